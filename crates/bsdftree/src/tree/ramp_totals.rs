//! Keeps the light of each incident direction where leaves have ramps: those of a peak that wanders over its neighbours would add up to
//! more light than there is.
//!
//! In: an arena and the slopes of its leaves. Out: slopes along the incident axes made flatter, so that inside each finest incident cell no
//! directional-hemispherical total is above the largest of the cells around it (or below the smallest) by more than [`SLACK`] of it,
//! neither alone nor with what else leaves on the other side.
//! What raises a total at a corner of a cell is made flatter by one factor, what lowers it stays, and the other way round; each leaf by the
//! smallest factor of its cells; again, until all totals are kept: S. T. Zalesak, "Fully multidimensional flux-corrected transport algorithms for
//! fluids", Journal of Computational Physics 31, 1979. Deviation: what lowers a total counts against what raises it, but in the last rounds.

use crate::direction::Direction;
use crate::tree::arena::{Arena, Content, Rank, Slot};
use crate::tree::coordinates::incident_direction;
use crate::tree::slice::area;
use crate::tree::slopes::{Slope, steepness};
use crate::tree::totals::{Totals, incident_axes};
use crate::tree::walk::child_cell;

/// How much more than around it a total may be, as a part of itself. With less, ramps of smooth functions are lost: at 0.1 %, a quarter of
/// what they gain.
const SLACK: f64 = 0.01;

/// Rounds that count what lowers against what raises; and all of them, after which no incident ramp is left.
const ROUNDS: [usize; 2] = [12, 60];

/// Makes incident slopes flatter until totals are kept; `beside` is what leaves besides for an incident direction. Where there are too many
/// incident cells to know, none is left.
pub(super) fn keep(arena: &Arena, slopes: &mut [Slope], beside: &dyn Fn(Direction) -> f64) {
    if arena.n_nodes() == 0 {
        return;
    }
    let Some(limits) = Limits::new(arena, beside) else {
        return flatten(arena.rank(), slopes);
    };
    let leaves = leaves(arena);
    for round in 0..ROUNDS[1] {
        let changes = limits.changes(arena.rank(), &leaves, slopes);
        let Some(factors) = limits.factors(&changes, round >= ROUNDS[0]) else { return };
        for leaf in &leaves {
            let factor = limits.factor(arena.rank(), leaf, slopes[leaf.slot], &factors);
            if factor < 1.0 {
                for slope in incident(arena.rank(), &mut slopes[leaf.slot]) {
                    *slope = (f64::from(*slope) * factor) as i16;
                }
            }
        }
    }
    flatten(arena.rank(), slopes);
}

/// Those along the incident axes.
fn incident(rank: Rank, slope: &mut Slope) -> &mut [i16] {
    &mut slope[..incident_axes(rank) as usize]
}

fn flatten(rank: Rank, slopes: &mut [Slope]) {
    slopes.iter_mut().for_each(|slope| incident(rank, slope).fill(0));
}

/// A leaf of light.
struct Leaf {
    slot: usize,
    level: u32,
    /// Its incident cell.
    cell: [u32; 2],
    /// What it adds to totals.
    light: f64,
}

fn leaves(arena: &Arena) -> Vec<Leaf> {
    fn collect(
        arena: &Arena,
        (slot, index): (Slot, usize),
        level: u32,
        cell: [u32; 4],
        leaves: &mut Vec<Leaf>,
    ) {
        match slot.content() {
            Content::Leaf(value) if value > 0.0 => {
                let light = f64::from(value) * area(level);
                let y = if arena.rank() == Rank::Four { cell[1] } else { 0 };
                leaves.push(Leaf { slot: index, level, cell: [cell[0], y], light });
            }
            Content::Leaf(_) => {}
            Content::Node(node) => {
                for (k, &child) in arena.children(node).iter().enumerate() {
                    let index = arena.slot_of(node, k);
                    collect(arena, (child, index), level + 1, child_cell(cell, k), leaves);
                }
            }
        }
    }
    let mut leaves = Vec::new();
    collect(arena, (arena.root(), 0), 0, [0; 4], &mut leaves);
    leaves
}

/// Numbers for the four corners of each finest incident cell: what raises and what lowers.
type Corners = Vec<[[f64; 2]; 4]>;

/// What totals may be.
struct Limits {
    log2_res: u32,
    /// Finest incident cells along both axes.
    n: [usize; 2],
    totals: Vec<f64>,
    least: Vec<f64>,
    most: Vec<f64>,
}

impl Limits {
    fn new(arena: &Arena, beside: &dyn Fn(Direction) -> f64) -> Option<Limits> {
        let totals = Totals::new(arena, |_, value| [value])?;
        let side = 1usize << arena.log2_res();
        let n = [side, if arena.rank() == Rank::Four { side } else { 1 }];
        let value = |x: usize, y: usize| totals.of([x as u32, y as u32])[0];
        let cells: Vec<[usize; 2]> = (0..n[1]).flat_map(|y| (0..n[0]).map(move |x| [x, y])).collect();
        let around = |[x, y]: [usize; 2]| {
            let range = |c: usize, n: usize| c.saturating_sub(1)..(c + 2).min(n);
            range(y, n[1]).flat_map(move |y| range(x, n[0]).map(move |x| [x, y]))
        };
        // Ramps have their largest totals at corners.
        const CORNERS: [[f64; 2]; 5] =
            [[0.5, 0.5], [0.001, 0.001], [0.999, 0.001], [0.001, 0.999], [0.999, 0.999]];
        let most_beside = |cell: &[usize; 2]| {
            let at = |corner: [f64; 2]| [0, 1].map(|axis| (cell[axis] as f64 + corner[axis]) / side as f64);
            let totals = CORNERS.map(|corner| beside(incident_direction(arena.rank(), at(corner))));
            totals.into_iter().fold(0.0, f64::max)
        };
        let others: Vec<f64> = cells.iter().map(most_beside).collect();
        let other = |x: usize, y: usize| others[y * side + x];
        let room = |&cell: &[usize; 2], most: f64| {
            let [own, beside] = [value(cell[0], cell[1]), other(cell[0], cell[1])];
            let sums = around(cell).map(|[x, y]| value(x, y) + other(x, y));
            most.min(sums.fold(0.0, f64::max) * (1.0 + SLACK) - beside).max(own)
        };
        let extreme = |pick: fn(f64, f64) -> f64, slack: f64| {
            let of = |&cell: &[usize; 2]| {
                let own = value(cell[0], cell[1]);
                around(cell).map(|[x, y]| value(x, y)).fold(own, pick) * slack
            };
            cells.iter().map(of).collect::<Vec<f64>>()
        };
        let most = extreme(f64::max, 1.0 + SLACK);
        Some(Limits {
            log2_res: arena.log2_res(),
            n,
            totals: cells.iter().map(|&[x, y]| value(x, y)).collect(),
            least: extreme(f64::min, 1.0 - SLACK),
            most: cells.iter().zip(most).map(|(cell, most)| room(cell, most)).collect(),
        })
    }

    /// Calls `f` with the index of each finest cell of a leaf and what the leaf adds at its corners.
    fn over_corners(&self, rank: Rank, leaf: &Leaf, slope: Slope, mut f: impl FnMut(usize, [f64; 4])) {
        let [a, b] = [steepness(slope[0]), if rank == Rank::Four { steepness(slope[1]) } else { 0.0 }];
        if a == 0.0 && b == 0.0 {
            return;
        }
        let n = 1usize << (self.log2_res - leaf.level);
        let rows = if rank == Rank::Four { n } else { 1 };
        let edges =
            |c: usize, slope: f64| [c, c + 1].map(|c| (2.0 * c as f64 / n as f64 - 1.0) * slope * leaf.light);
        for y in 0..rows {
            let first = (leaf.cell[1] as usize * n + y) * self.n[0] + leaf.cell[0] as usize * n;
            let low_high = if rank == Rank::Four { edges(y, b) } else { [0.0; 2] };
            for x in 0..n {
                let left_right = edges(x, a);
                f(first + x, std::array::from_fn(|corner| left_right[corner & 1] + low_high[corner >> 1]));
            }
        }
    }

    fn changes(&self, rank: Rank, leaves: &[Leaf], slopes: &[Slope]) -> Corners {
        let mut changes = vec![[[0.0; 2]; 4]; self.totals.len()];
        for leaf in leaves {
            self.over_corners(rank, leaf, slopes[leaf.slot], |cell, corners| {
                for (sums, change) in changes[cell].iter_mut().zip(corners) {
                    sums[usize::from(change < 0.0)] += change.abs();
                }
            });
        }
        changes
    }

    /// By how much to flatten what raises and what lowers at each corner; `None` if all totals are kept.
    fn factors(&self, changes: &Corners, is_strict: bool) -> Option<Corners> {
        let mut all_kept = true;
        let factors = changes.iter().enumerate().map(|(cell, corners)| {
            corners.map(|[up, down]| {
                let total = self.totals[cell];
                let rooms = [self.most[cell] - total, total - self.least[cell]];
                let mut factors = [1.0; 2];
                for (way, [more, less]) in [[up, down], [down, up]].into_iter().enumerate() {
                    if more - less > rooms[way] + 1e-12 * total {
                        all_kept = false;
                        let against = if is_strict { 0.0 } else { less };
                        // A little less, so that rounding does not need another round.
                        factors[way] = (0.9999 * (rooms[way] + against) / more).min(0.9999);
                    }
                }
                factors
            })
        });
        let factors = factors.collect();
        (!all_kept).then_some(factors)
    }

    fn factor(&self, rank: Rank, leaf: &Leaf, slope: Slope, factors: &Corners) -> f64 {
        let mut least = 1.0f64;
        self.over_corners(rank, leaf, slope, |cell, corners| {
            for (factors, change) in factors[cell].iter().zip(corners) {
                least = least.min(factors[usize::from(change < 0.0)]);
            }
        });
        least
    }
}
