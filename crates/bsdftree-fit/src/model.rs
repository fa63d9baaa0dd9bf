//! A measurement fitted: values for every pair of directions of one part.

use bsdftree::direction::Side;
use bsdftree::{Direction, Part};
use rayon::prelude::*;

use crate::blend::{Layers, Recipe, Slice};
use crate::choose::{self, Score};
use crate::gridded::Gridded;
use crate::incidence::{Incidence, Weights};
use crate::lambert::{self, Ray};
use crate::measurement::{Measurement, Symmetry};
use crate::prepare;
use crate::raster::Raster;

/// Nodes of an edge of the table of scales.
const N_SCALES: usize = 33;

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
    scales: Vec<Vec<f32>>,
}

impl Model {
    /// Fits one part with the recipe of the least cross-validated error among `tried` (all if empty).
    pub fn new(measurement: &Measurement, part: Part, symmetry: Symmetry, tried: &[Recipe]) -> Model {
        let scans = prepare::gridded(prepare::symmetric(prepare::points_of(measurement, part), symmetry));
        let line = symmetry == Symmetry::Isotropic;
        let all = choose::recipes();
        let scores = choose::scores(&scans, line, if tried.is_empty() { &all } else { tried });
        let recipe = scores[0].recipe;
        let incidence = choose::incidence(&scans, line, recipe.blend, None);
        let layers = (0..measurement.n_channels).map(|c| Layers::new(&scans, c, recipe)).collect();
        let mut model = Model { part, symmetry, scores, scans, incidence, layers, scales: Vec::new() };
        model.scales = (0..measurement.n_channels).map(|c| model.table_of_scales(c)).collect();
        model
    }

    /// The recipe in use.
    pub fn recipe(&self) -> Recipe {
        self.layers[0].recipe
    }

    /// Number of channels.
    pub fn n_channels(&self) -> usize {
        self.layers.len()
    }

    fn is_line(&self) -> bool {
        self.symmetry == Symmetry::Isotropic
    }

    /// Turned so that an isotropic sample's incident direction lies where its scans do.
    fn turned(&self, incident: Ray, exitant: Ray) -> (Ray, Ray) {
        if !self.is_line() {
            return (incident, exitant);
        }
        let [x, y, z] = incident;
        let r = x.hypot(y);
        if r < 1e-7 {
            return (incident, exitant);
        }
        let (c, s) = (-x / r, -y / r);
        let [u, v, w] = exitant;
        ([-r, 0.0, z], [c * u + s * v, c * v - s * u, w])
    }

    /// The total of a channel that neighbours foresee.
    fn total(&self, channel: usize, weights: &Weights) -> f64 {
        let sum: f64 = weights.iter().map(|&(k, w)| w * self.scans[k].totals[channel]).sum();
        sum.clamp(0.0, 1.0)
    }

    /// All exitant directions for one incident direction (upper hemisphere, and of an isotropic sample in the plane of its scans), not
    /// scaled, and the total that they should have.
    pub(crate) fn slice(&self, channel: usize, incident: Ray) -> (Slice<'_>, f64) {
        let (weights, _) = self.incidence.weights(incident);
        (self.layers[channel].slice(incident, &weights), self.total(channel, &weights))
    }

    fn table_of_scales(&self, channel: usize) -> Vec<f32> {
        let rows = if self.is_line() { 1 } else { N_SCALES };
        let directions: Vec<(Ray, f32)> =
            Raster::directions(N_SUMMED).filter(|d| d[2] > 0.0).map(|d| (d, d[2])).collect();
        let pixel = lambert::SOLID_ANGLE as f32 * (2.0 * crate::raster::EXTENT / N_SUMMED as f32).powi(2);
        (0..rows * N_SCALES)
            .into_par_iter()
            .map(|k| {
                let at = |j: usize| 2.0 * j as f32 / (N_SCALES - 1) as f32 - 1.0;
                let point = if self.is_line() {
                    [-(k as f32) / (N_SCALES - 1) as f32, 0.0]
                } else {
                    [at(k % N_SCALES), at(k / N_SCALES)]
                };
                let r = point[0].hypot(point[1]);
                // Corners of the table have the value of the rim.
                let point = if r > 1.0 { point.map(|x| x / r) } else { point };
                let incident = lambert::direction(point);
                let (slice, total) = self.slice(channel, incident);
                let sum: f32 = directions.iter().map(|&(d, cosine)| slice.value(d) * cosine).sum();
                let sum = f64::from(sum * pixel);
                if sum > 0.0 { (total / sum) as f32 } else { 1.0 }
            })
            .collect()
    }

    fn scale(&self, channel: usize, incident: Ray) -> f32 {
        let table = &self.scales[channel];
        let last = (N_SCALES - 1) as f32;
        let [u, v] = lambert::point(incident);
        if self.is_line() {
            let x = (u.hypot(v) * last).min(last - 1e-3);
            let j = x as usize;
            return table[j] + (x - j as f32) * (table[j + 1] - table[j]);
        }
        let [x, y] = [u, v].map(|w| ((w + 1.0) * 0.5 * last).clamp(0.0, last - 1e-3));
        let (i, j) = (x as usize, y as usize);
        let (s, t) = (x - i as f32, y - j as f32);
        let at = |i: usize, j: usize| table[j * N_SCALES + i];
        let lower = at(i, j) + s * (at(i + 1, j) - at(i, j));
        let upper = at(i, j + 1) + s * (at(i + 1, j + 1) - at(i, j + 1));
        lower + t * (upper - lower)
    }

    /// BSDF \[1/sr\] for pairs of directions, one channel. Pairs on other sides than the part's are 0.
    pub fn eval(&self, channel: usize, incident: &[Direction], exitant: &[Direction]) -> Vec<f64> {
        let chunk = 2048;
        let pairs = incident.par_chunks(chunk).zip(exitant.par_chunks(chunk));
        pairs.flat_map_iter(|(i, o)| self.eval_chunk(channel, i, o)).collect()
    }

    fn eval_chunk(&self, channel: usize, incident: &[Direction], exitant: &[Direction]) -> Vec<f64> {
        let mut last: Option<(Ray, Slice<'_>, f32)> = None;
        let mut values = Vec::with_capacity(incident.len());
        for (&i, &o) in incident.iter().zip(exitant) {
            if Part::between(Side::of(i), Side::of(o)) != self.part {
                values.push(0.0);
                continue;
            }
            let (i, o) = self.turned(lambert::upper(i), lambert::upper(o));
            if last.as_ref().is_none_or(|(at, _, _)| *at != i) {
                last = Some((i, self.slice(channel, i).0, self.scale(channel, i)));
            }
            let (_, slice, scale) = last.as_ref().expect("just set");
            values.push(f64::from(slice.value(o) * scale));
        }
        values
    }
}
