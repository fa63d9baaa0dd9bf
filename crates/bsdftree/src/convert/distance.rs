//! How far one function is from another: ∫∫|f − g| / ∫∫f over incident and exitant projected solid angle.
//!
//! In: two functions of any kinds. Out: the relative L1 distance, by 2^16 points of a low-discrepancy sequence (M. Roberts' additive
//! recurrence of the generalised golden ratio), exitant directions sampled from f and g in turn, so that no peak of either is
//! missed and the integrand is at most twice the larger total. Deterministic; good to about 1 % of the result.

use crate::bsdf::Scattering;
use crate::direction::Side;
use crate::square::disk_from_square;

const N_POINTS: u32 = 1 << 16;

/// Point k of the sequence, in \[0, 1)⁴.
pub(super) fn even_point(k: u32) -> [f64; 4] {
    /// φ⁻¹ to φ⁻⁴ with φ⁵ = φ + 1.
    const STEPS: [f64; 4] =
        [0.856_674_883_854_502_9, 0.733_891_856_627_125_7, 0.628_706_721_037_808_8, 0.538_597_257_223_612_9];
    STEPS.map(|step| (0.5 + f64::from(k) * step).fract())
}

/// Relative L1 distance of `other` from `reference`; 0 between black functions, infinite from a black one.
///
/// ```
/// use bsdftree::{Rank, Scattering, Tree, convert::relative_l1};
/// let [a, b] = [0.2, 0.3].map(|v| Scattering::from(Tree::uniform(Rank::Four, v)));
/// assert!((relative_l1(&a, &b) - 0.5).abs() < 1e-6);
/// ```
pub fn relative_l1(reference: &Scattering, other: &Scattering) -> f64 {
    let (mut difference, mut light) = (0.0, 0.0);
    for k in 0..N_POINTS {
        let [x, y, which, u] = even_point(k);
        let incident = Side::Front.direction_from_disk(disk_from_square([x, y]));
        let functions = [reference, other];
        let lobes = functions.map(|function| function.lobe(incident, false));
        let totals = lobes.each_ref().map(crate::bsdf::Lobe::total);
        light += totals[0];
        let chances = match totals.map(|total| total > 0.0) {
            [true, true] => [0.5, 0.5],
            [true, false] => [1.0, 0.0],
            [false, true] => [0.0, 1.0],
            [false, false] => continue,
        };
        let Some((disk, _)) = lobes[usize::from(which >= chances[0])].sample(u, None) else { continue };
        let exitant = Side::Front.direction_from_disk(disk);
        let values = functions.map(|function| function.eval(incident, exitant, false));
        let density = |k: usize| if chances[k] > 0.0 { chances[k] * values[k] / totals[k] } else { 0.0 };
        let density = density(0) + density(1);
        if density > 0.0 {
            difference += (values[0] - values[1]).abs() / density;
        }
    }
    if difference == 0.0 { 0.0 } else { difference / light }
}
