//! Colours: chromaticities, however they were given.
//!
//! In: CIE 1931 (x, y), a spectrum, a temperature or a mixture. Out: a [`Color`], and red, green and blue of it at a
//! luminance. MGF's colours have no brightness of their own: what uses them gives it. Source: MGF entities `c`, `cxy`, `cspec`, `cct`,
//! `cmix`; Radiance's primaries. What is outside of the triangle of the primaries moves towards grey of the same luminance, as in
//! Radiance. Deviation from mgf2rad: 0.3333 and the like, as
//! rad2mgf writes a third, are grey exactly.

use bsdftree::color::rgb_from_xyz;
use glam::DVec3;

use super::observer;

/// A chromaticity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Color {
    x: f64,
    y: f64,
}

/// A third in four digits or more, as rad2mgf and others write it.
const WRITTEN_THIRDS: [f64; 7] =
    [0.3333, 0.33333, 0.333333, 0.3333333, 0.33333333, 0.333333333, 0.3333333333];

impl Default for Color {
    fn default() -> Self {
        Color::NEUTRAL
    }
}

impl Color {
    /// Of an equal-energy spectrum.
    pub(super) const NEUTRAL: Color = Color { x: 1.0 / 3.0, y: 1.0 / 3.0 };

    /// From CIE 1931 chromaticities; `None` unless x ≥ 0, y > 0 and x + y ≤ 1.
    pub(super) fn of_xy(x: f64, y: f64) -> Option<Color> {
        let is_third = |c: f64| (c - 1.0 / 3.0).abs() < 1e-12 || WRITTEN_THIRDS.contains(&c);
        let is_neutral = is_third(x) && is_third(y);
        if is_neutral {
            return Some(Color::NEUTRAL);
        }
        // Sums such as 0.2 + 0.8 may round up.
        (x >= 0.0 && y > 0.0 && x + y <= 1.0 + 1e-12).then_some(Color { x, y })
    }

    fn of_xyz([x, y, z]: [f64; 3]) -> Option<Color> {
        let sum = x + y + z;
        Color::of_xy(x / sum, y / sum).filter(|_| y > 0.0 && sum.is_finite())
    }

    /// Of a spectrum given by values at equal steps from the first to the last wavelength \[nm\], 0 outside; `None` if
    /// nothing of it is seen.
    pub(super) fn of_spectrum([first, last]: [f64; 2], values: &[f64]) -> Option<Color> {
        let steps = values.len().checked_sub(1).filter(|&n| n > 0)?;
        let largest = values.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let value = |nm: f64| {
            let at = (nm - first) / (last - first) * steps as f64;
            if !(0.0..=steps as f64).contains(&at) {
                return 0.0;
            }
            let (k, t) = ((at as usize).min(steps - 1), at.fract());
            let t = if at as usize == steps { 1.0 } else { t };
            (values[k] * (1.0 - t) + values[k + 1] * t) / largest
        };
        let xyz = observer::xyz(value);
        // Of the brightest spectrum that has these values' largest.
        const LEAST_SEEN: f64 = 1e-6;
        Color::of_xyz(xyz).filter(|_| xyz[1] > LEAST_SEEN)
    }

    /// Of a black body \[K\].
    pub(super) fn of_black_body(kelvin: f64) -> Option<Color> {
        // Planck's second constant [nm K].
        const C2: f64 = 1.438_776_877e7;
        // In proportion to its value at 560 nm where that is hot, so that nothing overflows.
        let planck =
            |nm: f64| (560.0 / nm).powi(5) * (C2 / (560.0 * kelvin)).exp_m1() / (C2 / (nm * kelvin)).exp_m1();
        Color::of_xyz(observer::xyz(planck))
    }

    /// Of light of two colours, of these luminances.
    pub(super) fn mixed(parts: &[(f64, Color)]) -> Option<Color> {
        let sum = |part: fn(&[f64; 3]) -> f64| parts.iter().map(|&(y, color)| part(&color.xyz(y))).sum();
        Color::of_xyz([sum(|c| c[0]), sum(|c| c[1]), sum(|c| c[2])])
    }

    fn xyz(self, luminance: f64) -> [f64; 3] {
        [self.x / self.y * luminance, luminance, (1.0 - self.x - self.y).max(0.0) / self.y * luminance]
    }

    /// Whether it passes for grey, by mgf2rad's measure.
    pub(super) fn is_grey(self) -> bool {
        let near = |c: f64| (0.323..=0.343).contains(&c);
        near(self.x) && near(self.y)
    }

    /// Whether two pass for the same, by mgf2rad's measure.
    pub(super) fn is_like(self, other: Color) -> bool {
        (self.x - other.x).abs() + (self.y - other.y).abs() <= 0.015
    }

    /// Whether two are the same but for the last of the six digits that rad2mgf writes.
    pub(super) fn is_same(self, other: Color) -> bool {
        (self.x - other.x).abs() <= 1.5e-6 && (self.y - other.y).abs() <= 1.5e-6
    }

    /// Linear RGB in Radiance's primaries, none below 0.
    pub(super) fn rgb(self, luminance: f64) -> DVec3 {
        if self == Color::NEUTRAL {
            return DVec3::splat(luminance);
        }
        let rgb = DVec3::from_array(rgb_from_xyz(self.xyz(luminance)));
        towards_grey(rgb, luminance, 0.0..=f64::INFINITY)
    }
}

/// A colour, moved towards grey of its luminance until all of it is in the range.
pub(super) fn towards_grey(rgb: DVec3, luminance: f64, range: std::ops::RangeInclusive<f64>) -> DVec3 {
    let (low, high) = (rgb.min_element(), rgb.max_element());
    let mut keep: f64 = 1.0;
    if low < *range.start() {
        keep = keep.min((luminance - range.start()) / (luminance - low));
    }
    if high > *range.end() {
        keep = keep.min((range.end() - luminance) / (high - luminance));
    }
    if keep == 1.0 {
        return rgb;
    }
    (DVec3::splat(luminance).lerp(rgb, keep.max(0.0)))
        .clamp(DVec3::splat(*range.start()), DVec3::splat(*range.end()))
}

#[cfg(test)]
mod tests {
    use bsdftree::color::xyz_from_rgb;
    use proptest::prelude::*;

    use super::*;

    /// Red, green, blue as mgf2rad of Radiance 6.1 prints them for `rd .5`.
    #[test]
    fn chromaticities_agree_with_mgf2rad() {
        for ([x, y], expected) in [
            ([0.4, 0.4], [0.599616, 0.489045, 0.205696]),
            ([0.2, 0.4], [0.0, 0.699217, 0.485436]),
            ([0.1, 0.8], [0.0, 0.725739, 0.211115]),
        ] {
            let rgb = Color::of_xy(x, y).unwrap().rgb(0.5);
            assert!((rgb - DVec3::from_array(expected)).abs().max_element() < 2e-6, "{x} {y}: {rgb}");
        }
    }

    #[test]
    fn grey_is_grey_exactly() {
        for color in [Color::of_xy(0.3333, 0.3333), Color::of_spectrum([300.0, 900.0], &[0.2, 0.2, 0.2])] {
            assert_eq!(color.unwrap().rgb(0.3), DVec3::splat(0.3));
        }
        assert!(Color::of_xy(0.33, 0.34).unwrap().is_grey() && !Color::of_xy(0.35, 0.33).unwrap().is_grey());
    }

    #[test]
    fn impossible_colors_are_none() {
        assert_eq!(Color::of_xy(0.3, 0.0), None);
        assert_eq!(Color::of_xy(0.5, 0.6), None);
        assert_eq!(Color::of_xy(-0.1, 0.6), None);
        assert_eq!(Color::of_spectrum([900.0, 1000.0], &[1.0, 1.0]), None);
        assert_eq!(Color::of_spectrum([400.0, 700.0], &[0.0, 0.0]), None);
        assert_eq!(Color::of_spectrum([400.0, 700.0], &[1.0]), None);
        assert_eq!(Color::mixed(&[(0.0, Color::NEUTRAL)]), None);
    }

    /// CIE: daylight-like temperatures lie on the Planckian locus.
    #[test]
    fn black_bodies_are_on_the_planckian_locus() {
        for (kelvin, x, y) in [
            (2856.0, 0.4475, 0.4074),
            (6500.0, 0.3135, 0.3237),
            (1e4, 0.2807, 0.2884),
            (1e300, 0.2399, 0.2341),
        ] {
            let color = Color::of_black_body(kelvin).unwrap();
            assert!((color.x - x).abs() < 6e-4 && (color.y - y).abs() < 6e-4, "{kelvin} K: {color:?}");
        }
    }

    #[test]
    fn spectra_are_linear_between_their_values() {
        let coarse = Color::of_spectrum([380.0, 780.0], &[0.0, 1.0]).unwrap();
        let values: Vec<f64> = (0..=400).map(|k| f64::from(k) / 400.0).collect();
        let fine = Color::of_spectrum([380.0, 780.0], &values).unwrap();
        assert!((coarse.x - fine.x).abs() < 1e-12 && (coarse.y - fine.y).abs() < 1e-12);
        assert!(coarse.x > 0.36, "more red than blue: {coarse:?}");
    }

    proptest! {
        #[test]
        fn luminance_is_kept_and_mixtures_add_up(
            x in prop::array::uniform2(0.05..0.6f64), y in prop::array::uniform2(0.05..0.4f64), weights in prop::array::uniform2(0.01..1.0f64)
        ) {
            let colors = [0, 1].map(|k| Color::of_xy(x[k], y[k]).unwrap());
            let rgb = colors[0].rgb(weights[0]);
            prop_assert!(rgb.min_element() >= 0.0);
            prop_assert!((xyz_from_rgb(rgb.to_array())[1] - weights[0]).abs() < 1e-9);
            let mixed = Color::mixed(&[(weights[0], colors[0]), (weights[1], colors[1])]).unwrap();
            let sum = mixed.xyz(weights[0] + weights[1]);
            for k in 0..3 {
                let parts = colors[0].xyz(weights[0])[k] + colors[1].xyz(weights[1])[k];
                prop_assert!((sum[k] - parts).abs() < 1e-9);
            }
            let inside = towards_grey(rgb, weights[0], 0.0..=1.0);
            prop_assert!(inside.max_element() <= 1.0);
            prop_assert!((xyz_from_rgb(inside.to_array())[1] - weights[0]).abs() < 1e-9);
        }
    }
}
