//! Light that goes the other way through an isotropic tree: drawn from a tree that is nearly the reversed one, and weighed.
//!
//! In: a rank-3 tree that stands in for the transmission of the other side. Out: directions and weights whose mean is exactly
//! that of the reversed tree. The library samples it exactly too, but has to collect all patches for every angle of
//! incidence anew, which costs more than a thousand paths. A grid of the reversed values, one for each cell of the tree's own
//! resolution, is a tree that is sampled at once; what it misses at the borders of cells is made up by the weight. A
//! small share of directions is drawn evenly, so that none is left out.

use std::f64::consts::{PI, TAU};

use bsdftree::square::disk_from_square;
use bsdftree::{Direction, Rank, Scattering, Side, Tree};

/// Finest grid: 2^6 cells along each axis.
const MOST_LOG2: u32 = 6;
/// The share of directions that are drawn evenly in projected solid angle.
const EVEN: f64 = 0.1;

/// A tree that is sampled for a reversed one.
#[derive(Clone, Debug)]
pub(super) struct Proposal(Scattering);

impl Proposal {
    /// For a rank-3 tree; `None` for everything else, which the library reverses at no cost.
    pub fn new(transmission: &Scattering) -> Option<Proposal> {
        let Scattering::Tree(tree) = transmission else { return None };
        if tree.rank() != Rank::Three {
            return None;
        }
        let log2 = tree.arena().log2_res().clamp(1, MOST_LOG2);
        let n = 1usize << log2;
        let middle = |k: usize| (k as f64 + 0.5) / n as f64;
        let mut values = vec![0.0; n * n * n];
        // Of the first coordinate, (1 − sin θ)/2, the upper half is never read.
        for (k, value) in values[..n * n * n / 2].iter_mut().enumerate() {
            let sin = 1.0 - 2.0 * middle(k / (n * n));
            let incident = Side::Front.direction_from_disk([-sin, 0.0]);
            let exitant =
                Side::Back.direction_from_disk(disk_from_square([middle(k / n % n), middle(k % n)]));
            *value = transmission.eval(incident, exitant, true) as f32;
        }
        Tree::from_grid(Rank::Three, &values).ok().map(|tree| Proposal(tree.into()))
    }

    /// About the fraction of light from `incident` that is transmitted, never 0.
    #[inline]
    pub fn share(&self, incident: Direction) -> f64 {
        self.0.hemispherical(incident, false) + 0.01
    }

    /// An exitant direction and what it weighs; `None` where there is no light. The mean of the weight over any solid angle is what
    /// the reversed tree transmits there.
    pub fn sample(
        &self,
        transmission: &Scattering,
        incident: Direction,
        [u, v]: [f64; 2],
    ) -> Option<(Direction, f64)> {
        let lobe = self.0.lobe(incident, false);
        let even = if lobe.total() > 0.0 { EVEN } else { 1.0 };
        let disk = if u < even {
            let (sin, cos) = (libm::sin(TAU * v), libm::cos(TAU * v));
            let radius = (u / even).sqrt();
            [radius * cos, radius * sin]
        } else {
            lobe.sample((u - even) / (1.0 - even), Some(v))?.0
        };
        let exitant = Side::of(incident).opposite().direction_from_disk(disk);
        let value = transmission.eval(incident, exitant, true);
        let proposed = self.0.eval(incident, exitant, false) / lobe.total().max(f64::MIN_POSITIVE);
        let density = (1.0 - even) * proposed + even / PI;
        (value > 0.0).then(|| (exitant, value / density))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::scatter::Scatter;
    use crate::scatter::test_support::{Cells, polar};
    use glam::DVec3;

    /// A tree with a peak that is finer than its surround.
    fn peaked() -> Scattering {
        let n = 32usize;
        let values: Vec<f32> = (0..n * n * n)
            .map(|k| {
                let [a, b, c] = [k / (n * n), k / n % n, k % n];
                // Straight on is where the second coordinate is 1 less the first.
                if a + b == n - 1 && c.abs_diff(n / 2) < 2 { 9.0 } else { 0.02 + 0.001 * (b % 5) as f32 }
            })
            .collect();
        Tree::from_grid(Rank::Three, &values).unwrap().into()
    }

    /// What leaves by each cell as the library samples it, with points so even that they have next to no error.
    fn by_the_library(tree: &Scattering, incident: Direction, cells: &Cells) -> Vec<f64> {
        let lobe = tree.lobe(incident, true);
        let n = 1 << 20;
        let mut sums = vec![0.0; cells.count()];
        for k in 0..n {
            let (u, v) = ((f64::from(k) + 0.5) / f64::from(n), (f64::from(k) * 0.618_033_988_75).fract());
            let (disk, _) = lobe.sample(u, Some(v)).unwrap();
            let direction = DVec3::from_array(Side::Back.direction_from_disk(disk));
            sums[cells.find(direction)] += lobe.total() / f64::from(n);
        }
        sums
    }

    #[test]
    fn means_are_those_of_the_reversed_tree() {
        let tree = peaked();
        let proposal = Proposal::new(&tree).unwrap();
        let cells = Cells { rings: 6, sectors: 12 };
        for theta in [3.0, 31.0, 66.0] {
            let incident = polar(theta, 40.0).to_array();
            let expected = by_the_library(&tree, incident, &cells);
            let mut random = Random::new(61, theta as u64, 0);
            let sample = || {
                let uv = [random.next_open(), random.next_open()];
                let (direction, weight) = proposal.sample(&tree, incident, uv)?;
                Some(Scatter::transmitted(DVec3::from_array(direction), weight))
            };
            let z = cells.compare(&expected, 400_000, sample, true);
            // 3 comparisons of 72 cells.
            assert!(z < 5.5, "{theta}: {z}");
        }
    }

    #[test]
    fn weights_hardly_vary() {
        let tree = peaked();
        let proposal = Proposal::new(&tree).unwrap();
        let incident = polar(33.0, 7.0).to_array();
        let mut random = Random::new(62, 0, 0);
        let weights: Vec<f64> = (0..20_000)
            .map(|_| {
                let uv = [random.next_open(), random.next_open()];
                proposal.sample(&tree, incident, uv).map_or(0.0, |(_, weight)| weight)
            })
            .collect();
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        let variance = weights.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / weights.len() as f64;
        assert!((mean - tree.hemispherical(incident, true)).abs() < 0.05 * mean);
        assert!(variance.sqrt() < 0.8 * mean, "{mean} ± {}", variance.sqrt());
    }

    #[test]
    fn only_isotropic_trees_need_one() {
        assert!(Proposal::new(&Tree::uniform(Rank::Four, 0.1).into()).is_none());
        let uniform: Scattering = Tree::uniform(Rank::Three, 0.1).into();
        let proposal = Proposal::new(&uniform).unwrap();
        assert!((proposal.share([0.0, 0.0, 1.0]) - 0.1 * PI).abs() < 0.011);
    }
}
