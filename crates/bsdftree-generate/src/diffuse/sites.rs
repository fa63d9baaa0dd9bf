//! Sites: patches of surface, each on one side, that send out light they have diffused.
//!
//! In: a device and its entrance. Out: for any place on a surface its site; the area of a site and points on it; the medium it
//! lies in. Patches come of a pilot of ordinary paths from a few directions, so that they are fine where light
//! differs from place to place, interreflections included.

use bsdftree::{Rank, Side};
use bsdftree_device::Device;
use glam::DVec3;
use rayon::prelude::*;

use super::entrance::Entrance;
use super::partition::{Event, Key, N_AXES, Partition};
use super::points::{Point, Points};
use super::walk::{Lobes, Meeting, walk};
use crate::layout::Layout;
use crate::options::Aperture;
use crate::path::Scene;
use crate::random::Stratified;
use crate::scatter::Spectrum;
use crate::tile::Tile;

/// Points by which area is measured; each is a site's on its front and on its back.
const N_POINTS: usize = 1 << 18;

/// Incident directions of the pilot: 2^LOG2_PILOT per axis, from both sides.
const LOG2_PILOT: u32 = 3;

/// Paths of the pilot per incident direction and half.
const N_PILOT: u64 = 256;

/// Most sites. The product of all pairs of directions costs as much as there are sites.
pub(crate) const MAX_SITES: usize = 512;

/// A cut that changes less of the whole than this is not made.
const TOLERANCE: f64 = 2e-4;

/// Keeps the random numbers of the pilot apart from others of the same seed.
const PILOT: u64 = 0x70_696c_6f74;

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

/// From positions and normals to the coordinates that patches are cut along.
struct Frame {
    low: DVec3,
    inv_extent: DVec3,
    /// Corner and inverse extents of a period; zero where there is none.
    period: [[f64; 2]; 2],
}

impl Frame {
    fn new(device: &Device, folded: bool) -> Frame {
        let [low, high] = device.bounds().unwrap_or_default();
        let inverse = |extent: f64| if extent > 0.0 { 1.0 / extent } else { 0.0 };
        let mut period = [[0.0; 2]; 2];
        if let (true, Some([from, to])) = (folded, device.tile) {
            // What repeats but once in the box is told by the position.
            for axis in (0..2).filter(|&a| (to - from)[a] > 0.0 && (high - low)[a] > 2.0 * (to - from)[a]) {
                period[0][axis] = from[axis];
                period[1][axis] = inverse((to - from)[axis]);
            }
        }
        Frame { low, inv_extent: (high - low).map(inverse), period }
    }

    /// `normal` is the one on the side that is meant.
    #[inline]
    fn key(&self, position: DVec3, normal: DVec3) -> Key {
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
        let (_, materials) = scene.parts();
        let box_ = tile.map(|_| [aperture.min, aperture.max].map(DVec3::from_array));
        let spread = Points::spread(device, box_, fineness.n_points, |m| materials[m as usize].is_diffuse());
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
        let pilot = Pilot { scene, entrance: Entrance::new(device, aperture, tile), tile, frame, media, seed };
        let mut events = pilot.run(fineness.n_pilot);
        let n_origins = 2 << (2 * LOG2_PILOT);
        let (partition, patches) =
            Partition::grow(&mut keys, &mut events, n_origins, fineness.max_sites, fineness.tolerance);
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

/// The media that a walk can be in, the first of which is none.
fn media(device: &Device) -> Vec<Option<DVec3>> {
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
struct Pilot<'a, S> {
    scene: &'a Scene<S>,
    entrance: Entrance,
    tile: Option<&'a Tile>,
    frame: Frame,
    media: Vec<Option<DVec3>>,
    seed: u64,
}

impl<S: Spectrum> Pilot<'_, S> {
    fn run(&self, n_paths: u64) -> Vec<Event> {
        let n_cells = 1usize << (2 * LOG2_PILOT);
        let events: Vec<Vec<Event>> = (0..2 * n_cells)
            .into_par_iter()
            .map(|origin| {
                let side = if origin < n_cells { Side::Front } else { Side::Back };
                self.from_cell(side, origin % n_cells, origin as u16, n_paths)
            })
            .collect();
        events.concat()
    }

    fn from_cell(&self, side: Side, cell: usize, origin: u16, n_paths: u64) -> Vec<Event> {
        let layout = Layout::Tree { rank: Rank::Four, log2_res: LOG2_PILOT };
        let seed = self.seed ^ PILOT;
        let stream = u64::from(origin);
        let stratified = Stratified::new(seed, stream);
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
            if let Some(every) = every.filter(|every| (sample / 2).is_multiple_of(*every)) {
                if let Some((ray, flux)) = self.entrance.through_rest(side, direction, start.origin) {
                    follow(ray, 0.0, flux * every as f64);
                }
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
            events.push(Event {
                key,
                origin,
                half,
                medium,
                sent: sent as f32,
                returned: returned as f32,
            });
        };
        push(meeting.facing, sent * reflected, returned * arrived * meeting.reversal);
        if transmitted > 0.0 {
            push(-meeting.facing, sent * transmitted, 0.0);
        }
    }
}
