//! What a path carries: RGB, or its luminance alone.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul};

use bsdftree::color::xyz_from_rgb;
use glam::DVec3;

/// The weight a path carries: [`DVec3`] for RGB, `f64` for luminance alone.
///
/// A grey path multiplies luminances, which equals the luminance of the product only where at most one factor is
/// coloured: use it where [`is_neutral`](super::is_neutral) holds for all materials, or where that is accepted.
pub trait Spectrum:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// How many numbers it is.
    const CHANNELS: usize;
    /// Absorbs all.
    const BLACK: Self;
    /// Changes nothing.
    const WHITE: Self;
    /// From linear RGB in Radiance's primaries.
    fn from_rgb(rgb: DVec3) -> Self;
    /// Luminance: the Y of [`xyz_from_rgb`], as in the BSDF that comes of it; 1 for white.
    fn luminance(self) -> f64;
    /// Number `k` below [`CHANNELS`](Self::CHANNELS): red, green, blue or the luminance.
    fn channel(self, k: usize) -> f64;
    /// From its [`channel`](Self::channel)s.
    fn from_channels(channel: impl FnMut(usize) -> f64) -> Self;
}

impl Spectrum for f64 {
    const CHANNELS: usize = 1;
    const BLACK: f64 = 0.0;
    const WHITE: f64 = 1.0;

    #[inline]
    fn from_rgb(rgb: DVec3) -> f64 {
        rgb.luminance()
    }

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

impl Spectrum for DVec3 {
    const CHANNELS: usize = 3;
    const BLACK: DVec3 = DVec3::ZERO;
    const WHITE: DVec3 = DVec3::ONE;

    #[inline]
    fn from_rgb(rgb: DVec3) -> DVec3 {
        rgb
    }

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
