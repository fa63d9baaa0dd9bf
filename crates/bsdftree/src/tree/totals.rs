//! Directional-hemispherical totals of all incident cells of a tree.
//!
//! In: a tree. Out: for each incident cell at the tree's own resolution the total in its middle, and for smooth trees how much it grows
//! from there to the upper side along each incident dimension. A leaf adds its value times its exitant area to the block of incident
//! cells that it stands for, at its own level; levels are then summed from coarse to fine, so that the time is that of visiting each
//! leaf and each cell once.

use crate::tree::arena::{Arena, Content, Rank, Slot};
use crate::tree::slice::area;

/// Most incident cells whose totals are kept \[2^28 byte, thrice as many if smooth\].
const MAX_CELLS_LOG2: u32 = 25;

/// Totals by incident cell: one number each, or three, the growth along both dimensions being the others.
pub(crate) struct Totals<const N: usize> {
    log2_res: u32,
    values: Box<[[f64; N]]>,
}

impl<const N: usize> Totals<N> {
    /// Whether a tree has no more incident cells than a number can be kept for.
    pub fn are_kept(rank: Rank, log2_res: u32) -> bool {
        incident_axes(rank) * log2_res <= MAX_CELLS_LOG2
    }

    /// Sums all leaves, of which `leaf` says from slot and value what the BSDF is in their middle, and how much it grows from there;
    /// `None` if the tree has too many incident cells to keep a number for each.
    pub fn new(arena: &Arena, leaf: impl Fn(usize, f64) -> [f64; N]) -> Option<Totals<N>> {
        let axes = incident_axes(arena.rank());
        if !Self::are_kept(arena.rank(), arena.log2_res()) {
            return None;
        }
        let levels = (0..=arena.log2_res()).map(|l| vec![[0.0; N]; 1 << (axes * l)]).collect();
        let mut sums = Sums { arena, leaf, levels };
        sums.collect((arena.root(), 0), 0, [0, 0]);
        let mut levels = sums.levels.into_iter().enumerate();
        let (_, first) = levels.next().expect("the root");
        let values = levels.fold(first, |coarse, (level, fine)| {
            let below = level as u32 - 1;
            let split = |k: usize| match arena.rank() {
                Rank::Three => (k >> 1, [k & 1, 0]),
                Rank::Four => {
                    let [x, y] = [k & ((1 << level) - 1), k >> level];
                    (y >> 1 << below | x >> 1, [x & 1, y & 1])
                }
            };
            let inherited = |(k, own): (usize, [f64; N])| {
                let (parent, half) = split(k);
                added(in_half(coarse[parent], half), own)
            };
            fine.into_iter().enumerate().map(inherited).collect()
        });
        Some(Totals { log2_res: arena.log2_res(), values: values.into() })
    }

    /// Memory \[byte\].
    pub fn n_bytes(&self) -> usize {
        size_of_val(&*self.values)
    }

    /// Of the incident cell at these coordinates.
    #[inline(always)]
    pub fn of(&self, [x, y]: [u32; 2]) -> [f64; N] {
        self.values[(y << self.log2_res | x) as usize]
    }
}

/// A total that grows, seen from the middle of one half of the cell along each dimension.
#[inline(always)]
fn in_half<const N: usize>(mut total: [f64; N], half: [usize; 2]) -> [f64; N] {
    for axis in 1..N {
        total[axis] *= 0.5;
        total[0] += if half[axis - 1] == 1 { total[axis] } else { -total[axis] };
    }
    total
}

fn added<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|i| a[i] + b[i])
}

/// Dimensions of the incident direction.
pub(super) fn incident_axes(rank: Rank) -> u32 {
    match rank {
        Rank::Three => 1,
        Rank::Four => 2,
    }
}

struct Sums<'a, F, const N: usize> {
    arena: &'a Arena,
    leaf: F,
    levels: Vec<Vec<[f64; N]>>,
}

impl<F: Fn(usize, f64) -> [f64; N], const N: usize> Sums<'_, F, N> {
    /// Adds all leaves below a slot, given with its index.
    fn collect(&mut self, (slot, index): (Slot, usize), level: u32, [x, y]: [u32; 2]) {
        match slot.content() {
            Content::Leaf(value) => {
                let more = (self.leaf)(index, f64::from(value)).map(|v| v * area(level));
                let sum = &mut self.levels[level as usize][(y << level | x) as usize];
                *sum = added(*sum, more);
            }
            Content::Node(node) => {
                let arena = self.arena;
                for (k, &child) in arena.children(node).iter().enumerate() {
                    let bit = |i: usize| (k >> i & 1) as u32;
                    let cell = match arena.rank() {
                        Rank::Three => [x << 1 | bit(0), 0],
                        Rank::Four => [x << 1 | bit(0), y << 1 | bit(1)],
                    };
                    let index = (node as usize) << arena.rank().dimensions() | k;
                    self.collect((child, index), level + 1, cell);
                }
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
            let totals = Totals::new(tree.arena(), |_, value| [value]).unwrap();
            for x in 0..8 {
                for y in 0..if rank == Rank::Four { 8 } else { 1 } {
                    let slice = Slice::new(tree.arena(), [x, y]).total();
                    assert!((totals.of([x, y])[0] / slice - 1.0).abs() < 1e-14);
                }
            }
        }
        let black = Tree::uniform(Rank::Four, 0.0);
        assert_eq!(Totals::new(black.arena(), |_, value| [value]).unwrap().of([0, 0]), [0.0]);
    }
}
