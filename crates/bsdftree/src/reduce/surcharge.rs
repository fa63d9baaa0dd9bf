//! Surcharges on cuts that change totals, so that the cheapest tree keeps the light of each incident direction too.
//!
//! In: what nodes cost as leaves, and by how much the totals of a tree that was cut at these costs are off. Out: higher costs of those nodes
//! that would add to what is off. A tree that is cut by them is the cheapest again for its number of leaves, of another cost: the error plus,
//! for each incident cell i, w⁺ᵢ times the sum of what leaves add to its total, and w⁻ᵢ times that of what they take away. Weights
//! begin with 0; w⁺ᵢ grows while the total is too large, and shrinks again, w⁻ᵢ while it is too small (a Lagrangian with multipliers by
//! subgradients, N. Z. Shor, "Minimization Methods for Non-Differentiable Functions", 1985, chapter 2). Deviation: what adds and
//! what takes away is weighed apart, so that no cut is ever rewarded; a reward is greatest for the coarsest cuts.

use super::measure::Measures;
use super::source::{Source, Weights};
use super::totals::Differences;
use super::{Norm, Reduction};
use crate::tree::{Content, Rank, Slot, Tree, leaf_area};

/// Most rounds.
const N_ROUNDS: usize = 16;

/// By how many times totals are to be nearer at most: more than is found.
const MOST_TIMES: f64 = 10.0;

/// By how much a weight grows where a total is off by twice the bound; 1 makes a change of a total as dear as an error of as much light.
const STEP: f64 = 0.5;

/// The largest excess that counts, in bounds.
const MOST: f64 = 3.0;

/// How much slower weights shrink where a total is within the bound.
const BACK: f64 = 0.2;

impl<S: Source> Reduction<S> {
    /// A tree of at most so many leaves whose totals are within a bound, or as near to it as is found, given the cheapest one.
    pub(super) fn with_surcharges(&self, cheapest: Tree, n_leaves: usize, bound: f64) -> Tree {
        let [l1, squares] = self.source.lost(cheapest.arena());
        let per_light = match self.norm {
            Norm::Rms if l1 > 0.0 => self.scale * squares / l1,
            _ => self.scale,
        };
        let mut surcharge = Surcharge::new(&self.source, per_light);
        let mut off = Differences::new(&self.source, cheapest.arena());
        let mut best = (off.worst(), cheapest);
        let bound = bound.max(best.0 / MOST_TIMES);
        for _ in 0..N_ROUNDS {
            if best.0 <= bound {
                break;
            }
            surcharge.learn(&off, bound);
            let measures = self.measures.with_errors(surcharge.errors(&self.source, &self.measures));
            let tree = self.tree(&self.of_leaves(&measures, n_leaves).is_cut);
            off = Differences::new(&self.source, tree.arena());
            if off.worst() < best.0 {
                best = (off.worst(), tree);
            }
        }
        best.1
    }
}

/// What it costs to change totals.
pub(super) struct Surcharge {
    rank: Rank,
    log2_res: u32,
    /// Weights of what is too much and of what is too little, for each finest incident cell.
    weights: [Vec<f64>; 2],
    /// By what they are multiplied, so that 1 is as dear as an error.
    units: Vec<f64>,
}

impl Surcharge {
    /// None yet. `per_light` is what an error costs beside the light that is misplaced by it.
    pub fn new(source: &impl Source, per_light: f64) -> Surcharge {
        let (rank, log2_res) = (source.rank(), source.log2_res());
        let side = 1usize << log2_res;
        let n_cells = if rank == Rank::Four { side * side } else { side };
        let areas = Weights::new(rank, log2_res);
        let unit = |k: usize| per_light * areas.of(log2_res, (k % side) as u32) / leaf_area(log2_res);
        let weights = [vec![0.0; n_cells], vec![0.0; n_cells]];
        Surcharge { rank, log2_res, weights, units: (0..n_cells).map(unit).collect() }
    }

    /// Changes weights by how far totals are off.
    pub fn learn(&mut self, off: &Differences, bound: f64) {
        for (weights, sign) in self.weights.iter_mut().zip([1.0, -1.0]) {
            for (weight, error) in weights.iter_mut().zip(off.relative()) {
                let excess = (sign * error / bound - 1.0).clamp(-1.0, MOST);
                let change = STEP * if excess > 0.0 { excess } else { BACK * excess };
                *weight = (*weight + change).max(0.0);
            }
        }
    }

    /// What nodes cost as leaves, with surcharges.
    pub fn errors(&self, source: &impl Source, measures: &Measures) -> Vec<f32> {
        let mut errors = measures.errors.clone();
        if let Content::Node(root) = source.root().content() {
            let cells = |level: u32| match self.rank {
                Rank::Four => 1usize << (2 * (self.log2_res - level)),
                Rank::Three => 1 << (self.log2_res - level),
            };
            let light = (0..=self.log2_res).map(|level| vec![0.0; cells(level)]).collect();
            let dear = self.dear();
            Walk { surcharge: self, source, means: &measures.means, errors: &mut errors, light, dear }
                .node(root, 0, [0; 2]);
        }
        errors
    }

    /// Whether there is a weight in each incident cell of each level.
    fn dear(&self) -> Vec<Vec<bool>> {
        let [over, under] = &self.weights;
        let mut levels: Vec<Vec<bool>> = vec![over.iter().zip(under).map(|(a, b)| a + b > 0.0).collect()];
        for level in (0..self.log2_res).rev() {
            let (fine, side) = (levels.last().expect("there is the finest"), 2 << level);
            let at = |x: usize, y: usize| fine[y * side + x];
            let of = |x: usize, y: usize| at(2 * x, y) || at(2 * x + 1, y);
            let half = side / 2;
            levels.push(match self.rank {
                Rank::Three => (0..half).map(|x| of(x, 0)).collect(),
                Rank::Four => {
                    let cells = (0..half).flat_map(|y| (0..half).map(move |x| (x, y)));
                    cells.map(|(x, y)| of(x, 2 * y) || of(x, 2 * y + 1)).collect()
                }
            });
        }
        levels.reverse();
        levels
    }
}

/// Goes over all nodes that change a total that has a weight.
struct Walk<'a, S> {
    surcharge: &'a Surcharge,
    source: &'a S,
    means: &'a [f32],
    errors: &'a mut [f32],
    /// What a node of each level gives to its incident cells; where there is no weight, anything.
    light: Vec<Vec<f64>>,
    dear: Vec<Vec<bool>>,
}

impl<S: Source> Walk<'_, S> {
    /// Adds surcharges in a branch, and makes the light of its node.
    fn node(&mut self, node: u32, level: u32, cell: [usize; 2]) {
        let rank = self.surcharge.rank;
        let mut light = std::mem::take(&mut self.light[level as usize]);
        if level + 1 == self.surcharge.log2_res {
            self.source.totals_below(node, level, &mut light);
        } else {
            light.fill(0.0);
            let half = 1usize << (self.surcharge.log2_res - level - 1);
            let rows = if rank == Rank::Four { half } else { 1 };
            for (k, child) in self.source.children(node)[..rank.n_children()].iter().enumerate() {
                let [x, y] = [k & 1, if rank == Rank::Four { k >> 1 & 1 } else { 0 }];
                let below = [cell[0] << 1 | x, cell[1] << 1 | y];
                if !self.dear[level as usize + 1][below[1] << (level + 1) | below[0]] {
                    continue;
                }
                self.child(*child, level + 1, below);
                for row in 0..rows {
                    let from = &self.light[level as usize + 1][row * half..][..half];
                    let to = &mut light[(y * half + row) * 2 * half + x * half..][..half];
                    to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
                }
            }
        }
        let mean = f64::from(self.means[node as usize]) * leaf_area(level);
        self.errors[node as usize] += self.of(mean, &light, level, cell) as f32;
        self.light[level as usize] = light;
    }

    /// The same of a child, which may be a leaf.
    fn child(&mut self, slot: Slot, level: u32, cell: [usize; 2]) {
        match slot.content() {
            Content::Leaf(value) => self.light[level as usize].fill(f64::from(value) * leaf_area(level)),
            Content::Node(node) => self.node(node, level, cell),
        }
    }

    /// The surcharge of a node that gives so much to all its incident cells in place of what each had.
    fn of(&self, mean: f64, light: &[f64], level: u32, cell: [usize; 2]) -> f64 {
        let Surcharge { weights: [over, under], units, log2_res, .. } = self.surcharge;
        let side = 1usize << (log2_res - level);
        let mut sum = 0.0;
        for (y, light) in light.chunks_exact(side).enumerate() {
            let first = ((cell[1] * side + y) << log2_res) + cell[0] * side;
            let cells = first..first + side;
            let weights = over[cells.clone()].iter().zip(&under[cells.clone()]).zip(&units[cells]);
            for (light, ((over, under), unit)) in light.iter().zip(weights) {
                let change = mean - light;
                sum += unit * change.abs() * if change > 0.0 { over } else { under };
            }
        }
        sum
    }
}
