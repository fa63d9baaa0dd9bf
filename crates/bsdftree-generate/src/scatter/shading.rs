//! Materials that are more than constants, and what modifiers make of any material.
//!
//! Extension point: a material of its own kind implements [`Shading`] and is made in `PreparedMaterial::new` as
//! `Prepared::Other`. It is given the [`Meeting`] of ray and surface and the [`Shade`] that the patterns and textures around it have
//! worked out, which it has to apply as Radiance does for it.

use std::fmt::Debug;

use glam::DVec3;

use super::{Meeting, Scatter, Spectrum};
use crate::random::Random;

/// A material that is asked with all that is known of a meeting.
pub(super) trait Shading<S>: Debug + Send + Sync {
    /// As [`PreparedMaterial::scatter`](super::PreparedMaterial::scatter).
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>>;
}

/// What patterns and textures make of a material at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shade<S> {
    /// What the material's colour is multiplied by.
    pub color: S,
    /// The same as RGB, for functions that ask for it.
    pub rgb: DVec3,
    /// What is added to the unit normal of the front (`Meeting::normal`) before it is made unit again.
    pub perturbation: DVec3,
}

impl<S: Spectrum> Shade<S> {
    /// Without modifiers.
    #[inline]
    pub fn of(meeting: &Meeting) -> Shade<S> {
        Shade { color: S::WHITE, rgb: DVec3::ONE, perturbation: meeting.local.perturbation }
    }
}

impl<S> Shade<S> {
    /// Whether the normal is not that of the surface.
    #[inline]
    pub fn is_textured(&self) -> bool {
        // Radiance's least perturbation that counts.
        self.perturbation.length_squared() > 1e-12
    }

    /// The unit normal with the perturbation, on the front, and the cosine of the ray to it, above 0 for rays that come from the
    /// front of the surface itself: a perturbation that would turn the surface away from the ray is mirrored.
    pub fn normal(&self, meeting: &Meeting) -> (DVec3, f64) {
        let own = -meeting.incoming.dot(meeting.normal);
        if !self.is_textured() {
            return (meeting.normal, own);
        }
        let Some(normal) = (meeting.normal + self.perturbation).try_normalize() else {
            return (meeting.normal, own);
        };
        let cosine = -meeting.incoming.dot(normal);
        if (cosine > 0.0) == (own > 0.0) {
            return (normal, cosine);
        }
        (normal + meeting.incoming * (2.0 * cosine), -cosine)
    }
}
