//! `genblinds`: slats one above the other, flat or curved.

use glam::{DVec3, dvec3};

use super::arguments::Arguments;
use super::output::Output;
use super::{Environment, Names};
use crate::error::DeviceError;

/// Angle of the strips of a curved slat \[rad\]; an angle this much of a strip longer still makes no strip more.
const STRIP: f64 = std::f64::consts::PI / 60.0;
const TOLERANCE: f64 = 1e-5;

pub(super) fn generate(
    arguments: &mut Arguments,
    _: &Environment,
    output: &mut Output,
) -> Result<(), DeviceError> {
    let names = Names::take(arguments)?;
    let depth = arguments.number("the depth of the slats")?;
    let width = arguments.number("the width of the slats")?;
    let height = arguments.number("the height of the blind")?;
    let n_slats = arguments.count("the number of slats", 0)?;
    let (sin, cos) = arguments.number("the angle of the slats")?.to_radians().sin_cos();
    let profile = match arguments.next() {
        None => vec![(0.0, 0.0), (depth, 0.0)],
        Some(option @ ("-r" | "+r")) => {
            let what = "a radius of at least half the depth";
            let radius =
                arguments.number_that(what, |r| r == 0.0 || 2.0 * r.abs() >= depth && depth > 0.0)?;
            curved(depth, if option == "-r" { -radius } else { radius })
        }
        Some(other) => return Err(arguments.unknown(other)),
    };
    if let Some(other) = arguments.next() {
        return Err(arguments.unknown(other));
    }
    output.expect(n_slats.saturating_mul(profile.len() as u64 - 1))?;
    let pitch = height / n_slats as f64;
    for slat in 1..=n_slats {
        let rise = pitch * (slat as f64 - 0.5);
        let point =
            |(along, up): (f64, f64), y: f64| dvec3(along * cos - up * sin, y, along * sin + up * cos + rise);
        for (strip, ends) in profile.windows(2).enumerate() {
            let (a, b) = (ends[0], ends[1]);
            let corners: [DVec3; 4] = [point(a, 0.0), point(a, width), point(b, width), point(b, 0.0)];
            output.polygon(&names.modifier, names.part(format_args!("{slat}.{strip}")), corners)?;
        }
    }
    Ok(())
}

/// Points of an arc over a chord of this length, above it if the radius is positive.
fn curved(chord: f64, radius: f64) -> Vec<(f64, f64)> {
    if radius == 0.0 {
        return vec![(0.0, 0.0), (chord, 0.0)];
    }
    let half = (0.5 * chord / radius.abs()).asin();
    let n = (2.0 * half / STRIP + 1.0 - TOLERANCE).floor();
    let point = |k: u32| {
        let angle = half * (2.0 * f64::from(k) / n - 1.0);
        (0.5 * chord + radius.abs() * angle.sin(), radius * (angle.cos() - half.cos()))
    };
    (0..=n as u32).map(point).collect()
}
