//! Which recipe suits a measurement: each scan is predicted from the others and compared with what was measured.
//!
//! The score of a recipe is Σ w|f̂ − f| over Σ w f of all left-out scans, w the projected solid angle of a point, where a scan counts with no more
//! than its own light, however far off it is. Copies by symmetry are left out together. Scans at the edge of what was measured are not left out:
//! predicting them would be extrapolation.

use rayon::prelude::*;

use crate::blend::{Layers, Recipe};
use crate::frame::Frame;
use crate::gridded::Gridded;
use crate::incidence::{Blend, Incidence, Line, Plane, lambert_radius};
use crate::lambert::{self, Ray};
use crate::progress::{Progress, Stopped};
use crate::residual::{Residual, absolute_l1, measured, relative_l1};
use crate::swapped::Swap;

/// Points of a scan that are compared.
const N_COMPARED: usize = 1500;

/// Relative error for each unit of distance outside of scans where no scan tells: 0.1 is 8° near the normal.
const UNKNOWN: f64 = 3.0;

/// Scans left out at most.
const N_LEFT_OUT: usize = 48;

/// What a recipe is worth.
#[derive(Clone, Copy, Debug)]
pub struct Score {
    /// The way to interpolate.
    pub recipe: Recipe,
    /// Relative L1 error of left-out scans together.
    pub l1: f64,
    /// That of the worst scan that is not dark.
    pub worst: f64,
}

/// The incident directions of scans, without one group.
pub(crate) fn incidence(scans: &[Gridded], line: bool, blend: Blend, without: Option<usize>) -> Incidence {
    let kept: Vec<usize> = (0..scans.len()).filter(|&k| Some(scans[k].group) != without).collect();
    if line {
        let radii: Vec<f64> = kept.iter().map(|&k| lambert_radius(scans[k].incident)).collect();
        Incidence::Line(Line::new(&radii, &kept, blend))
    } else {
        let points: Vec<[f64; 2]> =
            kept.iter().map(|&k| lambert::point(scans[k].incident).map(f64::from)).collect();
        Incidence::Plane(Plane::new(&points, &kept, blend))
    }
}

/// The first scan of each group.
pub(crate) fn one_of_each_group(scans: &[Gridded]) -> impl Iterator<Item = usize> + '_ {
    (0..scans.len()).filter(|&k| scans[..k].iter().all(|before| before.group != scans[k].group))
}

/// Scans that lie inside the others, evenly chosen if there are many.
pub(crate) fn left_out(scans: &[Gridded], line: bool) -> Vec<usize> {
    let is_inside = |&k: &usize| {
        let group = scans[k].group;
        let others = scans.iter().any(|scan| scan.group != group);
        others && incidence(scans, line, Blend::Linear, Some(group)).weights(scans[k].incident).1 < 1e-6
    };
    let mut inside: Vec<usize> = one_of_each_group(scans).filter(is_inside).collect();
    if inside.len() > N_LEFT_OUT {
        let step = inside.len() as f64 / N_LEFT_OUT as f64;
        inside = (0..N_LEFT_OUT).map(|k| inside[(k as f64 * step) as usize]).collect();
    }
    inside
}

/// Predictions of one scan from the others, and from swapped pairs if `swap` says how.
pub(crate) fn residuals(
    scans: &[Gridded],
    layers: &Layers,
    line: bool,
    swap: Option<&Swap<'_>>,
    k: usize,
) -> Vec<Residual> {
    let scan = &scans[k];
    let incidence = incidence(scans, line, layers.recipe.blend, Some(scan.group));
    let (weights, _) = incidence.weights(scan.incident);
    let slice = layers.slice(scan.incident, &weights, Some(scan.group));
    let channel = scan.main();
    let values = &scan.values[channel];
    let step = scan.exitant.len().div_ceil(N_COMPARED).max(1);
    let predicted = |o: Ray| match swap {
        Some(swap) => swap.predicted(&slice, scan.incident, o, &incidence),
        None => slice.blended(o),
    };
    let mut found: Vec<Residual> = (0..scan.exitant.len())
        .step_by(step)
        .map(|j| Residual {
            predicted: predicted(scan.exitant[j]),
            measured: values[j],
            weight: scan.weights[j],
        })
        .collect();
    // Totals are known from the neighbours, so a prediction is brought to the total that they foresee.
    let total = slice.total;
    let mine: f64 = found.iter().map(|r| f64::from(r.predicted.value * r.weight)).sum();
    let theirs: f64 = found.iter().map(|r| f64::from(r.measured * r.weight)).sum();
    let scale = (total / scan.totals[channel] * theirs / mine.max(1e-12)).clamp(0.5, 2.0) as f32;
    found.iter_mut().for_each(|r| r.predicted.value *= scale);
    found
}

/// Relative error of scans at the edge predicted from the others, for each unit of distance to those on the disk: median.
pub(crate) fn beyond(scans: &[Gridded], layers: &Layers, line: bool) -> f64 {
    /// What is nearer lies inside.
    const NEAR: f64 = 0.02;
    let error = |k: usize| {
        let incidence = incidence(scans, line, Blend::Linear, Some(scans[k].group));
        let (_, distance) = incidence.weights(scans[k].incident);
        (distance > NEAR).then(|| relative_l1(&residuals(scans, layers, line, None, k)) / distance)
    };
    let several = |k: &usize| scans.iter().any(|scan| scan.group != scans[*k].group);
    let mut errors: Vec<f64> = one_of_each_group(scans).filter(several).filter_map(error).collect();
    errors.sort_by(f64::total_cmp);
    errors.get(errors.len() / 2).copied().unwrap_or(UNKNOWN)
}

/// What is predicted wrongly of scans that are left out one by one.
pub(crate) struct Missed {
    /// Of the light of all together.
    pub together: f64,
    /// Of the worst scan that is not dark.
    pub worst: f64,
    /// Mean over scans, whatever light they have.
    pub mean: f64,
}

/// Leaves scans out and predicts them.
pub(crate) fn missed(
    scans: &[Gridded],
    layers: &Layers,
    line: bool,
    swap: Option<&Swap<'_>>,
    left_out: &[usize],
    progress: &Progress,
) -> Result<Missed, Stopped> {
    /// Scans with less of the mean flux are dark.
    const DARK: f64 = 0.2;
    let one = |&k: &usize| {
        progress.go_on()?;
        let residuals = residuals(scans, layers, line, swap, k);
        Ok((absolute_l1(&residuals), measured(&residuals)))
    };
    let sums = left_out.par_iter().map(one).collect::<Result<Vec<(f64, f64)>, _>>()?;
    let flux = sums.iter().map(|s| s.1).sum::<f64>();
    let n = sums.len() as f64;
    let dark = DARK * flux / n;
    let bright = sums.iter().filter(|s| s.1 >= dark);
    Ok(Missed {
        together: sums.iter().map(|&(error, flux)| error.min(flux)).sum::<f64>() / flux,
        worst: bright.map(|&(error, flux)| error / flux).fold(f64::NAN, f64::max),
        mean: sums.iter().map(|&(error, flux)| (error / flux.max(dark)).min(1.0)).sum::<f64>() / n,
    })
}

/// The recipes that are tried.
pub(crate) fn recipes() -> Vec<Recipe> {
    let mut all = Vec::new();
    for frame in Frame::ALL {
        for blend in [Blend::Spline, Blend::Linear] {
            for split in [false, true] {
                let splits = match frame {
                    Frame::Fixed => !split,
                    Frame::Lobes => split,
                    _ => true,
                };
                if splits {
                    all.push(Recipe { frame, blend, split, reciprocal: false });
                }
            }
        }
    }
    all
}

/// Scores of all recipes, best first; a step each. Without scans to leave out scores are NaN and the order is that of [`recipes`].
pub(crate) fn scores(
    scans: &[Gridded],
    line: bool,
    tried: &[Recipe],
    progress: &Progress,
) -> Result<Vec<Score>, Stopped> {
    let left_out = left_out(scans, line);
    let channel = scans[0].main();
    // Recipes that share logarithms come one after the other.
    let mut ordered = tried.to_vec();
    ordered.sort_by_key(|recipe| recipe.logs());
    let mut layers = Layers::new(scans, channel, line, ordered[0], progress)?;
    let mut score = |recipe: Recipe| {
        layers = layers.for_recipe(scans, channel, recipe, progress)?;
        let score = match layers.exists() {
            true => {
                let missed = missed(scans, &layers, line, None, &left_out, progress)?;
                Some(Score { recipe, l1: missed.together, worst: missed.worst })
            }
            false => None,
        };
        progress.count(1).map(|()| score)
    };
    let scores = ordered.into_iter().filter_map(|recipe| score(recipe).transpose());
    let mut scores = scores.collect::<Result<Vec<Score>, _>>()?;
    scores.sort_by(|a, b| a.l1.total_cmp(&b.l1));
    Ok(scores)
}
