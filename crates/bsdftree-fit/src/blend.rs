//! Scans blended between incident directions: logarithms of values along a [`Frame`], with the weights of [`Incidence`].
//!
//! f(i,o) = Π_k (f_k(o_k) + ε)^w_k − ε, where o_k is o moved to the incident direction of scan k. With `split`, what is below 1.5 times
//! the median of a scan is its base, which is blended at fixed directions, and the rest is moved. The half-vector frame blends
//! f·cos θ_i·cos θ_o.

use std::sync::Arc;

use rayon::prelude::*;

use crate::frame::{Frame, LEAST_COSINE, Motion};
use crate::gridded::Gridded;
use crate::incidence::{Blend, Weights};
use crate::lambert::{self, Ray};
use crate::raster::Raster;
use crate::residual::Blended;

/// ε in units of the mean BSDF.
const EPSILON: f64 = 3e-3;

/// The base of a scan in units of its median.
const BASE: f32 = 1.5;

/// One way to interpolate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// How directions move.
    pub frame: Frame,
    /// How weights go.
    pub blend: Blend,
    /// Whether the base stays and only the rest moves.
    pub split: bool,
    /// Whether pairs are averaged with swapped pairs.
    pub reciprocal: bool,
}

/// Logarithms of scans, as some recipes share them.
#[derive(Debug)]
pub(crate) struct Logs {
    incidents: Vec<Ray>,
    logs: Vec<Raster>,
    bases: Vec<Raster>,
    epsilon: f32,
}

/// Scans made ready for one recipe, one channel.
#[derive(Clone, Debug)]
pub(crate) struct Layers {
    pub recipe: Recipe,
    logs: Arc<Logs>,
}

impl Logs {
    fn new(scans: &[Gridded], channel: usize, recipe: Recipe) -> Logs {
        let mean =
            scans.iter().map(|s| s.totals[channel] / std::f64::consts::PI).sum::<f64>() / scans.len() as f64;
        let epsilon = (EPSILON * mean).max(1e-12) as f32;
        let half = recipe.frame == Frame::Half;
        let level = |scan: &Gridded| if recipe.split { BASE * median(&scan.rasters[channel]) } else { 0.0 };
        let log = |scan: &Gridded| {
            let base = level(scan);
            let cosine = if half { scan.incident[2].max(LEAST_COSINE) } else { 1.0 };
            scan.rasters[channel].map(|d, v| {
                let rest = (v - base).max(0.0);
                let rest = if half { rest * cosine * d[2].max(LEAST_COSINE) } else { rest };
                (rest + epsilon).ln()
            })
        };
        let logs = scans.par_iter().map(log).collect();
        let base = |scan: &Gridded| {
            let base = level(scan);
            scan.rasters[channel].map(|_, v| v.clamp(0.0, base))
        };
        let bases = if recipe.split { scans.par_iter().map(base).collect() } else { Vec::new() };
        Logs { incidents: scans.iter().map(|s| s.incident).collect(), logs, bases, epsilon }
    }
}

impl Layers {
    pub fn new(scans: &[Gridded], channel: usize, recipe: Recipe) -> Layers {
        Layers { recipe, logs: Arc::new(Logs::new(scans, channel, recipe)) }
    }

    /// The same scans for another recipe; the logarithms are shared if they are the same.
    pub fn for_recipe(&self, scans: &[Gridded], channel: usize, recipe: Recipe) -> Layers {
        let needs = |recipe: Recipe| (recipe.frame == Frame::Half, recipe.split);
        match needs(recipe) == needs(self.recipe) {
            true => Layers { recipe, logs: Arc::clone(&self.logs) },
            false => Layers::new(scans, channel, recipe),
        }
    }

    /// All exitant directions for one incident direction.
    pub fn slice(&self, incident: Ray, weights: &Weights) -> Slice<'_> {
        let term = |&(k, weight): &(usize, f64)| Term {
            scan: k,
            weight: weight as f32,
            motion: Motion::new(self.recipe.frame, incident, self.logs.incidents[k]),
            log: &self.logs.logs[k],
            base: self.logs.bases.get(k),
        };
        let half = self.recipe.frame == Frame::Half;
        let cosine = if half { Some(incident[2].max(LEAST_COSINE)) } else { None };
        Slice { terms: weights.iter().map(term).collect(), epsilon: self.logs.epsilon, cosine }
    }
}

struct Term<'a> {
    scan: usize,
    weight: f32,
    motion: Motion,
    log: &'a Raster,
    base: Option<&'a Raster>,
}

/// The interpolant for one incident direction.
pub(crate) struct Slice<'a> {
    terms: Vec<Term<'a>>,
    epsilon: f32,
    cosine: Option<f32>,
}

impl Slice<'_> {
    /// The value in one direction.
    #[inline]
    pub fn value(&self, o: Ray) -> f32 {
        let (mut log, mut base) = (0.0, 0.0);
        for term in &self.terms {
            log += term.weight * term.log.at(lambert::point(term.motion.apply(o)));
            if let Some(raster) = term.base {
                base += term.weight * raster.at(lambert::point(o));
            }
        }
        self.finished(log, base, o)
    }

    /// The value, and how much scans differ there.
    pub fn blended(&self, o: Ray) -> Blended {
        let (mut log, mut base) = (0.0, 0.0);
        let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
        for term in &self.terms {
            let here = term.log.at(lambert::point(term.motion.apply(o)));
            log += term.weight * here;
            let w = term.weight.abs();
            sum += w;
            first += w * here;
            second += w * here * here;
            if let Some(raster) = term.base {
                base += term.weight * raster.at(lambert::point(o));
            }
        }
        let spread = (second / sum - (first / sum).powi(2)).max(0.0).sqrt();
        Blended { value: self.finished(log, base, o), spread }
    }

    /// What scans say at the place that each is looked up at, added up with a function of the weight.
    pub fn sum(&self, o: Ray, f: impl Fn(f32, usize, [f32; 2]) -> f32) -> f32 {
        self.terms.iter().map(|t| f(t.weight, t.scan, lambert::point(t.motion.apply(o)))).sum()
    }

    #[inline(always)]
    fn finished(&self, log: f32, base: f32, o: Ray) -> f32 {
        let mut rest = (log.exp() - self.epsilon).max(0.0);
        if let Some(cosine) = self.cosine {
            rest /= cosine * o[2].max(LEAST_COSINE);
        }
        base.max(0.0) + rest
    }
}

fn median(raster: &Raster) -> f32 {
    let n = raster.n();
    let mut above: Vec<f32> =
        Raster::directions(n).zip(raster.values()).filter(|(d, _)| d[2] > 0.0).map(|(_, &v)| v).collect();
    let middle = above.len() / 2;
    *above.select_nth_unstable_by(middle, f32::total_cmp).1
}
