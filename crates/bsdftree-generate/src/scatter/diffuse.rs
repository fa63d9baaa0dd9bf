//! The diffuse lobes of a plain material apart from the others: what they take, and how a ray goes on without them.
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

    /// As [`scatter_plain`](Self::scatter_plain) of the material without its diffuse lobes.
    #[inline]
    pub(crate) fn scatter_specular(
        &self,
        normal: DVec3,
        incoming: DVec3,
        random: &mut Random,
    ) -> Option<Scatter<S>> {
        match &self.0 {
            Prepared::Gloss(gloss) => gloss.scatter_specular(normal, incoming, random),
            _ => self.scatter_plain(normal, incoming, random),
        }
    }

    /// What the weight of a ray that was scattered as [`scatter_specular`](Self::scatter_specular) says is multiplied by to be
    /// that of light which travels the same way back: 1 where scattering is reciprocal.
    ///
    /// Behind a boundary light is denser by the squared ratio of the indices (étendue). Transmission spread by roughness, as
    /// Radiance defines it, is not reciprocal.
    #[inline]
    pub(crate) fn reversal(&self, normal: DVec3, incoming: DVec3, scatter: &Scatter<S>) -> f64 {
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
            let direction =
                if self.smooth { incoming } else { self.facets.spread(facing, incoming, random)? };
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
        let (exitant, factor) = self.facets.glance(facing, incoming, cosine, random)?;
        Some(Scatter::reflected(exitant, weight * factor))
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
        let (axes, roughness) = self.facets.axes(facing);
        let squared: f64 =
            (0..2).filter(|&k| roughness[k] > 0.0).map(|k| (shift.dot(axes[k]) / roughness[k]).powi(2)).sum();
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

#[cfg(test)]
mod tests {
    use bsdftree_device::material::{Gloss, GlossKind, Material, Medium};

    use super::*;
    use crate::scatter::test_support::{direction, polar};
    use crate::scatter::{Meeting, evaluate};

    fn sheet(roughness: [f64; 2], specular: f64) -> Gloss {
        Gloss {
            kind: GlossKind::Trans,
            color: DVec3::new(0.9, 0.6, 0.3),
            specular,
            roughness,
            orientation: Some(DVec3::new(1.0, 0.4, 0.2)),
            transmission: 0.6,
            transmitted_specular: 0.7,
        }
    }

    fn metal(roughness: f64) -> Gloss {
        let gloss = sheet([roughness; 2], 0.6);
        Gloss { kind: GlossKind::Metal, transmission: 0.0, transmitted_specular: 0.0, ..gloss }
    }

    #[test]
    fn what_is_diffused_and_what_is_not_is_all() {
        for gloss in [sheet([0.0; 2], 0.1), sheet([0.2, 0.1], 0.05), metal(0.0), metal(0.3)] {
            let material = PreparedMaterial::<DVec3>::new(&Material::Gloss(gloss));
            assert!(material.is_diffuse());
            for theta in [0.0, 45.0, 80.0] {
                let incoming = -polar(theta, 30.0);
                let mut random = Random::new(31, theta as u64, 0);
                let n = 200_000;
                let mut mean = |specular: bool| {
                    let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
                    for _ in 0..n {
                        let scatter = if specular {
                            material.scatter_specular(DVec3::Z, incoming, &mut random)
                        } else {
                            material.scatter(&Meeting::new(DVec3::Z, incoming), &mut random)
                        };
                        // Direction tells lobes apart, up to what they share.
                        let weight = scatter.map_or(DVec3::ZERO, |s| s.weight * (1.5 + s.direction.z));
                        sum += weight;
                        squares += weight * weight;
                    }
                    let mean = sum / f64::from(n);
                    (mean, (squares / f64::from(n) - mean * mean) / f64::from(n))
                };
                let ((all, a), (specular, b)) = (mean(false), mean(true));
                let [reflected, transmitted] = material.diffuse_albedo(-incoming.z);
                // The mean height of a cosine-distributed direction is ⅔.
                let diffuse = reflected * (1.5 + 2.0 / 3.0) + transmitted * (1.5 - 2.0 / 3.0);
                let excess = (all - specular - diffuse).abs() - 4.5 * (a + b).max(DVec3::ZERO).map(f64::sqrt);
                assert!(
                    excess.max_element() < 1e-9,
                    "{all} is not {specular} + {diffuse}: {gloss:?} {theta}"
                );
            }
        }
    }

    #[test]
    fn the_way_back_has_the_weight_of_the_lobe_the_other_way() {
        let gloss = Gloss { transmitted_specular: 1.0, ..sheet([0.3, 0.15], 0.0) };
        let material = PreparedMaterial::<f64>::new(&Material::Gloss(gloss));
        let mut random = Random::new(32, 0, 0);
        for _ in 0..1000 {
            let (normal, incoming) = (direction(&mut random), direction(&mut random));
            let Some(scatter) = material.scatter_specular(normal, incoming, &mut random) else { continue };
            let (incident, exitant) = (-incoming, scatter.direction);
            let there = evaluate::<f64>(&gloss, incident, exitant, normal);
            let back = evaluate::<f64>(&gloss, exitant, incident, normal);
            let ratio = material.reversal(normal, incoming, &scatter);
            assert!((back - ratio * there).abs() <= 1e-6 * back + 1e-300, "{ratio} is not {back}/{there}");
        }
    }

    #[test]
    fn light_is_denser_behind_a_boundary_by_the_squared_index() {
        let inside = Medium { transmittance: DVec3::ONE, index: 1.5 };
        let glass = PreparedMaterial::<f64>::new(&Material::Dielectric { inside, outside: Medium::VACUUM });
        for (direction, expected) in [(-DVec3::Z, 1.0 / 2.25), (DVec3::Z, 2.25)] {
            let into = Scatter { direction, weight: 1.0, transmitted: true };
            assert!((glass.reversal(DVec3::Z, direction, &into) - expected).abs() < 1e-15);
            let off = Scatter { direction: -direction, weight: 1.0, transmitted: false };
            assert_eq!(glass.reversal(DVec3::Z, direction, &off), 1.0);
        }
    }

    #[test]
    fn lambertian_directions_have_the_mean_height_of_a_cosine() {
        let normal = polar(110.0, 40.0);
        let n = 400;
        let mut sum = DVec3::ZERO;
        for i in 0..n {
            for j in 0..n {
                let d = lambertian_direction(normal, [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n)));
                assert!((d.length() - 1.0).abs() < 1e-12 && d.dot(normal) > 0.0);
                sum += d;
            }
        }
        assert!((sum / f64::from(n * n) - normal * (2.0 / 3.0)).length() < 1e-4);
    }
}
