//! Trees and matrices by themselves.

use std::sync::Arc;

use bsdftree::{Basis, Component, Rank, Scattering};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::value_error;

/// A tensor tree.
#[pyclass(frozen, module = "bsdftree")]
pub struct Tree(pub Arc<bsdftree::Tree>);

/// Rank 3 or 4.
pub fn rank(rank: usize) -> PyResult<Rank> {
    match rank {
        3 => Ok(Rank::Three),
        4 => Ok(Rank::Four),
        other => Err(PyValueError::new_err(format!("rank {other}; expected 3 (isotropic) or 4"))),
    }
}

#[pymethods]
impl Tree {
    #[getter]
    fn rank(&self) -> usize {
        self.0.rank().dimensions()
    }

    #[getter]
    fn depth(&self) -> u32 {
        self.0.arena().log2_res()
    }

    #[getter]
    fn n_leaves(&self) -> usize {
        self.0.arena().n_leaves()
    }

    #[getter]
    fn nbytes(&self) -> usize {
        self.0.arena().n_bytes()
    }

    fn _to_grid<'py>(&self, py: Python<'py>, log2_res: u32) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_vec(py, py.detach(|| self.0.to_grid(log2_res)))
    }

    #[allow(clippy::type_complexity, reason = "three arrays side by side")]
    fn leaves<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyArray2<u32>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f32>>)> {
        let d = self.0.rank().dimensions();
        let (mut cells, mut levels, mut values) = (Vec::new(), Vec::new(), Vec::new());
        for leaf in self.0.leaves() {
            cells.extend_from_slice(&leaf.cell[..d]);
            levels.push(leaf.level);
            values.push(leaf.value);
        }
        let n = levels.len();
        let cells = PyArray1::from_vec(py, cells).reshape([n, d])?;
        Ok((cells, PyArray1::from_vec(py, levels), PyArray1::from_vec(py, values)))
    }

    fn __repr__(&self) -> String {
        format!("<Tree rank {}, 2^{} per axis, {} leaves>", self.rank(), self.depth(), self.n_leaves())
    }
}

/// A Klems matrix.
#[pyclass(frozen, module = "bsdftree")]
pub struct Matrix(pub Arc<bsdftree::Matrix>);

/// Rings of a basis: lower and upper polar angle \[degree\] and number of patches.
pub fn rings(basis: &Basis) -> Vec<(f64, f64, u32)> {
    basis.rings().iter().map(|r| (r.bounds_deg[0], r.bounds_deg[1], r.n_phi)).collect()
}

#[pymethods]
impl Matrix {
    #[getter]
    fn incident_basis(&self) -> String {
        self.0.incident().name().to_owned()
    }

    #[getter]
    fn exitant_basis(&self) -> String {
        self.0.exitant().name().to_owned()
    }

    #[getter]
    fn incident_rings(&self) -> Vec<(f64, f64, u32)> {
        rings(self.0.incident())
    }

    #[getter]
    fn exitant_rings(&self) -> Vec<(f64, f64, u32)> {
        rings(self.0.exitant())
    }

    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let shape = [self.0.incident().n_patches(), self.0.exitant().n_patches()];
        PyArray1::from_slice(py, self.0.values()).reshape(shape)
    }

    #[getter]
    fn nbytes(&self) -> usize {
        std::mem::size_of_val(self.0.values())
    }

    fn __repr__(&self) -> String {
        format!(
            "<Matrix {} ({}) x {} ({})>",
            self.0.incident().name(),
            self.0.incident().n_patches(),
            self.0.exitant().name(),
            self.0.exitant().n_patches()
        )
    }
}

/// A tree or a matrix by itself.
pub fn scattering<'py>(py: Python<'py>, scattering: &Scattering) -> PyResult<Bound<'py, PyAny>> {
    Ok(match scattering {
        Scattering::Tree(tree) => Bound::new(py, Tree(Arc::clone(tree)))?.into_any(),
        Scattering::Matrix(matrix) => Bound::new(py, Matrix(Arc::clone(matrix)))?.into_any(),
    })
}

/// A tree or a matrix, as it comes from Python.
#[derive(FromPyObject)]
pub enum Function<'py> {
    Tree(PyRef<'py, Tree>),
    Matrix(PyRef<'py, Matrix>),
}

impl From<&Function<'_>> for Scattering {
    fn from(function: &Function<'_>) -> Scattering {
        match function {
            Function::Tree(tree) => Scattering::Tree(Arc::clone(&tree.0)),
            Function::Matrix(matrix) => Scattering::Matrix(Arc::clone(&matrix.0)),
        }
    }
}

/// A component of luminance, or of luminance and both chroma.
pub fn component(functions: &[Function<'_>]) -> PyResult<Component> {
    let functions: Vec<Scattering> = functions.iter().map(Scattering::from).collect();
    if functions.iter().any(|f| !f.has_domain_of(&functions[0])) {
        return Err(value_error(
            "luminance and chroma of different kinds; expected trees of one rank or matrices over one basis",
        ));
    }
    match <[Scattering; 3]>::try_from(functions) {
        Ok([luminance, a, b]) => Ok(Component { luminance, chroma: Some([a, b]) }),
        Err(functions) => match <[Scattering; 1]>::try_from(functions) {
            Ok([luminance]) => Ok(Component::grey(luminance)),
            Err(functions) => Err(value_error(format!("{} functions; expected 1 or 3", functions.len()))),
        },
    }
}

/// Luminance and chroma of a component.
pub fn functions<'py>(py: Python<'py>, component: &Component) -> PyResult<Vec<Bound<'py, PyAny>>> {
    std::iter::once(&component.luminance)
        .chain(component.chroma.iter().flatten())
        .map(|s| scattering(py, s))
        .collect()
}
