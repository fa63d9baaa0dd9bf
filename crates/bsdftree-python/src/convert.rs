//! One kind of BSDF from another.

use std::sync::Arc;

use bsdftree::convert::TreeOptions;
use pyo3::prelude::*;

use crate::bsdf::Bsdf;
use crate::component::{Function, rank};
use crate::layout::{Klems, klems_basis};
use crate::value_error;

/// A BSDF without repairs of its own.
pub fn made(bsdf: bsdftree::Bsdf) -> Bsdf {
    Bsdf { bsdf, repairs: Vec::new() }
}

/// Over an angle basis.
#[pyfunction]
pub fn to_klems(py: Python<'_>, bsdf: &Bsdf, klems: Klems, subdivide: u32) -> PyResult<Bsdf> {
    let basis = Arc::new(klems_basis(klems, subdivide)?);
    py.detach(|| bsdf.bsdf.to_klems(&basis)).map(made).map_err(value_error)
}

/// As trees.
#[pyfunction]
pub fn to_tree(py: Python<'_>, bsdf: &Bsdf, rank: usize, log2_res: u32, tolerance: f64) -> PyResult<Bsdf> {
    let options = TreeOptions { rank: self::rank(rank)?, log2_res, tolerance };
    py.detach(|| bsdf.bsdf.to_tree(&options)).map(made).map_err(value_error)
}

/// How far one function is from another, relative to all light of the first.
#[pyfunction]
pub fn relative_l1(py: Python<'_>, reference: Function<'_>, other: Function<'_>) -> f64 {
    let (reference, other) = ((&reference).into(), (&other).into());
    py.detach(|| bsdftree::convert::relative_l1(&reference, &other))
}
