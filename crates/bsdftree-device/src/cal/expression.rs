//! A compiled formula or function, as callers hold it.

use super::error::CalError;
use super::inputs::{Inputs, Uses};
use super::machine;
use super::program::{Entry, Named, Op, Program};
use super::scratch::Scratch;
use std::sync::Arc;

/// A formula, ready to be evaluated by any number of threads.
///
/// Equal if they were compiled from the same formula and definitions.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression(Arc<Program>);

impl Expression {
    pub(super) fn new(program: Program) -> Self {
        Expression(Arc::new(with_constant_entries(program)))
    }

    /// The value.
    ///
    /// # Errors
    /// A name without definition, a missing argument, or an endless recursion, each with its line.
    pub fn evaluate<I: Inputs + ?Sized>(&self, inputs: &I) -> Result<f64, CalError> {
        match self.constant() {
            Some(value) => Ok(value),
            None => self.evaluate_in(inputs, &mut Scratch::default()),
        }
    }

    /// The value, in memory that is used again and then tells of faults: the faster way for many evaluations.
    ///
    /// # Errors
    /// As [`Expression::evaluate`].
    pub fn evaluate_in<I: Inputs + ?Sized>(
        &self,
        inputs: &I,
        scratch: &mut Scratch,
    ) -> Result<f64, CalError> {
        scratch.begin(&self.0);
        entry_value(&self.0, 0, inputs, scratch)
    }

    /// The value, if it is always the same.
    pub fn constant(&self) -> Option<f64> {
        self.0.entries[0].constant
    }

    /// What the value can depend on.
    pub fn uses(&self) -> Uses {
        self.0.entries[0].uses
    }

    /// What would stop an evaluation that came to it: names without definition, calls with too few arguments.
    pub fn problems(&self) -> &[CalError] {
        &self.0.problems
    }
}

/// Several formulas that are evaluated together, so that what they share is computed once.
#[derive(Clone, Debug, PartialEq)]
pub struct Expressions(Arc<Program>);

impl Expressions {
    pub(super) fn new(program: Program) -> Self {
        Expressions(Arc::new(with_constant_entries(program)))
    }

    /// How many there are.
    #[expect(clippy::len_without_is_empty, reason = "it is asked for the length of the output")]
    pub fn len(&self) -> usize {
        self.0.entries.len()
    }

    /// Their values, in their order.
    ///
    /// # Errors
    /// As [`Expression::evaluate`].
    ///
    /// # Panics
    /// If `values` is not as long as there are formulas.
    pub fn evaluate_in<I: Inputs + ?Sized>(
        &self,
        inputs: &I,
        scratch: &mut Scratch,
        values: &mut [f64],
    ) -> Result<(), CalError> {
        assert_eq!(values.len(), self.len(), "one value for each formula");
        scratch.begin(&self.0);
        for (at, value) in values.iter_mut().enumerate() {
            *value = entry_value(&self.0, at, inputs, scratch)?;
        }
        Ok(())
    }

    /// What the values can depend on.
    pub fn uses(&self) -> Uses {
        self.0.entries.iter().fold(Uses::default(), |mut uses, entry| {
            uses.add(entry.uses);
            uses
        })
    }

    /// As [`Expression::problems`].
    pub fn problems(&self) -> &[CalError] {
        &self.0.problems
    }
}

/// A function that is called with numbers, ready to be called by any number of threads.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    program: Arc<Program>,
    n_arguments: usize,
}

impl Function {
    pub(super) fn new(program: Program, n_arguments: usize) -> Self {
        Function { program: Arc::new(with_constant_variables(program)), n_arguments }
    }

    /// With how many arguments it is called.
    pub fn n_arguments(&self) -> usize {
        self.n_arguments
    }

    /// The value for these arguments.
    ///
    /// # Errors
    /// As [`Expression::evaluate`].
    ///
    /// # Panics
    /// If there are not as many arguments as the function was compiled for.
    pub fn call<I: Inputs + ?Sized>(&self, arguments: &[f64], inputs: &I) -> Result<f64, CalError> {
        self.call_in(arguments, inputs, &mut Scratch::default())
    }

    /// The value for these arguments, in memory that is used again and then tells of faults.
    ///
    /// # Errors
    /// As [`Expression::evaluate`].
    ///
    /// # Panics
    /// If there are not as many arguments as the function was compiled for.
    pub fn call_in<I: Inputs + ?Sized>(
        &self,
        arguments: &[f64],
        inputs: &I,
        scratch: &mut Scratch,
    ) -> Result<f64, CalError> {
        assert_eq!(arguments.len(), self.n_arguments, "as many arguments as the function was compiled for");
        scratch.begin(&self.program);
        arguments.iter().for_each(|&value| scratch.pass(value));
        machine::run(&self.program, self.program.entries[0].pc, inputs, scratch)
    }

    /// What the value can depend on beside the arguments.
    pub fn uses(&self) -> Uses {
        self.program.entries[0].uses
    }

    /// As [`Expression::problems`].
    pub fn problems(&self) -> &[CalError] {
        &self.program.problems
    }
}

fn entry_value<I: Inputs + ?Sized>(
    program: &Program,
    at: usize,
    inputs: &I,
    scratch: &mut Scratch,
) -> Result<f64, CalError> {
    let entry = &program.entries[at];
    match entry.constant {
        Some(value) => Ok(value),
        None => machine::run(program, entry.pc, inputs, scratch),
    }
}

/// Operations that may be spent on constants of a program.
const CONSTANT_STEPS: usize = 1_000_000;
/// How many constants without a proper value are looked at before the rest is left for evaluation.
const MAX_FAILURES: usize = 16;

/// Computes formulas and variables that depend on nothing, where they have a value without a fault.
fn with_constant_entries(program: Program) -> Program {
    let mut program = with_constant_variables(program);
    let constant = |entry: &Entry| entry.uses.is_empty().then_some(entry.pc);
    let pcs: Vec<Option<u32>> = program.entries.iter().map(constant).collect();
    let values = constant_values(&program, &pcs);
    for (entry, value) in program.entries.iter_mut().zip(values) {
        entry.constant = value;
    }
    program
}

/// Computes variables that depend on nothing, where they have a value without a fault.
fn with_constant_variables(mut program: Program) -> Program {
    let constant = |(variable, uses): (&Named, &Uses)| uses.is_empty().then_some(variable.pc);
    let pcs: Vec<Option<u32>> = program.variables.iter().zip(&program.variable_uses).map(constant).collect();
    let values = constant_values(&program, &pcs);
    for op in &mut program.code {
        if let Op::Variable(at) = *op
            && let Some(value) = values[at as usize]
        {
            *op = Op::Number(value);
        }
    }
    program
}

/// Values of the code at these places, as far as they have any.
fn constant_values(program: &Program, pcs: &[Option<u32>]) -> Vec<Option<f64>> {
    let mut values = vec![None; pcs.len()];
    let mut scratch = Scratch::with_max_steps(CONSTANT_STEPS);
    scratch.begin(program);
    let mut n_failures = 0;
    // What is needed by others was found after them.
    for (value, pc) in values.iter_mut().zip(pcs).rev() {
        let Some(pc) = *pc else { continue };
        match machine::run(program, pc, &(), &mut scratch) {
            Ok(found) if scratch.faults() == 0 => *value = Some(found),
            _ if n_failures == MAX_FAILURES => break,
            // A fault is forgotten with the value that it led to.
            _ => {
                n_failures += 1;
                scratch.begin(program);
            }
        }
    }
    values
}
