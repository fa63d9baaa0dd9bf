//! Sites: patches of surface, each on one side, that send out light they have diffused.
//!
//! In: a device and its entrance. Out: for any place on a surface its site; the area of a site and points on it; the medium it
//! lies in. Patches come of a pilot of ordinary paths from a few directions, so that they are fine where light
//! differs from place to place, interreflections included.

use std::ops::Range;

use bsdftree_device::Device;
use glam::DVec3;
use rayon::prelude::*;

#[cfg(test)]
use super::partition::N_AXES;
use super::partition::{Key, Partition};
use super::pilot::{Frame, N_ORIGINS, Pilot, media};
use super::points::{Point, Points};
use crate::entrance::Entrance;
use crate::path::Scene;
use crate::scatter::Spectrum;
use crate::tile::Tile;

/// Points by which area is measured; each is a site's on its front and on its back.
const N_POINTS: usize = 1 << 18;

/// Paths of the pilot per incident direction and half.
const N_PILOT: u64 = 512;

/// Most sites. The product of all pairs of directions costs as much as there are sites.
pub(crate) const MAX_SITES: usize = 256;

/// A cut that changes less of the whole than this is not made.
const TOLERANCE: f64 = 1e-4;

/// Everything that sends out diffused light, in patches.
pub(crate) struct Sites {
    partition: Partition,
    frame: Frame,
    /// Places that measure area.
    points: Vec<Point>,
    /// Site by site its points: twice the number of the place, and one more for its back.
    order: Vec<u32>,
    /// Where those of each site end.
    ends: Vec<usize>,
    area_each: f64,
    media: Vec<Option<DVec3>>,
}

/// What the fineness of the sites depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fineness {
    pub max_sites: usize,
    pub tolerance: f64,
    pub n_pilot: u64,
    pub n_points: usize,
}

impl Default for Fineness {
    fn default() -> Self {
        Fineness { max_sites: MAX_SITES, tolerance: TOLERANCE, n_pilot: N_PILOT, n_points: N_POINTS }
    }
}

impl Sites {
    /// `None` if no surface is diffuse.
    pub fn build<S: Spectrum>(
        scene: &Scene<S>,
        device: &Device,
        entrance: &Entrance,
        tile: Option<&Tile>,
        fineness: Fineness,
        seed: u64,
    ) -> Option<Sites> {
        let (bvh, materials) = scene.parts();
        let box_ = tile.map(|_| entrance.corners());
        let is_diffuse = |m: u32| materials[m as usize].is_diffuse();
        let spread = Points::spread(device, bvh, box_, fineness.n_points, is_diffuse);
        if spread.points.is_empty() {
            return None;
        }
        let Points { points, area_each } = spread;
        let periods = if tile.is_none() { entrance.periods() } else { [None; 2] };
        let frame = Frame::new(device, periods);
        let mut keys: Vec<Key> = points
            .iter()
            .flat_map(|p| [p.normal, -p.normal].map(|normal| frame.key(p.position, normal)))
            .collect();
        let media = media(device);
        let pilot = Pilot { scene, entrance, tile, frame, media, seed };
        let mut events = pilot.run(fineness.n_pilot);
        let (partition, patches) =
            Partition::grow(&mut keys, &mut events, N_ORIGINS, fineness.max_sites, fineness.tolerance);
        let media = patches.iter().map(|patch| {
            let first = events[patch.events.clone()].first();
            first.and_then(|event| pilot.media[usize::from(event.medium)])
        });
        let media = media.collect();
        let mut sites = Sites {
            points,
            order: Vec::new(),
            ends: vec![0; patches.len()],
            area_each,
            media,
            partition,
            frame: pilot.frame,
        };
        sites.sort();
        Some(sites)
    }

    /// Finds the site of each point, on its front and on its back.
    fn sort(&mut self) {
        let find = |p: &Point| [p.normal, -p.normal].map(|normal| self.find(p.position, normal) as u32);
        let found: Vec<[u32; 2]> = self.points.par_iter().map(find).collect();
        let mut next = vec![0u32; self.ends.len()];
        found.iter().flatten().for_each(|&site| next[site as usize] += 1);
        let mut end = 0;
        for (next, site_end) in next.iter_mut().zip(&mut self.ends) {
            let begin = end;
            end += *next as usize;
            (*next, *site_end) = (begin as u32, end);
        }
        self.order = vec![0; end];
        for (k, &site) in found.iter().flatten().enumerate() {
            let place = &mut next[site as usize];
            self.order[*place as usize] = k as u32;
            *place += 1;
        }
    }

    #[cfg(test)]
    pub fn cuts(&self) -> [usize; N_AXES] {
        self.partition.cuts()
    }

    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// The site at a place on a surface, on the side that `normal` points to.
    #[inline]
    pub fn find(&self, position: DVec3, normal: DVec3) -> usize {
        self.partition.find(&self.frame.key(position, normal))
    }

    fn range(&self, site: usize) -> Range<usize> {
        site.checked_sub(1).map_or(0, |before| self.ends[before])..self.ends[site]
    }

    /// The point of the site that lies where `share` of its area lie before it, with a normal that points to its side.
    pub fn point(&self, site: usize, share: f64) -> Point {
        let order = &self.order[self.range(site)];
        let k = order[(share * order.len() as f64) as usize];
        let point = self.points[k as usize / 2];
        if k.is_multiple_of(2) { point } else { Point { normal: -point.normal, ..point } }
    }

    /// \[m²\].
    pub fn area(&self, site: usize) -> f64 {
        self.range(site).len() as f64 * self.area_each
    }

    /// Transmittance \[1/m\] of the medium that the site sends light into.
    pub fn medium(&self, site: usize) -> Option<DVec3> {
        self.media[site]
    }
}
