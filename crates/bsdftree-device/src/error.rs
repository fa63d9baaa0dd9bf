//! What can be wrong with a device, each with the place and what to do.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// A line of a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file as it was named, or the name given to a text.
    pub file: Arc<str>,
    /// Line, counted from 1.
    pub line: u32,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}

/// Why a device could not be read or made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// The text is not what the format asks for at this place.
    #[error("{at}: expected {expected}, found {found}{}", advice_after(.advice))]
    Unexpected {
        /// Where.
        at: Place,
        /// What the format asks for.
        expected: String,
        /// What is there.
        found: String,
        /// What to do; may be empty.
        advice: String,
    },
    /// The scene uses something that this reader does not handle.
    #[error("{at}: {what} is not supported: {advice}")]
    Unsupported {
        /// Where.
        at: Place,
        /// The feature, by its name in the scene.
        what: String,
        /// What to do.
        advice: String,
    },
    /// A name is used before it is defined.
    #[error("{at}: {kind} '{name}' is not defined: define it before this line or correct its name")]
    Undefined {
        /// Where.
        at: Place,
        /// What kind of thing it names.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// Files that name each other in a circle.
    #[error("{at}: files name each other in a circle: {}", .chain.join(" → "))]
    Cycle {
        /// The line that closes the circle.
        at: Place,
        /// The files, from the first to its repetition.
        chain: Vec<String>,
    },
    /// The scene would not fit the reader's limits.
    #[error("{at}: the scene has more than {limit} {what}: make it smaller")]
    TooLarge {
        /// Where the limit was passed.
        at: Place,
        /// What was counted.
        what: &'static str,
        /// How many are allowed.
        limit: u64,
    },
    /// What a modifier needs is wrong in another file.
    #[error("{at}: {reason}")]
    Modifier {
        /// The line of the modifier.
        at: Place,
        /// What is wrong, with its own file and line, and which surface needs it.
        reason: String,
    },
    /// A binary file is not what its format asks for.
    #[error("{file}: byte {offset}: expected {expected}, found {found}: {advice}")]
    Binary {
        /// The file as it was named.
        file: String,
        /// Where in it \[byte\].
        offset: u64,
        /// What the format asks for.
        expected: String,
        /// What is there.
        found: String,
        /// What to do.
        advice: &'static str,
    },
    /// A formula of a command is wrong.
    #[error(transparent)]
    Formula(#[from] crate::cal::CalError),
    /// A program that a scene may run did not do its work.
    #[error("{at}: the command '{command}' failed: {reason}")]
    Program {
        /// The line of the command.
        at: Place,
        /// The program and its arguments.
        command: String,
        /// What happened.
        reason: String,
    },
    /// A file could not be read.
    #[error("{}cannot read '{}': {reason}", place_before(.named_at), .path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The line that names it, if a scene file does.
        named_at: Option<Place>,
        /// Why, and where it was looked for.
        reason: String,
    },
    /// A text such as `blinds:depth=0.05` is not a device.
    #[error("device '{spec}': {reason}")]
    Spec {
        /// The text as given.
        spec: String,
        /// What is wrong and what is possible.
        reason: String,
    },
    /// A name that is not a unit of length.
    #[error("'{0}' is not a unit of length: use meter, foot, inch, centimeter or millimeter")]
    Unit(String),
}

fn advice_after(advice: &str) -> String {
    if advice.is_empty() { String::new() } else { format!(": {advice}") }
}

fn place_before(at: &Option<Place>) -> String {
    at.as_ref().map(|at| format!("{at}: ")).unwrap_or_default()
}
