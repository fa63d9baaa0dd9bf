//! Patches of surface within which light arrives alike, wherever it comes from.
//!
//! In: points that measure area; events, which are light of known origin that met a surface. Out: a tree that sorts every
//! position and normal into one of a bounded number of patches.
//!
//! Over a patch of area a, let p be the vector of light sent out for light from each origin, and q that of light which would come
//! from there if it were sent back, both per area. Taking p and q for constant over the patch changes what the patch
//! scatters by Σ a_b (p_b − p)(q_b − q)ᵀ over its parts b: the product of two root mean squares bounds it. The patch for which
//! that bound is the largest is cut next, across the coordinate along which it is largest, where the halves differ most.
//! Two independent halves of the events are multiplied with each other, so that noise adds nothing in the mean.
//!
//! Coordinates are place, normal, and the place within one period of a device that says that it has one, so that equal places of
//! different periods can share a patch.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

/// Number of coordinates.
pub(crate) const N_AXES: usize = 8;

/// Coordinates of a place on a surface: position in the box (3), normal (3), position in the period (2).
pub(crate) type Key = [f32; N_AXES];

/// Parts into which each coordinate is divided to find where to cut.
const N_BINS: usize = 16;

/// Fewest points in a patch: its area is known to a few parts in a hundred.
const LEAST_POINTS: usize = 64;

/// Points, and events, by which bins are laid and areas of bins measured.
const N_LOOKED_AT: usize = 2048;

/// Signal below this part of the noise is noise: the scatter of their ratio is 1/(2√n) for n numbers, and there are some hundred.
const LEAST_SIGNAL: f64 = 0.1;

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

#[derive(Clone, Copy, Debug)]
struct Cut {
    axis: usize,
    threshold: f32,
    /// What taking the patch for uniform may change.
    spread: f64,
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
    /// events by patch. `points` are keys with the number of the point.
    pub fn grow(
        points: &mut [(Key, u32)],
        events: &mut [Event],
        n_origins: usize,
        budget: usize,
        tolerance: f64,
    ) -> (Partition, Vec<Patch>) {
        let root = Patch { points: 0..points.len(), events: 0..events.len() };
        let mut nodes = vec![Node { axis: LEAF, threshold: 0.0, next: 0 }];
        let mut patches = vec![root.clone()];
        let mut heap = BinaryHeap::new();
        let consider = |points: &[(Key, u32)], events: &[Event], patch: Patch, node: u32| {
            let (cut, size) = best_cut(&points[patch.points.clone()], &events[patch.events.clone()], n_origins);
            (cut.map(|cut| Candidate { cut, size, patch, node }), size)
        };
        let (first, mut whole) = consider(points, events, root, 0);
        heap.extend(first);
        while let Some(candidate) = heap.pop() {
            if patches.len() >= budget || candidate.cut.spread <= tolerance * whole {
                break;
            }
            let Candidate { cut: Cut { axis, threshold, .. }, size, patch, node } = candidate;
            let p = patch.points.start
                + partition(&mut points[patch.points.clone()], |p| p.0[axis] < threshold);
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
                || consider(points, events, left, children),
                || consider(points, events, right, children + 1),
            );
            for (candidate, size) in [a, b] {
                whole += size;
                heap.extend(candidate);
            }
        }
        (Partition { nodes }, patches)
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

/// Sums over the events of a bin: light sent and returned in either half, by origin.
struct Bins {
    sums: Vec<f32>,
    n_origins: usize,
}

const SENT: usize = 0;
const RETURNED: usize = 1;

impl Bins {
    fn row(&self, bin: usize, kind: usize, half: usize) -> &[f32] {
        let at = ((bin * 2 + kind) * 2 + half) * self.n_origins;
        &self.sums[at..at + self.n_origins]
    }

    fn add(&mut self, bin: usize, event: &Event) {
        let at = (bin * 4 + usize::from(event.half)) * self.n_origins + usize::from(event.origin);
        self.sums[at] += event.sent;
        self.sums[at + 2 * self.n_origins] += event.returned;
    }
}

/// Where a patch is best cut, if it can be, and what it scatters.
fn best_cut(points: &[(Key, u32)], events: &[Event], n_origins: usize) -> (Option<Cut>, f64) {
    let mut best: Option<Cut> = None;
    let mut size = 0.0;
    for axis in 0..N_AXES {
        let edges = edges(points, events, axis);
        if edges.is_empty() && axis > 0 {
            continue;
        }
        let bin = |key: &Key| edges.iter().map(|&edge| usize::from(key[axis] >= edge)).sum::<usize>();
        let mut bins = Bins { sums: vec![0.0; (edges.len() + 1) * 4 * n_origins], n_origins };
        events.iter().for_each(|event| bins.add(bin(&event.key), event));
        let mut counts = vec![0.0f64; edges.len() + 1];
        every(points).for_each(|(key, _)| counts[bin(key)] += 1.0);
        let total: f64 = counts.iter().sum();
        let areas: Vec<f64> = counts.iter().map(|c| c.max(0.5) / total * points.len() as f64).collect();
        let [sent, returned] = [SENT, RETURNED].map(|kind| Spread::new(&bins, kind, &areas));
        size = (sent.square.max(0.0) * returned.square.max(0.0)).sqrt();
        let spread = (sent.signal() * returned.signal()).sqrt();
        if spread <= best.map_or(0.0, |b| b.spread) {
            continue;
        }
        if let Some(k) = place(&sent, &returned, &areas) {
            best = Some(Cut { axis, threshold: edges[k], spread });
        }
    }
    (best, size)
}

/// At most [`N_LOOKED_AT`] of the items.
fn every<T>(items: &[T]) -> impl Iterator<Item = &T> {
    items.iter().step_by(items.len().div_ceil(N_LOOKED_AT).max(1))
}

/// Values of a coordinate between which about as many points and events lie; never one that a point has.
fn edges(points: &[(Key, u32)], events: &[Event], axis: usize) -> Vec<f32> {
    let mut values: Vec<f32> = every(points).map(|(key, _)| key[axis]).collect();
    let share = values.len();
    values.extend(every(events).map(|e| e.key[axis]).take(share));
    values.sort_unstable_by(f32::total_cmp);
    let (Some(&low), Some(&high)) = (values.first(), values.last()) else { return Vec::new() };
    // Normals of a flat surface differ by rounding alone.
    let least = (1e-4 * (high - low)).max(1e-5);
    let mut edges: Vec<f32> = Vec::new();
    for k in 1..=N_BINS {
        // Below the value at each sixteenth, and above the last.
        let value = values[(k.min(N_BINS - 1) * values.len()) / N_BINS];
        let other = if k < N_BINS {
            let below = values.partition_point(|&v| v < value - least);
            values[..below].last()
        } else {
            values.get(values.partition_point(|&v| v <= value + least))
        };
        let edge = other.map(|v| 0.5 * (v + value));
        edges.extend(edge.filter(|&e| edges.last().is_none_or(|&last| e > last)));
    }
    edges
}

/// How light differs between bins.
struct Spread {
    /// Square of the mean density times area.
    square: f64,
    /// Sum over bins of area times squared deviation of the density.
    deviation: f64,
    /// The same of the difference of the halves.
    noise: f64,
    /// The deviation of the two halves on either side of each edge.
    cuts: Vec<f64>,
}

impl Spread {
    fn new(bins: &Bins, kind: usize, areas: &[f64]) -> Spread {
        let n = bins.n_origins;
        let mut totals = [vec![0.0f64; n], vec![0.0f64; n]];
        let area: f64 = areas.iter().sum();
        let (mut between, mut noise) = (0.0, 0.0);
        for (bin, &a) in areas.iter().enumerate() {
            let rows = [0, 1].map(|half| bins.row(bin, kind, half));
            let (mut product, mut difference) = (0.0, 0.0);
            for j in 0..n {
                let [x, y] = rows.map(|row| f64::from(row[j]));
                product += x * y;
                difference += (x - y) * (x - y);
                totals[0][j] += x;
                totals[1][j] += y;
            }
            between += product / a;
            noise += difference / a;
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let square = dot(&totals[0], &totals[1]) / area;
        let mut left = [vec![0.0f64; n], vec![0.0f64; n]];
        let mut left_area = 0.0;
        let mut cuts = Vec::with_capacity(areas.len());
        for bin in 0..areas.len() - 1 {
            for half in 0..2 {
                let row = bins.row(bin, kind, half);
                left[half].iter_mut().zip(row).for_each(|(l, &x)| *l += f64::from(x));
            }
            left_area += areas[bin];
            let right: f64 =
                (0..n).map(|j| (totals[0][j] - left[0][j]) * (totals[1][j] - left[1][j])).sum();
            cuts.push(dot(&left[0], &left[1]) / left_area + right / (area - left_area) - square);
        }
        Spread { square, deviation: between - square, noise, cuts }
    }

    /// The deviation if it is more than noise, else 0.
    fn signal(&self) -> f64 {
        if self.deviation > LEAST_SIGNAL * self.noise { self.deviation } else { 0.0 }
    }
}

/// The edge at which to cut: where sent and returned light both differ most, or else in the middle.
fn place(sent: &Spread, returned: &Spread, areas: &[f64]) -> Option<usize> {
    let total: f64 = areas.iter().sum();
    let mut left = 0.0;
    let mut best: Option<(usize, [f64; 2])> = None;
    for k in 0..sent.cuts.len() {
        left += areas[k];
        let smaller = left.min(total - left);
        if smaller < LEAST_POINTS as f64 {
            continue;
        }
        let merit = [sent.cuts[k].max(0.0) * returned.cuts[k].max(0.0), smaller];
        if best.is_none_or(|(_, least)| merit > least) {
            best = Some((k, merit));
        }
    }
    best.map(|(k, _)| k)
}
