//! What is asked of a generation.

use std::path::PathBuf;
use std::time::Duration;

use bsdftree::Side;
use bsdftree::bsdf::LengthUnit;

use crate::bands::Band;
use crate::layout::{Layout, MAX_LOG2_RES};

/// A default at which pruning adds about 1 % to the error of the whole.
const DETAIL: f64 = 0.1;

/// The box that stands for the device \[m\]: rays enter through its front (z = max) or back (z = min), over its whole extent in x
/// and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aperture {
    /// Smallest x, y, z.
    pub min: [f64; 3],
    /// Largest x, y, z.
    pub max: [f64; 3],
}

/// The sides that light comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// From the room (+Z): Reflection Back and Transmission Back.
    Front,
    /// From outside (−Z): Reflection Front and Transmission Front.
    Back,
    /// All four components.
    #[default]
    Both,
}

impl Sides {
    pub(crate) fn iter(self) -> impl Iterator<Item = Side> {
        let sides: &[Side] = match self {
            Sides::Front => &[Side::Front],
            Sides::Back => &[Side::Back],
            Sides::Both => &[Side::Front, Side::Back],
        };
        sides.iter().copied()
    }
}

/// Everything that a generation depends on besides the device.
#[derive(Clone, Debug)]
pub struct Options {
    /// Tree of which rank and resolution, or Klems basis.
    pub layout: Layout,
    /// Paths per incident cell and side, at most.
    pub samples: u64,
    /// Ends earlier, when the estimated error is this small: Σ|error| / Σ BSDF over all cells, and `direction_tolerance` is kept too.
    pub tolerance: Option<f64>,
    /// Wrong light tolerated in the hemispherical reflectance or transmittance of any one incident direction, relative to
    /// it, or to 0.1 if it is less. Leaves are kept small enough for it.
    pub direction_tolerance: f64,
    /// How small differences are kept, relative to the mean BSDF, where they are as large as a cell of a 2⁵ tree (smaller ones have to
    /// be stronger); by default 0.1, or twice the tolerance if that is less.
    pub detail: Option<f64>,
    /// Ends earlier, when this time is over.
    pub time_budget: Option<Duration>,
    /// Whether paths start from evenly spread points, or else from independent ones.
    pub stratified: bool,
    /// The sides that light comes from.
    pub sides: Sides,
    /// Whether to keep colour, of the visible band.
    pub color: bool,
    /// What light is counted, each as a band of its own in the file.
    pub bands: Vec<Band>,
    /// Whether colours of materials are what they are in the one band that is asked for, not in the visible range. Spectra, where there are
    /// any, are spectra all the same.
    pub own_band: bool,
    /// Whether to average pairs travelled one way with the same pairs travelled the other way; by default, where both must be equal (not
    /// for rank 3): all materials are reciprocal, and the device repeats or is flat, so that no light leaves by its sides.
    pub reciprocity: Option<bool>,
    /// Whether light that is diffused is followed to and from patches of surface, and only corrected by full paths; rank-4
    /// trees only.
    pub reuse: bool,
    /// Whether to merge cells that differ only by noise; trees only.
    pub pruned: bool,
    /// The device's box; its bounding box by default.
    pub aperture: Option<Aperture>,
    /// Whether the device repeats for ever, with the aperture as its period (by default, the period it knows of itself).
    pub tile: bool,
    /// Unit of length in the file's header.
    pub unit: LengthUnit,
    /// Whether to put the device's geometry into the file, as MGF in that unit.
    pub geometry: bool,
    /// Equal seeds give equal bits, whatever the number of threads.
    pub seed: u64,
    /// Number of threads; all processors by default.
    pub threads: Option<usize>,
    /// A directory, new or empty at first, that keeps what was counted, so that a generation that was interrupted goes on where it
    /// was, and one that is done goes on to more `samples`.
    pub checkpoint: Option<PathBuf>,
}

impl Options {
    /// 2000 paths per incident cell from both sides, grey, pruned, over the bounding box.
    pub fn new(layout: Layout) -> Options {
        Options {
            layout,
            samples: 2000,
            tolerance: None,
            direction_tolerance: 0.05,
            detail: None,
            time_budget: None,
            stratified: true,
            sides: Sides::Both,
            color: false,
            bands: vec![Band::visible()],
            own_band: false,
            reciprocity: None,
            reuse: true,
            pruned: true,
            aperture: None,
            tile: false,
            unit: LengthUnit::Meter,
            geometry: false,
            seed: 0,
            threads: None,
            checkpoint: None,
        }
    }

    pub(crate) fn detail(&self) -> f64 {
        self.detail.unwrap_or_else(|| self.tolerance.map_or(DETAIL, |tolerance| DETAIL.min(2.0 * tolerance)))
    }

    /// Says what is wrong with the options, if anything is.
    pub(crate) fn problem(&self) -> Option<String> {
        if self.samples == 0 || self.samples > u64::from(u32::MAX) {
            return Some(format!("{} samples per incident cell; expected 1 to 4294967295", self.samples));
        }
        if let Some(detail) = self.detail.filter(|d| !(d.is_finite() && *d >= 0.0)) {
            return Some(format!("a detail of {detail}; expected 0 or more, e.g. 0.1"));
        }
        for (name, value) in
            [("tolerance", self.tolerance), ("tolerance of directions", Some(self.direction_tolerance))]
        {
            if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
                return Some(format!("a {name} of {value}; expected a number above 0, e.g. 0.05 for 5 %"));
            }
        }
        if self.bands.is_empty() || (self.own_band && self.bands.len() > 1) {
            return Some(format!(
                "{} bands; expected one or more, and one if it is the materials' own",
                self.bands.len()
            ));
        }
        for (k, band) in self.bands.iter().enumerate() {
            if self.bands[..k].iter().any(|other| other.name().eq_ignore_ascii_case(band.name())) {
                return Some(format!("two bands named {}; give each once", band.name()));
            }
        }
        if self.threads == Some(0) {
            return Some("0 threads; expected at least 1".into());
        }
        if let Layout::Tree { rank, log2_res } = &self.layout {
            if !(1..=MAX_LOG2_RES).contains(log2_res) {
                return Some(format!(
                    "a resolution of 2^{log2_res} per axis; expected 2^1 to 2^{MAX_LOG2_RES}"
                ));
            }
            if self.reciprocity == Some(true) && *rank == bsdftree::Rank::Three {
                return Some(
                    "reciprocity averaging of rank-3 trees; it is done for rank 4 and Klems bases".into(),
                );
            }
        }
        if let Some(aperture) = &self.aperture {
            let extents = [0, 1, 2].map(|k| aperture.max[k] - aperture.min[k]);
            if !extents.iter().all(|e| e.is_finite())
                || extents[0] <= 0.0
                || extents[1] <= 0.0
                || extents[2] < 0.0
            {
                return Some(format!(
                    "an aperture from {:?} to {:?} m; expected min < max",
                    aperture.min, aperture.max
                ));
            }
        }
        None
    }
}
