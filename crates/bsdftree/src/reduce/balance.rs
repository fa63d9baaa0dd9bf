//! Keeps the light of each incident direction by exchange: leaves that are children of one node give light to each other.
//!
//! In: a function, and a tree that is it with branches cut off, so that a leaf's mean is right for its incident cells together, not for each
//! of them. Out: the same tree with other values, whose directional-hemispherical totals are nearer to those of the function, as near as is
//! asked for if that can be. The light over every node is what it was: changes of its leaves sum to zero. No leaf changes by more than
//! nine tenths of it.
//!
//! Of all such changes that mend the totals that are off by too much, the one whose squares, each divided by the leaf's value,
//! are least is found by conjugate gradients (M. R. Hestenes and E. Stiefel, "Methods of conjugate gradients for solving linear
//! systems", Journal of Research of the National Bureau of Standards 49, 1952), and again for what is then left.

use super::source::{Source, Weights};
use super::totals::Differences;
use crate::tree::{Arena, Content, Rank, Slot, TreeBuilder, leaf_area};

/// Most rounds, and most steps of each.
const N_ROUNDS: usize = 32;
const N_STEPS: usize = 25;

/// Most that a leaf may change by, as a part of it.
const MOST: f64 = 0.9;

/// Of what the bound allows, what is aimed at where it is exceeded, and from which on totals are watched.
const AIM: f64 = 0.9;
const WATCHED: f64 = 0.8;

/// A leaf that may change.
struct Leaf {
    level: u32,
    /// Where its incident cells are among those of its level.
    cell: usize,
    value: f64,
    /// How much of the domain it is.
    weight: f64,
}

/// The leaves of a tree, those of one node together, nodes in the order in which [`rebuilt`] comes to them.
struct Balance {
    log2_res: u32,
    /// Of the incident direction.
    axes: u32,
    leaves: Vec<Leaf>,
    /// Where those of each node end.
    ends: Vec<usize>,
    /// What totals are divided by; infinite where nobody reads.
    scales: Vec<f64>,
}

/// A tree whose totals are all within a bound, or the worst as near to it as is found; only a share of that if `keeps` wants no more.
pub(super) fn balanced(
    source: &impl Source,
    reduced: &Arena,
    bound: f64,
    keeps: impl Fn(&Arena) -> bool,
) -> Option<Arena> {
    let Content::Node(root) = reduced.root().content() else { return None };
    let (rank, log2_res) = (source.rank(), source.log2_res());
    let Differences { off: base, scales } = Differences::new(source, reduced);
    let mut balance = Balance {
        log2_res,
        axes: if rank == Rank::Four { 2 } else { 1 },
        leaves: Vec::new(),
        ends: Vec::new(),
        scales,
    };
    balance.collect(reduced, root, 0, [0; 2], &Weights::new(rank, log2_res));
    let changes = balance.changes(&base, bound);
    [1.0, 0.5, 0.25, 0.125].into_iter().find_map(|share| {
        let mut builder = TreeBuilder::new(rank);
        let top = rebuilt(reduced, root, &mut changes.iter().map(|change| share * change), &mut builder);
        Some(builder.finish(top)).filter(|arena| keeps(arena))
    })
}

/// A node with its leaves changed.
fn rebuilt(
    arena: &Arena,
    node: u32,
    changes: &mut impl Iterator<Item = f64>,
    builder: &mut TreeBuilder,
) -> Slot {
    let mut children = arena.children(node).to_vec();
    for child in &mut children {
        if let Content::Leaf(value) = child.content() {
            let change = changes.next().expect("there is one for each leaf");
            *child = Slot::leaf((f64::from(value) + change).max(0.0) as f32);
        }
    }
    for child in &mut children {
        if let Content::Node(below) = child.content() {
            *child = rebuilt(arena, below, changes, builder);
        }
    }
    builder.node(&children).expect("a legal tree stays one")
}

impl Balance {
    fn collect(&mut self, arena: &Arena, node: u32, level: u32, [x, y]: [usize; 2], weights: &Weights) {
        let below = |k: usize| [x << 1 | (k & 1), if self.axes == 2 { y << 1 | (k >> 1 & 1) } else { 0 }];
        let places: Vec<[usize; 2]> = (0..arena.rank().n_children()).map(below).collect();
        for (child, &[x, y]) in arena.children(node).iter().zip(&places) {
            if let Content::Leaf(value) = child.content() {
                let value = f64::from(value);
                let weight = weights.of(level + 1, x as u32);
                self.leaves.push(Leaf { level: level + 1, cell: y << (level + 1) | x, value, weight });
            }
        }
        self.ends.push(self.leaves.len());
        for (child, &place) in arena.children(node).iter().zip(&places) {
            if let Content::Node(child) = child.content() {
                self.collect(arena, child, level + 1, place, weights);
            }
        }
    }

    /// What leaves change by, given how far totals are off.
    fn changes(&self, base: &[f64], bound: f64) -> Vec<f64> {
        let mut changes = vec![0.0; self.leaves.len()];
        let mut best = (f64::INFINITY, changes.clone());
        for _ in 0..N_ROUNDS {
            let effects = self.effects(&changes);
            let error = |((effect, base), scale): ((f64, &f64), &f64)| (effect + base) / scale;
            let errors: Vec<f64> = effects.into_iter().zip(base).zip(&self.scales).map(error).collect();
            let worst = errors.iter().fold(0.0, |worst: f64, e| worst.max(e.abs()));
            if worst < best.0 {
                best = (worst, changes.clone());
            }
            if worst <= bound {
                break;
            }
            let is_watched = |error: &f64| error.abs() > WATCHED * bound;
            let inverse = |(e, s): (&f64, &f64)| if is_watched(e) { 1.0 / s } else { 0.0 };
            let inverses: Vec<f64> = errors.iter().zip(&self.scales).map(inverse).collect();
            let wanted = |e: &f64| -(e.abs() - AIM * bound).max(0.0).copysign(*e);
            let step = self.step(errors.iter().map(wanted).collect(), &inverses);
            changes.iter_mut().zip(step).for_each(|(change, more)| *change += more);
            self.limit(&mut changes);
        }
        best.1
    }

    /// Small changes that change relative totals by as much as is wanted.
    fn step(&self, wanted: Vec<f64>, inverses: &[f64]) -> Vec<f64> {
        let times = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<f64>>();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let least = 1e-8 * dot(&wanted, &wanted);
        let (mut found, mut left) = (vec![0.0; wanted.len()], wanted);
        let mut direction = left.clone();
        let (mut size, mut ridge) = (dot(&left, &left), None);
        for _ in 0..N_STEPS {
            let mut image = times(&self.effects(&self.toward(times(&direction, inverses))), inverses);
            // Totals that hardly can be changed are left alone.
            let ridge = *ridge.get_or_insert(1e-3 * dot(&direction, &image) / size);
            image.iter_mut().zip(&direction).for_each(|(image, d)| *image += ridge * d);
            let curvature = dot(&direction, &image);
            if curvature <= 0.0 {
                break;
            }
            let share = size / curvature;
            found.iter_mut().zip(&direction).for_each(|(found, d)| *found += share * d);
            left.iter_mut().zip(&image).for_each(|(left, image)| *left -= share * image);
            let next = dot(&left, &left);
            if next < least {
                break;
            }
            direction.iter_mut().zip(&left).for_each(|(d, left)| *d = left + next / size * *d);
            size = next;
        }
        self.toward(times(&found, inverses))
    }

    /// How leaves change if the total of each incident cell is to grow in proportion to a number, without that those of a node have more
    /// light together.
    fn toward(&self, wanted: Vec<f64>) -> Vec<f64> {
        let mut levels = vec![wanted];
        for level in (0..self.log2_res).rev() {
            let fine = &levels[levels.len() - 1];
            let mut coarse = vec![0.0; 1 << (self.axes * level)];
            (0..fine.len()).for_each(|k| coarse[self.parent(level + 1, k)] += fine[k]);
            levels.push(coarse);
        }
        levels.reverse();
        let of = |leaf: &Leaf| leaf_area(leaf.level) * levels[leaf.level as usize][leaf.cell];
        let mut changes = Vec::with_capacity(self.leaves.len());
        let mut first = 0;
        for &end in &self.ends {
            let leaves = &self.leaves[first..end];
            let (light, norm) = leaves.iter().fold((0.0, 0.0), |(light, norm), leaf| {
                let give = leaf.weight * leaf.value;
                (light + give * of(leaf), norm + give * leaf.weight)
            });
            let shift = if norm > 0.0 { light / norm } else { 0.0 };
            changes.extend(leaves.iter().map(|leaf| match norm > 0.0 {
                true => leaf.value * (of(leaf) - shift * leaf.weight),
                false => 0.0,
            }));
            first = end;
        }
        changes
    }

    /// By how much totals grow by changes.
    fn effects(&self, changes: &[f64]) -> Vec<f64> {
        let mut levels: Vec<Vec<f64>> =
            (0..=self.log2_res).map(|level| vec![0.0; 1 << (self.axes * level)]).collect();
        for (leaf, change) in self.leaves.iter().zip(changes) {
            levels[leaf.level as usize][leaf.cell] += change * leaf_area(leaf.level);
        }
        for level in 1..=self.log2_res {
            let (above, below) = levels.split_at_mut(level as usize);
            let coarse = &above[level as usize - 1];
            below[0].iter_mut().enumerate().for_each(|(k, sum)| *sum += coarse[self.parent(level, k)]);
        }
        levels.pop().expect("there is the finest")
    }

    /// The cell of the level above that a cell of a level is in.
    fn parent(&self, level: u32, k: usize) -> usize {
        match self.axes {
            1 => k >> 1,
            _ => (k >> level >> 1) << (level - 1) | (k & ((1 << level) - 1)) >> 1,
        }
    }

    /// Makes all changes of a node's leaves smaller if one is too large.
    fn limit(&self, changes: &mut [f64]) {
        let mut first = 0;
        for &end in &self.ends {
            let pairs = self.leaves[first..end].iter().zip(&changes[first..end]);
            let ratio =
                |(leaf, change): (&Leaf, &f64)| if *change == 0.0 { 0.0 } else { change.abs() / leaf.value };
            let largest = pairs.map(ratio).fold(0.0, f64::max);
            if largest > MOST {
                changes[first..end].iter_mut().for_each(|change| *change *= MOST / largest);
            }
            first = end;
        }
    }
}
