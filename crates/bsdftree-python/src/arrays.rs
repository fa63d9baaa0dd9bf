//! NumPy arrays as slices of directions and numbers.

use bsdftree::Direction;
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Directions as the library takes them.
pub type Directions<'py> = PyReadonlyArray2<'py, f64>;
/// Numbers as the library takes them.
pub type Numbers<'py> = PyReadonlyArray1<'py, f64>;

/// The rows of a C-contiguous (n, 3) array.
pub fn directions<'a>(array: &'a Directions<'_>, name: &str) -> PyResult<&'a [Direction]> {
    if array.shape()[1] != 3 {
        return Err(PyValueError::new_err(format!("{name} has shape {:?}; expected (n, 3)", array.shape())));
    }
    let (rows, rest) = array.as_slice()?.as_chunks::<3>();
    debug_assert!(rest.is_empty());
    Ok(rows)
}

/// Refuses arrays of different lengths.
pub fn same_length(a: usize, b: usize) -> PyResult<()> {
    if a == b {
        Ok(())
    } else {
        Err(PyValueError::new_err(format!("arrays of {a} and {b} rows; expected equal lengths")))
    }
}
