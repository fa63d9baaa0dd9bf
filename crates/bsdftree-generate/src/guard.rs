//! Keeps the light of each incident direction: leaves shared by many directions may not, together, give one of them too much.
//!
//! A leaf's mean is right for its incident cells together, not for each. Over all leaves that an incident cell meets, the
//! differences may add up, even to more light than came in. Where the tree's total P of a cell differs from the counted total H by more
//! than a tolerance, and by more than noise explains, leaves are split (each to its cheapest tree with at least one split).
//! A leaf's score is what it contributes to the differences of all its cells: systematic contributions add up over cells, noise cancels.
//! Leaves are split in the order of their score, as many as would remove all excess if splitting removed their contribution, and
//! this is repeated until no total differs, or nothing is left to split.

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
    kept: Kept,
    totals: &Totals,
    headroom: &[f64],
    tolerance: f64,
) -> (Kept, Vec<f64>) {
    let (root, members) = reducer.root();
    let limits = limits(totals, headroom, tolerance);
    let mut leaves = Vec::new();
    let shape = flattened(reducer, kept, root, &members, &mut leaves);
    let mut sums: Vec<f64> = totals.values.iter().map(|total| -total).collect();
    sums.iter_mut().enumerate().for_each(|(row, sum)| *sum += reducer.modelled_sum(row as u32, &root));
    members.iter().for_each(|&member| sums[member[0] as usize] += reducer.sums(member).0);
    leaves.iter().for_each(|leaf| leaf.contributions(reducer, |row, d| sums[row as usize] += d));
    for _ in 0..MAX_ROUNDS {
        let mut excess: Vec<_> =
            sums.iter().zip(&limits).map(|(sum, l)| sum.abs() - l[usize::from(*sum < 0.0)]).collect();
        if excess.iter().all(|&e| e <= 0.0) {
            break;
        }
        let wanted = leaves_to_split(reducer, &leaves, &sums, &mut excess);
        if wanted.is_empty() {
            break;
        }
        for index in wanted {
            let leaf = &leaves[index];
            leaf.contributions(reducer, |row, d| sums[row as usize] -= d);
            let (region, members) = (leaf.region, leaf.members.clone());
            let n_before = leaves.len();
            let split =
                flattened(reducer, reducer.split_kept(region, &members), region, &members, &mut leaves);
            for leaf in &leaves[n_before..] {
                leaf.contributions(reducer, |row, d| sums[row as usize] += d);
            }
            leaves[index].split = Some(split);
        }
    }
    (assembled(&shape, &leaves), sums)
}

/// How much more, and how much less, than counted the tree may give each incident cell.
fn limits(totals: &Totals, headroom: &[f64], tolerance: f64) -> Vec<[f64; 2]> {
    let limits = totals.values.iter().zip(&totals.errors);
    let limits = limits.map(|(total, error)| (tolerance * total.max(LEAST_TOTAL)).max(STUDENT_95 * error));
    limits.zip(headroom).map(|(limit, room)| [limit.min(0.5 * room.max(0.0) + EXCESS), limit]).collect()
}

/// A leaf of the tree with the counts that fell into it.
struct Leaf {
    value: f64,
    xyz: [f32; 3],
    region: Region,
    members: Vec<Member>,
    /// What took its place.
    split: Option<Shape>,
}

/// The tree over a list of leaves.
enum Shape {
    Leaf(usize),
    Node(Vec<Shape>),
}

impl Leaf {
    /// Calls `f` for each incident cell with how much more light the leaf gives it than was counted.
    fn contributions<S: Flux>(&self, reducer: &Reducer<'_, S>, mut f: impl FnMut(u32, f64)) {
        if self.value == 0.0 && self.members.is_empty() && reducer.modelled(&self.region).value == 0.0 {
            return;
        }
        let given = self.value * reducer.omega * self.region.n_exit as f64;
        let mut members = self.members.iter().peekable();
        for row in self.region.first_row..self.region.first_row + self.region.n_rows {
            let counted = members.next_if(|m| m[0] == row).map_or(0.0, |&m| reducer.sums(m).0);
            f(row, given - counted - reducer.modelled_sum(row, &self.region));
        }
    }
}

fn flattened<S: Flux>(
    reducer: &Reducer<'_, S>,
    kept: Kept,
    region: Region,
    members: &[Member],
    leaves: &mut Vec<Leaf>,
) -> Shape {
    match kept {
        Kept::Leaf { value, xyz } => {
            leaves.push(Leaf { value, xyz, region, members: members.to_vec(), split: None });
            Shape::Leaf(leaves.len() - 1)
        }
        Kept::Node(children) => {
            let parts = reducer.parts(region, members);
            let children = children.into_iter().zip(&parts);
            Shape::Node(
                children.map(|(child, (part, m))| flattened(reducer, child, *part, m, leaves)).collect(),
            )
        }
    }
}

fn assembled(shape: &Shape, leaves: &[Leaf]) -> Kept {
    match shape {
        Shape::Leaf(index) => match &leaves[*index] {
            Leaf { split: Some(split), .. } => assembled(split, leaves),
            Leaf { value, xyz, .. } => Kept::Leaf { value: *value, xyz: *xyz },
        },
        Shape::Node(children) => Kept::Node(children.iter().map(|child| assembled(child, leaves)).collect()),
    }
}

/// Leaves to split, best first; takes what they would remove from the excess.
fn leaves_to_split<S: Flux>(
    reducer: &Reducer<'_, S>,
    leaves: &[Leaf],
    sums: &[f64],
    excess: &mut [f64],
) -> Vec<usize> {
    struct Candidate {
        leaf: usize,
        score: f64,
        /// What it contributes to the cells that deviate, in the direction of their deviation.
        parts: Vec<(u32, f64)>,
    }
    // How many incident cells before each deviate: most leaves meet none that does.
    let mut deviating = vec![0u32; excess.len() + 1];
    for (row, &excess) in excess.iter().enumerate() {
        deviating[row + 1] = deviating[row] + u32::from(excess > 0.0);
    }
    let candidate = |(index, leaf): (usize, &Leaf)| {
        let Region { first_row, n_rows, .. } = leaf.region;
        let any = deviating[(first_row + n_rows) as usize] > deviating[first_row as usize];
        if !any || leaf.split.is_some() || reducer.is_whole(&leaf.region, &leaf.members) {
            return None;
        }
        let mut parts = Vec::new();
        leaf.contributions(reducer, |row, d| {
            if excess[row as usize] > 0.0 {
                parts.push((row, d * sums[row as usize].signum()));
            }
        });
        let score: f64 = parts.iter().map(|(_, d)| d).sum();
        (score > 0.0).then_some(Candidate { leaf: index, score, parts })
    };
    let mut candidates: Vec<_> = leaves.par_iter().enumerate().filter_map(candidate).collect();
    candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut wanted = Vec::new();
    for candidate in candidates {
        if candidate.parts.iter().any(|&(row, d)| d > 0.0 && excess[row as usize] > 0.0) {
            wanted.push(candidate.leaf);
            for (row, d) in candidate.parts {
                excess[row as usize] -= d.max(0.0);
            }
        }
    }
    wanted
}
