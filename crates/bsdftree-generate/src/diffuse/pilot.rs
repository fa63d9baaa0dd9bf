//! A pilot of ordinary paths from a few incident directions, which tells where light meets surfaces.
//!
//! In: a device and its entrance. Out: events for [`partition`](super::partition). Light is diffused here as it is, so
//! that patches are fine also where light comes by way of other patches.

use bsdftree::{Rank, Side};
use bsdftree_device::Device;
use glam::DVec3;
use rayon::prelude::*;

use super::partition::{Event, Key, N_AXES};
use super::walk::{Lobes, Meeting, walk};
use crate::entrance::Entrance;
use crate::layout::Layout;
use crate::path::Scene;
use crate::random::Stratified;
use crate::scatter::Spectrum;
use crate::tile::Tile;

/// Incident directions of the pilot: 2^LOG2_PILOT per axis, from both sides.
const LOG2_PILOT: u32 = 3;

/// Incident cells of both sides.
pub(super) const N_ORIGINS: usize = 2 << (2 * LOG2_PILOT);

/// Keeps the random numbers of the pilot apart from others of the same seed.
const PILOT: u64 = 0x70_696c_6f74;

/// From positions and normals to the coordinates that patches are cut along.
pub(super) struct Frame {
    low: DVec3,
    inv_extent: DVec3,
    /// Corner and inverse extents of a period; zero where there is none.
    period: [[f64; 2]; 2],
}

impl Frame {
    /// `periods` are those within which equal places can share a patch.
    pub fn new(device: &Device, periods: [Option<f64>; 2]) -> Frame {
        let [low, high] = device.bounds().unwrap_or_default();
        let inverse = |extent: f64| if extent > 0.0 { 1.0 / extent } else { 0.0 };
        let period = [[low.x, low.y], periods.map(|period| inverse(period.unwrap_or(0.0)))];
        Frame { low, inv_extent: (high - low).map(inverse), period }
    }

    /// `normal` is the one on the side that is meant.
    #[inline]
    pub fn key(&self, position: DVec3, normal: DVec3) -> Key {
        let p = ((position - self.low) * self.inv_extent).as_vec3();
        let n = normal.as_vec3();
        let [from, inverse] = self.period;
        let folded = [0, 1].map(|k| {
            let turns = (position[k] - from[k]) * inverse[k];
            (turns - turns.floor()) as f32
        });
        let key: [f32; N_AXES] = [p.x, p.y, p.z, n.x, n.y, n.z, folded[0], folded[1]];
        key
    }
}

/// The media that a walk can be in, the first of which is none.
pub(super) fn media(device: &Device) -> Vec<Option<DVec3>> {
    let mut media = vec![None];
    for named in &device.materials {
        if let bsdftree_device::Material::Dielectric { inside, outside } = &named.material {
            for medium in [inside, outside] {
                let transmittance = (medium.transmittance != DVec3::ONE).then_some(medium.transmittance);
                if !media.contains(&transmittance) && media.len() < usize::from(u8::MAX) {
                    media.push(transmittance);
                }
            }
        }
    }
    media
}

/// Ordinary paths that tell where light meets surfaces.
pub(super) struct Pilot<'a, S> {
    pub scene: &'a Scene<S>,
    pub entrance: &'a Entrance,
    pub tile: Option<&'a Tile>,
    pub frame: Frame,
    pub media: Vec<Option<DVec3>>,
    pub seed: u64,
}

impl<S: Spectrum> Pilot<'_, S> {
    pub fn run(&self, n_paths: u64) -> Vec<Event> {
        let n_cells = 1usize << (2 * LOG2_PILOT);
        let events: Vec<Vec<Event>> = (0..2 * n_cells)
            .into_par_iter()
            .map(|origin| {
                let side = if origin < n_cells { Side::Front } else { Side::Back };
                self.cell(side, origin % n_cells, origin as u16, n_paths)
            })
            .collect();
        events.concat()
    }

    fn cell(&self, side: Side, cell: usize, origin: u16, n_paths: u64) -> Vec<Event> {
        let layout = Layout::Tree { rank: Rank::Four, log2_res: LOG2_PILOT };
        let seed = self.seed ^ PILOT;
        let stream = u64::from(origin);
        let mut stratified = Stratified::new(seed, stream);
        let mut events = Vec::new();
        for sample in 0..2 * n_paths {
            let mut start = stratified.start(seed, stream, sample);
            let [u, v] = start.incident;
            let toward = side.opposite().direction_from_disk(layout.incident_disk(cell, u, v));
            let direction = DVec3::from_array(toward);
            let half = (sample % 2) as u8;
            let outermost = f64::from(u8::from(self.entrance.is_outermost(side)));
            let mut follow = |ray, sent: f64, returned: f64| {
                walk(self.scene, self.tile, Lobes::All, (ray, None), &mut start.random, |meeting| {
                    self.note(&mut events, (origin, half), &meeting, [sent, returned]);
                });
            };
            follow(self.entrance.through_aperture(side, direction, start.origin), 1.0, outermost);
            let every = self.entrance.sparsity(side, direction);
            if let Some(every) = every.filter(|every| (sample / 2).is_multiple_of(*every))
                && let Some((ray, flux)) = self.entrance.through_rest(side, direction, start.origin)
            {
                follow(ray, 0.0, flux * every as f64);
            }
        }
        events
    }

    fn note(
        &self,
        events: &mut Vec<Event>,
        (origin, half): (u16, u8),
        meeting: &Meeting<S>,
        [sent, returned]: [f64; 2],
    ) {
        let arrived = meeting.arrived.luminance();
        let medium = self.media.iter().position(|m| *m == meeting.medium).unwrap_or(0) as u8;
        let [reflected, transmitted] = meeting.albedo.map(|a| (meeting.arrived * a).luminance());
        let mut push = |normal: DVec3, sent: f64, returned: f64| {
            let key = self.frame.key(meeting.hit.position, normal);
            events.push(Event { key, origin, half, medium, sent: sent as f32, returned: returned as f32 });
        };
        push(meeting.facing, sent * reflected, returned * arrived * meeting.reversal);
        if transmitted > 0.0 {
            push(-meeting.facing, sent * transmitted, 0.0);
        }
    }
}
