//! Directional-hemispherical totals of all incident cells of a tree.
//!
//! In: a tree. Out: one number for each incident cell at the tree's own resolution. A leaf adds its value times its exitant area to
//! the block of incident cells that it stands for, at its own level; levels are then summed from coarse to fine, so that the
//! time is that of visiting each leaf and each cell once.

use crate::tree::arena::{Arena, Content, Rank, Slot};
use crate::tree::slice::area;

/// Most incident cells whose totals are kept \[2^28 byte\].
const MAX_CELLS_LOG2: u32 = 25;

/// Totals by incident cell.
pub(super) struct Totals {
    log2_res: u32,
    values: Box<[f64]>,
}

impl Totals {
    /// Sums all leaves; `None` if the tree has too many incident cells to keep a number for each.
    pub fn new(arena: &Arena) -> Option<Totals> {
        let axes = incident_axes(arena.rank());
        if axes * arena.log2_res() > MAX_CELLS_LOG2 {
            return None;
        }
        let mut levels: Vec<Vec<f64>> = (0..=arena.log2_res()).map(|l| vec![0.0; 1 << (axes * l)]).collect();
        collect(arena, arena.root(), 0, [0, 0], &mut levels);
        let mut levels = levels.into_iter().enumerate();
        let (_, first) = levels.next().expect("the root");
        let values = levels.fold(first, |coarse, (level, fine)| {
            let below = level as u32 - 1;
            let parent = |k: usize| match arena.rank() {
                Rank::Three => k >> 1,
                Rank::Four => (k >> level >> 1) << below | (k & ((1 << level) - 1)) >> 1,
            };
            fine.into_iter().enumerate().map(|(k, sum)| coarse[parent(k)] + sum).collect()
        });
        Some(Totals { log2_res: arena.log2_res(), values: values.into() })
    }

    /// Memory \[byte\].
    pub fn n_bytes(&self) -> usize {
        size_of_val(&*self.values)
    }

    /// Of the incident cell at these coordinates.
    #[inline(always)]
    pub fn of(&self, [x, y]: [u32; 2]) -> f64 {
        self.values[(y << self.log2_res | x) as usize]
    }
}

fn incident_axes(rank: Rank) -> u32 {
    match rank {
        Rank::Three => 1,
        Rank::Four => 2,
    }
}

fn collect(arena: &Arena, slot: Slot, level: u32, [x, y]: [u32; 2], levels: &mut [Vec<f64>]) {
    match slot.content() {
        Content::Leaf(value) => {
            levels[level as usize][(y << level | x) as usize] += f64::from(value) * area(level)
        }
        Content::Node(node) => {
            for (k, &child) in arena.children(node).iter().enumerate() {
                let bit = |i: usize| (k >> i & 1) as u32;
                let cell = match arena.rank() {
                    Rank::Three => [x << 1 | bit(0), 0],
                    Rank::Four => [x << 1 | bit(0), y << 1 | bit(1)],
                };
                collect(arena, child, level + 1, cell, levels);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::Tree;
    use crate::tree::slice::Slice;

    #[test]
    fn totals_are_those_of_slices() {
        for rank in [Rank::Three, Rank::Four] {
            let n = 1usize << (3 * rank.dimensions());
            let values: Vec<f32> =
                (0..n).map(|k| if k * 31 % 64 < 30 { 2.0 } else { (k % 13) as f32 }).collect();
            let tree = Tree::from_grid(rank, &values).unwrap();
            let totals = Totals::new(tree.arena()).unwrap();
            for x in 0..8 {
                for y in 0..if rank == Rank::Four { 8 } else { 1 } {
                    let slice = Slice::new(tree.arena(), [x, y]).total();
                    assert!((totals.of([x, y]) / slice - 1.0).abs() < 1e-14);
                }
            }
        }
        let black = Tree::uniform(Rank::Four, 0.0);
        assert_eq!(Totals::new(black.arena()).unwrap().of([0, 0]), 0.0);
    }
}
