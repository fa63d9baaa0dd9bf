//! What can be wrong with a function file or with the evaluation of one of its formulas, each with its line.

use crate::error::Place;

/// Why a formula could not be read or evaluated: the line, what is wrong there, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{at}: {problem}")]
pub struct CalError {
    /// File and line.
    pub at: Place,
    /// What is wrong there.
    pub problem: Box<CalProblem>,
}

/// What is wrong with a formula.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CalProblem {
    /// The text is not what the grammar asks for.
    #[error("expected {expected}, found {found}: {advice}")]
    Unexpected {
        /// What the grammar asks for.
        expected: String,
        /// What is there.
        found: String,
        /// What to do.
        advice: String,
    },
    /// A name without a definition was needed.
    #[error("{kind} '{name}' is not defined: {advice}")]
    Undefined {
        /// Variable or function.
        kind: &'static str,
        /// The name as it was looked for.
        name: String,
        /// What to do.
        advice: String,
    },
    /// A function needs an argument that its caller did not give.
    #[error(
        "function '{function}' needs its argument {needed}, found {given}: give it at least {needed} arguments"
    )]
    TooFewArguments {
        /// The function.
        function: String,
        /// Number of the argument, counted from 1.
        needed: usize,
        /// How many were given.
        given: usize,
    },
    /// A parameter is called, but what was passed for it is no function.
    #[error(
        "function '{function}' calls its parameter {parameter}, but a value was passed for it: \
         pass the name of a function"
    )]
    NotAFunction {
        /// The function.
        function: String,
        /// Number of the parameter, counted from 1.
        parameter: usize,
    },
    /// A real argument of the scene's primitive is asked for that is not there.
    #[error(
        "arg({needed}) is missing, found {given} real arguments: \
         give the primitive that uses this file at least {needed} real arguments"
    )]
    MissingArgument {
        /// Number of the argument, counted from 1.
        needed: u32,
        /// How many there are.
        given: u32,
    },
    /// A channel that a ray does not have.
    #[error(
        "expected a channel that a ray has, $1 to $27, found ${channel}: use one of those, or their names"
    )]
    NoChannel {
        /// The channel asked for.
        channel: u32,
    },
    /// A variable whose value needs its own value.
    #[error("variable '{name}' is defined by itself: break the circle of definitions")]
    Circular {
        /// The variable.
        name: String,
    },
    /// An evaluation that does not end, or not within reason.
    #[error("'{name}' was stopped after {limit} {what}: let its recursion end, with if(), after fewer")]
    Endless {
        /// The function or variable that was being evaluated.
        name: String,
        /// What was counted.
        what: &'static str,
        /// How many are allowed.
        limit: usize,
    },
    /// Text beyond the limits of the reader.
    #[error("expected at most {limit} {what}, found more: {advice}")]
    TooLarge {
        /// What was counted.
        what: &'static str,
        /// How many are allowed.
        limit: usize,
        /// What to do.
        advice: &'static str,
    },
}

impl CalError {
    /// This problem at this place.
    pub(super) fn new(at: &Place, problem: CalProblem) -> Self {
        CalError { at: at.clone(), problem: Box::new(problem) }
    }
}
