//! Binary files of the MERL database of isotropic reflectances.
//!
//! In: three 32-bit counts 90, 90, 180, then doubles of red, green and blue one after the other, each over θ_half (slowest, bins that grow
//! with the square of their number), θ_diff and φ_diff (half a turn, since both directions may be swapped). Out: scans at nine polar
//! angles at points around the mirrored direction, as X, Y, Z of RGB with equal-energy white. Values are those of the bin, as in the
//! database's own reader; negative ones say that nothing was measured there, and are left out.
//!
//! Source: W. Matusik, H. Pfister, M. Brand, L. McMillan, "A Data-Driven Reflectance Model", SIGGRAPH 2003, and the published layout.

use std::f64::consts::{FRAC_PI_2, PI};

use bsdftree::Direction;
use bsdftree::color::xyz_from_rgb;

use crate::measurement::{Measurement, Scan, Symmetry};

use super::error::ReadError;
use super::points::around_mirror;
use super::text::direction_from_degrees;

const SHAPE: [usize; 3] = [90, 90, 180];
const N: usize = SHAPE[0] * SHAPE[1] * SHAPE[2];
const HEAD: usize = 12;
/// What stored numbers of red, green and blue are multiplied by.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
/// Where the light comes from \[degree\]; beyond 80° the database extrapolates.
const THETAS_DEG: [f64; 9] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0];

fn count_at(bytes: &[u8], at: usize) -> Option<usize> {
    let word = bytes.get(at..at + 4)?.try_into().ok()?;
    usize::try_from(i32::from_le_bytes(word)).ok()
}

/// Whether it begins with the counts.
pub(super) fn recognizes(bytes: &[u8]) -> bool {
    (0..3).all(|k| count_at(bytes, 4 * k) == Some(SHAPE[k]))
}

/// Reads a file.
///
/// # Errors
/// If counts or length are others.
pub(super) fn read(bytes: &[u8]) -> Result<Measurement, ReadError> {
    if !recognizes(bytes) {
        let counts: Vec<String> =
            (0..3).map(|k| count_at(bytes, 4 * k).map_or("nothing".into(), |n| n.to_string())).collect();
        return Err(ReadError::byte(0, counts.join(", "), "the counts 90, 90, 180 as 32-bit integers"));
    }
    let (numbers, rest) = bytes[HEAD..].as_chunks::<8>();
    if numbers.len() != 3 * N || !rest.is_empty() {
        let found = format!("{} bytes after the counts", bytes.len() - HEAD);
        return Err(ReadError::byte(HEAD, found, format!("{}, which are {} doubles", 24 * N, 3 * N)));
    }
    let mut scans = Vec::new();
    let mut n_left_out = 0;
    for theta_deg in THETAS_DEG {
        let incident = direction_from_degrees(theta_deg, 0.0);
        let mut scan = Scan { incident, source: format!("incidence {theta_deg}°"), ..Scan::default() };
        for exitant in around_mirror(incident) {
            let bin = bin(incident, exitant);
            let stored = [0, 1, 2].map(|channel| f64::from_le_bytes(numbers[channel * N + bin]));
            if let Some(channel) = stored.iter().position(|number| !number.is_finite()) {
                let byte = HEAD + 8 * (channel * N + bin);
                return Err(ReadError::byte(byte, stored[channel].to_string(), "a finite number"));
            }
            if stored.iter().any(|&number| number < 0.0) {
                n_left_out += 1;
                continue;
            }
            scan.exitant.push(exitant);
            scan.values.extend(xyz_from_rgb([0, 1, 2].map(|k| stored[k] * SCALES[k])));
        }
        scans.push(scan);
    }
    let mut notes = vec!["red, green and blue are taken as Radiance's, with equal-energy white".into()];
    if n_left_out > 0 {
        notes.push(format!("{n_left_out} points whose bins say that nothing was measured are left out"));
    }
    scans.retain(|scan| !scan.exitant.is_empty());
    Ok(Measurement {
        n_channels: 3,
        scans,
        symmetry: Some(Symmetry::Isotropic),
        notes,
        ..Measurement::default()
    })
}

/// The bin of a pair of directions, both over the horizon.
fn bin(incident: Direction, exitant: Direction) -> usize {
    let sum = [0, 1, 2].map(|k| incident[k] + exitant[k]);
    let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt();
    let half = sum.map(|c| c / length);
    let theta_half = half[2].clamp(-1.0, 1.0).acos();
    let sine = half[0].hypot(half[1]);
    // Turned so that the half vector is the pole: first about Z, then about Y.
    let [c, s] = if sine < 1e-12 { [1.0, 0.0] } else { [half[0] / sine, half[1] / sine] };
    let turned = [c * incident[0] + s * incident[1], c * incident[1] - s * incident[0], incident[2]];
    let diff = [half[2] * turned[0] - sine * turned[2], turned[1], sine * turned[0] + half[2] * turned[2]];
    let theta_diff = diff[2].clamp(-1.0, 1.0).acos();
    let phi_diff = diff[1].atan2(diff[0]).rem_euclid(PI);
    let at = |fraction: f64, n: usize| ((fraction * n as f64) as usize).min(n - 1);
    let half = at((theta_half / FRAC_PI_2).sqrt(), SHAPE[0]);
    (half * SHAPE[1] + at(theta_diff / FRAC_PI_2, SHAPE[1])) * SHAPE[2] + at(phi_diff / PI, SHAPE[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of a function of θ_half, θ_diff and φ_diff \[rad\] at the middles of bins.
    fn file(f: impl Fn(f64, f64, f64) -> f64) -> Vec<u8> {
        let mut bytes: Vec<u8> = SHAPE.iter().flat_map(|&n| (n as i32).to_le_bytes()).collect();
        for scale in SCALES {
            for k in 0..N {
                let middle = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
                let half = middle(k / (SHAPE[1] * SHAPE[2]), SHAPE[0]).powi(2) * FRAC_PI_2;
                let diff = middle(k / SHAPE[2] % SHAPE[1], SHAPE[1]) * FRAC_PI_2;
                bytes.extend((f(half, diff, middle(k % SHAPE[2], SHAPE[2]) * PI) / scale).to_le_bytes());
            }
        }
        bytes
    }

    #[test]
    fn reads_a_lobe_about_the_mirrored_direction() {
        let read = read(&file(|half, _, _| 0.1 + (-half * half / 0.02).exp())).unwrap();
        assert_eq!((read.scans.len(), read.n_channels), (9, 3));
        for scan in &read.scans {
            for (o, xyz) in scan.exitant.iter().zip(scan.values.as_chunks::<3>().0) {
                let half: f64 = (0..3).map(|k| (scan.incident[k] + o[k]).powi(2)).sum::<f64>().sqrt();
                let angle = ((scan.incident[2] + o[2]) / half).min(1.0).acos();
                let expected = 0.1 + (-angle * angle / 0.02).exp();
                // A bin is as wide as (2k + 1)/90² · 90°.
                assert!((xyz[1] - expected).abs() < 0.06, "{} for {expected}", xyz[1]);
                assert!((xyz[0] - xyz[1]).abs() < 1e-3 * xyz[1], "grey stays grey");
            }
        }
    }

    #[test]
    fn differences_are_told_apart() {
        // θ_diff is the angle between the light and the half vector.
        let read = read(&file(|_, diff, phi| diff + 10.0 * phi)).unwrap();
        let scan = &read.scans[4];
        let first = &scan.values[..3];
        // Mirrored: θ_diff is 40°, φ_diff is 0 or π, which are one bin's ends.
        let near = |phi: f64| (first[1] - 40f64.to_radians() - 10.0 * phi).abs() < 0.2;
        assert!(near(0.0) || near(PI), "{first:?}");
    }

    #[test]
    fn faulty_files_are_refused() {
        let good = file(|_, _, _| 0.1);
        for (bytes, said) in [
            (&good[..1000], "byte 12: found 988 bytes after the counts; expected 34992000"),
            (&good[..7], "byte 0: found 90, nothing, nothing; expected the counts 90, 90, 180"),
        ] {
            let message = read(bytes).unwrap_err().to_string();
            assert!(message.contains(said), "{message}");
        }
        assert!(
            read(&file(|_, _, _| f64::NAN)).unwrap_err().to_string().contains("expected a finite number")
        );
        assert!(read(&file(|_, _, _| -1.0)).unwrap().scans.is_empty());
    }
}
