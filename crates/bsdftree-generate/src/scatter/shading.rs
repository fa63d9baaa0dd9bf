//! Materials that are more than constants, and what modifiers make of any material.
//!
//! Extension point: a material of its own kind implements [`Shading`] and is made in `PreparedMaterial::prepare` as
//! `Prepared::Other`. It is given the [`Meeting`] of ray and surface and the [`Shade`] that the patterns and textures around it have
//! worked out, which it has to apply as Radiance does for it; [`Facing`] is what of both it needs for the most part. If it
//! has fields that can fail, it keeps the [`Watch`](super::faults::Watch) it is made with.

use std::fmt::Debug;

use bsdftree_device::field::RayState;
use glam::DVec3;

use super::frame::{mirrored, renormalized};
use super::{Meeting, Scatter, Spectrum};
use crate::random::Random;

/// A material that is asked with all that is known of a meeting.
pub(super) trait Shading<S>: Debug + Send + Sync {
    /// As [`PreparedMaterial::scatter`](super::PreparedMaterial::scatter).
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>>;

    /// As [`PreparedMaterial::medium`](super::PreparedMaterial::medium).
    fn medium(&self, _meeting: &Meeting, _shade: &Shade<S>, _front: bool) -> Option<DVec3> {
        None
    }
}

/// What patterns and textures make of a material at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shade<S> {
    /// What the material's colour is multiplied by.
    pub color: S,
    /// The same as RGB: for functions that ask for it, and for media.
    pub rgb: DVec3,
    /// What is added to the unit normal of the front (`Meeting::normal`) before it is made unit again.
    pub perturbation: DVec3,
    /// The length \[m\] that a pattern on a medium is for.
    pub unit: f64,
}

/// Radiance's least perturbation that counts, squared, and how far a direction has to be off the surface.
const LEAST_PERTURBATION: f64 = 1e-12;
const LEAST_HEIGHT: f64 = 1e-6;

impl<S: Spectrum> Shade<S> {
    /// Without modifiers.
    #[inline]
    pub fn of(meeting: &Meeting) -> Shade<S> {
        Shade { color: S::WHITE, rgb: DVec3::ONE, perturbation: meeting.local.perturbation, unit: 1.0 }
    }

    /// Without negative colours, which no light has.
    pub fn clamped(self) -> Shade<S> {
        Shade { color: self.color.clamped(), rgb: self.rgb.max(DVec3::ZERO), ..self }
    }
}

/// A surface seen from the side the ray comes from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facing {
    /// Unit normal of the surface itself.
    pub surface: DVec3,
    /// Unit normal with the perturbation, also on the side of the ray.
    pub normal: DVec3,
    /// Cosine of the ray to `normal`, in [0, 1].
    pub cosine: f64,
    /// The perturbation of `surface`; zero if it does not count.
    pub perturbation: DVec3,
}

impl Facing {
    /// With Radiance's rule for perturbations that would turn the surface away from the ray: they are mirrored.
    pub fn new<S>(meeting: &Meeting, shade: &Shade<S>) -> Facing {
        let (surface, own) = super::facing(meeting.normal, meeting.incoming);
        let plain = Facing { surface, normal: surface, cosine: own, perturbation: DVec3::ZERO };
        if shade.perturbation.length_squared() <= LEAST_PERTURBATION {
            return plain;
        }
        let perturbation = if meeting.is_front() { shade.perturbation } else { -shade.perturbation };
        let Some(normal) = (surface + perturbation).try_normalize() else { return plain };
        let cosine = -meeting.incoming.dot(normal);
        if cosine > 0.0 {
            return Facing { surface, normal, cosine: cosine.min(1.0), perturbation };
        }
        let turned = renormalized(normal + meeting.incoming * (2.0 * cosine));
        Facing { surface, normal: turned, cosine: (-cosine).min(1.0), perturbation }
    }

    /// Whether the normal is not that of the surface.
    pub fn is_textured(&self) -> bool {
        self.perturbation != DVec3::ZERO
    }

    /// Whether a direction leaves on the side of the ray.
    pub fn is_above(&self, direction: DVec3) -> bool {
        direction.dot(self.surface) > 0.0
    }

    /// The mirror direction, whichever side it is on.
    pub fn mirrored(&self, incoming: DVec3) -> DVec3 {
        mirrored(incoming, self.normal, self.cosine)
    }

    /// The mirror direction, without the perturbation if it would pierce the surface.
    pub fn mirrored_above(&self, incoming: DVec3) -> DVec3 {
        let direction = self.mirrored(incoming);
        if self.is_textured() && direction.dot(self.surface) <= LEAST_HEIGHT {
            return mirrored(incoming, self.surface, -incoming.dot(self.surface));
        }
        direction
    }

    /// Straight on, less the perturbation, but never back.
    pub fn through(&self, incoming: DVec3) -> DVec3 {
        match (incoming - self.perturbation).try_normalize() {
            Some(direction) if self.is_textured() && direction.dot(self.surface) < -LEAST_HEIGHT => direction,
            _ => incoming,
        }
    }

    /// Goes on in this direction, by either side.
    pub fn scatter<S: Spectrum>(&self, direction: DVec3, weight: S) -> Scatter<S> {
        Scatter { direction, weight, transmitted: !self.is_above(direction) }
    }
}

/// A meeting as patterns, textures and mixtures see it: the normal is that of the front.
pub(super) fn ray_state(meeting: &Meeting) -> RayState {
    RayState {
        direction: meeting.incoming,
        normal: meeting.normal,
        position: meeting.position,
        distance: meeting.distance,
        traveled: meeting.traveled,
        uv: meeting.local.uv,
        perturbed_normal: meeting.normal,
        perturbed_cosine: -meeting.incoming.dot(meeting.normal),
        color: DVec3::ONE,
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_support::direction;
    use super::*;

    #[test]
    fn perturbed_normals_stay_on_the_side_of_the_ray() {
        let mut random = Random::new(41, 0, 0);
        for _ in 0..10_000 {
            let meeting = Meeting::new(direction(&mut random), direction(&mut random));
            let perturbation = direction(&mut random) * (3.0 * random.next_f64());
            let facing = Facing::new(&meeting, &Shade { perturbation, ..Shade::<f64>::of(&meeting) });
            let incoming = meeting.incoming;
            assert!((facing.normal.length() - 1.0).abs() < 1e-12);
            assert!((facing.cosine + incoming.dot(facing.normal)).abs() < 1e-12 && facing.cosine >= 0.0);
            assert!(facing.surface.dot(incoming) <= 0.0);
            assert!(facing.mirrored_above(incoming).dot(facing.surface) > 0.0);
            assert!(facing.through(incoming).dot(facing.surface) < 0.0);
        }
    }
}
