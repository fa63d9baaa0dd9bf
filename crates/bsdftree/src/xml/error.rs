//! What can be wrong with a file: the fault, and where it is.

use std::fmt;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::source::Source;
use crate::tree::TreeError;

/// A file that was refused: which one, where, and why.
#[derive(Debug, Error)]
pub struct XmlError {
    /// The file, if it was read by name.
    pub path: Option<PathBuf>,
    /// Bytes before the place of the fault.
    pub offset: u64,
    /// Line of that place, counted from 1.
    pub line: u64,
    /// What is wrong.
    pub fault: Fault,
}

/// What is wrong: what was found, what was expected, and what to do.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum Fault {
    #[error("cannot be read: {0}")]
    Unreadable(std::io::Error),

    #[error("the file is empty; expected a BSDF in XML, so copy or generate it again")]
    Empty,

    #[error("found {0}; expected XML text in UTF-8, so check that this is a BSDF file and convert it")]
    NotText(&'static str),

    #[error("not well-formed XML: {0}; correct the markup here")]
    Syntax(String),

    #[error("the file ends inside <{element}>; it is truncated, so copy or generate it again")]
    Truncated { element: String },

    #[error("more than {limit} {what}; no BSDF file needs that, so check where this file comes from")]
    Limit { what: &'static str, limit: usize },

    #[error("the document type declares entities; they are never expanded, so delete the DOCTYPE")]
    Entities,

    #[error("<{parent}> has no <{element}>; {advice}")]
    Missing { parent: String, element: &'static str, advice: &'static str },

    #[error("{what} is `{found}`; expected {expected}")]
    Unexpected { what: &'static str, found: String, expected: String },

    #[error("found `{found}` where a number is expected: {problem}; correct or remove it")]
    BadNumber { found: String, problem: &'static str },

    #[error("found {found}; expected {expected}, so the data is incomplete or of another kind than declared")]
    WrongCount { found: String, expected: String },

    #[error("found {found}; expected {expected}, so check the braces before this place")]
    Brace { found: String, expected: &'static str },

    #[error("{0}")]
    Tree(TreeError),

    #[error("angle basis `{name}`: {problem}; correct its AngleBasisBlocks")]
    Basis { name: String, problem: String },

    #[error("{found}; read it in repair mode to have {remedy}")]
    Lossy { found: String, remedy: String },
}

impl XmlError {
    /// A fault at a byte of the text; the line is found later.
    pub(super) fn new(offset: usize, fault: Fault) -> XmlError {
        XmlError { path: None, offset: offset as u64, line: 1, fault }
    }

    pub(super) fn located(mut self, source: &Source<'_>) -> XmlError {
        (self.offset, self.line) = source.place(self.offset as usize);
        self
    }

    pub(crate) fn in_file(mut self, path: &Path) -> XmlError {
        self.path = Some(path.to_owned());
        self
    }
}

impl fmt::Display for XmlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}: ", path.display())?;
        }
        if !matches!(self.fault, Fault::Unreadable(_)) {
            write!(f, "line {}, byte {}: ", self.line, self.offset)?;
        }
        self.fault.fmt(f)
    }
}

/// The beginning of a text, short enough for a message.
pub(super) fn excerpt(text: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = text.trim_ascii();
    let shown = String::from_utf8_lossy(&text[..text.len().min(LONGEST)]).escape_debug().to_string();
    if text.len() > LONGEST { shown + "…" } else { shown }
}
