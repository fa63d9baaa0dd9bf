//! `dielectric` and `interface`: refraction and reflection at a boundary, absorption on the way.
//!
//! The path carries flux, so a refracted ray keeps its weight. Deviations from Radiance: it carries radiance and
//! scales by the squared ratio of the indices, which cancels for a device with air on both sides; dispersion
//! (Hartmann's constant) is left out, as it is in Radiance but for views of light sources.

use bsdftree_device::material::Medium;
use glam::DVec3;

use super::frame::{mirrored, renormalized};
use super::fresnel::Boundary;
use super::spectrum::map_rgb;
use super::{Scatter, Spectrum};
use crate::random::Random;

/// The media in front of a surface and behind it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    pub outside: Medium,
    pub inside: Medium,
}

impl Interface {
    /// The medium on one side of the surface.
    #[inline]
    pub fn medium(&self, front: bool) -> &Medium {
        if front { &self.outside } else { &self.inside }
    }

    #[inline]
    pub fn scatter<S: Spectrum>(&self, normal: DVec3, incoming: DVec3, random: &mut Random) -> Scatter<S> {
        let (facing, cosine) = super::facing(normal, incoming);
        let front = super::is_front(normal, incoming);
        let ratio = self.medium(front).index / self.medium(!front).index;
        match Boundary::new(cosine, ratio) {
            Some(boundary) if random.next_open() >= boundary.unpolarized() => {
                let refracted = incoming * ratio + facing * (ratio * cosine - boundary.cosine);
                Scatter::transmitted(renormalized(refracted), S::WHITE)
            }
            _ => Scatter::reflected(mirrored(incoming, facing, cosine), S::WHITE),
        }
    }
}

/// What is left of light after `distance` \[m\] in a medium with this `transmittance` \[1/m\].
#[inline]
pub fn attenuation<S: Spectrum>(transmittance: DVec3, distance: f64) -> S {
    if transmittance == DVec3::ONE {
        return S::WHITE;
    }
    S::from_rgb(map_rgb(transmittance, |t| libm::pow(t, distance)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLASS: Interface =
        Interface { outside: Medium::VACUUM, inside: Medium { transmittance: DVec3::ONE, index: 1.52 } };

    fn incoming(degrees: f64, down: bool) -> DVec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(sin, 0.0, if down { -cos } else { cos })
    }

    #[test]
    fn reflection_is_as_frequent_as_fresnel_says() {
        // z of a binomial count; 4.5 is exceeded with probability 7e-6 a case.
        let n = 200_000;
        for (down, ratio) in [(true, 1.0 / 1.52), (false, 1.52)] {
            for degrees in [0.0_f64, 10.0, 20.0, 30.0, 35.0, 40.0, 60.0, 75.0, 85.0, 89.0] {
                let expected =
                    Boundary::new(degrees.to_radians().cos(), ratio).map_or(1.0, |b| b.unpolarized());
                let mut random = Random::new(3, 0, degrees as u64);
                let reflected = (0..n)
                    .filter(|_| {
                        !GLASS.scatter::<f64>(DVec3::Z, incoming(degrees, down), &mut random).transmitted
                    })
                    .count() as f64;
                let deviation = (n as f64 * expected * (1.0 - expected)).sqrt().max(1e-9);
                assert!((reflected - n as f64 * expected).abs() / deviation < 4.5, "{degrees} {down}");
            }
        }
    }

    #[test]
    fn refracted_rays_obey_snell() {
        let mut random = Random::new(4, 0, 0);
        for (down, ratio) in [(true, 1.0 / 1.52), (false, 1.52)] {
            for degrees in [0.0, 5.0, 20.0, 35.0, 41.0, 60.0, 80.0] {
                let towards = incoming(degrees, down);
                for _ in 0..50 {
                    let scatter: Scatter<f64> = GLASS.scatter(DVec3::Z, towards, &mut random);
                    let d = scatter.direction;
                    assert!((d.length() - 1.0).abs() < 1e-14 && d.y == 0.0 && scatter.weight == 1.0);
                    assert_eq!(d.z * towards.z > 0.0, scatter.transmitted);
                    let sine = if scatter.transmitted { ratio * towards.x } else { towards.x };
                    assert!((d.x - sine).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn an_interface_of_equal_media_is_not_there() {
        let water = Medium { transmittance: DVec3::ONE, index: 1.33 };
        let same = Interface { outside: water, inside: water };
        let mut random = Random::new(5, 0, 0);
        for degrees in [0.0, 30.0, 89.9, 90.0] {
            let scatter: Scatter<f64> = same.scatter(DVec3::Z, incoming(degrees, true), &mut random);
            assert!(scatter.transmitted && (scatter.direction - incoming(degrees, true)).length() < 1e-8);
        }
    }

    #[test]
    fn absorption_is_a_power_of_the_distance() {
        let green = DVec3::new(0.5, 0.9, 0.25);
        assert_eq!(attenuation::<DVec3>(green, 2.0), DVec3::new(0.25, 0.9 * 0.9, 0.0625));
        assert!(
            (attenuation::<f64>(green, 2.0) - (0.2651 * 0.25 + 0.6701 * 0.81 + 0.0648 * 0.0625)).abs() < 1e-4
        );
        assert_eq!(attenuation::<f64>(DVec3::ONE, f64::INFINITY), 1.0);
        assert_eq!(attenuation::<f64>(DVec3::ZERO, 1e-9), 0.0);
    }
}
