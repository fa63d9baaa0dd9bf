//! Slices of a tree, made when they are first asked for and kept while memory allows.
//!
//! What is kept never changes a result: a slice is a pure function of the tree and the incident cell.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError, RwLock};

use crate::tree::arena::Arena;
use crate::tree::slice::Slice;

const N_SHARDS: usize = 64;
/// Bound on the slices of one tree \[byte\]; a full shard is emptied before more is kept.
const MAX_BYTES: usize = 256 << 20;

#[derive(Default)]
struct Shard {
    slices: HashMap<[u32; 2], Arc<Slice>>,
    n_bytes: usize,
}

/// The slices of one tree.
pub(super) struct SliceCache {
    shards: Box<[RwLock<Shard>; N_SHARDS]>,
}

impl Default for SliceCache {
    fn default() -> Self {
        SliceCache { shards: Box::new(std::array::from_fn(|_| RwLock::default())) }
    }
}

impl SliceCache {
    /// The slice over an incident cell at the tree's own resolution.
    pub fn slice(&self, arena: &Arena, cell: [u32; 2]) -> Arc<Slice> {
        // Neighbouring cells land in different shards.
        let shard = &self.shards[(cell[0] as usize + 7 * cell[1] as usize) % N_SHARDS];
        if let Some(slice) = shard.read().unwrap_or_else(PoisonError::into_inner).slices.get(&cell) {
            return Arc::clone(slice);
        }
        let slice = Arc::new(Slice::new(arena, cell));
        let n_bytes = slice.n_bytes();
        let mut shard = shard.write().unwrap_or_else(PoisonError::into_inner);
        if shard.n_bytes + n_bytes > MAX_BYTES / N_SHARDS {
            *shard = Shard::default();
        }
        if shard.slices.insert(cell, Arc::clone(&slice)).is_none() {
            shard.n_bytes += n_bytes;
        }
        slice
    }
}
