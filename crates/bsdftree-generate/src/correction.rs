//! A tree over a model, corrected by what full paths say beyond it.
//!
//! In: a tree of counted paths and model together, and the tree of the residual, which is coarse where paths agree with the model.
//! Out: one tree, whose mean over each leaf of the residual is that of the full paths. Within it, the residual is shared out in
//! proportion to the model, which keeps its detail.

use crate::errors::Uncertainty;
use crate::pyramid::Pyramid;
use crate::reduce::Kept;

/// A leaf of the residual on its way down.
#[derive(Clone, Copy)]
enum Share {
    /// So much of the model more.
    Factor(f64),
    /// So much more, where the model says 0.
    Constant(f64),
}

/// The tree, and its standard errors, with the residual added. All are trees of rank 4 over the same square.
pub(crate) fn corrected(
    kept: &Kept,
    errors: &Kept,
    residual: &Kept,
    of_residual: &Uncertainty,
    model: &Pyramid,
) -> [Kept; 2] {
    let block = Block { level: 0, incident: 0, exitant: 0 };
    let [value, error] =
        walked([kept, errors], Residual::Tree([residual, &of_residual.errors]), model, block);
    [value, error]
}

/// What is left to be added.
#[derive(Clone, Copy)]
enum Residual<'a> {
    /// A tree of values and one of their standard errors.
    Tree([&'a Kept; 2]),
    Shared([Share; 2]),
}

#[derive(Clone, Copy)]
struct Block {
    level: u32,
    incident: u32,
    exitant: u64,
}

impl Block {
    /// Child k of a node of rank 4: incident in the low bits.
    fn child(self, k: usize) -> Block {
        Block {
            level: self.level + 1,
            incident: self.incident << 2 | (k as u32 & 3),
            exitant: self.exitant << 2 | k as u64 >> 2,
        }
    }

    /// What the model says here.
    fn modelled(self, model: &Pyramid) -> f64 {
        let level = self.level.min(model.log2());
        let bits = 2 * (self.level - level);
        model.mean(level, self.incident >> bits, self.exitant >> bits)
    }
}

impl Share {
    fn of(value: f64, modelled: f64) -> Share {
        if modelled > 0.0 { Share::Factor(value / modelled) } else { Share::Constant(value) }
    }

    fn here(self, modelled: f64) -> f64 {
        match self {
            Share::Factor(factor) => factor * modelled,
            Share::Constant(value) => value,
        }
    }
}

fn walked(trees: [&Kept; 2], residual: Residual<'_>, model: &Pyramid, block: Block) -> [Kept; 2] {
    let residual = match residual {
        Residual::Tree([Kept::Leaf { value, .. }, Kept::Leaf { value: error, .. }]) => {
            let modelled = block.modelled(model);
            Residual::Shared([Share::of(*value, modelled), Share::of(*error, modelled)])
        }
        other => other,
    };
    match (trees, residual) {
        ([Kept::Leaf { value, xyz }, Kept::Leaf { value: error, .. }], Residual::Shared([more, noise])) => {
            let modelled = block.modelled(model);
            let corrected = (value + more.here(modelled)).max(0.0);
            let factor = if *value > 0.0 { (corrected / value) as f32 } else { 1.0 };
            [
                Kept::Leaf { value: corrected, xyz: xyz.map(|c| c * factor) },
                Kept::Leaf { value: error.hypot(noise.here(modelled)), xyz: [0.0; 3] },
            ]
        }
        (trees, residual) => {
            let child = |k: usize| {
                let trees = trees.map(|tree| child_of(tree, k));
                let residual = match residual {
                    Residual::Tree(trees) => Residual::Tree(trees.map(|tree| child_of(tree, k))),
                    shared => shared,
                };
                walked(trees, residual, model, block.child(k))
            };
            let (values, errors) = (0..16).map(child).map(|[value, error]| (value, error)).unzip();
            [Kept::Node(values), Kept::Node(errors)]
        }
    }
}

/// A child of a node; of a leaf, itself, since it is the same all over.
fn child_of(tree: &Kept, k: usize) -> &Kept {
    match tree {
        Kept::Node(children) => &children[k],
        leaf => leaf,
    }
}
