//! Whether units and sides look as they should: what is doubtful becomes a note, nothing is changed.
//!
//! In: a measurement. Out: notes. A scattered fraction over 1 means another scale (percent?); values that fall as the cosine does towards
//! the horizon mean that a cosine is in them (DSF); light that mostly goes back to the side that it came from means that azimuths of the
//! light are where it goes. Each is said only if most of the scans that can tell agree. Of light in one plane, which samples that are
//! isotropic are measured with, sides of that plane that differ are a note too: a fit would average them.

use bsdftree::Direction;
use bsdftree::direction::Side;

use crate::coverage::angle_deg;
use crate::measurement::{Measurement, Scan};
use crate::summary::summary;

/// Scattered fraction that noise and coarse points may reach.
const LARGEST_TOTAL: f64 = 1.15;

/// Relative difference of mirror images that noise, and lobes that are narrow for their points, may reach.
const LARGEST_ASYMMETRY: f64 = 0.25;

/// Most scans that are looked at, evenly spread.
const MOST_SCANS: usize = 200;

/// What is doubtful.
pub(super) fn doubts(measurement: &Measurement) -> Vec<String> {
    let step = measurement.scans.len().div_ceil(MOST_SCANS).max(1);
    let measurement = &Measurement {
        n_channels: measurement.n_channels,
        scans: measurement.scans.iter().step_by(step).cloned().collect(),
        symmetry: measurement.symmetry,
        ..Measurement::default()
    };
    let n = measurement.n_channels;
    // Y of X, Y, Z.
    let channel = if n == 3 { 1 } else { 0 };
    let mut notes = Vec::new();
    let rows = summary(measurement);
    let largest = rows.iter().filter_map(|row| row.total).fold(0.0, f64::max);
    if largest > LARGEST_TOTAL {
        notes.push(format!(
            "up to {largest:.3} of the light would be scattered, more than there is: values may be percent, or of another scale"
        ));
    }
    let asymmetries = rows.iter().filter_map(|row| Some((row.asymmetry?, row.incident_deg[0])));
    let most = asymmetries.max_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((asymmetry, theta_deg)) = most.filter(|(asymmetry, _)| *asymmetry > LARGEST_ASYMMETRY)
        && is_in_one_plane(&measurement.scans)
    {
        notes.push(format!(
            "the two sides of the plane of incidence differ by up to {:.0} % (light from {theta_deg:.1}°): the sample is not isotropic, or not \
             level; a fit as isotropic averages them",
            100.0 * asymmetry
        ));
    }
    let scans: Vec<Vec<(Direction, f64)>> = measurement
        .scans
        .iter()
        .map(|scan| {
            scan.exitant.iter().enumerate().map(|(k, &o)| (o, scan.values[n * k + channel])).collect()
        })
        .collect();
    let falls: Vec<bool> =
        measurement.scans.iter().zip(&scans).filter_map(|(s, points)| falls_as_cosine(s, points)).collect();
    if is_mostly(&falls) {
        notes.push(
            "values fall like the cosine towards the horizon: they may be DSFs, with the cosine in them"
                .into(),
        );
    }
    let returns: Vec<bool> =
        measurement.scans.iter().zip(&scans).filter_map(|(s, points)| returns(s, points)).collect();
    if is_mostly(&returns) {
        notes.push(
            "most light goes back to where it came from: azimuths of the light may be where it goes, so add 180° to them".into(),
        );
    }
    notes
}

/// Whether all light comes from one plane through the normal.
fn is_in_one_plane(scans: &[Scan]) -> bool {
    let length = |i: Direction| i[0].hypot(i[1]);
    let slanted: Vec<Direction> =
        scans.iter().map(|scan| scan.incident).filter(|&i| length(i) > 0.02).collect();
    slanted.iter().all(|i| {
        let [a, b] = [slanted[0], *i];
        (a[0] * b[1] - a[1] * b[0]).abs() < 0.02 * length(a) * length(b)
    })
}

fn is_mostly(answers: &[bool]) -> bool {
    !answers.is_empty() && answers.iter().filter(|&&yes| yes).count() * 4 >= answers.len() * 3
}

/// The slope of log f over log cos θ near the horizon, away from the mirrored direction, is about 1.
fn falls_as_cosine(scan: &Scan, points: &[(Direction, f64)]) -> Option<bool> {
    const AWAY_DEG: f64 = 45.0;
    let [x, y, z] = scan.incident;
    let far = |o: Direction| angle_deg(o, [-x, -y, z]) > AWAY_DEG && angle_deg(o, [-x, -y, -z]) > AWAY_DEG;
    let logs: Vec<[f64; 2]> = points
        .iter()
        .filter(|&&(o, value)| value > 0.0 && (0.02..0.5).contains(&o[2].abs()) && far(o))
        .map(|&(o, value)| [o[2].abs().ln(), value.ln()])
        .collect();
    let n = logs.len() as f64;
    if n < 20.0 {
        return None;
    }
    let mean = [0, 1].map(|k| logs.iter().map(|log| log[k]).sum::<f64>() / n);
    let product =
        |a: usize, b: usize| logs.iter().map(|log| (log[a] - mean[a]) * (log[b] - mean[b])).sum::<f64>();
    let slope = product(0, 1) / product(0, 0);
    let correlation = product(0, 1) / (product(0, 0) * product(1, 1)).sqrt();
    // Noise-free cosines have 1 and 1; diffusers, and what rises towards the horizon, 0 and less.
    (n > 0.0 && product(0, 0) > 0.0).then_some((0.85..1.2).contains(&slope) && correlation > 0.9)
}

/// Of what is reflected, the brightest tenth lies on the side of the light.
fn returns(scan: &Scan, points: &[(Direction, f64)]) -> Option<bool> {
    let [x, y, z] = scan.incident;
    let sine = x.hypot(y);
    let mut points: Vec<&(Direction, f64)> =
        points.iter().filter(|(o, _)| Side::of(*o) == Side::of(scan.incident)).collect();
    if sine < 0.3 || z.abs() < 0.1 || points.len() < 30 {
        return None;
    }
    let along = |o: Direction| (o[0] * x + o[1] * y) / sine;
    // Both sides must have been measured alike.
    let has = |sign: f64| points.iter().any(|(o, _)| (along(*o) * sign - sine).abs() < 0.1);
    if !has(1.0) || !has(-1.0) {
        return None;
    }
    points.sort_by(|a, b| b.1.total_cmp(&a.1));
    let brightest = &points[..points.len() / 10];
    let dimmest = points[points.len() / 2].1;
    let mean = brightest.iter().map(|(o, _)| along(*o)).sum::<f64>() / brightest.len() as f64;
    Some(mean > 0.4 * sine && brightest[0].1 > 3.0 * dimmest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdftree::direction::direction_from_polar;

    fn measurement(f: impl Fn(Direction, Direction) -> f64) -> Measurement {
        let at = |theta: i32, phi: i32| {
            direction_from_polar(f64::from(theta).to_radians(), f64::from(phi).to_radians())
        };
        let exitant: Vec<Direction> =
            (2..90).step_by(4).flat_map(|t| (0..360).step_by(6).map(move |p| at(t, p))).collect();
        let scan = |incident: Direction| Scan {
            incident,
            values: exitant.iter().map(|&o| f(incident, o)).collect(),
            exitant: exitant.clone(),
            ..Scan::default()
        };
        Measurement {
            n_channels: 1,
            scans: [20, 40, 60].map(|t| scan(at(t, 70))).into(),
            ..Measurement::default()
        }
    }

    fn lobe(i: Direction, o: Direction) -> f64 {
        0.1 + 3.0 * (30.0 * (-i[0] * o[0] - i[1] * o[1] + i[2] * o[2] - 1.0)).exp()
    }

    #[test]
    fn only_what_is_doubtful_is_doubted() {
        assert_eq!(doubts(&measurement(lobe)), Vec::<String>::new());
        assert_eq!(doubts(&measurement(|_, _| 0.3)), Vec::<String>::new());
        for (f, said) in [
            ((|i, o| 50.0 * lobe(i, o)) as fn(Direction, Direction) -> f64, "percent"),
            (|i, o| o[2] * lobe(i, o), "cosine"),
            (|i, o| lobe([-i[0], -i[1], i[2]], o), "goes back"),
            (|i, o| lobe(i, o) * if i[0] * o[1] > i[1] * o[0] { 1.5 } else { 1.0 }, "not isotropic"),
        ] {
            let notes = doubts(&measurement(f));
            assert!(notes.len() == 1 && notes[0].contains(said), "{notes:?} for {said}");
        }
    }
}
