//! Measurements fitted.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use bsdftree_fit::{Blend, Fit as Fitted, Frame, Options, Progress, Reciprocity, Score, Symmetry};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{Directions, directions};
use crate::bsdf::Bsdf;
use crate::component::rank;
use crate::convert::made;
use crate::measurement::{Measurement, one_of, symmetry_of};
use crate::value_error;

/// A measurement fitted.
#[pyclass(frozen, module = "bsdftree._core")]
pub struct Fit(Arc<Fitted>);

/// Frame, blend, whether the base stays, whether pairs are averaged with swapped pairs; mean and worst error.
type ScoreOut = (&'static str, &'static str, bool, bool, f64, f64);

type ReciprocityOut = (bool, usize, f64, f64);

fn score_out(score: &Score) -> ScoreOut {
    let blend = match score.recipe.blend {
        Blend::Spline => "spline",
        Blend::Linear => "linear",
    };
    (score.recipe.frame.name(), blend, score.recipe.split, score.recipe.reciprocal, score.l1, score.worst)
}

/// Fits a measurement.
#[pyfunction]
#[pyo3(signature = (measurement, *, symmetry, frame, reciprocal, progress))]
pub fn fit(
    py: Python<'_>,
    measurement: &Measurement,
    symmetry: Option<&str>,
    frame: Option<&str>,
    reciprocal: Option<bool>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Fit> {
    let options = Options {
        symmetry: symmetry.map(symmetry_of).transpose()?,
        frame: frame.map(|name| one_of("frame", name, &Frame::ALL, Frame::name)).transpose()?,
        reciprocal,
    };
    let measurement = Arc::clone(&measurement.0);
    let fitted = watched(py, &Progress::default(), progress, |p| Fitted::new(&measurement, &options, p))?;
    Ok(Fit(Arc::new(fitted.map_err(value_error)?)))
}

#[pymethods]
impl Fit {
    fn eval<'py>(
        &self,
        py: Python<'py>,
        incident: Directions<'_>,
        exitant: Directions<'_>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (i, o) = (directions(&incident, "incident")?, directions(&exitant, "exitant")?);
        let n = self.0.n_channels();
        let channels: Vec<Vec<f64>> =
            py.detach(|| (0..n).map(|channel| self.0.eval(channel, i, o)).collect());
        let rows = (0..i.len()).flat_map(|k| channels.iter().map(move |c| c[k])).collect();
        PyArray1::from_vec(py, rows).reshape([i.len(), n])
    }

    fn error<'py>(
        &self,
        py: Python<'py>,
        incident: Directions<'_>,
        exitant: Directions<'_>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (i, o) = (directions(&incident, "incident")?, directions(&exitant, "exitant")?);
        Ok(PyArray1::from_vec(py, py.detach(|| self.0.error(i, o))))
    }

    /// Trees; what is not given is chosen.
    #[pyo3(signature = (*, rank, log2_res, tolerance, progress))]
    fn bsdf(
        &self,
        py: Python<'_>,
        rank: Option<usize>,
        log2_res: Option<u32>,
        tolerance: Option<f64>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Bsdf> {
        let rank = rank.map(self::rank).transpose()?.unwrap_or(self.0.rank());
        let log2_res = log2_res.unwrap_or_else(|| self.0.log2_res(rank));
        let tolerance = tolerance.unwrap_or_else(|| self.0.tolerance());
        let shared = Progress::default();
        let bsdf = watched(py, &shared, progress, |p| self.0.bsdf(rank, log2_res, tolerance, p))?
            .map_err(value_error)?;
        Ok(made(bsdf))
    }

    /// Standard errors of trees that [`Fit::bsdf`] made.
    fn errors_of(&self, py: Python<'_>, bsdf: &Bsdf) -> PyResult<Bsdf> {
        Ok(made(py.detach(|| self.0.errors_of(&bsdf.bsdf)).map_err(value_error)?))
    }

    /// Name, reason, and cross-validated error of each symmetry that was tried.
    fn symmetry(&self) -> (&'static str, String, Vec<(&'static str, f64)>) {
        let found = &self.0.symmetry;
        (
            found.symmetry.name(),
            found.why.clone(),
            found.errors.iter().map(|&(s, e)| (Symmetry::name(s), e)).collect(),
        )
    }

    fn notes(&self) -> Vec<String> {
        self.0.notes.clone()
    }

    /// By part, best first.
    fn scores(&self) -> Vec<(&'static str, Vec<ScoreOut>)> {
        self.0.scores().map(|(part, scores)| (part.key(), scores.iter().map(score_out).collect())).collect()
    }

    /// By part: whether reciprocity holds, number of swapped pairs, their median difference, what is expected of it.
    fn reciprocity(&self) -> Vec<(&'static str, Option<ReciprocityOut>)> {
        let out = |r: Reciprocity| (r.holds, r.n_pairs, r.difference, r.expected);
        self.0.models.iter().map(|model| (model.part.key(), model.reciprocity.map(out))).collect()
    }

    /// Rank, resolution and tolerance that are chosen where none are given.
    fn chosen(&self) -> (usize, u32, f64) {
        let rank = self.0.rank();
        (rank.dimensions(), self.0.log2_res(rank), self.0.tolerance())
    }
}

/// Runs `work` on a thread of its own, tells `callback` (done, total) meanwhile, and stops it if that or Ctrl-C raises.
fn watched<T: Send>(
    py: Python<'_>,
    progress: &Progress,
    callback: Option<Bound<'_, PyAny>>,
    work: impl FnOnce(&Progress) -> T + Send,
) -> PyResult<T> {
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| work(progress));
        let mut raised = None;
        while !worker.is_finished() {
            py.detach(|| std::thread::sleep(Duration::from_millis(20)));
            let counts = || (progress.done.load(Ordering::Relaxed), progress.total.load(Ordering::Relaxed));
            let told = py.check_signals().and_then(|()| match &callback {
                Some(callback) => callback.call1(counts()).map(drop),
                None => Ok(()),
            });
            if let Err(error) = told {
                progress.stop.store(true, Ordering::Relaxed);
                raised = Some(error);
                break;
            }
        }
        let done = py.detach(|| worker.join()).unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        raised.map_or(Ok(done), Err)
    })
}
