//! Scans of one part → numbers over the disk, copied by symmetry.

use bsdftree::Part;
use bsdftree::direction::Side;
use rayon::prelude::*;

use crate::gridded::{Gridded, distinct};
use crate::in_plane;
use crate::lambert::{self, Ray};
use crate::measurement::{Measurement, Scan, Symmetry};
use crate::progress::{Progress, Stopped};

/// Directions closer than this are one \[rad\].
const SAME: f32 = 2e-3;

/// Fewest and most pixels of an edge; most of many scans.
const PIXELS: [usize; 3] = [128, 512, 256];
/// More scans than this are many.
const MANY: usize = 16;

/// The points of one scan on one side, incident and exitant on the upper hemisphere.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    pub part: Part,
    pub incident: Ray,
    pub group: usize,
    pub exitant: Vec<Ray>,
    /// One list per channel, and with `noisy` one of standard errors of the main channel.
    pub values: Vec<Vec<f32>>,
    pub noisy: bool,
}

/// The scans of a part.
pub(crate) fn points_of(measurement: &Measurement, part: Part) -> Vec<Points> {
    let n = measurement.n_channels;
    let noisy = measurement.scans.iter().any(|scan| !scan.errors.is_empty());
    let mut all = Vec::new();
    for (group, scan) in measurement.scans.iter().enumerate() {
        if Side::of(scan.incident) != part.incident_side() {
            continue;
        }
        let here: Vec<usize> =
            (0..scan.exitant.len()).filter(|&k| Side::of(scan.exitant[k]) == part.exitant_side()).collect();
        if here.is_empty() {
            continue;
        }
        let mut points = points_on_side(n, scan, group, part, &here);
        if noisy {
            let error = |&k: &usize| scan.errors.get(k * n + n / 2).map_or(0.0, |&e| e as f32);
            points.values.push(here.iter().map(error).collect());
        }
        all.push(Points { noisy, ..points });
    }
    all
}

/// Some points of a scan, all on one side, with `n` channels and without errors.
pub(crate) fn points_on_side(n: usize, scan: &Scan, group: usize, part: Part, here: &[usize]) -> Points {
    let exitant = here.iter().map(|&k| lambert::upper(scan.exitant[k])).collect();
    let channel = |c: usize| here.iter().map(|&k| scan.values[k * n + c].max(0.0) as f32).collect();
    let values = (0..n).map(channel).collect();
    Points { part, incident: lambert::upper(scan.incident), group, exitant, values, noisy: false }
}

/// Copies that a symmetry makes. Scans whose incident direction is its own image get points instead; at [`Symmetry::Isotropic`] all are
/// turned into the half-plane y = 0, x ≤ 0.
pub(crate) fn symmetric(scans: Vec<Points>, symmetry: Symmetry) -> Vec<Points> {
    let scans = match symmetry {
        Symmetry::Isotropic => {
            let scans = merged(scans.into_iter().map(turned).collect());
            let whole =
                |scan: Points| if in_plane::is_in_plane(&scan) { in_plane::spread(scan) } else { scan };
            scans.into_iter().map(whole).collect()
        }
        _ => scans,
    };
    merged(mirrors(symmetry).iter().fold(scans, copied))
}

/// The mirrors of a symmetry, or its half turn; of an isotropic sample, that of the half-plane in which its scans are.
pub(crate) fn mirrors(symmetry: Symmetry) -> &'static [fn(Ray) -> Ray] {
    const X: fn(Ray) -> Ray = |[x, y, z]| [-x, y, z];
    const Y: fn(Ray) -> Ray = |[x, y, z]| [x, -y, z];
    const HALF_TURN: fn(Ray) -> Ray = |[x, y, z]| [-x, -y, z];
    match symmetry {
        Symmetry::Anisotropic => &[],
        Symmetry::HalfTurn => &[HALF_TURN],
        Symmetry::BilateralX | Symmetry::Isotropic => &[Y],
        Symmetry::BilateralY => &[X],
        Symmetry::Quadrilateral => &[Y, X],
    }
}

pub(crate) fn turned(scan: Points) -> Points {
    let [x, y, z] = scan.incident;
    let r = x.hypot(y);
    if r < 1e-6 {
        return scan;
    }
    let (c, s) = (-x / r, -y / r);
    let turn = |[x, y, z]: Ray| [c * x + s * y, c * y - s * x, z];
    Points { incident: [-r, 0.0, z], exitant: scan.exitant.into_iter().map(turn).collect(), ..scan }
}

fn copied(scans: Vec<Points>, image: impl Fn(Ray) -> Ray) -> Vec<Points> {
    let mut all = Vec::with_capacity(2 * scans.len());
    for mut scan in scans {
        let incident = image(scan.incident);
        let exitant: Vec<Ray> = scan.exitant.iter().map(|&o| image(o)).collect();
        if distance(incident, scan.incident) < SAME {
            scan.exitant.extend(exitant);
            scan.values.iter_mut().for_each(|v| v.extend_from_within(..));
            all.push(scan);
        } else {
            let copy = Points { incident, exitant, ..scan.clone() };
            all.extend([scan, copy]);
        }
    }
    all
}

/// Scans of one incident direction become one.
pub(crate) fn merged(scans: Vec<Points>) -> Vec<Points> {
    let mut all: Vec<Points> = Vec::new();
    for scan in scans {
        match all.iter_mut().find(|other| distance(other.incident, scan.incident) < SAME) {
            Some(other) => {
                other.exitant.extend(scan.exitant);
                other.values.iter_mut().zip(scan.values).for_each(|(a, b)| a.extend(b));
            }
            None => all.push(scan),
        }
    }
    all
}

fn distance(a: Ray, b: Ray) -> f32 {
    (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f32>().sqrt()
}

/// Lays all scans over disks of one resolution.
pub(crate) fn gridded(scans: Vec<Points>, progress: &Progress) -> Result<Vec<Gridded>, Stopped> {
    let made_distinct = |scan: Points| {
        let (exitant, values) = distinct(&scan.exitant, &scan.values, SAME / 2.0);
        progress.go_on().map(|()| Points { exitant, values, ..scan })
    };
    let scans = scans.into_par_iter().map(made_distinct).collect::<Result<Vec<Points>, _>>()?;
    let n = resolution(&scans);
    scans.into_par_iter().map(|scan| progress.go_on().map(|()| Gridded::new(scan, n))).collect()
}

/// Pixels so that the closest quarter of all points lie two pixels apart or less.
fn resolution(scans: &[Points]) -> usize {
    let mut gaps: Vec<f32> = scans.par_iter().flat_map_iter(nearest_gaps).collect();
    let quarter = gaps.len() / 4;
    let gap = gaps.select_nth_unstable_by(quarter, f32::total_cmp).1.max(1e-4);
    let wanted = (2.0 * 2.0 * crate::raster::EXTENT / gap) as usize;
    let most = if scans.len() > MANY { PIXELS[2] } else { PIXELS[1] };
    wanted.next_power_of_two().clamp(PIXELS[0], most)
}

/// Distance on the disk from each point to its nearest neighbour.
fn nearest_gaps(scan: &Points) -> Vec<f32> {
    let mut points: Vec<[f32; 2]> = scan.exitant.iter().map(|&o| lambert::point(o)).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let gap = |k: usize| {
        let mut best = 1f32;
        let away = |l: usize| ((points[l][0] - points[k][0]).powi(2), (points[l][1] - points[k][1]).powi(2));
        for l in k + 1..points.len() {
            let (dx, dy) = away(l);
            if dx > best {
                break;
            }
            best = best.min(dx + dy);
        }
        for l in (0..k).rev() {
            let (dx, dy) = away(l);
            if dx > best {
                break;
            }
            best = best.min(dx + dy);
        }
        best.sqrt()
    };
    (0..points.len()).map(gap).collect()
}
