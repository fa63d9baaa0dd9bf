//! A compiled formula: what the [`super::machine`] runs.

use super::builtin::Builtin;
use super::error::CalError;
use super::inputs::Uses;
use crate::error::Place;
use std::sync::Arc;

/// One operation. Values are on a stack; arguments of functions are passed beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Op {
    Number(f64),
    Channel(u32),
    /// The value of a parameter of the present function.
    Parameter(u16),
    Variable(u32),
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Maximum,
    Minimum,
    /// A library function of numbers, with exactly as many as it needs.
    Library(Builtin),
    /// `arg(n)`
    RealArgument,
    /// Takes a value, goes on there unless it is above 0.
    Branch(u32),
    Jump(u32),
    /// Takes a value, goes on at one of the `n` jumps that follow; what is out of range goes to `end` with its result.
    Select {
        n: u16,
        end: u32,
    },
    PassNumber(f64),
    PassValue,
    PassParameter(u16),
    PassName(u32),
    /// Passes code that is run when the value is first needed.
    PassLazy(u32),
    Call {
        function: u32,
        n: u16,
    },
    CallParameter {
        parameter: u16,
        n: u16,
    },
    Return,
    /// Stops with this problem.
    Fail(u32),
}

/// Code and what it refers to by number.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Program {
    pub code: Vec<Op>,
    pub entries: Vec<Entry>,
    pub variables: Vec<Named>,
    pub variable_uses: Vec<Uses>,
    pub functions: Vec<Named>,
    pub names: Vec<PassedName>,
    pub problems: Vec<CalError>,
    /// Places of operations that can fail, in the order of the code.
    pub places: Vec<(u32, Place)>,
    /// Whether it is incomplete because it would have become too large.
    pub is_cut: bool,
}

/// Where a formula begins, and what it depends on.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Entry {
    pub pc: u32,
    pub uses: Uses,
    /// Its value, if it depends on nothing and has one.
    pub constant: Option<f64>,
}

/// A variable or a function.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Named {
    pub pc: u32,
    pub name: Arc<str>,
    pub at: Place,
}

/// A name that is passed as an argument.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PassedName {
    /// Code of its value as a variable.
    pub value_pc: u32,
    /// The function that it names, if it has a definition.
    pub function: Option<u32>,
    pub builtin: Option<Builtin>,
    /// For a library function: by number of arguments, in rising order, the function that calls it.
    pub by_count: Vec<(u16, u32)>,
    /// What to say if it is called and is no function.
    pub undefined: CalError,
}

impl Program {
    /// The place of an operation that can fail.
    pub(super) fn place(&self, pc: u32) -> Option<&Place> {
        self.places.binary_search_by_key(&pc, |(pc, _)| *pc).ok().map(|at| &self.places[at].1)
    }
}
