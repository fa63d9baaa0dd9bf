//! The cheapest tree that is left when branches become leaves, for a price per leaf.
//!
//! A tree whose error plus λ times its number of leaves is least has, of all that are made by cutting branches off, the least error for
//! its number of leaves. Branches of one price, as symmetric ones are, may be cut one by one: what lies between two such trees is as
//! cheap. The tree is found from the leaves up, each branch being cut where that is cheaper; the larger λ, the more is
//! cut (L. Breiman et al., "Classification and Regression Trees", 1984, chapter 3; P. A. Chou, T. Lookabaugh and R. M. Gray, "Optimal
//! pruning with applications to tree-structured source coding", IEEE Transactions on Information Theory 35, 1989).

use std::collections::VecDeque;

use super::measure::Measures;
use super::source::Source;
use crate::tree::{Content, Rank};

/// Error and number of leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cost {
    /// ∫|error| or ∫error².
    pub error: f64,
    pub n_leaves: usize,
}

impl Cost {
    #[inline]
    fn at(self, price: f64) -> f64 {
        self.error + price * self.n_leaves as f64
    }

    #[inline]
    fn plus(self, other: Cost) -> Cost {
        Cost { error: self.error + other.error, n_leaves: self.n_leaves + other.n_leaves }
    }

    #[inline]
    fn leaf(error: f32) -> Cost {
        Cost { error: f64::from(error), n_leaves: 1 }
    }
}

/// Which branches are cut at some price, and what is left.
#[derive(Clone)]
pub(super) struct Pruning {
    /// Whether each node becomes a leaf where its parent does not.
    pub is_cut: Vec<bool>,
    /// What is left.
    pub cost: Cost,
}

/// The cheapest tree at a price.
pub(super) fn pruned(measures: &Measures, rank: Rank, price: f64) -> Pruning {
    let mut is_cut = vec![false; measures.n_nodes()];
    let cost = cheapest(measures, rank, price, |node, cut| is_cut[node] = cut);
    Pruning { is_cut, cost }
}

/// Goes over all nodes, children before their parents: `of` makes of a node, and of the sum of what was made of its children, something
/// new. `leaf` is what leaves among the children are.
fn from_leaves_up<T: Copy>(
    measures: &Measures,
    rank: Rank,
    leaf: T,
    plus: impl Fn(T, T) -> T,
    mut of: impl FnMut(usize, T) -> T,
) -> T {
    let n_children = rank.n_children();
    let sums: Vec<T> =
        std::iter::successors(Some(leaf), |&sum| Some(plus(sum, leaf))).take(n_children).collect();
    let all_leaves = sums[n_children - 1];
    // What was made of nodes with links whose parents come later, the last of them first. Those without links, most of all, are
    // made beside their parents.
    let mut waiting: VecDeque<T> = VecDeque::new();
    let mut next = measures.n_nodes();
    for node in (0..measures.n_nodes()).rev() {
        let n_links = measures.n_links(node);
        if n_links == 0 && node > 0 {
            continue;
        }
        let mut sum = (n_children > n_links).then(|| sums[n_children - n_links - 1]);
        for child in (next - n_links..next).rev() {
            let below = match measures.n_links(child) {
                0 => of(child, all_leaves),
                _ => waiting.pop_front().expect("children come after their parents"),
            };
            sum = Some(sum.map_or(below, |sum| plus(sum, below)));
        }
        next -= n_links;
        waiting.push_back(of(node, sum.expect("a node has children")));
    }
    waiting.pop_front().unwrap_or(leaf)
}

/// What is left of the cheapest tree at a price; `decided` is told of each node whether it is cut.
fn cheapest(measures: &Measures, rank: Rank, price: f64, mut decided: impl FnMut(usize, bool)) -> Cost {
    from_leaves_up(measures, rank, Cost::leaf(0.0), Cost::plus, |node, split| {
        let leaf = Cost::leaf(measures.errors[node]);
        let is_cut = leaf.at(price) <= split.at(price);
        decided(node, is_cut);
        if is_cut { leaf } else { split }
    })
}

/// A node that is cut at some of the prices that are looked at, or that has such ones below.
struct Open {
    as_leaf: f32,
    /// Of the children that are the same at all of these prices.
    settled: Cost,
    /// Other children.
    n_open: usize,
    /// Whether it is cut at none of the prices.
    is_kept: bool,
}

/// What is still to be decided between two prices.
struct Undecided {
    /// In the order of nodes.
    open: Vec<Open>,
    /// Of what is not.
    settled: Cost,
}

impl Undecided {
    /// Given what is cut at the lower and at the upper price.
    fn new(measures: &Measures, rank: Rank, [lower, upper]: [&Pruning; 2]) -> Undecided {
        let is_reached = reached(measures, &lower.is_cut);
        let mut open = Vec::new();
        let plus = |(a, n): (Cost, usize), (b, m): (Cost, usize)| (a.plus(b), n + m);
        let of = |node: usize, (settled, n_open): (Cost, usize)| {
            let as_leaf = measures.errors[node];
            if !is_reached[node] || lower.is_cut[node] {
                (Cost::leaf(as_leaf), 0)
            } else if !upper.is_cut[node] && n_open == 0 {
                (settled, 0)
            } else {
                open.push((node, Open { as_leaf, settled, n_open, is_kept: !upper.is_cut[node] }));
                (Cost::default(), 1)
            }
        };
        let (settled, _) = from_leaves_up(measures, rank, (Cost::leaf(0.0), 0), plus, of);
        open.sort_unstable_by_key(|&(node, _)| node);
        Undecided { open: open.into_iter().map(|(_, open)| open).collect(), settled }
    }

    /// What is left at a price.
    fn cheapest(&self, price: f64) -> Cost {
        let mut waiting: VecDeque<Cost> = VecDeque::new();
        for open in self.open.iter().rev() {
            let mut split = open.settled;
            for _ in 0..open.n_open {
                split = split.plus(waiting.pop_front().expect("children come after their parents"));
            }
            let leaf = Cost::leaf(open.as_leaf);
            let is_cut = !open.is_kept && leaf.at(price) <= split.at(price);
            waiting.push_back(if is_cut { leaf } else { split });
        }
        waiting.pop_front().unwrap_or(self.settled)
    }
}

/// Which nodes are left, as nodes or leaves.
fn reached(measures: &Measures, is_cut: &[bool]) -> Vec<bool> {
    let mut is_reached = vec![false; measures.n_nodes()];
    is_reached.first_mut().into_iter().for_each(|root| *root = true);
    let mut next = 1;
    for node in 0..measures.n_nodes() {
        let n_links = measures.n_links(node);
        if is_reached[node] && !is_cut[node] {
            is_reached[next..next + n_links].fill(true);
        }
        next += n_links;
    }
    is_reached
}

/// Prices that are looked at first: those of some nodes, from low to high, between bounds that no price of a node is beyond.
fn prices(measures: &Measures, rank: Rank) -> Vec<f64> {
    /// So many that few nodes lie between two of them.
    const N: usize = 255;
    let errors = || measures.errors.iter().copied().filter(|&e| e > 0.0);
    let most = 2.0 * f64::from(errors().fold(0.0, f32::max));
    let least = f64::from(errors().fold(f32::MAX, f32::min)) / 1e3;
    // Counted from the end, where most nodes are finest.
    let some = measures.errors.iter().rev().step_by(measures.n_nodes() / N + 1);
    let price = |&error: &f32| f64::from(error) / (rank.n_children() - 1) as f64;
    let mut prices: Vec<f64> = some.map(price).filter(|&p| least < p && p < most).collect();
    prices.extend([least, most]);
    prices.sort_by(f64::total_cmp);
    prices
}

/// The cheapest trees on both sides of the price at which a property ends that those of small prices have: the one of the largest
/// price that is found to have it, and the one of the smallest that is found not to. Where all have it, or none, the two are the same.
pub(super) fn boundary(measures: &Measures, rank: Rank, holds: impl Fn(Cost) -> bool) -> [Pruning; 2] {
    let at = |price: f64| cheapest(measures, rank, price, |_, _| {});
    let all = |price: f64| pruned(measures, rank, price);
    let prices = prices(measures, rank);
    let (least, most) = (prices[0], prices[prices.len() - 1]);
    for price in [most, 0.0] {
        if holds(at(price)) == (price > 0.0) {
            let pruning = all(price);
            return [pruning.clone(), pruning];
        }
    }
    let above = prices.partition_point(|&price| price == least || (price < most && holds(at(price))));
    let (mut lower, mut upper) = (prices[above - 1], prices[above]);
    let undecided = Undecided::new(measures, rank, [&all(lower), &all(upper)]);
    let mut n_leaves = [lower, upper].map(|price| undecided.cheapest(price).n_leaves);
    // By the logarithm of the price, since errors of nodes span many decades.
    while upper / lower > 1.0 + 1e-7 && n_leaves[0] > n_leaves[1] {
        let price = (lower * upper).sqrt();
        let found = undecided.cheapest(price);
        let side = usize::from(!holds(found));
        *[&mut lower, &mut upper][side] = price;
        n_leaves[side] = found.n_leaves;
    }
    [all(lower), all(upper)]
}

/// As [`boundary`], for a property of the trees themselves.
pub(super) fn boundary_of_trees(
    measures: &Measures,
    rank: Rank,
    holds: impl Fn(&Pruning) -> bool,
) -> [Pruning; 2] {
    let prices = prices(measures, rank);
    let at = |price: f64| pruned(measures, rank, price);
    let (first, last) = (at(0.0), at(prices[prices.len() - 1]));
    if holds(&last) {
        return [last.clone(), last];
    }
    if !holds(&first) {
        return [first.clone(), first];
    }
    let (mut below, mut above) = ((prices[0], first), (prices[prices.len() - 1], last));
    while above.0 / below.0 > 1.0 + 1e-7 && below.1.cost.n_leaves > above.1.cost.n_leaves {
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
/// the costs without it and with it.
pub(super) fn between(
    measures: &Measures,
    source: &impl Source,
    [few, many]: [&Pruning; 2],
    takes: impl Fn(Cost, Cost) -> bool,
) -> Pruning {
    let mut result = few.clone();
    let mut differences = Vec::new();
    if let Content::Node(root) = source.root().content() {
        collect(measures, source, root, [few, many], &mut differences);
    }
    let gain = |d: &Difference| d.less_error / d.more_leaves.max(1) as f64;
    differences.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
    for Difference { node, more_leaves, less_error } in differences {
        let Cost { error, n_leaves } = result.cost;
        let with = Cost { error: error - less_error, n_leaves: n_leaves + more_leaves };
        if takes(result.cost, with) {
            copy(source, node, &many.is_cut, &mut result.is_cut);
            result.cost = with;
        }
    }
    result
}

fn collect(
    measures: &Measures,
    source: &impl Source,
    node: u32,
    prunings: [&Pruning; 2],
    differences: &mut Vec<Difference>,
) {
    match (prunings[0].is_cut[node as usize], prunings[1].is_cut[node as usize]) {
        (true, true) => {}
        (true, false) => {
            let left = left(measures, source, node, &prunings[1].is_cut);
            let less_error = f64::from(measures.errors[node as usize]) - left.error;
            differences.push(Difference { node, more_leaves: left.n_leaves - 1, less_error });
        }
        (false, _) => {
            source.nodes_below(node).for_each(|child| collect(measures, source, child, prunings, differences))
        }
    }
}

/// What is left of a node.
fn left(measures: &Measures, source: &impl Source, node: u32, is_cut: &[bool]) -> Cost {
    if is_cut[node as usize] {
        return Cost::leaf(measures.errors[node as usize]);
    }
    let below = source.nodes_below(node);
    let leaves = Cost { error: 0.0, n_leaves: source.rank().n_children() - below.len() };
    below.fold(leaves, |cost, child| cost.plus(left(measures, source, child, is_cut)))
}

/// Copies what is cut in a branch.
fn copy(source: &impl Source, node: u32, from: &[bool], to: &mut [bool]) {
    to[node as usize] = from[node as usize];
    source.nodes_below(node).for_each(|child| copy(source, child, from, to));
}
