//! A binary tree over boxes by the surface area heuristic.
//!
//! Enters: boxes. Leaves: a full binary tree in preorder with one box per leaf.
//! Invariants: the same tree whatever the number of threads; depth below [`SAH_DEPTH`] + log₂(n), so that later walks may
//! recurse. Source: Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007 (binning).

use super::primitives::Bounds;

/// Bins per axis; more did not make faster trees on blinds, meshes or spheres.
const N_BINS: usize = 32;
/// Below this depth halves are taken by count, which ends.
const SAH_DEPTH: u32 = 36;
/// Subtrees with fewer boxes are not worth a thread.
const PARALLEL_FROM: usize = 4096;

/// A node over `count` boxes: its left child follows it, its right child stands `2·left_count` places on; a single box is a
/// leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub bounds: Bounds,
    pub count: u32,
    /// A leaf's box; an inner node's number of boxes on the left.
    pub item: u32,
}

impl Pair {
    /// Places of the children of the inner node at `place`.
    pub fn children(&self, place: usize) -> [usize; 2] {
        [place + 1, place + 2 * self.item as usize]
    }
}

/// Tree over at least one box, `2n − 1` nodes, root first.
pub(super) fn binary_tree(boxes: &[Bounds]) -> Vec<Pair> {
    let mut items: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Pair { bounds: Bounds::EMPTY, count: 0, item: 0 }; 2 * boxes.len() - 1];
    fill(boxes, &mut items, &mut nodes, 0);
    nodes
}

fn fill(boxes: &[Bounds], items: &mut [u32], nodes: &mut [Pair], depth: u32) {
    let bounds = items.iter().fold(Bounds::EMPTY, |b, &i| b.union(&boxes[i as usize]));
    let count = items.len();
    if count == 1 {
        nodes[0] = Pair { bounds, count: 1, item: items[0] };
        return;
    }
    let left_count = if depth < SAH_DEPTH { sah_split(boxes, items) } else { None }
        .unwrap_or_else(|| middle_split(boxes, items, &bounds));
    nodes[0] = Pair { bounds, count: count as u32, item: left_count as u32 };
    let (left_items, right_items) = items.split_at_mut(left_count);
    let (left_nodes, right_nodes) = nodes[1..].split_at_mut(2 * left_count - 1);
    let mut left = || fill(boxes, left_items, left_nodes, depth + 1);
    let mut right = || fill(boxes, right_items, right_nodes, depth + 1);
    if count >= PARALLEL_FROM {
        rayon::join(left, right);
    } else {
        left();
        right();
    }
}

/// Twice the centre of a box along an axis.
#[inline]
fn center(b: &Bounds, axis: usize) -> f32 {
    b.lower[axis] + b.upper[axis]
}

/// Partition by the cheapest plane between bins; how many boxes went left, or `None` if all centres coincide.
fn sah_split(boxes: &[Bounds], items: &mut [u32]) -> Option<usize> {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for &i in items.iter() {
        for axis in 0..3 {
            let c = center(&boxes[i as usize], axis);
            low[axis] = low[axis].min(c);
            high[axis] = high[axis].max(c);
        }
    }
    let n_bins = N_BINS.min(items.len() * 2);
    let per_length: [f32; 3] = std::array::from_fn(|axis| n_bins as f32 / (high[axis] - low[axis]));
    let bin = |i: u32, axis: usize| {
        ((center(&boxes[i as usize], axis) - low[axis]) * per_length[axis]).min(n_bins as f32 - 1.0) as usize
    };
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| per_length[axis].is_finite()) {
        let mut bins = [(Bounds::EMPTY, 0u32); N_BINS];
        for &i in items.iter() {
            let (bounds, count) = &mut bins[bin(i, axis)];
            *bounds = bounds.union(&boxes[i as usize]);
            *count += 1;
        }
        if let Some((cost, plane)) = cheapest_plane(&bins[..n_bins])
            && best.is_none_or(|b| cost < b.0)
        {
            best = Some((cost, axis, plane));
        }
    }
    let (_, axis, plane) = best?;
    let mut left = 0;
    for k in 0..items.len() {
        if bin(items[k], axis) < plane {
            items.swap(left, k);
            left += 1;
        }
    }
    Some(left)
}

/// Cost and number of bins on the left, over all planes with boxes on both sides.
fn cheapest_plane(bins: &[(Bounds, u32)]) -> Option<(f32, usize)> {
    let mut right_cost = [f32::INFINITY; N_BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for k in (1..bins.len()).rev() {
        bounds = bounds.union(&bins[k].0);
        count += bins[k].1;
        if count > 0 {
            right_cost[k] = bounds.half_area() * count as f32;
        }
    }
    let mut best: Option<(f32, usize)> = None;
    (bounds, count) = (Bounds::EMPTY, 0);
    for k in 1..bins.len() {
        bounds = bounds.union(&bins[k - 1].0);
        count += bins[k - 1].1;
        let cost = bounds.half_area() * count as f32 + right_cost[k];
        if count > 0 && cost.is_finite() && best.is_none_or(|b| cost < b.0) {
            best = Some((cost, k));
        }
    }
    best
}

/// Halve by count along the longest axis.
fn middle_split(boxes: &[Bounds], items: &mut [u32], bounds: &Bounds) -> usize {
    let axis = (0..3).max_by(|&a, &b| bounds.extent(a).total_cmp(&bounds.extent(b))).unwrap_or(0);
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |&a, &b| {
        let order = center(&boxes[a as usize], axis).total_cmp(&center(&boxes[b as usize], axis));
        order.then(a.cmp(&b))
    });
    middle
}
