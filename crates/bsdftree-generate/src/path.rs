//! One path through a device: in at the aperture, out by a direction with a weight.
//!
//! The weight's mean over random numbers is the fraction of light that leaves by a direction. Nothing is cut off: faint paths
//! are ended at random and the survivors carry their share (Russian roulette, J. Arvo and D. Kirk, SIGGRAPH 1990).
//! A path that meets nothing more has left, whichever way it goes: receivers are at infinity, as in Radiance's genBSDF.

use bsdftree_device::Device;
use glam::DVec3;

use crate::bvh::{Bvh, BvhError, Ray};
use crate::random::Random;
use crate::scatter::{PreparedMaterial, Spectrum, attenuation};
use crate::tile::Tile;

/// Luminous weight under which a path has to survive the roulette.
const FAINT: f64 = 0.05;

/// A path this long is trapped by rounding, as in a closed mirror box with a leak, or skims a tile for ever: it is counted as
/// lost.
const MAX_BOUNCES: u32 = 10_000;

/// A device ready for paths that carry `S`.
pub struct Scene<S> {
    bvh: Bvh,
    materials: Vec<PreparedMaterial<S>>,
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
        let materials = device.materials.iter().map(|m| PreparedMaterial::new(&m.material)).collect();
        Ok(Scene { bvh: Bvh::build(device)?, materials })
    }

    /// What rays meet, and what it is made of.
    pub(crate) fn parts(&self) -> (&Bvh, &[PreparedMaterial<S>]) {
        (&self.bvh, &self.materials)
    }

    /// Follows a path from a point along a unit direction, through a device that is alone or repeats by a tile.
    #[inline]
    pub fn follow(
        &self,
        origin: DVec3,
        direction: DVec3,
        tile: Option<&Tile>,
        random: &mut Random,
    ) -> Outcome<S> {
        let mut ray = Ray { origin, direction, from: None };
        let mut weight = S::WHITE;
        let mut medium: Option<DVec3> = None;
        for _ in 0..MAX_BOUNCES {
            let hit = self.bvh.closest(&ray);
            if let Some((again, t)) =
                tile.and_then(|tile| tile.wrapped(&ray, hit.map_or(f64::INFINITY, |h| h.t)))
            {
                if let Some(transmittance) = medium {
                    weight = weight * attenuation::<S>(transmittance, t);
                }
                ray = again;
                continue;
            }
            let Some(hit) = hit else { return Outcome::Left(ray.direction, weight) };
            let material = &self.materials[hit.material as usize];
            if let Some(transmittance) = material.medium(hit.front).or(medium) {
                weight = weight * attenuation::<S>(transmittance, hit.t);
            }
            let Some(scatter) = material.scatter(hit.normal, ray.direction, random) else {
                return Outcome::Absorbed;
            };
            weight = weight * scatter.weight;
            let luminance = weight.luminance();
            if luminance < FAINT {
                let survival = luminance / FAINT;
                if random.next_f64() >= survival {
                    return Outcome::Absorbed;
                }
                weight = weight / survival;
            }
            if let Some(entered) = material.medium(hit.front != scatter.transmitted) {
                medium = (entered != DVec3::ONE).then_some(entered);
            }
            ray = Ray { origin: hit.position, direction: scatter.direction, from: Some(hit.surface) };
        }
        Outcome::Lost
    }
}
