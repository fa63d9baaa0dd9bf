//! The directory of a checkpoint: whose it is, who may write there, and files that are whole as soon as they are there.
//!
//! In: a directory. Out: the lock on it, or why not. Invariant: nothing that is not ours is written over or removed.

use std::fs::{self, File, TryLockError};
use std::path::Path;

use super::error::CheckpointError;
use super::file::io_error;
use super::{JOB, paths_of};

const LOCK: &str = "checkpoint.lock";
/// Ends the names of files that are not whole yet.
const NEW: &str = ".new";

/// A directory without a job may have only what is left of a run that was killed before it wrote one.
pub(super) fn refuse_others(directory: &Path) -> Result<(), CheckpointError> {
    let error = |source| io_error("list", directory, source);
    for entry in fs::read_dir(directory).map_err(error)? {
        let name = entry.map_err(error)?.file_name();
        if name != JOB && name != LOCK && name.to_str() != Some(&format!("{JOB}{NEW}")) {
            let found = name.to_string_lossy().into_owned();
            return Err(CheckpointError::NotOurs { directory: directory.into(), found });
        }
    }
    Ok(())
}

/// Files that a run which was killed had not brought to their end.
pub(super) fn remove_unfinished(directory: &Path) -> Result<(), CheckpointError> {
    let error = |source| io_error("tidy", directory, source);
    for entry in fs::read_dir(directory).map_err(error)? {
        let name = entry.map_err(error)?.file_name();
        if name.to_str().and_then(|name| paths_of(name.strip_suffix(NEW)?)).is_some() {
            fs::remove_file(directory.join(name)).map_err(error)?;
        }
    }
    Ok(())
}

pub(super) fn locked(directory: &Path) -> Result<File, CheckpointError> {
    let path = directory.join(LOCK);
    let error = |source| io_error("lock", &path, source);
    let lock = File::options().write(true).create(true).truncate(false).open(&path).map_err(error)?;
    match lock.try_lock() {
        Ok(()) => Ok(lock),
        Err(TryLockError::WouldBlock) => Err(CheckpointError::InUse(directory.into())),
        Err(TryLockError::Error(source)) => Err(error(source)),
    }
}

/// Writes a file that has its name only when it is whole.
pub(super) fn write_whole(
    directory: &Path,
    name: &str,
    write: impl FnOnce(&mut File) -> std::io::Result<()>,
) -> Result<(), CheckpointError> {
    let path = directory.join(format!("{name}{NEW}"));
    let written = File::create(&path).and_then(|mut file| {
        write(&mut file)?;
        file.sync_all()
    });
    let named = written.and_then(|()| fs::rename(&path, directory.join(name)));
    named.map_err(|source| {
        // What is on disk without it is enough.
        let _ = fs::remove_file(&path);
        io_error("write", &path, source)
    })?;
    sync_names(directory)
}

/// Waits until the names of files are on the disk.
pub(super) fn sync_names(directory: &Path) -> Result<(), CheckpointError> {
    // Only where directories can be opened as files.
    #[cfg(unix)]
    File::open(directory)
        .and_then(|names| names.sync_all())
        .map_err(|source| io_error("write", directory, source))?;
    #[cfg(not(unix))]
    let _ = directory;
    Ok(())
}
