//! Where a patch is best cut.
//!
//! In: the points and events of a patch. Out: for each coordinate, what taking the patch for uniform may change because of
//! variation along it, and the place of the best cut. See [`partition`](super::partition) for the measure.

use super::partition::{Event, Key, N_AXES};

/// Parts into which each coordinate is divided to find where to cut.
const N_BINS: usize = 16;

/// Fewest points in a patch: its area is known to a few parts in a hundred.
const LEAST_POINTS: usize = 128;

/// Points, and events, by which bins are laid.
const N_LOOKED_AT: usize = 1024;

/// Points, and events, that a bin is worth.
const LEAST_IN_BIN: usize = 32;

/// Standard errors from which on a difference is taken for one.
const SIGNIFICANT: f64 = 3.0;

/// How much of what a patch may change is left to each half: of light that varies linearly along the coordinate that was cut
/// (half the area, half the deviation of both factors), and along another, which may be the same variation.
const LEFT_ALONG: f64 = 0.125;
const LEFT_ACROSS: f64 = 0.25;

#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    pub axis: usize,
    pub threshold: f32,
    /// What taking the patch for uniform may change.
    pub spread: f64,
    /// What it may change because of variation along each coordinate.
    along: [f64; N_AXES],
}

impl Cut {
    /// What is to be expected of each half.
    pub fn expected(&self) -> [f64; N_AXES] {
        let left = |k| if k == self.axis { LEFT_ALONG } else { LEFT_ACROSS };
        std::array::from_fn(|k| self.along[k] * left(k))
    }
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
pub(super) fn best_cut(
    points: &[Key],
    events: &[Event],
    n_origins: usize,
    expected: [f64; N_AXES],
) -> (Option<Cut>, f64) {
    let mut best: Option<(f64, usize, f32)> = None;
    let mut along = [0.0; N_AXES];
    let mut size = 0.0;
    for axis in 0..N_AXES {
        let edges = edges(points, events, axis);
        if edges.is_empty() && axis > 0 {
            continue;
        }
        let mut filled = [f32::INFINITY; N_BINS];
        filled[..edges.len()].copy_from_slice(&edges);
        let bin = |key: &Key| filled.iter().map(|&edge| u32::from(key[axis] >= edge)).sum::<u32>() as usize;
        let mut counts = vec![0.0f64; edges.len() + 1];
        points.iter().for_each(|key| counts[bin(key)] += 1.0);
        let mut bins = Bins { sums: vec![0.0; (edges.len() + 1) * 4 * n_origins], n_origins };
        events.iter().for_each(|event| bins.add(bin(&event.key), event));
        let areas: Vec<f64> = counts.iter().map(|c| c.max(0.5)).collect();
        let [sent, returned] = [SENT, RETURNED].map(|kind| Spread::new(&bins, kind, &areas));
        size = (sent.square.max(0.0) * returned.square.max(0.0)).sqrt();
        let seen =
            sent.deviation > SIGNIFICANT * sent.error && returned.deviation > SIGNIFICANT * returned.error;
        along[axis] = if seen {
            (sent.deviation * returned.deviation).sqrt()
        } else {
            (sent.most() * returned.most()).sqrt().min(expected[axis])
        };
        if along[axis] > best.map_or(0.0, |b| b.0)
            && let Some(k) = place(&sent, &returned, &areas, seen)
        {
            best = Some((along[axis], axis, edges[k]));
        }
    }
    (best.map(|(spread, axis, threshold)| Cut { axis, threshold, spread, along }), size)
}

/// At most [`N_LOOKED_AT`] of the items.
fn every<T>(items: &[T]) -> impl Iterator<Item = &T> {
    items.iter().step_by(items.len().div_ceil(N_LOOKED_AT).max(1))
}

/// Values of a coordinate between which about as many points and events lie; never one that a point has.
fn edges(points: &[Key], events: &[Event], axis: usize) -> Vec<f32> {
    let mut values: Vec<f32> = every(points).map(|key| key[axis]).collect();
    let share = values.len();
    values.extend(every(events).map(|e| e.key[axis]).take(share));
    values.sort_unstable_by(f32::total_cmp);
    let (Some(&low), Some(&high)) = (values.first(), values.last()) else { return Vec::new() };
    // Normals of a flat surface differ by rounding alone.
    let least = (1e-4 * (high - low)).max(1e-5);
    let n = (points.len().min(events.len()) / LEAST_IN_BIN).clamp(2, N_BINS);
    let mut edges: Vec<f32> = Vec::new();
    for k in 1..=n {
        // Below the value at each part, and above the last.
        let value = values[(k.min(n - 1) * values.len()) / n];
        let other = if k < n {
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

fn add(sums: &mut [f32], row: &[f32]) {
    sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
}

/// Σ f(x, y), in eight sums side by side.
fn sum_of(x: &[f32], y: &[f32], f: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sums = [0.0; 8];
    let (x, y) = (x.chunks_exact(8), y.chunks_exact(8));
    let rest = x.remainder().iter().zip(y.remainder());
    let rest: f64 = rest.map(|(&x, &y)| f(f64::from(x), f64::from(y))).sum();
    for (x, y) in x.zip(y) {
        for k in 0..8 {
            sums[k] += f(f64::from(x[k]), f64::from(y[k]));
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// How light differs between bins.
struct Spread {
    /// Square of the mean density times area.
    square: f64,
    /// Sum over bins of area times squared deviation of the density.
    deviation: f64,
    /// Standard error of that where there is no deviation, and what areas known by counting make of it.
    error: f64,
    /// The deviation of the two halves on either side of each edge.
    cuts: Vec<f64>,
}

impl Spread {
    fn new(bins: &Bins, kind: usize, areas: &[f64]) -> Spread {
        let rows = |bin: usize| [0, 1].map(|half| bins.row(bin, kind, half));
        let mut totals = [(); 2].map(|()| vec![0.0f32; bins.n_origins]);
        let area: f64 = areas.iter().sum();
        let (mut between, mut variance, mut uncounted) = (0.0, 0.0, 0.0);
        for (bin, &a) in areas.iter().enumerate() {
            let [x, y] = rows(bin);
            let product = sum_of(x, y, |x, y| x * y);
            between += product / a;
            // A count of points is uncertain by its root.
            uncounted += product.max(0.0) / (a * a);
            // Of normal x and y, the mean of (x − y)⁴ is twelve times their squared variance.
            variance += sum_of(x, y, |x, y| ((x - y) * (x - y)) * ((x - y) * (x - y))) / (12.0 * a * a);
            totals.iter_mut().zip([x, y]).for_each(|(total, row)| add(total, row));
        }
        let square = sum_of(&totals[0], &totals[1], |x, y| x * y) / area;
        let mut left = [(); 2].map(|()| vec![0.0f32; bins.n_origins]);
        let mut left_area = 0.0;
        let mut cuts = Vec::with_capacity(areas.len());
        for (bin, &a) in areas.iter().enumerate().take(areas.len() - 1) {
            left.iter_mut().zip(rows(bin)).for_each(|(left, row)| add(left, row));
            left_area += a;
            let [x, y] = [0, 1].map(|half| sum_of(&left[half], &totals[1 - half], |x, y| x * y));
            let within = sum_of(&left[0], &left[1], |x, y| x * y);
            // (X − x)(Y − y) over what is right of the edge.
            let right = square * area - x - y + within;
            cuts.push(within / left_area + right / (area - left_area) - square);
        }
        Spread { square, deviation: between - square, error: variance.sqrt() + uncounted / 3.0, cuts }
    }

    /// The most that the deviation may be.
    fn most(&self) -> f64 {
        self.deviation.max(0.0) + SIGNIFICANT * self.error
    }
}

/// The edge at which to cut: where sent and returned light both differ most if that can be seen, or else in the middle.
fn place(sent: &Spread, returned: &Spread, areas: &[f64], seen: bool) -> Option<usize> {
    let total: f64 = areas.iter().sum();
    let mut left = 0.0;
    let mut best: Option<(usize, [f64; 2])> = None;
    for k in 0..sent.cuts.len() {
        left += areas[k];
        let smaller = left.min(total - left);
        if smaller < LEAST_POINTS as f64 {
            continue;
        }
        let gain = if seen { sent.cuts[k].max(0.0) * returned.cuts[k].max(0.0) } else { 0.0 };
        let merit = [gain, smaller];
        if best.is_none_or(|(_, least)| merit > least) {
            best = Some((k, merit));
        }
    }
    best.map(|(k, _)| k)
}
