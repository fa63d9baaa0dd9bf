//! Scans of the plane of incidence alone, spread over the hemisphere.
//!
//! Many goniophotometers move in one plane. What leaves elsewhere was then not measured; it is *assumed* to depend on the angle γ from the mirror
//! direction m (or from where light goes straight through) and to go evenly, as (1 + cos ψ)/2, from what was measured at γ beyond m to
//! what was measured at γ before it, ψ being the angle about m; where only one of the two was measured, that counts. In the plane that is
//! the measurement itself.

use crate::lambert::Ray;
use crate::prepare::Points;

/// Sine of the angle from the plane of incidence within which points lie in it.
const THIN: f32 = 0.02;

/// Least step of γ \[rad\], and steps of ψ around m.
const STEP: f32 = 0.005;
const N_TURNS: usize = 24;

/// Whether all points lie in the plane of incidence. The scan's incident direction lies in the half-plane y = 0, x ≤ 0.
pub(crate) fn is_in_plane(scan: &Points) -> bool {
    scan.exitant.iter().all(|o| o[1].abs() < THIN)
}

/// The scan with points all around.
pub(crate) fn spread(mut scan: Points) -> Points {
    let angle = |o: Ray| o[0].atan2(o[2]);
    let mirror = (-scan.incident[0]).atan2(scan.incident[2]);
    let mut along: Vec<(f32, usize)> =
        scan.exitant.iter().enumerate().map(|(k, &o)| (angle(o) - mirror, k)).collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut radii: Vec<f32> = along.iter().map(|(delta, _)| delta.abs()).collect();
    radii.sort_by(f32::total_cmp);
    radii.dedup_by(|a, b| *a - *b < STEP);
    let measured = scan.values.clone();
    // Nothing beyond the outermost points.
    let at = |values: &[f32], delta: f32| {
        let upper = along.partition_point(|&(d, _)| d < delta);
        let (&(b, k), (a, j)) = (along.get(upper)?, along[upper.checked_sub(1)?]);
        Some(values[j] + (delta - a) / (b - a).max(1e-9) * (values[k] - values[j]))
    };
    let (s, c) = mirror.sin_cos();
    for &radius in radii.iter().filter(|&&radius| radius > STEP) {
        for turn in (1..N_TURNS).filter(|turn| 2 * turn != N_TURNS) {
            let psi = std::f32::consts::TAU * turn as f32 / N_TURNS as f32;
            // About the normal first, then tilted to m.
            let [x, y, z] = [radius.sin() * psi.cos(), radius.sin() * psi.sin(), radius.cos()];
            let o = [c * x + s * z, y, c * z - s * x];
            if o[2] > 0.0 {
                let forward = 0.5 * (1.0 + psi.cos());
                scan.exitant.push(o);
                for (values, measured) in scan.values.iter_mut().zip(&measured) {
                    let (beyond, before) = (at(measured, radius), at(measured, -radius));
                    let (beyond, before) = (beyond.or(before), before.or(beyond));
                    values.push(beyond.zip(before).map_or(0.0, |(f, b)| forward * f + (1.0 - forward) * b));
                }
            }
        }
    }
    scan
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdftree::Part;

    #[test]
    fn what_depends_on_the_angle_from_the_mirror_direction_alone_comes_out_as_it_is() {
        let incident = [-0.5f32, 0.0, 0.75f32.sqrt()];
        let mirror = [0.5f32, 0.0, 0.75f32.sqrt()];
        let f = |o: Ray| (-4.0 * (1.0 - (0..3).map(|d| o[d] * mirror[d]).sum::<f32>())).exp();
        let exitant: Vec<Ray> =
            (-80..=80).map(|a| (a as f32).to_radians()).map(|a| [a.sin(), 0.0, a.cos()]).collect();
        let values = vec![exitant.iter().map(|&o| f(o)).collect()];
        let scan = Points { part: Part::ReflectionBack, incident, group: 0, exitant, values, noisy: false };
        assert!(is_in_plane(&scan));
        let whole = spread(scan);
        assert!(whole.exitant.len() > 2000 && !is_in_plane(&whole));
        // Where both sides of the mirror direction were measured.
        for (o, value) in whole.exitant.iter().zip(&whole.values[0]).filter(|(o, _)| f(**o) > 0.6) {
            assert!((value - f(*o)).abs() < 2e-3, "{o:?} {value}");
        }
    }
}
