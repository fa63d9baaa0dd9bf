//! From the binary tree to the 8-wide one, at least expected cost.
//!
//! Enters: a binary tree, which boxes are triangles. Leaves: wide nodes, leaves, and the order of the primitives in them.
//! Invariant: a subtree becomes one leaf, one wide node, or is dissolved into its parent, whichever is cheapest.
//! Source: Ylitie, Karras & Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017,
//! section 3.1. Deviation: a leaf of triangles costs the same however full it is, as one SIMD test covers it.

use super::node::{Child, Node, PADDING, WIDTH};
use super::primitives::Bounds;
use super::split::Pair;

/// Expected time of one test relative to a node's. Between 0.5 and 1.5 speeds on the scenes of `benches/bvh.rs` are the same.
const LEAF_COST: f32 = 0.9;
const ANALYTIC_COST: f32 = 1.0;
const NODE_COST: f32 = 1.0;
/// Analytic surfaces are tested one by one.
const MOST_ANALYTIC: u32 = 4;

/// The wide tree; primitives named as in the boxes given to [`binary_tree`](super::split::binary_tree).
#[derive(Default)]
pub(super) struct Wide {
    pub nodes: Vec<Node>,
    /// Triangles of each leaf.
    pub leaves: Vec<Vec<u32>>,
    /// Analytic surfaces in the order [`Child::analytic`] refers to.
    pub analytic: Vec<u32>,
}

/// Cheapest ways to represent one binary node.
#[derive(Clone, Copy)]
struct Plan {
    /// `[i]`: cost as at most `i + 1` roots.
    cost: [f32; WIDTH - 1],
    /// `[i]`: roots given to the left child; 0: no better than fewer roots. `[0]` is unused.
    left: [u8; WIDTH - 1],
    /// Roots given to the left child if this becomes a wide node; 0: it becomes a leaf.
    left_of_node: u8,
    n_triangles: u32,
}

/// Collapse a binary tree whose boxes below `n_triangles` are triangles and the others analytic.
pub(super) fn collapse(tree: &[Pair], n_triangles: usize) -> Wide {
    let plans = plan(tree, n_triangles);
    let mut wide = Wide::default();
    let root = Collapse { tree, plans: &plans }.emit(0, &mut wide);
    if wide.nodes.is_empty() {
        wide.nodes.push(Node::default());
        set_child(&mut wide.nodes[0], 0, &tree[0].bounds, root);
    }
    wide
}

fn plan(tree: &[Pair], n_triangles: usize) -> Vec<Plan> {
    let empty = Plan { cost: [0.0; WIDTH - 1], left: [0; WIDTH - 1], left_of_node: 0, n_triangles: 0 };
    let mut plans = vec![empty; tree.len()];
    for place in (0..tree.len()).rev() {
        let pair = &tree[place];
        let area = pair.bounds.half_area();
        if pair.count == 1 {
            let is_triangle = (pair.item as usize) < n_triangles;
            let cost = area * if is_triangle { LEAF_COST } else { ANALYTIC_COST };
            plans[place] = Plan { cost: [cost; WIDTH - 1], n_triangles: is_triangle as u32, ..empty };
            continue;
        }
        let [left, right] = pair.children(place).map(|child| plans[child]);
        let share = |roots: usize| {
            (1..roots)
                .filter(|&k| k < WIDTH && roots - k < WIDTH)
                .map(|k| (left.cost[k - 1] + right.cost[roots - k - 1], k as u8))
                .fold((f32::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a })
        };
        let mut plan = Plan { n_triangles: left.n_triangles + right.n_triangles, ..empty };
        let (children_cost, left_of_node) = share(WIDTH);
        (plan.cost[0], plan.left_of_node) = (children_cost + area * NODE_COST, left_of_node);
        if let Some(cost) = leaf_cost(pair.count, plan.n_triangles)
            && area * cost <= plan.cost[0]
        {
            (plan.cost[0], plan.left_of_node) = (area * cost, 0);
        }
        for i in 1..WIDTH - 1 {
            let (cost, k) = share(i + 1);
            let better = cost < plan.cost[i - 1];
            (plan.cost[i], plan.left[i]) = if better { (cost, k) } else { (plan.cost[i - 1], 0) };
        }
        plans[place] = plan;
    }
    plans
}

fn leaf_cost(count: u32, n_triangles: u32) -> Option<f32> {
    if n_triangles == count && count <= WIDTH as u32 {
        Some(LEAF_COST)
    } else if n_triangles == 0 && count <= MOST_ANALYTIC {
        Some(ANALYTIC_COST * count as f32)
    } else {
        None
    }
}

struct Collapse<'a> {
    tree: &'a [Pair],
    plans: &'a [Plan],
}

impl Collapse<'_> {
    /// Write the subtree at `place` as one child.
    fn emit(&self, place: usize, wide: &mut Wide) -> Child {
        let (pair, plan) = (&self.tree[place], &self.plans[place]);
        if plan.left_of_node == 0 {
            let items = self.tree[place..place + 2 * pair.count as usize - 1].iter();
            let items = items.filter(|p| p.count == 1).map(|p| p.item);
            if plan.n_triangles > 0 {
                wide.leaves.push(items.collect());
                return Child::leaf(wide.leaves.len() - 1);
            }
            let first = wide.analytic.len();
            wide.analytic.extend(items);
            return Child::analytic(first, pair.count as usize);
        }
        let mut roots = Vec::with_capacity(WIDTH);
        let [left, right] = pair.children(place);
        self.roots(left, plan.left_of_node as usize, &mut roots);
        self.roots(right, WIDTH - plan.left_of_node as usize, &mut roots);
        let index = wide.nodes.len();
        wide.nodes.push(Node::default());
        for (lane, &root) in roots.iter().enumerate() {
            let child = self.emit(root, wide);
            set_child(&mut wide.nodes[index], lane, &self.tree[root].bounds, child);
        }
        Child::node(index)
    }

    /// The at most `limit` subtrees that stand for the one at `place`.
    fn roots(&self, place: usize, limit: usize, found: &mut Vec<usize>) {
        let mut limit = limit;
        while limit > 1 && self.plans[place].left[limit - 1] == 0 {
            limit -= 1;
        }
        if limit == 1 {
            found.push(place);
            return;
        }
        let left_limit = self.plans[place].left[limit - 1] as usize;
        let [left, right] = self.tree[place].children(place);
        self.roots(left, left_limit, found);
        self.roots(right, limit - left_limit, found);
    }
}

fn set_child(node: &mut Node, lane: usize, bounds: &Bounds, child: Child) {
    for axis in 0..3 {
        node.planes[2 * axis][lane] = bounds.lower[axis] - PADDING;
        node.planes[2 * axis + 1][lane] = bounds.upper[axis] + PADDING;
    }
    node.children[lane] = child;
}
