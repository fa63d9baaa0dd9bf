//! All trees of a BSDF reduced.

use super::{Goal, ReduceError};
use crate::bsdf::{Bsdf, Scattering};

/// Relative L1 error that u′ and v′ may have: about two just noticeable differences of colour on average.
const CHROMA: f64 = 0.01;

impl Bsdf {
    /// A copy whose trees are reduced, each by itself: luminance to the goal, u′ and v′ to a relative L1 error of 1 %, or to as many leaves
    /// if that is the goal. Matrices stay as they are.
    ///
    /// # Errors
    /// As [`Tree::reduced`](crate::Tree::reduced).
    pub fn reduced(&self, goal: &Goal) -> Result<Bsdf, ReduceError> {
        let mut bsdf = self.clone();
        let chroma = Goal { l1: Some(CHROMA), ..Goal::default() };
        let chroma = if goal.n_leaves.is_some() { *goal } else { chroma };
        for band in &mut bsdf.bands {
            for component in band.components_mut() {
                reduce(&mut component.luminance, goal)?;
                for function in component.chroma.iter_mut().flatten() {
                    reduce(function, &chroma)?;
                }
            }
        }
        Ok(bsdf)
    }
}

fn reduce(function: &mut Scattering, goal: &Goal) -> Result<(), ReduceError> {
    if let Scattering::Tree(tree) = function {
        *function = tree.reduced(goal)?.0.into();
    }
    Ok(())
}
