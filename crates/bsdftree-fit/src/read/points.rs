//! Where a reflectance that is known everywhere is looked at: densely around the mirrored direction, coarsely elsewhere.
//!
//! In: an incident direction. Out: exitant directions on its side. Most are those that mirrors tilted by θ_h reflect to, with steps of θ_h
//! that grow with its square from 0.03°, as lobes of rough surfaces need it; the others are spread evenly over the hemisphere.

use bsdftree::Direction;
use bsdftree::direction::direction_from_polar;

use super::text::direction_from_degrees;

/// Tilts of mirrors, and azimuths of each.
const N_TILTS: usize = 36;
const N_AZIMUTHS: usize = 24;
/// Directions spread over the sphere, half of them over the hemisphere.
const N_SPREAD: usize = 700;
/// Exitant directions are no nearer to the horizon \[cosine\]: 1°.
const LOWEST: f64 = 0.0175;

/// Exitant directions for light from a direction over the horizon.
pub(super) fn around_mirror(incident: Direction) -> Vec<Direction> {
    let mut all = vec![[-incident[0], -incident[1], incident[2]]];
    for tilt in 1..=N_TILTS {
        let theta_deg = 90.0 * (tilt as f64 / N_TILTS as f64).powi(2);
        for azimuth in 0..N_AZIMUTHS {
            // Every second ring is turned by half a step.
            let phi_deg = 360.0 * (azimuth as f64 + 0.5 * (tilt % 2) as f64) / N_AZIMUTHS as f64;
            let normal = direction_from_degrees(theta_deg, phi_deg);
            let cosine = (0..3).map(|k| normal[k] * incident[k]).sum::<f64>();
            all.push([0, 1, 2].map(|k| 2.0 * cosine * normal[k] - incident[k]));
        }
    }
    // A spiral by the golden angle is even.
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let spread = (0..N_SPREAD / 2).map(|k| {
        let z = 1.0 - (k as f64 + 0.5) * 2.0 / N_SPREAD as f64;
        direction_from_polar(z.acos(), golden * k as f64)
    });
    all.extend(spread);
    all.retain(|o| o[2] > LOWEST);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_dense_about_the_mirrored_direction_and_everywhere() {
        let incident = direction_from_degrees(50.0, 20.0);
        let points = around_mirror(incident);
        assert!((600..1300).contains(&points.len()), "{}", points.len());
        let near = |d: Direction, deg: f64| {
            let cosine = deg.to_radians().cos();
            points.iter().filter(|o| (0..3).map(|k| o[k] * d[k]).sum::<f64>() > cosine).count()
        };
        assert!(near([-incident[0], -incident[1], incident[2]], 2.0) > 80);
        for phi in (0..360).step_by(30) {
            assert!(near(direction_from_degrees(70.0, f64::from(phi)), 8.0) > 0);
        }
        assert!(points.iter().all(|o| (o.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12));
    }
}
