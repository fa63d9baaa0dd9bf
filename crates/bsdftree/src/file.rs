//! Files of either format: the XML of WINDOW and Radiance, and its binary twin.
//!
//! Read, a file says by its first bytes what it is; written, by the ending of its name: `.bsdft`, or XML.

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use thiserror::Error;

use crate::binary::{self, BinaryError, BinaryFault, Packing};
use crate::bsdf::Bsdf;
use crate::xml::{self, Fault, Repair, Strictness, WriteError, XmlError};

/// A file that was refused.
#[derive(Debug, Error)]
pub enum FileError {
    /// XML, or a file that cannot be read.
    #[error(transparent)]
    Xml(#[from] XmlError),
    /// `.bsdft`.
    #[error(transparent)]
    Binary(#[from] BinaryError),
}

impl FileError {
    /// What the file system said, if it refused.
    pub fn io(&self) -> Option<&io::Error> {
        match self {
            FileError::Xml(XmlError { fault: Fault::Unreadable(error), .. })
            | FileError::Binary(BinaryError { fault: BinaryFault::Io(error), .. }) => Some(error),
            _ => None,
        }
    }
}

/// A file that could not be written.
#[derive(Debug)]
pub enum SaveError {
    /// XML.
    Xml(WriteError),
    /// `.bsdft`.
    Binary(BinaryError),
}

impl fmt::Display for SaveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SaveError::Xml(error) => error.fmt(f),
            SaveError::Binary(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SaveError {}

/// The BSDF in a file, and what was noted or repaired on the way. Raw `.bsdft` files are mapped ([`binary::open`]).
///
/// # Errors
/// As [`xml::read_file`] and [`binary::open`].
pub fn read(path: impl AsRef<Path>, strictness: Strictness) -> Result<(Bsdf, Vec<Repair>), FileError> {
    let path = path.as_ref();
    let mut first = Vec::new();
    let mut is_binary = || -> io::Result<bool> {
        // What is no file can be read only once.
        let file = File::open(path)?;
        Ok(file.metadata()?.is_file() && {
            file.take(8).read_to_end(&mut first)?;
            binary::is_binary(&first)
        })
    };
    if is_binary().unwrap_or(false) {
        return Ok((binary::open(path)?, Vec::new()));
    }
    let bytes = xml::read_bytes(path)?;
    match binary::is_binary(&bytes) {
        true => Ok((binary::read(&bytes).map_err(|error| error.in_file(path))?, Vec::new())),
        false => Ok(xml::read(&bytes, strictness).map_err(|error| error.in_file(path))?),
    }
}

/// As [`read`], from the bytes of a file.
///
/// # Errors
/// As [`xml::read`] and [`binary::read`].
pub fn read_bytes(bytes: &[u8], strictness: Strictness) -> Result<(Bsdf, Vec<Repair>), FileError> {
    match binary::is_binary(bytes) {
        true => Ok((binary::read(bytes)?, Vec::new())),
        false => Ok(xml::read(bytes, strictness)?),
    }
}

/// Writes a file, whole or not at all; one that ends in `.bsdft` as `packing` says, any other as XML.
///
/// # Errors
/// As [`xml::write_file`] and [`binary::write_file`].
pub fn write(bsdf: &Bsdf, path: impl AsRef<Path>, packing: Packing) -> Result<(), SaveError> {
    let path = path.as_ref();
    match is_binary_name(path) {
        true => binary::write_file(bsdf, packing, path).map_err(SaveError::Binary),
        false => xml::write_file(bsdf, path).map_err(SaveError::Xml),
    }
}

/// Whether a file of this name is written in binary.
pub fn is_binary_name(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("bsdft"))
}
