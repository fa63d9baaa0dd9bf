//! Smaller trees with an error that the caller chooses.
//!
//! In: a tree, and what may be lost: bounds on errors, or a number of leaves. Out: a tree that is the first one with branches cut off,
//! each of which became a leaf of its mean, so that the light over every leaf is kept exactly. For the norm that is bounded (or
//! chosen) no tree made that way with as few leaves has a smaller error; errors are those of the result, computed anew.
//!
//! Source: Radiance's rttree_reduce, which cuts off a percentage of branches by a score of its own.

mod source;
mod measure;
mod grid;
mod noise;
mod prune;
mod totals;
mod surcharge;
mod balance;
mod whole;

use thiserror::Error;

use crate::tree::{Arena, Content, Rank, Slot, Totals, Tree, TreeBuilder, TreeError};
pub use noise::{Noise, SIGNIFICANCE};

use grid::Grid;
use measure::Measures;
use prune::{Cost, Pruning, between, boundary, boundary_of_trees};
use source::{Nodes, Source};

/// How differences are weighed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// By their size.
    #[default]
    L1,
    /// By their square.
    Rms,
}

impl Norm {
    #[inline(always)]
    fn of(self, difference: f64) -> f64 {
        match self {
            Norm::L1 => difference.abs(),
            Norm::Rms => difference * difference,
        }
    }
}

/// What a reduced tree may have lost. Bounds that are not given are not kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// Most of ∫|f − g| / ∫f.
    pub l1: Option<f64>,
    /// Most of √∫(f − g)² / √∫f².
    pub rms: Option<f64>,
    /// Most of |H_f − H_g| / max(H_f, [`LEAST_TOTAL`]), H being the directional-hemispherical totals of any finest incident cell.
    pub total: Option<f64>,
    /// To what leaves that are children of one node bring `total` by giving light to each other, as far as they can: then the light over
    /// every node is kept, but not over each of its leaves. Bounds on other errors are kept. Of trees of a number of leaves, one is taken
    /// whose totals are near to that before.
    pub balance: Option<f64>,
    /// Most leaves.
    pub n_leaves: Option<usize>,
    /// What is made least where only a number of leaves is given, or a bound on totals.
    pub norm: Norm,
}

/// Totals below are not the measure of their errors, but this is.
pub const LEAST_TOTAL: f64 = 0.1;

/// How far a tree is from the one it was made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loss {
    /// ∫|f − g| / ∫f.
    pub l1: f64,
    /// √∫(f − g)² / √∫f².
    pub rms: f64,
    /// Mean over incident directions of |H_f − H_g| / max(H_f, [`LEAST_TOTAL`]).
    pub mean_total: f64,
    /// Largest of those.
    pub worst_total: f64,
    /// The point of the square in the middle of the incident cell that has it; of rank 3 d0, and 0.
    pub worst_at: [f64; 2],
}

/// What is asked for cannot be.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ReduceError {
    /// No bound at all.
    #[error("nothing says how far to reduce; give a bound on an error or a number of leaves")]
    NoGoal,
    /// A bound that is no number ≥ 0.
    #[error("the bound of {0} is {1}; expected a number of at least 0")]
    Bound(&'static str, f64),
    /// Values that are no grid.
    #[error(transparent)]
    Grid(#[from] TreeError),
    /// Variances or counts that are none.
    #[error("{0}; expected one number of at least 0 for each value")]
    Noise(String),
    /// More incident cells than totals are kept of.
    #[error(
        "a tree of 2^{0} cells per axis is too fine to be reduced; convert it to a coarser one first (`convert --tree`)"
    )]
    TooFine(u32),
    /// Not a tree with branches cut off.
    #[error(
        "the second tree is of another rank, or finer than the first in some place; expected one that was reduced"
    )]
    NoPart,
    /// A size that no tree has.
    #[error("{least} is the least there can be; {asked} were asked for")]
    Size {
        /// Of the smallest.
        least: usize,
        /// That was asked for.
        asked: usize,
    },
    /// Bounds that no tree of so few leaves keeps.
    #[error("{needed} leaves are needed to keep the bounds; {asked} were asked for")]
    Leaves {
        /// With which they are kept.
        needed: usize,
        /// That were asked for.
        asked: usize,
    },
}

impl Goal {
    /// Whether nothing is asked for.
    pub fn is_empty(&self) -> bool {
        *self == Goal { norm: self.norm, ..Goal::default() }
    }

    fn validated(self) -> Result<Goal, ReduceError> {
        let bounds = [("L1", self.l1), ("RMS", self.rms), ("totals", self.total), ("balance", self.balance)];
        if bounds[..3].iter().all(|(_, bound)| bound.is_none()) && self.n_leaves.is_none() {
            return Err(ReduceError::NoGoal);
        }
        for (name, bound) in bounds {
            if let Some(bound) = bound.filter(|b| b.is_nan() || *b < 0.0) {
                return Err(ReduceError::Bound(name, bound));
            }
        }
        Ok(self)
    }

    fn norm(&self) -> Norm {
        match (self.l1, self.rms) {
            (Some(_), _) => Norm::L1,
            (None, Some(_)) => Norm::Rms,
            (None, None) => self.norm,
        }
    }

    fn is_kept_by(&self, loss: &Loss) -> bool {
        let within = |bound: Option<f64>, error: f64| bound.is_none_or(|bound| error <= bound);
        within(self.l1, loss.l1) && within(self.rms, loss.rms) && within(self.total, loss.worst_total)
    }
}

impl Tree {
    /// A tree of as few leaves as keep the goal's bounds, or of as little error as its number of leaves allows, and what was lost.
    ///
    /// # Errors
    /// If the goal says nothing, or its bounds need more leaves than it has.
    pub fn reduced(&self, goal: &Goal) -> Result<(Tree, Loss), ReduceError> {
        let goal = goal.validated()?;
        self.has_totals()?;
        let arena = self.arena().in_level_order();
        Reduction::new(Nodes::new(&arena), goal.norm()).best(&goal)
    }

    /// As [`Tree::from_grid`] and then [`Tree::reduced`], without the whole tree in memory: an eighth of the grid is what it takes.
    ///
    /// # Errors
    /// As those.
    pub fn reduced_from_grid(rank: Rank, values: &[f32], goal: &Goal) -> Result<(Tree, Loss), ReduceError> {
        let goal = goal.validated()?;
        Reduction::new(Grid::new(rank, values)?, goal.norm()).best(&goal)
    }

    fn has_totals(&self) -> Result<(), ReduceError> {
        let log2_res = self.arena().log2_res();
        Totals::<1>::are_kept(self.rank(), log2_res).then_some(()).ok_or(ReduceError::TooFine(log2_res))
    }

    /// How far another tree is from this one, of which it has nowhere smaller leaves.
    ///
    /// # Errors
    /// If it is of the other rank, or has.
    pub fn loss_of(&self, reduced: &Tree) -> Result<Loss, ReduceError> {
        if self.rank() != reduced.rank()
            || !is_part(self.arena(), reduced.arena(), [self.arena().root(), reduced.arena().root()])
        {
            return Err(ReduceError::NoPart);
        }
        self.has_totals()?;
        Ok(loss(&Nodes::new(self.arena()), reduced.arena()))
    }
}

/// How far a tree with branches cut off is from the whole one.
fn loss(whole: &impl Source, reduced: &Arena) -> Loss {
    totals::with_totals(measure::loss(whole, reduced), whole, reduced)
}

/// Whether the second tree is nowhere finer than the first.
fn is_part(whole: &Arena, reduced: &Arena, slots: [Slot; 2]) -> bool {
    match slots.map(Slot::content) {
        [_, Content::Leaf(_)] => true,
        [Content::Leaf(_), Content::Node(_)] => false,
        [Content::Node(a), Content::Node(b)] => {
            let mut pairs = whole.children(a).iter().zip(reduced.children(b));
            pairs.all(|(&a, &b)| is_part(whole, reduced, [a, b]))
        }
    }
}

/// A function whose nodes are measured.
struct Reduction<S> {
    source: S,
    measures: Measures,
    norm: Norm,
    /// What errors are multiplied by, so that they are numbers of 32 bits whatever the values are.
    scale: f64,
}

impl<S: Source> Reduction<S> {
    fn new(source: S, norm: Norm) -> Reduction<S> {
        let largest = source.whole().largest;
        let scale = if largest > 0.0 { largest.recip() } else { 1.0 };
        let measures = source.measures(norm, scale);
        Reduction { source, measures, norm, scale: norm.of(scale) }
    }

    fn best(&self, goal: &Goal) -> Result<(Tree, Loss), ReduceError> {
        let Goal { l1, rms, total, n_leaves, .. } = *goal;
        let (tree, loss) = match (l1.or(rms).or(total), n_leaves) {
            (None, Some(n)) => {
                let cheapest = self.of_leaves(&self.measures, n);
                match goal.balance {
                    Some(bound) => {
                        let cheapest = self.tree(&cheapest.is_cut);
                        let tree = self.with_surcharges(cheapest, n, bound);
                        let loss = loss(&self.source, tree.arena());
                        (tree, loss)
                    }
                    None => self.result(cheapest, None),
                }
            }
            _ => self.bounded(goal),
        };
        let (tree, loss) = match goal.balance {
            Some(bound) => self.balanced(tree, loss, bound, goal),
            None => (tree, loss),
        };
        match n_leaves {
            Some(asked) if tree.arena().n_leaves() > asked => {
                Err(ReduceError::Leaves { needed: tree.arena().n_leaves(), asked })
            }
            _ => Ok((tree, loss)),
        }
    }

    /// The cheapest tree of at most so many leaves.
    fn of_leaves(&self, measures: &Measures, n: usize) -> Pruning {
        let [many, few] = boundary(measures, self.source.rank(), |cost| cost.n_leaves > n);
        between(measures, &self.source, [&few, &many], |_, with: Cost| with.n_leaves <= n)
    }

    /// A tree whose leaves gave light to each other, if that keeps what the goal wants.
    fn balanced(&self, tree: Tree, before: Loss, bound: f64, goal: &Goal) -> (Tree, Loss) {
        let keeps = |arena: &Arena| {
            let after = loss(&self.source, arena);
            goal.is_kept_by(&after) && after.worst_total < before.worst_total
        };
        match balance::balanced(&self.source, tree.arena(), bound, keeps) {
            Some(arena) => {
                let loss = loss(&self.source, &arena);
                (Tree::new(arena), loss)
            }
            None => (tree, before),
        }
    }

    /// The cheapest tree that keeps the bounds, but for what that of totals takes back.
    fn bounded(&self, goal: &Goal) -> (Tree, Loss) {
        let whole = self.source.whole();
        let most = match (goal.l1, goal.rms) {
            (Some(l1), _) => l1 * whole.light * self.scale,
            (None, Some(rms)) => rms * rms * whole.power * self.scale,
            (None, None) => f64::INFINITY,
        };
        // Errors are kept in 32 bits, so the sum may be a little less than it is.
        for most in [most, most * (1.0 - 1e-6)] {
            let (tree, loss) = self.result(self.within(most), goal.total);
            if goal.is_kept_by(&loss) {
                return (tree, loss);
            }
        }
        // The other bounds are not known of a pruning without its tree.
        let holds =
            |p: &Pruning| p.cost.error <= most && goal.is_kept_by(&self.result(p.clone(), goal.total).1);
        let [pruning, _] = boundary_of_trees(&self.measures, self.source.rank(), holds);
        self.result(pruning, goal.total)
    }

    /// What is left of a pruning, with so much given back that a bound on totals is kept.
    fn result(&self, mut pruning: Pruning, total: Option<f64>) -> (Tree, Loss) {
        let mut tree = self.tree(&pruning.is_cut);
        if let Some(bound) = total {
            let means = &self.measures.means;
            if totals::kept(&self.source, means, &mut pruning.is_cut, tree.arena(), bound) {
                // So that there are not two.
                drop(tree);
                tree = self.tree(&pruning.is_cut);
            }
        }
        drop(pruning);
        let loss = loss(&self.source, tree.arena());
        (tree, loss)
    }

    /// The cheapest tree of an error of at most so much.
    fn within(&self, most: f64) -> Pruning {
        let [many, few] = boundary(&self.measures, self.source.rank(), |cost| cost.error <= most);
        between(&self.measures, &self.source, [&few, &many], |without, _| without.error > most)
    }

    /// The tree that is left when branches are cut.
    fn tree(&self, is_cut: &[bool]) -> Tree {
        let mut builder = TreeBuilder::new(self.source.rank());
        let root = self.slot(self.source.root(), is_cut, &mut builder);
        Tree::new(builder.finish(root))
    }

    fn slot(&self, slot: Slot, is_cut: &[bool], builder: &mut TreeBuilder) -> Slot {
        match slot.content() {
            Content::Leaf(_) => slot,
            Content::Node(node) if is_cut[node as usize] => Slot::leaf(self.measures.means[node as usize]),
            Content::Node(node) => {
                let mut children = self.source.children(node);
                let children = &mut children[..self.source.rank().n_children()];
                for child in children.iter_mut() {
                    *child = self.slot(*child, is_cut, builder);
                }
                builder.node(children).expect("a part of a legal tree is legal")
            }
        }
    }
}
