//! `BSDF` and `aBSDF`: what a file says of how light scatters.
//!
//! Source: Radiance's reference manual ("Materials": BSDF, aBSDF). Deviation: there is no thickness. A surface with a thickness
//! stands for geometry behind it, which is what rays meet first in Radiance too; so the reader makes it
//! [`Material::Void`](super::Material::Void), and says so.

use std::fmt;
use std::sync::Arc;

use bsdftree::file;
use bsdftree::xml::{Severity, Strictness};
use bsdftree::{Band, Bsdf, Lobes, Rank, Scattering, Side};
use glam::DVec3;

use super::Orientation;
use crate::field::File;

/// The band of a file that a device is made of: as in Radiance, the visible one.
const BAND: &str = "Visible";

/// Incident directions along each axis of the square at which totals are checked.
const N_CHECKED: usize = 16;

/// How much more than all light may leave before the user is told: what rounding in a file makes of it.
const EXCESS: f64 = 0.01;

/// A surface that scatters as a file says.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The BSDF. Its front is the surface's.
    pub file: BsdfFile,
    /// Its up direction, as far as it is normal to the surface's normal.
    pub up: Orientation,
    /// Diffuse reflectance of the front, of the back, and transmittance, which add to those of the file.
    pub diffuse: [DVec3; 3],
    /// `aBSDF`: light that the file has in the cells around the straight direction goes straight on.
    pub through: bool,
}

/// A BSDF file that has been read, and one of its bands. Equal if the bytes of the files are, and the bands.
#[derive(Clone)]
pub struct BsdfFile {
    /// Where it was found, and a digest of its bytes.
    pub file: File,
    bsdf: Arc<Bsdf>,
    /// Index of the band.
    band: usize,
}

impl BsdfFile {
    /// The BSDF in the bytes of `file`, and what the user should know: repairs, directions that scatter more light than they
    /// bring.
    ///
    /// # Errors
    /// What makes it unreadable; no visible band.
    pub fn parse(bytes: &[u8], file: File) -> Result<(BsdfFile, Vec<String>), String> {
        let path = &file.path;
        let (bsdf, repairs) =
            file::read_bytes(bytes, Strictness::Repair).map_err(|e| format!("{path}: {e}"))?;
        let repairs = repairs.iter().filter(|repair| repair.severity == Severity::Repair);
        let mut notices: Vec<String> = repairs.map(|repair| format!("{path}: {repair}")).collect();
        let Some(band) = bsdf.bands.iter().position(|band| band.name.eq_ignore_ascii_case(BAND)) else {
            let names: Vec<&str> = bsdf.bands.iter().map(|band| &*band.name).collect();
            let found = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            return Err(format!("{path}: expected data of wavelength {BAND}, found {found}"));
        };
        notices.extend(gain(&bsdf.bands[band]).map(|gain| format!("{path}: {gain}")));
        Ok((BsdfFile { file, bsdf: Arc::new(bsdf), band }, notices))
    }

    /// All that the file holds.
    pub fn bsdf(&self) -> &Arc<Bsdf> {
        &self.bsdf
    }

    /// Index in [`Bsdf::bands`] of the band that light scatters by.
    pub fn band_index(&self) -> usize {
        self.band
    }

    /// The band that light scatters by.
    pub fn band(&self) -> &Band {
        &self.bsdf.bands[self.band]
    }

    /// The same file with another of its bands, by its name in any case; `None` if it has no such band.
    pub fn of_band(&self, name: &str) -> Option<BsdfFile> {
        let band = self.bsdf.bands.iter().position(|band| band.name.eq_ignore_ascii_case(name))?;
        Some(BsdfFile { band, ..self.clone() })
    }

    /// Whether it is the same for all azimuths, so that it needs no up direction.
    pub fn is_isotropic(&self) -> bool {
        let is_rank3 = |s: &Scattering| matches!(s, Scattering::Tree(tree) if tree.rank() == Rank::Three);
        self.band().components().all(|(_, component)| is_rank3(&component.luminance))
    }

    /// Whether it has colours.
    pub fn has_color(&self) -> bool {
        self.band().components().any(|(_, component)| component.chroma.is_some())
    }
}

impl PartialEq for BsdfFile {
    fn eq(&self, other: &Self) -> bool {
        (self.file.digest, self.band) == (other.file.digest, other.band)
    }
}

impl fmt::Debug for BsdfFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} band {}", self.file, self.band)
    }
}

/// What is wrong with the energy of a BSDF, if anything is.
fn gain(band: &Band) -> Option<String> {
    let middle = |k: usize| (k as f64 + 0.5) / N_CHECKED as f64;
    let points = (0..N_CHECKED * N_CHECKED).map(|k| [middle(k % N_CHECKED), middle(k / N_CHECKED)]);
    let directions = points.flat_map(|point| {
        let disk = bsdftree::square::disk_from_square(point);
        [Side::Front, Side::Back].map(|side| side.direction_from_disk(disk))
    });
    let most = directions.map(|incident| band.hemispherical(incident, Lobes::All)).fold(0.0, f64::max);
    (most > 1.0 + EXCESS).then(|| {
        format!(
            "it scatters up to {:.1} % of the light of a direction: so will the device, but for more losses",
            100.0 * most
        )
    })
}
