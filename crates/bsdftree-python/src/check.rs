//! The checks and repairs, as plain Python objects.

use std::path::PathBuf;

use bsdftree::check::{Finding, Kind, Place, Report, Severity, Tolerance};
use bsdftree::repair::repaired as mend;
use bsdftree::xml::{self, Strictness};
use bsdftree::{Direction, Side};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::bsdf::Bsdf;
use crate::convert::made;
use crate::value_error;

/// Findings of the header, and one dictionary per band.
#[pyfunction]
pub fn check<'py>(
    py: Python<'py>,
    bsdf: &Bsdf,
    energy: f64,
    reciprocity: f64,
    noise: f64,
) -> PyResult<(Bound<'py, PyList>, Bound<'py, PyList>)> {
    let report = py.detach(|| bsdftree::check::check(&bsdf.bsdf, Tolerance { energy, reciprocity, noise }));
    Ok((findings(py, &report.findings)?, bands(py, &report)?))
}

/// A copy with findings of some kinds mended, and what was done.
#[pyfunction]
pub fn repaired<'py>(
    py: Python<'py>,
    bsdf: &Bsdf,
    kinds: Vec<String>,
    energy: f64,
    reciprocity: f64,
    noise: f64,
) -> PyResult<(Bsdf, Bound<'py, PyList>)> {
    let kinds: Vec<Kind> = kinds
        .iter()
        .map(|name| {
            let found = Kind::ALL.into_iter().find(|kind| kind.name() == name);
            found.ok_or_else(|| {
                let known: Vec<_> = Kind::ALL.iter().map(|kind| kind.name()).collect();
                value_error(format!("no kind of finding {name:?}; expected some of {}", known.join(", ")))
            })
        })
        .collect::<PyResult<_>>()?;
    let tolerance = Tolerance { energy, reciprocity, noise };
    let (bsdf, done) = py.detach(|| mend(&bsdf.bsdf, &kinds, tolerance));
    let list = PyList::empty(py);
    for mended in done {
        let row = PyDict::new(py);
        row.set_item("kind", mended.kind.name())?;
        row.set_item("band", mended.band)?;
        row.set_item("part", mended.part.map(|part| part.key()))?;
        row.set_item("what", mended.what)?;
        row.set_item("measure", mended.measure)?;
        row.set_item("before", mended.before)?;
        row.set_item("after", mended.after)?;
        list.append(row)?;
    }
    Ok((made(bsdf), list))
}

/// What a reader had to mend in a file, as text; not what it only remarks upon.
#[pyfunction]
pub fn faults(py: Python<'_>, path: PathBuf) -> PyResult<Vec<String>> {
    let read = py.detach(|| bsdftree::file::read(&path, Strictness::Repair));
    let (_, repairs) = read.map_err(value_error)?;
    Ok(repairs.iter().filter(|r| r.severity == xml::Severity::Repair).map(ToString::to_string).collect())
}

fn bands<'py>(py: Python<'py>, report: &Report) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for band in &report.bands {
        let dict = PyDict::new(py);
        dict.set_item("band", &band.band)?;
        let rows = |rows: Vec<Bound<'py, PyDict>>| PyList::new(py, rows);
        let energy = band.energy.iter().map(|e| {
            let row = PyDict::new(py);
            row.set_item("side", if e.side == Side::Front { "front" } else { "back" })?;
            row.set_item("reflected", e.mean[0])?;
            row.set_item("transmitted", e.mean[1])?;
            row.set_item("max", e.max)?;
            row.set_item("at", e.at)?;
            row.set_item("over", e.over)?;
            Ok(row)
        });
        dict.set_item("energy", rows(energy.collect::<PyResult<_>>()?)?)?;
        let reciprocity = band.reciprocity.iter().map(|r| {
            let row = PyDict::new(py);
            row.set_item("part", if r.part.is_reflection() { r.part.key() } else { "transmission" })?;
            row.set_item("mean", r.mean)?;
            row.set_item("max", r.max)?;
            row.set_item("at", r.at)?;
            Ok(row)
        });
        dict.set_item("reciprocity", rows(reciprocity.collect::<PyResult<_>>()?)?)?;
        let symmetry = band.symmetry.iter().map(|s| {
            let row = PyDict::new(py);
            row.set_item("part", s.part.key())?;
            row.set_item("left_right", s.left_right)?;
            row.set_item("top_bottom", s.top_bottom)?;
            row.set_item("quarter_turn", s.quarter_turn)?;
            Ok(row)
        });
        dict.set_item("symmetry", rows(symmetry.collect::<PyResult<_>>()?)?)?;
        let noise = band.noise.iter().map(|n| {
            let row = PyDict::new(py);
            row.set_item("part", n.part.key())?;
            row.set_item("level", n.level)?;
            row.set_item("neighbours", n.neighbours)?;
            row.set_item("coverage", n.coverage)?;
            row.set_item("reversal", n.reversal)?;
            Ok(row)
        });
        dict.set_item("noise", rows(noise.collect::<PyResult<_>>()?)?)?;
        let gamut = band.gamut.iter().map(|g| {
            let row = PyDict::new(py);
            row.set_item("part", g.part.key())?;
            row.set_item("impossible", g.impossible)?;
            row.set_item("beyond_rgb", g.beyond_rgb)?;
            row.set_item("max", g.max)?;
            row.set_item("uv", g.uv)?;
            row.set_item("at", g.at)?;
            Ok(row)
        });
        dict.set_item("gamut", rows(gamut.collect::<PyResult<_>>()?)?)?;
        dict.set_item("findings", findings(py, &band.findings)?)?;
        list.append(dict)?;
    }
    Ok(list)
}

fn findings<'py>(py: Python<'py>, findings: &[Finding]) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for finding in findings {
        let row = PyDict::new(py);
        row.set_item("kind", finding.kind.name())?;
        let severity = match finding.severity {
            Severity::Violation => "violation",
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        row.set_item("severity", severity)?;
        row.set_item("part", finding.part.map(|part| part.key()))?;
        row.set_item("incident", finding.at.map(|Place { incident, .. }| incident))?;
        row.set_item("exitant", finding.at.and_then(|place| place.exitant).map(|d: Direction| d))?;
        row.set_item("amount", finding.amount)?;
        row.set_item("message", &finding.message)?;
        row.set_item("advice", finding.advice)?;
        row.set_item("repair", finding.repair.is_some())?;
        list.append(row)?;
    }
    Ok(list)
}
