//! The cheapest tree that is left when branches become leaves, for a price per leaf.
//!
//! A tree whose error plus λ times its number of leaves is least has, of all that are made by cutting branches off, the least error for
//! its number of leaves. Branches of one price, as symmetric ones are, may be cut one by one: what lies between two such trees is as
//! cheap. The tree is found from the leaves up, each branch being cut where that is cheaper; the larger λ, the more is
//! cut (L. Breiman et al., "Classification and Regression Trees", 1984, chapter 3; P. A. Chou, T. Lookabaugh and R. M. Gray, "Optimal
//! pruning with applications to tree-structured source coding", IEEE Transactions on Information Theory 35, 1989).

use super::measure::Measures;
use crate::tree::{Arena, Content, Rank, Slot};

/// Which branches are cut at some price, and what is left.
#[derive(Clone)]
pub(super) struct Pruning {
    /// Whether each node becomes a leaf where its parent does not.
    pub is_cut: Vec<bool>,
    /// ∫|error| or ∫error² of what is left.
    pub error: f64,
    /// Its leaves.
    pub n_leaves: usize,
}

/// The cheapest tree at a price.
pub(super) fn pruned(measures: &Measures, rank: Rank, price: f64) -> Pruning {
    let n = measures.errors.len();
    let mut is_cut = vec![false; n];
    let mut costs = vec![(0.0f32, 0u32); n];
    // Children come after their parents, in the order of the links to them.
    let mut next = n;
    for node in (0..n).rev() {
        let n_links = usize::from(measures.n_links[node]);
        let children = &costs[next - n_links..next];
        next -= n_links;
        let n_leaves = (rank.n_children() - n_links) as u32;
        let (error, n_leaves) =
            children.iter().fold((0.0, n_leaves), |(error, n), &(e, k)| (error + f64::from(e), n + k));
        let as_leaf = f64::from(measures.errors[node]);
        is_cut[node] = as_leaf + price <= error + price * f64::from(n_leaves);
        costs[node] = if is_cut[node] { (measures.errors[node], 1) } else { (error as f32, n_leaves) };
    }
    let (error, n_leaves) = costs.first().map_or((0.0, 1), |&(error, n)| (f64::from(error), n as usize));
    Pruning { is_cut, error, n_leaves }
}

/// The cheapest trees on both sides of the price at which a property ends that those of small prices have: the one of the largest
/// price that is found to have it, and the one of the smallest that is found not to. Where all have it, or none, the two are the same.
pub(super) fn boundary(measures: &Measures, rank: Rank, holds: impl Fn(&Pruning) -> bool) -> [Pruning; 2] {
    let errors = || measures.errors.iter().copied().filter(|&e| e > 0.0);
    let most = 2.0 * f64::from(errors().fold(0.0, f32::max));
    let least = f64::from(errors().fold(f32::MAX, f32::min)) / 1e3;
    let at = |price: f64| pruned(measures, rank, price);
    let (first, last) = (at(0.0), at(most));
    if holds(&last) {
        return [last.clone(), last];
    }
    if !holds(&first) {
        return [first.clone(), first];
    }
    let (mut below, mut above) = ((least, first), (most, last));
    // By the logarithm of the price, since errors of nodes span many decades.
    while above.0 / below.0 > 1.0 + 1e-7 && below.1.n_leaves > above.1.n_leaves {
        let price = (below.0 * above.0).sqrt();
        let found = at(price);
        let is_below = holds(&found);
        *if is_below { &mut below } else { &mut above } = (price, found);
    }
    [below.1, above.1]
}

/// Where two prunings differ: a branch that the one with fewer leaves cuts, and the other does not.
struct Difference {
    node: u32,
    /// Leaves that the other one has more here.
    more_leaves: usize,
    /// By how much its error is less here.
    less_error: f64,
}

/// The pruning of fewer leaves with branches given back that the other one has, the most useful first: each one that `takes` wants, given
/// the numbers of leaves and the errors without it and with it.
pub(super) fn between(
    measures: &Measures,
    arena: &Arena,
    [few, many]: [&Pruning; 2],
    takes: impl Fn([usize; 2], [f64; 2]) -> bool,
) -> Pruning {
    let mut result = few.clone();
    let mut differences = Vec::new();
    collect(measures, arena, arena.root(), [few, many], &mut differences);
    let gain = |d: &Difference| d.less_error / d.more_leaves.max(1) as f64;
    differences.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
    for Difference { node, more_leaves, less_error } in differences {
        let (n_leaves, error) = (result.n_leaves + more_leaves, result.error - less_error);
        if takes([result.n_leaves, n_leaves], [result.error, error]) {
            copy(arena, node, &many.is_cut, &mut result.is_cut);
            (result.n_leaves, result.error) = (n_leaves, error);
        }
    }
    result
}

fn collect(
    measures: &Measures,
    arena: &Arena,
    slot: Slot,
    [few, many]: [&Pruning; 2],
    differences: &mut Vec<Difference>,
) {
    let Content::Node(node) = slot.content() else { return };
    let k = node as usize;
    match (few.is_cut[k], many.is_cut[k]) {
        (true, true) => {}
        (true, false) => {
            let (n_leaves, error) = left(measures, arena, slot, &many.is_cut);
            let less_error = f64::from(measures.errors[k]) - error;
            differences.push(Difference { node, more_leaves: n_leaves - 1, less_error });
        }
        (false, _) => {
            for &child in arena.children(node) {
                collect(measures, arena, child, [few, many], differences);
            }
        }
    }
}

/// Leaves and error of what is left below a slot.
fn left(measures: &Measures, arena: &Arena, slot: Slot, is_cut: &[bool]) -> (usize, f64) {
    match slot.content() {
        Content::Leaf(_) => (1, 0.0),
        Content::Node(node) if is_cut[node as usize] => (1, f64::from(measures.errors[node as usize])),
        Content::Node(node) => arena.children(node).iter().fold((0, 0.0), |(n, error), &child| {
            let (more, other) = left(measures, arena, child, is_cut);
            (n + more, error + other)
        }),
    }
}

/// Copies what is cut in a branch.
fn copy(arena: &Arena, node: u32, from: &[bool], to: &mut [bool]) {
    to[node as usize] = from[node as usize];
    for child in arena.children(node) {
        if let Content::Node(child) = child.content() {
            copy(arena, child, from, to);
        }
    }
}
