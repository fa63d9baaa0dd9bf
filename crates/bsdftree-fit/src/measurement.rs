//! What a goniophotometer measured: for some incident directions, values at scattered exitant directions.
//!
//! Directions are the library's: unit vectors away from the surface, the incident one too, +Z the front (the room). Values are BSDF
//! \[1/sr\] without a cosine. A scan may have exitant directions on both sides; a measurement may have incident directions on both.

use bsdftree::direction::Side;
use bsdftree::{Direction, Part};

/// Values for one incident direction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scan {
    /// Where the light came from, a unit vector away from the surface.
    pub incident: Direction,
    /// Where it was measured, unit vectors away from the surface.
    pub exitant: Vec<Direction>,
    /// BSDF \[1/sr\], [`Measurement::n_channels`] numbers for each exitant direction, one direction after the other. Noise may make
    /// values negative.
    pub values: Vec<f64>,
    /// Standard error of each value \[1/sr\], as many as values; empty if unknown.
    pub errors: Vec<f64>,
    /// Where it is from: file, and block or sheet if the file has several.
    pub source: String,
}

/// All that was measured of one sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Numbers for each pair of directions: 1, or 3 for CIE X, Y, Z.
    pub n_channels: usize,
    /// Scans, in the order of the files.
    pub scans: Vec<Scan>,
    /// What the sample is called, if the file says so.
    pub name: Option<String>,
    /// Who made the sample, if the file says so.
    pub manufacturer: Option<String>,
    /// The symmetry that the file states.
    pub symmetry: Option<Symmetry>,
    /// Wavelength of the source \[nm\], if there is one.
    pub wavelength_nm: Option<f64>,
    /// What was assumed, repaired or left out in reading, a sentence each.
    pub notes: Vec<String>,
}

/// What turns and mirrors a sample looks the same after.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Symmetry {
    /// None.
    Anisotropic,
    /// A mirror at the plane y = 0.
    BilateralX,
    /// A mirror at the plane x = 0.
    BilateralY,
    /// Both mirrors.
    Quadrilateral,
    /// Every turn about the normal, and every mirror that holds it.
    Isotropic,
}

impl Measurement {
    /// The parts that there are values of, in the order of [`Part::ALL`].
    pub fn parts(&self) -> Vec<Part> {
        let has = |part| {
            self.scans.iter().any(|scan| {
                let from = Side::of(scan.incident);
                scan.exitant.iter().any(|&exitant| Part::between(from, Side::of(exitant)) == part)
            })
        };
        Part::ALL.into_iter().filter(|&part| has(part)).collect()
    }
}
