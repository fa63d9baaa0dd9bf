//! The file of a range of path numbers: blocks one after the other, each with its length and a checksum.
//!
//! In: blocks in any order, from any thread. Out: the blocks, up to the first that is not whole. Blocks are only ever appended, so an
//! interruption spoils at most the last one; it is cut off when the file is read, and counted again.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::encode::{decode, encode};
use super::error::CheckpointError;
use crate::counts::{Block, Shape, Slot, Spent, View};
use crate::scatter::Flux;

/// What may be lost when the power fails. (What was written survives the end of the process at any time.)
const SYNC: Duration = Duration::from_secs(1);

/// Length and checksum \[byte\].
const HEAD: usize = 8 + 4;
/// Number of the block \[byte\].
const ID: usize = 4;

/// Blocks that are made bytes before they are written.
const AT_ONCE: usize = 256;

/// A file of blocks.
pub(crate) struct RoundFile {
    path: PathBuf,
    file: File,
    key: u32,
    written: Mutex<Written>,
}

struct Written {
    /// Bytes of whole blocks.
    length: u64,
    synced: Instant,
    /// Why nothing can be appended any more.
    failure: Option<String>,
}

impl RoundFile {
    /// Opens or begins a file. Blocks of another `key` are no blocks.
    pub fn open(path: &Path, key: u32) -> Result<RoundFile, CheckpointError> {
        let file = File::options().read(true).append(true).create(true).open(path);
        let file = file.map_err(|source| io_error("open", path, source))?;
        let written = Mutex::new(Written { length: 0, synced: Instant::now(), failure: None });
        Ok(RoundFile { path: path.into(), file, key, written })
    }

    /// Tells all whole blocks, where block number k has shape k. Cuts off what comes after them; returns how much \[byte\].
    pub fn read<S: Flux>(
        &mut self,
        shapes: &[Shape],
        mut tell: impl FnMut(usize, Block<S>),
    ) -> Result<u64, CheckpointError> {
        let error = |source| io_error("read", &self.path, source);
        let size = self.file.seek(SeekFrom::End(0)).map_err(error)?;
        self.file.seek(SeekFrom::Start(0)).map_err(error)?;
        let mut frames = Frames { from: BufReader::new(&self.file), left: size, key: self.key };
        let mut bytes = Vec::new();
        let mut length = 0;
        while frames.next(&mut bytes).map_err(error)? {
            let Some((id, block)) = parsed(&bytes, shapes) else { break };
            tell(id, block);
            length += (HEAD + bytes.len()) as u64;
        }
        if length < size {
            self.file.set_len(length).map_err(|source| io_error("shorten", &self.path, source))?;
        }
        self.written.get_mut().unwrap_or_else(PoisonError::into_inner).length = length;
        Ok(size - length)
    }

    /// Appends a block; `bytes` is room to work in.
    pub fn append<S: Flux>(
        &self,
        id: usize,
        block: &View<'_, S>,
        bytes: &mut Vec<u8>,
    ) -> Result<(), CheckpointError> {
        frame(id, block, self.key, bytes);
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(why) = &written.failure {
            return Err(io_error("write", &self.path, io::Error::other(why.clone())));
        }
        if let Err(source) = (&self.file).write_all(bytes) {
            // Nothing is found behind a block that is not whole.
            written.failure = Some(source.to_string());
            // What is left of it may be all the room there is.
            let _ = self.file.set_len(written.length);
            return Err(io_error("write", &self.path, source));
        }
        written.length += bytes.len() as u64;
        if written.synced.elapsed() < SYNC {
            return Ok(());
        }
        written.synced = Instant::now();
        // The others may write meanwhile.
        drop(written);
        self.sync()
    }

    /// Says that blocks are missing that were there.
    pub fn damaged(&self) -> CheckpointError {
        let offset = self.written.lock().unwrap_or_else(PoisonError::into_inner).length;
        CheckpointError::Damaged { path: self.path.clone(), offset }
    }

    /// Waits until all is on the disk.
    pub fn sync(&self) -> Result<(), CheckpointError> {
        self.file.sync_data().map_err(|source| io_error("write", &self.path, source))
    }
}

/// Writes all that was counted as one block per slot; the first has all that was spent.
pub(super) fn write_all<S: Flux>(
    to: &mut impl Write,
    key: u32,
    slots: &[Slot<'_, S>],
    spent: Spent,
) -> io::Result<()> {
    for (k, some) in slots.chunks(AT_ONCE).enumerate() {
        let blocks = some.par_iter().enumerate().map(|(i, slot)| {
            let id = k * AT_ONCE + i;
            let Spent { lost, seconds } = if id == 0 { spent } else { Spent::default() };
            let mut bytes = Vec::new();
            frame(id, &slot.view(lost, seconds), key, &mut bytes);
            bytes
        });
        for bytes in blocks.collect::<Vec<_>>() {
            to.write_all(&bytes)?;
        }
    }
    Ok(())
}

pub(super) fn io_error(action: &'static str, path: &Path, source: io::Error) -> CheckpointError {
    CheckpointError::Io { action, path: path.into(), source }
}

/// Makes `bytes` a whole block.
fn frame<S: Flux>(id: usize, block: &View<'_, S>, key: u32, bytes: &mut Vec<u8>) {
    bytes.clear();
    bytes.resize(HEAD, 0);
    bytes.extend((id as u32).to_le_bytes());
    encode(block, bytes);
    let (head, payload) = bytes.split_at_mut(HEAD);
    head[..8].copy_from_slice(&(payload.len() as u64).to_le_bytes());
    head[8..].copy_from_slice(&checksum(payload, key).to_le_bytes());
}

fn parsed<S: Flux>(bytes: &[u8], shapes: &[Shape]) -> Option<(usize, Block<S>)> {
    let (id, bytes) = bytes.split_first_chunk::<ID>()?;
    let id = u32::from_le_bytes(*id) as usize;
    Some((id, decode(bytes, shapes.get(id)?)?))
}

pub(super) fn checksum(bytes: &[u8], key: u32) -> u32 {
    let mut hasher = crc32fast::Hasher::new_with_initial(key);
    hasher.update(bytes);
    hasher.finalize()
}

/// Whole blocks of a stream, as bytes.
struct Frames<R> {
    from: R,
    /// Bytes that the stream has left.
    left: u64,
    key: u32,
}

impl<R: Read> Frames<R> {
    /// Reads the next block, or says that there is none.
    fn next(&mut self, bytes: &mut Vec<u8>) -> io::Result<bool> {
        let mut head = [0; HEAD];
        if self.left < (HEAD + ID) as u64 {
            return Ok(false);
        }
        self.from.read_exact(&mut head)?;
        self.left -= HEAD as u64;
        let (length, sum) = head.split_at(8);
        let length = u64::from_le_bytes(length.try_into().expect("8 bytes"));
        if length < ID as u64 || length > self.left {
            return Ok(false);
        }
        bytes.resize(length as usize, 0);
        self.from.read_exact(bytes)?;
        self.left -= length;
        Ok(checksum(bytes, self.key).to_le_bytes() == *sum)
    }
}
