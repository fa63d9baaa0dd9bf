//! Scans of one part with a recipe: all exitant directions for one incident direction, at the totals that scans foresee.

use rayon::prelude::*;

use crate::blend::{Layers, Slice};
use crate::gridded::Gridded;
use crate::incidence::{Incidence, Weights, apart};
use crate::lambert::{self, Ray};
use crate::progress::{Progress, Stopped};
use crate::raster::Raster;
use crate::scales::{Sample, Scales};
use crate::tree::Values;

/// Pixels of an edge over which slices are summed.
pub(crate) const N_SUMMED: usize = 128;

/// Smaller weights are left out of a [`Place`], which is asked for one pair and averaged with what is known otherwise.
const LEAST_WEIGHT: f64 = 0.01;

/// What scans say, each forward: the way that light went.
#[derive(Debug)]
pub(crate) struct Forward {
    pub scans: Vec<Gridded>,
    /// Whether the sample is isotropic: scans lie in one half-plane.
    pub line: bool,
    pub incidence: Incidence,
    /// One per channel.
    pub layers: Vec<Layers>,
    /// What brings slices to the totals that were measured, by incident direction, one per channel.
    scales: Vec<Scales>,
}

/// What is known of an incident direction (upper hemisphere; of an isotropic sample in the plane of its scans).
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub weights: Weights,
    /// Brings what scans say to its total.
    pub scale: f32,
    /// How far from a scan it is: 1 − Σw².
    pub apart: f32,
    /// How far outside the measured ones it is \[disk\].
    pub outside: f32,
}

/// All exitant directions for one incident direction, at the total that scans foresee.
pub(crate) struct Scaled<'a> {
    pub slice: Slice<'a>,
    /// How far outside the measured incident directions it is \[disk\].
    pub outside: f64,
    /// Brings the slice to its total.
    pub scale: f32,
}

impl Values for Scaled<'_> {
    fn total(&self) -> f64 {
        self.slice.total
    }

    #[inline]
    fn value(&self, o: Ray) -> f32 {
        self.slice.value(o) * self.scale
    }
}

impl Forward {
    pub fn new(
        scans: Vec<Gridded>,
        line: bool,
        incidence: Incidence,
        layers: Vec<Layers>,
        progress: &Progress,
    ) -> Result<Forward, Stopped> {
        let mut forward = Forward { scans, line, incidence, layers, scales: Vec::new() };
        let directions = summed_directions(N_SUMMED);
        let scales = |channel: usize| {
            let summed = summed(line, &directions, progress, |incident| {
                let (slice, outside) = forward.slice(channel, incident);
                let apart = slice.apart;
                let total = slice.total;
                (move |o: Ray| slice.value(o), total, apart, outside)
            })?;
            Ok(Scales::new(line, summed.iter().map(|s| s.to(s.total)).collect()))
        };
        forward.scales = (0..forward.layers.len()).map(scales).collect::<Result<_, _>>()?;
        Ok(forward)
    }

    /// Cosine and sine of the turn that brings an isotropic sample's incident direction to where its scans are; of others none.
    pub fn turn(&self, incident: Ray) -> [f32; 2] {
        if self.line { turn(incident) } else { [1.0, 0.0] }
    }

    /// The slice of an incident direction, not scaled, and how far outside the measured ones that is.
    pub fn slice(&self, channel: usize, incident: Ray) -> (Slice<'_>, f64) {
        let (weights, outside) = self.incidence.weights(incident);
        (self.layers[channel].slice(incident, &weights, None), outside)
    }

    /// What brings the slice of an incident direction to its total.
    pub fn scale(&self, channel: usize, incident: Ray, apart: f32, outside: f64) -> f32 {
        self.scales[channel].at(incident, apart, outside == 0.0)
    }

    /// The slice of an incident direction with what brings it to its total.
    pub fn scaled(&self, channel: usize, incident: Ray) -> Scaled<'_> {
        let (slice, outside) = self.slice(channel, incident);
        let scale = self.scale(channel, incident, slice.apart, outside);
        Scaled { slice, outside, scale }
    }

    pub fn place(&self, channel: usize, incident: Ray) -> Place {
        self.place_by(&self.incidence, channel, incident)
    }

    /// What is known of an incident direction by some of the scans.
    pub fn place_by(&self, incidence: &Incidence, channel: usize, incident: Ray) -> Place {
        let (mut weights, outside) = incidence.weights(incident);
        let apart = apart(&weights);
        weights.retain(|(_, w)| w.abs() > LEAST_WEIGHT);
        let sum: f64 = weights.iter().map(|(_, w)| w).sum();
        weights.iter_mut().for_each(|(_, w)| *w /= sum);
        let scale = self.scale(channel, incident, apart, outside);
        Place { weights, scale, apart, outside: outside as f32 }
    }
}

/// Directions that slices are summed over, in the pixels of an edge of `n`.
pub(crate) fn summed_directions(n: usize) -> Vec<Ray> {
    Raster::directions(n).filter(|d| d[2] > 0.0).collect()
}

/// A slice summed.
pub(crate) struct Summed {
    /// As it is.
    pub sum: f64,
    /// As scans foresee it.
    pub total: f64,
    pub apart: f32,
    pub outside: f64,
}

impl Summed {
    /// What brings it to a total, as tables keep it.
    pub fn to(&self, total: f64) -> Sample {
        (if self.sum > 0.0 { (total / self.sum) as f32 } else { 1.0 }, self.apart, self.outside == 0.0)
    }
}

/// Slices summed over exitant directions at all nodes of [`Scales`]. `slice` makes of an incident direction a function of an
/// exitant one, the total, and how far from a scan and how far outside it is.
fn summed<F: Fn(Ray) -> f32>(
    line: bool,
    directions: &[Ray],
    progress: &Progress,
    slice: impl Fn(Ray) -> (F, f64, f32, f64) + Sync,
) -> Result<Vec<Summed>, Stopped> {
    let pixel = lambert::SOLID_ANGLE as f32 * (2.0 * crate::raster::EXTENT / N_SUMMED as f32).powi(2);
    let summed = |incident: Ray| {
        progress.go_on()?;
        let (value, total, apart, outside) = slice(incident);
        let sum: f32 = directions.iter().map(|&o| value(o) * o[2]).sum();
        Ok(Summed { sum: f64::from(sum * pixel), total, apart, outside })
    };
    Scales::nodes(line).into_par_iter().map(summed).collect()
}

/// Cosine and sine of the turn that brings a direction to the half-plane y = 0, x ≤ 0.
#[inline(always)]
pub(crate) fn turn([x, y, _]: Ray) -> [f32; 2] {
    let r = x.hypot(y);
    if r > 1e-7 { [-x / r, -y / r] } else { [1.0, 0.0] }
}

/// A direction turned back by the angle of this cosine and sine.
#[inline(always)]
pub(crate) fn turned([x, y, z]: Ray, [c, s]: [f32; 2]) -> Ray {
    [c * x + s * y, c * y - s * x, z]
}
