//! Trees from the leaves up, with branches joined where that costs less than a tolerance.
//!
//! Invariant: the relative L1 error of all that is joined, ∫|f − mean|/∫f, is at most the tolerance; the mean over every branch stays
//! what it is. A branch becomes a leaf where its own error is at most half the tolerance of its own light or of the mean
//! branch's, whichever is more. With tolerance 0, equal values are joined only.

use crate::tree::{Content, Rank, Slot, Tree, TreeBuilder, TreeError};

/// What has been built of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Branch {
    slot: Slot,
    /// Mean value.
    mean: f64,
    /// Mean of |f − leaf| over the cell.
    error: f64,
    /// How much of its parent it is, beside the other children: all alike at rank 4, by the ring of incident directions at rank 3.
    weight: f64,
}

impl Branch {
    /// Mean value over the cell.
    pub fn mean(&self) -> f64 {
        self.mean
    }
}

/// Squared sines of the incident polar angles of a layer of cells of a rank-3 tree: the inner and the outer border of a ring, both
/// 0 if it is never read. The shift of 10⁻⁶ that puts normal incidence into the read half is left out.
pub(crate) fn squared_radii(level: u32, layer: u32) -> [f64; 2] {
    let edge = 0.5f64.powi(level as i32);
    let d0 = f64::from(layer) * edge;
    [d0 + edge, d0].map(|d0| (1.0 - 2.0 * d0).max(0.0).powi(2))
}

/// Builds a tree.
pub(super) struct Grower {
    builder: TreeBuilder,
    rank: Rank,
    half_tolerance: f64,
    /// Mean of the whole function.
    mean: f64,
}

impl Grower {
    pub fn new(rank: Rank, tolerance: f64, mean: f64) -> Grower {
        Grower { builder: TreeBuilder::new(rank), rank, half_tolerance: 0.5 * tolerance, mean }
    }

    /// One value over a cell of this level, whose first coordinate is `layer`.
    pub fn leaf(&self, value: f64, level: u32, layer: u32) -> Branch {
        let weight = match self.rank {
            Rank::Four => 1.0,
            Rank::Three => {
                let [inner, outer] = squared_radii(level, layer);
                outer - inner
            }
        };
        let value = value.max(0.0);
        Branch { slot: Slot::leaf(value as f32), mean: value, error: 0.0, weight }
    }

    /// The half of a rank-3 tree that is never read.
    pub fn unread(&self) -> Branch {
        Branch { slot: Slot::leaf(0.0), mean: 0.0, error: 0.0, weight: 0.0 }
    }

    /// Whether a cell of this mean may be one leaf, if that puts it wrong by `error` on average.
    pub fn allows(&self, mean: f64, error: f64) -> bool {
        error <= self.half_tolerance * mean.max(self.mean)
    }

    /// The weight of a cell from the sum of its children's: at rank 3, four of them are of one ring.
    fn parent_weight(&self, sum: f64) -> f64 {
        match self.rank {
            Rank::Three => sum / 4.0,
            Rank::Four => sum / 16.0,
        }
    }

    /// A leaf that is the mean of 2^rank children. What it loses of them is not counted as an error of joining.
    pub fn blend(&self, children: &[Branch]) -> Branch {
        let weight: f64 = children.iter().map(|c| c.weight).sum();
        let mean = children.iter().map(|c| c.weight * c.mean).sum::<f64>() / weight.max(f64::MIN_POSITIVE);
        Branch { slot: Slot::leaf(mean as f32), mean, error: 0.0, weight: self.parent_weight(weight) }
    }

    /// A cell from its 2^rank children.
    pub fn join(&mut self, children: &[Branch]) -> Result<Branch, TreeError> {
        let weight: f64 = children.iter().map(|c| c.weight).sum();
        let average = |of: &dyn Fn(&Branch) -> f64| match weight > 0.0 {
            true => children.iter().map(|c| c.weight * of(c)).sum::<f64>() / weight,
            false => 0.0,
        };
        let above = self.parent_weight(weight);
        let joined = |slot, mean, error| Branch { slot, mean, error, weight: above };
        let (mean, error) = (average(&|c| c.mean), average(&|c| c.error));
        if children.iter().all(|c| matches!(c.slot.content(), Content::Leaf(_))) {
            if children.iter().all(|c| c.slot == children[0].slot) {
                return Ok(joined(children[0].slot, mean, error));
            }
            let error = error + average(&|c| (c.mean - mean).abs());
            if self.half_tolerance > 0.0 && self.allows(mean, error) {
                return Ok(joined(Slot::leaf(mean as f32), mean, error));
            }
        }
        let mut slots = [children[0].slot; 16];
        slots.iter_mut().zip(children).for_each(|(slot, child)| *slot = child.slot);
        Ok(joined(self.builder.node(&slots[..self.rank.n_children()])?, mean, error))
    }

    /// The tree of its root.
    pub fn finish(self, root: Branch) -> Tree {
        Tree::new(self.builder.finish(root.slot))
    }
}
