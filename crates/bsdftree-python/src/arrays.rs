//! NumPy arrays as slices of directions and numbers, chunk by chunk.

use std::ops::Range;

use bsdftree::Direction;
use bsdftree::direction::normalized;
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

/// Rows that are looked at and asked about together: few enough to stay in the cache.
pub const CHUNK: usize = 1024;

/// Directions that may not have unit length.
pub struct Vectors<'a> {
    rows: &'a [Direction],
    name: &'static str,
    /// Where a chunk is normalised, if it must be.
    normalized: Vec<Direction>,
}

impl<'a> Vectors<'a> {
    /// Those in an array.
    pub fn new(array: &'a Directions<'_>, name: &'static str) -> PyResult<Vectors<'a>> {
        Ok(Vectors { rows: directions(array, name)?, name, normalized: Vec::new() })
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Unit vectors of a chunk.
    ///
    /// # Errors
    /// If one has no direction.
    pub fn units(&mut self, range: Range<usize>) -> Result<&[Direction], String> {
        /// Of a squared length, which rounding does not exceed.
        const TOLERANCE: f64 = 2e-12;
        let first = range.start;
        let rows = &self.rows[range];
        let are_units =
            rows.iter().fold(true, |all, [x, y, z]| all & ((x * x + y * y + z * z - 1.0).abs() < TOLERANCE));
        if are_units {
            return Ok(rows);
        }
        self.normalized.clear();
        for (k, &row) in rows.iter().enumerate() {
            let unit = normalized(row).ok_or_else(|| {
                let (name, at) = (self.name, first + k);
                format!("{name}[{at}] is {row:?}, which has no direction; expected a unit vector")
            })?;
            self.normalized.push(unit);
        }
        Ok(&self.normalized)
    }
}

/// Ranges of so many things that are a chunk each.
pub fn chunks(n: usize) -> impl Iterator<Item = Range<usize>> {
    (0..n).step_by(CHUNK).map(move |first| first..(first + CHUNK).min(n))
}

/// Refuses arrays of different lengths.
pub fn same_length(a: usize, b: usize) -> PyResult<()> {
    if a == b {
        Ok(())
    } else {
        Err(PyValueError::new_err(format!("arrays of {a} and {b} rows; expected equal lengths")))
    }
}
