//! Random trees and statistics for the tests. Every test uses a fixed seed.
#![allow(dead_code, reason = "each test binary uses its own part")]

use bsdftree::tree::{Slot, TreeBuilder};
use bsdftree::{Direction, Rank, Tree};

/// SplitMix64: reproducible numbers that are good enough to test with.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in projected solid angle, on the front.
    pub fn direction(&mut self) -> Direction {
        let [x, y] = bsdftree::square::disk_from_square([self.unit(), self.unit()]);
        bsdftree::Side::Front.direction_from_disk([x, y])
    }
}

/// A tree of random shape with values from 0 (a quarter of them) to peaks, at most `depth` deep.
pub fn random_tree(rank: Rank, depth: u32, random: &mut Random) -> Tree {
    fn grow(rank: Rank, depth: u32, builder: &mut TreeBuilder, random: &mut Random) -> Slot {
        if depth == 0 || random.unit() < 0.35 {
            let u = random.unit();
            return Slot::leaf(if u < 0.25 { 0.0 } else { (0.02 / (1.01 - u)) as f32 });
        }
        let children: Vec<_> =
            (0..rank.n_children()).map(|_| grow(rank, depth - 1, builder, random)).collect();
        builder.node(&children).unwrap()
    }
    let mut builder = TreeBuilder::new(rank);
    let children: Vec<_> =
        (0..rank.n_children()).map(|_| grow(rank, depth - 1, &mut builder, random)).collect();
    let root = builder.node(&children).unwrap();
    Tree::new(builder.finish(root))
}

/// Whether counts fit expected ones by Pearson's χ² at significance 1e-4. Bins expected to hold under 5 are pooled; a count
/// where none is expected fails.
pub fn fits(counts: &[u64], expected: &[f64]) -> Result<(), String> {
    let (mut chi2, mut degrees) = (0.0, 0.0);
    let mut pool = (0.0, 0.0);
    let mut add = |count: f64, expected: f64| {
        chi2 += (count - expected).powi(2) / expected;
        degrees += 1.0;
    };
    for (&count, &expected) in counts.iter().zip(expected) {
        if expected == 0.0 && count > 0 {
            return Err(format!("{count} where none is expected"));
        }
        if expected >= 5.0 {
            add(count as f64, expected);
        } else {
            pool = (pool.0 + count as f64, pool.1 + expected);
        }
    }
    if pool.1 >= 5.0 {
        add(pool.0, pool.1);
    }
    // Wilson and Hilferty's normal approximation of the quantile; 3.719 is the normal quantile of 1 − 1e-4.
    let k: f64 = degrees - 1.0;
    let limit = k * (1.0 - 2.0 / (9.0 * k) + 3.719 * (2.0 / (9.0 * k)).sqrt()).powi(3);
    if chi2 <= limit {
        Ok(())
    } else {
        Err(format!("χ² {chi2:.1} over {limit:.1} at {k} degrees of freedom"))
    }
}
