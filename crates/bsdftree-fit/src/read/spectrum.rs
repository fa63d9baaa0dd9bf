//! X, Y, Z of values at some wavelengths.
//!
//! In: wavelengths \[nm\]. Out: weights that make X, Y and Z in equal-energy light of values there, by the trapezoidal rule.
//!
//! Source: C. Wyman, P. Sloan, P. Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013.

/// X, Y and Z of one unit at each wavelength \[nm\], such that a flat spectrum has its own value in all three.
pub(super) fn weights(wavelengths: &[f32]) -> Vec<[f64; 3]> {
    let n = wavelengths.len();
    let nm = |k: usize| f64::from(wavelengths[k.min(n - 1)]);
    let weight = |k: usize| {
        let width = if n > 1 { 0.5 * (nm(k + 1) - nm(k.saturating_sub(1))).abs() } else { 1.0 };
        color_matching(nm(k)).map(|value| value * width)
    };
    let weights: Vec<[f64; 3]> = (0..n).map(weight).collect();
    let sums = weights.iter().fold([1e-300; 3], |sum, w| [0, 1, 2].map(|c| sum[c] + w[c]));
    weights.into_iter().map(|w| [0, 1, 2].map(|c| w[c] / sums[c])).collect()
}

/// The standard observer (2°, 1931), approximately.
fn color_matching(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, middle: f64, left: f64, right: f64| {
        let t = (nm - middle) * if nm < middle { left } else { right };
        height * (-0.5 * t * t).exp()
    };
    [
        lobe(0.362, 442.0, 0.0624, 0.0374)
            + lobe(1.056, 599.8, 0.0264, 0.0323)
            + lobe(-0.065, 501.1, 0.0490, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn green_light_is_mostly_y() {
        let wavelengths: Vec<f32> = (38..=78).map(|k| 10.0 * k as f32).collect();
        let weights = weights(&wavelengths);
        for c in 0..3 {
            assert!((weights.iter().map(|w| w[c]).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        // The standard observer has ȳ = 0.9950 and x̄ = 0.4334 at 550 nm, and both sum up to 10.69 in steps of 10 nm.
        let at_550 = weights[17];
        assert!((at_550[1] - 0.0931).abs() < 0.003 && (at_550[0] - 0.0406).abs() < 0.003, "{at_550:?}");
    }
}
