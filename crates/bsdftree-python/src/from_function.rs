//! Trees from functions: of Python, and of Radiance's function language.

use std::path::PathBuf;

use bsdftree::color::xyz_from_rgb;
use bsdftree::convert::{FunctionError, TreeOptions};
use bsdftree::{Direction, Part};
use bsdftree_device::cal::{CalError, Context, Function, Scratch};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::bsdf::Bsdf;
use crate::component::rank;
use crate::convert::made;
use crate::value_error;

/// The parts of these names.
fn parts(names: &[String]) -> PyResult<Vec<Part>> {
    let find = |name: &String| {
        Part::ALL.into_iter().find(|part| part.key() == name).ok_or_else(|| {
            let keys: Vec<_> = Part::ALL.iter().map(|part| part.key()).collect();
            PyValueError::new_err(format!("no component {name:?}; expected one of {}", keys.join(", ")))
        })
    };
    names.iter().map(find).collect()
}

fn py_error<E: Into<PyErr>>(error: FunctionError<E>) -> PyErr {
    match error {
        FunctionError::Convert(error) => value_error(error),
        FunctionError::Function(error) => error.into(),
        FunctionError::Value { incident, exitant, value } => PyValueError::new_err(format!(
            "the function is {value} for light from {incident:?} to {exitant:?}; expected a finite number >= 0 [1/sr]"
        )),
    }
}

/// Of a callable of two (n, 3) arrays that gives (n,), or with colour (n, 3): X, Y, Z.
#[pyfunction]
pub fn from_callable(
    py: Python<'_>,
    function: Bound<'_, PyAny>,
    rank: usize,
    log2_res: u32,
    tolerance: f64,
    components: Vec<String>,
    color: bool,
) -> PyResult<Bsdf> {
    let options = TreeOptions { rank: self::rank(rank)?, log2_res, tolerance };
    let rows = |directions: &[Direction]| {
        PyArray1::from_slice(py, directions.as_flattened()).reshape([directions.len(), 3])
    };
    let call = |incident: &[Direction], exitant: &[Direction], values: &mut [f64]| -> PyResult<()> {
        let result = function.call1((rows(incident)?, rows(exitant)?))?;
        let result: PyReadonlyArrayDyn<'_, f64> = result
            .extract()
            .map_err(|_| PyValueError::new_err("the function gives no array of numbers of type float64"))?;
        let array = result.as_array();
        let n = incident.len();
        let fits = if color { array.shape() == [n, 3] } else { array.shape() == [n] };
        if !fits {
            let shape = if color { format!("({n}, 3)") } else { format!("({n},)") };
            return Err(PyValueError::new_err(format!(
                "the function gives an array of shape {:?} for {n} pairs of directions; expected {shape}",
                array.shape()
            )));
        }
        values.iter_mut().zip(array.iter()).for_each(|(value, &v)| *value = v);
        Ok(())
    };
    bsdftree::Bsdf::from_function(call, &parts(&components)?, color, &options).map(made).map_err(py_error)
}

/// Of a function of six numbers, or three of them for red, green and blue, after files and definitions of Radiance's function language.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the keyword arguments of one Python function")]
pub fn from_cal(
    py: Python<'_>,
    names: Vec<String>,
    files: Vec<PathBuf>,
    definitions: Vec<String>,
    rank: usize,
    log2_res: u32,
    tolerance: f64,
    components: Vec<String>,
) -> PyResult<Bsdf> {
    let options = TreeOptions { rank: self::rank(rank)?, log2_res, tolerance };
    let parts = parts(&components)?;
    let mut context = Context::new();
    context.define("PI : 3.14159265358979323846;").map_err(value_error)?;
    for path in &files {
        let text = std::fs::read(path).map_err(|e| {
            PyOSError::new_err((e.raw_os_error(), e.kind().to_string(), path.display().to_string()))
        })?;
        let name = path.display().to_string();
        context.load(&String::from_utf8_lossy(&text), &name).map_err(value_error)?;
    }
    definitions.iter().try_for_each(|text| context.define(text).map_err(value_error))?;
    let functions: Vec<Function> =
        names.iter().map(|name| context.function(name, 6).map_err(value_error)).collect::<PyResult<_>>()?;
    let color = match functions.len() {
        1 => false,
        3 => true,
        n => {
            return Err(PyValueError::new_err(format!(
                "{n} functions; expected one, or red, green and blue"
            )));
        }
    };
    let call = |incident: &[Direction], exitant: &[Direction], values: &mut [f64]| {
        evaluate(&functions, incident, exitant, values)
    };
    let result = py.detach(|| bsdftree::Bsdf::from_function(call, &parts, color, &options));
    result.map(made).map_err(|error| match error {
        FunctionError::Function(error) => value_error(error),
        FunctionError::Convert(error) => value_error(error),
        FunctionError::Value { incident, exitant, value } => {
            py_error(FunctionError::<PyErr>::Value { incident, exitant, value })
        }
    })
}

/// All pairs, by all threads.
fn evaluate(
    functions: &[Function],
    incident: &[Direction],
    exitant: &[Direction],
    values: &mut [f64],
) -> Result<(), CalError> {
    const CHUNK: usize = 1024;
    let n = functions.len();
    let pairs = incident.par_chunks(CHUNK).zip(exitant.par_chunks(CHUNK));
    values.par_chunks_mut(CHUNK * n).zip(pairs).try_for_each_init(
        Scratch::default,
        |scratch, (values, (from, to))| {
            for (k, values) in values.chunks_exact_mut(n).enumerate() {
                let ([a, b, c], [d, e, f]) = (from[k], to[k]);
                for (value, function) in values.iter_mut().zip(functions) {
                    *value = function.call_in(&[a, b, c, d, e, f], &(), scratch)?;
                }
                if let [r, g, b] = *values {
                    values.copy_from_slice(&xyz_from_rgb([r, g, b]));
                }
            }
            Ok(())
        },
    )
}
