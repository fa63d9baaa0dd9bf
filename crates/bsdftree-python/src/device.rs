//! Devices: reading them, and what they say of themselves.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use bsdftree_device::options::MaterialMap;
use bsdftree_device::{ReadOptions, Unit, Up, parametric};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::value_error;

/// How files are read.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Reading {
    unit: String,
    search: Vec<PathBuf>,
    allow_commands: Vec<String>,
    materials: Vec<PathBuf>,
    material_names: BTreeMap<String, String>,
    default_material: Option<String>,
}

impl TryFrom<Reading> for ReadOptions {
    type Error = PyErr;

    fn try_from(reading: Reading) -> PyResult<ReadOptions> {
        Ok(ReadOptions {
            unit: Unit::from_str(&reading.unit).map_err(value_error)?,
            search: Some(reading.search),
            allowed_commands: reading.allow_commands,
            materials: MaterialMap {
                files: reading.materials,
                names: reading.material_names,
                default: reading.default_material,
            },
            ..ReadOptions::default()
        })
    }
}

fn unknown(kind: &str) -> PyErr {
    value_error(format!(
        "files of the kind {kind:?} are not read; expected \"scene\", \"rad\", \"mgf\" or \"xml\""
    ))
}

/// The device inside the one BSDF file.
fn read_bsdf(paths: &[PathBuf], options: ReadOptions) -> PyResult<bsdftree_device::Device> {
    let [path] = paths else {
        return Err(value_error(format!(
            "{} BSDF files; expected one, whose geometry is the device",
            paths.len()
        )));
    };
    let device = bsdftree_device::Device::read_bsdf_geometry(path, options).map_err(value_error)?;
    device.ok_or_else(|| value_error(format!("{}: the file holds no geometry of its device", path.display())))
}

/// Geometry and materials.
#[pyclass(frozen, module = "bsdftree")]
pub struct Device(pub Arc<bsdftree_device::Device>);

#[pymethods]
impl Device {
    /// Reads files of one kind, in their order.
    #[staticmethod]
    fn _read(py: Python<'_>, kind: &str, paths: Vec<PathBuf>, options: Reading) -> PyResult<Device> {
        let options = ReadOptions::try_from(options)?;
        let device = py.detach(|| match kind {
            "scene" => bsdftree_device::Device::read(&paths, options).map_err(value_error),
            "rad" => bsdftree_device::Device::read_rad(&paths, options).map_err(value_error),
            "mgf" => bsdftree_device::Device::read_mgf(&paths, options).map_err(value_error),
            "xml" => read_bsdf(&paths, options),
            _ => Err(unknown(kind)),
        })?;
        Ok(Device(Arc::new(device)))
    }

    /// Reads text of one kind; files that it names are looked for in `directory`.
    #[staticmethod]
    fn _parse(kind: &str, text: &str, directory: PathBuf, options: Reading) -> PyResult<Device> {
        let options = ReadOptions::try_from(options)?;
        let directory = Path::new(&directory);
        let device = match kind {
            "rad" => bsdftree_device::Device::parse_rad(text, "text", directory, options),
            "mgf" => bsdftree_device::Device::parse_mgf(text, "text", directory, options),
            _ => return Err(unknown(kind)),
        };
        Ok(Device(Arc::new(device.map_err(value_error)?)))
    }

    #[staticmethod]
    fn _from_spec(spec: &str) -> PyResult<Device> {
        Ok(Device(Arc::new(bsdftree_device::Device::from_spec(spec).map_err(value_error)?)))
    }

    /// The same device of the materials that files define under the names of its own.
    fn _with_materials(&self, py: Python<'_>, paths: Vec<PathBuf>, options: Reading) -> PyResult<Device> {
        let options = ReadOptions::try_from(options)?;
        let device = py.detach(|| self.0.with_materials(&paths, options)).map_err(value_error)?;
        Ok(Device(Arc::new(device)))
    }

    fn _turned_up(&self, up: &str) -> PyResult<Device> {
        Ok(Device(Arc::new(self.0.turned_up(Up::from_str(up).map_err(value_error)?))))
    }

    /// The device as a Radiance scene in metres.
    fn to_rad(&self) -> String {
        self.0.to_rad()
    }

    /// The device as MGF in a unit of length, and what that does not say.
    fn to_mgf(&self, unit: &str) -> PyResult<(String, Vec<String>)> {
        let mgf = self.0.to_mgf(Unit::from_str(unit).map_err(value_error)?);
        Ok((mgf.text, mgf.losses))
    }

    #[getter]
    fn n_surfaces(&self) -> usize {
        self.0.surfaces.len()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings.clone()
    }

    /// Corners of one period \[m\], or None if the device is not known to be periodic.
    #[getter]
    fn tile(&self) -> Option<[[f64; 3]; 2]> {
        self.0.tile.map(|b| b.map(|p| p.to_array()))
    }

    /// Corners of the bounding box \[m\], or None for an empty device.
    #[getter]
    fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        self.0.bounds().map(|b| b.map(|p| p.to_array()))
    }

    fn __repr__(&self) -> String {
        format!("<Device of {} surfaces>", self.0.surfaces.len())
    }
}

/// The parametric devices: name, summary, drawing, and name, unit, default, range, meaning of each parameter.
#[pyfunction]
pub fn device_families(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    parametric::families()
        .iter()
        .map(|family| {
            let dict = PyDict::new(py);
            dict.set_item("name", family.name)?;
            dict.set_item("summary", family.summary)?;
            dict.set_item("drawing", family.drawing)?;
            let parameters: Vec<_> = family
                .parameters
                .iter()
                .map(|p| (p.name, p.unit, p.default_text(), p.range_text(), p.meaning))
                .collect();
            dict.set_item("parameters", parameters)?;
            Ok(dict)
        })
        .collect()
}
