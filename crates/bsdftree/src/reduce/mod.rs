//! Smaller trees with an error that the caller chooses.
//!
//! In: a tree, and what may be lost: bounds on errors, or a number of leaves. Out: a tree that is the first one with branches cut off,
//! each of which became a leaf of its mean, so that the light over every leaf is kept exactly. For the norm that is bounded (or
//! chosen) no tree made that way with as few leaves has a smaller error; errors are those of the result, computed anew.
//!
//! Source: Radiance's rttree_reduce, which cuts off a percentage of branches by a score of its own.

mod measure;
mod prune;
mod totals;
mod whole;

use thiserror::Error;

use crate::tree::{Arena, Content, Slot, Totals, Tree, TreeBuilder};
use measure::{Measures, Sums};
use prune::{Pruning, between, boundary};

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
    fn validated(self) -> Result<Goal, ReduceError> {
        let bounds = [("L1", self.l1), ("RMS", self.rms), ("totals", self.total)];
        if bounds.iter().all(|(_, bound)| bound.is_none()) && self.n_leaves.is_none() {
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
        Reduction::new(&arena, goal.norm()).best(&goal)
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
        Ok(loss(self.arena(), reduced.arena()))
    }
}

/// How far a tree with branches cut off is from the whole one.
fn loss(whole: &Arena, reduced: &Arena) -> Loss {
    totals::with_totals(Sums::of(whole, reduced).loss(), whole, reduced)
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

struct Reduction<'a> {
    arena: &'a Arena,
    measures: Measures,
    /// ∫f.
    light: f64,
    /// ∫f².
    power: f64,
}

impl Reduction<'_> {
    fn new(arena: &Arena, norm: Norm) -> Reduction<'_> {
        let whole = Sums::of(arena, arena);
        Reduction { arena, measures: Measures::new(arena, norm), light: whole.light, power: whole.power }
    }

    fn best(&self, goal: &Goal) -> Result<(Tree, Loss), ReduceError> {
        let Goal { l1, rms, total, n_leaves, .. } = *goal;
        let pruning = match (l1.or(rms).or(total), n_leaves) {
            (None, Some(n)) => {
                let [many, few] = boundary(&self.measures, self.arena.rank(), |p| p.n_leaves > n);
                between(&self.measures, self.arena, [&few, &many], |[_, leaves], _| leaves <= n)
            }
            _ => self.bounded(goal),
        };
        let mut is_cut = pruning.is_cut;
        if let Some(bound) = total {
            totals::kept(self.arena, &self.measures.means, &mut is_cut, bound);
        }
        let tree = self.tree(&is_cut);
        let loss = loss(self.arena, tree.arena());
        match n_leaves {
            Some(asked) if tree.arena().n_leaves() > asked => {
                Err(ReduceError::Leaves { needed: tree.arena().n_leaves(), asked })
            }
            _ => Ok((tree, loss)),
        }
    }

    /// The cheapest tree that keeps the bounds, but for that of totals if there is another one.
    fn bounded(&self, goal: &Goal) -> Pruning {
        let rank = self.arena.rank();
        let first = match (goal.l1, goal.rms) {
            (Some(l1), _) => l1 * self.light,
            (None, Some(rms)) => rms * rms * self.power,
            (None, None) => f64::INFINITY,
        };
        let [many, few] = boundary(&self.measures, rank, |p| p.error <= first);
        let pruning = between(&self.measures, self.arena, [&few, &many], |_, [error, _]| error > first);
        // Errors are kept in 32 bits, and the other bounds are not known of a pruning without its tree.
        let others = Goal { total: goal.total.filter(|_| first == f64::INFINITY), ..*goal };
        let is_kept = |p: &Pruning| others.is_kept_by(&loss(self.arena, self.tree(&p.is_cut).arena()));
        if is_kept(&pruning) {
            return pruning;
        }
        let [pruning, _] = boundary(&self.measures, rank, |p| p.error <= first && is_kept(p));
        pruning
    }

    /// The tree that is left when branches are cut.
    fn tree(&self, is_cut: &[bool]) -> Tree {
        let mut builder = TreeBuilder::new(self.arena.rank());
        let root = self.slot(self.arena.root(), is_cut, &mut builder);
        Tree::new(builder.finish(root))
    }

    fn slot(&self, slot: Slot, is_cut: &[bool], builder: &mut TreeBuilder) -> Slot {
        match slot.content() {
            Content::Leaf(_) => slot,
            Content::Node(node) if is_cut[node as usize] => Slot::leaf(self.measures.means[node as usize]),
            Content::Node(node) => {
                let mut children = [slot; 16];
                let n = self.arena.rank().n_children();
                for (made, &child) in children.iter_mut().zip(self.arena.children(node)) {
                    *made = self.slot(child, is_cut, builder);
                }
                builder.node(&children[..n]).expect("a part of a legal tree is legal")
            }
        }
    }
}
