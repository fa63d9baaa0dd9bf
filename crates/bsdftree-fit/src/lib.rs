//! Scattered BSDF measurements → a variable-resolution BSDF.
//!
//! What enters: files of goniophotometers ([`read`]), one scan of exitant directions for each incident direction. What leaves: a
//! [`Measurement`], and fitted to it trees with an error for each leaf.

pub mod measurement;
pub mod read;
pub mod write;

pub use measurement::{Measurement, Scan, Symmetry};
