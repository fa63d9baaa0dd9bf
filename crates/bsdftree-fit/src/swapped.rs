//! Reciprocity as information: f(i,o) is also what the fit says of light that comes from o and leaves towards i.
//!
//! Scans know few incident directions and many exitant ones. So between scans, and beyond the last of them, f(i,o) is known well where o is
//! near the incident direction of a scan: that scan was measured at i. Both estimates are averaged with the inverse of their variances,
//! which are estimated from how far from a scan each is ([`variance`]). At a scan its own points count alone, except where it has none.
//!
//! In reflection the swapped pair is one of the same part; in transmission (i in front, o behind) it is one of the light that comes from behind,
//! and both were mirrored to the upper hemisphere in the same way, so here there is no difference.

use std::borrow::Cow;

use crate::blend::{Layers, Slice};
use crate::forward::{self, Forward, Place, turned};
use crate::gridded::{Gridded, MOST_BEND};
use crate::incidence::Incidence;
use crate::lambert::{self, Ray};
use crate::raster::Raster;
use crate::residual::Blended;

/// How many times worse than the mean over a scan an extrapolated value may be: it is the dim parts that are off most.
const BEYOND: f32 = 2.0;

/// An estimate whose variance is as many times that of the other counts for nothing: it is not looked up.
const ENOUGH: f32 = 100.0;

/// Neither estimate counts for nothing.
const LEAST_VARIANCE: f32 = 1e-6;

/// Steps of the radius of the disk for which an isotropic sample's weights are kept: 10 000 times finer than scans are apart.
const N_RADII: usize = 8192;

/// Where a pair's swapped pair is asked: scans of the light that goes back, one channel.
#[derive(Clone, Copy)]
pub(crate) struct Back<'a> {
    pub scans: &'a [Gridded],
    pub layers: &'a Layers,
    pub line: bool,
    /// Relative error between scans, and for each unit of distance on the disk outside of them.
    pub errors: [f32; 2],
}

/// The squared relative error that is expected of an estimate.
///
/// `doubt` is that of going linearly between points there. At a scan ([`Place::apart`] is 0) `measured` says that its own points are
/// to be kept as they are.
fn variance(back: &Back<'_>, apart: f32, outside: f32, doubt: f32, measured: bool) -> f32 {
    let apart = (2.0 * apart).min(1.0);
    let bend = doubt.min(MOST_BEND);
    let bend = if measured { apart * bend } else { bend };
    let [between, beyond] = back.errors;
    let unknown = (doubt - MOST_BEND).max(0.0);
    apart * between.powi(2) + bend + unknown + (BEYOND * beyond * outside).powi(2) + LEAST_VARIANCE
}

/// Pixels of an edge for which other samples' weights are kept.
const N_PIXELS: usize = 128;

/// Both estimates of one pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimates {
    swapped: f32,
    /// Weight of the forward one, in [0, 1].
    pub share: f32,
}

impl Estimates {
    /// The mean with a forward value.
    #[inline(always)]
    pub fn of(self, forward: f32) -> f32 {
        self.share * forward + (1.0 - self.share) * self.swapped
    }
}

impl<'a> Back<'a> {
    pub fn new(of: &'a Forward, channel: usize, errors: [f32; 2]) -> Back<'a> {
        let Forward { scans, layers, line, .. } = of;
        Back { scans, layers: &layers[channel], line: *line, errors }
    }

    /// What the forward estimate counts, in [0, 1]. The pair `here` is known of the incident direction, `there` of the exitant one.
    #[inline]
    pub fn share(
        &self,
        slice: &Slice<'_>,
        scans: &[Gridded],
        (incident, outside): (Ray, f32),
        o: Ray,
        there: &Place,
    ) -> f32 {
        let doubt = slice.nearest(o).map_or(0.0, |(k, point)| scans[k].doubt.at(point));
        let forward = variance(self, slice.apart, outside, doubt, true);
        let least = variance(self, there.apart, there.outside, 0.0, false);
        if least > ENOUGH * forward {
            return 1.0;
        }
        let turn = self.turn(o);
        let (k, point) = self.layers.nearest(turned(o, turn), &there.weights, turned(incident, turn));
        let doubt = self.scans[k].doubt.at(point);
        let swapped = variance(self, there.apart, there.outside, doubt, false);
        swapped / (forward + swapped)
    }

    /// The swapped pair's value, and what the forward one counts.
    #[inline]
    pub fn estimates(
        &self,
        slice: &Slice<'_>,
        scans: &[Gridded],
        (incident, outside): (Ray, f32),
        o: Ray,
        there: &Place,
    ) -> Estimates {
        let share = self.share(slice, scans, (incident, outside), o, there);
        if share == 1.0 {
            return Estimates { swapped: 0.0, share };
        }
        let turn = self.turn(o);
        let value = self.layers.value(turned(o, turn), &there.weights, turned(incident, turn));
        Estimates { swapped: value * there.scale, share }
    }

    fn turn(&self, o: Ray) -> [f32; 2] {
        if self.line { forward::turn(o) } else { [1.0, 0.0] }
    }
}

/// How scans that are left out are predicted from swapped pairs too.
pub(crate) struct Swap<'a> {
    /// All scans of the part.
    pub forward: &'a Forward,
    /// Those of the light that goes back: perhaps the same.
    pub of: &'a Forward,
    pub channel: usize,
    pub errors: [f32; 2],
}

impl<'a> Swap<'a> {
    pub fn back(&self) -> Back<'a> {
        Back::new(self.of, self.channel, self.errors)
    }

    /// Predicts pairs from a slice without the scans that `incidence` leaves out, and from swapped pairs without them.
    pub fn predicted(&self, slice: &Slice<'_>, incident: Ray, o: Ray, incidence: &Incidence) -> Blended {
        let incidence = if std::ptr::eq(self.of, self.forward) { incidence } else { &self.of.incidence };
        let there = self.of.place_by(incidence, self.channel, o);
        let both = self.back().estimates(slice, &self.forward.scans, (incident, 0.0), o, &there);
        let forward = slice.blended(o);
        let scale = self.forward.scale(self.channel, incident, slice.apart, 0.0);
        Blended { value: both.of(forward.value * scale), ..forward }
    }
}

/// What is known of directions as incident ones: a table by radius of an isotropic sample, by pixel of others.
#[derive(Debug)]
pub(crate) struct Places {
    line: bool,
    table: Vec<Place>,
}

impl Places {
    pub fn new(forward: &Forward, channel: usize) -> Places {
        let at = |k: usize| {
            let r = k as f32 / (N_RADII - 1) as f32;
            let z = 1.0 - r * r;
            forward.place(channel, [-(1.0 - z * z).max(0.0).sqrt(), 0.0, z])
        };
        let table = match forward.line {
            true => (0..N_RADII).map(at).collect(),
            false => Raster::directions(N_PIXELS).map(|d| forward.place(channel, d)).collect(),
        };
        Places { line: forward.line, table }
    }

    /// That of a direction itself, or within a step of the table by radius.
    pub fn at<'a>(&'a self, forward: &Forward, channel: usize, o: Ray) -> Cow<'a, Place> {
        match self.line {
            true => Cow::Borrowed(self.near(o)),
            false => Cow::Owned(forward.place(channel, o)),
        }
    }

    /// That of the nearest direction of the table: enough for errors.
    pub fn near(&self, o: Ray) -> &Place {
        let r = (1.0 - o[2]).max(0.0).sqrt() * (N_RADII - 1) as f32;
        &self.table[if self.line { (r + 0.5) as usize } else { Raster::pixel(N_PIXELS, lambert::point(o)) }]
    }
}
