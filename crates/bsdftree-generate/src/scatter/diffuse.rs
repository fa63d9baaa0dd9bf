//! The diffuse lobes of a material apart from the others: what they take, and how a ray goes on without them.
//!
//! In and out as in [`scatter`](super). Invariant: the mean of [`PreparedMaterial::scatter_specular`] and the two albedos of
//! [`PreparedMaterial::diffuse_albedo`] together are what [`PreparedMaterial::scatter`] does.

use glam::DVec3;

use super::frame::{cos_sin, mirrored, tangents};
use super::gloss::{
    DIFFUSE_REFLECTION, DIFFUSE_TRANSMISSION, PreparedGloss, SPECULAR_REFLECTION, SPECULAR_TRANSMISSION,
};
use super::{Prepared, PreparedMaterial, Scatter, Spectrum, facing, is_front};
use crate::random::Random;

impl<S: Spectrum> PreparedMaterial<S> {
    /// Whether light that meets the material can be diffused.
    pub fn is_diffuse(&self) -> bool {
        matches!(&self.0, Prepared::Gloss(gloss) if gloss.is_diffuse())
    }

    /// The fractions of light arriving at a `cosine` ≥ 0 to the normal that are sent out evenly in projected solid angle: on
    /// the side it came from, and on the other.
    #[inline]
    pub fn diffuse_albedo(&self, cosine: f64) -> [S; 2] {
        match &self.0 {
            Prepared::Gloss(gloss) => gloss.diffuse_albedo(cosine),
            _ => [S::BLACK; 2],
        }
    }

    /// As [`scatter`](Self::scatter) of the material without its diffuse lobes.
    #[inline]
    pub fn scatter_specular(
        &self,
        normal: DVec3,
        incoming: DVec3,
        random: &mut Random,
    ) -> Option<Scatter<S>> {
        match &self.0 {
            Prepared::Gloss(gloss) => gloss.scatter_specular(normal, incoming, random),
            _ => self.scatter(normal, incoming, random),
        }
    }

    /// What the weight of a ray that was scattered as [`scatter_specular`](Self::scatter_specular) says is multiplied by to be
    /// that of light which travels the same way back: 1 where scattering is reciprocal.
    ///
    /// Behind a boundary light is denser by the squared ratio of the indices (étendue). Transmission spread by roughness, as
    /// Radiance defines it, is not reciprocal.
    #[inline]
    pub fn reversal(&self, normal: DVec3, incoming: DVec3, scatter: &Scatter<S>) -> f64 {
        if !scatter.transmitted {
            return 1.0;
        }
        match &self.0 {
            Prepared::Dielectric(interface) => {
                let front = is_front(normal, incoming);
                (interface.medium(front).index / interface.medium(!front).index).powi(2)
            }
            Prepared::Gloss(gloss) => gloss.reversal(normal, incoming, scatter.direction),
            _ => 1.0,
        }
    }
}

impl<S: Spectrum> PreparedGloss<S> {
    fn is_diffuse(&self) -> bool {
        [DIFFUSE_REFLECTION, DIFFUSE_TRANSMISSION].iter().any(|&k| self.lobes[k].luminance > 0.0)
    }

    #[inline]
    fn diffuse_albedo(&self, cosine: f64) -> [S; 2] {
        let kept = 1.0 - self.fresnel_at(cosine);
        [DIFFUSE_REFLECTION, DIFFUSE_TRANSMISSION].map(|k| self.lobes[k].color * kept)
    }

    #[inline]
    fn scatter_specular(&self, normal: DVec3, incoming: DVec3, random: &mut Random) -> Option<Scatter<S>> {
        let (facing, cosine) = facing(normal, incoming);
        let fresnel = self.fresnel_at(cosine);
        let through = self.lobes[SPECULAR_TRANSMISSION].luminance * (1.0 - fresnel);
        let total = through + self.lobes[SPECULAR_REFLECTION].luminance * (1.0 - fresnel) + fresnel;
        if total <= 0.0 {
            return None;
        }
        if random.next_open() * total < through {
            let weight = self.lobes[SPECULAR_TRANSMISSION].tint * total;
            let direction = if self.smooth { incoming } else { self.spread(facing, incoming, random)? };
            return Some(Scatter::transmitted(direction, weight));
        }
        let color = self.highlight(fresnel);
        let luminance = color.luminance();
        if luminance <= 0.0 {
            return None;
        }
        let weight = color * (total / luminance);
        if self.smooth {
            return Some(Scatter::reflected(mirrored(incoming, facing, cosine), weight));
        }
        self.glance(facing, incoming, cosine, weight, random)
    }

    /// The ratio of [`evaluate`](Self::evaluate) with its directions swapped to that as they are, for transmission.
    #[inline]
    fn reversal(&self, normal: DVec3, incoming: DVec3, exitant: DVec3) -> f64 {
        if self.smooth {
            return 1.0;
        }
        let (facing, cosine) = facing(normal, incoming);
        let ratio = -exitant.dot(facing) / cosine;
        let shift = exitant / ratio - incoming;
        let (axes, roughness) = self.axes(facing);
        let squared: f64 = (0..2)
            .filter(|&k| roughness[k] > 0.0)
            .map(|k| (shift.dot(axes[k]) / roughness[k]).powi(2))
            .sum();
        libm::exp(squared * (1.0 - ratio * ratio)) * ratio.powi(6)
    }
}

/// The unit direction on `normal`'s side that a point of the unit square stands for; even points give density cos θ / π.
#[inline]
pub fn lambertian_direction(normal: DVec3, [u, v]: [f64; 2]) -> DVec3 {
    let [cos, sin] = cos_sin((v * 4_294_967_296.0) as u32);
    let radius = u.sqrt();
    let [t, b] = tangents(normal);
    t * (radius * cos) + b * (radius * sin) + normal * (1.0 - u).sqrt()
}
