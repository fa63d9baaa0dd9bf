//! The cheapest tree that is left when branches become leaves, for a price per leaf.
//!
//! A tree whose error plus λ times its number of leaves is least has, of all that are made by cutting branches off, the least error for
//! its number of leaves. It is found from the leaves up, each branch being cut where that is cheaper; the larger λ, the more is
//! cut (L. Breiman et al., "Classification and Regression Trees", 1984, chapter 3; P. A. Chou, T. Lookabaugh and R. M. Gray, "Optimal
//! pruning with applications to tree-structured source coding", IEEE Transactions on Information Theory 35, 1989).

use super::measure::Measures;
use crate::tree::Rank;

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
