//! What light of all wavelengths comes to, as weights of the wavelengths of a path.
//!
//! A table W(λ) with its own wavelengths λ_j and trapezoids Δ_j gives w_k = Σ_j W(λ_j) Δ_j φ_k(λ_j) / Σ_j W(λ_j) Δ_j, where Σ_k p(λ_k) φ_k is the
//! cubic through the four values p around: so products of spectra, which are smoother than sunlight and need no samples of it, may be
//! bent. Lines make sums 100 times less exact. Source: ASTM E308 and E2022 weigh in this way (Lagrange's interpolation). As there, a few
//! weights are a little below 0.

use std::sync::LazyLock;

use super::grid::{N, cubic, place};
use super::{VISIBLE_NM, cie, solar};

/// One weight for each wavelength; their sum is 1.
pub(crate) type Weights = [f32; N];

/// X, Y, Z in the light of illuminant E (equal energy), each 1 for white.
pub(crate) fn cie_xyz() -> &'static [Weights; 3] {
    static XYZ: LazyLock<[Weights; 3]> = LazyLock::new(|| {
        [0, 1, 2].map(|k| {
            let lines = cie::COLOR_MATCHING.iter().enumerate();
            integral(lines.map(|(j, bar)| (cie::FROM_NM + j as f64, bar[k])), VISIBLE_NM)
        })
    });
    &XYZ
}

/// Sunlight between two wavelengths \[nm\] within 300 to 2500.
pub(crate) fn solar_between(range_nm: [f64; 2]) -> Weights {
    integral(solar::IRRADIANCE.iter().enumerate().map(|(j, &w)| (solar::wavelength_nm(j), w)), range_nm)
}

/// Equal energy between two wavelengths \[nm\].
pub(crate) fn mean_between([from, to]: [f64; 2]) -> Weights {
    let steps = ((to - from) / 0.5).ceil().max(1.0);
    let step = (to - from) / steps;
    integral((0..=steps as usize).map(|j| (from + j as f64 * step, 1.0)), [from, to])
}

/// One wavelength \[nm\].
pub(crate) fn value_at(nm: f64) -> Weights {
    let (lower, t) = place(nm);
    let mut weights = [0.0; N];
    weights[lower] = (1.0 - t) as f32;
    weights[lower + 1] = t as f32;
    weights
}

/// How much light of each wavelength counts when lobes are chosen and faint paths are ended: Y and sunlight alike, and a little of all, so that
/// nothing is lost.
pub(crate) fn importance() -> &'static Weights {
    static IMPORTANCE: LazyLock<Weights> = LazyLock::new(|| {
        let (y, solar) = (&cie_xyz()[1], solar_between(super::RANGE_NM));
        let all: [f32; N] =
            std::array::from_fn(|k| 0.45 * y[k].max(0.0) + 0.45 * solar[k].max(0.0) + 0.1 / N as f32);
        let sum: f32 = all.iter().sum();
        all.map(|weight| weight / sum)
    });
    &IMPORTANCE
}

/// The weights of a table of wavelengths \[nm\], in order, and values, as far as it lies in a range.
fn integral(table: impl Iterator<Item = (f64, f64)>, [from, to]: [f64; 2]) -> Weights {
    let lines: Vec<(f64, f64)> = table.filter(|(nm, _)| (from..=to).contains(nm)).collect();
    let mut weights = [0.0f64; N];
    for (j, &(nm, value)) in lines.iter().enumerate() {
        let (before, after) = (lines[j.saturating_sub(1)].0, lines[(j + 1).min(lines.len() - 1)].0);
        let (first, shares) = cubic(nm);
        for (weight, share) in weights[first..].iter_mut().zip(shares) {
            *weight += value * 0.5 * (after - before) * share;
        }
    }
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| (weight / sum) as f32)
}
