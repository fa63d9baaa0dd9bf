//! Colour as three functions of one kind, so that whatever is done to light is done to each.
//!
//! Trees carry Y with u′ and v′, which must not be averaged: they become trees of X, Y and Z on the common subdivision, and come back
//! from them. Matrices carry X, Y, Z themselves.

use crate::bsdf::{Component, Scattering};
use crate::color::{uv_from_xyz, xyz_from_yuv};
use crate::tree::{Content, Slot, Tree, TreeBuilder, TreeError};

/// A component with every function of light replaced: Y alone, or X, Y and Z.
pub(super) fn mapped<E: From<TreeError>>(
    component: &Component,
    mut f: impl FnMut(&Scattering) -> Result<Scattering, E>,
) -> Result<Component, E> {
    let Some([x, y, z]) = channels(component)? else { return Ok(Component::grey(f(&component.luminance)?)) };
    Ok(from_channels([f(&x)?, f(&y)?, f(&z)?])?)
}

/// X, Y and Z of a component with colour.
pub(crate) fn channels(component: &Component) -> Result<Option<[Scattering; 3]>, TreeError> {
    let luminance = &component.luminance;
    Ok(match (luminance, &component.chroma) {
        (_, None) => None,
        (Scattering::Tree(y), Some([Scattering::Tree(u), Scattering::Tree(v)])) => {
            let xyz = |k: usize| {
                combined([y, u, v], &move |[y, u, v]: [f64; 3]| xyz_from_yuv(y, [u, v])[k].max(0.0))
            };
            Some([xyz(0)?.into(), luminance.clone(), xyz(2)?.into()])
        }
        (_, Some([x, z])) => Some([x.clone(), luminance.clone(), z.clone()]),
    })
}

/// A component of CIE X, Y and Z.
///
/// # Errors
/// If trees are too large.
pub fn from_channels([x, y, z]: [Scattering; 3]) -> Result<Component, TreeError> {
    let chroma = match (&x, &y, &z) {
        (Scattering::Tree(x), Scattering::Tree(y), Scattering::Tree(z)) => {
            let uv = |k: usize| combined([x, y, z], &move |xyz: [f64; 3]| uv_from_xyz(xyz)[k]);
            [uv(0)?.into(), uv(1)?.into()]
        }
        _ => [x, z],
    };
    Ok(Component { luminance: y, chroma: Some(chroma) })
}

/// What `f` makes of the values of three trees of one rank, place by place.
pub(crate) fn combined(trees: [&Tree; 3], f: &dyn Fn([f64; 3]) -> f64) -> Result<Tree, TreeError> {
    fn grow(
        trees: [&Tree; 3],
        slots: [Slot; 3],
        f: &dyn Fn([f64; 3]) -> f64,
        builder: &mut TreeBuilder,
    ) -> Result<Slot, TreeError> {
        let leaf = |slot: Slot| match slot.content() {
            Content::Leaf(value) => Some(f64::from(value)),
            Content::Node(_) => None,
        };
        if let [Some(a), Some(b), Some(c)] = slots.map(leaf) {
            return Ok(Slot::leaf(f([a, b, c]) as f32));
        }
        let n = trees[0].rank().n_children();
        let mut children = [slots[0]; 16];
        for (k, child) in children[..n].iter_mut().enumerate() {
            let below = std::array::from_fn(|t: usize| match slots[t].content() {
                Content::Leaf(_) => slots[t],
                Content::Node(node) => trees[t].arena().child(node, k),
            });
            *child = grow(trees, below, f, builder)?;
        }
        builder.node_or_leaf(&children[..n])
    }
    let mut builder = TreeBuilder::new(trees[0].rank());
    let root = grow(trees, trees.map(|tree| tree.arena().root()), f, &mut builder)?;
    Ok(Tree::new(builder.finish(root)))
}
