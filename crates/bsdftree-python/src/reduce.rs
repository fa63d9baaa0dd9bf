//! Trees of grids, and trees with branches cut off.

use std::io::{self, Write};
use std::sync::Arc;

use bsdftree::binary::{self, Packing};
use bsdftree::reduce::{Goal, Loss, Noise, Norm, ReduceError};
use bsdftree::tree::{TreeError, grid};
use bsdftree::{Component, Rank, Scattering, xml};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::bsdf::Bsdf;
use crate::component::{Tree, rank};
use crate::value_error;

/// What a reduced tree may have lost.
#[pyclass(name = "Goal", module = "bsdftree._core", frozen)]
pub struct PyGoal(Goal);

#[pymethods]
impl PyGoal {
    #[new]
    #[pyo3(signature = (*, l1=None, rms=None, total=None, n_leaves=None, norm="l1", balance=None))]
    fn new(
        l1: Option<f64>,
        rms: Option<f64>,
        total: Option<f64>,
        n_leaves: Option<usize>,
        norm: &str,
        balance: Option<f64>,
    ) -> PyResult<PyGoal> {
        let norm = match norm {
            "l1" => Norm::L1,
            "rms" => Norm::Rms,
            other => {
                return Err(PyValueError::new_err(format!("norm {other:?}; expected \"l1\" or \"rms\"")));
            }
        };
        Ok(PyGoal(Goal { l1, rms, total, balance, n_leaves, norm }))
    }
}

/// Loss as Python takes it: relative L1, relative RMS, mean and worst error of totals, and where the worst is in the incident square.
type LossTuple = (f64, f64, f64, f64, [f64; 2]);

fn loss_tuple(loss: &Loss) -> LossTuple {
    (loss.l1, loss.rms, loss.mean_total, loss.worst_total, loss.worst_at)
}

/// A tree of a grid, reduced if anything says how far; what was lost by that; and what was mended, unless that is refused.
#[pyfunction]
pub fn tree_of_grid(
    py: Python<'_>,
    values: PyReadonlyArray1<'_, f32>,
    rank: usize,
    strict: bool,
    goal: &PyGoal,
) -> PyResult<(Tree, LossTuple, Option<String>)> {
    let (rank, values) = (self::rank(rank)?, values.as_slice()?);
    made_of(py, rank, values, strict, |values| match goal.0.is_empty() {
        true => Ok((bsdftree::Tree::from_grid(rank, values)?, Loss::default())),
        false => bsdftree::Tree::reduced_from_grid(rank, values, &goal.0),
    })
}

/// A tree of a grid without what noise explains, reduced if anything says how far; what was lost by that; and what was mended.
#[pyfunction]
pub fn tree_of_noisy_grid(
    py: Python<'_>,
    values: PyReadonlyArray1<'_, f32>,
    noise: PyReadonlyArray1<'_, f32>,
    is_counts: bool,
    rank: usize,
    strict: bool,
    goal: &PyGoal,
) -> PyResult<(Tree, LossTuple, Option<String>)> {
    let (rank, values, noise) = (self::rank(rank)?, values.as_slice()?, noise.as_slice()?);
    let noise = if is_counts { Noise::Counts(noise) } else { Noise::Variance(noise) };
    made_of(py, rank, values, strict, |values| bsdftree::Tree::from_noisy_grid(rank, values, noise, &goal.0))
}

/// What is made of a grid; if that is refused for bad values, what is made of it with those replaced, unless that is refused too.
fn made_of(
    py: Python<'_>,
    rank: Rank,
    values: &[f32],
    strict: bool,
    make: impl Fn(&[f32]) -> Result<(bsdftree::Tree, Loss), ReduceError> + Send + Sync,
) -> PyResult<(Tree, LossTuple, Option<String>)> {
    let made = py.detach(|| match make(values) {
        Err(ReduceError::Grid(TreeError::BadValues(bad))) if strict => Err(format!(
            "{bad}; strict=False takes negative ones as 0 and others as the mean of those around"
        )),
        Err(ReduceError::Grid(TreeError::BadValues(bad))) => {
            let mut values = values.to_vec();
            grid::mend(rank, &mut values).map_err(|e| e.to_string())?;
            let mended = format!("{bad}; negative ones taken as 0, others as the mean of those around");
            make(&values).map(|made| (made, Some(mended))).map_err(|e| e.to_string())
        }
        made => made.map(|made| (made, None)).map_err(|e| e.to_string()),
    });
    let ((tree, loss), mended) = made.map_err(value_error)?;
    Ok((Tree(Arc::new(tree)), loss_tuple(&loss), mended))
}

/// A tree reduced to bounds or to a number of leaves.
#[pyfunction]
pub fn reduced(py: Python<'_>, tree: &Tree, goal: &PyGoal) -> PyResult<Tree> {
    let (tree, _) = py.detach(|| tree.0.reduced(&goal.0)).map_err(value_error)?;
    Ok(Tree(Arc::new(tree)))
}

/// A BSDF whose trees are reduced.
#[pyfunction]
pub fn reduced_bsdf(py: Python<'_>, bsdf: &Bsdf, goal: &PyGoal) -> PyResult<Bsdf> {
    let reduced = py.detach(|| bsdf.bsdf.reduced(&goal.0)).map_err(value_error)?;
    Ok(Bsdf { bsdf: reduced, repairs: Vec::new() })
}

/// A BSDF whose trees are reduced so that it has at most so many leaves (of luminance), or bytes as a file.
#[pyfunction]
pub fn reduced_bsdf_to(py: Python<'_>, bsdf: &Bsdf, most: usize, of: &str, goal: &PyGoal) -> PyResult<Bsdf> {
    let size: fn(&bsdftree::Bsdf) -> usize = match of {
        "leaves" => n_leaves,
        "xml" => |bsdf| counted(|out| xml::write(bsdf, out).map_err(drop)),
        "bsdft" => |bsdf| counted(|out| binary::write(bsdf, Packing::Raw, out).map_err(drop)),
        "packed" => |bsdf| counted(|out| binary::write(bsdf, Packing::SMALL, out).map_err(drop)),
        other => {
            return Err(PyValueError::new_err(format!(
                "a size as {other:?}; expected \"xml\", \"bsdft\" or \"packed\""
            )));
        }
    };
    let reduced = py.detach(|| bsdf.bsdf.reduced_to(most, &goal.0, size)).map_err(|error| match error {
        ReduceError::Size { least, asked } => {
            let what = if of == "leaves" { of } else { "bytes" };
            value_error(format!("{least} {what} are the least there can be; {asked} were asked for"))
        }
        other => value_error(other),
    })?;
    Ok(Bsdf { bsdf: reduced, repairs: Vec::new() })
}

fn n_leaves(bsdf: &bsdftree::Bsdf) -> usize {
    let luminance = bsdf.bands.iter().flat_map(|band| band.components()).map(|(_, c)| &c.luminance);
    luminance.map(|f| if let Scattering::Tree(tree) = f { tree.arena().n_leaves() } else { 0 }).sum()
}

/// What is written to it is counted, and forgotten.
#[derive(Default)]
struct Counter(usize);

impl Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// How many bytes are written; more than fit anywhere if they cannot be.
fn counted(write: impl FnOnce(&mut Counter) -> Result<(), ()>) -> usize {
    let mut counter = Counter::default();
    write(&mut counter).map_or(usize::MAX, |()| counter.0)
}

/// All trees of a BSDF, luminance and chroma of each component of each band.
#[pyfunction]
pub fn all_trees(bsdf: &Bsdf) -> Vec<Tree> {
    let components = bsdf.bsdf.bands.iter().flat_map(|band| band.components());
    let functions = components.flat_map(|(_, component)| component.functions());
    let trees = functions.filter_map(|f| if let Scattering::Tree(tree) = f { Some(tree) } else { None });
    trees.map(|tree| Tree(Arc::clone(tree))).collect()
}

/// A BSDF with other trees, in the same order.
#[pyfunction]
pub fn with_trees(bsdf: &Bsdf, trees: Vec<PyRef<'_, Tree>>) -> PyResult<Bsdf> {
    let (mut bsdf, mut trees) = (bsdf.bsdf.clone(), trees.into_iter());
    for component in bsdf.bands.iter_mut().flat_map(|band| band.components_mut()) {
        let Component { luminance, chroma } = component;
        for function in std::iter::once(luminance).chain(chroma.iter_mut().flatten()) {
            if let Scattering::Tree(_) = function {
                let tree = trees.next().ok_or_else(|| value_error("fewer trees than the BSDF has"))?;
                *function = Scattering::Tree(Arc::clone(&tree.0));
            }
        }
    }
    Ok(Bsdf { bsdf, repairs: Vec::new() })
}

/// How far a tree is from the one that it is with branches cut off.
#[pyfunction]
pub fn loss(py: Python<'_>, whole: &Tree, reduced: &Tree) -> PyResult<LossTuple> {
    let loss = py.detach(|| whole.0.loss_of(&reduced.0)).map_err(value_error)?;
    Ok(loss_tuple(&loss))
}
