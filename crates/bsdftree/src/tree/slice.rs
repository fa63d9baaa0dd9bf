//! The exitant half of a tree for one incident cell, in Hilbert order, ready for sampling.
//!
//! G. Ward and A. McNeil, "A Variable-resolution BSDF Implementation": the leaves that an incident direction meets are
//! walked along the Hilbert curve through the exitant square and their projected-solid-angle-weighted values summed;
//! one number in \[0, 1) is looked up in the sums, and what is left of it says where in the leaf.
//! The walk descends the tree in Hilbert order, so nothing is sorted.

use std::f64::consts::PI;

use crate::cumulative::Cumulative;
use crate::hilbert::{State, cell_from_hilbert};
use crate::tree::arena::{Arena, Content, Rank, Slot};

/// Levels of the Hilbert index inside the unit square: 2^-26 is below the rounding of a direction in f32.
const LEVELS: u32 = 26;

/// A leaf of the slice.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Value \[1/sr\].
    value: f32,
    /// Edge is 2^-level of the unit square.
    level: u32,
    /// Position along the curve in units of 4^-level.
    hilbert: u64,
}

/// The leaves of one incident cell and their cumulative sums.
#[derive(Debug)]
pub(super) struct Slice {
    cells: Vec<Cell>,
    cumulative: Cumulative,
    /// Finest and coarsest leaf met, black ones included.
    levels: [u32; 2],
}

impl Slice {
    /// Walks the leaves over an incident cell, given by its coordinates at the tree's own resolution.
    pub fn new(arena: &Arena, incident: [u32; 2]) -> Slice {
        let mut walk = Walk { arena, incident, cells: Vec::new(), levels: [0, u32::MAX] };
        walk.descend(arena.root(), State::default(), 0, 0);
        let Walk { cells, levels, .. } = walk;
        let cumulative = Cumulative::new(cells.iter().map(|c| f64::from(c.value) * area(c.level)));
        Slice { cells, cumulative, levels }
    }

    /// Directional-hemispherical total.
    pub fn total(&self) -> f64 {
        self.cumulative.total()
    }

    /// A point of the exitant square and the BSDF there \[1/sr\], or `None` if the slice is black.
    ///
    /// Takes one number in \[0, 1), or two: then the first chooses the leaf and the place across it, the second along.
    pub fn sample(&self, u: f64, v: Option<f64>) -> Option<([f64; 2], f64)> {
        let (index, rest) = self.cumulative.find(u)?;
        let cell = self.cells[index];
        let below = LEVELS - cell.level;
        let n = 1u64 << below;
        let (x, y) = match v {
            None => {
                let inside = ((rest * (n * n) as f64) as u64).min(n * n - 1);
                cell_from_hilbert(cell.hilbert << (2 * below) | inside, LEVELS)
            }
            Some(v) => {
                let (x, y) = cell_from_hilbert(cell.hilbert, cell.level);
                let within = |t: f64| ((t * n as f64) as u64).min(n - 1) as u32;
                (x << below | within(rest), y << below | within(v))
            }
        };
        let center = |k: u32| (f64::from(k) + 0.5) * 0.5f64.powi(LEVELS as i32);
        Some(([center(x), center(y)], f64::from(cell.value)))
    }

    /// Smallest and largest projected solid angle of a leaf \[sr\].
    pub fn projected_solid_angle(&self) -> [f64; 2] {
        self.levels.map(area)
    }

    /// Memory \[byte\].
    pub fn n_bytes(&self) -> usize {
        std::mem::size_of_val(self.cells.as_slice()) + self.cumulative.n_bytes()
    }
}

/// Projected solid angle of a leaf at a level \[sr\].
pub(crate) fn area(level: u32) -> f64 {
    PI * 0.25f64.powi(level as i32)
}

struct Walk<'a> {
    arena: &'a Arena,
    incident: [u32; 2],
    cells: Vec<Cell>,
    levels: [u32; 2],
}

impl Walk<'_> {
    fn descend(&mut self, slot: Slot, state: State, level: u32, hilbert: u64) {
        match slot.content() {
            Content::Leaf(value) => {
                self.levels = [self.levels[0].max(level), self.levels[1].min(level)];
                if value > 0.0 {
                    self.cells.push(Cell { value, level, hilbert });
                }
            }
            Content::Node(node) => {
                let bit = |c: u32| (c >> (self.arena.log2_res() - 1 - level) & 1) as usize;
                let (fixed, shift) = match self.arena.rank() {
                    Rank::Three => (bit(self.incident[0]), 1),
                    Rank::Four => (bit(self.incident[0]) | bit(self.incident[1]) << 1, 2),
                };
                for k in 0..4 {
                    let (quadrant, next) = state.step(k);
                    let child = self.arena.child(node, fixed | (quadrant as usize) << shift);
                    self.descend(child, next, level + 1, hilbert << 2 | k as u64);
                }
            }
        }
    }
}
