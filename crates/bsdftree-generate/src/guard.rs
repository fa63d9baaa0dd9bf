//! Keeps the light of each incident direction: leaves shared by many directions may not, together, give one of them too much.
//!
//! A leaf's mean is right for its incident cells together, not for each. Over all leaves that an incident cell meets, the
//! differences may add up, even to more light than came in. Where the tree's total P of a cell differs from the counted total H by more
//! than a tolerance, and by more than noise explains, leaves are split (each to its cheapest tree with at least one split).
//! A leaf's score is what it contributes to the differences of all its cells: systematic contributions add up over cells, noise cancels.
//! Leaves are split in the order of their score, as many as would remove all excess if splitting removed their contribution, and
//! this is repeated until no total differs, or nothing is left to split.

use std::ops::Range;

use rayon::prelude::*;

use crate::errors::STUDENT_95;
use crate::reduce::{Kept, Member, Reducer, Region};
use crate::scatter::Flux;
use crate::totals::Totals;

/// |P − H| is tolerated relative to H, or to this if H is less.
pub(crate) const LEAST_TOTAL: f64 = 0.1;
/// Tolerated excess of all scattered light over what came in, for each of the two components that share it.
const EXCESS: f64 = 0.004;
/// Splitting ends by itself: each round deepens a leaf. This only bounds the time.
const MAX_ROUNDS: u32 = 40;

/// The tree with leaves split until totals are kept, and by how much each incident cell's total departs from what was counted.
/// `totals` are those, before they were averaged with what travelled the other way, which would make them less exact; `headroom` is,
/// for each incident cell, the part of the light that was counted neither as reflected nor as transmitted.
pub(crate) fn guarded<S: Flux>(
    reducer: &Reducer<'_, S>,
    mut kept: Kept,
    totals: &Totals,
    headroom: &[f64],
    tolerance: f64,
) -> (Kept, Vec<f64>) {
    let (root, members) = reducer.root();
    let limits = limits(totals, headroom, tolerance);
    let mut sums: Vec<f64> = totals.values.iter().map(|total| -total).collect();
    reducer.give(&kept, root, 1.0, &mut sums);
    for _ in 0..MAX_ROUNDS {
        let excess = sums.iter().zip(&limits).map(|(sum, l)| sum.abs() - l[usize::from(*sum < 0.0)]);
        let deviating = Deviating::new(excess.collect(), &sums);
        if deviating.rows.is_empty() {
            break;
        }
        let among: Vec<Member> =
            members.iter().filter(|m| deviating.excess[m[0] as usize] > 0.0).copied().collect();
        let candidates = deviating.candidates(reducer, &kept, root, &among);
        let wanted = deviating.leaves_to_split(reducer, candidates);
        if wanted.is_empty() {
            break;
        }
        for region in wanted {
            let leaf = leaf_mut(reducer, &mut kept, root, &region);
            reducer.give(leaf, region, -1.0, &mut sums);
            reducer.split_leaf(leaf, region);
            reducer.give(leaf, region, 1.0, &mut sums);
        }
    }
    (kept, sums)
}

/// How much more, and how much less, than counted the tree may give each incident cell.
fn limits(totals: &Totals, headroom: &[f64], tolerance: f64) -> Vec<[f64; 2]> {
    let limits = totals.values.iter().zip(&totals.errors);
    let limits = limits.map(|(total, error)| (tolerance * total.max(LEAST_TOTAL)).max(STUDENT_95 * error));
    limits.zip(headroom).map(|(limit, room)| [limit.min(0.5 * room.max(0.0) + EXCESS), limit]).collect()
}

/// The leaf of a region.
fn leaf_mut<'k, S: Flux>(
    reducer: &Reducer<'_, S>,
    mut kept: &'k mut Kept,
    mut at: Region,
    region: &Region,
) -> &'k mut Kept {
    while let Kept::Node(children) = kept {
        let mut parts = reducer.regions(at).enumerate();
        let (k, part) = parts.find(|(_, part)| part.contains(region)).expect("a part of the whole");
        (kept, at) = (&mut children[k], part);
    }
    kept
}

/// Incident cells whose total is not kept.
struct Deviating<'a> {
    rows: Vec<u32>,
    /// How many of them come before each incident cell.
    before: Vec<u32>,
    /// By how much each incident cell's total is off beyond what is tolerated, where that is positive.
    excess: Vec<f64>,
    sums: &'a [f64],
    /// Those of them that have too much, less those that have too little, up to each.
    signs: Vec<f64>,
}

/// A leaf that may be split.
struct Candidate {
    region: Region,
    /// What it gives each incident cell.
    given: f64,
    /// What was counted for cells that deviate.
    members: Vec<Member>,
    /// What it contributes to them in all, in the direction of their deviation.
    score: f64,
}

impl<'a> Deviating<'a> {
    fn new(excess: Vec<f64>, sums: &'a [f64]) -> Deviating<'a> {
        let (mut rows, mut before) = (Vec::new(), Vec::with_capacity(excess.len() + 1));
        let mut signs = vec![0.0];
        for (row, &excess) in excess.iter().enumerate() {
            before.push(rows.len() as u32);
            if excess > 0.0 {
                signs.push(signs[rows.len()] + sums[row].signum());
                rows.push(row as u32);
            }
        }
        before.push(rows.len() as u32);
        Deviating { rows, before, excess, sums, signs }
    }

    /// Those in a region, by their places in the list.
    fn within(&self, region: &Region) -> Range<usize> {
        let Range { start, end } = region.rows();
        self.before[start] as usize..self.before[end] as usize
    }

    /// Leaves that give too much to those that have too much, or too little to those that have too little. `members` are what was
    /// counted for cells that deviate alone.
    fn candidates<S: Flux>(
        &self,
        reducer: &Reducer<'_, S>,
        kept: &Kept,
        region: Region,
        members: &[Member],
    ) -> Vec<Candidate> {
        match kept {
            _ if self.within(&region).is_empty() => Vec::new(),
            Kept::Leaf { value, .. } => {
                self.candidate(reducer, *value, region, members).into_iter().collect()
            }
            Kept::Node(children) => {
                let parts = reducer.parts(region, members);
                let below = |(k, child): (usize, &Kept)| {
                    let (part, members) = parts.get(k);
                    self.candidates(reducer, child, part, members)
                };
                match region.level < 2 {
                    true => children.par_iter().enumerate().flat_map_iter(below).collect(),
                    false => children.iter().enumerate().flat_map(below).collect(),
                }
            }
        }
    }

    fn candidate<S: Flux>(
        &self,
        reducer: &Reducer<'_, S>,
        value: f64,
        region: Region,
        members: &[Member],
    ) -> Option<Candidate> {
        if region.level == reducer.log2_res
            || (members.is_empty() && value == 0.0 && reducer.modelled(&region).value == 0.0)
        {
            return None;
        }
        let given = value * reducer.omega * region.n_exit as f64;
        let score = match reducer.model {
            Some(_) => self
                .contributions(reducer, &region, given, members)
                .map(|(_, contribution)| contribution)
                .sum(),
            None => {
                let Range { start, end } = self.within(&region);
                let counted = members.iter().map(|&m| self.sums[m[0] as usize].signum() * reducer.sums(m).0);
                given * (self.signs[end] - self.signs[start]) - counted.sum::<f64>()
            }
        };
        let whole = || reducer.is_whole(&region, &reducer.members(&region));
        (score > 0.0 && !whole()).then(|| Candidate { region, given, members: members.to_vec(), score })
    }

    /// For each cell of a region that deviates, how much more of a leaf's light than was counted it gets, in the direction of its
    /// deviation.
    fn contributions<S: Flux>(
        &self,
        reducer: &Reducer<'_, S>,
        region: &Region,
        given: f64,
        members: &[Member],
    ) -> impl Iterator<Item = (usize, f64)> {
        let mut members = members.iter().peekable();
        self.rows[self.within(region)].iter().map(move |&row| {
            let counted = members.next_if(|m| m[0] == row).map_or(0.0, |&m| reducer.sums(m).0);
            let more = given - counted - reducer.modelled_sum(row, region);
            (row as usize, more * self.sums[row as usize].signum())
        })
    }

    /// Leaves to split, best first: as many as would remove all excess if splitting removed what they contribute.
    fn leaves_to_split<S: Flux>(
        &self,
        reducer: &Reducer<'_, S>,
        mut candidates: Vec<Candidate>,
    ) -> Vec<Region> {
        candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut excess = self.excess.clone();
        let mut n_left = self.rows.len();
        let mut wanted = Vec::new();
        for Candidate { region, given, members, .. } in candidates {
            if n_left == 0 {
                break;
            }
            let positive = || {
                self.contributions(reducer, &region, given, &members)
                    .filter(|&(_, contribution)| contribution > 0.0)
            };
            if positive().any(|(row, _)| excess[row] > 0.0) {
                wanted.push(region);
                for (row, contribution) in positive() {
                    n_left -= usize::from(excess[row] > 0.0 && excess[row] <= contribution);
                    excess[row] -= contribution;
                }
            }
        }
        wanted
    }
}
