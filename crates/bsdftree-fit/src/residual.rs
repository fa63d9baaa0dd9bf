//! Predictions beside what was measured.

/// A value, and how much the scans it is of differ.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Blended {
    /// \[1/sr\], ≥ 0.
    pub value: f32,
    /// Root of the weighted mean square of the differences of logarithms.
    pub spread: f32,
}

/// A prediction and what was measured there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Residual {
    pub predicted: Blended,
    pub measured: f32,
    /// Projected solid angle \[sr\].
    pub weight: f32,
}

/// Σ w|f̂ − f| / Σ w f.
pub(crate) fn relative_l1(residuals: &[Residual]) -> f64 {
    absolute_l1(residuals) / sum(residuals, |r| r.measured).max(1e-12)
}

/// Σ w|f̂ − f|.
pub(crate) fn absolute_l1(residuals: &[Residual]) -> f64 {
    sum(residuals, |r| (r.predicted.value - r.measured).abs())
}

/// Σ w f.
pub(crate) fn measured(residuals: &[Residual]) -> f64 {
    sum(residuals, |r| r.measured)
}

fn sum(residuals: &[Residual], f: impl Fn(&Residual) -> f32) -> f64 {
    residuals.iter().map(|r| f64::from(f(r) * r.weight)).sum()
}
