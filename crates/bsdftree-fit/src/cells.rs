//! A fitted model over the cells of a tree: means over incident and exitant cell.
//!
//! Two pairs of points for each pair of cells, four where the two differ; sixteen where those do or cells beside each other differ, and
//! more of the 256 that there are where the sixteen do. Sixteen pairs are an orthogonal array ([`PARTNERS`]). Lobes around the mirror direction
//! depend on differences of the coordinates of both cells: of such a lobe the array's mean is three to seven times nearer than that of
//! pairs which a quarter turn joins, and half as near where light goes back to where it came from, which is rare.
//! Rows are brought to the totals that were measured.

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

    /// How many times sixteen pairs of points are taken of cells with edges: few where there are many cells, so that a fit takes a minute.
    fn n_moved(self) -> usize {
        (4096 / self.n_incident()).clamp(2, MOVED.len())
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

/// Four incident points. With their partners each stratum of each of the four axes has one, and the first two are opposite each other, as
/// are the others: what is linear is averaged exactly.
pub(crate) const FOUR: [usize; 4] = [4, 11, 1, 14];

/// The exitant point that each incident one is paired with: the orthogonal array of sixteen runs and strength two (Rao 1947; Owen 1992 for
/// integrals), from the field of four elements: (a, b, a+2b, a+3b), with strata renumbered so that pairs lie opposite each other. Any two of
/// the four axes have each of their sixteen combinations once.
const PARTNERS: [usize; N_POINTS] = [0, 14, 11, 5, 7, 9, 12, 2, 13, 3, 6, 8, 10, 4, 1, 15];

/// The same array moved by these steps, which together are all pairs; the first few are spread evenly too.
const MOVED: [usize; N_POINTS] = [0, 10, 5, 15, 1, 11, 4, 14, 2, 8, 7, 13, 3, 9, 6, 12];

/// The exitant point that an incident one is paired with.
pub(crate) fn partner(point: usize) -> usize {
    PARTNERS[point]
}

/// Whether values that lie between two are as good as equal, in units of the mean or of the level.
fn is_smooth(low: f32, high: f32, mean: f32, level: f32, rough: f32) -> bool {
    high - low <= rough * mean.max(level)
}

/// The means of `f(exitant cell)(incident point, exitant point)` over an incident cell with each exitant one.
pub(crate) fn means<F: Fn(usize, usize) -> f32>(
    level: f32,
    cells: Cells,
    row: &mut [f32],
    f: impl Fn(usize) -> F,
) {
    let n = cells.n();
    let first = |(c, mean): (usize, &mut f32)| {
        let rough;
        (*mean, rough) = first_mean(level, f(c));
        rough
    };
    let rough: Vec<bool> = row.iter_mut().enumerate().map(first).collect();
    let first = row.to_vec();
    for (c, mean) in row.iter_mut().enumerate() {
        if rough[c] || beside_edge(&first, n, c, level) {
            *mean = fine_mean(level, cells, f(c));
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

/// The mean over a pair of cells that a few pairs of points are too few for.
fn fine_mean(level: f32, cells: Cells, f: impl Fn(usize, usize) -> f32) -> f32 {
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
    // The first of them are those sixteen.
    let n_moved = cells.n_moved();
    let more = MOVED[1..n_moved].iter().flat_map(|step| (0..N_POINTS).map(move |i| (i, partner(i) ^ step)));
    more.fold(sum, |sum, (i, o)| sum + f(i, o)) / (N_POINTS * n_moved) as f32
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

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    /// Strata of both points of a pair.
    fn strata(i: usize, o: usize) -> [usize; 4] {
        [i / STRATA, i % STRATA, o / STRATA, o % STRATA]
    }

    #[test]
    fn sixteen_pairs_have_all_combinations_of_any_two_axes() {
        for step in MOVED {
            for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
                let pairs = (0..N_POINTS).map(|i| strata(i, partner(i) ^ step));
                assert_eq!(pairs.map(|s| (s[a], s[b])).collect::<HashSet<_>>().len(), N_POINTS);
            }
        }
    }

    #[test]
    fn all_steps_together_are_all_pairs_and_four_are_opposite_each_other() {
        let all = MOVED.iter().flat_map(|step| (0..N_POINTS).map(move |i| (i, partner(i) ^ step)));
        assert_eq!(all.collect::<HashSet<_>>().len(), N_POINTS * N_POINTS);
        let [a, b, c, d] = FOUR.map(|i| strata(i, partner(i)));
        for axis in 0..4 {
            assert_eq!((a[axis] + b[axis], c[axis] + d[axis]), (STRATA - 1, STRATA - 1));
            assert_ne!(a[axis].min(b[axis]), c[axis].min(d[axis]));
        }
    }

    #[test]
    fn the_mean_of_a_lobe_needs_few_of_all_pairs() {
        // Around the mirror direction: a Gaussian of the difference of coordinates. Strata count from −1.5 to 1.5.
        let lobe = |i: usize, o: usize| {
            let at = |k: usize| strata(i, o)[k] as f32 - 1.5;
            let (x, y) = (at(0) - at(2) - 0.7, at(1) - at(3) + 0.4);
            (-0.2 * (x * x + 0.3 * x * y + y * y)).exp()
        };
        let all = (0..N_POINTS).flat_map(|i| (0..N_POINTS).map(move |o| lobe(i, o)));
        let exact = all.sum::<f32>() / (N_POINTS * N_POINTS) as f32;
        let sixteen = (0..N_POINTS).map(|i| lobe(i, partner(i))).sum::<f32>() / N_POINTS as f32;
        assert!((sixteen / exact - 1.0).abs() < 0.03, "{sixteen} {exact}");
    }
}
