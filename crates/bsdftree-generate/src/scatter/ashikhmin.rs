//! `ashik2`: the anisotropic reflection of Ashikhmin and Shirley, as Radiance traces it.
//!
//! Facets have normals h with density √((nu+1)(nv+1))/2π · (n·h)^(nu cos²φ + nv sin²φ) and mirror the light, of which they take the
//! fraction s + (1−s)(1−cosθ)⁵, θ being the angle of incidence to the surface and s the specular colour. So the specular BSDF is
//! that fraction times √((nu+1)(nv+1))/8π · (n·h)^(nu cos²φ + nv sin²φ) / ((h·i) cosθo), over the part of it that lies above the
//! surface. The rest of the light meets a Lambertian surface of the diffuse colour. Both sides behave alike.
//!
//! Sources: M. Ashikhmin, P. Shirley, "An anisotropic Phong BRDF model", J. Graphics Tools 5(2), 2000; Radiance's reference
//! manual (total reflectance is the sum of the colours); `rtrace` and `rcontrib`, observed.
//! Deviations. From the paper: Fresnel's approximation takes the surface's angle, not the facet's; cosθo stands for
//! max(cosθi, cosθo), as facets that mirror light above the surface lose none of it; the diffuse part is Lambertian. All three are
//! Radiance's, where it follows rays. From Radiance: the diffuse part never takes more than the specular one leaves,
//! so there is never more light than came, which Radiance makes towards grazing; a direction below the surface is drawn
//! again 32 times, not 10.

use bsdftree_device::material::{Ashikhmin, Orientation};
use glam::DVec3;

use super::faults::Watch;
use super::frame::{cos_sin, cosine_direction, renormalized, tangents};
use super::shading::{Facing, Shade, Shading, ray_state};
use super::{Meeting, Scatter, Spectrum};
use crate::random::Random;

/// How often a direction is drawn.
const MOST_DRAWS: u32 = 32;

/// An `ashik2` ready to scatter.
#[derive(Clone, Debug)]
pub(super) struct PreparedAshikhmin<S> {
    diffuse: S,
    specular: S,
    power: [f64; 2],
    orientation: Orientation,
    watch: Watch,
}

impl<S: Spectrum> PreparedAshikhmin<S> {
    pub fn new(material: &Ashikhmin, watch: Watch) -> Self {
        PreparedAshikhmin {
            diffuse: S::from_rgb(material.diffuse),
            specular: S::from_rgb(material.specular),
            power: material.power,
            orientation: material.orientation.clone(),
            watch,
        }
    }

    /// What is mirrored and what is diffused at a cosine of incidence, under patterns of this colour.
    #[inline]
    pub fn albedos(&self, cosine: f64, color: S) -> [S; 2] {
        let fresnel = (1.0 - cosine).powi(5);
        let mirrored = match self.specular.luminance() > 0.0 {
            true => self.specular * (1.0 - fresnel) + S::WHITE * fresnel,
            false => S::BLACK,
        };
        let diffuse = self.diffuse * color;
        [mirrored, diffuse.at_most(S::WHITE + mirrored * -1.0).clamped()]
    }

    /// Unit vectors u and v in the surface, and the power along each.
    #[inline]
    fn axes(&self, facing: DVec3, u: DVec3) -> ([DVec3; 2], [f64; 2]) {
        match facing.cross(u).try_normalize() {
            Some(v) => ([v.cross(facing), v], self.power),
            None => {
                // The orientation is along the normal: as Radiance does, isotropic with the harmonic mean.
                let mean = 2.0 / self.power.iter().map(|n| 1.0 / (n + 1e-5)).sum::<f64>();
                (tangents(facing), [mean; 2])
            }
        }
    }

    /// Density of the facet that mirrors `incident` to `exitant` times what mirroring makes of it: the specular BSDF \[1/sr\] of a
    /// fraction of 1, before what points below the surface is drawn again. Unit vectors away from the surface.
    #[cfg(test)]
    fn lobe(&self, incident: DVec3, exitant: DVec3, normal: DVec3, u: DVec3) -> f64 {
        let ([u, v], [nu, nv]) = self.axes(normal, u);
        let h = (incident + exitant).normalize();
        let (c, a, b) = (h.dot(normal), h.dot(u), h.dot(v));
        if c <= 0.0 {
            return 0.0;
        }
        let exponent = if c < 1.0 { (nu * a * a + nv * b * b) / (1.0 - c * c) } else { nu };
        ((nu + 1.0) * (nv + 1.0)).sqrt() * c.powf(exponent)
            / (8.0 * std::f64::consts::PI * h.dot(incident) * exitant.dot(normal))
    }
}

impl<S: Spectrum> Shading<S> for PreparedAshikhmin<S> {
    /// One lobe, taken by luminance.
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>> {
        let facing = Facing::new(meeting, shade);
        let albedos = self.albedos(facing.cosine, shade.color);
        let [mirrored, diffused] = albedos.map(S::luminance);
        let total = mirrored + diffused;
        if total <= 0.0 {
            return None;
        }
        if random.next_open() * total >= mirrored {
            return Some(
                facing.scatter(cosine_direction(facing.normal, random), albedos[1] * (total / diffused)),
            );
        }
        let u = self.watch.checked(self.orientation.at(|| ray_state(meeting)))?;
        let (axes, power) = self.axes(facing.normal, u);
        let incoming = meeting.incoming;
        for _ in 0..MOST_DRAWS {
            let facet = facet(facing.normal, axes, power, random);
            let direction = renormalized(incoming - facet * (2.0 * facet.dot(incoming)));
            if facing.is_above(direction) {
                return Some(Scatter::reflected(direction, albedos[0] * (total / mirrored)));
            }
        }
        None
    }
}

/// A facet's normal.
#[inline]
fn facet(facing: DVec3, [u, v]: [DVec3; 2], [nu, nv]: [f64; 2], random: &mut Random) -> DVec3 {
    let height = random.next_open();
    let [cos, sin] = cos_sin(random.next_u32());
    let (cos, sin) = ((nv + 1.0).sqrt() * cos, (nu + 1.0).sqrt() * sin);
    let length = (cos * cos + sin * sin).sqrt();
    let (cos, sin) = (cos / length, sin / length);
    let cos_theta = libm::pow(height, 1.0 / (nu * cos * cos + nv * sin * sin + 1.0));
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    u * (cos * sin_theta) + v * (sin * sin_theta) + facing * cos_theta
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::sync::Arc;

    use super::*;
    use crate::scatter::test_support::{Cells, polar};

    fn prepared(diffuse: f64, specular: f64, power: [f64; 2], u: DVec3) -> PreparedAshikhmin<f64> {
        let [diffuse, specular] = [diffuse, specular].map(DVec3::splat);
        let orientation = Orientation::Constant(u);
        let material = Ashikhmin { diffuse, specular, power, orientation };
        PreparedAshikhmin::new(&material, Watch::new("", &Arc::default()))
    }

    fn scatter(
        material: &PreparedAshikhmin<f64>,
        meeting: &Meeting,
        random: &mut Random,
    ) -> Option<Scatter<f64>> {
        material.scatter(meeting, &Shade::of(meeting), random)
    }

    /// ∫ f cos dω over each cell. As f has 1/cos in it, over cosine and azimuth, in which the integrand is smooth.
    fn integrate(cells: &Cells, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
        let n = 48;
        let middle = |i: usize| (i as f64 + 0.5) / n as f64;
        (0..cells.count())
            .map(|cell| {
                let (ring, sector) = (cell / cells.sectors, cell % cells.sectors);
                let [high, low] = [ring, ring + 1].map(|k| (1.0 - k as f64 / cells.rings as f64).sqrt());
                let points = (0..n * n).map(|k| (low + (high - low) * middle(k / n), middle(k % n)));
                let sum: f64 = points
                    .map(|(cos, part)| {
                        let phi = TAU * (sector as f64 + part) / cells.sectors as f64;
                        let sin = (1.0 - cos * cos).sqrt();
                        f(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)) * cos
                    })
                    .sum();
                sum * (high - low) * TAU / (cells.sectors * n * n) as f64
            })
            .collect()
    }

    #[test]
    fn samples_are_distributed_as_the_published_formula() {
        let cells = Cells { rings: 12, sectors: 16 };
        let u = DVec3::new(1.0, 0.5, 3.0);
        for power in [[20.0, 20.0], [10.0, 120.0], [1.0, 4.0]] {
            for theta in [0.0, 35.0, 70.0] {
                let incident = polar(theta, 25.0);
                let material = prepared(0.0, 0.4, power, u);
                let meeting = Meeting::new(DVec3::Z, -incident);
                let raw = integrate(&cells, |exitant| material.lobe(incident, exitant, DVec3::Z, u));
                // What lies above the surface has all that is mirrored.
                let above: f64 = raw.iter().sum();
                let [mirrored, _] = material.albedos(incident.z, 1.0);
                let expected: Vec<f64> = raw.iter().map(|x| x / above * mirrored).collect();
                let mut random = Random::new(51, theta as u64, power[1] as u64);
                let z =
                    cells.compare(&expected, 200_000, || scatter(&material, &meeting, &mut random), false);
                // 9 comparisons of up to 192 cells: 5.4 is exceeded by one with probability 1e-4.
                assert!(z < 5.4, "{power:?} {theta}: {z}");
            }
        }
    }

    #[test]
    fn totals_are_the_sum_of_the_colours_and_never_more_than_all() {
        for (diffuse, specular) in [(0.3, 0.2), (0.6, 0.0), (0.7, 0.3)] {
            let material = prepared(diffuse, specular, [50.0; 2], DVec3::X);
            for theta in [0.0_f64, 40.0, 60.0, 75.0, 88.0] {
                let fresnel = if specular > 0.0 { (1.0 - theta.to_radians().cos()).powi(5) } else { 0.0 };
                let expected = (diffuse + specular + (1.0 - specular) * fresnel).min(1.0);
                for incident in [polar(theta, 3.0), -polar(theta, 3.0)] {
                    let meeting = Meeting::new(DVec3::Z, -incident);
                    let mut random = Random::new(52, theta as u64, 0);
                    for _ in 0..2000 {
                        let s = scatter(&material, &meeting, &mut random).unwrap();
                        assert!(
                            (s.weight - expected).abs() < 1e-12 && !s.transmitted,
                            "{theta} {s:?} {expected}"
                        );
                        assert!(s.direction.z * incident.z >= 0.0);
                    }
                }
            }
        }
    }

    #[test]
    fn orientation_along_the_normal_falls_back_to_the_harmonic_mean() {
        let material = prepared(0.0, 1.0, [10.0, 40.0], DVec3::Z);
        let (_, power) = material.axes(DVec3::Z, DVec3::Z);
        assert!((power[0] - 16.0).abs() < 1e-3 && power[0] == power[1]);
    }
}
