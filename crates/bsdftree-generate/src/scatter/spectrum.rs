//! What a path carries, and what is counted of it.
//!
//! A path carries RGB, its luminance alone, or light of many wavelengths ([`Spectral`](super::Spectral)); numbers of one meeting after the other are
//! multiplied. What is counted where paths leave ([`Flux`]) is only summed up: it is what a path carries, or some means over its wavelengths.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul};

use bsdftree::color::{rgb_from_xyz, xyz_from_rgb};
use glam::DVec3;

use super::Spectral;

/// Light that can be summed up: [`DVec3`] for RGB, [`Xyz`], `f64` for one number.
pub trait Flux:
    Copy + Debug + PartialEq + Send + Sync + Add<Output = Self> + Mul<f64, Output = Self> + 'static
{
    /// How many numbers it is, at least where it is kept.
    const CHANNELS: usize;
    /// No light.
    const BLACK: Self;
    /// What it counts for: Y, 1 for white.
    fn luminance(self) -> f64;
    /// Number `k` below [`CHANNELS`](Self::CHANNELS).
    fn channel(self, k: usize) -> f64;
    /// From its [`channel`](Self::channel)s, of which it may have more than that ([`Spectral`](super::Spectral)).
    fn from_channels(channel: impl FnMut(usize) -> f64) -> Self;
}

/// The weight a path carries: [`DVec3`] for RGB, `f64` for luminance alone, or [`Spectral`](super::Spectral).
///
/// A grey path multiplies luminances, which equals the luminance of the product only where at most one factor is
/// coloured: use it where [`is_neutral`](super::is_neutral) holds for all materials, or where that is accepted. So it is with RGB and
/// spectra: X, Y, Z of a product of spectra do not follow from RGB of each.
pub trait Spectrum: Flux + Mul<Output = Self> + Div<f64, Output = Self> {
    /// Changes nothing.
    const WHITE: Self;
    /// From linear RGB in Radiance's primaries.
    fn from_rgb(rgb: DVec3) -> Self;
    /// The same with nothing below 0.
    fn clamped(self) -> Self;
    /// The lesser of both, number by number.
    fn at_most(self, other: Self) -> Self;
    /// From a spectrum. RGB: that of X, Y, Z in equal-energy light, with nothing below 0, as Radiance has it.
    fn from_spectral(spectral: Spectral) -> Self;
}

/// CIE X, Y, Z: a flux that nothing is multiplied with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Xyz(pub DVec3);

impl Flux for f64 {
    const CHANNELS: usize = 1;
    const BLACK: f64 = 0.0;

    #[inline]
    fn luminance(self) -> f64 {
        self
    }

    #[inline]
    fn channel(self, _: usize) -> f64 {
        self
    }

    #[inline]
    fn from_channels(mut channel: impl FnMut(usize) -> f64) -> f64 {
        channel(0)
    }
}

impl Spectrum for f64 {
    const WHITE: f64 = 1.0;

    #[inline]
    fn from_rgb(rgb: DVec3) -> f64 {
        rgb.luminance()
    }

    #[inline]
    fn clamped(self) -> f64 {
        self.max(0.0)
    }

    #[inline]
    fn at_most(self, other: f64) -> f64 {
        self.min(other)
    }

    #[inline]
    fn from_spectral(spectral: Spectral) -> f64 {
        spectral.xyz()[1]
    }
}

impl Flux for DVec3 {
    const CHANNELS: usize = 3;
    const BLACK: DVec3 = DVec3::ZERO;

    #[inline]
    fn luminance(self) -> f64 {
        xyz_from_rgb(self.to_array())[1]
    }

    #[inline]
    fn channel(self, k: usize) -> f64 {
        self[k]
    }

    #[inline]
    fn from_channels(channel: impl FnMut(usize) -> f64) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(channel))
    }
}

impl Spectrum for DVec3 {
    const WHITE: DVec3 = DVec3::ONE;

    #[inline]
    fn from_rgb(rgb: DVec3) -> DVec3 {
        rgb
    }

    #[inline]
    fn clamped(self) -> DVec3 {
        self.max(DVec3::ZERO)
    }

    #[inline]
    fn at_most(self, other: DVec3) -> DVec3 {
        self.min(other)
    }

    #[inline]
    fn from_spectral(spectral: Spectral) -> DVec3 {
        DVec3::from_array(rgb_from_xyz(spectral.xyz())).max(DVec3::ZERO)
    }
}

impl Add for Xyz {
    type Output = Xyz;

    #[inline]
    fn add(self, other: Xyz) -> Xyz {
        Xyz(self.0 + other.0)
    }
}

impl Mul<f64> for Xyz {
    type Output = Xyz;

    #[inline]
    fn mul(self, factor: f64) -> Xyz {
        Xyz(self.0 * factor)
    }
}

impl Flux for Xyz {
    const CHANNELS: usize = 3;
    const BLACK: Xyz = Xyz(DVec3::ZERO);

    #[inline]
    fn luminance(self) -> f64 {
        self.0.y
    }

    #[inline]
    fn channel(self, k: usize) -> f64 {
        self.0[k]
    }

    #[inline]
    fn from_channels(channel: impl FnMut(usize) -> f64) -> Xyz {
        Xyz(DVec3::from_channels(channel))
    }
}

/// Whether red, green and blue are the same.
#[inline]
pub(super) fn is_grey(rgb: DVec3) -> bool {
    rgb.x == rgb.y && rgb.y == rgb.z
}

/// `f` of each component; computed once for a grey, the common case.
#[inline]
pub(super) fn map_rgb(rgb: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    if is_grey(rgb) { DVec3::splat(f(rgb.x)) } else { rgb.map(f) }
}
