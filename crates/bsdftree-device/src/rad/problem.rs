//! What is wrong with a modifier that may stand in a library as long as no surface uses it.

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

    /// The error that arises when `user` at `used_at` needs the modifier.
    pub(super) fn raise(&self, user: &str, used_at: &Place) -> DeviceError {
        let use_here = format!("{} uses it at {used_at}", quoted(user));
        let at = self.at.clone();
        match self.kind.clone() {
            Kind::Unsupported { what, advice } => {
                DeviceError::Unsupported { at, what, advice: format!("{advice} ({use_here})") }
            }
            Kind::Value { expected, found } => {
                DeviceError::Unexpected { at, expected, found, advice: format!("correct it ({use_here})") }
            }
        }
    }
}
