//! `genprism`: an outline extruded along a vector, its edges and corners perhaps rounded.
//!
//! Deviation: none, not even in sides that lean: of a rounded prism whose vector is not upright they meet the cylinders along its
//! edges not quite where they touch, and this does the same.

use glam::{DVec2, DVec3};

use super::arguments::Arguments;
use super::output::Output;
use super::{Environment, Names};
use crate::error::DeviceError;
use crate::rad::{quoted, real};

/// Radiance's least length that counts.
const TINY: f64 = 1e-6;

pub(super) fn generate(
    arguments: &mut Arguments,
    environment: &Environment,
    output: &mut Output,
) -> Result<(), DeviceError> {
    let names = Names::take(arguments)?;
    let outline = outline(arguments, environment)?;
    let mut prism = Prism { names, outline, along: DVec3::Z, is_closed: true };
    let (mut radius, mut has_ends) = (0.0, true);
    while let Some(option) = arguments.next() {
        match option {
            "-l" => {
                let x = arguments.number("the extrusion's x")?;
                let y = arguments.number("the extrusion's y")?;
                let z = arguments.number_that("the extrusion's z, not 0", |z| z.abs() > TINY)?;
                prism.along = DVec3::new(x, y, z);
            }
            "-r" => radius = arguments.number_that("a radius of at least 0", |r| r >= 0.0)?,
            "-c" => prism.is_closed = false,
            "-e" => has_ends = false,
            other => return Err(arguments.unknown(other)),
        }
    }
    output.expect(8 * prism.outline.len() as u64)?;
    if radius > 0.0 {
        let corners = prism.corners(radius).ok_or_else(|| {
            arguments.unexpected("an outline without sides of no length or that turn back", None)
        })?;
        prism.rounded(radius, &corners, has_ends, output)
    } else {
        prism.plain(has_ends, output)
    }
}

/// The outline's corners: from a file, or as many as are said.
fn outline(arguments: &mut Arguments, environment: &Environment) -> Result<Vec<DVec2>, DeviceError> {
    let first = arguments.word("a file of corners or their number")?;
    let numbers = if let Some(count) = real(first) {
        let count = count as u64;
        let n_numbers = 2 * count.min(environment.limit) as usize;
        let number = |k: usize| arguments.number(&format!("{} of corner {}", ["x", "y"][k % 2], k / 2 + 1));
        (0..n_numbers).map(number).collect::<Result<Vec<f64>, _>>()?
    } else {
        let text = (environment.read)(first)?;
        let number = |word: &str| {
            let what = format!("two numbers for each corner in {}", quoted(first));
            real(word).ok_or_else(|| arguments.unexpected(&what, Some(word)))
        };
        let words = text.split(|c: char| c.is_ascii_whitespace() || c == ',').filter(|word| !word.is_empty());
        words.map(number).collect::<Result<Vec<f64>, _>>()?
    };
    if numbers.len() < 6 || !numbers.len().is_multiple_of(2) {
        return Err(arguments.unexpected("at least three corners of two numbers", Some(first)));
    }
    Ok(numbers.chunks_exact(2).map(|xy| DVec2::new(xy[0], xy[1])).collect())
}

struct Prism {
    names: Names,
    outline: Vec<DVec2>,
    along: DVec3,
    is_closed: bool,
}

/// A corner of a rounded prism.
struct Corner {
    /// Centre of its rounding.
    center: DVec2,
    /// Whether the outline turns there the way it goes around, and whether it does not turn the other way.
    is_convex: bool,
    is_not_concave: bool,
}

impl Prism {
    fn plain(&self, has_ends: bool, output: &mut Output) -> Result<(), DeviceError> {
        let bottom: Vec<DVec3> = self.outline.iter().map(|p| p.extend(0.0)).collect();
        if has_ends {
            self.ends(&bottom, output)?;
        }
        for (k, a, b) in self.sides() {
            let (a, b) = (bottom[a], bottom[b]);
            let side = [a, a + self.along, b + self.along, b];
            output.polygon(&self.names.modifier, self.names.part(k), side)?;
        }
        Ok(())
    }

    fn ends(&self, bottom: &[DVec3], output: &mut Output) -> Result<(), DeviceError> {
        let Names { modifier, .. } = &self.names;
        output.polygon(modifier, self.names.part("b"), bottom.iter().copied())?;
        output.polygon(modifier, self.names.part("t"), bottom.iter().rev().map(|&p| p + self.along))
    }

    /// Number, first and second corner of each side that is drawn.
    fn sides(&self) -> impl Iterator<Item = (usize, usize, usize)> {
        let n = self.outline.len();
        let n_sides = if self.is_closed { n } else { n - 1 };
        (0..n_sides).map(move |k| (k + 1, k, (k + 1) % n))
    }

    /// 1 if the extrusion points away from where the outline goes around counter-clockwise, else −1: then normals face
    /// inward, and rounding adds to the prism.
    fn sense(&self) -> f64 {
        -self.along.z.signum()
    }

    /// `None` if a side has no length, or two run back over each other.
    fn corners(&self, radius: f64) -> Option<Vec<Corner>> {
        let n = self.outline.len();
        let along: Vec<DVec2> = (0..n)
            .map(|k| {
                let side = self.outline[(k + 1) % n] - self.outline[k];
                if side.length() > TINY { side.try_normalize() } else { None }
            })
            .collect::<Option<_>>()?;
        let corner = |k: usize| {
            let (before, after) = (along[(k + n - 1) % n], along[k]);
            let room = 1.0 + before.dot(after);
            if room <= TINY {
                return None;
            }
            let turn = before.perp_dot(after) * self.sense();
            let inward = (before.perp() + after.perp()) * (self.sense() * radius / room);
            let center = self.outline[k] + inward;
            Some(Corner { center, is_convex: turn > TINY, is_not_concave: turn >= -TINY })
        };
        (0..n).map(corner).collect()
    }

    fn rounded(
        &self,
        radius: f64,
        corners: &[Corner],
        has_ends: bool,
        output: &mut Output,
    ) -> Result<(), DeviceError> {
        let Names { modifier, .. } = &self.names;
        let bottom: Vec<DVec3> = corners.iter().map(|c| c.center.extend(0.0)).collect();
        let inset = DVec3::Z * (radius * self.along.z.signum());
        let levels = [inset, self.along - inset];
        if has_ends {
            self.ends(&bottom, output)?;
            for (end, level) in ["b", "t"].into_iter().zip(levels) {
                for (k, corner) in corners.iter().enumerate() {
                    let before = (k + corners.len() - 1) % corners.len();
                    if corner.is_convex {
                        let name = self.names.part(format_args!("{end}c{}", k + 1));
                        output.sphere(modifier, name, bottom[k] + level, radius)?;
                    }
                    let name = self.names.part(format_args!("{end}e{}", k + 1));
                    output.cylinder(modifier, name, [bottom[before] + level, bottom[k] + level], radius)?;
                }
            }
        }
        for (k, a, b) in self.sides() {
            let outward = self.outward(a, b) * radius;
            let [low, high] = levels;
            let side = [bottom[a] + low, bottom[a] + high, bottom[b] + high, bottom[b] + low];
            output.polygon(modifier, self.names.part(k), side.map(|p| p + outward))?;
            if corners[b].is_not_concave {
                let name = self.names.part(format_args!("e{k}"));
                output.cylinder(modifier, name, [bottom[b] + low, bottom[b] + high], radius)?;
            }
        }
        Ok(())
    }

    /// Where the cylinder along a side touches it, seen from its axis.
    fn outward(&self, a: usize, b: usize) -> DVec3 {
        let along = (self.outline[b] - self.outline[a]).normalize_or_zero();
        let flat = -along.perp() * self.sense();
        let lean = self.along.truncate() / self.along.z;
        let up = -flat.dot(lean) / (1.0 + along.dot(lean).powi(2)).sqrt();
        flat.extend(up).normalize_or_zero()
    }
}
