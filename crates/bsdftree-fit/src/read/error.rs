//! What can be wrong with a file of measurements: the fault, and the line, row or byte where it is.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A file that was refused: which one, where, and why.
#[derive(Debug, Error)]
pub struct ReadError {
    /// The file, if it was named.
    pub path: Option<PathBuf>,
    /// Where in it.
    pub place: Place,
    /// What is wrong.
    pub fault: Fault,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The whole of it.
    File,
    /// A line, from 1.
    Line(usize),
    /// Bytes before it.
    Byte(u64),
    /// A cell of a sheet, as spreadsheets name it: `C7`.
    Cell {
        /// The sheet.
        sheet: String,
        /// From 0.
        row: usize,
        /// From 0.
        column: usize,
    },
}

/// What is wrong.
#[derive(Debug, Error)]
pub enum Fault {
    /// The file system refused.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// Not what must be there. What is expected may go on to say what to do.
    #[error("found {found}; expected {expected}")]
    Unexpected {
        /// What is there.
        found: String,
        /// What must be.
        expected: String,
    },
}

impl ReadError {
    /// Something else than what must be there.
    pub(crate) fn new(place: Place, found: impl Into<String>, expected: impl Into<String>) -> ReadError {
        let fault = Fault::Unexpected { found: shortened(&found.into()), expected: expected.into() };
        ReadError { path: None, place, fault }
    }

    /// In a line, from 1.
    pub(crate) fn line(line: usize, found: impl Into<String>, expected: impl Into<String>) -> ReadError {
        ReadError::new(Place::Line(line), found, expected)
    }

    /// Of the file as a whole.
    pub(crate) fn file(found: impl Into<String>, expected: impl Into<String>) -> ReadError {
        ReadError::new(Place::File, found, expected)
    }

    /// After so many bytes.
    pub(crate) fn byte(byte: usize, found: impl Into<String>, expected: impl Into<String>) -> ReadError {
        ReadError::new(Place::Byte(byte as u64), found, expected)
    }

    pub(crate) fn in_file(mut self, path: &Path) -> ReadError {
        self.path.get_or_insert_with(|| path.to_owned());
        self
    }

    /// What the file system said, if it refused.
    pub fn io(&self) -> Option<&io::Error> {
        match &self.fault {
            Fault::Io(error) => Some(error),
            Fault::Unexpected { .. } => None,
        }
    }
}

impl From<io::Error> for ReadError {
    fn from(error: io::Error) -> ReadError {
        ReadError { path: None, place: Place::File, fault: error.into() }
    }
}

/// Lines of files may have any length.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 160;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// The letters of a spreadsheet's column, from 0: A, B, … Z, AA, …
fn column_letters(mut column: usize) -> String {
    let mut letters = Vec::new();
    loop {
        letters.insert(0, char::from(b'A' + (column % 26) as u8));
        match column / 26 {
            0 => return letters.into_iter().collect(),
            more => column = more - 1,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File => Ok(()),
            Place::Line(line) => write!(f, "line {line}"),
            Place::Byte(byte) => write!(f, "byte {byte}"),
            Place::Cell { sheet, row, column } => {
                write!(f, "sheet {sheet:?}, cell {}{}", column_letters(*column), row + 1)
            }
        }
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}: ", path.display())?;
        }
        if self.place != Place::File {
            write!(f, "{}: ", self.place)?;
        }
        self.fault.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_named_as_in_spreadsheets() {
        let names = [0, 25, 26, 51, 52, 701, 702].map(column_letters);
        assert_eq!(names, ["A", "Z", "AA", "AZ", "BA", "ZZ", "AAA"]);
    }
}
