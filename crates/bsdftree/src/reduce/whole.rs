//! All trees of a BSDF reduced: each by itself to bounds, or all to one bound that makes them as small together as is wanted.

use super::source::Nodes;
use super::{Goal, Norm, ReduceError, Reduction};
use crate::bsdf::{Bsdf, Scattering};
use crate::tree::Arena;

/// Relative L1 error that u′ and v′ may have: about two just noticeable differences of colour on average.
const CHROMA: f64 = 0.01;

/// Bounds on errors between which that of a size is sought: as good as none, and the most there can be (of L1, where all light is in a
/// small part).
const BOUNDS: [f64; 2] = [1e-9, 2.0];

/// The first bound that is tried, and the steps by which others are, until one is on either side of the size.
const FIRST: f64 = 0.02;
const STEP: f64 = 8.0;

/// How near to the size is near enough.
const PRECISION: f64 = 0.005;

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
        for_functions(&mut bsdf, |function, is_chroma| {
            reduce(function, if is_chroma { &chroma } else { goal })
        })?;
        Ok(bsdf)
    }

    /// A copy reduced to a size that `size` tells of a BSDF: the errors of all luminance trees are kept within one bound, about as small
    /// as the size allows, and the goal's on totals; its norm says which errors. Few copies are made on the way: sizes follow errors smoothly.
    ///
    /// # Errors
    /// If the smallest there is, which has one leaf in each tree unless totals are kept within a bound too, is larger, or as
    /// [`Tree::reduced`](crate::Tree::reduced).
    pub fn reduced_to(
        &self,
        most: usize,
        goal: &Goal,
        size: impl Fn(&Bsdf) -> usize,
    ) -> Result<Bsdf, ReduceError> {
        let goal = Goal { l1: None, rms: None, n_leaves: None, ..*goal };
        Goal { n_leaves: Some(most), ..goal }.validated()?;
        let mut base = self.clone();
        let chroma = Goal { l1: Some(CHROMA), ..Goal::default() };
        for_functions(&mut base, |function, is_chroma| match is_chroma {
            true => reduce(function, &chroma),
            false => Ok(()),
        })?;
        let arenas = luminance_in_order(&mut base)?;
        let reductions: Vec<_> =
            arenas.iter().map(|arena| Reduction::new(Nodes::new(arena), goal.norm)).collect();
        let at = |bound: f64| -> Result<(Bsdf, usize), ReduceError> {
            let goal = match goal.norm {
                Norm::L1 => Goal { l1: Some(bound), ..goal },
                Norm::Rms => Goal { rms: Some(bound), ..goal },
            };
            let (mut bsdf, mut reductions) = (base.clone(), reductions.iter());
            for_functions(&mut bsdf, |function, is_chroma| {
                if let (Scattering::Tree(_), false) = (&*function, is_chroma) {
                    let reduction = reductions.next().expect("there is one for each tree");
                    *function = reduction.best(&goal)?.0.into();
                }
                Ok(())
            })?;
            let size = size(&bsdf);
            Ok((bsdf, size))
        };
        sought(at, most)
    }
}

/// The BSDF of about the least bound at which its size is at most so much.
fn sought(at: impl Fn(f64) -> Result<(Bsdf, usize), ReduceError>, most: usize) -> Result<Bsdf, ReduceError> {
    // The logarithms of a bound and of a size beside what is wanted. A little less is aimed at, so as not to end just above.
    let aim = most as f64 * (1.0 - PRECISION / 2.0);
    let point = |bound: f64, size: usize| (bound.ln(), (size as f64 / aim).ln());
    let is_near = |size: usize| size <= most && size as f64 >= most as f64 * (1.0 - PRECISION);
    let (mut best, mut bound) = (None, FIRST);
    let (mut fits, mut exceeds) = (None, None);
    while fits.is_none() || exceeds.is_none() {
        let (bsdf, size) = at(bound)?;
        if size <= most {
            (best, fits) = (Some(bsdf), Some(point(bound, size)));
            if bound == BOUNDS[0] || is_near(size) {
                break;
            }
            bound = if exceeds.is_none() { (bound / STEP).max(BOUNDS[0]) } else { bound };
        } else {
            exceeds = Some(point(bound, size));
            if bound == BOUNDS[1] {
                return Err(ReduceError::Size { least: size, asked: most });
            }
            bound = if fits.is_none() { (bound * STEP).min(BOUNDS[1]) } else { bound };
        }
    }
    let (Some(mut fits), Some(mut exceeds)) = (fits, exceeds) else {
        return Ok(best.expect("one fits, or there was an error"));
    };
    // Where a line through both says that it is (the Illinois rule: a side that stays counts half).
    while fits.0 - exceeds.0 > 1e-3 {
        let share = (exceeds.1 / (exceeds.1 - fits.1)).clamp(0.02, 0.98);
        let bound = (exceeds.0 + share * (fits.0 - exceeds.0)).exp();
        let (bsdf, size) = at(bound)?;
        if size <= most {
            (fits, exceeds.1) = (point(bound, size), exceeds.1 / 2.0);
            best = Some(bsdf);
            if is_near(size) {
                break;
            }
        } else {
            (exceeds, fits.1) = (point(bound, size), fits.1 / 2.0);
        }
    }
    Ok(best.expect("one fits"))
}

/// Calls `f` with all functions, and whether they are u′ or v′.
fn for_functions(
    bsdf: &mut Bsdf,
    mut f: impl FnMut(&mut Scattering, bool) -> Result<(), ReduceError>,
) -> Result<(), ReduceError> {
    for component in bsdf.bands.iter_mut().flat_map(|band| band.components_mut()) {
        f(&mut component.luminance, false)?;
        component.chroma.iter_mut().flatten().try_for_each(|function| f(function, true))?;
    }
    Ok(())
}

/// The luminance trees in level order.
fn luminance_in_order(bsdf: &mut Bsdf) -> Result<Vec<Arena>, ReduceError> {
    let mut arenas = Vec::new();
    for_functions(bsdf, |function, is_chroma| {
        if let (Scattering::Tree(tree), false) = (&*function, is_chroma) {
            tree.has_totals()?;
            arenas.push(tree.arena().in_level_order());
        }
        Ok(())
    })?;
    Ok(arenas)
}

fn reduce(function: &mut Scattering, goal: &Goal) -> Result<(), ReduceError> {
    if let Scattering::Tree(tree) = function {
        *function = tree.reduced(goal)?.0.into();
    }
    Ok(())
}
