//! Spectra of patterns: how a colour depends on the wavelength.
//!
//! In: `spectrum` (samples at even wavelengths), `specfile` (a data file of one dimension), `specfunc` (a function of the
//! wavelength and of the place). Out: [`Spectral`], wavelengths and values, which multiply what a material reflects and
//! transmits. A tracer that carries bands takes its means over them; one that carries RGB takes [`Spectral::rgb`], as
//! Radiance does. Source: Radiance's reference manual ("Patterns").

use std::sync::Arc;

use bsdftree::color::rgb_from_xyz;
use glam::DVec3;

use super::FieldError;
use super::formula::Call;
use super::space::{File, RayState, Seen, Space};
use crate::mgf::color::towards_grey;
use crate::mgf::observer;

/// A factor that depends on the wavelength.
///
/// Each value is the mean over an interval around its wavelength that reaches half-way to its neighbours, and at the ends as far
/// out as in. Nothing is known outside: Radiance takes it for 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectral {
    /// Ascending \[nm\]; at least two.
    pub wavelengths_nm: Vec<f64>,
    /// One for each wavelength.
    pub values: Vec<f64>,
    /// The file they were in, if they were in one.
    pub file: Option<File>,
}

impl Spectral {
    /// From wavelengths in either order, with as many values; `None` if they are not two or more in steady order.
    pub fn new(mut wavelengths_nm: Vec<f64>, mut values: Vec<f64>) -> Option<Spectral> {
        if wavelengths_nm.first() > wavelengths_nm.last() {
            wavelengths_nm.reverse();
            values.reverse();
        }
        let ascending = wavelengths_nm.windows(2).all(|pair| pair[0] < pair[1]);
        let right = ascending && wavelengths_nm.len() >= 2 && values.len() == wavelengths_nm.len();
        right.then_some(Spectral { wavelengths_nm, values, file: None })
    }

    /// The ends of the interval that value `k` stands for \[nm\].
    pub fn interval_nm(&self, k: usize) -> [f64; 2] {
        let w = &self.wavelengths_nm;
        let n = w.len();
        let middle = |a: usize, b: usize| 0.5 * (w[a] + w[b]);
        [
            if k == 0 { w[0] - 0.5 * (w[1] - w[0]) } else { middle(k - 1, k) },
            if k == n - 1 { w[k] + 0.5 * (w[k] - w[k - 1]) } else { middle(k, k + 1) },
        ]
    }

    /// The mean over a band \[nm\], where the band is not covered taken as 0.
    pub fn mean(&self, [from, to]: [f64; 2]) -> f64 {
        let parts = self.values.iter().enumerate().map(|(k, value)| {
            let [low, high] = self.interval_nm(k);
            value * (high.min(to) - low.max(from)).max(0.0)
        });
        parts.sum::<f64>() / (to - from)
    }

    /// Red, green and blue in Radiance's primaries: those of X, Y, Z by the CIE 1931 observer under light of equal energy, moved
    /// towards grey of the same luminance as far as one of them would be negative.
    pub fn rgb(&self) -> [f64; 3] {
        let n = self.values.len();
        let first = self.interval_nm(0)[0];
        let value = |nm: f64| {
            // The first interval that reaches so far; ends of intervals ascend.
            let (mut k, mut beyond) = (0, n);
            while k < beyond {
                let middle = (k + beyond) / 2;
                if self.interval_nm(middle)[1] < nm { k = middle + 1 } else { beyond = middle }
            }
            if nm < first { 0.0 } else { self.values.get(k).copied().unwrap_or(0.0) }
        };
        let xyz = observer::xyz(value);
        towards_grey(rgb_from_xyz(xyz).into(), xyz[1], 0.0..=f64::INFINITY).to_array()
    }
}

/// `specfunc`: a spectrum that is a function.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralFunction {
    /// Coordinates and arguments; the first two arguments are the wavelengths the function is defined between.
    pub space: Arc<Space>,
    /// Called with a wavelength \[nm\].
    pub function: Call,
    /// Where it is defined, the shorter one first \[nm\].
    pub range_nm: [f64; 2],
}

impl SpectralFunction {
    /// Most samples, one each 5 nm of the visible range.
    const SAMPLES: usize = 80;

    /// The same in a device that is turned by a rotation.
    pub fn turned(&self, turn: impl Fn(DVec3) -> DVec3) -> SpectralFunction {
        SpectralFunction { space: Arc::new(self.space.turned(turn)), ..self.clone() }
    }

    /// The spectrum for a ray at a surface.
    ///
    /// # Errors
    /// A function that fails, or whose value is not finite.
    pub fn at(&self, ray: &RayState) -> Result<Spectral, FieldError> {
        let seen = Seen { ray, space: &self.space };
        let [short, long] = self.range_nm;
        let step = (long - short) / Self::SAMPLES as f64;
        let wavelengths_nm: Vec<f64> = (0..Self::SAMPLES).map(|k| short + (k as f64 + 0.5) * step).collect();
        let mut values = Vec::with_capacity(Self::SAMPLES);
        for nm in &wavelengths_nm {
            values.push(self.function.call(&[*nm], &seen).map_err(|reason| self.space.error(reason))?);
        }
        Ok(Spectral { wavelengths_nm, values, file: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_spectrum_is_white() {
        let white = Spectral::new(vec![380.0, 480.0, 580.0, 680.0, 780.0], vec![0.5; 5]).unwrap();
        assert!(white.rgb().iter().all(|c| (c - 0.5).abs() < 1e-15));
    }

    #[test]
    fn what_is_not_covered_is_black() {
        let line = Spectral::new(vec![650.0, 640.0], vec![1.0, 0.0]).unwrap();
        assert_eq!(line.mean([655.0, 700.0]), 0.0);
        assert!((line.mean([640.0, 660.0]) - 0.5).abs() < 1e-12);
        let [r, g, b] = line.rgb();
        // A red line is outside of the primaries' triangle.
        assert!(r > 0.01 && (0.0..1e-3).contains(&g.min(b)), "{r} {g} {b}");
    }

    #[test]
    fn means_over_all_intervals_are_the_integral() {
        let s = Spectral::new(vec![400.0, 410.0, 440.0, 500.0], vec![1.0, 2.0, 3.0, 4.0]).unwrap();
        let [from, to] = [s.interval_nm(0)[0], s.interval_nm(3)[1]];
        assert_eq!([from, to], [395.0, 530.0]);
        assert!((s.mean([from, to]) * (to - from) - (10.0 + 40.0 + 135.0 + 240.0)).abs() < 1e-9);
    }

    #[test]
    fn disorder_is_refused() {
        assert_eq!(Spectral::new(vec![400.0], vec![1.0]), None);
        assert_eq!(Spectral::new(vec![400.0, 410.0, 405.0, 420.0], vec![1.0; 4]), None);
        assert_eq!(Spectral::new(vec![400.0, 410.0], vec![1.0; 3]), None);
    }
}
