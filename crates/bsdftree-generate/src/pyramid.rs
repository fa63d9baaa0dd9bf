//! A dense model of a BSDF at every level of a tree: its mean in each block, and the variance of that.
//!
//! In: two independent estimates for all pairs of a 2^log2 grid, cells in Morton order. Half their difference is normal with the
//! variance of their mean; blocks of half differences give the variance of blocks, correlations included. A single square says
//! little, so that those of 16 siblings are taken together.

use rayon::prelude::*;

/// Blocks of one level: 4^level × 4^level of them, incident block by incident block.
struct Level {
    mean: Vec<f32>,
    variance: Vec<f32>,
    /// Mean squares of the finest cells; none at the finest level.
    square: Vec<f32>,
}

/// The model of one component.
pub(crate) struct Pyramid {
    levels: Vec<Level>,
    /// For each level of exitant blocks, their means for each single incident cell.
    rows: Vec<Vec<f32>>,
    /// Of the mean over all exitant cells, for each finest incident cell.
    row_variance: Vec<f32>,
    /// Means of the channels that luminance is made of, by level.
    channels: Vec<Vec<Vec<f32>>>,
    /// Of each channel, the luminance of one.
    luminances: Vec<f64>,
}

impl Pyramid {
    /// From the two estimates of each channel, with the luminance that a channel's 1 has.
    pub fn new(log2: u32, estimates: Vec<[Vec<f32>; 2]>, luminances: Vec<f64>) -> Pyramid {
        let n = 1usize << (2 * log2);
        let mut mean = vec![0.0f32; n * n];
        let mut half = vec![0.0f32; n * n];
        let mut channels = Vec::new();
        for ([a, b], luminance) in estimates.into_iter().zip(&luminances) {
            let y = *luminance as f32;
            mean.par_iter_mut().zip(&a).zip(&b).for_each(|((m, a), b)| *m += 0.5 * y * (a + b));
            half.par_iter_mut().zip(&a).zip(&b).for_each(|((h, a), b)| *h += 0.5 * y * (a - b));
            if luminances.len() > 1 {
                channels.push(a.into_iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect::<Vec<_>>());
            }
        }
        let mut rows = vec![mean.clone()];
        for level in (0..log2).rev() {
            rows.push(pooled_exits(rows.last().expect("the finest"), 1 << (2 * level)));
        }
        rows.reverse();
        let row_variance = row_variances(&half, n);
        let squares = coarser(mean.par_iter().map(|m| m * m).collect(), log2);
        let means = coarser(mean, log2);
        let channels = channels.into_iter().map(|channel| coarser(channel, log2)).collect();
        let halves = coarser(half, log2).into_iter().enumerate();
        let mut levels: Vec<_> = halves
            .zip(means)
            .zip(squares)
            .map(|(((level, half), mean), square)| Level {
                variance: among_siblings(level, &half, &mean),
                mean,
                square,
            })
            .collect();
        levels[log2 as usize].square = Vec::new();
        Pyramid { levels, rows, row_variance, channels, luminances }
    }

    /// Level of the finest blocks.
    pub fn log2(&self) -> u32 {
        self.levels.len() as u32 - 1
    }

    /// Finest incident cells.
    pub fn n_cells(&self) -> usize {
        1 << (2 * self.log2())
    }

    /// Mean over a block.
    pub fn mean(&self, level: u32, incident: u32, exitant: u64) -> f64 {
        f64::from(self.levels[level as usize].mean[index(level, incident, exitant)])
    }

    /// Mean over a block of the squares of its finest cells.
    pub fn mean_square(&self, level: u32, incident: u32, exitant: u64) -> f64 {
        match level == self.log2() {
            true => self.mean(level, incident, exitant).powi(2),
            false => f64::from(self.levels[level as usize].square[index(level, incident, exitant)]),
        }
    }

    /// Variance of the mean over a block.
    pub fn variance(&self, level: u32, incident: u32, exitant: u64) -> f64 {
        f64::from(self.levels[level as usize].variance[index(level, incident, exitant)])
    }

    /// Mean over an exitant block for one finest incident cell.
    pub fn row(&self, level: u32, incident: u32, exitant: u64) -> f64 {
        f64::from(self.rows[level as usize][index(level, incident, exitant)])
    }

    /// Variance of the mean over all exitant cells for one finest incident cell.
    pub fn row_variance(&self, incident: u32) -> f64 {
        f64::from(self.row_variance[incident as usize])
    }

    /// Mean of each channel over a block.
    pub fn channels(&self, level: u32, incident: u32, exitant: u64) -> impl Iterator<Item = f64> {
        let at = index(level, incident, exitant);
        let one = self.luminances.len() == 1;
        let mean = &self.levels[level as usize].mean;
        let single = one.then(|| f64::from(mean[at]) / self.luminances[0]);
        single.into_iter().chain(self.channels.iter().map(move |c| f64::from(c[level as usize][at])))
    }
}

fn index(level: u32, incident: u32, exitant: u64) -> usize {
    ((incident as usize) << (2 * level)) + exitant as usize
}

/// A grid of the finest level, and its means over blocks at all levels from the coarsest on.
fn coarser(finest: Vec<f32>, log2: u32) -> Vec<Vec<f32>> {
    let mut levels = vec![finest];
    for level in (0..log2).rev() {
        let n = 1usize << (2 * level);
        let fine = levels.last().expect("the finest");
        let mut mean = vec![0.0; n * n];
        mean.par_chunks_mut(n).zip(fine.par_chunks(16 * n)).for_each(|(out, rows)| {
            for (o, out) in out.iter_mut().enumerate() {
                let row = |i: usize| -> f32 { rows[i * 4 * n + 4 * o..][..4].iter().sum() };
                *out = (0..4).map(row).sum::<f32>() / 16.0;
            }
        });
        levels.push(mean);
    }
    levels.reverse();
    levels
}

/// Means over fours of exitant cells, of which `n` come.
fn pooled_exits(fine: &[f32], n: usize) -> Vec<f32> {
    let mut mean = vec![0.0; fine.len() / 4];
    mean.par_chunks_mut(n).zip(fine.par_chunks(4 * n)).for_each(|(out, row)| {
        out.iter_mut().zip(row.chunks_exact(4)).for_each(|(out, four)| *out = four.iter().sum::<f32>() / 4.0);
    });
    mean
}

/// Squares of rows' means, averaged over fours of neighbouring rows.
fn row_variances(half: &[f32], n: usize) -> Vec<f32> {
    let squares: Vec<f32> =
        half.par_chunks(n).map(|row| (row.iter().sum::<f32>() / n as f32).powi(2)).collect();
    squares.chunks(4).flat_map(|four| [four.iter().sum::<f32>() / 4.0; 4]).collect()
}

/// Variances of blocks: squares of half differences summed over the 16 blocks of one parent, and shared out in proportion to the
/// blocks' means, as counts would be.
fn among_siblings(level: usize, half: &[f32], mean: &[f32]) -> Vec<f32> {
    if level == 0 {
        return vec![half[0] * half[0]];
    }
    let n = 1usize << (2 * level);
    let mut variance = vec![0.0; half.len()];
    let rows = half.par_chunks(4 * n).zip(mean.par_chunks(4 * n));
    variance.par_chunks_mut(4 * n).zip(rows).for_each(|(out, (half, mean))| {
        for first in (0..n).step_by(4) {
            let cells = (0..4).flat_map(|i| (0..4).map(move |o| i * n + first + o));
            let squares: f32 = cells.clone().map(|k| half[k] * half[k]).sum();
            let total: f32 = cells.clone().map(|k| mean[k]).sum();
            if total > 0.0 {
                cells.for_each(|k| out[k] = squares * (mean[k] / total));
            }
        }
    });
    variance
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 4 × 4 … cells, distinct values.
    fn pyramid() -> (Vec<f32>, Pyramid) {
        let n = 1usize << 4;
        let a: Vec<f32> = (0..n * n).map(|k| (k * k % 97) as f32).collect();
        let b: Vec<f32> = a.iter().map(|v| v + 2.0).collect();
        (a.clone(), Pyramid::new(2, vec![[a, b]], vec![1.0]))
    }

    #[test]
    fn blocks_are_means_of_their_cells() {
        let (a, pyramid) = pyramid();
        let mean = |rows: std::ops::Range<usize>, exits: std::ops::Range<usize>| {
            let n = (rows.len() * exits.len()) as f64;
            rows.flat_map(|i| exits.clone().map(move |o| i * 16 + o))
                .map(|k| f64::from(a[k]) + 1.0)
                .sum::<f64>()
                / n
        };
        assert_eq!(pyramid.log2(), 2);
        let near = |x: f64, y: f64| assert!((x - y).abs() < 1e-4, "{x} {y}");
        near(pyramid.mean(0, 0, 0), mean(0..16, 0..16));
        near(pyramid.mean(1, 2, 3), mean(8..12, 12..16));
        near(pyramid.mean(2, 5, 9), mean(5..6, 9..10));
        let cells = (8..12).flat_map(|i| (12..16).map(move |o| i * 16 + o));
        let square = cells.map(|k| f64::from(a[k] + 1.0).powi(2));
        near(pyramid.mean_square(1, 2, 3) / (square.sum::<f64>() / 16.0), 1.0);
        near(pyramid.mean_square(2, 5, 9), mean(5..6, 9..10).powi(2));
        near(pyramid.row(0, 7, 0), mean(7..8, 0..16));
        near(pyramid.row(1, 7, 2), mean(7..8, 8..12));
        near(pyramid.channels(1, 2, 3).next().unwrap(), mean(8..12, 12..16));
    }

    #[test]
    fn a_common_error_does_not_average_out() {
        let (_, pyramid) = pyramid();
        for level in 1..3 {
            let siblings = (0..4).flat_map(|i| (0..4).map(move |o| (i, o)));
            let mean = siblings.map(|(i, o)| pyramid.variance(level, i, o)).sum::<f64>() / 16.0;
            assert!((mean - 1.0).abs() < 1e-5, "{level}: {mean}");
        }
        assert_eq!(pyramid.variance(0, 0, 0), 1.0);
        assert_eq!(pyramid.row_variance(5), 1.0);
    }
}
