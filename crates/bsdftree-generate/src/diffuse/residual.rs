//! Full paths of light that is diffused: what the model is checked against, and corrected by.
//!
//! In: incident cells. Out: exits and weights whose mean is the diffuse part of the BSDF, without sites. A path is a walk without
//! diffuse scattering, of whose meetings one is taken with the probability of the light it diffuses, and a path with all lobes
//! from there.

use bsdftree::Side;
use glam::DVec3;

use super::deposit::Walker;
use super::walk::{Lobes, Meeting, walk};
use crate::bvh::Ray;
use crate::path::Outcome;
use crate::random::{Random, Stratified};
use crate::scatter::{Spectrum, lambertian_direction};

/// Keeps the random numbers of these paths apart from others of the same seed.
const RESIDUAL: u64 = 0x72_6573_6964;
const BEFORE: u64 = 0x62_6566_6f72;

/// Where a path goes on: one of the meetings so far.
struct Chosen<S> {
    ray: Ray,
    medium: Option<DVec3>,
    weight: S,
}

impl<S: Spectrum> Walker<'_, S> {
    /// Follows diffused paths from an incident cell of the layout; tells `left` the number of the path, the incident point of the
    /// disk, the direction and the weight of each that leaves. Returns how many did not end.
    pub fn follow_diffused(
        &self,
        side: Side,
        cell: usize,
        paths: std::ops::Range<u64>,
        mut left: impl FnMut(u64, [f64; 2], DVec3, S),
    ) -> u64 {
        let stream = (cell as u64) << 1 | u64::from(side == Side::Back);
        let seed = self.seed ^ RESIDUAL;
        let mut stratified = Stratified::new(seed, stream);
        let mut lost = 0;
        for path in paths {
            let mut start = self.start(&mut stratified, seed, stream, path);
            let [u, v] = start.incident;
            let disk = self.layout.incident_disk(cell, u, v);
            let direction = DVec3::from_array(side.opposite().direction_from_disk(disk));
            let ray = self.entrance.through_aperture(side, direction, start.origin);
            // The even words go to the choice among meetings and to the way on; the walk before them has a stream of its own.
            let mut before = Random::new(self.seed ^ BEFORE, stream, path);
            let mut chosen: Option<Chosen<S>> = None;
            let mut luminance = 0.0;
            walk(self.scene, self.tile, Lobes::Specular, (ray, None), &mut before, |meeting| {
                for side in 0..2 {
                    let sent = (meeting.arrived * meeting.albedo[side]).luminance();
                    if sent > 0.0 {
                        luminance += sent;
                        if start.random.next_open() * luminance < sent {
                            chosen = Some(onward(
                                &meeting,
                                side,
                                [start.random.next_open(), start.random.next_open()],
                            ));
                        }
                    }
                }
            });
            let Some(Chosen { ray, medium, weight }) = chosen else { continue };
            let weight = weight * (luminance / weight.luminance());
            match walk(self.scene, self.tile, Lobes::All, (ray, medium), &mut start.random, |_| {}) {
                Outcome::Left(exitant, rest) => left(path, disk, exitant, weight * rest),
                Outcome::Absorbed => {}
                Outcome::Lost => lost += 1,
            }
        }
        lost
    }
}

/// The way on from a meeting by diffuse reflection or transmission.
fn onward<S: Spectrum>(meeting: &Meeting<S>, side: usize, point: [f64; 2]) -> Chosen<S> {
    let normal = if side == 0 { meeting.facing } else { -meeting.facing };
    let direction = lambertian_direction(normal, point);
    let ray = Ray { origin: meeting.hit.position, direction, from: Some(meeting.hit.part) };
    Chosen { ray, medium: meeting.medium, weight: meeting.arrived * meeting.albedo[side] }
}
