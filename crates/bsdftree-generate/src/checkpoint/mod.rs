//! What was counted, kept on disk, so that a generation that was killed goes on where it was.
//!
//! In: blocks as they are counted. Out: the same blocks, when the same generation begins again. A directory has
//! * `checkpoint.txt`: what is counted, in clear text ([`job`]); it is written last when the directory is made, and never again;
//! * `A-B.blocks`: what paths A to B of each incident cell counted ([`file`]), for each round, or from 0 for many rounds in one;
//! * `checkpoint.lock`: held by the run that is at work.
//!
//! Invariant: what is on disk is at any time what a generation can go on from with the same bits. Files grow by whole blocks; a file
//! that replaces others is whole before it gets its name, and they go after that. Rounds that were cut short by `samples` or by time are kept
//! until the round is counted to its end, since only whole rounds have the bits of longer generations.

mod directory;
mod encode;
mod error;
mod file;
mod job;
#[cfg(test)]
mod tests;

use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

pub use error::CheckpointError;
pub(crate) use file::RoundFile;
pub(crate) use job::{Counted, Job};

use crate::counts::{Slot, Spent};
use crate::scatter::Flux;
use crate::schedule::{FIRST, is_whole};
use directory::{locked, refuse_others, remove_unfinished, sync_names, write_whole};
use file::{checksum, io_error};

const JOB: &str = "checkpoint.txt";

/// Rounds are made one file when they are larger than this together \[byte\], and than this many times the last one: by then,
/// most of what is in them is the same cells again.
const SMALL: u64 = if cfg!(test) { 1 } else { 64 << 20 };
const MANY: u64 = 4;

/// A directory that holds what was counted.
pub(crate) struct Checkpoint {
    directory: PathBuf,
    key: u32,
    /// Locked as long as it is open.
    _lock: File,
}

/// A file of blocks.
struct Part {
    paths: Range<u64>,
    size: u64,
}

impl Checkpoint {
    /// Opens the checkpoint of a job in a directory, or begins one in an empty or new directory.
    pub fn open(directory: &Path, job: &Job) -> Result<Checkpoint, CheckpointError> {
        fs::create_dir_all(directory).map_err(|source| io_error("make", directory, source))?;
        let text = job.text();
        let path = directory.join(JOB);
        if !path.exists() {
            refuse_others(directory)?;
        }
        let lock = locked(directory)?;
        remove_unfinished(directory)?;
        match fs::read_to_string(&path) {
            Ok(theirs) => match job.differences(&theirs) {
                Some(differences) if differences.is_empty() => {}
                Some(differences) => {
                    return Err(CheckpointError::Differs { directory: directory.into(), differences });
                }
                None => {
                    return Err(CheckpointError::NotOurs { directory: directory.into(), found: JOB.into() });
                }
            },
            Err(source) if source.kind() == ErrorKind::NotFound => {
                write_whole(directory, JOB, |file| file.write_all(text.as_bytes()))?;
            }
            Err(source) if source.kind() == ErrorKind::InvalidData => {
                return Err(CheckpointError::NotOurs { directory: directory.into(), found: JOB.into() });
            }
            Err(source) => return Err(io_error("read", &path, source)),
        }
        Ok(Checkpoint { directory: directory.into(), key: checksum(text.as_bytes(), 0), _lock: lock })
    }

    /// The rounds from the first on that are in one file.
    pub fn base(&self, samples: u64) -> Result<Option<Range<u64>>, CheckpointError> {
        let bases = self.parts()?.into_iter().map(|part| part.paths);
        let base = bases.filter(|p| p.start == 0 && p.end > FIRST && is_whole(p.end)).max_by_key(|p| p.end);
        match base {
            Some(base) if base.end > samples => Err(CheckpointError::Beyond {
                directory: self.directory.clone(),
                counted: base.end,
                asked: samples,
            }),
            base => Ok(base),
        }
    }

    /// Whether anything was counted of a round.
    pub fn has(&self, round: &Range<u64>) -> bool {
        self.path(round).exists()
    }

    /// The end of a round that was cut short.
    pub fn cut(&self, start: u64) -> Result<Option<u64>, CheckpointError> {
        let parts = self.parts()?.into_iter().map(|part| part.paths);
        Ok(parts.filter(|p| p.start == start && !is_whole(p.end)).map(|p| p.end).max())
    }

    /// What was counted of a round.
    pub fn round(&self, round: &Range<u64>) -> Result<RoundFile, CheckpointError> {
        let file = RoundFile::open(&self.path(round), self.key_of(round))?;
        sync_names(&self.directory)?;
        Ok(file)
    }

    /// Says that all of a round was counted, and everything before it: what that makes superfluous goes.
    pub fn complete<S: Flux>(
        &self,
        round: &Range<u64>,
        slots: &[Slot<'_, S>],
        spent: Spent,
    ) -> Result<(), CheckpointError> {
        if !is_whole(round.end) {
            return Ok(());
        }
        let parts: Vec<Part> = self.parts()?.into_iter().filter(|part| part.paths.end <= round.end).collect();
        let cut = |part: &&Part| !is_whole(part.paths.end);
        parts.iter().filter(cut).try_for_each(|part| self.remove(part))?;
        let whole = parts.iter().filter(|part| !cut(part));
        let size: u64 = whole.clone().map(|part| part.size).sum();
        let last = whole.clone().find(|part| part.paths == *round).map_or(0, |part| part.size);
        if size < SMALL || size < MANY * last {
            return Ok(());
        }
        self.unite(round.end, slots, spent)
    }

    /// Puts all rounds up to an end in one file.
    fn unite<S: Flux>(&self, end: u64, slots: &[Slot<'_, S>], spent: Spent) -> Result<(), CheckpointError> {
        let all = 0..end;
        let name = name(&all);
        write_whole(&self.directory, &name, |file| file::write_all(file, self.key_of(&all), slots, spent))?;
        let parts = self.parts()?;
        parts.iter().filter(|p| p.paths.end <= end && p.paths != all).try_for_each(|part| self.remove(part))
    }

    fn path(&self, paths: &Range<u64>) -> PathBuf {
        self.directory.join(name(paths))
    }

    /// A block counts only in its own file.
    fn key_of(&self, paths: &Range<u64>) -> u32 {
        checksum(name(paths).as_bytes(), self.key)
    }

    fn parts(&self) -> Result<Vec<Part>, CheckpointError> {
        let error = |source| io_error("list", &self.directory, source);
        let mut parts = Vec::new();
        for entry in fs::read_dir(&self.directory).map_err(error)? {
            let entry = entry.map_err(error)?;
            if let Some(paths) = entry.file_name().to_str().and_then(paths_of) {
                parts.push(Part { paths, size: entry.metadata().map_err(error)?.len() });
            }
        }
        Ok(parts)
    }

    fn remove(&self, part: &Part) -> Result<(), CheckpointError> {
        let path = self.path(&part.paths);
        fs::remove_file(&path).map_err(|source| io_error("remove", &path, source))
    }
}

fn name(paths: &Range<u64>) -> String {
    format!("{}-{}.blocks", paths.start, paths.end)
}

fn paths_of(file_name: &str) -> Option<Range<u64>> {
    let (start, end) = file_name.strip_suffix(".blocks")?.split_once('-')?;
    let paths = start.parse().ok()?..end.parse().ok()?;
    (name(&paths) == file_name && !paths.is_empty()).then_some(paths)
}
