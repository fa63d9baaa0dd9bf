//! Light of many wavelengths: what a path carries where spectra are known, or sunlight is asked for.
//!
//! Its numbers are values at the wavelengths of [`spectra`](crate::spectra). They are `f32`, whose rounding is a thousandth of what the
//! steps between the wavelengths leave out; sums of them are made in eight parts and then in `f64`, in one order on all machines.

use std::ops::{Add, Div, Mul, Range};
use std::sync::LazyLock;

use glam::DVec3;

use super::spectrum::{Flux, Spectrum, is_grey};
use crate::spectra::{
    GROUP, N, N_GROUPS, RED_GREEN, VISIBLE_NM, Weights, cie_xyz, importance, resampled, wavelengths_nm,
};

/// Light, or a factor of light, at 136 wavelengths from 300 to 2500 nm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Spectral([f32; N]);

/// Numbers that are added at once.
const LANES: usize = 8;
const _: () = assert!(N.is_multiple_of(LANES) && N.is_multiple_of(GROUP));

impl Spectral {
    /// From two or more samples ≥ 0 at rising wavelengths \[nm\], linear between them, and beyond half a step from the first and the last
    /// of them 0; but a spectrum that reaches below 400 nm or above 700 nm goes on with its last value.
    ///
    /// ```
    /// use bsdftree_generate::scatter::Spectral;
    /// let [x, y, z] = Spectral::from_samples(&[380.0, 780.0], &[0.5, 0.5]).xyz();
    /// assert!((x - 0.5).abs() < 1e-6 && (y - 0.5).abs() < 1e-6 && (z - 0.5).abs() < 1e-6);
    /// ```
    ///
    /// # Panics
    /// If there are fewer than two wavelengths, or not as many values.
    pub fn from_samples(wavelengths_nm: &[f64], values: &[f64]) -> Spectral {
        assert!(wavelengths_nm.len() >= 2 && values.len() == wavelengths_nm.len());
        Spectral(resampled(wavelengths_nm, values).map(|value| value as f32))
    }

    /// The mean over wavelengths that weights say.
    #[inline]
    pub(crate) fn mean(&self, weights: &Weights) -> f64 {
        let mut sums = [0.0f32; LANES];
        for (values, weights) in self.0.chunks_exact(LANES).zip(weights.chunks_exact(LANES)) {
            for (sum, (value, weight)) in sums.iter_mut().zip(values.iter().zip(weights)) {
                *sum += value * weight;
            }
        }
        sums.into_iter().map(f64::from).sum()
    }

    /// CIE X, Y, Z in equal-energy light; 1 for white.
    pub fn xyz(&self) -> [f64; 3] {
        cie_xyz().each_ref().map(|weights| self.mean(weights))
    }

    #[inline]
    fn map(mut self, f: impl Fn(f32) -> f32) -> Spectral {
        self.0.iter_mut().for_each(|value| *value = f(*value));
        self
    }

    #[inline]
    fn zip(mut self, other: &Spectral, f: impl Fn(f32, f32) -> f32) -> Spectral {
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a = f(*a, *b));
        self
    }
}

impl Add for Spectral {
    type Output = Spectral;

    #[inline]
    fn add(self, other: Spectral) -> Spectral {
        self.zip(&other, |a, b| a + b)
    }
}

impl Mul for Spectral {
    type Output = Spectral;

    #[inline]
    fn mul(self, other: Spectral) -> Spectral {
        self.zip(&other, |a, b| a * b)
    }
}

impl Mul<f64> for Spectral {
    type Output = Spectral;

    #[inline]
    fn mul(self, factor: f64) -> Spectral {
        let factor = factor as f32;
        self.map(|value| value * factor)
    }
}

impl Div<f64> for Spectral {
    type Output = Spectral;

    #[inline]
    fn div(self, divisor: f64) -> Spectral {
        self * (1.0 / divisor)
    }
}

impl Flux for Spectral {
    /// Means over groups of neighbouring wavelengths, where all of them would be too much.
    const CHANNELS: usize = N_GROUPS;
    const BLACK: Spectral = Spectral([0.0; N]);

    /// Y and sunlight in equal parts, and a little of every wavelength, since what has none would be lost.
    #[inline]
    fn luminance(self) -> f64 {
        self.mean(importance())
    }

    fn channel(self, k: usize) -> f64 {
        self.0[k * GROUP..(k + 1) * GROUP].iter().map(|&value| f64::from(value)).sum::<f64>() / GROUP as f64
    }

    fn from_channels(mut channel: impl FnMut(usize) -> f64) -> Spectral {
        let mut values = [0.0; N];
        values.chunks_exact_mut(GROUP).enumerate().for_each(|(k, group)| group.fill(channel(k) as f32));
        Spectral(values)
    }
}

impl Spectrum for Spectral {
    const WHITE: Spectral = Spectral([1.0; N]);

    /// A spectrum of this colour. Beyond the visible range, of which RGB says nothing, it is the grey of the same luminance.
    fn from_rgb(rgb: DVec3) -> Spectral {
        if is_grey(rgb) {
            return Spectral([rgb.x as f32; N]);
        }
        let [red, green, blue] = rgb.to_array().map(|c| c as f32);
        let mut values = [rgb.luminance() as f32; N];
        for (value, [r, g]) in values[VISIBLE].iter_mut().zip(&*PRIMARIES) {
            *value = r * red + g * green + (1.0 - r - g).max(0.0) * blue;
        }
        Spectral(values)
    }

    #[inline]
    fn clamped(self) -> Spectral {
        self.map(|value| value.max(0.0))
    }

    #[inline]
    fn at_most(self, other: Spectral) -> Spectral {
        self.zip(&other, f32::min)
    }

    #[inline]
    fn from_spectral(spectral: Spectral) -> Spectral {
        spectral
    }
}

/// Shares of red and green in the visible range.
static PRIMARIES: LazyLock<[[f32; 2]; RED_GREEN.len()]> =
    LazyLock::new(|| RED_GREEN.map(|shares| shares.map(|share| share as f32)));

/// The wavelengths that RGB says something of: all visible ones but the last, which belongs as much to what is beyond.
const VISIBLE: Range<usize> = {
    let nm = wavelengths_nm();
    let mut first = 0;
    while nm[first] < VISIBLE_NM[0] {
        first += 1;
    }
    let last = first + RED_GREEN.len() - 1;
    assert!(nm[last] == VISIBLE_NM[1]);
    first..last
};

#[cfg(test)]
mod tests {
    use bsdftree::color::xyz_from_rgb;

    use super::*;

    #[test]
    fn colours_of_rgb_are_kept() {
        assert!(RED_GREEN.iter().all(|[r, g]| *r >= 0.0 && *g >= 0.0 && r + g <= 1.0 + 1e-6));
        for rgb in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.2, 0.7, 0.4), DVec3::splat(0.3)] {
            let spectral = Spectral::from_rgb(rgb);
            for (found, expected) in spectral.xyz().into_iter().zip(xyz_from_rgb(rgb.to_array())) {
                assert!((found - expected).abs() < 1e-6, "{rgb}: {found} is not {expected}");
            }
            assert!((DVec3::from_spectral(spectral) - rgb).abs().max_element() < 4e-6, "{rgb}");
            assert!((spectral.0[0] - rgb.luminance() as f32).abs() < 1e-6);
        }
    }

    #[test]
    fn spectra_are_multiplied_before_they_are_averaged() {
        let nm = [380.0, 780.0];
        let (rising, falling) =
            (Spectral::from_samples(&nm, &[0.0, 1.0]), Spectral::from_samples(&nm, &[1.0, 0.0]));
        let (y, of_means) = ((rising * falling).xyz()[1], rising.xyz()[1] * falling.xyz()[1]);
        // x(1 − x) is a mean less a mean of squares: the difference is the variance of ȳ's wavelengths.
        assert!(of_means - y > 0.005, "{y} {of_means}");
        let squares = (rising * rising).xyz()[1];
        assert!((y - (rising.xyz()[1] - squares)).abs() < 1e-6);
    }

    #[test]
    fn white_is_one_and_groups_are_means() {
        assert!((Spectral::WHITE.luminance() - 1.0).abs() < 1e-6);
        let slope = Spectral::from_samples(&[300.0, 2500.0], &[0.0, 1.0]);
        assert!((slope.channel(0) - 35.0 / 2200.0).abs() < 1e-6);
        let coarse = Spectral::from_channels(|k| slope.channel(k));
        for k in 0..N_GROUPS {
            assert!((coarse.channel(k) - slope.channel(k)).abs() < 1e-6);
        }
        assert!(((slope + slope) * 0.5 / 0.5 - slope * 2.0).abs() < 1e-6);
    }

    impl std::ops::Sub for Spectral {
        type Output = Spectral;

        fn sub(self, other: Spectral) -> Spectral {
            self + other * -1.0
        }
    }

    impl Spectral {
        fn abs(&self) -> f32 {
            self.0.iter().fold(0.0, |most, value| most.max(value.abs()))
        }
    }
}
