//! Scene files: where they are, and what is in them, each read once.
//!
//! In: a name and the directory of the file that names it. Out: its statements. Searched are that directory and then
//! the search folders (by default `RAYPATH`), relative ones from the working directory. Names that begin with `.` or `/` are not
//! looked for in absolute directories of `RAYPATH`, as in Radiance.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use super::statement::{self, Statement};
use crate::error::{DeviceError, Place};

/// A scene file or text, parsed.
pub(super) struct Source {
    /// For messages.
    pub name: Arc<str>,
    /// Where its commands run.
    pub directory: PathBuf,
    pub statements: Vec<Statement>,
}

/// Files read so far.
pub(super) struct Files {
    raypath: Vec<PathBuf>,
    read: HashMap<PathBuf, Rc<Source>>,
}

/// Largest file that is read \[bytes\].
pub(super) const LARGEST: u64 = 1 << 30;

impl Files {
    pub(super) fn new(raypath: Vec<PathBuf>) -> Self {
        Files { raypath, read: HashMap::new() }
    }

    /// Finds a file that is named at a place of a scene.
    pub(super) fn find(&self, name: &str, directory: &Path, at: &Place) -> Result<PathBuf, DeviceError> {
        let anchored = name.starts_with(['.', '/']);
        let relative = self.raypath.iter().filter(|d| !anchored || !d.is_absolute()).map(PathBuf::as_path);
        let mut searched: Vec<&Path> = Vec::new();
        for directory in std::iter::once(directory).chain(relative) {
            let path = directory.join(name);
            if path.is_file() {
                return Ok(path);
            }
            let shown = if directory.as_os_str().is_empty() { Path::new(".") } else { directory };
            if !searched.contains(&shown) {
                searched.push(shown);
            }
        }
        let searched: Vec<_> = searched.iter().map(|d| format!("'{}'", d.display())).collect();
        let reason = format!("no such file, looked for in {}", searched.join(", "));
        Err(DeviceError::File { path: name.into(), named_at: Some(at.clone()), reason })
    }

    /// The statements of a file, and its unambiguous path.
    pub(super) fn open(
        &mut self,
        path: &Path,
        named_at: Option<&Place>,
    ) -> Result<(PathBuf, Rc<Source>), DeviceError> {
        let canonical = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if let Some(source) = self.read.get(&canonical) {
            return Ok((canonical, source.clone()));
        }
        let directory = path.parent().unwrap_or(Path::new("")).to_owned();
        let source = Rc::new(Source::of(&read(path, named_at)?, &path.display().to_string(), directory)?);
        self.read.insert(canonical.clone(), source.clone());
        Ok((canonical, source))
    }
}

impl Source {
    pub(super) fn of(text: &str, name: &str, directory: PathBuf) -> Result<Self, DeviceError> {
        let name: Arc<str> = name.into();
        Ok(Source { statements: statement::parse(text, &name)?, name, directory })
    }
}

/// The text of a file; bytes that are not UTF-8, as in old comments, become replacement characters.
pub(crate) fn read(path: &Path, named_at: Option<&Place>) -> Result<String, DeviceError> {
    let bytes = read_bytes(path, LARGEST, named_at)?;
    Ok(String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned()))
}

/// What is in a file of at most `largest` bytes.
pub(crate) fn read_bytes(
    path: &Path,
    largest: u64,
    named_at: Option<&Place>,
) -> Result<Vec<u8>, DeviceError> {
    let error =
        |reason: String| DeviceError::File { path: path.to_owned(), named_at: named_at.cloned(), reason };
    let metadata = path.metadata().map_err(|e| error(e.to_string()))?;
    if !metadata.is_file() {
        return Err(error("it is not a regular file".to_owned()));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|e| error(e.to_string()))?;
    file.take(largest + 1).read_to_end(&mut bytes).map_err(|e| error(e.to_string()))?;
    if bytes.len() as u64 > largest {
        return Err(error(format!("it is larger than {} MiB", largest >> 20)));
    }
    Ok(bytes)
}
