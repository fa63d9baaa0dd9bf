//! What is counted where a path leaves.

use std::marker::PhantomData;

use super::Band;
use crate::scatter::{Flux, Spectral, Spectrum, Xyz};
use crate::spectra::{GROUP, N_GROUPS, Weights, cie_xyz};

/// From what a path carries to what is counted of it.
pub(crate) trait Detector: Sync {
    /// What a path carries.
    type Light: Spectrum;
    /// What is counted in each band.
    type Flux: Flux;
    /// Whether that is known by wavelengths.
    const SPECTRAL: bool;
    /// How many bands there are.
    fn n_bands(&self) -> usize;
    /// What light comes to in a band.
    fn detect(&self, light: &Self::Light, band: usize) -> Self::Flux;
    /// What light that is 1 in a [channel](Flux::channel) and nothing else comes to.
    fn of_channel(&self, channel: usize, band: usize) -> Self::Flux;
}

/// Counts what paths carry.
pub(crate) struct Plain<S>(PhantomData<fn() -> S>);

impl<S> Plain<S> {
    pub fn new() -> Self {
        Plain(PhantomData)
    }
}

impl<S: Spectrum> Detector for Plain<S> {
    type Light = S;
    type Flux = S;
    const SPECTRAL: bool = false;

    fn n_bands(&self) -> usize {
        1
    }

    #[inline(always)]
    fn detect(&self, light: &S, _: usize) -> S {
        *light
    }

    fn of_channel(&self, channel: usize, _: usize) -> S {
        S::from_channels(|k| f64::from(u8::from(k == channel)))
    }
}

/// Counts means over wavelengths.
pub(crate) struct Spectrometer<F> {
    bands: Vec<Response>,
    flux: PhantomData<fn() -> F>,
}

/// What is counted of a band.
enum Response {
    One(Box<Weights>),
    /// X, Y, Z.
    Color,
}

/// What a spectrometer can count.
pub(crate) trait Detected: Flux {
    /// Whether it has colour.
    const COLOR: bool;
    /// A flux without colour.
    fn grey(value: f64) -> Self;
    /// A flux of X, Y, Z.
    fn color(xyz: [f64; 3]) -> Self;
}

impl Detected for f64 {
    const COLOR: bool = false;

    #[inline]
    fn grey(value: f64) -> f64 {
        value
    }

    #[inline]
    fn color(xyz: [f64; 3]) -> f64 {
        xyz[1]
    }
}

impl Detected for Xyz {
    const COLOR: bool = true;

    #[inline]
    fn grey(value: f64) -> Xyz {
        Xyz::from_channels(|_| value)
    }

    #[inline]
    fn color(xyz: [f64; 3]) -> Xyz {
        Xyz(xyz.into())
    }
}

impl<F: Detected> Spectrometer<F> {
    /// `None` if one of the bands is not known by wavelengths.
    pub fn new(bands: &[Band]) -> Option<Self> {
        let response = |band: &Band| match F::COLOR && band.is_visible() {
            true => Some(Response::Color),
            false => band.weights().map(|weights| Response::One(Box::new(weights))),
        };
        Some(Spectrometer { bands: bands.iter().map(response).collect::<Option<_>>()?, flux: PhantomData })
    }
}

impl<F: Detected> Detector for Spectrometer<F> {
    type Light = Spectral;
    type Flux = F;
    const SPECTRAL: bool = true;

    fn n_bands(&self) -> usize {
        self.bands.len()
    }

    #[inline]
    fn detect(&self, light: &Spectral, band: usize) -> F {
        match &self.bands[band] {
            // A spectrum of single lines can come out a little below 0.
            Response::One(weights) => F::grey(light.mean(weights).max(0.0)),
            Response::Color => F::color(light.xyz().map(|c| c.max(0.0))),
        }
    }

    fn of_channel(&self, channel: usize, band: usize) -> F {
        debug_assert!(channel < N_GROUPS);
        let sum = |weights: &Weights| -> f64 {
            weights[channel * GROUP..(channel + 1) * GROUP].iter().map(|&w| f64::from(w)).sum()
        };
        match &self.bands[band] {
            Response::One(weights) => F::grey(sum(weights)),
            Response::Color => F::color(cie_xyz().each_ref().map(sum)),
        }
    }
}
