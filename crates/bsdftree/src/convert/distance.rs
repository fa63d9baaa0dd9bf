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
    let mut l1 = L1::default();
    l1.add(reference, other, N_POINTS);
    l1.relative()
}

/// [`relative_l1`] in steps, for who must not wait: what has been summed so far.
///
/// ```
/// use bsdftree::{Rank, Scattering, Tree, convert::{L1, relative_l1}};
/// let [a, b] = [0.2, 0.3].map(|v| Scattering::from(Tree::uniform(Rank::Four, v)));
/// let mut l1 = L1::default();
/// while l1.done() < 1.0 {
///     l1.add(&a, &b, 1000);
/// }
/// assert_eq!(l1.relative(), relative_l1(&a, &b));
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct L1 {
    n_points: u32,
    difference: f64,
    light: f64,
}

impl L1 {
    /// Adds as many points as are left, `n_points` at most. The functions must be the same each time.
    pub fn add(&mut self, reference: &Scattering, other: &Scattering, n_points: u32) {
        let end = N_POINTS.min(self.n_points.saturating_add(n_points));
        for k in self.n_points..end {
            self.add_point(even_point(k), [reference, other]);
        }
        self.n_points = end;
    }

    /// The part of all points that has been added, 0 to 1.
    pub fn done(&self) -> f64 {
        f64::from(self.n_points) / f64::from(N_POINTS)
    }

    /// The distance, by the points that have been added.
    pub fn relative(&self) -> f64 {
        if self.difference == 0.0 { 0.0 } else { self.difference / self.light }
    }

    fn add_point(&mut self, [x, y, which, u]: [f64; 4], functions: [&Scattering; 2]) {
        let incident = Side::Front.direction_from_disk(disk_from_square([x, y]));
        let lobes = functions.map(|function| function.lobe(incident, false));
        let totals = lobes.each_ref().map(crate::bsdf::Lobe::total);
        self.light += totals[0];
        let chances = match totals.map(|total| total > 0.0) {
            [true, true] => [0.5, 0.5],
            [true, false] => [1.0, 0.0],
            [false, true] => [0.0, 1.0],
            [false, false] => return,
        };
        let Some((disk, _)) = lobes[usize::from(which >= chances[0])].sample(u, None) else { return };
        let exitant = Side::Front.direction_from_disk(disk);
        let values = functions.map(|function| function.eval(incident, exitant, false));
        let density = |k: usize| if chances[k] > 0.0 { chances[k] * values[k] / totals[k] } else { 0.0 };
        let density = density(0) + density(1);
        if density > 0.0 {
            self.difference += (values[0] - values[1]).abs() / density;
        }
    }
}
