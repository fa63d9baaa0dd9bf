//! Trees with branches cut off.

use std::sync::Arc;

use bsdftree::reduce::{Goal, Norm};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::bsdf::Bsdf;
use crate::component::Tree;
use crate::value_error;

fn goal(
    l1: Option<f64>,
    rms: Option<f64>,
    total: Option<f64>,
    n_leaves: Option<usize>,
    norm: &str,
) -> PyResult<Goal> {
    let norm = match norm {
        "l1" => Norm::L1,
        "rms" => Norm::Rms,
        other => {
            return Err(PyValueError::new_err(format!("norm {other:?}; expected \"l1\" or \"rms\"")));
        }
    };
    Ok(Goal { l1, rms, total, n_leaves, norm })
}

/// A tree reduced to bounds or to a number of leaves.
#[pyfunction]
pub fn reduced(
    py: Python<'_>,
    tree: &Tree,
    l1: Option<f64>,
    rms: Option<f64>,
    total: Option<f64>,
    n_leaves: Option<usize>,
    norm: &str,
) -> PyResult<Tree> {
    let goal = goal(l1, rms, total, n_leaves, norm)?;
    let (tree, _) = py.detach(|| tree.0.reduced(&goal)).map_err(value_error)?;
    Ok(Tree(Arc::new(tree)))
}

/// A BSDF whose trees are reduced.
#[pyfunction]
pub fn reduced_bsdf(
    py: Python<'_>,
    bsdf: &Bsdf,
    l1: Option<f64>,
    rms: Option<f64>,
    total: Option<f64>,
    norm: &str,
) -> PyResult<Bsdf> {
    let goal = goal(l1, rms, total, None, norm)?;
    let reduced = py.detach(|| bsdf.bsdf.reduced(&goal)).map_err(value_error)?;
    Ok(Bsdf { bsdf: reduced, repairs: Vec::new() })
}

/// How far a tree is from the one that it is with branches cut off: relative L1, relative RMS, mean and worst error of totals, and where
/// the worst is in the incident square.
#[pyfunction]
pub fn loss(py: Python<'_>, whole: &Tree, reduced: &Tree) -> PyResult<(f64, f64, f64, f64, [f64; 2])> {
    let loss = py.detach(|| whole.0.loss_of(&reduced.0)).map_err(value_error)?;
    Ok((loss.l1, loss.rms, loss.mean_total, loss.worst_total, loss.worst_at))
}
