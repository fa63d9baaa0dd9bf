//! How far long work is, and whether it shall go on.
//!
//! What takes long counts its steps and asks after each whether it shall stop; what it asks with `?` ends it there. Results never depend on it.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use thiserror::Error;

/// How far it is, and whether it shall go on; shared between threads. One for each piece of work.
#[derive(Debug, Default)]
pub struct Progress {
    /// Steps done: cross-validations of a fit, incident cells of trees.
    pub done: AtomicUsize,
    /// Steps to do; 0 before that is known.
    pub total: AtomicUsize,
    /// Set to stop soon.
    pub stop: AtomicBool,
}

/// Stopped from outside.
#[derive(Clone, Copy, Debug, Error)]
#[error("stopped")]
pub struct Stopped;

impl Progress {
    /// Whether it shall go on.
    pub(crate) fn go_on(&self) -> Result<(), Stopped> {
        if self.stop.load(Ordering::Relaxed) { Err(Stopped) } else { Ok(()) }
    }

    /// Counts steps, and says whether it shall go on.
    pub(crate) fn count(&self, n: usize) -> Result<(), Stopped> {
        self.done.fetch_add(n, Ordering::Relaxed);
        self.go_on()
    }
}
