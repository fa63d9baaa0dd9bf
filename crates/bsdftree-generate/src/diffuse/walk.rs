//! One walk through a device that tells what it meets.
//!
//! As [`Scene::follow`](crate::path::Scene::follow), but the diffuse lobes of what is met may be left out, and at each meeting
//! the caller hears what arrived. Invariant: all materials are plain ([`Scene::is_plain`](crate::path::Scene::is_plain)). Source of the roulette: see [`path`](crate::path).

use glam::DVec3;

use crate::bvh::{Hit, Ray};
use crate::path::{Outcome, Scene};
use crate::random::Random;
use crate::scatter::{Spectrum, attenuation};
use crate::tile::Tile;

/// Luminous weight under which a walk has to survive the roulette.
const FAINT: f64 = 0.05;

/// As for paths.
const MAX_BOUNCES: u32 = 10_000;

/// Which lobes a walk goes on by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lobes {
    /// All but the diffuse ones.
    Specular,
    /// All.
    All,
}

/// Light at a surface that has diffuse lobes.
pub(crate) struct Meeting<'a, S> {
    pub hit: &'a Hit,
    /// Unit normal on the side the light came from.
    pub facing: DVec3,
    /// The walk's weight.
    pub arrived: S,
    /// What the weight is multiplied by to be that of light travelling back.
    pub reversal: f64,
    /// The fractions that are diffused: on this side, on the other.
    pub albedo: [S; 2],
    /// Transmittance \[1/m\] of the medium the light came through, if it has any.
    pub medium: Option<DVec3>,
}

/// Follows a walk that starts in a medium. `meet` is told of each diffuse surface.
#[inline]
pub(crate) fn walk<S: Spectrum>(
    scene: &Scene<S>,
    tile: Option<&Tile>,
    lobes: Lobes,
    (mut ray, mut medium): (Ray, Option<DVec3>),
    random: &mut Random,
    mut meet: impl FnMut(Meeting<S>),
) -> Outcome<S> {
    let (bvh, materials) = scene.parts();
    let mut weight = S::WHITE;
    let mut reversal = 1.0;
    for _ in 0..MAX_BOUNCES {
        let hit = bvh.closest(&ray);
        if let Some((again, t)) = tile.and_then(|tile| tile.wrapped(&ray, hit.map_or(f64::INFINITY, |h| h.t)))
        {
            if let Some(transmittance) = medium {
                weight = weight * attenuation::<S>(transmittance, t);
            }
            ray = again;
            continue;
        }
        let Some(hit) = hit else { return Outcome::Left(ray.direction, weight) };
        let material = &materials[hit.material as usize];
        let before = material.medium_plain(hit.front).or(medium);
        if let Some(transmittance) = before {
            weight = weight * attenuation::<S>(transmittance, hit.t);
        }
        if material.is_diffuse() {
            let facing = if hit.front { hit.normal } else { -hit.normal };
            let albedo = material.diffuse_albedo(ray.direction.dot(hit.normal).abs().min(1.0));
            meet(Meeting { hit: &hit, facing, arrived: weight, reversal, albedo, medium });
        }
        let scatter = match lobes {
            Lobes::Specular => material.scatter_specular(hit.normal, ray.direction, random),
            Lobes::All => material.scatter_plain(hit.normal, ray.direction, random),
        };
        let Some(scatter) = scatter else { return Outcome::Absorbed };
        if lobes == Lobes::Specular || !material.is_diffuse() {
            reversal *= material.reversal(hit.normal, ray.direction, &scatter);
        }
        weight = weight * scatter.weight;
        let luminance = weight.luminance();
        if luminance < FAINT {
            let survival = luminance / FAINT;
            if random.next_f64() >= survival {
                return Outcome::Absorbed;
            }
            weight = weight / survival;
        }
        if let Some(entered) = material.medium_plain(hit.front != scatter.transmitted) {
            medium = (entered != DVec3::ONE).then_some(entered);
        }
        ray = Ray { origin: hit.position, direction: scatter.direction, from: Some(hit.part) };
    }
    Outcome::Lost
}
