//! Cells of incident and exitant directions, and where paths start, for whoever else traces rays.

use std::sync::Arc;

use bsdftree::klems::Ring;
use bsdftree::{Basis, Rank, Scattering};
use bsdftree_generate::layout::morton_from_cell;
use bsdftree_generate::random::Stratified;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::component;
use crate::value_error;

/// A basis by name, or by its rings: lower and upper polar angle \[degree\] and number of patches.
#[derive(FromPyObject)]
pub enum Klems {
    Name(String),
    Rings(Vec<(f64, f64, u32)>),
}

/// A basis, each patch of it split into as many by as many.
pub fn klems_basis(klems: Klems, subdivide: u32) -> PyResult<Basis> {
    let basis = match klems {
        Klems::Rings(rings) => {
            let ring = |(lower, upper, n_phi)| Ring { bounds_deg: [lower, upper], n_phi };
            Basis::new("User", rings.into_iter().map(ring).collect()).map_err(value_error)?
        }
        Klems::Name(name) => match name.as_str() {
            "full" => Basis::full(),
            "half" => Basis::half(),
            "half73" => Basis::half_73(),
            "quarter" => Basis::quarter(),
            _ => {
                let expected = "expected \"full\", \"half\", \"half73\", \"quarter\" or a list of rings";
                return Err(value_error(format!("Klems basis {name:?}; {expected}")));
            }
        },
    };
    if subdivide == 1 { Ok(basis) } else { basis.subdivided(subdivide).map_err(value_error) }
}

/// Of `klems` and (`rank`, `log2_res`) exactly one counts.
pub fn layout(
    rank: usize,
    log2_res: u32,
    klems: Option<Klems>,
    subdivide: u32,
) -> PyResult<bsdftree_generate::Layout> {
    Ok(match klems {
        Some(klems) => bsdftree_generate::Layout::Klems(Arc::new(klems_basis(klems, subdivide)?)),
        None => bsdftree_generate::Layout::Tree { rank: component::rank(rank)?, log2_res },
    })
}

/// How incident and exitant directions are divided. Cells of a square count with the first coordinate slowest.
#[pyclass(frozen, module = "bsdftree._core")]
pub struct Layout(bsdftree_generate::Layout);

#[pymethods]
impl Layout {
    #[new]
    #[pyo3(signature = (*, rank, log2_res, klems, subdivide))]
    fn new(rank: usize, log2_res: u32, klems: Option<Klems>, subdivide: u32) -> PyResult<Layout> {
        let layout = layout(rank, log2_res, klems, subdivide)?;
        if let (bsdftree_generate::Layout::Tree { .. }, false) =
            (&layout, (1..=bsdftree_generate::layout::MAX_LOG2_RES).contains(&log2_res))
        {
            let most = bsdftree_generate::layout::MAX_LOG2_RES;
            return Err(value_error(format!(
                "a resolution of 2^{log2_res} per axis; expected 2^1 to 2^{most}"
            )));
        }
        Ok(Layout(layout))
    }

    #[getter]
    fn n_incident(&self) -> usize {
        self.0.n_incident()
    }

    #[getter]
    fn n_exitant(&self) -> usize {
        self.0.n_exitant()
    }

    /// Rings of patches; none for trees.
    #[getter]
    fn rings(&self) -> Vec<(f64, f64, u32)> {
        match &self.0 {
            bsdftree_generate::Layout::Klems(basis) => component::rings(basis),
            bsdftree_generate::Layout::Tree { .. } => Vec::new(),
        }
    }

    /// Projected solid angles of the exitant cells \[sr\].
    fn exitant_areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, (0..self.0.n_exitant()).map(|cell| self.0.exitant_area(cell)))
    }

    /// Where the paths of an incident cell start: −incident.xy, and a point of the aperture in \[0, 1)², (n, 4). The points are
    /// those of `generate` for the same seed.
    fn starts<'py>(
        &self,
        py: Python<'py>,
        from_back: bool,
        cell: usize,
        n: u64,
        seed: u64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        if cell >= self.0.n_incident() || n >= 1 << 35 {
            return Err(value_error(format!("cell {cell} of {}, {n} paths", self.0.n_incident())));
        }
        let cell = match &self.0 {
            bsdftree_generate::Layout::Tree { rank: Rank::Four, log2_res } => {
                morton_from_cell([(cell >> log2_res) as u32, (cell & ((1 << log2_res) - 1)) as u32]) as usize
            }
            _ => cell,
        };
        let stream = (cell as u64) << 1 | u64::from(from_back);
        let mut points = Stratified::new(seed, stream);
        let mut rows = Vec::with_capacity(4 * n as usize);
        for sample in 0..n {
            let start = points.start(seed, stream, sample);
            rows.extend(self.0.incident_disk(cell, start.incident[0], start.incident[1]));
            rows.extend(start.origin);
        }
        PyArray1::from_vec(py, rows).reshape([n as usize, 4])
    }

    /// A tree or a matrix of values \[1/sr\], a row of exitant cells for each incident cell. The upper half of a rank-3 tree, which no
    /// light comes from, is 0.
    fn function<'py>(
        &self,
        py: Python<'py>,
        values: PyReadonlyArray1<'_, f32>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut values = values.as_slice()?.to_vec();
        let scattering = match &self.0 {
            bsdftree_generate::Layout::Klems(basis) => {
                let matrix = bsdftree::Matrix::new(Arc::clone(basis), Arc::clone(basis), values);
                Scattering::from(matrix.map_err(value_error)?)
            }
            bsdftree_generate::Layout::Tree { rank, .. } => {
                if *rank == Rank::Three {
                    values.resize(2 * values.len(), 0.0);
                }
                Scattering::from(bsdftree::Tree::from_grid(*rank, &values).map_err(value_error)?)
            }
        };
        component::scattering(py, &scattering)
    }
}
