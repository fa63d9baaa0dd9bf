//! The one rule of leniency: whatever would be lost or reinterpreted is refused by a strict reader and listed by a
//! repairing one.

use std::fmt;

use super::error::{Fault, XmlError};
use super::source::Source;

/// What to do with a file that says something that would be lost or reinterpreted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strictness {
    /// Refuse it.
    #[default]
    Strict,
    /// Read what can be read, and list what was done.
    Repair,
}

/// How much an entry of the list matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Something legal that is no part of a BSDF and is not kept.
    Note,
    /// Something wrong that was put right; a strict reader refuses it.
    Repair,
}

/// One thing that was noted or repaired.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repair {
    /// Bytes before the place.
    pub offset: u64,
    /// Its line, counted from 1.
    pub line: u64,
    /// Note or repair.
    pub severity: Severity,
    /// What was found and what was done about it.
    pub what: String,
}

impl fmt::Display for Repair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, byte {}: {}", self.line, self.offset, self.what)
    }
}

/// The list being made.
pub(super) struct Repairs {
    strictness: Strictness,
    found: Vec<Repair>,
}

impl Repairs {
    pub(super) fn new(strictness: Strictness) -> Repairs {
        Repairs { strictness, found: Vec::new() }
    }

    /// Something that a strict reader refuses; `remedy` says what happens to it otherwise, as in “it taken as 0”.
    pub(super) fn repair(
        &mut self,
        offset: usize,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Result<(), XmlError> {
        let (found, remedy) = (found.into(), remedy.into());
        if self.strictness == Strictness::Strict {
            return Err(XmlError::new(offset, Fault::Lossy { found, remedy }));
        }
        self.push(offset, Severity::Repair, format!("{found}: {remedy}"));
        Ok(())
    }

    /// Something legal that is not kept.
    pub(super) fn note(&mut self, offset: usize, what: impl Into<String>) {
        self.push(offset, Severity::Note, what.into());
    }

    fn push(&mut self, offset: usize, severity: Severity, what: String) {
        self.found.push(Repair { offset: offset as u64, line: 1, severity, what });
    }

    /// The list in the order of the file, with lines.
    pub(super) fn located(mut self, source: &Source<'_>) -> Vec<Repair> {
        self.found.sort_by_key(|repair| repair.offset);
        let offsets: Vec<usize> = self.found.iter().map(|repair| repair.offset as usize).collect();
        for (repair, place) in self.found.iter_mut().zip(source.places(&offsets)) {
            (repair.offset, repair.line) = place;
        }
        self.found
    }
}
