//! What can be wrong with a file: the fault, and the byte where it is.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A file that was refused or could not be written: which one, where, and why.
#[derive(Debug, Error)]
pub struct BinaryError {
    /// The file, if it was named.
    pub path: Option<PathBuf>,
    /// Bytes before the place of the fault.
    pub offset: u64,
    /// What is wrong.
    pub fault: BinaryFault,
}

/// What is wrong.
#[derive(Debug, Error)]
pub enum BinaryFault {
    /// The file system refused.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// Not what must be there.
    #[error("found {found}; expected {expected}; {advice}")]
    Unexpected {
        /// What is there.
        found: String,
        /// What must be.
        expected: String,
        /// What to do.
        advice: &'static str,
    },
    /// A BSDF that no file can hold.
    #[error("{0}")]
    Unwritable(String),
}

/// For files that are not as they were written.
pub(super) const COPY_AGAIN: &str = "the file is damaged, so copy or make it again";

impl BinaryError {
    pub(super) fn unexpected(
        offset: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
        advice: &'static str,
    ) -> BinaryError {
        let fault = BinaryFault::Unexpected { found: found.into(), expected: expected.into(), advice };
        BinaryError { path: None, offset: offset as u64, fault }
    }

    /// Not what was written.
    pub(super) fn damaged(
        offset: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> BinaryError {
        BinaryError::unexpected(offset, found, expected, COPY_AGAIN)
    }

    pub(crate) fn in_file(mut self, path: &Path) -> BinaryError {
        self.path = Some(path.to_owned());
        self
    }
}

impl From<io::Error> for BinaryError {
    fn from(error: io::Error) -> BinaryError {
        BinaryError { path: None, offset: 0, fault: error.into() }
    }
}

impl fmt::Display for BinaryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}: ", path.display())?;
        }
        if matches!(self.fault, BinaryFault::Unexpected { .. }) {
            write!(f, "byte {}: ", self.offset)?;
        }
        self.fault.fmt(f)
    }
}
