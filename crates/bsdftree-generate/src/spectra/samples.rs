//! Spectra that are given by samples, as functions of the wavelength.
//!
//! Between samples they are linear. They go on for half a step beyond the first and the last sample, and are 0 after that, as in Radiance; but one that reaches to
//! the ends of what the eye sees well (400 and 700 nm) was hardly meant to end there, and goes on. Deviation: Radiance takes a
//! spectrum as steps around its samples, which says the same to second order, and lets all of them end.

use super::grid::{N, wavelengths_nm};

/// Spectra that reach at least so far go on with their last value \[nm\].
pub(crate) const REACH_NM: [f64; 2] = [400.0, 700.0];

/// Values at the wavelengths of a path, from two or more samples at rising wavelengths \[nm\]. Where samples are closer than the wavelengths, all of
/// them count ([`mean`]).
pub(crate) fn resampled(nm: &[f64], values: &[f64]) -> [f64; N] {
    let at = wavelengths_nm();
    std::array::from_fn(|k| {
        let step = (at[k] - at[k.max(1) - 1]).min(at[(k + 1).min(N - 1)] - at[k]);
        let (low, high) = (at[k] - 0.5 * step, at[k] + 0.5 * step);
        let inside = nm.partition_point(|&x| x <= high) - nm.partition_point(|&x| x < low);
        match inside > 2 && nm[0] <= low && high <= nm[nm.len() - 1] {
            true => mean(nm, values, [low, high]),
            false => value(nm, values, at[k]),
        }
    })
}

/// The wavelengths that samples stand for.
fn ends(nm: &[f64]) -> (f64, f64) {
    let n = nm.len();
    (nm[0] - 0.5 * (nm[1] - nm[0]), nm[n - 1] + 0.5 * (nm[n - 1] - nm[n - 2]))
}

fn value(nm: &[f64], values: &[f64], at: f64) -> f64 {
    let n = nm.len();
    let (low, high) = ends(nm);
    if (at < low && low > REACH_NM[0]) || (at > high && high < REACH_NM[1]) {
        return 0.0;
    }
    let lower = nm.partition_point(|&x| x <= at).clamp(1, n - 1) - 1;
    let t = ((at - nm[lower]) / (nm[lower + 1] - nm[lower])).clamp(0.0, 1.0);
    values[lower] * (1.0 - t) + values[lower + 1] * t
}

/// The mean between two wavelengths within the samples, weighted by 9/4 − 15x² with x from −½ to ½: of cubics that is the value in the middle, and
/// what swings cancels. Between the least and the most there is.
fn mean(nm: &[f64], values: &[f64], [from, to]: [f64; 2]) -> f64 {
    let between = (0..nm.len()).filter(|&k| from < nm[k] && nm[k] < to).map(|k| (nm[k], values[k]));
    let end = |x: f64| std::iter::once((x, value(nm, values, x)));
    let points: Vec<(f64, f64)> = end(from).chain(between).chain(end(to)).collect();
    let weighted = |x: f64, y: f64| y * (2.25 - 15.0 * ((x - from) / (to - from) - 0.5).powi(2));
    // Simpson's rule is exact for what is linear times a square.
    let sum: f64 = points
        .windows(2)
        .map(|pair| {
            let [(a, at_a), (b, at_b)] = [pair[0], pair[1]];
            let middle = weighted(0.5 * (a + b), 0.5 * (at_a + at_b));
            (b - a) / 6.0 * (weighted(a, at_a) + 4.0 * middle + weighted(b, at_b))
        })
        .sum();
    let all = points.iter().map(|point| point.1);
    let (least, most) = (all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max));
    (sum / (to - from)).clamp(least, most)
}
