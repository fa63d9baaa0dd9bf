//! Trees from a function of two directions.
//!
//! In: a function that takes many pairs of directions at once. Out: trees whose values are its means over cells, refined where it changes
//! ([`super::refine`]).
//!
//! Source: the function mode of Radiance's bsdf2ttree, which evaluates a full grid and then culls it.

use super::refine::Refinement;
use super::{ConvertError, TreeOptions, xyz};
use crate::bsdf::{Band, Bsdf, Component, Part};
use crate::direction::Direction;
use crate::tree::Tree;

/// What is wrong with a function.
#[derive(Debug)]
pub enum FunctionError<E> {
    /// Options out of range, or a tree too large.
    Convert(ConvertError),
    /// The function itself failed.
    Function(E),
    /// A value that is not a finite number ≥ 0.
    Value {
        /// Where light came from.
        incident: Direction,
        /// Where it went.
        exitant: Direction,
        /// The value \[1/sr\].
        value: f64,
    },
}

impl<E, F: Into<ConvertError>> From<F> for FunctionError<E> {
    fn from(error: F) -> Self {
        FunctionError::Convert(error.into())
    }
}

/// What makes a component: for pairs of directions, one value each \[1/sr\] or X, Y, Z, one pair after the other.
pub(super) type Evaluate<'a, E> = dyn FnMut(&[Direction], &[Direction], &mut [f64]) -> Result<(), E> + 'a;

impl Bsdf {
    /// A BSDF of the band Visible from a function of incident and exitant direction, for each of `parts`; black ones are left out.
    ///
    /// `f` fills in one value \[1/sr\] (no cosine) for each pair, or with `color` CIE X, Y and Z. At rank 3 the incident directions lie
    /// in the half-plane y = 0, x ≤ 0, and the function is taken to be isotropic.
    ///
    /// # Errors
    /// If the options are out of range, or `f` fails or gives a value that is negative or not finite.
    pub fn from_function<E>(
        mut f: impl FnMut(&[Direction], &[Direction], &mut [f64]) -> Result<(), E>,
        parts: &[Part],
        color: bool,
        options: &TreeOptions,
    ) -> Result<Bsdf, FunctionError<E>> {
        let options = options.validated()?;
        let mut band = Band::new("Visible");
        for &part in parts {
            let n = if color { 3 } else { 1 };
            let mut trees = Refinement::new(&mut f, part, n, options)?.trees()?;
            let luminance = trees.remove(n / 2);
            if luminance.arena().n_nodes() == 0 && luminance.leaves().all(|leaf| leaf.value == 0.0) {
                continue;
            }
            let component = match <[Tree; 2]>::try_from(trees) {
                Ok([x, z]) => xyz::from_channels([x.into(), luminance.into(), z.into()])?,
                Err(_) => Component::grey(luminance.into()),
            };
            band.insert(part, component);
        }
        Ok(Bsdf { bands: vec![band], ..Bsdf::default() })
    }
}
