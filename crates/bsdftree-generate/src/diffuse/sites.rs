//! Sites: patches of surface, each on one side, that send out light they have diffused.
//!
//! In: a device and its entrance. Out: for any place on a surface its site; the area of a site and points on it; the medium it
//! lies in. Patches come of a pilot of ordinary paths from a few directions, so that they are fine where light
//! differs from place to place, interreflections included.

use bsdftree_device::Device;
use glam::DVec3;
use rayon::prelude::*;

use super::entrance::Entrance;
#[cfg(test)]
use super::partition::N_AXES;
use super::partition::{Key, Partition};
use super::pilot::{Frame, N_ORIGINS, Pilot, media};
use super::points::{Point, Points};
use crate::options::Aperture;
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
    /// Points of all sites, site by site.
    points: Vec<Point>,
    /// Where the points of each site end.
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
        aperture: &Aperture,
        tile: Option<&Tile>,
        fineness: Fineness,
        seed: u64,
    ) -> Option<Sites> {
        let (bvh, materials) = scene.parts();
        let box_ = tile.map(|_| [aperture.min, aperture.max].map(DVec3::from_array));
        let is_diffuse = |m: u32| materials[m as usize].is_diffuse();
        let spread = Points::spread(device, bvh, box_, fineness.n_points, is_diffuse);
        if spread.points.is_empty() {
            return None;
        }
        let frame = Frame::new(device, tile.is_none());
        let n = spread.points.len();
        let mut keys: Vec<(Key, u32)> = (0..2 * n)
            .into_par_iter()
            .map(|k| {
                let p = &spread.points[k % n];
                (frame.key(p.position, if k < n { p.normal } else { -p.normal }), k as u32)
            })
            .collect();
        let media = media(device);
        let pilot =
            Pilot { scene, entrance: Entrance::new(device, aperture, tile), tile, frame, media, seed };
        let mut events = pilot.run(fineness.n_pilot);
        let (partition, patches) =
            Partition::grow(&mut keys, &mut events, N_ORIGINS, fineness.max_sites, fineness.tolerance);
        let points = keys.iter().map(|&(_, k)| {
            let point = spread.points[k as usize % n];
            Point { normal: if (k as usize) < n { point.normal } else { -point.normal }, ..point }
        });
        let media = patches.iter().map(|patch| {
            let first = events[patch.events.clone()].first();
            first.and_then(|event| pilot.media[usize::from(event.medium)])
        });
        // Patches lie in the order of their points only within the tree.
        let mut sites = Sites {
            points: Vec::with_capacity(2 * n),
            ends: Vec::with_capacity(patches.len()),
            area_each: spread.area_each,
            media: media.collect(),
            partition,
            frame: pilot.frame,
        };
        let points: Vec<Point> = points.collect();
        for patch in &patches {
            sites.points.extend_from_slice(&points[patch.points.clone()]);
            sites.ends.push(sites.points.len());
        }
        Some(sites)
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

    /// Points of equal shares of the site's area, with normals that point to its side.
    pub fn points(&self, site: usize) -> &[Point] {
        &self.points[site.checked_sub(1).map_or(0, |before| self.ends[before])..self.ends[site]]
    }

    /// \[m²\].
    pub fn area(&self, site: usize) -> f64 {
        self.points(site).len() as f64 * self.area_each
    }

    /// Transmittance \[1/m\] of the medium that the site sends light into.
    pub fn medium(&self, site: usize) -> Option<DVec3> {
        self.media[site]
    }
}
