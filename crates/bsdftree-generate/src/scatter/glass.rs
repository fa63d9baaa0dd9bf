//! `glass`: a thin pane, both interfaces and all reflections between them in one surface.
//!
//! For one interface's reflectance r and the pane's internal transmittance t = tn^(1/cosθt), for each polarisation:
//! T = (1−r)²t / (1−r²t²), R = r + r(1−r)²t² / (1−r²t²). Light goes straight on or is mirrored.
//!
//! Source: Radiance's reference manual (`glass`); the geometric series over the pane.

use glam::DVec3;

use super::frame::mirrored;
use super::fresnel::Boundary;
use super::spectrum::{is_grey, map_rgb};
use super::{Scatter, Spectrum};
use crate::random::Random;

/// A pane of glass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pane {
    /// ln of the transmissivity; −∞ for an opaque one.
    pub log_transmissivity: DVec3,
    pub index: f64,
}

impl Pane {
    pub fn new(transmissivity: DVec3, index: f64) -> Self {
        Pane { log_transmissivity: map_rgb(transmissivity, libm::log), index }
    }

    /// Reflectance and transmittance (RGB) for a `cosine` of incidence ≥ 0.
    #[inline]
    pub fn reflectance_transmittance(&self, cosine: f64) -> [DVec3; 2] {
        let Some(boundary) = Boundary::new(cosine, 1.0 / self.index) else {
            return [DVec3::ONE, DVec3::ZERO];
        };
        let split = |log: f64| {
            let inside = libm::exp(log / boundary.cosine);
            let [s, p] = boundary.reflectance.map(|r| {
                // The floor is for r = inside = 1, where nothing gets in and the sum is 0/0.
                let series = (1.0 - r).powi(2) / (1.0 - (r * inside).powi(2)).max(f64::MIN_POSITIVE);
                [r + r * inside * inside * series, inside * series]
            });
            [0.5 * (s[0] + p[0]), 0.5 * (s[1] + p[1])]
        };
        let logs = self.log_transmissivity;
        let red = split(logs.x);
        let [green, blue] = if is_grey(logs) { [red; 2] } else { [split(logs.y), split(logs.z)] };
        [0, 1].map(|part| DVec3::new(red[part], green[part], blue[part]))
    }

    #[inline]
    pub fn scatter<S: Spectrum>(
        &self,
        normal: DVec3,
        incoming: DVec3,
        random: &mut Random,
    ) -> Option<Scatter<S>> {
        let (facing, cosine) = super::facing(normal, incoming);
        let [reflectance, transmittance] = self.reflectance_transmittance(cosine).map(S::from_rgb);
        let [reflected, transmitted] = [reflectance.luminance(), transmittance.luminance()];
        let total = reflected + transmitted;
        if random.next_open() * total < reflected {
            return Some(Scatter::reflected(
                mirrored(incoming, facing, cosine),
                reflectance * (total / reflected),
            ));
        }
        (transmitted > 0.0).then(|| Scatter::transmitted(incoming, transmittance * (total / transmitted)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ray followed through a slab until nothing is left: reflectance and transmittance of one polarisation.
    fn follow(r: f64, t: f64) -> [f64; 2] {
        let (mut out, mut inside, mut front) = ([r, 0.0], (1.0 - r) * t, false);
        while inside > 1e-18 {
            out[usize::from(!front)] += inside * (1.0 - r);
            inside *= r * t;
            front = !front;
        }
        out
    }

    #[test]
    fn pane_equals_a_ray_followed_between_its_interfaces() {
        for index in [1.3, 1.52, 1.9] {
            for transmissivity in [0.96, 0.7, 0.2, 0.0, 1.0] {
                let pane = Pane::new(DVec3::splat(transmissivity), index);
                for degrees in [0.0_f64, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 88.0] {
                    let cosine = degrees.to_radians().cos();
                    let boundary = Boundary::new(cosine, 1.0 / index).unwrap();
                    let inside =
                        transmissivity.powf(1.0 / (1.0 - (1.0 - cosine * cosine) / index / index).sqrt());
                    let [s, p] = boundary.reflectance.map(|r| follow(r, inside));
                    let [reflectance, transmittance] = pane.reflectance_transmittance(cosine);
                    assert!((reflectance.y - 0.5 * (s[0] + p[0])).abs() < 1e-12, "{index} {degrees}");
                    assert!((transmittance.y - 0.5 * (s[1] + p[1])).abs() < 1e-12, "{index} {degrees}");
                }
            }
        }
    }

    #[test]
    fn clear_pane_loses_nothing() {
        // At normal incidence and t = 1, R = 2r/(1+r) for the stack of two interfaces.
        let [reflectance, transmittance] = Pane::new(DVec3::ONE, 1.52).reflectance_transmittance(1.0);
        let r = (0.52_f64 / 2.52).powi(2);
        assert!((reflectance.x - 2.0 * r / (1.0 + r)).abs() < 1e-14);
        for cosine in [1.0, 0.5, 0.1, 1e-3, 0.0] {
            let [r, t] = Pane::new(DVec3::ONE, 1.52).reflectance_transmittance(cosine);
            assert!(
                ((r + t) - DVec3::ONE).abs().max_element() < 1e-6,
                "{cosine} {reflectance} {transmittance}"
            );
        }
    }

    #[test]
    fn radiances_example_of_common_glass_holds() {
        // The manual: a transmissivity of 0.96 is a transmittance of 88 %.
        let [_, transmittance] = Pane::new(DVec3::splat(0.96), 1.52).reflectance_transmittance(1.0);
        assert!((transmittance.x - 0.88).abs() < 0.005, "{transmittance}");
    }
}
