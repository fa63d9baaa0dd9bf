//! One path through a device: in at the aperture, out by a direction with a weight.
//!
//! The weight's mean over random numbers is the fraction of light that leaves by a direction. Nothing is cut off: faint paths
//! are ended at random and the survivors carry their share (Russian roulette, J. Arvo and D. Kirk, SIGGRAPH 1990).
//! A path that meets nothing more has left, whichever way it goes: receivers are at infinity, as in Radiance's genBSDF.

mod antimatter;
mod wave;

use std::sync::Arc;

use bsdftree_device::{Device, NamedMaterial, Shape};
use glam::DVec3;

use crate::bvh::{Bvh, BvhError, Hit, Ray};
use crate::random::Random;
use crate::scatter::{Faults, Meeting, PreparedMaterial, Scatter, Spectrum, attenuation};
use crate::tile::Tile;

use antimatter::{Seen, Volumes, Within};
pub use wave::Departure;

/// Luminous weight under which a path has to survive the roulette.
const FAINT: f64 = 0.05;

/// A path this long is trapped by rounding, as in a closed mirror box with a leak, or skims a tile for ever: it is counted as
/// lost.
const MAX_BOUNCES: u32 = 10_000;

/// A device ready for paths that carry `S`.
pub struct Scene<S> {
    bvh: Bvh,
    materials: Vec<PreparedMaterial<S>>,
    /// Whether all materials are plain, no surface is a smooth mesh, and there is no antimatter.
    is_plain: bool,
    /// Where materials are not there, if the device has antimatter.
    volumes: Option<Volumes>,
    faults: Arc<Faults>,
}

/// How a path ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome<S> {
    /// It left by this direction of travel.
    Left(DVec3, S),
    /// It was absorbed.
    Absorbed,
    /// It did not end within 10 000 bounces.
    Lost,
}

impl<S: Spectrum> Scene<S> {
    /// Prepares a device.
    pub fn new(device: &Device) -> Result<Scene<S>, BvhError> {
        let faults = Arc::new(Faults::default());
        let prepared = |m: &NamedMaterial| PreparedMaterial::prepare(&m.material, &m.name, &faults);
        let materials: Vec<_> = device.materials.iter().map(prepared).collect();
        let is_smooth =
            |shape: &Shape| matches!(shape, Shape::Mesh(mesh) if !mesh.vertices.normals.is_empty());
        let volumes = Volumes::new(device);
        let is_plain = volumes.is_none()
            && materials.iter().all(PreparedMaterial::is_plain)
            && !device.surfaces.iter().any(|surface| is_smooth(&surface.shape));
        Ok(Scene { bvh: Bvh::build(device)?, materials, is_plain, volumes, faults })
    }

    /// What went wrong at surfaces so far: after a failure, no path is right.
    pub fn faults(&self) -> &Faults {
        &self.faults
    }

    /// Whether how a ray scatters depends on nothing but the material and two directions.
    pub(crate) fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// What rays meet, and what it is made of.
    pub(crate) fn parts(&self) -> (&Bvh, &[PreparedMaterial<S>]) {
        (&self.bvh, &self.materials)
    }

    /// What finds the first surface on each ray.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Follows a path from a point along a unit direction, through a device that is alone or repeats by a tile.
    pub fn follow(
        &self,
        origin: DVec3,
        direction: DVec3,
        tile: Option<&Tile>,
        random: &mut Random,
    ) -> Outcome<S> {
        self.follow_seen(origin, direction, tile, random, |_| ())
    }

    /// [`Scene::follow`], showing each ray before its first surface is sought.
    #[inline]
    pub fn follow_seen(
        &self,
        origin: DVec3,
        direction: DVec3,
        tile: Option<&Tile>,
        random: &mut Random,
        mut seen: impl FnMut(&Ray),
    ) -> Outcome<S> {
        let mut path = Path::new(origin, direction);
        loop {
            seen(&path.ray);
            let hit = self.bvh.closest(&path.ray);
            if let Some(outcome) = self.advance(&mut path, hit, tile, random) {
                return outcome;
            }
        }
    }

    /// Takes a path from where its ray ends to its next ray; or how it ended.
    #[inline(always)]
    fn advance(
        &self,
        path: &mut Path<S>,
        hit: Option<Hit>,
        tile: Option<&Tile>,
        random: &mut Random,
    ) -> Option<Outcome<S>> {
        let ray = path.ray;
        if let Some((again, t)) = tile.and_then(|tile| tile.wrapped(&ray, hit.map_or(f64::INFINITY, |h| h.t)))
        {
            if let Some(transmittance) = path.medium {
                path.weight = path.weight * attenuation::<S>(transmittance, t);
            }
            path.traveled += t;
            return path.go_on(again);
        }
        let Some(hit) = hit else { return Some(Outcome::Left(ray.direction, path.weight)) };
        let Met { before, scatter, after } =
            if self.is_plain { self.meet(path, &hit, random) } else { self.meet_varying(path, &hit, random) };
        let mut weight = path.weight;
        if let Some(transmittance) = before.or(path.medium) {
            weight = weight * attenuation::<S>(transmittance, hit.t);
        }
        let Some(scatter) = scatter else { return Some(Outcome::Absorbed) };
        weight = weight * scatter.weight;
        let luminance = weight.luminance();
        if luminance < FAINT {
            let survival = luminance / FAINT;
            if random.next_f64() >= survival {
                return Some(Outcome::Absorbed);
            }
            weight = weight / survival;
        }
        path.weight = weight;
        if let Some(entered) = after {
            path.medium = (entered != DVec3::ONE).then_some(entered);
        }
        path.go_on(Ray { origin: hit.position, direction: scatter.direction, from: Some(hit.part) })
    }
}

/// What a surface does with a path: its media in front of it, on the path's way, and behind.
struct Met<S> {
    before: Option<DVec3>,
    scatter: Option<Scatter<S>>,
    after: Option<DVec3>,
}

impl<S: Spectrum> Scene<S> {
    #[inline(always)]
    fn meet(&self, path: &Path<S>, hit: &Hit, random: &mut Random) -> Met<S> {
        let material = &self.materials[hit.material as usize];
        let scatter = material.scatter_plain(hit.normal, path.ray.direction, random);
        let after = scatter.and_then(|s| material.medium_plain(hit.front != s.transmitted));
        Met { before: material.medium_plain(hit.front), scatter, after }
    }

    /// [`meet`](Self::meet) for any material and any surface.
    #[inline(never)]
    fn meet_varying(&self, path: &mut Path<S>, hit: &Hit, random: &mut Random) -> Met<S> {
        let meeting = Meeting::of(&self.bvh, &path.ray, hit, path.traveled);
        path.traveled = meeting.traveled;
        let Some(volumes) = &self.volumes else { return self.meet_as(hit.material, &meeting, random) };
        let within = path.within.get_or_insert_with(|| Box::new(volumes.outside()));
        let met = match volumes.meet(within, hit) {
            Seen::Nothing => {
                let scatter = Scatter { direction: meeting.incoming, weight: S::WHITE, transmitted: true };
                Met { before: None, scatter: Some(scatter), after: None }
            }
            Seen::Surface => self.meet_as(hit.material, &meeting, random),
            Seen::Skin(material) => self.meet_as(material, &meeting.turned_over(), random),
        };
        if met.scatter.is_some_and(|s| s.transmitted) {
            volumes.pass(within, hit);
        }
        met
    }

    fn meet_as(&self, material: u32, meeting: &Meeting, random: &mut Random) -> Met<S> {
        let material = &self.materials[material as usize];
        let front = meeting.is_front();
        let scatter = material.scatter(meeting, random);
        let after = scatter.and_then(|s| material.medium(meeting, front != s.transmitted));
        Met { before: material.medium(meeting, front), scatter, after }
    }
}

/// A path under way.
struct Path<S> {
    ray: Ray,
    weight: S,
    /// Transmittance \[1/m\] of what it is in, if not air.
    medium: Option<DVec3>,
    /// Its length so far \[m\].
    traveled: f64,
    bounces: u32,
    /// What it is inside of, once it has met something in a device with antimatter.
    within: Option<Box<Within>>,
}

impl<S: Spectrum> Path<S> {
    #[inline(always)]
    fn new(origin: DVec3, direction: DVec3) -> Path<S> {
        let ray = Ray { origin, direction, from: None };
        Path { ray, weight: S::WHITE, medium: None, traveled: 0.0, bounces: 0, within: None }
    }

    /// `None`, unless this was the last bounce allowed.
    #[inline(always)]
    fn go_on(&mut self, ray: Ray) -> Option<Outcome<S>> {
        self.ray = ray;
        self.bounces += 1;
        (self.bounces == MAX_BOUNCES).then_some(Outcome::Lost)
    }
}
