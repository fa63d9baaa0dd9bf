//! Trees to measure with, made here so that everyone has the same.

use bsdftree::tree::{Slot, TreeBuilder};
use bsdftree::{Rank, Tree};

/// How a BSDF is to be divided: a cube becomes a leaf if its values differ by less than this part of their mean.
pub struct Shape {
    pub rank: Rank,
    pub log2_res: u32,
    pub tolerance: f64,
}

/// A diffuse background that changes slowly, a broad lobe and a peak, both along the diagonal, where mirrors have theirs.
fn value(c: [f64; 4], rank: Rank) -> f64 {
    let (along, across) = match rank {
        Rank::Three => (1.0 - c[0] - c[1], 0.5 - c[2]),
        Rank::Four => (c[0] - c[2], c[1] - c[3]),
    };
    let r2 = along * along + across * across;
    0.1 + 0.05 * (3.17 * c[0] + 2.23 * c[1] - 4.57 * c[2] + 1.41 * c[3]).sin()
        + 0.8 * (-12.0 * r2).exp()
        + 40.0 * (-900.0 * r2).exp()
}

/// The tree of that function.
pub fn smooth(shape: &Shape) -> Tree {
    let mut builder = TreeBuilder::new(shape.rank);
    let (root, ..) = grow(shape, 0, [0; 4], &mut builder);
    Tree::new(builder.finish(root))
}

/// The subtree of a cell, the smallest and the largest value in it, and the mean.
fn grow(shape: &Shape, level: u32, corner: [u32; 4], builder: &mut TreeBuilder) -> (Slot, [f64; 2], f64) {
    if level == shape.log2_res {
        let edge = 0.5f64.powi(level as i32);
        let v = value(corner.map(|k| (f64::from(k) + 0.5) * edge), shape.rank);
        return (Slot::leaf(v as f32), [v, v], v);
    }
    let n = shape.rank.n_children();
    let (mut children, mut range, mut sum) = ([Slot::leaf(0.0); 16], [f64::INFINITY, 0.0f64], 0.0);
    for (k, child) in children[..n].iter_mut().enumerate() {
        let below = std::array::from_fn(|i| corner[i] << 1 | (k as u32 >> i & 1));
        let (slot, [low, high], mean) = grow(shape, level + 1, below, builder);
        (*child, range, sum) = (slot, [range[0].min(low), range[1].max(high)], sum + mean);
    }
    let mean = sum / n as f64;
    if range[1] - range[0] < shape.tolerance * mean {
        return (Slot::leaf(mean as f32), range, mean);
    }
    (builder.node(&children[..n]).expect("it is not too deep"), range, mean)
}
