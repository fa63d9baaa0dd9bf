//! Specular peaks, as plain Python objects.

use bsdftree::peaks::{Map, PeakFamily, PeakOptions};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::bsdf::Bsdf;

/// One dictionary per family; its peaks are arrays side by side.
#[pyfunction]
pub fn peaks<'py>(
    py: Python<'py>,
    bsdf: &Bsdf,
    band: &str,
    contrast: f64,
    min_strength: f64,
) -> PyResult<Bound<'py, PyList>> {
    let band = bsdf.band(band)?;
    let families = py.detach(|| bsdftree::peaks::peaks(band, PeakOptions { contrast, min_strength }));
    let list = PyList::empty(py);
    for found in &families {
        list.append(family(py, found)?)?;
    }
    Ok(list)
}

fn family<'py>(py: Python<'py>, family: &PeakFamily) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("component", family.part.key())?;
    dict.set_item("kind", family.map.name())?;
    dict.set_item("residual_deg", (!family.residual_deg.is_nan()).then_some(family.residual_deg))?;
    dict.set_item("n_directions", family.n_directions)?;
    match family.map {
        Map::Facet { normal } => dict.set_item("normal", normal)?,
        Map::Prism { normal, index, flat_first } => {
            dict.set_item("normal", normal)?;
            dict.set_item("index", index)?;
            dict.set_item("flat_first", flat_first)?;
        }
        Map::InnerFacet { normal, index } => {
            dict.set_item("normal", normal)?;
            dict.set_item("index", index)?;
        }
        Map::Groove { axis } => dict.set_item("axis", axis)?,
        Map::Shift { cosines } => dict.set_item("shift", cosines)?,
        Map::Straight | Map::Mirror | Map::Retro | Map::Table => {}
    }
    let peaks = &family.peaks;
    let numbers = |f: fn(&bsdftree::peaks::Peak) -> f64| PyArray1::from_iter(py, peaks.iter().map(f));
    dict.set_item("incident", directions(py, peaks.iter().map(|p| p.incident).collect())?)?;
    dict.set_item("exitant", directions(py, peaks.iter().map(|p| p.exitant).collect())?)?;
    dict.set_item("strength", numbers(|p| p.strength))?;
    dict.set_item("surround", numbers(|p| p.surround))?;
    dict.set_item("projected_solid_angle", numbers(|p| p.projected_solid_angle))?;
    dict.set_item("width_deg", numbers(bsdftree::peaks::Peak::width_deg))?;
    dict.set_item("resolution_limited", PyArray1::from_iter(py, peaks.iter().map(|p| p.resolution_limited)))?;
    Ok(dict)
}

fn directions(py: Python<'_>, rows: Vec<[f64; 3]>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let n = rows.len();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([n, 3])
}
