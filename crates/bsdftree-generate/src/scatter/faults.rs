//! What goes wrong, or is doubtful, where materials are worked out at each meeting of a ray and a surface.
//!
//! In: errors of fields, from any thread. Out: the first of them, after which a run has to end; and which materials were seen to
//! send out more light than they get. A failure scatters nothing, and nothing that was counted since may be used.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use bsdftree_device::field::FieldError;

/// What went wrong so far.
#[derive(Debug, Default)]
pub struct Faults {
    error: OnceLock<FieldError>,
    too_bright: Mutex<BTreeSet<Arc<str>>>,
}

impl Faults {
    /// The first failure of a function.
    pub fn error(&self) -> Option<&FieldError> {
        self.error.get()
    }

    /// Names of the materials whose colour, with their patterns, was above 1 somewhere.
    pub fn too_bright(&self) -> Vec<Arc<str>> {
        self.too_bright.lock().unwrap_or_else(PoisonError::into_inner).iter().cloned().collect()
    }
}

/// Where one material tells its faults.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    name: Arc<str>,
    faults: Arc<Faults>,
    told: Arc<AtomicBool>,
}

/// Rounding of a sum of fractions.
const ROUNDING: f64 = 1e-6;

impl Watch {
    pub fn new(name: &str, faults: &Arc<Faults>) -> Watch {
        Watch { name: name.into(), faults: faults.clone(), told: Arc::default() }
    }

    /// The value, or nothing once the failure is told.
    pub fn checked<T>(&self, value: Result<T, FieldError>) -> Option<T> {
        match value {
            Ok(value) => Some(value),
            Err(error) => {
                // Only the first one counts.
                let _ = self.faults.error.set(error);
                None
            }
        }
    }

    /// Takes note of how much of the light goes on.
    pub fn see_albedo(&self, albedo: f64) {
        if albedo > 1.0 + ROUNDING && !self.told.swap(true, Ordering::Relaxed) {
            let mut names = self.faults.too_bright.lock().unwrap_or_else(PoisonError::into_inner);
            names.insert(self.name.clone());
        }
    }
}
