//! The exitant half of a tree for one incident cell, in Hilbert order, ready for sampling.
//!
//! G. Ward and A. McNeil, "A Variable-resolution BSDF Implementation": the leaves that an incident direction meets are
//! walked along the Hilbert curve through the exitant square and their projected-solid-angle-weighted values summed;
//! one number in \[0, 1) is looked up in the sums, and what is left of it says where in the leaf.
//! The walk descends the tree in Hilbert order, so nothing is sorted. Sums are fractions of the total in 32 bits, thirteen bytes
//! a leaf in all: a leaf's chance is off by 2⁻³² of the total at most.
//!
//! A guide says where to begin in the sums, so that on average O(1) of them are compared: H. C. Chen and Y. Asau, "On
//! generating random variates from an empirical distribution", AIIE Transactions 6, 1974.

use std::f64::consts::PI;

use bytemuck::{Pod, Zeroable};

use crate::cumulative::BELOW_ONE;
use crate::hilbert::{State, cell_from_hilbert};
use crate::tree::arena::{Arena, Content, Rank, Slot};
use crate::tree::cache;

/// Levels of the Hilbert index inside the unit square: 2^-26 is below the rounding of a direction in f32.
const LEVELS: u32 = 26;

/// All fractions.
const ONE: u64 = 1 << 32;

/// A leaf of the slice.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Entry {
    /// Weight of the leaves before it as a fraction of the total \[2⁻³²\].
    before: u32,
    /// Position along the curve in units of 4^-level, below a leading one that tells the level.
    place: u32,
    /// Value \[1/sr\].
    value: f32,
}

/// The leaves of one incident cell and their cumulative sums.
#[derive(Debug)]
pub(super) struct Slice {
    /// The guide, which has for each of some equal parts of the total the last entry that may hold its beginning, and behind it the
    /// entries, without black ones: one stretch of memory, since what costs time is fetching it.
    table: Box<[u32]>,
    n_parts: u32,
    total: f64,
    /// Finest and coarsest leaf met, black ones included.
    levels: [u32; 2],
}

impl Slice {
    /// Walks the leaves over an incident cell, given by its coordinates at the tree's own resolution.
    pub fn new(arena: &Arena, incident: [u32; 2]) -> Slice {
        let (mut entries, mut total, mut levels) = (Vec::new(), 0.0, [0, u32::MAX]);
        walk(arena, incident, |Met { value, level, place, .. }| {
            levels = [levels[0].max(level), levels[1].min(level)];
            if value > 0.0 {
                let entry = Entry { before: 0, place, value };
                total += entry.weight();
                entries.push(entry);
            }
        });
        let mut sum = 0.0;
        for entry in &mut entries {
            entry.before = (sum / total * ONE as f64) as u32;
            sum += entry.weight();
        }
        let mut table = guide(&entries);
        let n_parts = table.len() as u32;
        table.extend_from_slice(bytemuck::cast_slice(&entries));
        Slice { table: table.into(), n_parts, total, levels }
    }

    /// Directional-hemispherical total.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// A point of the exitant square and the BSDF there \[1/sr\], or `None` if the slice is black.
    ///
    /// Takes one number in \[0, 1), or two: then the first chooses the leaf and the place across it, the second along.
    #[inline]
    pub fn sample(&self, u: f64, v: Option<f64>) -> Option<([f64; 2], f64)> {
        match self.is_black() {
            true => None,
            false => {
                let (place, value) = self.sample_from(self.begin(u), u, v);
                Some((place.point(), value))
            }
        }
    }

    /// Where to begin in the guide for a number; the slice must not be black.
    #[inline(always)]
    pub fn guide(&self, u: f64) -> &u32 {
        let part = (u64::from(target(u) as u32) * u64::from(self.n_parts)) >> 32;
        &self.table[part as usize]
    }

    #[inline(always)]
    fn entries(&self) -> &[Entry] {
        bytemuck::cast_slice(&self.table[self.n_parts as usize..])
    }

    /// The entry to begin with for a number; the slice must not be black.
    #[inline(always)]
    fn begin(&self, u: f64) -> usize {
        *self.guide(u) as usize
    }

    /// Where an entry is in memory, to be asked for early.
    #[inline(always)]
    pub fn place_of(&self, entry: u32) -> *const u8 {
        self.entries().as_ptr().wrapping_add(entry as usize).cast()
    }

    /// Whether no leaf has light.
    #[inline(always)]
    pub fn is_black(&self) -> bool {
        self.table.is_empty()
    }

    /// [`Slice::sample`] from an entry that is not behind the one that is sought.
    #[inline(always)]
    pub fn sample_from(&self, begin: usize, u: f64, v: Option<f64>) -> (Place, f64) {
        let target = target(u);
        // What is before an entry is a whole number.
        let whole = target as u32;
        let entries = self.entries();
        let mut k = begin;
        let mut entry = entries[k];
        let mut end = ONE;
        while let Some(next) = entries.get(k + 1) {
            if next.before > whole {
                end = u64::from(next.before);
                break;
            }
            (k, entry) = (k + 1, *next);
        }
        let before = f64::from(entry.before);
        let rest = ((target - before) / (end as f64 - before)).min(BELOW_ONE);
        (Place::inside(entry.place, rest, v), f64::from(entry.value))
    }

    /// Smallest and largest projected solid angle of a leaf \[sr\].
    pub fn projected_solid_angle(&self) -> [f64; 2] {
        self.levels.map(area)
    }
}

impl cache::Slice for Slice {
    fn n_bytes(&self) -> usize {
        size_of_val(&*self.table)
    }
}

/// A number in \[0, 1) in the units of [`Entry::before`].
#[inline(always)]
fn target(u: f64) -> f64 {
    u.clamp(0.0, BELOW_ONE) * ONE as f64
}

/// A third as many parts as there are entries: comparing a few of them costs less than memory.
fn guide(entries: &[Entry]) -> Vec<u32> {
    let n = entries.len().div_ceil(3);
    let mut k = 0;
    let part = |j: usize| {
        // The least number that belongs to the part.
        let least = ((j as u64) << 32).div_ceil(n as u64);
        while entries.get(k + 1).is_some_and(|next| u64::from(next.before) <= least) {
            k += 1;
        }
        k as u32
    };
    (0..n).map(part).collect()
}

impl Entry {
    fn weight(self) -> f64 {
        f64::from(self.value) * area(level_of(self.place))
    }
}

/// The level of a leaf from where it lies on the curve, as in [`Entry`].
#[inline(always)]
pub(super) fn level_of(place: u32) -> u32 {
    place.ilog2() / 2
}

impl Place {
    /// A place in a leaf, of which is known where it lies on the curve, as in [`Entry`].
    #[inline(always)]
    pub fn inside(leaf: u32, rest: f64, v: Option<f64>) -> Place {
        let level = level_of(leaf);
        let hilbert = u64::from(leaf & !(1 << (2 * level)));
        let below = LEVELS - level;
        let n = 1u64 << below;
        let first = hilbert << (2 * below);
        match v {
            None => {
                let inside = ((rest * (n * n) as f64) as u64).min(n * n - 1);
                Place { hilbert: first | inside, across: 0, within: [0; 2] }
            }
            Some(v) => {
                let within = |t: f64| ((t * n as f64) as u64).min(n - 1) as u32;
                Place { hilbert: first, across: n as u32 - 1, within: [within(rest), within(v)] }
            }
        }
    }
}

/// A place in the exitant square, to be found on the Hilbert curve.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    /// Along the curve in units of 4^-[`LEVELS`].
    pub hilbert: u64,
    /// The bits of both coordinates that are not those of the curve,
    pub across: u32,
    /// but these.
    pub within: [u32; 2],
}

impl Place {
    /// The point of the exitant square.
    #[inline(always)]
    pub fn point(self) -> [f64; 2] {
        let (x, y) = cell_from_hilbert(self.hilbert, LEVELS);
        let coordinate = |k: u32, within: u32| {
            (f64::from((k & !self.across | within) as i32) + 0.5) / (1u64 << LEVELS) as f64
        };
        [coordinate(x, self.within[0]), coordinate(y, self.within[1])]
    }
}

/// Projected solid angle of a leaf at a level \[sr\].
pub(crate) fn area(level: u32) -> f64 {
    const AREAS: [f64; 16] = {
        let mut areas = [PI; 16];
        let mut level = 1;
        while level < 16 {
            areas[level] = areas[level - 1] * 0.25;
            level += 1;
        }
        areas
    };
    AREAS[level as usize]
}

/// A leaf over an incident cell.
pub(super) struct Met {
    /// Its slot, 0 if it is the whole tree.
    pub slot: usize,
    /// Value \[1/sr\].
    pub value: f32,
    pub level: u32,
    /// As in [`Entry`].
    pub place: u32,
}

/// Calls `meet` with all leaves over an incident cell, given by its coordinates at the tree's own resolution, in Hilbert order.
pub(super) fn walk(arena: &Arena, incident: [u32; 2], meet: impl FnMut(Met)) {
    Walk { arena, incident, meet }.descend(arena.root(), 0, State::default(), 0, 1);
}

struct Walk<'a, F> {
    arena: &'a Arena,
    incident: [u32; 2],
    meet: F,
}

impl<F: FnMut(Met)> Walk<'_, F> {
    /// `index`: of the slot. `place` as in [`Entry`].
    fn descend(&mut self, slot: Slot, index: usize, state: State, level: u32, place: u32) {
        match slot.content() {
            Content::Leaf(value) => (self.meet)(Met { slot: index, value, level, place }),
            Content::Node(node) => {
                let bit = |c: u32| (c >> (self.arena.log2_res() - 1 - level) & 1) as usize;
                let (fixed, shift) = match self.arena.rank() {
                    Rank::Three => (bit(self.incident[0]), 1),
                    Rank::Four => (bit(self.incident[0]) | bit(self.incident[1]) << 1, 2),
                };
                for k in 0..4 {
                    let (quadrant, next) = state.step(k);
                    let child = fixed | (quadrant as usize) << shift;
                    let index = self.arena.slot_of(node, child);
                    self.descend(self.arena.slots()[index], index, next, level + 1, place << 2 | k as u32);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::Tree;

    #[test]
    fn entries_are_chosen_as_often_as_they_weigh() {
        let values: Vec<f32> = (0..4096).map(|k| if k % 5 == 0 { 0.0 } else { (k % 97) as f32 }).collect();
        let tree = Tree::from_grid(Rank::Four, &values).unwrap();
        let slice = Slice::new(tree.arena(), [3, 5]);
        assert_eq!(tree.arena().log2_res(), 3);
        let n = 1 << 16;
        let mut counts = vec![0.0; 64];
        for k in 0..n {
            let ([x, y], value) = slice.sample((f64::from(k) + 0.5) / f64::from(n), None).unwrap();
            let cell = (x * 8.0) as usize * 8 + (y * 8.0) as usize;
            assert_eq!(value, f64::from(values[(3 * 8 + 5) * 64 + cell]));
            counts[cell] += 1.0 / f64::from(n);
        }
        for (cell, count) in counts.into_iter().enumerate() {
            let chance = f64::from(values[(3 * 8 + 5) * 64 + cell]) * area(3) / slice.total();
            // Evenly spread numbers miss the chance of a stretch by one of them at each end.
            assert!((count - chance).abs() <= 2.0 / f64::from(n), "{cell}: {count} {chance}");
        }
    }

    #[test]
    fn tiny_weights_and_ends_of_the_numbers_are_found() {
        let values = [1e-30f32, 1.0, 0.0, 1e-12, 1.0, 1e-30, 0.0, 0.0];
        let tree = Tree::from_grid(Rank::Three, &[values, values].concat()[..8]).unwrap();
        let slice = Slice::new(tree.arena(), [0, 0]);
        for u in [0.0, 1e-300, 0.5, BELOW_ONE, 1.0, -1.0, 2.0] {
            let (_, value) = slice.sample(u, None).unwrap();
            assert!(value > 0.0, "{u}: {value}");
        }
        assert!(Slice::new(Tree::uniform(Rank::Four, 0.0).arena(), [0, 0]).sample(0.5, None).is_none());
    }
}
