//! Measurements: read, made of arrays, looked into.

use std::path::PathBuf;
use std::sync::Arc;

use bsdftree::Direction;
use bsdftree::direction::{Side, normalized};
use bsdftree_fit::read::{self, Format, Grazing, Options, ReadError};
use bsdftree_fit::summary::Row;
use bsdftree_fit::{Scan, Symmetry, write};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Directions, Numbers, directions};
use crate::value_error;

/// What a goniophotometer measured.
#[pyclass(frozen, module = "bsdftree._core")]
pub struct Measurement(pub Arc<bsdftree_fit::Measurement>);

/// Incident, exitant (n, 3), values (n, channels), errors alike or nothing, source.
type ScanArrays<'py> =
    (Numbers<'py>, Directions<'py>, PyReadonlyArray2<'py, f64>, Option<PyReadonlyArray2<'py, f64>>, String);

/// The same, as it is handed out.
type ScanOut<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Option<Bound<'py, PyArray2<f64>>>,
    String,
);

#[pymethods]
impl Measurement {
    #[staticmethod]
    #[pyo3(signature = (paths, *, format, columns, side, grazing))]
    fn read(
        py: Python<'_>,
        paths: Vec<PathBuf>,
        format: Option<&str>,
        columns: Option<String>,
        side: &str,
        grazing: Option<f64>,
    ) -> PyResult<Measurement> {
        let format = format.map(format_of).transpose()?;
        // An angle, or infinity, which stands for the lowest incident direction.
        let grazing = grazing.map(|angle| match angle == f64::INFINITY {
            true => Grazing::LowestIncident,
            false => Grazing::Below(angle),
        });
        let options = Options { format, columns, side: side_of(side)?, grazing };
        let read = py.detach(|| read::read_files(&paths, &options)).map_err(read_error)?;
        Ok(Measurement(Arc::new(read)))
    }

    #[staticmethod]
    #[pyo3(signature = (scans, *, n_channels, name, manufacturer, symmetry, wavelength_nm, notes))]
    fn of_arrays(
        scans: Vec<ScanArrays<'_>>,
        n_channels: usize,
        name: Option<String>,
        manufacturer: Option<String>,
        symmetry: Option<&str>,
        wavelength_nm: Option<f64>,
        notes: Vec<String>,
    ) -> PyResult<Measurement> {
        let scans = scans.into_iter().enumerate();
        let measurement = bsdftree_fit::Measurement {
            n_channels,
            scans: scans.map(|(k, arrays)| scan_of(k, arrays)).collect::<PyResult<_>>()?,
            name,
            manufacturer,
            symmetry: symmetry.map(symmetry_of).transpose()?,
            wavelength_nm,
            notes,
        };
        measurement.verify().map_err(value_error)?;
        Ok(Measurement(Arc::new(measurement)))
    }

    #[getter]
    fn n_channels(&self) -> usize {
        self.0.n_channels
    }

    #[getter]
    fn name(&self) -> Option<&str> {
        self.0.name.as_deref()
    }

    #[getter]
    fn manufacturer(&self) -> Option<&str> {
        self.0.manufacturer.as_deref()
    }

    #[getter]
    fn symmetry(&self) -> Option<&'static str> {
        self.0.symmetry.map(Symmetry::name)
    }

    #[getter]
    fn wavelength_nm(&self) -> Option<f64> {
        self.0.wavelength_nm
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.0.notes.clone()
    }

    #[getter]
    fn parts(&self) -> Vec<&'static str> {
        self.0.parts().into_iter().map(bsdftree::Part::key).collect()
    }

    #[getter]
    fn scans<'py>(&self, py: Python<'py>) -> PyResult<Vec<ScanOut<'py>>> {
        self.0.scans.iter().map(|scan| arrays_of(py, scan, self.0.n_channels)).collect()
    }

    /// A dictionary for each part of each scan.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        py.detach(|| bsdftree_fit::summary::summary(&self.0)).iter().map(|row| summary_row(py, row)).collect()
    }

    /// Names and texts of files.
    fn to_pab_opto(&self) -> Vec<(String, String)> {
        write::pab_opto(&self.0).into_iter().map(|file| (file.name, file.text)).collect()
    }
}

fn summary_row<'py>(py: Python<'py>, row: &Row) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("scan", row.scan)?;
    dict.set_item("part", row.part.key())?;
    dict.set_item("incident_theta_deg", row.incident_deg[0])?;
    dict.set_item("incident_phi_deg", row.incident_deg[1])?;
    dict.set_item("n_points", row.n_points)?;
    dict.set_item("theta_range_deg", (row.theta_range_deg[0], row.theta_range_deg[1]))?;
    dict.set_item("azimuth_coverage_deg", row.azimuth_coverage_deg)?;
    dict.set_item("spacing_deg", (!row.spacing_deg.is_nan()).then_some(row.spacing_deg))?;
    dict.set_item("hole_deg", row.hole_deg)?;
    dict.set_item("value_range", (row.value_range[0], row.value_range[1]))?;
    dict.set_item("n_negative", row.n_negative)?;
    dict.set_item("relative_error", row.relative_error)?;
    dict.set_item("asymmetry", row.asymmetry)?;
    dict.set_item("total", row.total)?;
    Ok(dict)
}

fn scan_of(k: usize, (incident, exitant, values, errors, source): ScanArrays<'_>) -> PyResult<Scan> {
    let unit = |row: Direction, name: &str| {
        let found = || {
            value_error(format!(
                "scan {k}: {name} is {row:?}, which has no direction; expected a unit vector"
            ))
        };
        normalized(row).ok_or_else(found)
    };
    let incident: Direction = incident.as_slice()?.try_into().map_err(|_| {
        value_error(format!("scan {k}: incident has {} numbers; expected 3", incident.as_array().len()))
    })?;
    let exitant = directions(&exitant, "exitant")?;
    Ok(Scan {
        incident: unit(incident, "incident")?,
        exitant: exitant.iter().map(|&row| unit(row, "an exitant vector")).collect::<PyResult<_>>()?,
        values: values.as_array().iter().copied().collect(),
        errors: errors.map(|errors| errors.as_array().iter().copied().collect()).unwrap_or_default(),
        source,
    })
}

fn arrays_of<'py>(py: Python<'py>, scan: &Scan, n_channels: usize) -> PyResult<ScanOut<'py>> {
    let n = scan.exitant.len();
    let table = |numbers: Vec<f64>, columns: usize| PyArray1::from_vec(py, numbers).reshape([n, columns]);
    let errors = match scan.errors.is_empty() {
        true => None,
        false => Some(table(scan.errors.clone(), n_channels)?),
    };
    Ok((
        PyArray1::from_slice(py, &scan.incident),
        table(scan.exitant.as_flattened().to_vec(), 3)?,
        table(scan.values.clone(), n_channels)?,
        errors,
        scan.source.clone(),
    ))
}

fn read_error(error: ReadError) -> PyErr {
    // Python turns the number into FileNotFoundError and its like.
    match error.io().and_then(|io| Some((io.raw_os_error()?, io.kind()))) {
        Some((number, kind)) => {
            let path = error.path.as_ref().map(|path| path.display().to_string());
            PyOSError::new_err((number, kind.to_string(), path))
        }
        None => value_error(error),
    }
}

fn format_of(name: &str) -> PyResult<Format> {
    one_of("format", name, &Format::ALL, Format::name)
}

pub fn symmetry_of(name: &str) -> PyResult<Symmetry> {
    one_of("symmetry", name, &Symmetry::ALL, Symmetry::name)
}

fn side_of(name: &str) -> PyResult<Side> {
    one_of("side", name, &[Side::Front, Side::Back], |side| match side {
        Side::Front => "front",
        Side::Back => "back",
    })
}

/// What is called so, or an error that names all there are.
pub fn one_of<T: Copy>(what: &str, name: &str, all: &[T], name_of: fn(T) -> &'static str) -> PyResult<T> {
    all.iter().copied().find(|&one| name_of(one) == name).ok_or_else(|| {
        let names: Vec<String> = all.iter().map(|&one| format!("{:?}", name_of(one))).collect();
        value_error(format!("{what} {name:?}; expected one of {}", names.join(", ")))
    })
}
