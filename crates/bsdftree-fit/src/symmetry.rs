//! Which symmetry a measurement has.
//!
//! A symmetry is copies of scans. If it holds, copies help to predict scans that are left out; if it does not, they spoil the prediction. So
//! the highest symmetry is taken whose cross-validated error is not above that of the scans alone. Where incident directions lie on one
//! azimuth or in one quadrant, nothing can be left out that copies would predict: the symmetry that makes the measurement whole is assumed,
//! as Radiance's pabopto2bsdf assumes it, unless scans contradict it plainly.

use crate::blend::{Layers, Recipe};
use crate::choose;
use crate::frame::Frame;
use crate::gridded::Gridded;
use crate::images::{from_image, from_image_in, from_own_image};
use crate::incidence::Blend;
use crate::lambert::Ray;
use crate::measurement::Symmetry;
use crate::prepare::{self, Points};
use crate::progress::{Progress, Stopped};
use crate::residual::relative_l1;

/// A higher symmetry is taken if errors rise by no more than this factor and this much: those that samples have raise them by up to
/// 1.06, those that they have not by 1.5 and more, or images contradict them.
const TOLERATED: (f64, f64) = (1.1, 0.002);

/// A scan at normal incidence is the same turned if it differs by no more than this many times what neighbouring points do, or this much.
const SAME_IMAGE: (f64, f64) = (2.0, 0.02);

/// Median relative difference, above what neighbouring points differ by, with which scans contradict a symmetry.
const CONTRADICTION: f64 = 0.1;

/// With a smaller error lobes are not followed one by one to find the symmetry.
const WELL: f64 = 0.2;

/// Fewest scans that cross-validation needs.
const N_NEEDED: usize = 4;

/// Frames that are tried with each symmetry, whatever comes out.
const MOVED: [Frame; 4] = [Frame::Fixed, Frame::Shift, Frame::Rotation, Frame::Half];

/// Steps that finding it takes for each part: these frames and lobes, with each symmetry.
pub(crate) const N_STEPS: usize = Symmetry::ALL.len() * (MOVED.len() + 1);

/// The symmetry of a sample, and why.
#[derive(Clone, Debug)]
pub struct SymmetryFound {
    /// That is used.
    pub symmetry: Symmetry,
    /// A sentence.
    pub why: String,
    /// Cross-validated relative L1 error with each symmetry that was tried.
    pub errors: Vec<(Symmetry, f64)>,
}

/// Finds it out from the scans of each part.
pub(crate) fn found(parts: &[Vec<Points>], progress: &Progress) -> Result<SymmetryFound, Stopped> {
    let alone = parts.iter().map(|scans| prepare::gridded(prepare::merged(scans.clone()), progress));
    let alone: Vec<Vec<Gridded>> = alone.collect::<Result<_, _>>()?;
    let assumed = || {
        progress.count(parts.len() * N_STEPS)?;
        Ok(assumed(parts, &alone))
    };
    if parts.iter().any(|scans| !is_spread(scans)) {
        return assumed();
    }
    let judged: Vec<Vec<usize>> = alone
        .iter()
        .map(|scans| choose::left_out(scans, false).into_iter().map(|k| scans[k].group).collect())
        .collect();
    if judged.iter().any(|groups: &Vec<usize>| groups.len() < N_NEEDED) {
        return assumed();
    }
    let error = |symmetry: Symmetry| {
        let each = parts.iter().zip(&judged).map(|(scans, groups)| {
            let scans = prepare::gridded(prepare::symmetric(scans.clone(), symmetry), progress)?;
            error_of(&scans, symmetry == Symmetry::Isotropic, groups, progress)
        });
        Ok((symmetry, each.sum::<Result<f64, _>>()? / parts.len() as f64))
    };
    let errors = Symmetry::ALL.into_iter().map(error).collect::<Result<Vec<(Symmetry, f64)>, _>>()?;
    let limit = errors[0].1 * TOLERATED.0 + TOLERATED.1;
    let turns = alone.iter().flatten().all(looks_the_same_turned);
    let holds = |&&(symmetry, error): &&(Symmetry, f64)| {
        let is_turned = symmetry != Symmetry::Isotropic || turns;
        error <= limit && is_turned && !is_contradicted(&alone, symmetry)
    };
    let (symmetry, error) = *errors.iter().rev().find(holds).unwrap_or(&errors[0]);
    let why = format!(
        "with its copies scans are predicted to {:.1} %, without to {:.1} %",
        100.0 * error,
        100.0 * errors[0].1
    );
    Ok(SymmetryFound { symmetry, why, errors })
}

/// The least error of a few recipes on the scans of some groups.
fn error_of(scans: &[Gridded], line: bool, groups: &[usize], progress: &Progress) -> Result<f64, Stopped> {
    let judged: Vec<usize> =
        choose::one_of_each_group(scans).filter(|&k| groups.contains(&scans[k].group)).collect();
    let recipe = |frame| Recipe { frame, blend: Blend::Spline, split: false, reciprocal: false };
    let mut layers = Layers::new(scans, scans[0].main(), line, recipe(Frame::Fixed), progress)?;
    let mut error = |frame: Frame| {
        let split = frame == Frame::Lobes;
        layers = layers.for_recipe(scans, scans[0].main(), Recipe { split, ..recipe(frame) }, progress)?;
        let error = match layers.exists() {
            true => choose::missed(scans, &layers, line, None, &judged, progress)?.mean,
            false => f64::MAX,
        };
        progress.count(1).map(|()| error)
    };
    let mut least = f64::MAX;
    for frame in MOVED {
        least = least.min(error(frame)?);
    }
    if least >= WELL {
        return Ok(least.min(error(Frame::Lobes)?));
    }
    progress.count(1).map(|()| least)
}

/// Whether incident directions reach over more than a half-plane: else nothing is known of the other half.
fn is_spread(scans: &[Points]) -> bool {
    let mut azimuths: Vec<f64> = scans
        .iter()
        .filter(|s| s.incident[2] < 0.999)
        .map(|s| f64::from(s.incident[1]).atan2(f64::from(s.incident[0])))
        .collect();
    azimuths.sort_by(f64::total_cmp);
    let Some((&first, &last)) = azimuths.first().zip(azimuths.last()) else { return false };
    let widest =
        azimuths.windows(2).map(|w| w[1] - w[0]).fold(std::f64::consts::TAU - (last - first), f64::max);
    widest < 0.95 * std::f64::consts::PI
}

/// The symmetry that makes incident directions cover all azimuths: nothing tests it but scans that have an image among the others.
fn assumed(parts: &[Vec<Points>], alone: &[Vec<Gridded>]) -> SymmetryFound {
    let (mut x, mut y) = ([false; 2], [false; 2]);
    let mut line = true;
    let mut first: Option<Ray> = None;
    for scan in parts.iter().flatten().filter(|s| s.incident[2] < 0.999) {
        let i = scan.incident;
        for (axis, seen) in [(i[0], &mut x), (i[1], &mut y)] {
            if axis.abs() > 0.02 {
                seen[usize::from(axis > 0.0)] = true;
            }
        }
        let a = *first.get_or_insert(i);
        line &= (a[0] * i[1] - a[1] * i[0]).abs() < 0.02;
    }
    let turns = alone.iter().flatten().all(looks_the_same_turned);
    let difference = median(alone.iter().flatten().filter_map(from_own_image).collect());
    let (symmetry, why) = if line && turns {
        let difference = difference.map_or(String::new(), |difference| {
            format!(", and scans differ from their mirror images by {:.1} %", 100.0 * difference)
        });
        (
            Symmetry::Isotropic,
            format!("assumed, not tested: incident directions lie on one azimuth{difference}"),
        )
    } else if line {
        let why = "incident directions lie on one azimuth, but the scan at normal incidence changes with turns: \
                   nothing is known of other azimuths";
        (Symmetry::Anisotropic, why.to_owned())
    } else {
        let (mut symmetry, where_) = match (x == [true; 2], y == [true; 2]) {
            (false, false) => (Symmetry::Quadrilateral, "incident directions lie in one quadrant"),
            (true, false) => (Symmetry::BilateralX, "incident directions lie on one side of the plane y = 0"),
            (false, true) => (Symmetry::BilateralY, "incident directions lie on one side of the plane x = 0"),
            (true, true) => (Symmetry::Anisotropic, "too few incident directions to find any"),
        };
        let differences = from_images(alone, symmetry);
        let why = if symmetry == Symmetry::Anisotropic {
            where_.to_owned()
        } else if differences.iter().any(|(difference, limit)| difference > limit) {
            let name = symmetry.name();
            symmetry = Symmetry::Anisotropic;
            format!("{where_}, but scans are not the images of each other that {name} asks for")
        } else {
            let largest = differences.iter().map(|(difference, _)| *difference).reduce(f64::max);
            let told = largest.map_or("no scan has an image to be compared with".to_owned(), |largest| {
                format!("scans differ from such images as there are by {:.1} %", 100.0 * largest)
            });
            format!("assumed, not tested: {where_}, and {told}")
        };
        (symmetry, why)
    };
    SymmetryFound { symmetry, why, errors: Vec::new() }
}

/// Whether scans whose incident directions are images of each other differ plainly from what a symmetry asks for.
fn is_contradicted(alone: &[Vec<Gridded>], symmetry: Symmetry) -> bool {
    from_images(alone, symmetry).iter().any(|(difference, limit)| difference > limit)
}

/// For each part and image of a symmetry, if scans have such images: by how much the median one differs, and how much is plain. The turns
/// of an isotropic sample are not looked at.
fn from_images(alone: &[Vec<Gridded>], symmetry: Symmetry) -> Vec<(f64, f64)> {
    /// Farthest that an incident direction may be from the image of another to be compared.
    const NEAR: f32 = 0.02;
    if symmetry == Symmetry::Isotropic {
        return Vec::new();
    }
    let each = alone.iter().flat_map(|scans| {
        let limits = scans.iter().map(|scan| SAME_IMAGE.0 * relative_l1(&scan.held_out()));
        let limit = median(limits.collect()).unwrap_or(0.0) + CONTRADICTION;
        prepare::mirrors(symmetry).iter().filter_map(move |image| {
            let partner = |scan: &Gridded| {
                let there = image(scan.incident);
                let apart =
                    |other: &Gridded| (0..3).map(|d| (other.incident[d] - there[d]).abs()).sum::<f32>();
                let nearest = scans.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
                if apart(nearest) < NEAR { from_image_in(scan, nearest, image) } else { None }
            };
            median(scans.iter().filter_map(partner).collect()).map(|difference| (difference, limit))
        })
    });
    each.collect()
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Whether a scan at normal incidence does not change with turns.
fn looks_the_same_turned(scan: &Gridded) -> bool {
    if scan.incident[2] < 0.999 {
        return true;
    }
    let limit = (SAME_IMAGE.0 * relative_l1(&scan.held_out())).max(SAME_IMAGE.1);
    [0.5f32, 0.9, 1.570_796_4].into_iter().all(|angle| {
        let (s, c) = angle.sin_cos();
        from_image(scan, move |[u, v, w]: Ray| [c * u - s * v, s * u + c * v, w])
            .is_none_or(|difference| difference <= limit)
    })
}
