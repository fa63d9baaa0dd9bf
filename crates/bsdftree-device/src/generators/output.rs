//! Statements as a generator makes them, counted.

use glam::DVec3;

use crate::error::{DeviceError, Place};
use crate::rad::{Statement, too_large};

/// What a command may have too many of.
pub(super) enum TooMany {
    Statements,
    Operations,
}

impl TooMany {
    pub fn error(self, at: &Place, limit: u64) -> DeviceError {
        let what = match self {
            TooMany::Statements => "statements that a command makes",
            TooMany::Operations => "operations in the formulas of a command",
        };
        too_large(at, what, limit)
    }
}

/// Statements made so far.
pub(super) struct Output<'a> {
    statements: Vec<Statement>,
    place: &'a Place,
    limit: u64,
}

impl<'a> Output<'a> {
    pub fn new(place: &'a Place, limit: u64) -> Self {
        Output { statements: Vec::new(), place, limit }
    }

    pub fn into_statements(self) -> Vec<Statement> {
        self.statements
    }

    /// Fails now if this many statements more would be too many.
    pub fn expect(&self, more: u64) -> Result<(), DeviceError> {
        if (self.statements.len() as u64).saturating_add(more) > self.limit {
            return Err(TooMany::Statements.error(self.place, self.limit));
        }
        Ok(())
    }

    pub fn primitive(
        &mut self,
        modifier: &str,
        kind: &str,
        name: String,
        strings: &[&str],
        reals: Vec<f64>,
    ) -> Result<(), DeviceError> {
        self.expect(1)?;
        self.statements.push(Statement::made(self.place.line, modifier, kind, name, strings, reals));
        Ok(())
    }

    /// A primitive without string arguments.
    pub fn shape(
        &mut self,
        modifier: &str,
        kind: &str,
        name: String,
        reals: Vec<f64>,
    ) -> Result<(), DeviceError> {
        self.primitive(modifier, kind, name, &[], reals)
    }

    pub fn polygon(
        &mut self,
        modifier: &str,
        name: String,
        vertices: impl IntoIterator<Item = DVec3>,
    ) -> Result<(), DeviceError> {
        self.shape(modifier, "polygon", name, vertices.into_iter().flat_map(|v| v.to_array()).collect())
    }

    pub fn sphere(
        &mut self,
        modifier: &str,
        name: String,
        center: DVec3,
        radius: f64,
    ) -> Result<(), DeviceError> {
        self.shape(modifier, "sphere", name, [&center.to_array()[..], &[radius]].concat())
    }

    pub fn cylinder(
        &mut self,
        modifier: &str,
        name: String,
        [a, b]: [DVec3; 2],
        radius: f64,
    ) -> Result<(), DeviceError> {
        self.shape(modifier, "cylinder", name, [&a.to_array()[..], &b.to_array(), &[radius]].concat())
    }
}
