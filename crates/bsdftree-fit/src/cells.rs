//! A fitted model over the cells of a tree: means over incident and exitant cell.
//!
//! Two pairs of points for each pair of cells, four where the two differ, and sixteen where the four do. Rows are brought to the totals that were measured.

use bsdftree::Rank;
use bsdftree::square::disk_from_square;

use crate::lambert::Ray;

/// Strata of a cell along an axis.
const STRATA: usize = 2;
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

/// The mean of `f(incident point, exitant point)` over a pair of cells.
#[inline]
pub(crate) fn mean(level: f32, mut f: impl FnMut(usize, usize) -> f32) -> f32 {
    /// Each incident point with one exitant point, no two alike.
    const PARTNER: [usize; N_POINTS] = [0, 2, 3, 1];
    /// Difference, in units of the mean or of the level, over which more points are taken: after two, after four.
    const ROUGH: [f32; 2] = [0.06, 0.2];
    let is_smooth = |low: f32, high: f32, mean: f32, rough: f32| high - low <= rough * mean.max(level);
    let (a, b) = (f(0, PARTNER[0]), f(2, PARTNER[2]));
    if is_smooth(a.min(b), a.max(b), 0.5 * (a + b), ROUGH[0]) {
        return 0.5 * (a + b);
    }
    let four = [a, f(1, PARTNER[1]), b, f(3, PARTNER[3])];
    let sum: f32 = four.iter().sum();
    let (low, high) = four.iter().fold((f32::MAX, 0f32), |(l, h), &v| (l.min(v), h.max(v)));
    if is_smooth(low, high, 0.25 * sum, ROUGH[1]) {
        return 0.25 * sum;
    }
    let others =
        (0..N_POINTS).flat_map(|i| (0..N_POINTS).filter(move |&o| PARTNER[i] != o).map(move |o| (i, o)));
    (sum + others.map(|(i, o)| f(i, o)).sum::<f32>()) / (N_POINTS * N_POINTS) as f32
}
