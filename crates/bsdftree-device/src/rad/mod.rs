//! Radiance scene files.
//!
//! In: files or text in the format of Radiance's reference manual. Out: a [`Device`] in metres, or the first error
//! with its file and line. Several files are one scene in their order, as for `oconv a.rad b.rad`.
//!
//! No shell is run: of the commands (`!…`) only `xform`, `cat` of files and pipes into `xform` are understood, and only
//! files that the scene names are read. Deviations from Radiance: a file that is named is looked for beside the file
//! that names it before the directories of `RAYPATH`; materials outside [0, 1] are refused; surfaces of an unsupported
//! modifier are an error, never drawn as something else.
//!
//! Modules in the order in which data flows: [`words`] → [`statement`] ([`types`]) → [`scene`] ([`command`], [`xform`],
//! [`transform`], [`files`], [`definition`], [`problem`], [`material`]) →
//! [`collect`] ([`shape`]); back to text: [`mod@write`].

mod collect;
mod command;
mod definition;
mod files;
mod material;
mod problem;
mod scene;
mod shape;
mod statement;
mod transform;
mod types;
mod words;
mod write;
mod xform;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use collect::Limits;
use files::{Files, Source};
use scene::{Placement, Scene};

use crate::device::Device;
use crate::error::DeviceError;
use crate::unit::Unit;

impl Device {
    /// Reads Radiance scene files, in their order one scene, whose lengths are in `unit`.
    ///
    /// Files that they name by `!xform` are looked for beside the naming file, then in the directories of the
    /// environment variable `RAYPATH`.
    ///
    /// # Errors
    /// [`DeviceError`] with file, line, what was found and what was expected: text that is not Radiance's format,
    /// features that are not supported, files that cannot be read, circles of files, and scenes of more than 10⁷
    /// surfaces.
    pub fn read_rad(paths: &[PathBuf], unit: Unit) -> Result<Device, DeviceError> {
        let mut scene = Scene::new(Files::new(Files::raypath_of_environment()), Limits::DEFAULT);
        for path in paths {
            scene.file(path, &Placement::scaled(unit.meters()))?;
        }
        Ok(scene.into_device())
    }

    /// Reads the text of a Radiance scene, whose lengths are in `unit`.
    ///
    /// `name` stands for the file in messages; files that the text names are looked for in `directory`, then in the
    /// directories of `RAYPATH`.
    ///
    /// # Errors
    /// As [`Device::read_rad`].
    ///
    /// ```
    /// use bsdftree_device::{Device, Unit};
    /// let text = "void plastic white 0 0 5 .8 .8 .8 0 0   white ring disk 0 0 8  0 0 0  0 0 1  0 2";
    /// let device = Device::parse_rad(text, "disk.rad", ".".as_ref(), Unit::Inch)?;
    /// assert_eq!(device.bounds().unwrap()[1].x, 0.0508);
    /// let error = Device::parse_rad("white ring disk 0 0 0", "bad.rad", ".".as_ref(), Unit::Inch).unwrap_err();
    /// assert!(error.to_string().starts_with("bad.rad:1: "));
    /// # Ok::<(), bsdftree_device::DeviceError>(())
    /// ```
    pub fn parse_rad(text: &str, name: &str, directory: &Path, unit: Unit) -> Result<Device, DeviceError> {
        parse(text, name, directory, unit, Files::raypath_of_environment(), Limits::DEFAULT)
    }
}

fn parse(
    text: &str,
    name: &str,
    directory: &Path,
    unit: Unit,
    raypath: Vec<PathBuf>,
    limits: Limits,
) -> Result<Device, DeviceError> {
    let mut scene = Scene::new(Files::new(raypath), limits);
    let source = Source::of(text, name, directory.to_owned())?;
    scene.source(&source, directory, &Placement::scaled(unit.meters()))?;
    Ok(scene.into_device())
}
