//! Trees of grids whose values are known with an error: a branch is kept only where its children differ by more than noise explains.
//!
//! In: values, and the variance of each or the number of samples that made it. Out: a tree each of whose leaves is the mean of its cells,
//! so that the light over every leaf is kept.
//!
//! The children of a block, with means m_k of variances V_k and parts w_k of the block, spread by Q = Σ w_k (m_k − m)². Were they alike, Q
//! would be distributed as g·χ² of ν degrees of freedom, g and ν being those that give Q its mean and its variance
//! (F. E. Satterthwaite, "An approximate distribution of estimates of variance components", Biometrics Bulletin 2, 1946; ν is 15 for
//! blocks of rank 4 whose noise is even). T is what such a number exceeds with the probability α/n, n being the number of blocks, and
//! the cheapest tree is that of the greatest gain, found from the leaves up: G = max(0, Q − T + Σ G_k). So a constant and nothing but noise
//! becomes one leaf with the probability 1 − α at least.
//!
//! Of counts, V_k is that of a Poisson distribution with the mean of the whole block. Its tail is longer than a normal one's where
//! counts c of a block are few: T is 1 + 2.4/√c times as large, which covers the tails of multinomial distributions over 16 cells down to
//! single counts.

use super::source::{Nodes, Weights};
use super::{Goal, Loss, ReduceError, Reduction};
use crate::tree::grid::log2_of;
use crate::tree::{Rank, Slot, Tree, TreeBuilder};

/// Largest probability α that a constant with noise has more than one leaf.
pub const SIGNIFICANCE: f64 = 0.01;

/// How well the values of a grid are known: a number for each.
#[derive(Clone, Copy, Debug)]
pub enum Noise<'a> {
    /// Square of the standard error \[1/sr²\].
    Variance(&'a [f32]),
    /// How many samples of about equal weight, such as paths or photons, made the value.
    Counts(&'a [f32]),
}

impl Noise<'_> {
    fn validated(&self, n_values: usize) -> Result<(), ReduceError> {
        let (name, numbers) = match self {
            Noise::Variance(numbers) => ("variances", numbers),
            Noise::Counts(numbers) => ("counts", numbers),
        };
        if numbers.len() != n_values {
            return Err(ReduceError::Noise(format!("{} {name} of {n_values} values", numbers.len())));
        }
        match numbers.iter().position(|n| !(*n >= 0.0 && n.is_finite())) {
            None => Ok(()),
            Some(index) => Err(ReduceError::Noise(format!(
                "{} among the {name} at index {index} of the flat grid",
                numbers[index]
            ))),
        }
    }
}

impl Tree {
    /// A tree of a grid that keeps what differs by more than noise, and if the goal says anything, reduced to that; what was lost by that
    /// last step.
    ///
    /// # Errors
    /// As [`Tree::from_grid`] and [`Tree::reduced`], or if there is not a number ≥ 0 for each value.
    pub fn from_noisy_grid(
        rank: Rank,
        values: &[f32],
        noise: Noise<'_>,
        goal: &Goal,
    ) -> Result<(Tree, Loss), ReduceError> {
        let log2 = log2_of(rank, values)?;
        noise.validated(values.len())?;
        let n_blocks: usize = (0..log2).map(|level| 1usize << (rank.dimensions() as u32 * level)).sum();
        let mut blocks = Blocks {
            d: rank.dimensions(),
            log2,
            values,
            noise,
            weights: Weights::new(rank, log2),
            z: normal_quantile(SIGNIFICANCE / n_blocks.max(1) as f64),
            builder: TreeBuilder::new(rank),
        };
        let root = blocks.block(0, [0; 4]).slot;
        let tree = Tree::new(blocks.builder.finish(root));
        if goal.is_empty() {
            return Ok((tree, Loss::default()));
        }
        let goal = goal.validated()?;
        let arena = tree.arena().in_level_order();
        Reduction::new(Nodes::new(&arena), goal.norm()).best(&goal)
    }
}

/// What is known of a block.
#[derive(Clone, Copy)]
struct Block {
    slot: Slot,
    mean: f64,
    /// Of the mean.
    variance: f64,
    counts: f64,
    /// What is gained by keeping it a node; 0 if it is a leaf.
    gain: f64,
}

struct Blocks<'a> {
    d: usize,
    log2: u32,
    values: &'a [f32],
    noise: Noise<'a>,
    weights: Weights,
    /// Of T.
    z: f64,
    builder: TreeBuilder,
}

impl Blocks<'_> {
    /// The cell at these coordinates of a level.
    fn block(&mut self, level: u32, cell: [usize; 4]) -> Block {
        if level == self.log2 {
            return self.cell(cell);
        }
        let n_nodes = self.builder.n_nodes();
        let (n, mut blocks) = (1 << self.d, [None; 16]);
        let mut weights = [0.0; 16];
        for k in 0..n {
            let below = std::array::from_fn(|i| cell[i] << 1 | (k >> i & 1));
            blocks[k] = Some(self.block(level + 1, below));
            weights[k] = self.weights.of(level + 1, below[0] as u32);
        }
        let blocks = blocks.map(|block| block.unwrap_or(Block::NONE));
        let blocks = &blocks[..n];
        // Where nobody reads, there is a mean all the same.
        let is_read = weights.iter().sum::<f64>() > 0.0;
        let weights = if is_read { weights } else { [1.0; 16] };
        let spread = Spread::of(blocks, &weights[..n], matches!(self.noise, Noise::Counts(_)));
        let gain = spread.excess(self.z) + blocks.iter().map(|block| block.gain).sum::<f64>();
        let (mut slot, mut kept) = (Slot::leaf(spread.mean as f32), 0.0);
        if is_read && gain > 0.0 {
            let children: Vec<Slot> = blocks.iter().map(|block| block.slot).collect();
            (slot, kept) = (self.builder.node(&children).expect("a grid is no larger than a tree"), gain);
        } else {
            self.builder.truncate(n_nodes);
        }
        let Spread { mean, variance, counts, .. } = spread;
        Block { slot, mean, variance, counts, gain: kept }
    }

    fn cell(&self, cell: [usize; 4]) -> Block {
        let index = cell[..self.d].iter().fold(0, |index, &c| (index << self.log2) | c);
        let value = self.values[index];
        let (variance, counts) = match self.noise {
            Noise::Variance(variances) => (f64::from(variances[index]), 0.0),
            Noise::Counts(counts) => (0.0, f64::from(counts[index])),
        };
        Block { slot: Slot::leaf(value), mean: f64::from(value), variance, counts, gain: 0.0 }
    }
}

impl Block {
    const NONE: Block = Block { slot: Slot::BLACK, mean: 0.0, variance: 0.0, counts: 0.0, gain: 0.0 };
}

/// How blocks that make up one differ.
struct Spread {
    mean: f64,
    /// Of the mean.
    variance: f64,
    counts: f64,
    /// Q.
    spread: f64,
    /// Mean of Q if the blocks are alike, and half its variance.
    expected: [f64; 2],
    /// By how much its tail is longer than that of a χ² distribution.
    tail: f64,
}

impl Spread {
    fn of(blocks: &[Block], weights: &[f64], has_counts: bool) -> Spread {
        let pairs = || blocks.iter().zip(weights);
        let all: f64 = weights.iter().sum();
        let mean = pairs().map(|(block, w)| w * block.mean).sum::<f64>() / all;
        let counts: f64 = blocks.iter().map(|block| block.counts).sum();
        let variance_of = |block: &Block, w: f64| match has_counts {
            false => block.variance,
            true if counts > 0.0 && w > 0.0 => mean * mean * all / (counts * w),
            true => 0.0,
        };
        let (mut variance, mut spread, mut first, mut second, mut cross) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (block, &w) in pairs() {
            let (v, part) = (variance_of(block, w), w / all);
            variance += part * part * v;
            spread += w * (block.mean - mean).powi(2);
            first += w * v * (1.0 - part);
            second += (w * v).powi(2) * (1.0 - 2.0 * part);
            cross += w * v * part;
        }
        let tail = if has_counts && counts > 0.0 { 1.0 + 2.4 / counts.sqrt() } else { 1.0 };
        Spread { mean, variance, counts, spread, expected: [first, second + cross * cross], tail }
    }

    /// Q − T.
    fn excess(&self, z: f64) -> f64 {
        let [mean, half_variance] = self.expected;
        if mean <= 0.0 || half_variance <= 0.0 {
            return self.spread;
        }
        let (scale, freedom) = (half_variance / mean, mean * mean / half_variance);
        self.spread - self.tail * scale * chi2_quantile(freedom, z)
    }
}

/// What a χ² number exceeds with the probability with which a normal one exceeds z (E. B. Wilson and M. M. Hilferty, "The distribution of
/// chi-square", Proceedings of the National Academy of Sciences 17, 1931); far out, a little more.
fn chi2_quantile(freedom: f64, z: f64) -> f64 {
    let a = 2.0 / (9.0 * freedom);
    freedom * (1.0 - a + z * a.sqrt()).powi(3)
}

/// What a normal number exceeds with a probability of at most ½ (M. Abramowitz and I. A. Stegun, "Handbook of Mathematical Functions",
/// 1964, 26.2.23), to 4.5·10⁻⁴.
fn normal_quantile(p: f64) -> f64 {
    let t = (-2.0 * p.ln()).sqrt();
    t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_tables() {
        for (p, z) in [(0.01, 2.3263), (1e-4, 3.7190), (1e-8, 5.6120)] {
            assert!((normal_quantile(p) - z).abs() < 1e-3);
        }
        // At 10⁻², 10⁻⁴ and 10⁻⁸, from the incomplete gamma function.
        for (freedom, at) in [
            (15.0, [30.578, 44.263, 68.029]),
            (7.0, [18.475, 29.878, 50.813]),
            (1.5, [8.009, 16.894, 34.977]),
        ] {
            for (p, x) in [1e-2, 1e-4, 1e-8].into_iter().zip(at) {
                let ratio = chi2_quantile(freedom, normal_quantile(p)) / x;
                assert!((0.99..1.18).contains(&ratio), "{freedom} {p}: {ratio}");
            }
        }
    }
}
