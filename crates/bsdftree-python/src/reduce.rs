//! Trees with branches cut off.

use std::sync::Arc;

use bsdftree::reduce::{Goal, Loss, Norm};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::component::Tree;
use crate::value_error;

/// Relative L1, relative RMS, mean and worst error of totals, and where the worst is in the incident square.
type Numbers = (f64, f64, f64, f64, [f64; 2]);

fn numbers(loss: Loss) -> Numbers {
    (loss.l1, loss.rms, loss.mean_total, loss.worst_total, loss.worst_at)
}

/// A tree reduced to bounds or a number of leaves, and what it lost.
#[pyfunction]
#[pyo3(signature = (tree, l1, rms, total, n_leaves, norm))]
pub fn reduced(
    py: Python<'_>,
    tree: &Tree,
    l1: Option<f64>,
    rms: Option<f64>,
    total: Option<f64>,
    n_leaves: Option<usize>,
    norm: &str,
) -> PyResult<(Tree, Numbers)> {
    let norm = match norm {
        "l1" => Norm::L1,
        "rms" => Norm::Rms,
        other => {
            return Err(PyValueError::new_err(format!("norm {other:?}; expected \"l1\" or \"rms\"")));
        }
    };
    let goal = Goal { l1, rms, total, n_leaves, norm };
    let (tree, loss) = py.detach(|| tree.0.reduced(&goal)).map_err(value_error)?;
    Ok((Tree(Arc::new(tree)), numbers(loss)))
}

/// How far a tree is from the one that it is with branches cut off.
#[pyfunction]
pub fn loss(py: Python<'_>, whole: &Tree, reduced: &Tree) -> PyResult<Numbers> {
    py.detach(|| whole.0.loss_of(&reduced.0)).map(numbers).map_err(value_error)
}
