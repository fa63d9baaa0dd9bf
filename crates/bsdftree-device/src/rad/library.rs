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
use crate::error::Place;
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

/// What has been read.
#[derive(Default)]
pub(super) struct Library {
    functions: HashMap<PathBuf, Result<Rc<Functions>, Rc<Problem>>>,
    data: HashMap<PathBuf, Result<Arc<DataArray>, Rc<Problem>>>,
    pictures: HashMap<PathBuf, Result<Arc<Picture>, Rc<Problem>>>,
    spectral_pictures: HashMap<PathBuf, Result<Arc<SpectralPicture>, Rc<Problem>>>,
    fonts: HashMap<PathBuf, Result<Arc<Font>, Rc<Problem>>>,
    bsdfs: HashMap<PathBuf, Result<Rc<Told<BsdfFile>>, Rc<Problem>>>,
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
            let (text, file) = text(path, LARGEST[0], standing)?;
            let mut context = Context::rayinit();
            context.enter_file(name);
            context.load(&text, &file.path).map_err(|e| problem(standing, &e))?;
            Ok(Rc::new(Functions { context, file }))
        };
        self.functions.entry(path.clone()).or_insert_with(|| read(&path)).clone()
    }

    /// A data file.
    pub(super) fn data(&mut self, name: &str, standing: &Standing) -> Result<Arc<DataArray>, Rc<Problem>> {
        let path = find(name, standing)?;
        let read = |path: &Path| {
            let (text, file) = text(path, LARGEST[1], standing)?;
            DataArray::parse(&text, file).map(Arc::new).map_err(|e| problem(standing, &e))
        };
        self.data.entry(path.clone()).or_insert_with(|| read(&path)).clone()
    }

    /// A picture.
    pub(super) fn picture(&mut self, name: &str, standing: &Standing) -> Result<Arc<Picture>, Rc<Problem>> {
        let path = find(name, standing)?;
        let read = |path: &Path| {
            let (bytes, file) = bytes(path, LARGEST[2], standing)?;
            Picture::parse(&bytes, file).map(Arc::new).map_err(|e| problem(standing, &e))
        };
        self.pictures.entry(path.clone()).or_insert_with(|| read(&path)).clone()
    }

    /// A picture of spectra.
    pub(super) fn spectral_picture(
        &mut self,
        name: &str,
        standing: &Standing,
    ) -> Result<Arc<SpectralPicture>, Rc<Problem>> {
        let path = find(name, standing)?;
        let read = |path: &Path| {
            let (bytes, file) = bytes(path, LARGEST[2], standing)?;
            SpectralPicture::parse(&bytes, file).map(Arc::new).map_err(|e| problem(standing, &e))
        };
        self.spectral_pictures.entry(path.clone()).or_insert_with(|| read(&path)).clone()
    }

    /// A font.
    pub(super) fn font(&mut self, name: &str, standing: &Standing) -> Result<Arc<Font>, Rc<Problem>> {
        let path = find(name, standing)?;
        let read = |path: &Path| {
            let (text, file) = text(path, LARGEST[4], standing)?;
            Font::parse(&text, file).map(Arc::new).map_err(|e| problem(standing, &e))
        };
        self.fonts.entry(path.clone()).or_insert_with(|| read(&path)).clone()
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

fn text(path: &Path, largest: u64, standing: &Standing) -> Result<(String, File), Rc<Problem>> {
    let (bytes, file) = bytes(path, largest, standing)?;
    // Comments may be in any encoding.
    let text =
        String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned());
    Ok((text, file))
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
