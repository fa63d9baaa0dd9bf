//! A whole BSDF and its queries over arrays.

use std::collections::BTreeMap;
use std::path::PathBuf;

use bsdftree::binary::Packing;
use bsdftree::bsdf::LengthUnit;
use bsdftree::file;
use bsdftree::xml::{self, Strictness};
use bsdftree::{Band, Direction, Geometry, Header, Lobes, Part, Sample};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{CHUNK, Directions, Numbers, Vectors, chunks, same_length};
use crate::component;
use crate::value_error;

/// A BSDF.
#[pyclass(frozen, module = "bsdftree._core")]
pub struct Bsdf {
    pub bsdf: bsdftree::Bsdf,
    pub repairs: Vec<String>,
}

fn lobes(part: &str) -> PyResult<Lobes> {
    match part {
        "all" => Ok(Lobes::All),
        "reflection" => Ok(Lobes::Reflection),
        "transmission" => Ok(Lobes::Transmission),
        other => Err(PyValueError::new_err(format!(
            "part {other:?}; expected \"all\", \"reflection\" or \"transmission\""
        ))),
    }
}

impl Bsdf {
    /// The band of a name, or an error that lists the names.
    pub fn band(&self, name: &str) -> PyResult<&Band> {
        self.bsdf.band(name).ok_or_else(|| {
            let names: Vec<_> = self.bsdf.bands.iter().map(|b| b.name.as_str()).collect();
            PyValueError::new_err(format!("no band {name:?}; the file has {}", names.join(", ")))
        })
    }

    /// What `f` fills in for all pairs of directions, without the interpreter.
    fn over_pairs<T: Send + Clone + Default>(
        &self,
        py: Python<'_>,
        band: &str,
        incident: &Directions<'_>,
        exitant: &Directions<'_>,
        f: impl Fn(&Band, &[Direction], &[Direction], &mut [T]) + Sync,
    ) -> PyResult<Vec<T>> {
        let band = self.band(band)?;
        let (mut i, mut o) = (Vectors::new(incident, "incident")?, Vectors::new(exitant, "exitant")?);
        same_length(i.len(), o.len())?;
        let mut values = vec![T::default(); i.len()];
        let filled = py.detach(|| {
            chunks(i.len()).try_for_each(|chunk| {
                f(band, i.units(chunk.clone())?, o.units(chunk.clone())?, &mut values[chunk]);
                Ok(())
            })
        });
        filled.map(|()| values).map_err(|problem: String| value_error(problem))
    }

    /// What `f` fills in for all incident directions, without the interpreter.
    fn over_incident<T: Send + Clone + Default>(
        &self,
        py: Python<'_>,
        band: &str,
        incident: &Directions<'_>,
        f: impl Fn(&Band, &[Direction], &mut [T]) + Sync,
    ) -> PyResult<Vec<T>> {
        let band = self.band(band)?;
        let mut i = Vectors::new(incident, "incident")?;
        let mut values = vec![T::default(); i.len()];
        let filled = py.detach(|| {
            chunks(i.len()).try_for_each(|chunk| {
                f(band, i.units(chunk.clone())?, &mut values[chunk]);
                Ok(())
            })
        });
        filled.map(|()| values).map_err(|problem: String| value_error(problem))
    }
}

/// An array of (n, k) from its rows.
fn rows<'py, const K: usize>(py: Python<'py>, rows: Vec<[f64; K]>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let n = rows.len();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([n, K])
}

#[pymethods]
impl Bsdf {
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf, strict: bool) -> PyResult<Bsdf> {
        let strictness = if strict { Strictness::Strict } else { Strictness::Repair };
        py.detach(|| match file::read(&path, strictness) {
            Ok((bsdf, repairs)) => {
                Ok(Bsdf { bsdf, repairs: repairs.iter().map(ToString::to_string).collect() })
            }
            Err(error) => Err(match error.io().and_then(|e| Some((e.raw_os_error()?, e.kind()))) {
                // Python turns the number into FileNotFoundError and its like.
                Some((number, kind)) => {
                    PyOSError::new_err((number, kind.to_string(), path.display().to_string()))
                }
                None => PyValueError::new_err(error.to_string()),
            }),
        })
    }

    /// The XML text.
    fn to_xml(&self, py: Python<'_>) -> PyResult<String> {
        let mut text = Vec::new();
        py.detach(|| xml::write(&self.bsdf, &mut text)).map_err(|e| PyOSError::new_err(e.to_string()))?;
        String::from_utf8(text).map_err(|e| PyValueError::new_err(e.to_string()))
    }

    /// XML or `.bsdft` by the name's ending; the latter packed at a level, if there is one.
    fn write(&self, py: Python<'_>, path: PathBuf, level: Option<u8>) -> PyResult<()> {
        if level.is_some_and(|level| !(1..=22).contains(&level)) {
            return Err(PyValueError::new_err(format!("level is {}; expected 1 to 22", level.unwrap_or(0))));
        }
        if level.is_some() && !file::is_binary_name(&path) {
            let path = path.display();
            return Err(PyValueError::new_err(format!(
                "{path}: only files that end in .bsdft can be packed"
            )));
        }
        let packing = level.map_or(Packing::Raw, Packing::Packed);
        py.detach(|| file::write(&self.bsdf, &path, packing)).map_err(|e| PyOSError::new_err(e.to_string()))
    }

    /// Looks through values of a file that were not looked at when it was opened.
    fn verify(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.bsdf.verify()).map_err(value_error)
    }

    /// With ramps in the leaves of its trees.
    fn smooth(&self, py: Python<'_>) -> PyResult<Bsdf> {
        let bsdf = py.detach(|| self.bsdf.smooth()).ok_or_else(|| {
            PyValueError::new_err(
                "smooth() is for tensor trees, and there is none; convert matrices by to_tree() first",
            )
        })?;
        Ok(Bsdf { bsdf, repairs: self.repairs.clone() })
    }

    #[getter]
    fn is_smooth(&self) -> bool {
        self.bsdf.is_smooth()
    }

    #[getter]
    fn repairs(&self) -> Vec<String> {
        self.repairs.clone()
    }

    #[getter]
    fn bands(&self) -> Vec<String> {
        self.bsdf.bands.iter().map(|b| b.name.clone()).collect()
    }

    /// Name, manufacturer, lengths in metres and the rest of the header.
    #[getter]
    fn header<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyDict>> {
        let header = &self.bsdf.header;
        let dict = pyo3::types::PyDict::new(py);
        dict.set_item("name", &header.name)?;
        dict.set_item("manufacturer", &header.manufacturer)?;
        dict.set_item("width", header.width)?;
        dict.set_item("height", header.height)?;
        dict.set_item("thickness", header.thickness)?;
        dict.set_item("unit", header.unit.file_name())?;
        dict.set_item("geometry", header.geometry.as_ref().map(|g| g.mgf.as_str()))?;
        dict.set_item("provenance", &header.provenance)?;
        dict.set_item("properties", &header.properties)?;
        Ok(dict)
    }

    /// A copy with some of the header replaced; `size` is width, height and thickness \[m\], `geometry` MGF text (none if empty) and its unit.
    #[pyo3(signature = (name=None, manufacturer=None, unit=None, provenance=None, size=None, geometry=None, properties=None))]
    #[allow(clippy::too_many_arguments, reason = "the keyword arguments of one Python function")]
    fn with_header(
        &self,
        name: Option<String>,
        manufacturer: Option<String>,
        unit: Option<&str>,
        provenance: Option<Vec<String>>,
        size: Option<[Option<f64>; 3]>,
        geometry: Option<(String, String)>,
        properties: Option<Vec<(String, String)>>,
    ) -> PyResult<Bsdf> {
        let unit_of = |name: &str| {
            LengthUnit::from_name(name).ok_or_else(|| PyValueError::new_err(format!("no unit {name:?}")))
        };
        let mut bsdf = self.bsdf.clone();
        let header = &mut bsdf.header;
        header.name = name.unwrap_or_else(|| std::mem::take(&mut header.name));
        header.manufacturer = manufacturer.unwrap_or_else(|| std::mem::take(&mut header.manufacturer));
        header.provenance = provenance.unwrap_or_else(|| std::mem::take(&mut header.provenance));
        if let Some(unit) = unit {
            header.unit = unit_of(unit)?;
        }
        if let Some(size) = size {
            [header.width, header.height, header.thickness] = size;
        }
        if let Some((mgf, unit)) = geometry {
            let unit = unit_of(&unit)?;
            header.geometry = (!mgf.trim().is_empty()).then_some(Geometry { mgf, unit });
        }
        if let Some(properties) = properties {
            if let Some((name, _)) = properties.iter().find(|(name, _)| !Header::is_property(name)) {
                let message = format!("{name:?} cannot be a property of a material in the file");
                return Err(PyValueError::new_err(message));
            }
            header.properties = properties;
        }
        Ok(Bsdf { bsdf, repairs: self.repairs.clone() })
    }

    /// The functions of each component of a band: luminance, then chroma if there is colour.
    fn components<'py>(
        &self,
        py: Python<'py>,
        band: &str,
    ) -> PyResult<BTreeMap<&'static str, Vec<Bound<'py, PyAny>>>> {
        self.band(band)?
            .components()
            .map(|(part, component)| Ok((part.key(), component::functions(py, component)?)))
            .collect()
    }

    /// A BSDF of the band Visible: by component, luminance, or luminance and both chroma.
    #[staticmethod]
    fn of_components(components: BTreeMap<String, Vec<component::Function<'_>>>) -> PyResult<Bsdf> {
        let mut bsdf = bsdftree::Bsdf::default();
        for (key, functions) in components {
            let part = Part::ALL.into_iter().find(|p| p.key() == key).ok_or_else(|| {
                let keys: Vec<_> = Part::ALL.iter().map(|p| p.key()).collect();
                PyValueError::new_err(format!("no component {key:?}; expected one of {}", keys.join(", ")))
            })?;
            bsdf.band_mut("Visible").insert(part, component::component(&functions)?);
        }
        Ok(Bsdf { bsdf, repairs: Vec::new() })
    }

    fn eval<'py>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: Directions<'py>,
        exitant: Directions<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.over_pairs(py, band, &incident, &exitant, Band::eval_many)?))
    }

    fn eval_xyz<'py>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: Directions<'py>,
        exitant: Directions<'py>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.over_pairs(py, band, &incident, &exitant, Band::eval_xyz_many)?)
    }

    fn pdf<'py>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: Directions<'py>,
        exitant: Directions<'py>,
        part: &str,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let lobes = lobes(part)?;
        let values = self.over_pairs(py, band, &incident, &exitant, |band, i, o, values| {
            band.pdf_many(i, o, lobes, values);
        })?;
        Ok(PyArray1::from_vec(py, values))
    }

    #[pyo3(signature = (band, incident, u, v, part))]
    #[allow(clippy::type_complexity, reason = "three arrays side by side")]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: Directions<'py>,
        u: Numbers<'py>,
        v: Option<Numbers<'py>>,
        part: &str,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>)> {
        let (band, lobes) = (self.band(band)?, lobes(part)?);
        let (mut i, u) = (Vectors::new(&incident, "incident")?, u.as_slice()?);
        let v = v.as_ref().map(|v| v.as_slice()).transpose()?;
        same_length(i.len(), u.len())?;
        v.map_or(Ok(()), |v| same_length(i.len(), v.len()))?;
        let (mut exitant, mut weight, mut pdf) =
            (vec![[0.0; 3]; i.len()], vec![0.0; i.len()], vec![0.0; i.len()]);
        let filled = py.detach(|| {
            let mut samples = vec![Sample { exitant: [0.0; 3], pdf: 0.0, weight: 0.0 }; CHUNK.min(i.len())];
            chunks(i.len()).try_for_each(|range| {
                let samples = &mut samples[..range.len()];
                let v = v.map(|v| &v[range.clone()]);
                band.sample_many(i.units(range.clone())?, &u[range.clone()], v, lobes, samples);
                for (k, sample) in range.zip(samples) {
                    (exitant[k], weight[k], pdf[k]) = (sample.exitant, sample.weight, sample.pdf);
                }
                Ok(())
            })
        });
        filled.map_err(|problem: String| value_error(problem))?;
        Ok((rows(py, exitant)?, PyArray1::from_vec(py, weight), PyArray1::from_vec(py, pdf)))
    }

    fn hemispherical<'py>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: Directions<'py>,
        part: &str,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let lobes = lobes(part)?;
        let values = self.over_incident(py, band, &incident, |band, i, totals| {
            band.hemispherical_many(i, lobes, totals);
        })?;
        Ok(PyArray1::from_vec(py, values))
    }

    /// NaN where there is no component.
    fn projected_solid_angle<'py>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: Directions<'py>,
        exitant: Directions<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let angles = self.over_pairs(py, band, &incident, &exitant, Band::projected_solid_angle_many)?;
        Ok(PyArray1::from_vec(py, angles))
    }

    /// Smallest and largest, NaN where there is no component.
    fn projected_solid_angle_range<'py>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: Directions<'py>,
        part: &str,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let lobes = lobes(part)?;
        let range = |band: &Band, incident: &[Direction], ranges: &mut [[f64; 2]]| {
            for (&i, range) in incident.iter().zip(ranges) {
                *range = band.projected_solid_angle_range(i, lobes).unwrap_or([f64::NAN; 2]);
            }
        };
        rows(py, self.over_incident(py, band, &incident, range)?)
    }

    /// The Lambertian part of each component.
    fn lambertian(&self, py: Python<'_>, band: &str) -> PyResult<BTreeMap<&'static str, f64>> {
        let band = self.band(band)?;
        Ok(py.detach(|| band.components().map(|(part, c)| (part.key(), c.luminance.lambertian())).collect()))
    }
}
