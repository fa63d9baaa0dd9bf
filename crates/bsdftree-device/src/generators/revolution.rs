//! `genrev`: a curve turned about the z axis, in cones, cylinders and rings.

use glam::DVec2;

use super::arguments::Arguments;
use super::functions::Functions;
use super::output::Output;
use super::{Environment, Names};
use crate::error::DeviceError;

/// Heights or radii that differ by no more are the same.
const TINY: f64 = 1e-6;

pub(super) fn generate(
    arguments: &mut Arguments,
    environment: &Environment,
    output: &mut Output,
) -> Result<(), DeviceError> {
    let names = Names::take(arguments)?;
    let formulas = [arguments.word("z(t)")?, arguments.word("r(t)")?];
    let count = arguments.word("the number of segments")?;
    let mut functions = Functions::new();
    let mut is_smooth = false;
    while let Some(option) = arguments.next() {
        if option == "-s" {
            is_smooth = true;
        } else if !functions.option(option, arguments, environment)? {
            return Err(arguments.unknown(option));
        }
    }
    let n = functions.count(count, "the number of segments", arguments, environment)?;
    output.expect(n * (1 + is_smooth as u64))?;
    let mut curve = functions.compile(&formulas, &["t"], environment)?;
    let knots = (0..=n).map(|k| {
        // Radiance multiplies by the step.
        let value = curve.at(&[k as f64 * (1.0 / n as f64)])?;
        Ok(DVec2::new(value[0], value[1]))
    });
    let knots: Vec<DVec2> = knots.collect::<Result<_, DeviceError>>()?;
    let normals: Vec<DVec2> = knots.windows(2).map(|ends| normal(ends[0], ends[1])).collect();
    for (k, ends) in knots.windows(2).enumerate() {
        let (a, b) = (ends[0], ends[1]);
        let Some(kind) = Kind::of(a, b) else { continue };
        let modifier = if is_smooth {
            let beside =
                |at: Option<usize>| at.and_then(|at| normals.get(at)).copied().unwrap_or(DVec2::ZERO);
            let neighbours = [beside(k.checked_sub(1)), beside(Some(k + 1))];
            let reals = texture([a, b], normals[k], neighbours);
            let strings = ["rev_dx", "rev_dy", "rev_dz", "rev.cal"];
            output.primitive(&names.modifier, "texfunc", "Phong".to_owned(), &strings, reals)?;
            "Phong"
        } else {
            &names.modifier
        };
        let (name, reals) = (names.part(k + 1), kind.reals(a, b));
        output.shape(modifier, kind.name, name, reals)?;
    }
    Ok(())
}

/// Unit normal of a segment in (z, r), to the right of its way.
fn normal(a: DVec2, b: DVec2) -> DVec2 {
    let along = b - a;
    DVec2::new(-along.y, along.x).normalize_or_zero()
}

/// Arguments of the functions of `rev.cal`: slope and offset in z of the z component, and in r of the r component. What is
/// added to the normal is the neighbour's normal at each end, which makes the mean of both there.
fn texture([a, b]: [DVec2; 2], own: DVec2, [before, after]: [DVec2; 2]) -> Vec<f64> {
    let line = |axis: usize| {
        let length = b[axis] - a[axis];
        if length.abs() <= TINY {
            return [0.0, own[axis]];
        }
        let slope = (after[axis] - before[axis]) / length;
        [slope, before[axis] - slope * a[axis]]
    };
    [line(0), line(1)].concat()
}

struct Kind {
    name: &'static str,
    /// 1: by heights and two radii; 2: by heights and one radius; 3: a ring.
    form: u8,
}

impl Kind {
    /// `None` if there is nothing to draw.
    fn of(a: DVec2, b: DVec2) -> Option<Kind> {
        let (rise, widening) = (b.x - a.x, b.y - a.y);
        let (rises, falls) = (rise > TINY, rise < -TINY);
        let (name, form) = match (rises, falls, widening.abs() <= TINY) {
            (true, _, false) => ("cone", 1),
            (_, true, false) => ("cup", 1),
            (true, _, true) => ("cylinder", 2),
            (_, true, true) => ("tube", 2),
            (_, _, false) => ("ring", 3),
            (_, _, true) => return None,
        };
        Some(Kind { name, form })
    }

    fn reals(&self, a: DVec2, b: DVec2) -> Vec<f64> {
        match self.form {
            1 => vec![0.0, 0.0, a.x, 0.0, 0.0, b.x, a.y, b.y],
            2 => vec![0.0, 0.0, a.x, 0.0, 0.0, b.x, a.y],
            _ => vec![0.0, 0.0, a.x, 0.0, 0.0, if b.y > a.y { -1.0 } else { 1.0 }, a.y, b.y],
        }
    }
}
