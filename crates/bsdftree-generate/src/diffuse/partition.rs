//! Patches of surface within which light arrives alike, wherever it comes from.
//!
//! In: points that measure area; events, which are light of known origin that met a surface. Out: a tree that sorts every
//! position and normal into one of a bounded number of patches.
//!
//! Over a patch of area a, let p be the vector of light sent out for light from each origin, and q that of light which would come
//! from there if it were sent back, both per area. Taking p and q for constant over the patch changes what the patch
//! scatters by Σ a_b (p_b − p)(q_b − q)ᵀ over its parts b: the product of two root mean squares bounds it. The patch for which
//! that bound is the largest is cut next, across the coordinate along which it is largest, where the halves differ most.
//! Two independent halves of the events are multiplied with each other, so that noise adds nothing in the mean. What cannot be
//! told from noise is expected to be what it was before the last cut, less what a cut takes off linear variation.
//!
//! Coordinates are place, normal, and the place within one period of a device that says that it has one, so that equal places of
//! different periods can share a patch.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

use super::spread::{Cut, best_cut};

/// Number of coordinates.
pub(crate) const N_AXES: usize = 8;

/// Coordinates of a place on a surface: position in the box (3), normal (3), position in the period (2).
pub(crate) type Key = [f32; N_AXES];

/// Light that met a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Event {
    pub key: Key,
    /// Where it came from, below the number of origins.
    pub origin: u16,
    /// Which of the two halves it belongs to: 0 or 1.
    pub half: u8,
    /// Number of the medium it came through.
    pub medium: u8,
    /// Light sent out.
    pub sent: f32,
    /// Light that would come if it were sent back.
    pub returned: f32,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    axis: u8,
    threshold: f32,
    /// The first of two children, or the patch of a leaf.
    next: u32,
}

const LEAF: u8 = u8::MAX;

/// A tree that sorts keys into patches.
#[derive(Clone, Debug)]
pub(crate) struct Partition {
    nodes: Vec<Node>,
}

/// What is in a patch: ranges of the sorted points and events.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    pub points: Range<usize>,
    pub events: Range<usize>,
}

struct Candidate {
    cut: Cut,
    /// The patch's part of the whole.
    size: f64,
    patch: Patch,
    node: u32,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cut.spread.total_cmp(&other.cut.spread).then(other.node.cmp(&self.node))
    }
}

impl Partition {
    /// Cuts into at most `budget` patches, or until no cut matters by more than `tolerance` of the whole. Sorts points and
    /// events by patch.
    pub fn grow(
        points: &mut [Key],
        events: &mut [Event],
        n_origins: usize,
        budget: usize,
        tolerance: f64,
    ) -> (Partition, Vec<Patch>) {
        let root = Patch { points: 0..points.len(), events: 0..events.len() };
        let mut nodes = vec![Node { axis: LEAF, threshold: 0.0, next: 0 }];
        let mut patches = vec![root.clone()];
        let mut heap = BinaryHeap::new();
        let consider = |points: &[Key], events: &[Event], patch: Patch, node: u32, expected| {
            let (points, events) = (&points[patch.points.clone()], &events[patch.events.clone()]);
            let (cut, size) = best_cut(points, events, n_origins, expected);
            (cut.map(|cut| Candidate { cut, size, patch, node }), size)
        };
        let (first, mut whole) = consider(points, events, root, 0, [0.0; N_AXES]);
        heap.extend(first);
        while let Some(candidate) = heap.pop() {
            if patches.len() >= budget || candidate.cut.spread <= tolerance * whole {
                break;
            }
            let Candidate { cut, size, patch, node } = candidate;
            let Cut { axis, threshold, .. } = cut;
            let p =
                patch.points.start + partition(&mut points[patch.points.clone()], |p| p[axis] < threshold);
            let e = patch.events.start
                + partition(&mut events[patch.events.clone()], |e| e.key[axis] < threshold);
            let halves = [
                Patch { points: patch.points.start..p, events: patch.events.start..e },
                Patch { points: p..patch.points.end, events: e..patch.events.end },
            ];
            let index = nodes[node as usize].next;
            let children = nodes.len() as u32;
            nodes[node as usize] = Node { axis: axis as u8, threshold, next: children };
            nodes.push(Node { axis: LEAF, threshold: 0.0, next: index });
            nodes.push(Node { axis: LEAF, threshold: 0.0, next: patches.len() as u32 });
            patches[index as usize] = halves[0].clone();
            patches.push(halves[1].clone());
            whole -= size;
            let (points, events) = (&*points, &*events);
            let [left, right] = halves;
            let (a, b) = rayon::join(
                || consider(points, events, left, children, cut.expected()),
                || consider(points, events, right, children + 1, cut.expected()),
            );
            for (candidate, size) in [a, b] {
                whole += size;
                heap.extend(candidate);
            }
        }
        (Partition { nodes }, patches)
    }

    /// How many cuts are across each coordinate.
    #[cfg(test)]
    pub fn cuts(&self) -> [usize; N_AXES] {
        std::array::from_fn(|axis| self.nodes.iter().filter(|n| usize::from(n.axis) == axis).count())
    }

    /// The patch that a place belongs to.
    #[inline]
    pub fn find(&self, key: &Key) -> usize {
        let mut node = self.nodes[0];
        while node.axis != LEAF {
            let upper = key[usize::from(node.axis)] >= node.threshold;
            node = self.nodes[node.next as usize + usize::from(upper)];
        }
        node.next as usize
    }
}

/// Moves those that belong first to the front; their number.
fn partition<T>(items: &mut [T], first: impl Fn(&T) -> bool) -> usize {
    let mut count = 0;
    for k in 0..items.len() {
        if first(&items[k]) {
            items.swap(k, count);
            count += 1;
        }
    }
    count
}
