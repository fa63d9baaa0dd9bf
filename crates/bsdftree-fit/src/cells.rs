//! A fitted model over the cells of a tree: means over incident and exitant cell.
//!
//! Two pairs of points for each pair of cells, four where the two differ; sixteen where those do or cells beside each other differ, and
//! where the sixteen do, every point of one cell with every point of the other. Rows are brought to the totals that were measured.

use bsdftree::Rank;
use bsdftree::square::disk_from_square;

use crate::lambert::Ray;

/// Strata of a cell along an axis.
const STRATA: usize = 4;
/// Points of a cell.
pub(crate) const N_POINTS: usize = STRATA * STRATA;

/// The finest cells of a tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells {
    pub rank: Rank,
    pub log2_res: u32,
}

impl Cells {
    /// Cells along an axis.
    pub fn n(self) -> usize {
        1 << self.log2_res
    }

    /// Incident cells with values: of rank 3, those below ½.
    pub fn n_incident(self) -> usize {
        match self.rank {
            Rank::Three => self.n() / 2,
            Rank::Four => self.n() * self.n(),
        }
    }

    pub fn n_exitant(self) -> usize {
        self.n() * self.n()
    }

    /// Projected solid angle of an exitant cell \[sr\].
    pub fn omega(self) -> f64 {
        std::f64::consts::PI / self.n_exitant() as f64
    }

    /// Incident directions in a cell, upper hemisphere, evenly spread over its projected solid angle.
    pub fn incident(self, cell: usize) -> [Ray; N_POINTS] {
        let n = self.n();
        match self.rank {
            Rank::Four => self.points(cell).map(|[x, y]| upper([-x, -y])),
            Rank::Three => std::array::from_fn(|k| {
                let sine = |c: usize| 1.0 - 2.0 * c as f64 / n as f64;
                let (outer, inner) = (sine(cell), sine(cell + 1));
                let u = (k as f64 + 0.5) / N_POINTS as f64;
                upper([-(inner * inner + (outer * outer - inner * inner) * u).sqrt(), 0.0])
            }),
        }
    }

    /// Exitant directions in a cell, upper hemisphere.
    pub fn exitant(self, cell: usize) -> [Ray; N_POINTS] {
        self.points(cell).map(upper)
    }

    fn points(self, cell: usize) -> [[f64; 2]; N_POINTS] {
        let n = self.n();
        let (p, q) = (cell / n, cell % n);
        std::array::from_fn(|k| {
            let at =
                |c: usize, stratum: usize| (c as f64 + (stratum as f64 + 0.5) / STRATA as f64) / n as f64;
            disk_from_square([at(p, k / STRATA), at(q, k % STRATA)])
        })
    }
}

/// The direction over a point of the disk.
pub(crate) fn upper([x, y]: [f64; 2]) -> Ray {
    [x as f32, y as f32, (1.0 - x * x - y * y).max(0.0).sqrt() as f32]
}

/// Four incident points, the first two opposite each other and the others too, one in each row and column of strata.
pub(crate) const FOUR: [usize; 4] = [4, 11, 13, 2];

/// The exitant point that an incident one is paired with: a quarter turn on, so that their differences are spread evenly too.
pub(crate) fn partner(point: usize) -> usize {
    (STRATA - 1 - point % STRATA) * STRATA + point / STRATA
}

/// Whether values that lie between two are as good as equal, in units of the mean or of the level.
fn is_smooth(low: f32, high: f32, mean: f32, level: f32, rough: f32) -> bool {
    high - low <= rough * mean.max(level)
}

/// The means of `f(exitant cell)(incident point, exitant point)` over an incident cell with each exitant one.
pub(crate) fn means<F: Fn(usize, usize) -> f32>(
    level: f32,
    n: usize,
    row: &mut [f32],
    f: impl Fn(usize) -> F,
) {
    let first = |(c, mean): (usize, &mut f32)| {
        let rough;
        (*mean, rough) = first_mean(level, f(c));
        rough
    };
    let rough: Vec<bool> = row.iter_mut().enumerate().map(first).collect();
    let first = row.to_vec();
    for (c, mean) in row.iter_mut().enumerate() {
        if rough[c] || beside_edge(&first, n, c, level) {
            *mean = fine_mean(level, n, f(c));
        }
    }
}

/// The mean of `f(incident point, exitant point)` over a pair of cells by two or four pairs, and whether they are too few.
#[inline]
fn first_mean(level: f32, f: impl Fn(usize, usize) -> f32) -> (f32, bool) {
    /// Difference over which more points are taken: after two, after four.
    const ROUGH: [f32; 2] = [0.06, 0.2];
    let [a, b] = [FOUR[0], FOUR[1]].map(|i| f(i, partner(i)));
    if is_smooth(a.min(b), a.max(b), 0.5 * (a + b), level, ROUGH[0]) {
        return (0.5 * (a + b), false);
    }
    let [c, d] = [FOUR[2], FOUR[3]].map(|i| f(i, partner(i)));
    let mean = 0.25 * (a + b + c + d);
    let (low, high) = (a.min(b).min(c).min(d), a.max(b).max(c).max(d));
    (mean, !is_smooth(low, high, mean, level, ROUGH[1]))
}

/// The mean over a pair of cells, of `n` along an axis, that a few pairs of points are too few for.
fn fine_mean(level: f32, n: usize, f: impl Fn(usize, usize) -> f32) -> f32 {
    /// Difference of sixteen over which all are taken: more than slopes have, less than edges.
    const ROUGH: f32 = 1.5;
    let (mut sum, mut low, mut high) = (0f32, f32::MAX, 0f32);
    for value in (0..N_POINTS).map(|i| f(i, partner(i))) {
        (sum, low, high) = (sum + value, low.min(value), high.max(value));
    }
    let mean = sum / N_POINTS as f32;
    if is_smooth(low, high, mean, level, ROUGH) {
        return mean;
    }
    // Small cells need fewer: what varies within them is less.
    let step = (n / 32).pow(3).clamp(1, 8);
    let pairs = (0..N_POINTS).flat_map(|i| (i % step..N_POINTS).step_by(step).map(move |o| (i, o)));
    pairs.map(|(i, o)| f(i, o)).sum::<f32>() / (N_POINTS * N_POINTS / step) as f32
}

/// Whether an exitant cell differs so much from one beside it that an edge may lie between its points.
fn beside_edge(means: &[f32], n: usize, cell: usize, level: f32) -> bool {
    const ROUGH: f32 = 0.4;
    let (row, column) = (cell / n, cell % n);
    let beside = [
        (row > 0).then(|| cell - n),
        (row + 1 < n).then(|| cell + n),
        (column > 0).then(|| cell - 1),
        (column + 1 < n).then(|| cell + 1),
    ];
    let value = means[cell];
    beside
        .into_iter()
        .flatten()
        .map(|k| means[k])
        .any(|v| (v - value).abs() > ROUGH * v.max(value).max(level))
}
