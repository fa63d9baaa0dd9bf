//! How steep a tree is in each of its leaves: what turns steps into ramps.
//!
//! In: an arena. Out: for each leaf one slope per dimension, so that the leaf holds value × (1 + Σ slope·t), where t runs from −1 to 1
//! across it. Invariants: the mean over a leaf is the leaf's own value (the map to the square keeps areas, so energy is kept leaf by
//! leaf), and nowhere is it negative.
//!
//! A slope is that between the values on both sides, no steeper than twice the flatter side and none where the leaf is higher or lower
//! than both: B. van Leer, "Towards the ultimate conservative difference scheme IV", Journal of Computational Physics 23, 1977,
//! section 4 (the monotonised central difference). So a peak of one cell stays what it is. Deviations: of finer neighbours the mean over
//! a cell of the leaf's own size is taken, or over its near half if that makes the slope flatter; of a coarser one what its own slopes of the round before give in such a cell; and at the border
//! of the domain, where there is one side only, half the slope to it: BSDFs bend there more than elsewhere.

use crate::direction::Direction;
use crate::tree::arena::{Arena, Content, MAX_LOG2_RES, Rank, Slot};
use crate::tree::batch::ask;
use crate::tree::ramp_totals;
use crate::tree::walk::child_cell;

/// Slopes of one leaf in units of 2⁻¹⁵; their sizes sum up to 2¹⁵ at most.
pub(super) type Slope = [i16; 4];

/// Slope 1.
const UNIT: f64 = (1u32 << 15) as f64;

/// How often slopes are made, each time from those before.
const ROUNDS: usize = 2;

/// The slopes of all leaves, by slot.
pub(super) struct Slopes(Box<[Slope]>);

impl Slopes {
    /// Those of an arena; `beside` is what leaves besides for an incident direction.
    pub fn new(arena: &Arena, beside: &dyn Fn(Direction) -> f64) -> Slopes {
        let flat = vec![[0.0; 4]; arena.slots().len()];
        let mut fit = Fit { arena, means: vec![0.0; arena.n_nodes()], rises: flat.clone() };
        if let Content::Node(root) = arena.root().content() {
            fit.mean(root);
            for _ in 0..ROUNDS {
                let mut rises = flat.clone();
                fit.descend(&mut [root; MAX_LOG2_RES as usize], 0, [0; 4], &mut rises);
                fit.rises = rises;
            }
        }
        let relative = |(slot, rises): (&Slot, [f32; 4])| match slot.content() {
            // Towards 0 and a little less, so that the sum stays below one.
            Content::Leaf(value) if value > 0.0 => {
                rises.map(|rise| (f64::from(rise) / f64::from(value) * (UNIT - 2.0)) as i16)
            }
            _ => [0; 4],
        };
        let mut slopes: Box<[Slope]> = arena.slots().iter().zip(fit.rises).map(relative).collect();
        ramp_totals::keep(arena, &mut slopes, beside);
        Slopes(slopes)
    }

    /// Those of the rank-4 tree with incident and exitant directions swapped.
    pub fn reversed(&self, arena: &Arena, reversed: &Arena) -> Slopes {
        let mut slopes = vec![[0; 4]; reversed.slots().len()];
        self.copy_reversed([arena, reversed], [arena.root(), reversed.root()], &mut slopes);
        Slopes(slopes.into())
    }

    fn copy_reversed(&self, arenas: [&Arena; 2], slots: [Slot; 2], slopes: &mut [Slope]) {
        let [Content::Node(from), Content::Node(to)] = slots.map(Slot::content) else { return };
        for (k, &child) in arenas[0].children(from).iter().enumerate() {
            let mirrored = reversed_child(k);
            let [a, b, c, d] = self.0[from as usize * 16 + k];
            slopes[to as usize * 16 + mirrored] = [-c, -d, -a, -b];
            self.copy_reversed(arenas, [child, arenas[1].child(to, mirrored)], slopes);
        }
    }

    /// Of the leaf in a slot.
    #[inline(always)]
    pub fn of(&self, slot: usize) -> Slope {
        // A tree of one leaf has no slots.
        self.0.get(slot).copied().unwrap_or_default()
    }

    /// Asks early for those of a slot.
    #[inline(always)]
    pub fn ask(&self, slot: usize) {
        ask(self.0.as_ptr().wrapping_add(slot));
    }

    /// Memory \[byte\].
    pub fn n_bytes(&self) -> usize {
        size_of_val(&*self.0)
    }
}

/// Which child of a rank-4 node another becomes when incident and exitant directions are swapped.
#[inline(always)]
pub(super) fn reversed_child(k: usize) -> usize {
    let mirrored = !k & 15;
    mirrored >> 2 | (mirrored & 3) << 2
}

/// A slope as a number from −1 to 1.
#[inline(always)]
pub(super) fn steepness(slope: i16) -> f64 {
    f64::from(slope) * (1.0 / UNIT)
}

struct Fit<'a> {
    arena: &'a Arena,
    /// Of nodes.
    means: Vec<f64>,
    /// From the middle of a leaf to its upper side \[1/sr\], by slot.
    rises: Vec<[f32; 4]>,
}

impl Fit<'_> {
    fn mean(&mut self, node: u32) -> f64 {
        let arena = self.arena;
        let children = arena.children(node).iter().map(|child| match child.content() {
            Content::Leaf(value) => f64::from(value),
            Content::Node(node) => self.mean(node),
        });
        let mean = children.sum::<f64>() / arena.rank().n_children() as f64;
        self.means[node as usize] = mean;
        mean
    }

    fn slot(&self, node: u32, child: usize) -> usize {
        node as usize * self.arena.rank().n_children() + child
    }

    /// Makes the rises of all leaves below the last node of a path, whose cell has its lower corner at `at` in units of its edge.
    fn descend(
        &self,
        path: &mut [u32; MAX_LOG2_RES as usize],
        level: usize,
        at: [u32; 4],
        rises: &mut [[f32; 4]],
    ) {
        let node = path[level];
        for (k, child) in self.arena.children(node).iter().enumerate() {
            let cell = child_cell(at, k);
            match child.content() {
                Content::Leaf(value) => {
                    rises[self.slot(node, k)] = self.leaf(f64::from(value), &path[..=level], cell)
                }
                Content::Node(node) => {
                    path[level + 1] = node;
                    self.descend(path, level + 1, cell, rises);
                }
            }
        }
    }

    fn leaf(&self, value: f64, path: &[u32], at: [u32; 4]) -> [f32; 4] {
        let mut rises = [0.0; 4];
        for (axis, rise) in rises[..self.arena.rank().dimensions()].iter_mut().enumerate() {
            let [below, above] = [-1, 1].map(|step| self.difference(value, path, at, axis, step));
            *rise = limited(below.map(|below| -below), above);
        }
        let steepest: f64 = rises.iter().map(|rise| rise.abs()).sum();
        let share = if steepest > value { value / steepest } else { 1.0 };
        rises.map(|rise| (rise * share) as f32)
    }

    /// How much higher the cell beside a leaf is, which is as large and to which a path leads; `None` behind the border of the domain.
    fn difference(&self, value: f64, path: &[u32], at: [u32; 4], axis: usize, step: i32) -> Option<f64> {
        let level = path.len();
        // Of rank 3 only the lower half of dimension 0 is used.
        let is_half = axis == 0 && self.arena.rank() == Rank::Three;
        let n = if is_half { 1 << (level - 1) } else { 1 << level };
        let mut beside = at;
        beside[axis] = at[axis].checked_add_signed(step).filter(|&c| c < n)?;
        // Up to the cell that holds both, and down again.
        let up = (at[axis] ^ beside[axis]).ilog2() as usize + 1;
        let mut node = path[level - up];
        for below in (0..up).rev() {
            let child = (0..4).fold(0, |child, i| child | (beside[i] as usize >> below & 1) << i);
            let slot = self.slot(node, child);
            match self.arena.slots()[slot].content() {
                Content::Leaf(found) => return Some(self.inside(found, slot, below, beside) - value),
                Content::Node(next) => node = next,
            }
        }
        // The half of it that touches the leaf is at three quarters of the distance.
        let far = self.means[node as usize] - value;
        let near = (self.half(node, axis, usize::from(step < 0)) - value) / 0.75;
        Some(if far * near <= 0.0 { 0.0 } else { near.abs().min(far.abs()).copysign(near) })
    }

    /// The mean over one half of a node along an axis.
    fn half(&self, node: u32, axis: usize, side: usize) -> f64 {
        let children = self.arena.children(node);
        let halves = children.iter().enumerate().filter(|(k, _)| k >> axis & 1 == side);
        let means = halves.map(|(_, child)| match child.content() {
            Content::Leaf(value) => f64::from(value),
            Content::Node(node) => self.means[node as usize],
        });
        means.sum::<f64>() / (children.len() / 2) as f64
    }

    /// What a leaf has in the middle of a cell that is so many levels finer.
    fn inside(&self, value: f32, slot: usize, finer: usize, cell: [u32; 4]) -> f64 {
        let n = 1u32 << finer;
        let t = cell.map(|c| f64::from(2 * (c & (n - 1)) + 1) / f64::from(n) - 1.0);
        let rises = self.rises[slot].iter().zip(t);
        rises.fold(f64::from(value), |value, (&rise, t)| value + f64::from(rise) * t)
    }
}

/// The rise across half a leaf from those of the values below and above it.
fn limited(below: Option<f64>, above: Option<f64>) -> f64 {
    match (below, above) {
        (Some(below), Some(above)) if below * above > 0.0 => {
            let most = below.abs().min(above.abs());
            (0.25 * (below + above)).clamp(-most, most)
        }
        (Some(_), Some(_)) | (None, None) => 0.0,
        (Some(only), None) | (None, Some(only)) => 0.25 * only,
    }
}
