//! Slices of a tree, made when they are first asked for and kept while memory allows.
//!
//! What is kept never changes a result: a slice is a function of the tree and the incident cell. Reading one that
//! is kept takes no lock.

use std::ops::Deref;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::tree::arena::{Arena, Rank};
use crate::tree::batch::ask;

/// Most slices of one tree that are kept: all of them up to 2^9 cells per axis. Those of finer trees take more than [`MAX_BYTES`] anyway.
const MAX_SLOTS: usize = 1 << 18;
/// Memory of the slices of one tree at which no more are kept \[byte\].
const MAX_BYTES: usize = 256 << 20;

/// What is known of a tree over one incident cell.
pub(super) trait Slice {
    /// Memory \[byte\].
    fn n_bytes(&self) -> usize;
}

struct Kept<S> {
    cell: [u32; 2],
    slice: S,
}

/// The slices of one tree.
pub(super) struct SliceCache<S> {
    /// By incident cell; finer trees share a slot among several cells, and the first one has it.
    slots: OnceLock<Box<[OnceLock<Kept<S>>]>>,
    n_bytes: AtomicUsize,
}

impl<S> Default for SliceCache<S> {
    fn default() -> SliceCache<S> {
        SliceCache { slots: OnceLock::new(), n_bytes: AtomicUsize::new(0) }
    }
}

/// A slice that is kept, or one made for this use.
pub(super) enum SliceRef<'a, S> {
    Kept(&'a S),
    Made(Box<S>),
}

impl<S> Deref for SliceRef<'_, S> {
    type Target = S;

    #[inline]
    fn deref(&self) -> &S {
        match self {
            SliceRef::Kept(slice) => slice,
            SliceRef::Made(slice) => slice,
        }
    }
}

impl<S: Slice> SliceCache<S> {
    /// The slice over an incident cell at the tree's own resolution, which `make` makes if it is not kept.
    #[inline]
    pub fn slice(&self, arena: &Arena, cell: [u32; 2], make: impl Fn() -> S) -> SliceRef<'_, S> {
        let slot = self.slot(arena, cell);
        match slot.get() {
            Some(kept) if kept.cell == cell => SliceRef::Kept(&kept.slice),
            other => self.made(cell, other.is_none().then_some(slot), make),
        }
    }

    /// Makes all slices, as far as they are kept; their memory \[byte\].
    pub fn fill(&self, arena: &Arena, make: impl Fn([u32; 2]) -> S) -> usize {
        let n = 1u32 << arena.log2_res();
        let ny = if arena.rank() == Rank::Four { n } else { 1 };
        let cells = (0..ny).flat_map(|y| (0..n).map(move |x| [x, y]));
        for cell in cells {
            self.slice(arena, cell, || make(cell));
            if self.n_bytes.load(Ordering::Relaxed) >= MAX_BYTES {
                break;
            }
        }
        self.n_bytes.load(Ordering::Relaxed) + size_of_val(self.slots.get().map_or(&[][..], |slots| slots))
    }

    /// Asks early for where a slice is.
    #[inline(always)]
    pub fn ask(&self, arena: &Arena, cell: [u32; 2]) {
        ask(self.slot(arena, cell));
    }

    #[inline(always)]
    fn slot(&self, arena: &Arena, [x, y]: [u32; 2]) -> &OnceLock<Kept<S>> {
        let slots = self.slots.get_or_init(|| {
            let bits = match arena.rank() {
                Rank::Three => arena.log2_res(),
                Rank::Four => 2 * arena.log2_res(),
            };
            (0..(1 << bits).min(MAX_SLOTS)).map(|_| OnceLock::new()).collect()
        });
        let index = (u64::from(y) << arena.log2_res() | u64::from(x)) as usize;
        &slots[index & (slots.len() - 1)]
    }

    #[cold]
    fn made<'a>(
        &self,
        cell: [u32; 2],
        slot: Option<&'a OnceLock<Kept<S>>>,
        make: impl Fn() -> S,
    ) -> SliceRef<'a, S> {
        let slice = make();
        let n_bytes = slice.n_bytes();
        match slot {
            Some(slot) if self.n_bytes.load(Ordering::Relaxed) + n_bytes <= MAX_BYTES => {
                self.n_bytes.fetch_add(n_bytes, Ordering::Relaxed);
                let kept = slot.get_or_init(|| Kept { cell, slice });
                // Another thread may have been first, with this cell or one that shares the slot.
                match kept.cell == cell {
                    true => SliceRef::Kept(&kept.slice),
                    false => SliceRef::Made(Box::new(make())),
                }
            }
            _ => SliceRef::Made(Box::new(slice)),
        }
    }
}
