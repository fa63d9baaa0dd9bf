//! Why there is no checkpoint, and what to do about it.

use std::path::PathBuf;

use thiserror::Error;

/// What is wrong with a checkpoint.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// A file or directory cannot be read or written.
    #[error("checkpoint: cannot {action} {}: {source}; what was counted until then is kept, and the same command goes on from there", path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// Where.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The directory has other things in it.
    #[error("checkpoint: {} is no checkpoint and has {found:?} in it; give a new or an empty directory", directory.display())]
    NotOurs {
        /// The directory.
        directory: PathBuf,
        /// A file in it.
        found: String,
    },
    /// Another run writes there.
    #[error("checkpoint: {} is in use by another run; wait for its end, or give another directory", .0.display())]
    InUse(PathBuf),
    /// It belongs to another device, other options or another version.
    #[error("checkpoint: {} is of another generation: {}; give the same device and options, or another directory", directory.display(), differences.join("; "))]
    Differs {
        /// The directory.
        directory: PathBuf,
        /// What was asked for and what is there, one by one.
        differences: Vec<String>,
    },
    /// More was counted than is asked for, in a way that cannot be taken back.
    #[error("checkpoint: {} has {counted} samples per incident cell, more than the {asked} asked for; ask for {counted} or more, or give another directory", directory.display())]
    Beyond {
        /// The directory.
        directory: PathBuf,
        /// Samples per incident cell that it has.
        counted: u64,
        /// Samples that were asked for.
        asked: u64,
    },
    /// A file that was whole is not any more.
    #[error("checkpoint: {} is damaged from byte {offset} on; delete it, and what was in it is counted again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// First byte that is not as it was written.
        offset: u64,
    },
}
