//! `genworm`: spheres along a curve, with cones between that touch both their neighbours.

use glam::DVec3;

use super::arguments::Arguments;
use super::functions::Functions;
use super::output::Output;
use super::{Environment, Names};
use crate::error::DeviceError;

/// Radii that differ by no more make a cylinder.
const TINY: f64 = 1e-6;

pub(super) fn generate(
    arguments: &mut Arguments,
    environment: &Environment,
    output: &mut Output,
) -> Result<(), DeviceError> {
    let names = Names::take(arguments)?;
    let formulas =
        [arguments.word("x(t)")?, arguments.word("y(t)")?, arguments.word("z(t)")?, arguments.word("r(t)")?];
    let count = arguments.word("the number of segments")?;
    let mut functions = Functions::new();
    while let Some(option) = arguments.next() {
        if !functions.option(option, arguments, environment)? {
            return Err(arguments.unknown(option));
        }
    }
    let n = functions.count(count, "the number of segments", arguments, environment)?;
    output.expect(2 * n + 1)?;
    let mut curve = functions.compile(&formulas, &["t"], environment)?;
    let mut knot = |k: u64| -> Result<(DVec3, f64), DeviceError> {
        let value = curve.at(&[k as f64 / n as f64])?;
        Ok((DVec3::new(value[0], value[1], value[2]), value[3]))
    };
    let mut last = knot(0)?;
    output.sphere(&names.modifier, names.part("s0"), last.0, last.1)?;
    for k in 1..=n {
        let next = knot(k)?;
        joint(&names, k, last, next, output)?;
        output.sphere(&names.modifier, names.part(format_args!("s{k}")), next.0, next.1)?;
        last = next;
    }
    Ok(())
}

/// What lies between two spheres.
fn joint(
    names: &Names,
    k: u64,
    (a, a_radius): (DVec3, f64),
    (b, b_radius): (DVec3, f64),
    output: &mut Output,
) -> Result<(), DeviceError> {
    let name = names.part(format_args!("c{k}"));
    if (b_radius - a_radius).abs() <= TINY {
        return output.cylinder(&names.modifier, name, [a, b], a_radius);
    }
    // The cone touches the spheres where their radii are at right angles to it.
    let along = b - a;
    let sin = (b_radius - a_radius) / along.length();
    let cos = (1.0 - sin * sin).max(0.0).sqrt();
    let shift = along.normalize_or_zero() * sin;
    let ends = [a - shift * a_radius, b - shift * b_radius];
    let reals = [&ends[0].to_array()[..], &ends[1].to_array(), &[a_radius * cos, b_radius * cos]].concat();
    output.shape(&names.modifier, "cone", name, reals)
}
