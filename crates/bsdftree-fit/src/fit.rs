//! A measurement fitted: every part, and trees of all of them.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use bsdftree::convert::from_channels;
use bsdftree::direction::Direction;
use bsdftree::reduce::{Goal, ReduceError};
use bsdftree::tree::{Tree, TreeError};
use bsdftree::{Band, Bsdf, Component, Part, Rank, Scattering};
use thiserror::Error;

use crate::blend::Recipe;
use crate::choose::{self, Score};
use crate::frame::Frame;
use crate::in_plane;
use crate::measurement::{Measurement, Symmetry};
use crate::model::Model;
use crate::prepare::{self, Points};
use crate::progress::{Progress, Stopped};
use crate::symmetry::{self, SymmetryFound};

/// What is not left to the data.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// The sample's symmetry; if `None`, what the measurement states, or else what its scans show.
    pub symmetry: Option<Symmetry>,
    /// How lobes move with the incident direction; if `None`, what predicts scans best from the others.
    pub frame: Option<Frame>,
    /// Whether swapped pairs of directions count too; if `None`, where scans do not contradict it and it predicts left-out scans better.
    pub reciprocal: Option<bool>,
}

/// What cannot be fitted.
#[derive(Debug, Error)]
pub enum FitError {
    /// Nothing to fit.
    #[error("the measurement has no scans; expected one or more")]
    Empty,
    /// A scan with too few points.
    #[error(
        "{source_name}: {n} points on the side of {part}; expected {least} or more that do not lie on one line"
    )]
    TooFew {
        /// Of the scan.
        source_name: String,
        /// How many there are.
        n: usize,
        /// Fewest.
        least: usize,
        /// Which part.
        part: &'static str,
    },
    /// One plane of a sample that has no symmetry to turn it by.
    #[error(
        "{source_name}: all points lie in the plane of incidence, which says too little of a sample that is {symmetry}; if it is \
         isotropic, say so"
    )]
    InPlane {
        /// Of the scan.
        source_name: String,
        /// Of the sample.
        symmetry: &'static str,
    },
    /// Only zeros.
    #[error("{0} is black: no value above 0")]
    Black(&'static str),
    /// Lobes were to be followed, but there is only one.
    #[error("{0}: no scan has more than one lobe to follow; use another frame")]
    NoLobes(&'static str),
    /// Swapped pairs were asked for, but there are none.
    #[error(
        "{0}: swapped pairs of directions cannot be used: the light that goes back was not measured, or lobes are followed one by one; \
         leave the choice to the data, or use another frame"
    )]
    NotSwapped(&'static str),
    /// A resolution out of range.
    #[error("log2_res is {found}; expected 1 to {most} at rank {rank}")]
    Resolution {
        /// What was asked for.
        found: u32,
        /// Most at this rank.
        most: u32,
        /// 3 or 4.
        rank: usize,
    },
    /// Rank 3 of a sample that is not isotropic.
    #[error("a tree of rank 3 is isotropic, but the sample is {0}; use rank 4")]
    Rank(&'static str),
    /// A tree that cannot be.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// A tolerance that cannot be.
    #[error(transparent)]
    Reduce(#[from] ReduceError),
    /// Stopped from outside.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// A fitted measurement.
#[derive(Debug)]
pub struct Fit {
    /// One for each part.
    pub models: Vec<Model>,
    /// Which symmetry is used, and why.
    pub symmetry: SymmetryFound,
    /// What was assumed where nothing was measured, a sentence each.
    pub notes: Vec<String>,
    n_channels: usize,
}

impl Fit {
    /// Fits every part of a measurement. Steps are cross-validations: of one symmetry or recipe, for one part.
    ///
    /// # Errors
    /// If there is nothing to fit, or `progress` says stop.
    pub fn new(measurement: &Measurement, options: &Options, progress: &Progress) -> Result<Fit, FitError> {
        let parts = measurement.parts();
        if parts.is_empty() {
            return Err(FitError::Empty);
        }
        let points: Vec<Vec<Points>> =
            parts.iter().map(|&part| points(measurement, part)).collect::<Result<_, _>>()?;
        let mut tried: Vec<Recipe> = choose::recipes();
        tried.retain(|recipe| options.frame.is_none_or(|frame| recipe.frame == frame));
        let to_find = options.symmetry.or(measurement.symmetry).is_none();
        let steps = Model::n_steps(&tried) + if to_find { symmetry::N_STEPS } else { 0 };
        progress.total.store(parts.len() * steps, Ordering::Relaxed);
        let given = |symmetry, why: &str| SymmetryFound { symmetry, why: why.to_owned(), errors: Vec::new() };
        let symmetry = match (options.symmetry, measurement.symmetry) {
            (Some(symmetry), _) => given(symmetry, "given"),
            (None, Some(symmetry)) => given(symmetry, "as the file states"),
            (None, None) => symmetry::found(&points, progress)?,
        };
        let notes = notes(measurement, &points, symmetry.symmetry)?;
        let models = parts.into_iter().zip(points).map(|(part, points)| {
            let model =
                Model::new(points, part, symmetry.symmetry, &tried, measurement.n_channels, progress)?;
            model.ok_or(FitError::NoLobes(part.key()))
        });
        let mut models = models.collect::<Result<Vec<Model>, FitError>>()?;
        use_swapped(&mut models, options.reciprocal, progress)?;
        Ok(Fit { models, symmetry, notes, n_channels: measurement.n_channels })
    }

    /// Numbers for each pair of directions: 1, or 3 for X, Y, Z.
    pub fn n_channels(&self) -> usize {
        self.n_channels
    }

    /// BSDF \[1/sr\] of one channel for pairs of directions; 0 on sides that were not measured.
    pub fn eval(&self, channel: usize, incident: &[Direction], exitant: &[Direction]) -> Vec<f64> {
        self.sum(incident.len(), |model| model.eval(channel, incident, exitant))
    }

    /// Standard errors \[1/sr\] of the value, or of Y.
    pub fn error(&self, incident: &[Direction], exitant: &[Direction]) -> Vec<f64> {
        self.sum(incident.len(), |model| model.error(incident, exitant))
    }

    fn sum(&self, n: usize, f: impl Fn(&Model) -> Vec<f64>) -> Vec<f64> {
        let mut sum = vec![0.0; n];
        for model in &self.models {
            sum.iter_mut().zip(f(model)).for_each(|(sum, value)| *sum += value);
        }
        sum
    }

    /// 3 of an isotropic sample, 4 of others.
    pub fn rank(&self) -> Rank {
        if self.symmetry.symmetry == Symmetry::Isotropic { Rank::Three } else { Rank::Four }
    }

    /// Cells per axis, as a power of two, that show what was measured: a cell is about as wide as two pixels of the scans.
    pub fn log2_res(&self, rank: Rank) -> u32 {
        let finest = self.models.iter().map(Model::log2_pixels).max().unwrap_or(7);
        match rank {
            Rank::Three => finest - 1,
            Rank::Four => (finest - 2).min(6),
        }
    }

    /// Relative L1 error that trees may add: a fifth of that of the fit.
    pub fn tolerance(&self) -> f64 {
        let worst =
            self.models.iter().map(|m| m.scores[0].l1).filter(|l1| l1.is_finite()).fold(0.0, f64::max);
        (0.2 * worst).clamp(0.005, 0.05)
    }

    /// Makes trees, with as few leaves as the tolerance (relative L1) allows: one band.
    ///
    /// # Errors
    /// If rank or resolution do not suit, or `progress` says stop.
    pub fn bsdf(
        &self,
        rank: Rank,
        log2_res: u32,
        tolerance: f64,
        progress: &Progress,
    ) -> Result<Bsdf, FitError> {
        let most = if rank == Rank::Three { 9 } else { 7 };
        if !(1..=most).contains(&log2_res) {
            return Err(FitError::Resolution { found: log2_res, most, rank: rank.dimensions() });
        }
        if rank == Rank::Three && self.rank() == Rank::Four {
            return Err(FitError::Rank(self.symmetry.symmetry.name()));
        }
        let cells = crate::cells::Cells { rank, log2_res };
        progress.total.store(self.models.len() * self.n_channels * cells.n_incident(), Ordering::Relaxed);
        let mut band = Band::new("Visible");
        for model in &self.models {
            let others: Vec<&Model> = self
                .models
                .iter()
                .filter(|m| m.part != model.part && m.part.incident_side() == model.part.incident_side())
                .collect();
            let tree = |channel: usize| -> Result<Tree, FitError> {
                let tree = model.tree(channel, cells, &others, progress)?;
                let goal = Goal { l1: Some(tolerance), ..Goal::default() };
                Ok(if tolerance > 0.0 { tree.reduced(&goal)?.0 } else { tree })
            };
            let mut trees = (0..self.n_channels).map(tree).collect::<Result<Vec<Tree>, _>>()?;
            let component = match self.n_channels {
                1 => Component::grey(trees.remove(0).into()),
                _ => {
                    let [x, y, z] = <[Tree; 3]>::try_from(trees).expect("three channels");
                    from_channels([x.into(), y.into(), z.into()])?
                }
            };
            band.insert(model.part, component);
        }
        Ok(Bsdf { bands: vec![band], ..Bsdf::default() })
    }

    /// Trees that [`Fit::bsdf`] made with a standard error in place of each leaf's value \[1/sr\], of Y if there is colour.
    ///
    /// # Errors
    /// If trees cannot be built.
    pub fn errors_of(&self, bsdf: &Bsdf) -> Result<Bsdf, FitError> {
        let mut bands = Vec::new();
        for band in &bsdf.bands {
            let mut errors = Band::new(&band.name);
            for (part, component) in band.components() {
                let model = self.models.iter().find(|model| model.part == part);
                if let (Some(model), Scattering::Tree(tree)) = (model, &component.luminance) {
                    errors.insert(part, Component::grey(model.error_tree(tree)?.into()));
                }
            }
            bands.push(errors);
        }
        Ok(Bsdf { bands, ..Bsdf::default() })
    }

    /// Scores of all recipes by part.
    pub fn scores(&self) -> impl Iterator<Item = (Part, &[Score])> {
        self.models.iter().map(|model| (model.part, model.scores.as_slice()))
    }
}

/// Lets each part use swapped pairs of the part of the light that goes back, where that was measured.
fn use_swapped(models: &mut [Model], wanted: Option<bool>, progress: &Progress) -> Result<(), FitError> {
    let all: Vec<_> = models.iter().map(|model| (model.part, model.forward())).collect();
    for model in models {
        let part = Part::between(model.part.exitant_side(), model.part.incident_side());
        let of = all.iter().find(|(other, _)| *other == part);
        let is_used = match of {
            Some((_, of)) => model.use_swapped(Arc::clone(of), wanted, progress)?,
            None => false,
        };
        progress.count(1)?;
        if wanted == Some(true) && !is_used {
            return Err(FitError::NotSwapped(model.part.key()));
        }
    }
    Ok(())
}

/// What has to be assumed.
fn notes(
    measurement: &Measurement,
    parts: &[Vec<Points>],
    symmetry: Symmetry,
) -> Result<Vec<String>, FitError> {
    let scans = || parts.iter().flatten();
    let flat: Vec<&Points> =
        scans().filter(|scan| in_plane::is_in_plane(&prepare::turned((*scan).clone()))).collect();
    let mut notes = Vec::new();
    if let Some(first) = flat.first() {
        if symmetry != Symmetry::Isotropic {
            let source_name = measurement.scans[first.group].source.clone();
            return Err(FitError::InPlane { source_name, symmetry: symmetry.name() });
        }
        notes.push(format!(
            "{} of {} scans were measured in the plane of incidence alone: elsewhere the BSDF is assumed to depend on the angle from \
             the mirror direction, and to go evenly from what lies beyond it to what lies before it",
            flat.len(),
            scans().count()
        ));
    }
    Ok(notes)
}

/// The scans of a part, if they can be fitted.
fn points(measurement: &Measurement, part: Part) -> Result<Vec<Points>, FitError> {
    /// Triangles need three.
    const LEAST: usize = 3;
    let scans = prepare::points_of(measurement, part);
    for scan in &scans {
        if scan.exitant.len() < LEAST {
            return Err(FitError::TooFew {
                source_name: measurement.scans[scan.group].source.clone(),
                n: scan.exitant.len(),
                least: LEAST,
                part: part.key(),
            });
        }
    }
    if scans.iter().all(|s| s.values[measurement.n_channels / 2].iter().all(|&v| v <= 0.0)) {
        return Err(FitError::Black(part.key()));
    }
    Ok(scans)
}
