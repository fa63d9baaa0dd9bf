//! What an evaluation remembers while it runs, and how much that may become.

use super::program::Program;

/// How long and how deep an evaluation may become.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub steps: usize,
    pub depth: usize,
    /// Values and arguments that wait at the same time.
    pub waiting: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { steps: 10_000_000, depth: 50_000, waiting: 1_000_000 }
    }
}

/// Memory of an evaluation, to be used again by the next one, and what that found.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    pub(super) values: Vec<f64>,
    pub(super) arguments: Vec<Argument>,
    pub(super) records: Vec<Record>,
    pub(super) variables: Vec<Variable>,
    pub(super) steps: usize,
    pub(super) faults: u32,
    max_steps: Option<usize>,
}

impl Scratch {
    /// Memory for evaluations that are stopped after so many operations, rather than after ten million.
    pub fn with_max_steps(max_steps: usize) -> Self {
        Scratch { max_steps: Some(max_steps), ..Scratch::default() }
    }

    /// How many results of the last evaluation were not finite and became 0: divisions by 0, roots of negative numbers
    /// and the like. Radiance leaves out a pattern, texture or material whose function had any.
    pub fn faults(&self) -> u32 {
        self.faults
    }

    /// How long and deep an evaluation in this memory may become.
    pub(super) fn limits(&self) -> Limits {
        let limits = Limits::default();
        Limits { steps: self.max_steps.unwrap_or(limits.steps), ..limits }
    }

    /// Operations of the last evaluation.
    pub(crate) fn steps(&self) -> usize {
        self.steps
    }

    /// Passes a number to the function that the next run calls.
    pub(super) fn pass(&mut self, value: f64) {
        self.arguments.push(Argument::Value(value));
    }

    /// Forgets what was before.
    pub(super) fn begin(&mut self, program: &Program) {
        self.values.clear();
        self.arguments.clear();
        self.records.clear();
        self.variables.clear();
        self.variables.resize(program.variables.len(), Variable::Unknown);
        self.faults = 0;
        self.steps = 0;
    }
}

/// What was passed for a parameter.
#[derive(Clone, Copy, Debug)]
pub(super) enum Argument {
    Value(f64),
    /// Code and the record of the call whose parameters it refers to.
    Lazy(u32, u32),
    /// A name, which may be asked for its value or be called.
    Name(u32),
    /// The argument of a caller, not computed yet.
    Same(u32),
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Variable {
    Unknown,
    /// Being computed.
    Pending,
    Known(f64),
}

/// What goes on when the present code returns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    pub what: What,
    /// Where to go on.
    pub pc: u32,
    /// The record of the call whose parameters count there.
    pub outer: u32,
    /// The first argument and the number of arguments of a call.
    pub base: u32,
    pub n: u16,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum What {
    Call(u32),
    /// Keeps the value for the argument at this position.
    Lazy(u32),
    Name,
    Variable(u32),
}
