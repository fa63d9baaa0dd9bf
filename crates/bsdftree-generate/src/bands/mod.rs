//! Bands: what of the light is counted, and by which name it stands in the file.
//!
//! In: what paths carry where they leave. Out: for each band, one number, or X, Y, Z. Products of spectra are taken along the path, and only
//! then averaged over wavelengths: the mean of a product is not the product of means.
//!
//! * `Visible` is CIE Y (2°, 1931) in **equal-energy light** (illuminant E), with colour X, Y, Z or Y, u′, v′. That is what Radiance's RGB are in, so that
//!   neutral is neutral there (u′ = 4/19, v′ = 9/19), and what its rtrace makes of spectra. Deviation from WINDOW, whose Visible is in
//!   D65: of glass and paints Y differs by less than 0.01, and X, Y, Z of white would not be equal.
//! * `Solar`, `NIR`, `UV` are in sunlight (ASTM G173, global on 37°, air mass 1.5) from 300 to 2500, 780 to 2500 and 300 to 380 nm, the ranges that
//!   LBNL's schema of the file gives.
//! * `550` is one wavelength, `PAR:400-700` the mean over wavelengths \[nm\].

mod band;
mod detector;
#[cfg(test)]
mod tests;

pub use band::{Band, BandError};
pub(crate) use detector::{Detector, Plain, Spectrometer};
