//! Scans blended between incident directions: logarithms of values along a [`Frame`], with the weights of [`Incidence`].
//!
//! f(i,o) = Π_k (f_k(o_k) + ε)^w_k − ε, where o_k is o moved to the incident direction of scan k. With `split`, what is below 1.5 times
//! the median of a scan is its base, which is blended at fixed directions, and the rest is moved. The half-vector frame blends
//! f·cos θ_i·cos θ_o. Where scans go on beyond their outermost points as they are there, so do cosines: else f·cos θ_o would dip there,
//! and what is divided by it rise.

use std::sync::Arc;

use rayon::prelude::*;

use crate::frame::{Frame, LEAST_COSINE, Motion, Reflect};
use crate::gridded::Gridded;
use crate::incidence::{Blend, Weights, apart};
use crate::lambert::{self, Ray};
use crate::lobes;
use crate::progress::{Progress, Stopped};
use crate::raster::Raster;
use crate::residual::Blended;
use crate::tracks::{Followed, Tracks};

/// ε in units of the mean BSDF.
const EPSILON: f64 = 3e-3;

/// Cosines are held below this one at most, of scans that end well above the horizon: that of 70°.
const MOST_COSINE: f32 = 0.34;

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
    /// Whether pairs are averaged with swapped pairs, f(i,o) with f(o,i).
    pub reciprocal: bool,
}

impl Recipe {
    /// Recipes for which this is the same share logarithms.
    pub(crate) fn logs(self) -> (bool, bool, bool) {
        (self.frame == Frame::Half, self.split, self.frame == Frame::Lobes)
    }
}

/// Logarithms of scans, as some recipes share them.
#[derive(Debug)]
pub(crate) struct Logs {
    incidents: Vec<Ray>,
    groups: Vec<usize>,
    line: bool,
    tracks: Option<Tracks>,
    totals: Vec<f64>,
    logs: Vec<Raster>,
    bases: Vec<Raster>,
    epsilon: f32,
    least: f32,
}

/// Scans made ready for one recipe, one channel.
#[derive(Clone, Debug)]
pub(crate) struct Layers {
    pub recipe: Recipe,
    logs: Arc<Logs>,
}

impl Logs {
    fn new(
        scans: &[Gridded],
        channel: usize,
        line: bool,
        recipe: Recipe,
        progress: &Progress,
    ) -> Result<Logs, Stopped> {
        let mean =
            scans.iter().map(|s| s.totals[channel] / std::f64::consts::PI).sum::<f64>() / scans.len() as f64;
        let epsilon = (EPSILON * mean).max(1e-12) as f32;
        let half = recipe.frame == Frame::Half;
        let least = least_cosine(scans);
        let level = |scan: &Gridded| if recipe.split { BASE * median(&scan.rasters[channel]) } else { 0.0 };
        let log = |scan: &Gridded| {
            let base = level(scan);
            let cosine = if half { held(scan.incident[2], least) } else { 1.0 };
            scan.rasters[channel].map(|d, v| {
                let rest = (v - base).max(0.0);
                let rest = if half { rest * cosine * held(d[2], least) } else { rest };
                (rest + epsilon).ln()
            })
        };
        progress.go_on()?;
        let logs = scans.par_iter().map(log).collect();
        let tracks = if recipe.frame == Frame::Lobes {
            let levels: Vec<f32> = scans.iter().map(level).collect();
            Tracks::new(scans, channel, line, scans[0].part, &levels, progress)?
        } else {
            None
        };
        let base = |(k, scan): (usize, &Gridded)| {
            let base = level(scan);
            let labels = tracks.as_ref().map(|tracks| &tracks.labels[k]);
            let mut pixel = 0..;
            scan.rasters[channel].map(|_, v| {
                let pixel = pixel.next().expect("endless");
                let whole = labels.is_some_and(|labels| labels[pixel] == lobes::NONE);
                if whole { v.max(0.0) } else { v.clamp(0.0, base) }
            })
        };
        let bases = if recipe.split { scans.par_iter().enumerate().map(base).collect() } else { Vec::new() };
        let incidents = scans.iter().map(|s| s.incident).collect();
        let groups = scans.iter().map(|s| s.group).collect();
        let totals = scans.iter().map(|s| s.totals[channel]).collect();
        Ok(Logs { incidents, groups, line, tracks, totals, logs, bases, epsilon, least })
    }
}

impl Layers {
    pub fn new(
        scans: &[Gridded],
        channel: usize,
        line: bool,
        recipe: Recipe,
        progress: &Progress,
    ) -> Result<Layers, Stopped> {
        let logs = Logs::new(scans, channel, line, recipe, progress)?;
        Ok(Layers { recipe, logs: Arc::new(logs) })
    }

    /// The same scans for another recipe; the logarithms are shared if they are the same.
    pub fn for_recipe(
        &self,
        scans: &[Gridded],
        channel: usize,
        recipe: Recipe,
        progress: &Progress,
    ) -> Result<Layers, Stopped> {
        match recipe.logs() == self.recipe.logs() {
            true => Ok(Layers { recipe, logs: Arc::clone(&self.logs) }),
            false => Layers::new(scans, channel, self.logs.line, recipe, progress),
        }
    }

    /// Whether the recipe can be followed: lobes can if some scan has more than one.
    pub fn exists(&self) -> bool {
        self.recipe.frame != Frame::Lobes || self.logs.tracks.is_some()
    }

    /// All exitant directions for one incident direction, as seen by scans outside the group `without`, whose weights these are.
    pub fn slice(&self, incident: Ray, weights: &Weights, without: Option<usize>) -> Slice<'_> {
        let logs = &*self.logs;
        let half = self.recipe.frame == Frame::Half;
        let bases = match self.recipe.split {
            true => weights.iter().map(|&(k, weight)| (weight as f32, &logs.bases[k])).collect(),
            false => Vec::new(),
        };
        let (moved, total) = match &logs.tracks {
            Some(tracks) => {
                let at = tracks.at(&logs.incidents, &logs.groups, logs.line, incident, weights, without);
                let rest: f64 = weights.iter().map(|&(k, w)| w * (logs.totals[k] - tracks.power_in(k))).sum();
                let total = rest.max(0.0) + at.iter().map(|(_, followed)| followed.power).sum::<f64>();
                (at.into_iter().map(|(number, followed)| logs.followed(number, &followed)).collect(), total)
            }
            None => {
                let total = weights.iter().map(|&(k, w)| w * logs.totals[k]).sum();
                (vec![self.all(incident, weights)], total)
            }
        };
        let total = total.clamp(0.0, 1.0);
        let cosines = half.then(|| (held(incident[2], logs.least), logs.least));
        let apart = apart(weights);
        Slice { moved, bases, cosines, total, apart }
    }

    /// The scan of the largest weight, and the point where it is looked up. Lobes are not followed.
    #[inline]
    pub fn nearest(&self, incident: Ray, weights: &Weights, o: Ray) -> (usize, [f32; 2]) {
        let k = weights[0].0;
        let motion = Motion::new(self.recipe.frame, incident, self.logs.incidents[k]);
        (k, lambert::point(motion.apply(o)))
    }

    /// The value of one pair. Lobes are not followed.
    #[inline]
    pub fn value(&self, incident: Ray, weights: &Weights, o: Ray) -> f32 {
        let logs = &*self.logs;
        let mut sum = 0.0;
        for &(k, weight) in weights {
            let motion = Motion::new(self.recipe.frame, incident, logs.incidents[k]);
            let point = lambert::point(motion.apply(o));
            sum += weight as f32 * logs.logs[k].at(point);
        }
        let mut rest = (sum.exp() - logs.epsilon).max(0.0);
        if self.recipe.frame == Frame::Half {
            rest /= held(incident[2], logs.least) * held(o[2], logs.least);
        }
        let point = lambert::point(o);
        let base: f32 = match self.recipe.split {
            true => weights.iter().map(|&(k, weight)| weight as f32 * logs.bases[k].at(point)).sum(),
            false => 0.0,
        };
        base.max(0.0) + rest
    }

    /// Everything that moves, as one.
    fn all(&self, incident: Ray, weights: &Weights) -> Moved<'_> {
        let term = |&(k, weight): &(usize, f64)| Term {
            scan: k,
            weight: weight as f32,
            motion: Motion::new(self.recipe.frame, incident, self.logs.incidents[k]),
            incident: self.logs.incidents[k],
            log: &self.logs.logs[k],
            mask: None,
        };
        let terms = weights.iter().map(term).collect();
        let half = (self.recipe.frame == Frame::Half).then_some(incident);
        Moved { terms, half, offset: 0.0, epsilon: self.logs.epsilon, dark: 0.0 }
    }
}

impl Logs {
    /// One lobe, brought from the powers that it has in scans to that which it has here.
    fn followed(&self, number: u8, followed: &Followed) -> Moved<'_> {
        let tracks = self.tracks.as_ref().expect("there are lobes");
        let track = &tracks.tracks[usize::from(number)];
        let term = |&(k, weight, center): &(usize, f64, Ray)| Term {
            scan: k,
            weight: weight as f32,
            motion: Motion::between(followed.center, center),
            incident: self.incidents[k],
            log: &self.logs[k],
            mask: Some((&tracks.labels[k], number)),
        };
        let mean: f64 = followed.scans.iter().map(|&(k, w, _)| w * track.power_in(k).ln()).sum();
        let offset = (followed.power.ln() - mean) as f32;
        let terms = followed.scans.iter().map(term).collect();
        Moved { terms, half: None, offset, epsilon: self.epsilon * offset.exp(), dark: self.epsilon.ln() }
    }
}

struct Term<'a> {
    scan: usize,
    weight: f32,
    motion: Motion,
    /// That of the scan.
    incident: Ray,
    log: &'a Raster,
    /// Pixels' lobes, and which one counts.
    mask: Option<(&'a [u8], u8)>,
}

impl Term<'_> {
    /// The logarithm in the scan, and how much the scan counts: of a lobe that the horizon of the scan cuts, nothing where it is cut.
    #[inline(always)]
    fn log_at(&self, o: Ray, dark: f32) -> (f32, f32) {
        let there = self.motion.apply(o);
        let point = lambert::point(there);
        match self.mask {
            None => (self.log.at(point), self.weight),
            Some(_) if there[2] < LEAST_COSINE => (dark, 0.0),
            Some((labels, number)) if labels[Raster::pixel(self.log.n(), point)] != number => {
                (dark, self.weight)
            }
            Some(_) => (self.log.at(point), self.weight),
        }
    }
}

/// What moves as one.
struct Moved<'a> {
    terms: Vec<Term<'a>>,
    /// In the half-vector frame the incident direction.
    half: Option<Ray>,
    /// Added to the logarithm.
    offset: f32,
    epsilon: f32,
    /// Logarithm outside the lobe.
    dark: f32,
}

impl Moved<'_> {
    /// The logarithm, and how much scans differ in it.
    #[inline(always)]
    fn log_at(&self, o: Ray) -> (f32, f32) {
        let (mut log, mut sum, mut size, mut first, mut second) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for term in &self.terms {
            let (here, weight) = term.log_at(o, self.dark);
            log += weight * here;
            sum += weight;
            let w = weight.abs();
            size += w;
            first += w * here;
            second += w * here * here;
        }
        if sum < LEAST_SEEN {
            return (self.dark, 0.0);
        }
        (log / sum + self.offset, (second / size - (first / size).powi(2)).max(0.0).sqrt())
    }

    #[inline(always)]
    fn value(&self, o: Ray) -> f32 {
        let log = match self.half {
            Some(incident) => {
                let reflect = Reflect::new(incident, o);
                let log =
                    |term: &Term<'_>| term.weight * term.log.at(lambert::point(reflect.of(term.incident)));
                self.terms.iter().map(log).sum::<f32>() + self.offset
            }
            None => self.log_at(o).0,
        };
        (log.exp() - self.epsilon).max(0.0)
    }
}

/// Where scans with less weight than this see it, a lobe is dark.
const LEAST_SEEN: f32 = 0.3;

/// The interpolant for one incident direction.
pub(crate) struct Slice<'a> {
    moved: Vec<Moved<'a>>,
    bases: Vec<(f32, &'a Raster)>,
    /// That of the incident direction, and the least.
    cosines: Option<(f32, f32)>,
    /// The directional-hemispherical total that scans foresee, in [0, 1].
    pub total: f64,
    /// How far from a scan it is: 1 − Σw², 0 at a scan.
    pub apart: f32,
}

impl Slice<'_> {
    /// The value in one direction.
    #[inline]
    pub fn value(&self, o: Ray) -> f32 {
        self.finished(self.moved.iter().map(|moved| moved.value(o)).sum(), o)
    }

    /// The value, and how much scans differ there: of lobes, in the brightest.
    pub fn blended(&self, o: Ray) -> Blended {
        let (mut rest, mut brightest, mut spread) = (0.0, -1.0, 0.0);
        for moved in &self.moved {
            let (log, spread_here) = moved.log_at(o);
            let value = (log.exp() - moved.epsilon).max(0.0);
            if value > brightest {
                brightest = value;
                spread = spread_here;
            }
            rest += value;
        }
        Blended { value: self.finished(rest, o), spread }
    }

    /// What scans say at the place that each is looked up at, added up with a function of the weight; of lobes, in the first.
    pub fn sum(&self, o: Ray, f: impl Fn(f32, usize, [f32; 2]) -> f32) -> f32 {
        let terms = self.moved.first().map_or(&[][..], |moved| &moved.terms);
        terms.iter().map(|t| f(t.weight, t.scan, lambert::point(t.motion.apply(o)))).sum()
    }

    /// The scan of the largest weight, and the point where it is looked up.
    #[inline]
    pub fn nearest(&self, o: Ray) -> Option<(usize, [f32; 2])> {
        let term = self.moved.first()?.terms.first()?;
        Some((term.scan, lambert::point(term.motion.apply(o))))
    }

    #[inline(always)]
    fn finished(&self, rest: f32, o: Ray) -> f32 {
        let base: f32 = match self.bases.is_empty() {
            true => 0.0,
            false => {
                let point = lambert::point(o);
                self.bases.iter().map(|(weight, raster)| weight * raster.at(point)).sum()
            }
        };
        let rest = self.cosines.map_or(rest, |(cosine, least)| rest / (cosine * held(o[2], least)));
        base.max(0.0) + rest
    }
}

/// A cosine that does not fall below `least`, without the kink that pixels could not follow.
#[inline(always)]
fn held(cosine: f32, least: f32) -> f32 {
    let apart = cosine - least;
    0.5 * (cosine + least + (apart * apart + least * least / 16.0).sqrt())
}

/// The cosine down to which most scans reach, at least [`LEAST_COSINE`].
fn least_cosine(scans: &[Gridded]) -> f32 {
    let lowest = |scan: &Gridded| scan.exitant.iter().map(|o| o[2]).fold(1f32, f32::min);
    let mut lowest: Vec<f32> = scans.iter().map(lowest).collect();
    let middle = lowest.len() / 2;
    lowest.select_nth_unstable_by(middle, f32::total_cmp).1.clamp(LEAST_COSINE, MOST_COSINE)
}

fn median(raster: &Raster) -> f32 {
    let n = raster.n();
    let mut above: Vec<f32> =
        Raster::directions(n).zip(raster.values()).filter(|(d, _)| d[2] > 0.0).map(|(_, &v)| v).collect();
    let middle = above.len() / 2;
    *above.select_nth_unstable_by(middle, f32::total_cmp).1
}
