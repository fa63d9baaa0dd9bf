//! Numbers that trees and matrices look into: some of their own, or those of a file that is mapped into memory.
//!
//! What enters is a vector, or a stretch of a map; what leaves is a slice, found once, so that looking into it costs the same
//! whichever it is. A copy shares the numbers. Whoever writes into a file while it is mapped changes the numbers, and a file that
//! is cut short ends the program where they are read, as with every map; bsdftree itself replaces files, and never writes into one.

use std::fmt;
use std::fs::File;
use std::io;
use std::ops::{Deref, Range};
use std::ptr::NonNull;
use std::sync::Arc;

use bytemuck::Pod;
use memmap2::Mmap;

/// A file in memory.
#[derive(Clone)]
pub(crate) struct Map(Arc<Mmap>);

impl Map {
    /// Maps a whole file.
    pub fn new(file: &File) -> io::Result<Map> {
        // SAFETY: the bytes are only ever read, all values of them are legal wherever they are looked at, and every number that
        // is used as an index is bounded where it is used; so other writers can do no more than the module's head says.
        unsafe { Mmap::map(file) }.map(|map| Map(Arc::new(map)))
    }

    /// All bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }
}

/// Where in a file numbers are, and their checksum.
#[derive(Clone)]
pub(crate) struct Stretch {
    map: Map,
    range: Range<usize>,
    crc: u32,
}

impl Stretch {
    /// A stretch of a map; `None` if it lies beyond the end.
    pub fn new(map: &Map, range: Range<usize>, crc: u32) -> Option<Stretch> {
        map.bytes().get(range.clone())?;
        Some(Stretch { map: map.clone(), range, crc })
    }

    /// The first byte.
    pub fn offset(&self) -> usize {
        self.range.start
    }

    fn bytes(&self) -> &[u8] {
        &self.map.bytes()[self.range.clone()]
    }
}

/// A slice that is shared by all who have a copy of this.
pub(crate) struct Shared<T> {
    start: NonNull<T>,
    len: usize,
    owner: Owner<T>,
}

enum Owner<T> {
    Memory(Arc<Vec<T>>),
    File(Stretch),
}

// SAFETY: it is a shared reference to numbers that nobody writes to, together with what keeps them alive.
unsafe impl<T: Send + Sync> Send for Shared<T> {}
// SAFETY: as above.
unsafe impl<T: Send + Sync> Sync for Shared<T> {}

impl<T> From<Vec<T>> for Shared<T> {
    fn from(values: Vec<T>) -> Shared<T> {
        let values = Arc::new(values);
        let start = NonNull::from(values.as_slice()).cast();
        Shared { start, len: values.len(), owner: Owner::Memory(values) }
    }
}

impl<T: Pod> Shared<T> {
    /// The numbers in a stretch of a file; `None` if it does not begin and end where such numbers do.
    pub fn mapped(stretch: Stretch) -> Option<Shared<T>> {
        let values = bytemuck::try_cast_slice::<u8, T>(stretch.bytes()).ok()?;
        Some(Shared { start: NonNull::from(values).cast(), len: values.len(), owner: Owner::File(stretch) })
    }
}

impl<T> Shared<T> {
    /// Where in a file they are, unless they are in memory of their own.
    pub fn stretch(&self) -> Option<&Stretch> {
        match &self.owner {
            Owner::Memory(_) => None,
            Owner::File(stretch) => Some(stretch),
        }
    }

    /// Whether they are as they were written, by their checksum. Those in memory of their own are.
    pub fn is_as_written(&self) -> bool {
        self.stretch().is_none_or(|stretch| crc32fast::hash(stretch.bytes()) == stretch.crc)
    }
}

impl<T> Deref for Shared<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: the owner holds as many there, never moves them, and lives as long as this does.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.len) }
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Shared<T> {
        let owner = match &self.owner {
            Owner::Memory(values) => Owner::Memory(Arc::clone(values)),
            Owner::File(stretch) => Owner::File(stretch.clone()),
        };
        Shared { start: self.start, len: self.len, owner }
    }
}

impl<T> fmt::Debug for Shared<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} numbers{}", self.len, if self.stretch().is_some() { " of a file" } else { "" })
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn numbers_live_as_long_as_their_last_copy() {
        let first = Shared::from(vec![1u32, 2, 3]);
        let second = first.clone();
        drop(first);
        assert_eq!(*second, [1, 2, 3]);
        assert!(second.is_as_written());
        assert!(Shared::<u32>::from(Vec::new()).is_empty());
    }

    #[test]
    fn numbers_of_a_file_are_those_in_it() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(bytemuck::cast_slice(&[7u32, 8, 9, 10])).unwrap();
        let map = Map::new(&file).unwrap();
        let crc = crc32fast::hash(bytemuck::cast_slice(&[8u32, 9]));
        let numbers = Shared::<u32>::mapped(Stretch::new(&map, 4..12, crc).unwrap()).unwrap();
        assert_eq!(*numbers, [8, 9]);
        assert!(numbers.is_as_written());
        assert!(!Shared::<u32>::mapped(Stretch::new(&map, 4..12, 0).unwrap()).unwrap().is_as_written());
        assert!(Shared::<u32>::mapped(Stretch::new(&map, 2..6, 0).unwrap()).is_none());
        assert!(Shared::<u32>::mapped(Stretch::new(&map, 4..7, 0).unwrap()).is_none());
        assert!(Stretch::new(&map, 4..20, 0).is_none());
    }
}
