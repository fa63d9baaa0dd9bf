//! The checks, as plain Python objects.

use bsdftree::Side;
use bsdftree::check::{Severity, Tolerance};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::bsdf::Bsdf;

/// One dictionary per band.
#[pyfunction]
pub fn check<'py>(
    py: Python<'py>,
    bsdf: &Bsdf,
    energy: f64,
    reciprocity: f64,
) -> PyResult<Bound<'py, PyList>> {
    let bands = py.detach(|| bsdftree::check::check(&bsdf.bsdf, Tolerance { energy, reciprocity }));
    let list = PyList::empty(py);
    for band in bands {
        let dict = PyDict::new(py);
        dict.set_item("band", &band.band)?;
        let energies = PyList::empty(py);
        for e in &band.energy {
            let entry = PyDict::new(py);
            entry.set_item("side", if e.side == Side::Front { "front" } else { "back" })?;
            entry.set_item("reflected", e.mean[0])?;
            entry.set_item("transmitted", e.mean[1])?;
            entry.set_item("max", e.max)?;
            entry.set_item("at", e.at.to_vec())?;
            energies.append(entry)?;
        }
        dict.set_item("energy", energies)?;
        let pairs = PyList::empty(py);
        for r in &band.reciprocity {
            let entry = PyDict::new(py);
            entry.set_item("part", if r.part.is_reflection() { r.part.key() } else { "transmission" })?;
            entry.set_item("mean", r.mean)?;
            entry.set_item("max", r.max)?;
            pairs.append(entry)?;
        }
        dict.set_item("reciprocity", pairs)?;
        let findings = PyList::empty(py);
        for f in &band.findings {
            let entry = PyDict::new(py);
            entry.set_item(
                "severity",
                if f.severity == Severity::Violation { "violation" } else { "warning" },
            )?;
            entry.set_item("message", &f.message)?;
            findings.append(entry)?;
        }
        dict.set_item("findings", findings)?;
        list.append(dict)?;
    }
    Ok(list)
}
