//! Radiance scene files.
//!
//! In: files or text in the format of Radiance's reference manual. Out: a [`Device`] in metres, or the first error
//! with its file and line. Several files are one scene in their order, as for `oconv a.rad b.rad`.
//!
//! No shell is run: commands (`!…`) are understood here, see [`command`] and `generators`, unless the options allow their program to
//! be run; only files that the scene names are read. Deviations from Radiance: a file that is named is looked for beside the file
//! that names it before the directories of `RAYPATH`; materials outside [0, 1] are refused; surfaces of an unsupported
//! modifier are an error, never drawn as something else.
//!
//! Modules in the order in which data flows: [`words`] → [`statement`] ([`types`]) → [`scene`] ([`command`], [`stream`], [`process`], [`xform`],
//! [`transform`], [`files`], [`definition`], [`problem`], [`material`], [`modifier`], [`function_material`], [`optics`], [`mod@field`],
//! [`library`]) →
//! [`collect`] ([`shape`]); back to text: [`mod@write`], [`write_material`].

mod collect;
mod command;
mod definition;
mod exchange;
mod field;
mod files;
mod function_material;
mod library;
mod material;
mod modifier;
mod optics;
mod place_mesh;
mod problem;
mod process;
mod scene;
pub(crate) mod shape;
mod spectral;
mod statement;
mod stream;
mod text;
mod transform;
mod types;
mod words;
mod write;
mod write_material;
mod xform;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

pub(crate) use collect::{Collection, overflow, too_large};
pub(crate) use command::command_word;
pub(crate) use files::read as read_text;
#[cfg(test)]
pub(crate) use statement::parse as parse_statements;
pub(crate) use statement::{Content, Primitive, Statement, quoted, real};
pub(crate) use transform::{Steps, Transform, Wrong};
pub(crate) use types::is_surface;

use files::Source;
use scene::{Placement, Scene};

use crate::device::Device;
use crate::error::DeviceError;
use crate::mesh::Format;
use crate::options::ReadOptions;

/// A scene that has read the materials of its options, and the placement of what comes next.
fn begun(options: ReadOptions) -> Result<(Scene, Placement), DeviceError> {
    let placement = Placement::scaled(options.unit.meters());
    let materials = options.materials.files.clone();
    let mut scene = Scene::new(options);
    for path in &materials {
        scene.file(path, &placement)?;
    }
    Ok((scene, placement))
}

impl Device {
    /// Reads files of any format, in their order one scene, as the options (or just a [`Unit`](crate::Unit)) say.
    ///
    /// The ending of a name tells the format: `.obj`, `.ply`, `.stl` and `.rtm` (Radiance's compiled mesh) are triangle
    /// meshes, `.oct` is an octree of Radiance, all others are Radiance scenes. What a mesh is made of, it only names: the files of
    /// materials of the options and the scenes before it define it, see [`MaterialMap`](crate::options::MaterialMap). MGF is read by
    /// [`Device::read_mgf`].
    ///
    /// # Errors
    /// As [`Device::read_rad`]; meshes whose materials are not defined.
    ///
    /// ```
    /// use bsdftree_device::{Device, ReadOptions, options::MaterialMap};
    /// let folder = std::env::temp_dir().join(format!("bsdftree-doc-{}", std::process::id()));
    /// std::fs::create_dir_all(&folder)?;
    /// std::fs::write(folder.join("white.mat"), "void plastic white 0 0 5 .8 .8 .8 0 0")?;
    /// std::fs::write(folder.join("tile.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl Paint\nf 1 2 3 4\n")?;
    /// let names = [("Paint".to_owned(), "white".to_owned())].into();
    /// let materials = MaterialMap { files: vec![folder.join("white.mat")], names, default: None };
    /// let device = Device::read(&[folder.join("tile.obj")], ReadOptions { materials, ..ReadOptions::default() })?;
    /// assert_eq!(device.surfaces[0].shape.area(), 1.0);
    /// assert_eq!(device.materials[0].name, "white");
    /// # std::fs::remove_dir_all(&folder)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn read(paths: &[PathBuf], options: impl Into<ReadOptions>) -> Result<Device, DeviceError> {
        let (mut scene, placement) = begun(options.into())?;
        for path in paths {
            let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
            match Format::of(path) {
                Some(format) => scene.mesh_file(path, format, &placement)?,
                None if ending.is_some_and(|ending| ending == "oct") => {
                    scene.octree_file(path, &placement)?
                }
                None => scene.file(path, &placement)?,
            }
        }
        Ok(scene.into_device())
    }

    /// Reads one triangle mesh; see [`Device::read`].
    ///
    /// # Errors
    /// As [`Device::read`].
    pub fn read_mesh(path: &Path, options: impl Into<ReadOptions>) -> Result<Device, DeviceError> {
        Device::read(&[path.to_owned()], options)
    }

    /// Reads the bytes of a triangle mesh; the ending of `name`, which stands for the file in messages, tells the format.
    ///
    /// # Errors
    /// As [`Device::read`].
    pub fn parse_mesh(
        bytes: &[u8],
        name: &str,
        options: impl Into<ReadOptions>,
    ) -> Result<Device, DeviceError> {
        let (mut scene, placement) = begun(options.into())?;
        let path = Path::new(name);
        let format = Format::of(path).ok_or_else(|| DeviceError::File {
            path: path.to_owned(),
            named_at: None,
            reason: "its name does not end in .obj, .ply, .stl or .rtm".to_owned(),
        })?;
        scene.mesh_bytes(bytes, path, format, &placement)?;
        Ok(scene.into_device())
    }

    /// Reads Radiance scene files, in their order one scene, as the options (or just a [`Unit`](crate::Unit)) say.
    ///
    /// Files that they name by `!xform` are looked for beside the naming file, then in the directories of the
    /// environment variable `RAYPATH`, unless the options name others.
    ///
    /// # Errors
    /// [`DeviceError`] with file, line, what was found and what was expected: text that is not Radiance's format,
    /// features that are not supported, files that cannot be read, circles of files, and scenes that pass the limits of the
    /// options.
    pub fn read_rad(paths: &[PathBuf], options: impl Into<ReadOptions>) -> Result<Device, DeviceError> {
        let options = options.into();
        let placement = Placement::scaled(options.unit.meters());
        let mut scene = Scene::new(options);
        for path in paths {
            scene.file(path, &placement)?;
        }
        Ok(scene.into_device())
    }

    /// Reads the text of a Radiance scene, as the options (or just a [`Unit`](crate::Unit)) say.
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
    pub fn parse_rad(
        text: &str,
        name: &str,
        directory: &Path,
        options: impl Into<ReadOptions>,
    ) -> Result<Device, DeviceError> {
        let (mut scene, placement) = begun(options.into())?;
        let source = Source::of(text, name, directory.to_owned())?;
        scene.source(&source, directory, &placement)?;
        Ok(scene.into_device())
    }
}
