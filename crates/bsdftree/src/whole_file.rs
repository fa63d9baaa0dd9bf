//! Files that are written whole or not at all.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes a file by `write`. It takes the place of an older one only when it is safely on disk; of a link, of what it leads to.
/// What is not a file, such as `/dev/stdout` or a pipe, is written to directly.
///
/// # Errors
/// Those of `write`, and of the file system.
pub(crate) fn write<E: From<io::Error>>(
    path: &Path,
    write: impl Fn(&mut File) -> Result<(), E>,
) -> Result<(), E> {
    // A path that leads nowhere yet is its own target.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if target.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        return write(&mut File::options().write(true).open(&target)?);
    }
    let temporary = temporary_beside(&target);
    let written = || -> Result<(), E> {
        let mut file = File::create_new(&temporary)?;
        write(&mut file)?;
        file.sync_all()?;
        std::fs::rename(&temporary, &target)?;
        Ok(())
    };
    written().inspect_err(|_| {
        // Nothing more can be done if this fails too; the first error is the one to tell.
        let _ = std::fs::remove_file(&temporary);
    })
}

/// A name in the same folder that no other writer uses.
fn temporary_beside(target: &Path) -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let mut name = std::ffi::OsString::from(".");
    name.push(target.file_name().unwrap_or_default());
    name.push(format!(".{}-{}.part", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
    target.with_file_name(name)
}
