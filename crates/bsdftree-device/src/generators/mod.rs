//! Radiance's generator programs, in our own words: `genblinds`, `genbox`, `genprism`, `genrev`, `gensurf`, `genworm`,
//! `replmarks`.
//!
//! In: the words of a command. Out: the statements that Radiance's program of that name prints, in its order and under its
//! names, to the digits it prints. Source: their manual pages, and the 2025 release for what those leave open. Deviations: numbers
//! are not cut to 12 digits, words that are not numbers are refused where Radiance reads a 0, so are arguments that
//! make it print nothing or NaN, and OBJ output (`-o`).
//!
//! How many statements a command may make is bounded before it makes them.

mod arguments;
mod blinds;
mod boxes;
mod functions;
mod grid;
mod marks;
mod output;
mod prism;
mod revolution;
mod rounded;
mod surface;
#[cfg(test)]
mod tests;
mod worm;

use arguments::Arguments;
use output::Output;

use crate::error::{DeviceError, Place};
use crate::rad::Statement;

/// What a command may use.
pub(crate) struct Environment<'a> {
    /// The line of the command.
    pub at: &'a Place,
    /// The text of a file that the command names.
    pub read: &'a dyn Fn(&str) -> Result<String, DeviceError>,
    /// Whether a file of this name can be read.
    pub is_file: &'a dyn Fn(&str) -> bool,
    /// Most statements it may make.
    pub limit: u64,
    /// Most operations of all its formulas.
    pub most_steps: u64,
}

type Generator = fn(&mut Arguments, &Environment, &mut Output) -> Result<(), DeviceError>;

/// The generators by name, with how they are called.
const GENERATORS: [(&str, Generator, &str); 6] = [
    ("genblinds", blinds::generate, "mat name depth width height nslats angle [-r|+r rcurv]"),
    ("genbox", boxes::generate, "mat name xsize ysize zsize [-i] [-b bevel | -r round [-n nsegs] [-s]]"),
    ("genprism", prism::generate, "mat name {vfile | N v1 v2 .. vN} [-l lvect] [-r radius] [-c] [-e]"),
    ("genrev", revolution::generate, "mat name 'z(t)' 'r(t)' nseg [-e expr] [-f file] [-s]"),
    ("gensurf", surface::generate, "mat name 'x(s,t)' 'y(s,t)' 'z(s,t)' m n [-e expr] [-f file] [-s] [-i]"),
    ("genworm", worm::generate, "mat name 'x(t)' 'y(t)' 'z(t)' 'r(t)' nseg [-e expr] [-f file]"),
];

/// Whether a program of this name is understood by [`run`].
pub(crate) fn is_known(program: &str) -> bool {
    GENERATORS.iter().any(|(name, ..)| *name == program)
}

/// Names of the programs that are understood.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    GENERATORS.iter().map(|(name, ..)| *name)
}

/// What a program makes; it must be known.
pub(crate) fn run(command: &[String], environment: &Environment) -> Result<Vec<Statement>, DeviceError> {
    let known = GENERATORS.iter().find(|(name, ..)| Some(*name) == command.first().map(String::as_str));
    let Some((program, generate, usage)) = known else { return Ok(Vec::new()) };
    let mut arguments = Arguments::new(program, usage, &command[1..], environment.at);
    let mut output = Output::new(environment.at, environment.limit);
    generate(&mut arguments, environment, &mut output).map_err(|error| match error {
        // Which formula of which command would not be said otherwise.
        DeviceError::Formula(wrong) => DeviceError::Program {
            at: environment.at.clone(),
            command: command.join(" ").chars().take(60).collect(),
            reason: wrong.to_string(),
        },
        other => other,
    })?;
    Ok(output.into_statements())
}

pub(crate) use marks::Marks;

/// The modifier and the name that all generators begin with.
struct Names {
    modifier: String,
    name: String,
}

impl Names {
    fn take(arguments: &mut Arguments) -> Result<Names, DeviceError> {
        let modifier = arguments.word("a modifier")?.to_owned();
        Ok(Names { modifier, name: arguments.word("a name")?.to_owned() })
    }

    /// The name of a part.
    fn part(&self, part: impl std::fmt::Display) -> String {
        format!("{}.{part}", self.name)
    }
}
