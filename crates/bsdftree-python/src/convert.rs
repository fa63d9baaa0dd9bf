//! One kind of BSDF from another.

use std::sync::Arc;

use bsdftree::Part;
use bsdftree::convert::{Mirror, StackDomain, TreeOptions, default_domain};
use numpy::PyArray3;
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

/// Turned about the normal by an azimuth \[degree\].
#[pyfunction]
pub fn turned(py: Python<'_>, bsdf: &Bsdf, azimuth_deg: f64) -> PyResult<Bsdf> {
    py.detach(|| bsdf.bsdf.turned(azimuth_deg.to_radians())).map(made).map_err(value_error)
}

/// Mirrored in x or y.
#[pyfunction]
pub fn mirrored(py: Python<'_>, bsdf: &Bsdf, axis: &str) -> PyResult<Bsdf> {
    let mirror = match axis {
        "x" => Mirror::X,
        "y" => Mirror::Y,
        other => return Err(value_error(format!("axis {other:?}; expected \"x\" or \"y\""))),
    };
    Ok(made(py.detach(|| bsdf.bsdf.mirrored(mirror))))
}

/// Turned round.
#[pyfunction]
pub fn flipped(py: Python<'_>, bsdf: &Bsdf) -> Bsdf {
    made(py.detach(|| bsdf.bsdf.flipped()))
}

/// Some components and bands; one band may get another name.
#[pyfunction]
pub fn chosen(
    bsdf: &Bsdf,
    components: Option<Vec<String>>,
    bands: Option<Vec<String>>,
    renamed: Option<(String, String)>,
) -> PyResult<Bsdf> {
    let mut result = bsdftree::Bsdf { header: bsdf.bsdf.header.clone(), bands: Vec::new() };
    let names: Vec<String> = match bands {
        Some(names) => names,
        None => bsdf.bsdf.bands.iter().map(|band| band.name.clone()).collect(),
    };
    for name in names {
        let band = bsdf.band(&name)?;
        let name = match &renamed {
            Some((from, to)) if from.eq_ignore_ascii_case(&band.name) => to,
            _ => &band.name,
        };
        for part in Part::ALL {
            let is_chosen = components.as_ref().is_none_or(|keys| keys.iter().any(|key| key == part.key()));
            if let (true, Some(component)) = (is_chosen, band.component(part)) {
                result.band_mut(name).insert(part, component.clone());
            }
        }
    }
    Ok(made(result))
}

/// All that is in several, and remarks.
#[pyfunction]
pub fn merge(parts: Vec<PyRef<'_, Bsdf>>) -> PyResult<(Bsdf, Vec<String>)> {
    let parts: Vec<&bsdftree::Bsdf> = parts.iter().map(|part| &part.bsdf).collect();
    let (bsdf, remarks) = bsdftree::convert::merge(&parts).map_err(value_error)?;
    Ok((made(bsdf), remarks))
}

/// Layers from the outside to the room, over a basis, over trees, or over what suits them.
#[pyfunction]
pub fn stack(
    py: Python<'_>,
    layers: Vec<PyRef<'_, Bsdf>>,
    klems: Option<Klems>,
    subdivide: u32,
    log2_res: Option<u32>,
    tolerance: f64,
) -> PyResult<Bsdf> {
    let layers: Vec<&bsdftree::Bsdf> = layers.iter().map(|layer| &layer.bsdf).collect();
    let domain = domain_of(&layers, klems, subdivide, log2_res, tolerance)?;
    py.detach(|| bsdftree::convert::stack(&layers, &domain)).map(made).map_err(value_error)
}

/// Of light from each incident cell, what each layer of a stack absorbs: (layers, sides, cells).
#[pyfunction]
pub fn layer_absorptances<'py>(
    py: Python<'py>,
    layers: Vec<PyRef<'_, Bsdf>>,
    band: &str,
    klems: Option<Klems>,
    subdivide: u32,
    log2_res: Option<u32>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let layers: Vec<&bsdftree::Bsdf> = layers.iter().map(|layer| &layer.bsdf).collect();
    let domain = domain_of(&layers, klems, subdivide, log2_res, 0.0)?;
    let found =
        py.detach(|| bsdftree::convert::layer_absorptances(&layers, band, &domain)).map_err(value_error)?;
    let nested: Vec<Vec<Vec<f64>>> = found.into_iter().map(|a| vec![a.front, a.back]).collect();
    PyArray3::from_vec3(py, &nested).map_err(value_error)
}

fn domain_of(
    layers: &[&bsdftree::Bsdf],
    klems: Option<Klems>,
    subdivide: u32,
    log2_res: Option<u32>,
    tolerance: f64,
) -> PyResult<StackDomain> {
    Ok(match (klems, log2_res) {
        (Some(_), Some(_)) => {
            return Err(value_error("a Klems basis and a resolution of trees; expected one of them"));
        }
        (Some(klems), None) => StackDomain::Klems(Arc::new(klems_basis(klems, subdivide)?)),
        (None, Some(log2_res)) => StackDomain::Tree { log2_res, tolerance },
        (None, None) => match default_domain(layers) {
            StackDomain::Tree { log2_res, .. } => StackDomain::Tree { log2_res, tolerance },
            klems => klems,
        },
    })
}
