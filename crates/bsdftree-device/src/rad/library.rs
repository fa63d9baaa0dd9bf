//! Function files, data files, pictures and fonts that modifiers name, each read once.
//!
//! In: names as they stand in a scene. Out: what is in the files, or the [`Problem`] that arises if a surface needs it. They are
//! found as scene files are; see [`files`](super::files). Deviation from Radiance: each file is read with
//! the standard names alone before it, so that its names cannot be changed from the global scope or other files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use super::files::{self, Files};
use super::problem::Problem;
use crate::cal::Context;
use crate::error::{DeviceError, Place};
use crate::field::{DataArray, File, Font, Picture, SpectralPicture, digest};
use crate::material::BsdfFile;

/// Largest function file, data file, picture, BSDF and font or text \[byte\].
const LARGEST: [u64; 5] = [16 << 20, 1 << 30, 1 << 30, 4 << 30, 16 << 20];

/// Where a statement stands.
pub(super) struct Standing<'a> {
    /// File and line.
    pub at: &'a Place,
    /// Files it names are looked for here first.
    pub directory: &'a Path,
    /// Where else.
    pub files: &'a Files,
}

/// Definitions of a function file.
pub(super) struct Functions {
    pub context: Context,
    pub file: File,
}

/// What was read, and what the user should know of it.
pub(super) type Told<T> = (T, Vec<String>);

/// What was read from each file, or why it was not.
type Read<T> = HashMap<PathBuf, Result<T, Rc<Problem>>>;

/// What has been read.
#[derive(Default)]
pub(super) struct Library {
    functions: Read<Rc<Functions>>,
    data: Read<Arc<DataArray>>,
    pictures: Read<Arc<Picture>>,
    spectral_pictures: Read<Arc<SpectralPicture>>,
    fonts: Read<Arc<Font>>,
    bsdfs: Read<Rc<Told<BsdfFile>>>,
}

impl Library {
    /// The definitions of a function file; the standard names alone for `.`.
    pub(super) fn functions(
        &mut self,
        name: &str,
        standing: &Standing,
    ) -> Result<Rc<Functions>, Rc<Problem>> {
        if name == "." {
            let file = File { path: ".".into(), digest: 0 };
            return Ok(Rc::new(Functions { context: Context::rayinit(), file }));
        }
        let path = find(name, standing)?;
        let read = |path: &Path| -> Result<_, Rc<Problem>> {
            let (bytes, file) = bytes(path, LARGEST[0], standing)?;
            // Comments may be in any encoding.
            let text = String::from_utf8_lossy(&bytes);
            let mut context = Context::rayinit();
            context.enter_file(name);
            context.load(&text, &file.path).map_err(|e| problem(standing, &e))?;
            Ok(Rc::new(Functions { context, file }))
        };
        self.functions.entry(path.clone()).or_insert_with(|| read(&path)).clone()
    }

    /// A data file.
    pub(super) fn data(&mut self, name: &str, standing: &Standing) -> Result<Arc<DataArray>, Rc<Problem>> {
        let parse = |bytes: &[u8], file| DataArray::parse(&String::from_utf8_lossy(bytes), file);
        known(&mut self.data, name, LARGEST[1], standing, parse)
    }

    /// A picture.
    pub(super) fn picture(&mut self, name: &str, standing: &Standing) -> Result<Arc<Picture>, Rc<Problem>> {
        known(&mut self.pictures, name, LARGEST[2], standing, Picture::parse)
    }

    /// A picture of spectra.
    pub(super) fn spectral_picture(
        &mut self,
        name: &str,
        standing: &Standing,
    ) -> Result<Arc<SpectralPicture>, Rc<Problem>> {
        known(&mut self.spectral_pictures, name, LARGEST[2], standing, SpectralPicture::parse)
    }

    /// A font.
    pub(super) fn font(&mut self, name: &str, standing: &Standing) -> Result<Arc<Font>, Rc<Problem>> {
        let parse = |bytes: &[u8], file| Font::parse(&String::from_utf8_lossy(bytes), file);
        known(&mut self.fonts, name, LARGEST[4], standing, parse)
    }

    /// The bytes of a text file.
    pub(super) fn text(&self, name: &str, standing: &Standing) -> Result<(File, Vec<u8>), Rc<Problem>> {
        let (bytes, file) = bytes(&find(name, standing)?, LARGEST[4], standing)?;
        Ok((file, bytes))
    }

    /// A BSDF.
    pub(super) fn bsdf(
        &mut self,
        name: &str,
        standing: &Standing,
    ) -> Result<Rc<Told<BsdfFile>>, Rc<Problem>> {
        let path = find(name, standing)?;
        let read = |path: &Path| {
            let (bytes, file) = bytes(path, LARGEST[3], standing)?;
            let parsed = BsdfFile::parse(&bytes, file);
            parsed.map(Rc::new).map_err(|reason| Rc::new(Problem::failed(standing.at, reason)))
        };
        self.bsdfs.entry(path.clone()).or_insert_with(|| read(&path)).clone()
    }
}

fn find(name: &str, standing: &Standing) -> Result<PathBuf, Rc<Problem>> {
    let found = standing.files.find(name, standing.directory, standing.at);
    found.map_err(|e| Rc::new(Problem::file(standing.at, e)))
}

/// What is in a file, which is read when it is first named.
fn known<T>(
    files: &mut Read<Arc<T>>,
    name: &str,
    largest: u64,
    standing: &Standing,
    parse: impl FnOnce(&[u8], File) -> Result<T, DeviceError>,
) -> Result<Arc<T>, Rc<Problem>> {
    let path = find(name, standing)?;
    let read = |path: &Path| {
        let (bytes, file) = bytes(path, largest, standing)?;
        parse(&bytes, file).map(Arc::new).map_err(|e| problem(standing, &e))
    };
    files.entry(path.clone()).or_insert_with(|| read(&path)).clone()
}

fn bytes(path: &Path, largest: u64, standing: &Standing) -> Result<(Vec<u8>, File), Rc<Problem>> {
    let bytes = files::read_bytes(path, largest, Some(standing.at));
    let bytes = bytes.map_err(|e| Rc::new(Problem::file(standing.at, e)))?;
    let file = File { path: path.display().to_string().into(), digest: digest(&bytes) };
    Ok((bytes, file))
}

fn problem(standing: &Standing, error: &dyn std::error::Error) -> Rc<Problem> {
    Rc::new(Problem::failed(standing.at, error.to_string()))
}
