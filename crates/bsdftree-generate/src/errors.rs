//! How uncertain a tree is: a standard error for every leaf, and the error of the whole.
//!
//! The standard error of a leaf is the scatter of its replicates, which are independent and of one distribution whatever the sampling:
//! with T_r the weights that replicate r counted in the leaf and n_r its paths, Var(ΣT_r) = R/(R−1) Σ_r (T_r − n_r ΣT/n)², R = 8. An
//! interval of 95 % is ±2.36 standard errors (Student's t, 7 degrees of freedom). In a leaf in which nothing was counted, one count is.
//!
//! The expected error of the whole, Σ|B| E|f_B − f|, is, as in normal distributions, √(2/π) of the standard error in each leaf, and
//! 0.8 of the spread of its children beyond their noise, √(mean_k[(f_k−f_B)² − (V_k−V_B)]).

use rayon::prelude::*;

use crate::random::N_REPLICATES;
use crate::reduce::{Kept, Member, Reducer, Region};
use crate::scatter::Flux;
use crate::tally::Exit;

/// Mean of |x| for a normal x of variance 1; about 0.8 also for other distributions.
pub(crate) const MEAN_ABSOLUTE: f64 = 0.797_884_560_802_865_4;

/// Half an interval of 95 % in standard errors: Student's t with 7 degrees of freedom.
pub(crate) const STUDENT_95: f64 = 2.364_624_251_592_785;

/// What a component is uncertain by.
pub(crate) struct Uncertainty {
    /// The tree with standard errors in place of values.
    pub errors: Kept,
    /// Σ over the finest cells of the expected |error|.
    pub absolute: f64,
    /// Σ over the finest cells of the BSDF.
    pub total: f64,
}

/// Finds out what is wrong with the tree.
pub(crate) fn uncertainty<S: Flux>(reducer: &Reducer<'_, S>, kept: &Kept) -> Uncertainty {
    let (region, members) = reducer.root();
    visited(reducer, kept, region, &members, 0.0)
}

/// Standard error of the mean weight of n paths that exits counted.
pub(crate) fn standard_error<'a, S: Flux + 'a>(exits: impl IntoIterator<Item = &'a Exit<S>>, n: f64) -> f64 {
    let mut sums = [0.0; N_REPLICATES];
    for exit in exits {
        for (sum, part) in sums.iter_mut().zip(exit.replicates) {
            *sum += f64::from(part);
        }
    }
    let r = N_REPLICATES as f64;
    let mean = sums.iter().sum::<f64>() / n;
    // Paths are dealt in turn, so the first replicates may have one more.
    let (each, more) = ((n / r).floor(), (n % r) as usize);
    let paths = |k: usize| each + f64::from(u8::from(k < more));
    let squares: f64 = sums.iter().enumerate().map(|(k, sum)| (sum - paths(k) * mean).powi(2)).sum();
    (squares * r / (r - 1.0)).sqrt() / n
}

fn visited<S: Flux>(
    reducer: &Reducer<'_, S>,
    kept: &Kept,
    region: Region,
    members: &[Member],
    weight: f64,
) -> Uncertainty {
    let size = region.size();
    match kept {
        Kept::Leaf { value, .. } => {
            let error = match members.is_empty() {
                _ if size == 0.0 => 0.0,
                true => reducer.moments(&region, members, weight).variance.sqrt(),
                false => {
                    let exits = members.iter().flat_map(|&m| reducer.exits(m));
                    let counted = standard_error(exits, reducer.n) / (reducer.omega * size);
                    (counted * counted + reducer.modelled(&region).variance).sqrt()
                }
            };
            let spread = spread(reducer, *value, &region, members);
            Uncertainty {
                errors: Kept::Leaf { value: error, xyz: [0.0; 3], split: None },
                absolute: MEAN_ABSOLUTE * size * (error + spread),
                total: size * value,
            }
        }
        Kept::Node(children) => {
            let weight = reducer.weight(members);
            let parts = reducer.parts(region, members);
            let visit = |(k, child): (usize, &Kept)| {
                let (part, members) = parts.get(k);
                visited(reducer, child, part, members, weight)
            };
            let children: Vec<_> = match region.level < 2 {
                true => children.par_iter().enumerate().map(visit).collect(),
                false => children.iter().enumerate().map(visit).collect(),
            };
            Uncertainty {
                absolute: children.iter().map(|c| c.absolute).sum(),
                total: children.iter().map(|c| c.total).sum(),
                errors: Kept::Node(children.into_iter().map(|c| c.errors).collect()),
            }
        }
    }
}

/// By how much a leaf's children differ from it beyond noise \[1/sr\].
fn spread<S: Flux>(reducer: &Reducer<'_, S>, value: f64, region: &Region, members: &[Member]) -> f64 {
    if reducer.is_whole(region, members) {
        return 0.0;
    }
    let weight = reducer.weight(members);
    let own = reducer.moments(region, members, weight).variance;
    let parts = reducer.parts(*region, members);
    let squares: f64 = parts
        .iter()
        .filter(|(part, _)| part.size() > 0.0)
        .map(|(part, m)| {
            let child = reducer.moments(&part, m, weight);
            part.size() * ((child.value - value).powi(2) - (child.variance - own))
        })
        .sum();
    (squares / region.size()).max(0.0).sqrt()
}
