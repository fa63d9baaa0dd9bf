//! Formulas of a modifier, with the words they came from.
//!
//! Whatever has no finite value (a division by 0, the root of a negative number) is an error: Radiance would leave out the modifier
//! for that ray, with a warning, which is to make light of something unknown.

use std::cell::RefCell;
use std::fmt;
use std::sync::Arc;

use super::FieldProblem;
use super::space::Seen;
use crate::cal::{Expressions, Function, Scratch};

/// Formulas in the words of a modifier, such as `refl` or `if(Px,1,.5)`, that are worked out together. Equal by their words: what
/// these mean is in the function file.
#[derive(Clone)]
pub struct Formulas {
    /// As they stand in the scene.
    pub texts: Vec<Arc<str>>,
    /// In the context of the function file.
    pub expressions: Expressions,
}

/// A function that a modifier names. Equal by its name.
#[derive(Clone)]
pub struct Call {
    /// As it stands in the scene.
    pub name: Arc<str>,
    /// In the context of the function file.
    pub function: Function,
    /// Of numbers of a place, whether it takes all or only the one it stands for.
    pub takes_all: bool,
}

thread_local! {
    /// Memory for evaluations; what is left in it has no effect.
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl Formulas {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.texts.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.texts.is_empty()
    }

    /// Their values, all finite.
    pub(super) fn evaluate(&self, seen: &Seen, values: &mut [f64]) -> Result<(), FieldProblem> {
        SCRATCH.with_borrow_mut(|scratch| {
            self.expressions.evaluate_in(seen, scratch, values)?;
            let wrong = values.iter().position(|v| !v.is_finite()).or((scratch.faults() > 0).then_some(0));
            wrong.map_or(Ok(()), |k| Err(seen.no_value(&self.texts[k])))
        })
    }
}

impl Call {
    /// Its value for these arguments, finite.
    pub(super) fn call(&self, arguments: &[f64], seen: &Seen) -> Result<f64, FieldProblem> {
        SCRATCH.with_borrow_mut(|scratch| {
            let value = self.function.call_in(arguments, seen, scratch)?;
            let right = value.is_finite() && scratch.faults() == 0;
            if right { Ok(value) } else { Err(seen.no_value(&self.name)) }
        })
    }

    /// What it makes of the numbers at a place, of which it stands for number `k`.
    pub(super) fn of(&self, numbers: &[f64], k: usize, seen: &Seen) -> Result<f64, FieldProblem> {
        self.call(if self.takes_all { numbers } else { &numbers[k..=k] }, seen)
    }
}

impl PartialEq for Formulas {
    fn eq(&self, other: &Formulas) -> bool {
        self.texts == other.texts
    }
}

impl PartialEq for Call {
    fn eq(&self, other: &Call) -> bool {
        (&self.name, self.takes_all) == (&other.name, other.takes_all)
    }
}

impl fmt::Debug for Formulas {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Formulas({:?})", self.texts)
    }
}

impl fmt::Debug for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Call({:?}, {})", self.name, self.takes_all)
    }
}
