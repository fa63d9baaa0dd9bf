//! Matrices from arrays, and Radiance's matrix files.

use std::path::PathBuf;
use std::sync::Arc;

use bsdftree::radiance_matrix::{Format, RadianceMatrix};
use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use crate::component::Matrix;
use crate::layout::{Klems, klems_basis};
use crate::value_error;

/// Of values \[1/sr\], a row of exitant patches for each incident one.
#[pyfunction]
pub fn matrix(values: PyReadonlyArray2<'_, f32>, klems: Klems, subdivide: u32) -> PyResult<Matrix> {
    let basis = Arc::new(klems_basis(klems, subdivide)?);
    let n = basis.n_patches();
    let values = values.as_array();
    if values.shape() != [n, n] {
        return Err(value_error(format!("an array of shape {:?}; expected ({n}, {n})", values.shape())));
    }
    let values = values.iter().copied().collect();
    bsdftree::Matrix::new(Arc::clone(&basis), basis, values).map(|m| Matrix(Arc::new(m))).map_err(value_error)
}

/// Projected solid angles \[sr\] of the incident and the exitant patches.
#[pyfunction]
pub fn patch_areas<'py>(py: Python<'py>, matrix: &Matrix) -> [Bound<'py, PyArray1<f64>>; 2] {
    [matrix.0.incident(), matrix.0.exitant()].map(|basis| {
        PyArray1::from_iter(py, (0..basis.n_patches()).map(|patch| basis.projected_solid_angle(patch)))
    })
}

/// (rows, columns, components).
#[pyfunction]
pub fn read_radiance_matrix<'py>(py: Python<'py>, bytes: &[u8]) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let RadianceMatrix { n_rows, n_columns, n_components, values } =
        py.detach(|| RadianceMatrix::read(bytes)).map_err(value_error)?;
    PyArray1::from_vec(py, values).reshape([n_rows, n_columns, n_components])
}

/// Writes a file of (rows, columns, components).
#[pyfunction]
pub fn write_radiance_matrix(
    py: Python<'_>,
    path: PathBuf,
    values: PyReadonlyArray3<'_, f64>,
    format: &str,
) -> PyResult<()> {
    let format = match format {
        "ascii" => Format::Ascii,
        "float" => Format::Float,
        "double" => Format::Double,
        other => {
            let expected = "expected \"ascii\", \"float\" or \"double\"";
            return Err(value_error(format!("format {other:?}; {expected}")));
        }
    };
    let values = values.as_array();
    let &[n_rows, n_columns, n_components] = values.shape() else { unreachable!("three axes") };
    let matrix = RadianceMatrix { n_rows, n_columns, n_components, values: values.iter().copied().collect() };
    py.detach(|| matrix.write_file(&path, format))
        .map_err(|e| PyOSError::new_err((e.raw_os_error(), e.kind().to_string(), path.display().to_string())))
}
