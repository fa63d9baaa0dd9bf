//! A whole BSDF and its queries over arrays.

use std::collections::BTreeMap;
use std::ops::Range;
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

    /// An array of what `f` fills in for all pairs of directions, `K` numbers for each.
    fn over_pairs<'py, const K: usize>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: &Directions<'_>,
        exitant: &Directions<'_>,
        f: impl Fn(&Band, &[Direction], &[Direction], &mut [f64]) + Sync,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let band = self.band(band)?;
        let (mut i, mut o) = (Vectors::new(incident, "incident")?, Vectors::new(exitant, "exitant")?);
        same_length(i.len(), o.len())?;
        filled::<K>(py, i.len(), |chunk, values| {
            f(band, i.units(chunk.clone())?, o.units(chunk)?, values);
            Ok(())
        })
    }

    /// An array of what `f` fills in for all incident directions, `K` numbers for each.
    fn over_incident<'py, const K: usize>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: &Directions<'_>,
        f: impl Fn(&Band, &[Direction], &mut [f64]) + Sync,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let band = self.band(band)?;
        let mut i = Vectors::new(incident, "incident")?;
        filled::<K>(py, i.len(), |chunk, values| {
            f(band, i.units(chunk)?, values);
            Ok(())
        })
    }
}

/// An array of `K` numbers for each of n things, written chunk by chunk without the interpreter. NumPy allocates it: in huge pages, of
/// which a first touch costs less than of Rust's small ones.
fn filled<'py, const K: usize>(
    py: Python<'py>,
    n: usize,
    mut write: impl FnMut(Range<usize>, &mut [f64]) -> Result<(), String> + Send,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let array = PyArray1::zeros(py, n * K, false);
    {
        let mut array = array.readwrite();
        let values = array.as_slice_mut()?;
        py.detach(|| {
            chunks(n).try_for_each(|chunk| write(chunk.clone(), &mut values[K * chunk.start..K * chunk.end]))
        })
        .map_err(value_error)?;
    }
    Ok(array)
}

/// An array of n numbers as one of rows of `K`.
fn rows<'py, const K: usize>(array: Bound<'py, PyArray1<f64>>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let n = array.len()? / K;
    array.reshape([n, K])
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
        dict.set_item("geometry_unit", header.geometry.as_ref().map(|g| g.unit.file_name()))?;
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
        self.over_pairs::<1>(py, band, &incident, &exitant, Band::eval_many)
    }

    fn eval_xyz<'py>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: Directions<'py>,
        exitant: Directions<'py>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows::<3>(self.over_pairs::<3>(py, band, &incident, &exitant, |band, i, o, values| {
            band.eval_xyz_many(i, o, values.as_chunks_mut().0);
        })?)
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
        self.over_pairs::<1>(py, band, &incident, &exitant, |band, i, o, values| {
            band.pdf_many(i, o, lobes, values);
        })
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
        let n = i.len();
        let exitant = PyArray2::zeros(py, [n, 3], false);
        let [weight, pdf] = std::array::from_fn(|_| PyArray1::zeros(py, n, false));
        {
            let (mut exitant, mut weight, mut pdf) =
                (exitant.readwrite(), weight.readwrite(), pdf.readwrite());
            let directions = exitant.as_slice_mut()?.as_chunks_mut().0;
            let (weights, densities) = (weight.as_slice_mut()?, pdf.as_slice_mut()?);
            py.detach(|| {
                let mut samples = vec![Sample { exitant: [0.0; 3], pdf: 0.0, weight: 0.0 }; CHUNK.min(n)];
                chunks(n).try_for_each(|range| {
                    let samples = &mut samples[..range.len()];
                    let v = v.map(|v| &v[range.clone()]);
                    band.sample_many(i.units(range.clone())?, &u[range.clone()], v, lobes, samples);
                    for (k, sample) in range.zip(samples) {
                        (directions[k], weights[k], densities[k]) =
                            (sample.exitant, sample.weight, sample.pdf);
                    }
                    Ok(())
                })
            })
            .map_err(|problem: String| value_error(problem))?;
        }
        Ok((exitant, weight, pdf))
    }

    fn hemispherical<'py>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: Directions<'py>,
        part: &str,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let lobes = lobes(part)?;
        self.over_incident::<1>(py, band, &incident, |band, i, totals| {
            band.hemispherical_many(i, lobes, totals);
        })
    }

    /// NaN where there is no component.
    fn projected_solid_angle<'py>(
        &self,
        py: Python<'py>,
        band: &str,
        incident: Directions<'py>,
        exitant: Directions<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.over_pairs::<1>(py, band, &incident, &exitant, Band::projected_solid_angle_many)
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
        let range = |band: &Band, incident: &[Direction], ranges: &mut [f64]| {
            for (&i, range) in incident.iter().zip(ranges.as_chunks_mut().0) {
                *range = band.projected_solid_angle_range(i, lobes).unwrap_or([f64::NAN; 2]);
            }
        };
        rows::<2>(self.over_incident::<2>(py, band, &incident, range)?)
    }

    /// The Lambertian part of each component.
    fn lambertian(&self, py: Python<'_>, band: &str) -> PyResult<BTreeMap<&'static str, f64>> {
        let band = self.band(band)?;
        Ok(py.detach(|| band.components().map(|(part, c)| (part.key(), c.luminance.lambertian())).collect()))
    }
}
