//! What is wrong with a modifier that may stand in a library as long as no surface uses it.

use std::path::PathBuf;

use super::statement::quoted;
use crate::error::{DeviceError, Place};

/// Why a modifier cannot be used.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    at: Place,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Unsupported { what: String, advice: String },
    Value { expected: String, found: String },
    File { path: PathBuf, reason: String },
    Failed { reason: String },
}

impl Problem {
    /// A feature that is not handled.
    pub(super) fn unsupported(at: &Place, what: String, advice: &str) -> Self {
        Problem { at: at.clone(), kind: Kind::Unsupported { what, advice: advice.to_owned() } }
    }

    /// A value that makes no sense.
    pub(super) fn value(at: &Place, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Problem { at: at.clone(), kind: Kind::Value { expected: expected.into(), found: found.into() } }
    }

    /// A file that cannot be found or read, or is not what it should be.
    pub(super) fn file(at: &Place, error: DeviceError) -> Self {
        let kind = match error {
            DeviceError::File { path, reason, .. } => Kind::File { path, reason },
            other => Kind::Failed { reason: other.to_string() },
        };
        Problem { at: at.clone(), kind }
    }

    /// What another reader says is wrong, with its own file and line.
    pub(super) fn failed(at: &Place, reason: String) -> Self {
        Problem { at: at.clone(), kind: Kind::Failed { reason } }
    }

    /// The error that arises when `user` at `used_at` needs the modifier.
    pub(super) fn raise(&self, user: &str, used_at: &Place) -> DeviceError {
        let use_here = format!("{} uses it at {used_at}", quoted(user));
        let at = self.at.clone();
        match self.kind.clone() {
            Kind::Unsupported { what, advice } => {
                DeviceError::Unsupported { at, what, advice: format!("{advice} ({use_here})") }
            }
            Kind::File { path, reason } => {
                let reason = format!("{reason} ({use_here})");
                DeviceError::File { path, named_at: Some(at), reason }
            }
            Kind::Failed { reason } => DeviceError::Modifier { at, reason: format!("{reason} ({use_here})") },
            Kind::Value { expected, found } => {
                DeviceError::Unexpected { at, expected, found, advice: format!("correct it ({use_here})") }
            }
        }
    }
}
