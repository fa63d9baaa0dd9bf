//! Reflection at a boundary between two media (Fresnel), and Radiance's approximation of it.
//!
//! Source: M. Born, E. Wolf, "Principles of Optics", 1.5; the approximation: Radiance's normal materials.

/// A ray at a boundary that is not totally reflected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Boundary {
    /// Cosine of the refracted ray to the normal, > 0.
    pub cosine: f64,
    /// Reflectance for the electric field perpendicular (s) and parallel (p) to the plane of incidence.
    pub reflectance: [f64; 2],
}

impl Boundary {
    /// For a `cosine` ≥ 0 to the normal; `ratio` is the index of the ray's medium over the other's. `None` if reflection is total.
    #[inline]
    pub fn new(cosine: f64, ratio: f64) -> Option<Boundary> {
        // A cosine of 0 leaves 0/0 where the indices are equal.
        let incident = cosine.max(1e-9);
        let squared = (1.0 - ratio * ratio) + ratio * ratio * incident * incident;
        if squared <= 0.0 {
            return None;
        }
        let refracted = squared.sqrt();
        let s = (ratio * incident - refracted) / (ratio * incident + refracted);
        let p = (incident - ratio * refracted) / (incident + ratio * refracted);
        Some(Boundary { cosine: refracted, reflectance: [s * s, p * p] })
    }

    /// Reflectance for unpolarised light.
    #[inline]
    pub fn unpolarized(&self) -> f64 {
        0.5 * (self.reflectance[0] + self.reflectance[1])
    }
}

/// A smooth surface's gain of specularity towards grazing, for specularity from [`LEAST_SPECULAR`] on: 0.0008 at
/// normal incidence, 0.998 at grazing.
#[inline]
pub(super) fn approximation(cosine: f64) -> f64 {
    libm::exp(-5.85 * cosine) - 0.002_029_430_64
}

/// Radiance applies the approximation from 1.8 % on; a hair less, so that a specularity of 0.018 counts.
pub(super) const LEAST_SPECULAR: f64 = 0.017_999;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectance_follows_the_angles_of_snell() {
        // The sine and tangent form of Fresnel's formulas, independent of the one above.
        for ratio in [1.0 / 1.52, 1.0 / 1.33, 1.52, 1.1] {
            for degrees in [1.0_f64, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 89.0] {
                let i = degrees.to_radians();
                let sine = ratio * i.sin();
                let boundary = Boundary::new(i.cos(), ratio);
                if sine > 1.0 {
                    assert_eq!(boundary, None);
                    continue;
                }
                let t = sine.asin();
                let s = ((i - t).sin() / (i + t).sin()).powi(2);
                let p = ((i - t).tan() / (i + t).tan()).powi(2);
                let got = boundary.unwrap();
                assert!((got.reflectance[0] - s).abs() < 1e-12 && (got.reflectance[1] - p).abs() < 1e-12);
                assert!((got.cosine - t.cos()).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn normal_incidence_and_grazing_have_their_closed_forms() {
        let normal = Boundary::new(1.0, 1.0 / 1.52).unwrap();
        assert!((normal.unpolarized() - (0.52_f64 / 2.52).powi(2)).abs() < 1e-15);
        assert!((Boundary::new(0.0, 1.0 / 1.52).unwrap().unpolarized() - 1.0).abs() < 1e-7);
        assert_eq!(Boundary::new(0.0, 1.0).unwrap().reflectance, [0.0, 0.0]);
    }

    #[test]
    fn total_reflection_begins_at_the_critical_angle() {
        let critical = (1.0_f64 / 1.52).asin();
        assert!(Boundary::new((critical - 1e-6).cos(), 1.52).is_some());
        assert!(Boundary::new((critical + 1e-6).cos(), 1.52).is_none());
    }

    #[test]
    fn brewsters_angle_reflects_no_parallel_light() {
        for n in [1.33_f64, 1.52, 2.4] {
            let boundary = Boundary::new(n.atan().cos(), 1.0 / n).unwrap();
            assert!(boundary.reflectance[1] < 1e-28 && boundary.reflectance[0] > 0.05);
        }
    }

    #[test]
    fn approximation_stays_between_nothing_and_all() {
        for k in 0..=1000 {
            let f = approximation(f64::from(k) / 1000.0);
            assert!((0.0..1.0).contains(&f));
        }
    }
}
