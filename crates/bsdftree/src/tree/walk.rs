//! All leaves of a tree, and its uniform grid.

use crate::tree::Tree;
use crate::tree::arena::{Arena, Content, Slot};

/// A leaf: a cube in the tree's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// Lower corner in units of the edge; as many entries count as the tree has dimensions.
    pub cell: [u32; 4],
    /// The edge is 2^-level.
    pub level: u32,
    /// Value \[1/sr\].
    pub value: f32,
}

/// Lower corner of child k of a cell, in units of the child's edge.
pub(crate) fn child_cell<const N: usize>(cell: [u32; N], k: usize) -> [u32; N] {
    std::array::from_fn(|i| cell[i] << 1 | (k as u32 >> i & 1))
}

/// Iterates over leaves in branch order.
pub(super) struct Leaves<'a> {
    arena: &'a Arena,
    pending: Vec<(Slot, u32, [u32; 4])>,
}

impl Iterator for Leaves<'_> {
    type Item = Leaf;

    fn next(&mut self) -> Option<Leaf> {
        loop {
            let (slot, level, cell) = self.pending.pop()?;
            match slot.content() {
                Content::Leaf(value) => return Some(Leaf { cell, level, value }),
                Content::Node(node) => {
                    for (k, &child) in self.arena.children(node).iter().enumerate().rev() {
                        self.pending.push((child, level + 1, child_cell(cell, k)));
                    }
                }
            }
        }
    }
}

impl Tree {
    /// All leaves, in branch order (Morton order, dimension 0 fastest).
    pub fn leaves(&self) -> impl Iterator<Item = Leaf> + '_ {
        Leaves { arena: self.arena(), pending: vec![(self.arena().root(), 0, [0; 4])] }
    }

    /// The values of a uniform grid of 2^log2_res cells per axis, row-major, dimension 0 slowest; cells coarser than a
    /// leaf are its mean.
    ///
    /// # Panics
    /// If the grid would have more than 2^40 cells.
    pub fn to_grid(&self, log2_res: u32) -> Vec<f32> {
        let d = self.rank().dimensions();
        assert!(d as u32 * log2_res <= 40, "a grid of 2^{} values is too large", d as u32 * log2_res);
        let mut sums = vec![0.0f64; 1 << (d as u32 * log2_res)];
        for leaf in self.leaves() {
            if leaf.level <= log2_res {
                let up = log2_res - leaf.level;
                for inside in 0..1usize << (d as u32 * up) {
                    let index = (0..d).fold(0, |index, i| {
                        let offset = inside >> (i as u32 * up) & ((1 << up) - 1);
                        index << log2_res | (leaf.cell[i] as usize) << up | offset
                    });
                    sums[index] = f64::from(leaf.value);
                }
            } else {
                let down = leaf.level - log2_res;
                let index = (0..d).fold(0, |index, i| index << log2_res | (leaf.cell[i] >> down) as usize);
                sums[index] += f64::from(leaf.value) * 0.5f64.powi((d as u32 * down) as i32);
            }
        }
        sums.into_iter().map(|v| v as f32).collect()
    }

    /// Smallest value; of rank 3 only the half that is read (d0 < ½) counts.
    pub fn minimum(&self) -> f32 {
        let used = |leaf: &Leaf| {
            self.rank().dimensions() == 4 || leaf.level == 0 || leaf.cell[0] >> (leaf.level - 1) == 0
        };
        self.leaves().filter(used).map(|leaf| leaf.value).fold(f32::INFINITY, f32::min)
    }
}
