//! Pairs of directions drawn from a function by flux, and how far other values at them are.
//!
//! Points are those of the R₃ sequence (M. Roberts), two numbers for the incident square and one to sample with: deterministic, and
//! good to about 1 % of a mean.

use crate::bsdf::{Part, Scattering};
use crate::direction::Direction;
use crate::square::disk_from_square;

/// Pairs that are drawn.
const N: usize = 4096;

/// A pair of directions.
pub(super) struct Pair {
    pub incident: Direction,
    pub exitant: Direction,
    /// The function there \[1/sr\], over 0.
    pub value: f64,
    /// The light that the pair stands for.
    pub flux: f64,
}

/// Pairs from a function in proportion to its flux; none where it is black.
pub(super) fn draw(function: &Scattering, part: Part) -> Vec<Pair> {
    const STEP: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_938_2];
    let pair = |k: usize| {
        let [s, t, u] = STEP.map(|step| (0.5 + step * k as f64).fract());
        let incident = part.incident_side().direction_from_disk(disk_from_square([s, t]));
        let lobe = function.lobe(incident, false);
        let (disk, value) = lobe.sample(u, None)?;
        let exitant = part.exitant_side().direction_from_disk(disk);
        Some(Pair { incident, exitant, value, flux: lobe.total() })
    };
    // Not from 0, which is the normal: a border between cells.
    (1..=N).filter_map(pair).collect()
}

/// |a − b|/(a + b): 0 of equals, 1 if one is black.
pub(super) fn difference(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / (a + b) }
}

/// The flux-weighted mean of something over pairs; 0 of none.
pub(super) fn mean(pairs: &[Pair], of: impl Fn(&Pair) -> f64) -> f64 {
    let flux: f64 = pairs.iter().map(|pair| pair.flux).sum();
    let sum: f64 = pairs.iter().map(|pair| pair.flux * of(pair)).sum();
    if flux > 0.0 { sum / flux } else { 0.0 }
}

/// The flux-weighted median of values with their weights; `None` of no weight.
pub(super) fn weighted_median(mut values: Vec<(f64, f64)>) -> Option<f64> {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * values.iter().map(|v| v.1).sum::<f64>();
    let mut sum = 0.0;
    values.into_iter().find_map(|(value, weight)| {
        sum += weight;
        (sum > half && half > 0.0).then_some(value)
    })
}
