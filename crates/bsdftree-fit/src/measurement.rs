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
    /// Half a turn about the normal, no mirror: what pabopto2bsdf calls "up".
    HalfTurn,
    /// A mirror at the plane y = 0.
    BilateralX,
    /// A mirror at the plane x = 0.
    BilateralY,
    /// Both mirrors.
    Quadrilateral,
    /// Every turn about the normal, and every mirror that holds it.
    Isotropic,
}

impl Symmetry {
    /// All of them.
    pub const ALL: [Symmetry; 6] = [
        Symmetry::Anisotropic,
        Symmetry::HalfTurn,
        Symmetry::BilateralX,
        Symmetry::BilateralY,
        Symmetry::Quadrilateral,
        Symmetry::Isotropic,
    ];

    /// The name by which people choose it: `bilateral_x`.
    pub fn name(self) -> &'static str {
        match self {
            Symmetry::Anisotropic => "anisotropic",
            Symmetry::HalfTurn => "half_turn",
            Symmetry::BilateralX => "bilateral_x",
            Symmetry::BilateralY => "bilateral_y",
            Symmetry::Quadrilateral => "quadrilateral",
            Symmetry::Isotropic => "isotropic",
        }
    }
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

    /// Leaves out what was measured nearer to the surface than an angle \[degree\]; how many points that were. Incident directions stay.
    pub fn leave_out_grazing(&mut self, angle_deg: f64) -> usize {
        // What was measured at just that angle stays, whatever its rounding.
        let least = angle_deg.to_radians().sin() - 1e-9;
        let n = self.n_channels;
        self.scans.iter_mut().map(|scan| scan.retain(n, |exitant| exitant[2].abs() >= least)).sum()
    }

    /// The smallest angle between an incident direction and the surface \[degree\]; 90 if there is none.
    pub fn lowest_incident_deg(&self) -> f64 {
        self.scans
            .iter()
            .map(|scan| scan.incident[2].abs().clamp(0.0, 1.0).asin().to_degrees())
            .fold(90.0, f64::min)
    }

    /// Turns the sample by half a turn about +Y: front and back change places, and so do left and right; up stays up.
    pub fn turn_front_to_back(&mut self) {
        for scan in &mut self.scans {
            for direction in scan.exitant.iter_mut().chain([&mut scan.incident]) {
                *direction = [-direction[0], direction[1], -direction[2]];
            }
        }
    }

    /// What is wrong with it, if anything: directions that are no unit vectors, numbers that are not finite or too few or many.
    ///
    /// # Errors
    /// The first fault, in words that name the scan.
    pub fn verify(&self) -> Result<(), String> {
        if !matches!(self.n_channels, 1 | 3) {
            return Err(format!(
                "{} numbers for each direction; expected 1, or 3 for X, Y and Z",
                self.n_channels
            ));
        }
        for (k, scan) in self.scans.iter().enumerate() {
            scan.verify(self.n_channels).map_err(|fault| format!("scan {k}: {fault}"))?;
        }
        Ok(())
    }
}

impl Scan {
    /// Keeps the points whose exitant direction is wanted; how many are gone.
    pub(crate) fn retain(&mut self, n_channels: usize, is_wanted: impl Fn(&Direction) -> bool) -> usize {
        let kept: Vec<usize> = (0..self.exitant.len()).filter(|&k| is_wanted(&self.exitant[k])).collect();
        let n_gone = self.exitant.len() - kept.len();
        if n_gone > 0 {
            let n = n_channels;
            let of_kept = |values: &[f64]| -> Vec<f64> {
                kept.iter().flat_map(|&k| values.get(n * k..n * (k + 1)).unwrap_or(&[])).copied().collect()
            };
            (self.values, self.errors) = (of_kept(&self.values), of_kept(&self.errors));
            self.exitant = kept.iter().map(|&k| self.exitant[k]).collect();
        }
        n_gone
    }

    fn verify(&self, n_channels: usize) -> Result<(), String> {
        let is_unit = |d: &Direction| (d.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-9;
        if !is_unit(&self.incident) {
            return Err(format!("incident is {:?}; expected a unit vector", self.incident));
        }
        if let Some(k) = self.exitant.iter().position(|d| !is_unit(d)) {
            return Err(format!("exitant[{k}] is {:?}; expected a unit vector", self.exitant[k]));
        }
        let n = n_channels * self.exitant.len();
        if self.values.len() != n {
            return Err(format!(
                "{} values; expected {n}, for {} directions",
                self.values.len(),
                self.exitant.len()
            ));
        }
        if !self.errors.is_empty() && self.errors.len() != n {
            return Err(format!("{} errors; expected {n}, or none", self.errors.len()));
        }
        if let Some(k) = self.values.iter().position(|value| !value.is_finite()) {
            return Err(format!(
                "value {} of exitant[{}] is {}; expected a finite number",
                k % n_channels,
                k / n_channels,
                self.values[k]
            ));
        }
        if let Some(k) = self.errors.iter().position(|error| !(error.is_finite() && *error >= 0.0)) {
            return Err(format!(
                "error {} of exitant[{}] is {}; expected 0 or more",
                k % n_channels,
                k / n_channels,
                self.errors[k]
            ));
        }
        Ok(())
    }
}
