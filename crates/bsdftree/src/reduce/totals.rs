//! Keeps the light of each incident direction: a leaf's mean is right for its incident cells together, not for each of them.
//!
//! In: a tree, and which of its branches are cut off. Out: fewer cuts, so that no directional-hemispherical total is off by more than a
//! bound. Over all leaves that an incident cell meets the differences add up. Where they exceed the bound, cuts are taken back, each to
//! what is left of the branch below, in the order of what they contribute to the excess of all cells together, as many as remove it if
//! what comes instead contributes nothing; and again, until no total differs too much, or nothing is cut there.

use super::source::Source;
use super::{LEAST_TOTAL, Loss};
use crate::tree::{Arena, Content, Rank, Slot, Totals, leaf_area};

/// Takes cuts back until the bound holds, given the tree that they leave; whether any were.
pub(super) fn kept(
    source: &impl Source,
    means: &[f32],
    is_cut: &mut [bool],
    left: &Arena,
    bound: f64,
) -> bool {
    let totals = source.totals();
    let mut differences = Differences::new(source, left).off;
    let guard = Guard { source, means, is_cut, side: 1 << source.log2_res(), totals };
    let mut any = false;
    loop {
        let excess: Vec<f64> =
            differences.iter().zip(&guard.totals).map(|(d, t)| excess(*d, *t, bound)).collect();
        if excess.iter().all(|&e| e == 0.0) {
            return any;
        }
        let wanted = guard.wanted(excess);
        if wanted.cuts.is_empty() {
            return any;
        }
        any = true;
        for cut in &wanted.cuts {
            let (node, at) = (cut.node, guard.at(cut.level, cut.cell));
            guard.is_cut[node as usize] = false;
            at.add(wanted.of(cut), -1.0, &mut differences);
            guard.over_cuts(Slot::link(node), at.level, at.cell, None, &mut |_, at, difference| {
                at.add(difference, 1.0, &mut differences);
            });
        }
    }
}

/// How far totals of a tree with branches cut off are from what they were, in the finest incident cells.
pub(super) struct Differences {
    pub off: Vec<f64>,
    /// What they are divided by; infinite where nobody reads.
    pub scales: Vec<f64>,
}

impl Differences {
    /// Of a tree that is the source with branches cut off.
    pub fn new(source: &impl Source, reduced: &Arena) -> Differences {
        let totals = source.totals();
        // Of rank 3 only one half of the incident cells is read, which is all if there is one.
        let n_read = if source.rank() == Rank::Four { totals.len() } else { (totals.len() / 2).max(1) };
        let scale =
            |(k, total): (usize, &f64)| if k < n_read { total.max(LEAST_TOTAL) } else { f64::INFINITY };
        Differences {
            off: reduced_totals(source, reduced).zip(&totals).map(|(left, total)| left - total).collect(),
            scales: totals.iter().enumerate().map(scale).collect(),
        }
    }

    /// The same as parts of totals.
    pub fn relative(&self) -> impl Iterator<Item = f64> {
        self.off.iter().zip(&self.scales).map(|(off, scale)| off / scale)
    }

    /// The largest of these, whatever its sign.
    pub fn worst(&self) -> f64 {
        self.relative().fold(0.0, |worst, error| worst.max(error.abs()))
    }
}

/// Totals of a tree with branches cut off, in the finest incident cells of what it was.
fn reduced_totals(source: &impl Source, reduced: &Arena) -> impl Iterator<Item = f64> {
    let (log2, shift) = (source.log2_res(), source.log2_res() - reduced.log2_res());
    let totals = Totals::new(reduced, |_, value| [value]).expect("there are fewer than of the whole tree");
    let n_cells = if source.rank() == Rank::Four { 1 << (2 * log2) } else { 1 << log2 };
    (0..n_cells).map(move |k: u32| totals.of([k & ((1 << log2) - 1), k >> log2].map(|c| c >> shift))[0])
}

/// By how much a difference of a total is too large, with its sign.
fn excess(difference: f64, total: f64, bound: f64) -> f64 {
    // A little less than the bound, for sums that are made in another order.
    let allowed = bound * total.max(LEAST_TOTAL) * (1.0 - 1e-6);
    if difference.abs() > allowed { difference - allowed.copysign(difference) } else { 0.0 }
}

/// A loss with the errors of totals.
pub(super) fn with_totals(loss: Loss, source: &impl Source, reduced: &Arena) -> Loss {
    let (differences, fine) = (Differences::new(source, reduced), 1 << source.log2_res());
    let n_read = differences.scales.iter().filter(|scale| scale.is_finite()).count();
    let errors: Vec<f64> = differences.relative().take(n_read).map(f64::abs).collect();
    let worst = (0..errors.len()).fold(0, |worst, k| if errors[k] > errors[worst] { k } else { worst });
    Loss {
        mean_total: errors.iter().sum::<f64>() / errors.len() as f64,
        worst_total: errors[worst],
        worst_at: match source.rank() {
            Rank::Three => [(worst as f64 + 0.5) / fine as f64, 0.0],
            Rank::Four => [worst % fine, worst / fine].map(|c| (c as f64 + 0.5) / fine as f64),
        },
        ..loss
    }
}

/// The incident cells that a node stands for.
#[derive(Clone, Copy)]
struct At {
    level: u32,
    cell: [u32; 2],
    /// Finest cells along an axis of the node, and along the whole one.
    n: usize,
    side: usize,
    rank: Rank,
}

impl At {
    /// Indices of the finest cells.
    fn indices(self) -> impl Iterator<Item = usize> {
        let rows = if self.rank == Rank::Four { self.n } else { 1 };
        (0..rows).flat_map(move |y| {
            let first = (self.cell[1] as usize * self.n + y) * self.side + self.cell[0] as usize * self.n;
            first..first + self.n
        })
    }

    fn add(self, difference: &[f64], sign: f64, sums: &mut [f64]) {
        self.indices().zip(difference).for_each(|(k, d)| sums[k] += sign * d);
    }
}

/// A cut: the node, where it is, and where it begins to be said by how much it changes the total of each of its incident cells. There may
/// be as many as leaves, so they are small.
#[derive(Clone, Copy)]
struct Cut {
    score: f64,
    node: u32,
    level: u32,
    cell: [u32; 2],
    first: u32,
}

/// Some of them, and how they change totals, one after the other.
#[derive(Default)]
struct Cuts {
    cuts: Vec<Cut>,
    changes: Vec<f64>,
}

impl Cuts {
    /// How one changes totals, and what follows.
    fn of(&self, cut: &Cut) -> &[f64] {
        &self.changes[cut.first as usize..]
    }
}

struct Guard<'a, S> {
    source: &'a S,
    means: &'a [f32],
    is_cut: &'a mut [bool],
    side: usize,
    totals: Vec<f64>,
}

impl<S: Source> Guard<'_, S> {
    fn at(&self, level: u32, cell: [u32; 2]) -> At {
        let n = 1 << (self.source.log2_res() - level);
        At { level, cell, n, side: self.side, rank: self.source.rank() }
    }

    /// Calls `f` with all cuts below a slot, and with how they change totals; only with those where something is wanted, if that is
    /// given.
    fn over_cuts(
        &self,
        slot: Slot,
        level: u32,
        cell: [u32; 2],
        wanted: Option<&[f64]>,
        f: &mut impl FnMut(u32, At, &[f64]),
    ) {
        if let Content::Node(node) = slot.content() {
            self.over_cuts_in(node, level, cell, wanted, &mut Vec::new(), f);
        }
    }

    /// The same in a node, with room for differences.
    fn over_cuts_in(
        &self,
        node: u32,
        level: u32,
        cell: [u32; 2],
        wanted: Option<&[f64]>,
        difference: &mut Vec<f64>,
        f: &mut impl FnMut(u32, At, &[f64]),
    ) {
        let at = self.at(level, cell);
        if wanted.is_some_and(|wanted| at.indices().all(|k| wanted[k] == 0.0)) {
            return;
        }
        if self.is_cut[node as usize] {
            let mean = f64::from(self.means[node as usize]) * leaf_area(level);
            self.source.totals_below(node, level, difference);
            difference.iter_mut().for_each(|d| *d = mean - *d);
            return f(node, at, difference);
        }
        if self.source.nodes_below(node).is_empty() {
            return;
        }
        for (k, child) in self.children(node) {
            if let Content::Node(child) = child.content() {
                self.over_cuts_in(child, level + 1, self.below(cell, k), wanted, difference, f);
            }
        }
    }

    fn children(&self, node: u32) -> impl Iterator<Item = (usize, Slot)> + use<S> {
        self.source.children(node).into_iter().take(self.source.rank().n_children()).enumerate()
    }

    /// The incident cell of child k.
    fn below(&self, cell: [u32; 2], k: usize) -> [u32; 2] {
        let bit = |i: usize| (k >> i & 1) as u32;
        match self.source.rank() {
            Rank::Three => [cell[0] << 1 | bit(0), 0],
            Rank::Four => [cell[0] << 1 | bit(0), cell[1] << 1 | bit(1)],
        }
    }

    /// The cuts that make most of the excess, as many as remove it.
    fn wanted(&self, mut excess: Vec<f64>) -> Cuts {
        let mut found = Cuts::default();
        self.over_cuts(self.source.root(), 0, [0; 2], Some(&excess), &mut |node, at, difference| {
            let excessive = at.indices().zip(difference).filter(|&(k, _)| excess[k] != 0.0);
            let score: f64 = excessive.map(|(k, d)| d * excess[k].signum()).sum();
            if score > 0.0 {
                let first =
                    u32::try_from(found.changes.len()).expect("fewer than incident cells of all leaves");
                found.cuts.push(Cut { score, node, level: at.level, cell: at.cell, first });
                found.changes.extend_from_slice(difference);
            }
        });
        // The largest score first, then as they were found: one number each, which is sorted faster.
        let key = |(k, cut): (usize, &Cut)| u64::from(!(cut.score as f32).to_bits()) << 32 | k as u64;
        let mut order: Vec<u64> = found.cuts.iter().enumerate().map(key).collect();
        order.sort_unstable();
        let cuts = order.into_iter().filter_map(|key| {
            let cut = found.cuts[key as u32 as usize];
            let changes = || self.at(cut.level, cut.cell).indices().zip(found.of(&cut));
            let helps = changes().any(|(k, d)| d * excess[k] > 0.0);
            if helps {
                for (k, d) in changes() {
                    let left = excess[k] - d;
                    excess[k] = if left * excess[k] > 0.0 { left } else { 0.0 };
                }
            }
            helps.then_some(cut)
        });
        found.cuts = cuts.collect();
        found
    }
}
