//! Bands: what of the light is counted, and by which name it stands in the file.
//!
//! In: what paths carry where they leave. Out: for each band, one number, or X, Y, Z. Products of spectra are taken along the path, and only
//! then averaged over wavelengths: the mean of a product is not the product of means.
//!
//! * `Visible` is CIE Y (2°, 1931) in **equal-energy light** (illuminant E), with colour X, Y, Z or Y, u′, v′. That is what Radiance's RGB are
//!   in, so that neutral is neutral there (u′ = 4/19, v′ = 9/19), and what its rtrace makes of spectra. Deviation from WINDOW, whose Visible
//!   is in D65: over 78 measured patches of colour checkers Y differs by 0.005 in the mean and by 0.016 at most. The label in the file
//!   (D65) is genBSDF's.
//! * `Solar`, `NIR`, `UV` are in sunlight (ASTM G173, global on 37°, air mass 1.5) from 300 to 2500, 780 to 2500 and 300 to 380 nm, the ranges
//!   that LBNL's schema of the file gives.
//! * `550` is one wavelength, `PAR:400-700` the mean over wavelengths \[nm\].
//!
//! Where diffused light is reused (`diffuse`), the model knows wavelengths in 17 groups, which puts it, and the report's totals, off by less
//! than 1e-3 of the light; full paths, which know all of them, correct the tree. Checkpoints keep what was counted, so bands cannot
//! change when a generation goes on. Media (`dielectric`) and the factors of patterns on them are RGB.

mod band;
mod detector;
#[cfg(test)]
mod tests;

pub use band::{Band, BandError};
pub(crate) use detector::{Detector, Plain, Spectrometer};
