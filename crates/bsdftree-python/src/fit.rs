//! Measurements fitted, arrays in and out.

use bsdftree::Part;
use bsdftree_fit::{Blend, Frame, Measurement, Model as Fitted, Recipe, Scan, Symmetry};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{Directions, directions};
use crate::value_error;

type ScanArrays<'py> = ([f64; 3], PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, f64>);

/// One part fitted.
#[pyclass(frozen, module = "bsdftree._core")]
pub struct Model(Fitted);

fn frame_name(recipe: Recipe) -> (String, bool, bool, bool) {
    (recipe.frame.name().to_owned(), recipe.blend == Blend::Spline, recipe.split, recipe.reciprocal)
}

#[pymethods]
impl Model {
    #[new]
    #[pyo3(signature = (scans, part, symmetry, tried=Vec::new()))]
    fn new(scans: Vec<ScanArrays<'_>>, part: &str, symmetry: &str, tried: Vec<(String, bool, bool, bool)>) -> PyResult<Model> {
        let part = Part::ALL.into_iter().find(|p| p.key() == part).ok_or_else(|| value_error("no such part"))?;
        let symmetry = match symmetry {
            "isotropic" => Symmetry::Isotropic,
            "quadrilateral" => Symmetry::Quadrilateral,
            "x" => Symmetry::BilateralX,
            "y" => Symmetry::BilateralY,
            _ => Symmetry::Anisotropic,
        };
        let mut measurement = Measurement { n_channels: 1, ..Measurement::default() };
        for (incident, exitant, values) in &scans {
            measurement.scans.push(Scan {
                incident: *incident,
                exitant: directions(exitant, "exitant")?.to_vec(),
                values: values.as_slice()?.to_vec(),
                ..Scan::default()
            });
        }
        let recipe = |(frame, spline, split, reciprocal): (String, bool, bool, bool)| Recipe {
            frame: Frame::ALL.into_iter().find(|f| f.name() == frame).unwrap_or(Frame::Fixed),
            blend: if spline { Blend::Spline } else { Blend::Linear },
            split,
            reciprocal,
        };
        let tried: Vec<Recipe> = tried.into_iter().map(recipe).collect();
        Ok(Model(Fitted::new(&measurement, part, symmetry, &tried)))
    }

    fn eval<'py>(
        &self,
        py: Python<'py>,
        incident: Directions<'_>,
        exitant: Directions<'_>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (incident, exitant) = (directions(&incident, "incident")?, directions(&exitant, "exitant")?);
        let values = py.detach(|| self.0.eval(0, incident, exitant));
        Ok(PyArray1::from_vec(py, values))
    }

    fn scores(&self) -> Vec<((String, bool, bool, bool), f64, f64)> {
        self.0.scores.iter().map(|s| (frame_name(s.recipe), s.l1, s.worst)).collect()
    }
}
