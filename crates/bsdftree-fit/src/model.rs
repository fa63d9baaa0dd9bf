//! A measurement fitted: values for every pair of directions of one part.

use bsdftree::direction::Side;
use bsdftree::{Direction, Part};
use rayon::prelude::*;

use crate::blend::{Layers, Recipe, Slice};
use crate::choose::{self, Score};
use crate::gridded::Gridded;
use crate::incidence::Incidence;
use crate::lambert::{self, Ray};
use crate::measurement::Symmetry;
use crate::prepare::{self, Points};
use crate::progress::{Progress, Stopped};
use crate::raster::Raster;
use crate::scales::Scales;
use crate::uncertainty::Uncertainty;

/// Pixels of an edge over which slices are summed.
const N_SUMMED: usize = 128;

/// One part of a sample, ready to be asked.
#[derive(Debug)]
pub struct Model {
    /// What it answers for.
    pub part: Part,
    /// What was given or found.
    pub symmetry: Symmetry,
    /// All recipes that were tried, the one in use first.
    pub scores: Vec<Score>,
    scans: Vec<Gridded>,
    incidence: Incidence,
    /// One per channel.
    layers: Vec<Layers>,
    /// What brings slices to the totals that were measured, by incident direction, one per channel.
    scales: Vec<Scales>,
    uncertainty: Uncertainty,
}

impl Model {
    /// Fits one part with the recipe of the least cross-validated error among those tried; `None` if none can be followed.
    pub(crate) fn new(
        points: Vec<Points>,
        part: Part,
        symmetry: Symmetry,
        tried: &[Recipe],
        n_channels: usize,
        progress: &Progress,
    ) -> Result<Option<Model>, Stopped> {
        let scans = prepare::gridded(prepare::symmetric(points, symmetry), progress)?;
        let line = symmetry == Symmetry::Isotropic;
        let scores = choose::scores(&scans, line, tried, progress)?;
        let Some(&Score { recipe, .. }) = scores.first() else { return Ok(None) };
        let incidence = choose::incidence(&scans, line, recipe.blend, None);
        let layers = (0..n_channels).map(|c| Layers::new(&scans, c, line, recipe, progress));
        let layers = layers.collect::<Result<Vec<Layers>, _>>()?;
        let uncertainty = Uncertainty::new(&scans, &layers[scans[0].main()], line, progress)?;
        let mut model =
            Model { part, symmetry, scores, scans, incidence, layers, scales: Vec::new(), uncertainty };
        model.scales = (0..n_channels).map(|c| model.new_scales(c, progress)).collect::<Result<_, _>>()?;
        progress.count(1)?;
        Ok(Some(model))
    }

    /// How many steps one takes: each recipe, and what is done with the best.
    pub(crate) fn n_steps(tried: &[Recipe]) -> usize {
        tried.len() + 1
    }

    /// The recipe in use.
    pub fn recipe(&self) -> Recipe {
        self.layers[0].recipe
    }

    /// Pixels of an edge of scans laid over disks, as a power of two.
    pub(crate) fn log2_pixels(&self) -> u32 {
        self.scans[0].covered.n().ilog2()
    }

    fn is_line(&self) -> bool {
        self.symmetry == Symmetry::Isotropic
    }

    /// Cosine and sine of the turn that brings an isotropic sample's incident direction to where its scans are; of others none.
    pub(crate) fn turn(&self, [x, y, _]: Ray) -> [f32; 2] {
        let r = x.hypot(y);
        if self.is_line() && r > 1e-7 { [-x / r, -y / r] } else { [1.0, 0.0] }
    }

    /// All exitant directions for one incident direction (upper hemisphere, and of an isotropic sample in the plane of its scans), not
    /// scaled.
    pub(crate) fn slice(&self, channel: usize, incident: Ray) -> Slice<'_> {
        let (weights, _) = self.incidence.weights(incident);
        self.layers[channel].slice(incident, &weights, None)
    }

    fn new_scales(&self, channel: usize, progress: &Progress) -> Result<Scales, Stopped> {
        let directions: Vec<(Ray, f32)> =
            Raster::directions(N_SUMMED).filter(|d| d[2] > 0.0).map(|d| (d, d[2])).collect();
        let pixel = lambert::SOLID_ANGLE as f32 * (2.0 * crate::raster::EXTENT / N_SUMMED as f32).powi(2);
        let sample = |incident: Ray| {
            progress.go_on()?;
            let (weights, outside) = self.incidence.weights(incident);
            let slice = self.layers[channel].slice(incident, &weights, None);
            let sum: f32 = directions.iter().map(|&(d, cosine)| slice.value(d) * cosine).sum();
            let sum = f64::from(sum * pixel);
            let factor = if sum > 0.0 { (slice.total / sum) as f32 } else { 1.0 };
            Ok((factor, slice.apart, outside == 0.0))
        };
        let samples = Scales::nodes(self.is_line()).into_par_iter().map(sample).collect::<Result<_, _>>()?;
        Ok(Scales::new(self.is_line(), samples))
    }

    /// A slice, what it is to be scaled by, and how far outside the measured incident directions it is.
    fn scaled(&self, channel: usize, incident: Ray) -> (Slice<'_>, f32, f64) {
        let (weights, outside) = self.incidence.weights(incident);
        let slice = self.layers[channel].slice(incident, &weights, None);
        let scale = self.scales[channel].at(incident, slice.apart, outside == 0.0);
        (slice, scale, outside)
    }

    /// BSDF \[1/sr\] for pairs of directions, one channel. Pairs on other sides than the part's are 0.
    pub fn eval(&self, channel: usize, incident: &[Direction], exitant: &[Direction]) -> Vec<f64> {
        self.each(incident, exitant, |i| {
            let (slice, scale, _) = self.scaled(channel, i);
            move |o| f64::from(slice.value(o) * scale)
        })
    }

    /// Standard errors \[1/sr\] of what [`Model::eval`] gives of the main channel.
    pub fn error(&self, incident: &[Direction], exitant: &[Direction]) -> Vec<f64> {
        self.each(incident, exitant, |i| self.error_slice(i))
    }

    /// Standard errors for one incident direction.
    pub(crate) fn error_slice(&self, incident: Ray) -> impl Fn(Ray) -> f64 + '_ {
        let channel = self.scans[0].main();
        let (slice, scale, outside) = self.scaled(channel, incident);
        let apart = f64::from(slice.apart);
        move |o| {
            let mut blended = slice.blended(o);
            blended.value *= scale;
            let covered = slice.sum(o, |w, k, p| w * self.scans[k].covered.at(p)).clamp(0.0, 1.0);
            let noise2 =
                slice.sum(o, |w, k, p| self.scans[k].noise.as_ref().map_or(0.0, |n| (w * n.at(p)).powi(2)));
            self.uncertainty.error(blended, apart, outside, covered, f64::from(noise2.sqrt() * scale))
        }
    }

    /// A function of each incident direction and then of each exitant one.
    fn each<F: Fn(Ray) -> f64>(
        &self,
        incident: &[Direction],
        exitant: &[Direction],
        at: impl Fn(Ray) -> F + Sync,
    ) -> Vec<f64> {
        let chunk = |(incident, exitant): (&[Direction], &[Direction])| {
            let mut last: Option<(Ray, F)> = None;
            let value = |(&i, &o): (&Direction, &Direction)| {
                if Part::between(Side::of(i), Side::of(o)) != self.part {
                    return 0.0;
                }
                let (i, o) = (lambert::upper(i), lambert::upper(o));
                let turn = self.turn(i);
                let (i, o) = (turned(i, turn), turned(o, turn));
                if last.as_ref().is_none_or(|(before, _)| *before != i) {
                    last = Some((i, at(i)));
                }
                last.as_ref().expect("just set").1(o)
            };
            incident.iter().zip(exitant).map(value).collect::<Vec<f64>>()
        };
        const CHUNK: usize = 2048;
        incident.par_chunks(CHUNK).zip(exitant.par_chunks(CHUNK)).flat_map_iter(chunk).collect()
    }
}

/// A direction turned back by the angle of this cosine and sine.
#[inline(always)]
pub(crate) fn turned([x, y, z]: Ray, [c, s]: [f32; 2]) -> Ray {
    [c * x + s * y, c * y - s * x, z]
}
