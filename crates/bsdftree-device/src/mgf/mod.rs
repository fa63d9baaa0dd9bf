//! MGF, the Materials and Geometry Format, in and out.
//!
//! In: files or text of MGF 2, as Radiance's mgf2rad understands it: a [`Device`] comes of it, or the first error with its file and line.
//! Out: a device as MGF text, as rad2mgf gives it, and what MGF could not say of it. This is the language of the geometry inside BSDF
//! files, from which a device can be made again ([`Device::read_bsdf_geometry`]).
//!
//! Luminaires (`ies`) are refused, unknown entities are told and left out. Included files are looked for beside the file that
//! names them; the geometry inside a BSDF file may not name any. Deviations from mgf2rad are listed where they are:
//! [`scene`] (includes), [`piece`] (holes, normals, tori), [`material`], [`color`], [`entity`] (names).
//!
//! Modules in the order in which data flows: [`source`] → [`entity`] → [`context`]; colours and materials: [`observer`] → [`color`] →
//! [`palette`] → [`finish`] → [`mod@material`] ([`formula`], [`sides`]); surfaces: [`piece`] → [`geometry`], [`frame`] → [`place`]; all together in [`scene`]; back to
//! text: [`mod@write`] with `write_material`.

pub(crate) mod color;
mod context;
mod entity;
mod finish;
mod formula;
mod frame;
mod geometry;
mod material;
mod observer;
mod palette;
mod piece;
mod place;
mod scene;
mod sides;
mod source;
mod write;
mod write_material;

pub use write::Mgf;

use std::path::{Path, PathBuf};

use bsdftree::bsdf::{Geometry, LengthUnit};
use bsdftree::file;
use bsdftree::xml::Strictness;

use crate::device::Device;
use crate::error::DeviceError;
use crate::options::ReadOptions;
use scene::Scene;
use source::Source;

impl Device {
    /// Reads MGF files, in their order one scene, as the options (or just a [`Unit`](crate::Unit)) say.
    ///
    /// # Errors
    /// [`DeviceError`] with file, line, what was found and what was expected: text that is not MGF, luminaires, files that cannot
    /// be read, circles of files, and scenes that pass the limits of the options.
    pub fn read_mgf(paths: &[PathBuf], options: impl Into<ReadOptions>) -> Result<Device, DeviceError> {
        let mut scene = Scene::new(options.into());
        for path in paths {
            scene.file(path)?;
        }
        Ok(scene.into_device())
    }

    /// Reads MGF text, as the options (or just a [`Unit`](crate::Unit)) say.
    ///
    /// `name` stands for the file in messages; files that the text includes are looked for in `directory`.
    ///
    /// # Errors
    /// As [`Device::read_mgf`].
    ///
    /// ```
    /// use bsdftree_device::{Device, Unit};
    /// let text = "m white =\n rd .8\nv o =\n p 0 0 0\n n 0 0 1\nring o 0 2";
    /// let device = Device::parse_mgf(text, "disk.mgf", ".".as_ref(), Unit::Inch)?;
    /// assert_eq!(device.bounds().unwrap()[1].x, 0.0508);
    /// let error = Device::parse_mgf("ring o 0 2", "bad.mgf", ".".as_ref(), Unit::Inch).unwrap_err();
    /// assert!(error.to_string().starts_with("bad.mgf:1: vertex 'o' is not defined"));
    /// # Ok::<(), bsdftree_device::DeviceError>(())
    /// ```
    pub fn parse_mgf(
        text: &str,
        name: &str,
        directory: &Path,
        options: impl Into<ReadOptions>,
    ) -> Result<Device, DeviceError> {
        parse(text, name, Some(directory.to_owned()), options.into())
    }

    /// The device that a BSDF file says it is of, if it does. Its unit is the file's own, whatever the options say.
    ///
    /// # Errors
    /// As [`Device::read_mgf`], and if it includes files.
    pub fn from_bsdf_geometry(
        geometry: &Geometry,
        options: impl Into<ReadOptions>,
    ) -> Result<Device, DeviceError> {
        let options = ReadOptions { unit: geometry.unit.into(), ..options.into() };
        parse(&geometry.mgf, "geometry of the BSDF", None, options)
    }

    /// The geometry as a BSDF file holds it, with this point \[m\] of the device at x = y = 0, as genBSDF puts it; and what MGF
    /// does not say of the device, one sentence each.
    ///
    /// ```
    /// use bsdftree_device::Device;
    /// let blinds = Device::from_spec("blinds")?;
    /// let (geometry, losses) = blinds.to_bsdf_geometry(bsdftree::LengthUnit::Inch, [0.1, 0.0]);
    /// assert!(losses.is_empty());
    /// let again = Device::from_bsdf_geometry(&geometry, bsdftree_device::ReadOptions::default())?;
    /// assert!((again.bounds().unwrap()[0].x - (blinds.bounds().unwrap()[0].x - 0.1)).abs() < 1e-12);
    /// # Ok::<(), bsdftree_device::DeviceError>(())
    /// ```
    pub fn to_bsdf_geometry(&self, unit: LengthUnit, [x, y]: [f64; 2]) -> (Geometry, Vec<String>) {
        let Mgf { text, losses } = self.to_mgf(unit.into());
        let [x, y] = [x, y].map(|length| -length / unit.meters());
        (Geometry { mgf: format!("xf -t {x:?} {y:?} 0\n{text}xf\n"), unit }, losses)
    }

    /// Reads the device inside a BSDF file; `None` if there is none.
    ///
    /// # Errors
    /// As [`Device::from_bsdf_geometry`], and if the file is not a BSDF. What can be repaired in it does not matter here.
    pub fn read_bsdf_geometry(
        path: &Path,
        options: impl Into<ReadOptions>,
    ) -> Result<Option<Device>, DeviceError> {
        let wrong = |reason: String| DeviceError::File { path: path.to_owned(), named_at: None, reason };
        let (bsdf, _) = file::read(path, Strictness::Repair).map_err(|e| wrong(e.to_string()))?;
        bsdf.header.geometry.map(|geometry| Device::from_bsdf_geometry(&geometry, options)).transpose()
    }
}

fn parse(
    text: &str,
    name: &str,
    directory: Option<PathBuf>,
    options: ReadOptions,
) -> Result<Device, DeviceError> {
    let mut scene = Scene::new(options);
    scene.top(&Source::of(text, name, directory))?;
    Ok(scene.into_device())
}
