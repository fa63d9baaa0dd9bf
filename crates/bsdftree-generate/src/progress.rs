//! How far a generation has come, read by whoever waits for it, and the wish to stop it.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Shared between the workers and the one who waits.
#[derive(Debug, Default)]
pub struct Progress {
    done: AtomicU64,
    total: AtomicU64,
    cancelled: AtomicBool,
    resumed: OnceLock<Option<Resumed>>,
}

/// Where a generation went on that had been interrupted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resumed {
    /// Paths per incident cell and side that were counted before.
    pub samples: u64,
    /// Paths per incident cell and side at the end of the round that was interrupted; the same, if none was.
    pub round_end: u64,
    /// The share of that round that was counted, in 0..1.
    pub share: f64,
    /// What was written but is not whole, and is counted again \[byte\].
    pub n_dropped: u64,
}

impl Progress {
    /// Paths followed so far and paths there will be; (0, 0) before work begins.
    pub fn paths(&self) -> (u64, u64) {
        (self.done.load(Ordering::Relaxed), self.total.load(Ordering::Relaxed))
    }

    /// Asks the workers to stop; they do after the incident cell they are at.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Where work went on, if it had been interrupted; `None` until that is known.
    pub fn resumed(&self) -> Option<Resumed> {
        self.resumed.get().copied().flatten()
    }

    /// Work goes on from there, or else begins. Only the first time counts.
    pub(crate) fn resume(&self, from: Option<Resumed>) {
        let _ = self.resumed.set(from);
    }

    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// There will be `total` paths, as far as is known, of which `done` are done.
    pub(crate) fn begin(&self, total: u64, done: u64) {
        self.total.store(total, Ordering::Relaxed);
        self.done.store(done, Ordering::Relaxed);
    }

    pub(crate) fn add(&self, paths: u64) {
        self.done.fetch_add(paths, Ordering::Relaxed);
    }
}
