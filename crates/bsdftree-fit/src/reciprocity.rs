//! Whether light goes back as it came: a test on swapped pairs of scans.
//!
//! Where scan a was measured towards the incident direction of scan b, and b towards that of a, both values are of one pair of directions. Of
//! isotropic samples that holds for each azimuth between the two. What they differ by is compared with what noise and the distance of
//! points explain.

use crate::forward::{turn, turned};
use crate::gridded::Gridded;
use crate::lambert::{self, Ray};
use crate::residual::relative_l1;

/// Reciprocity holds if swapped pairs differ by no more than this many times what is expected, and this much.
const TOLERATED: (f64, f64) = (2.0, 0.03);

/// Fewest pairs that say something.
const N_NEEDED: usize = 6;

/// Azimuths between two scans of an isotropic sample.
const N_AZIMUTHS: usize = 24;

/// Squared relative error of going linearly between points over which a value is not compared.
const MOST_DOUBT: f32 = 0.01;

/// What swapped pairs of scans say.
#[derive(Clone, Copy, Debug)]
pub struct Reciprocity {
    /// Whether they differ by no more than noise and the distance of points explain, or little more.
    pub holds: bool,
    /// How many pairs were compared.
    pub n_pairs: usize,
    /// Median of |ln(f(i,o)/f(o,i))|.
    pub difference: f64,
    /// Median that is expected of noise and the distance of points.
    pub expected: f64,
}

impl Reciprocity {
    /// Compares scans with those of the light that goes back, which may be the same; `None` if there are too few pairs.
    pub(crate) fn of(scans: &[Gridded], back: &[Gridded], line: bool) -> Option<Reciprocity> {
        let same = std::ptr::eq(scans, back);
        let noise = within(scans);
        let turns = if line { N_AZIMUTHS } else { 1 };
        let mut found: Vec<(f64, f64)> = Vec::new();
        for (a, one) in scans.iter().enumerate() {
            for (b, other) in back.iter().enumerate() {
                // One plane of incidence apart a scan is its own swapped pair.
                if same && (b <= a || one.group == other.group) {
                    continue;
                }
                found.extend((0..turns).filter_map(|k| {
                    let angle = std::f32::consts::TAU * k as f32 / turns as f32;
                    compared(one, other, noise, if line { Some(angle) } else { None })
                }));
            }
        }
        if found.len() < N_NEEDED {
            return None;
        }
        let n_pairs = found.len();
        let difference = median(found.iter().map(|pair| pair.0));
        let expected = median(found.iter().map(|pair| pair.1));
        let holds = difference <= (TOLERATED.0 * expected).max(TOLERATED.1);
        Some(Reciprocity { holds, n_pairs, difference, expected })
    }
}

/// |ln| of the ratio of a pair and its swapped pair, and what is expected. `angle` turns the second direction of an isotropic sample.
fn compared(one: &Gridded, other: &Gridded, noise: f64, angle: Option<f32>) -> Option<(f64, f64)> {
    let (i, mut o) = (one.incident, other.incident);
    let mut from = [1.0, 0.0];
    if let Some(angle) = angle {
        let (s, c) = angle.sin_cos();
        o = turned(o, [c, s]);
        from = turn(o);
    }
    let (a, error_a) = looked_up(one, o)?;
    let (b, error_b) = looked_up(other, turned(i, from))?;
    Some(((a / b).ln().abs(), (error_a + error_b + 2.0 * noise * noise).sqrt()))
}

/// By how much points differ from their neighbours: median of some scans, relative.
fn within(scans: &[Gridded]) -> f64 {
    const N: usize = 8;
    median(scans.iter().step_by(scans.len().div_ceil(N)).map(|scan| relative_l1(&scan.held_out())))
}

/// Value and its squared relative error of points that are far from each other, where that is small.
fn looked_up(scan: &Gridded, o: Ray) -> Option<(f64, f64)> {
    /// What is darker than this part of the mean is noise.
    const DARK: f64 = 0.05;
    let point = lambert::point(o);
    let channel = scan.main();
    let value = f64::from(scan.rasters[channel].at(point));
    let doubt = scan.doubt.at(point);
    let mean = scan.totals[channel] / std::f64::consts::PI;
    if scan.covered.at(point) < 0.99 || doubt > MOST_DOUBT || value <= DARK * mean {
        return None;
    }
    Some((value, f64::from(doubt)))
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
