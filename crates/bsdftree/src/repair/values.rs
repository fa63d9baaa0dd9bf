//! Values that were multiplied by something.

use crate::bsdf::{Band, Component, Part, Scattering};
use crate::check::{Factor, mean_cosine};
use crate::klems::Matrix;
use crate::tree::{Arena, Content, Rank, Slot, Tree, TreeBuilder, child_cell};

/// Functions of light: Y of trees, whose colour is a ratio; X, Y and Z of matrices.
pub(super) fn of_light(component: &Component, f: impl Fn(&Scattering) -> Scattering) -> Component {
    let chroma = component.chroma.as_ref().map(|[a, b]| match component.luminance {
        Scattering::Tree(_) => [a.clone(), b.clone()],
        Scattering::Matrix(_) => [f(a), f(b)],
    });
    Component { luminance: f(&component.luminance), chroma }
}

/// A tree of other values: `f` takes level, cell and value of a leaf.
pub(super) fn mapped_leaves(tree: &Tree, f: &dyn Fn(u32, [u32; 4], f64) -> f64) -> Tree {
    fn grow(
        arena: &Arena,
        slot: Slot,
        (level, cell): (u32, [u32; 4]),
        f: &dyn Fn(u32, [u32; 4], f64) -> f64,
        builder: &mut TreeBuilder,
    ) -> Slot {
        let node = match slot.content() {
            Content::Leaf(value) => return Slot::leaf(f(level, cell, f64::from(value)) as f32),
            Content::Node(node) => node,
        };
        let n = arena.rank().n_children();
        let mut children = [slot; 16];
        for (k, child) in children[..n].iter_mut().enumerate() {
            let below = (level + 1, child_cell(cell, k));
            *child = grow(arena, arena.child(node, k), below, f, builder);
        }
        builder.node(&children[..n]).expect("a tree of the same form")
    }
    let mut builder = TreeBuilder::new(tree.rank());
    let root = grow(tree.arena(), tree.arena().root(), (0, [0; 4]), f, &mut builder);
    Tree::new(builder.finish(root))
}

/// A matrix of other values: `f` takes incident and exitant patch and value.
pub(super) fn mapped_patches(matrix: &Matrix, f: impl Fn(usize, usize, f64) -> f64) -> Matrix {
    let n = matrix.exitant().n_patches();
    let values = matrix.values().iter().enumerate();
    let values = values.map(|(k, &v)| f(k / n, k % n, f64::from(v)) as f32).collect();
    Matrix::new(matrix.incident().clone(), matrix.exitant().clone(), values)
        .expect("as many finite values, not negative")
}

/// Everything in a band times a factor.
pub(super) fn scale(band: &mut Band, factor: f64) -> bool {
    for part in Part::ALL {
        let scaled = |function: &Scattering| match function {
            Scattering::Tree(tree) => mapped_leaves(tree, &|_, _, v| v * factor).into(),
            Scattering::Matrix(matrix) => mapped_patches(matrix, |_, _, v| v * factor).into(),
        };
        if let Some(component) = band.component(part).map(|component| of_light(component, scaled)) {
            band.insert(part, component);
        }
    }
    true
}

/// A component without a factor of the exitant direction.
pub(super) fn divided(component: &Component, factor: Factor) -> Component {
    of_light(component, |function| match function {
        Scattering::Tree(tree) => {
            let first = if tree.rank() == Rank::Four { 2 } else { 1 };
            let cosine = |level, cell: [u32; 4]| mean_cosine(level, [cell[first], cell[first + 1]]);
            mapped_leaves(tree, &|level, cell, value| value / cosine(level, cell)).into()
        }
        Scattering::Matrix(matrix) => {
            let basis = matrix.exitant();
            mapped_patches(matrix, |_, o, value| value / factor.of_patch(basis, o)).into()
        }
    })
}
