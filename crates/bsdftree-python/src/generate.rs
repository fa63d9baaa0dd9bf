//! Generation on threads of its own so that Python can show progress and stop it.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use bsdftree::bsdf::LengthUnit;
use bsdftree_generate::{
    Aperture, Band, GenerateError, Generated, Options, Progress, Sides, Stop, generate_bands,
};
use numpy::PyArray1;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::bsdf::Bsdf;
use crate::device::Device;
use crate::layout::{self, Klems};
use crate::value_error;

type Outcome = Result<Generated, GenerateError>;

/// A generation that runs.
#[pyclass(frozen, module = "bsdftree._core")]
pub struct Generation {
    progress: Arc<Progress>,
    thread: Mutex<Option<JoinHandle<Outcome>>>,
}

/// Starts a generation; `aperture` is in `unit`, `own` are devices of bands with materials of their own. Of `klems` and (`rank`, `log2_res`) exactly one is given.
#[pyfunction]
#[pyo3(signature = (device, *, rank, log2_res, klems, subdivide, samples, tolerance, direction_tolerance, detail, time_budget, stratified, sides, color, reciprocity, reuse, pruned, aperture, tile, unit, seed, threads, checkpoint, geometry=false, bands=None, own=Vec::new()))]
#[allow(clippy::too_many_arguments, reason = "the keyword arguments of one Python function")]
pub fn generate(
    device: &Device,
    rank: usize,
    log2_res: u32,
    klems: Option<Klems>,
    subdivide: u32,
    samples: u64,
    tolerance: Option<f64>,
    direction_tolerance: f64,
    detail: Option<f64>,
    time_budget: Option<f64>,
    stratified: bool,
    sides: &str,
    color: bool,
    reciprocity: Option<bool>,
    reuse: bool,
    pruned: bool,
    aperture: Option<[[f64; 3]; 2]>,
    tile: bool,
    unit: &str,
    seed: u64,
    threads: Option<usize>,
    checkpoint: Option<PathBuf>,
    geometry: bool,
    bands: Option<Vec<String>>,
    own: Vec<(String, PyRef<'_, Device>)>,
) -> PyResult<Generation> {
    let layout = layout::layout(rank, log2_res, klems, subdivide)?;
    let sides = match sides {
        "front" => Sides::Front,
        "back" => Sides::Back,
        "both" => Sides::Both,
        other => {
            return Err(value_error(format!("sides {other:?}; expected \"front\", \"back\" or \"both\"")));
        }
    };
    let unit = LengthUnit::from_name(unit).ok_or_else(|| value_error(format!("no unit {unit:?}")))?;
    let aperture = aperture.map(|corners| {
        let [min, max] = corners.map(|corner| corner.map(|length| length * unit.meters()));
        Aperture { min, max }
    });
    let bands = match bands {
        None => vec![Band::visible()],
        Some(names) => {
            names.iter().map(|name| name.parse()).collect::<Result<_, _>>().map_err(value_error)?
        }
    };
    let own = own.iter().map(|(name, device)| {
        Ok((Band::named(name).map_err(value_error)?, bsdftree_device::Device::clone(&device.0)))
    });
    let own = own.collect::<PyResult<Vec<_>>>()?;
    let time_budget = time_budget.map(Duration::try_from_secs_f64).transpose().map_err(value_error)?;
    let options = Options {
        layout,
        samples,
        tolerance,
        direction_tolerance,
        detail,
        time_budget,
        stratified,
        sides,
        color,
        bands,
        own_band: false,
        reciprocity,
        reuse,
        pruned,
        aperture,
        tile,
        unit,
        seed,
        threads,
        checkpoint,
        geometry,
    };
    let progress = Arc::new(Progress::default());
    let (device, shared) = (Arc::clone(&device.0), Arc::clone(&progress));
    let thread = std::thread::spawn(move || generate_bands(&device, &own, &options, &shared));
    Ok(Generation { progress, thread: Mutex::new(Some(thread)) })
}

#[pymethods]
impl Generation {
    /// Paths done and paths to do.
    fn paths(&self) -> (u64, u64) {
        self.progress.paths()
    }

    /// Samples that a checkpoint had, samples at the end of the round that was interrupted, the share of that round that it had, and
    /// bytes of it that were not whole. None until that is known, and if there was nothing to go on from.
    fn resumed(&self) -> Option<(u64, u64, f64, u64)> {
        self.progress.resumed().map(|from| (from.samples, from.round_end, from.share, from.n_dropped))
    }

    /// Stops it soon.
    fn cancel(&self) {
        self.progress.cancel();
    }

    /// Waits at most this long \[s\]; whether it has ended.
    fn wait(&self, py: Python<'_>, seconds: f64) -> bool {
        const STEP: Duration = Duration::from_millis(5);
        py.detach(|| {
            let end = std::time::Instant::now() + Duration::from_secs_f64(seconds.clamp(0.0, 3600.0));
            loop {
                let ended = {
                    let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner);
                    thread.as_ref().is_none_or(JoinHandle::is_finished)
                };
                if ended || std::time::Instant::now() >= end {
                    return ended;
                }
                std::thread::sleep(STEP);
            }
        })
    }

    /// The BSDF, its standard errors and what was done; once.
    fn result<'py>(&self, py: Python<'py>) -> PyResult<(Bsdf, Bsdf, Bound<'py, PyDict>)> {
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        let thread = thread.ok_or_else(|| PyRuntimeError::new_err("the result was taken already"))?;
        let outcome = py
            .detach(|| thread.join())
            .map_err(|_| PyRuntimeError::new_err("generation failed on its thread"))?;
        let Generated { bsdf, errors, report } = outcome.map_err(value_error)?;
        let dict = PyDict::new(py);
        dict.set_item("paths", report.paths)?;
        dict.set_item("samples", report.samples)?;
        let stop = match report.stop {
            Stop::Samples => "samples",
            Stop::Tolerance => "tolerance",
            Stop::Time => "time",
            Stop::Memory => "memory",
        };
        dict.set_item("stop", stop)?;
        dict.set_item("error", report.error)?;
        dict.set_item("direction_error", report.direction_error)?;
        let bands = report.bands.into_iter().map(|band| {
            let totals = band.totals.into_iter().map(|totals| {
                let arrays = [totals.values, totals.errors].map(|v| PyArray1::from_vec(py, v));
                (totals.part.key(), arrays)
            });
            (band.name, band.error, band.direction_error, totals.collect::<Vec<_>>())
        });
        dict.set_item("bands", bands.collect::<Vec<_>>())?;
        dict.set_item("lost", report.lost)?;
        dict.set_item("tracing_seconds", report.tracing.as_secs_f64())?;
        dict.set_item("reducing_seconds", report.reducing.as_secs_f64())?;
        let [min, max] = [report.aperture.min, report.aperture.max].map(|[x, y, z]| (x, y, z));
        dict.set_item("aperture", (min, max))?;
        dict.set_item("warnings", report.warnings)?;
        let [bsdf, errors] = [bsdf, errors].map(|bsdf| Bsdf { bsdf, repairs: Vec::new() });
        Ok((bsdf, errors, dict))
    }
}
