//! A tree over a model, corrected by what full paths say beyond it.
//!
//! In: a tree of counted paths and model together, and the tree of the residual, which is coarse where paths agree with the model.
//! Out: one tree, whose mean over each leaf of the residual is that of the full paths. Within it, the residual is shared out in
//! proportion to the model, which keeps its detail.

use crate::errors::{STUDENT_95, Uncertainty};
use crate::pyramid::Pyramid;
use crate::reduce::{Kept, Reducer, Region};
use crate::scatter::Flux;

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

/// Light that the residual adds to each incident cell's total, and the standard error of that, shared out as [`corrected`] does.
/// What cannot be told from noise is left out: totals are known better than the few full paths tell.
pub(crate) fn of_totals<S: Flux>(
    reducer: &Reducer<'_, S>,
    residual: &Kept,
    of_residual: &Uncertainty,
) -> [Vec<f64>; 2] {
    let nothing = vec![0.0; reducer.rows.len()];
    let mut sums = [nothing.clone(), nothing];
    add_to_totals(reducer, [residual, &of_residual.errors], reducer.root().0, &mut sums);
    let [values, squares] = sums;
    [values, squares.into_iter().map(f64::sqrt).collect()]
}

fn add_to_totals<S: Flux>(
    reducer: &Reducer<'_, S>,
    trees: [&Kept; 2],
    region: Region,
    sums: &mut [Vec<f64>; 2],
) {
    if let [Kept::Leaf { value, .. }, Kept::Leaf { value: error, .. }] = trees {
        if value.abs() <= STUDENT_95 * error {
            return;
        }
        let modelled = reducer.modelled(&region).value;
        let shares = [*value, *error].map(|v| Share::of(v, modelled));
        let area = reducer.omega * region.n_exit as f64;
        for row in region.rows() {
            let mean = reducer.modelled_sum(row as u32, &region) / area;
            let [more, noise] = shares.map(|share| share.here(mean) * area);
            sums[0][row] += more;
            sums[1][row] += noise * noise;
        }
        return;
    }
    for (k, part) in reducer.regions(region).enumerate() {
        add_to_totals(reducer, trees.map(|tree| child_of(tree, k)), part, sums);
    }
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
        (
            [Kept::Leaf { value, xyz, .. }, Kept::Leaf { value: error, .. }],
            Residual::Shared([more, noise]),
        ) => {
            let modelled = block.modelled(model);
            let corrected = (value + more.here(modelled)).max(0.0);
            let factor = if *value > 0.0 { (corrected / value) as f32 } else { 1.0 };
            [
                Kept::Leaf { value: corrected, xyz: xyz.map(|c| c * factor), split: None },
                Kept::Leaf { value: error.hypot(noise.here(modelled)), xyz: [0.0; 3], split: None },
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
