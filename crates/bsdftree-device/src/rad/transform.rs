//! Distortion-free transformations, as Radiance's `xform` composes them.
//!
//! In: words such as `-t 1 0 0 -a 3 -rz 30`. Out: [`Steps`], from which each copy's [`Transform`] follows. Operations
//! apply in the order they are written; `-i n` and `-a n` end the group before them and repeat the group after them.
//! Source: Radiance manual page `xform`. Deviation: rotations by multiples of 90° are exact.

use glam::{DAffine3, DMat3, DVec3};

use super::statement::{quoted, real};

/// Rotation, uniform scale, mirror and translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Transform {
    affine: DAffine3,
    /// Absolute factor on lengths.
    pub scale: f64,
    /// Whether handedness changes.
    pub mirrored: bool,
}

impl Transform {
    pub(crate) const IDENTITY: Transform =
        Transform { affine: DAffine3::IDENTITY, scale: 1.0, mirrored: false };

    pub(crate) fn scaling(factor: f64) -> Self {
        let affine = DAffine3::from_scale(DVec3::splat(factor));
        Transform { affine, scale: factor.abs(), mirrored: factor < 0.0 }
    }

    fn translation(offset: DVec3) -> Self {
        Transform { affine: DAffine3::from_translation(offset), ..Self::IDENTITY }
    }

    fn rotation(axis: usize, degrees: f64) -> Self {
        let (sin, cos) = match degrees.rem_euclid(360.0) {
            0.0 => (0.0, 1.0),
            90.0 => (1.0, 0.0),
            180.0 => (0.0, -1.0),
            270.0 => (-1.0, 0.0),
            _ => degrees.to_radians().sin_cos(),
        };
        let mut columns = DMat3::IDENTITY.to_cols_array_2d();
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        (columns[u][u], columns[u][v]) = (cos, sin);
        (columns[v][u], columns[v][v]) = (-sin, cos);
        Transform { affine: DAffine3::from_mat3(DMat3::from_cols_array_2d(&columns)), ..Self::IDENTITY }
    }

    fn mirror(axis: usize) -> Self {
        let mut factors = DVec3::ONE;
        factors[axis] = -1.0;
        Transform { affine: DAffine3::from_scale(factors), scale: 1.0, mirrored: true }
    }

    /// First `self`, then `next`.
    pub(crate) fn then(&self, next: &Transform) -> Transform {
        Transform {
            affine: next.affine * self.affine,
            scale: self.scale * next.scale,
            mirrored: self.mirrored != next.mirrored,
        }
    }

    /// `self` applied `n` times.
    fn power(&self, mut n: u64) -> Transform {
        let (mut result, mut square) = (Self::IDENTITY, *self);
        while n > 0 {
            if n & 1 == 1 {
                result = result.then(&square);
            }
            square = square.then(&square);
            n >>= 1;
        }
        result
    }

    /// The same as a matrix.
    pub(crate) fn affine(&self) -> DAffine3 {
        self.affine
    }

    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.affine.transform_point3(p)
    }

    /// A direction, with its length scaled.
    pub(crate) fn vector(&self, v: DVec3) -> DVec3 {
        self.affine.transform_vector3(v)
    }

    /// Whether all of it can be computed with.
    pub(crate) fn is_finite(&self) -> bool {
        self.affine.is_finite() && self.scale.is_finite() && self.scale > 0.0
    }
}

/// What a command line should have said, and what it says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wrong {
    pub expected: String,
    pub found: String,
}

impl Wrong {
    pub(crate) fn new(expected: impl Into<String>, found: Option<&str>) -> Self {
        let found = found.map_or_else(|| "the end of the words".to_owned(), quoted);
        Wrong { expected: expected.into(), found }
    }
}

/// How often a group of operations is applied.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Repeat {
    Times(u64),
    /// One copy for each of 0, 1 … n−1 times.
    Copies(u64),
}

/// Groups of operations with their repetitions.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    groups: Vec<(Repeat, Transform)>,
}

impl Default for Steps {
    fn default() -> Self {
        Steps { groups: vec![(Repeat::Times(1), Transform::IDENTITY)] }
    }
}

impl Steps {
    /// Takes the option that the words begin with. Returns how many words it used, 0 if it is not a transformation.
    pub(crate) fn take(&mut self, words: &[&str]) -> Result<usize, Wrong> {
        let Some(&option) = words.first() else { return Ok(0) };
        let number = |n: usize| {
            let word = words.get(n).copied();
            word.and_then(real)
                .ok_or_else(|| Wrong::new(format!("a number as argument {n} of {option}"), word))
        };
        let (operation, used) = match option {
            "-t" => (Transform::translation(DVec3::new(number(1)?, number(2)?, number(3)?)), 4),
            "-rx" => (Transform::rotation(0, number(1)?), 2),
            "-ry" => (Transform::rotation(1, number(1)?), 2),
            "-rz" => (Transform::rotation(2, number(1)?), 2),
            "-s" => match number(1)? {
                0.0 => return Err(Wrong::new("a factor other than 0 after -s", words.get(1).copied())),
                factor => (Transform::scaling(factor), 2),
            },
            "-mx" => (Transform::mirror(0), 1),
            "-my" => (Transform::mirror(1), 1),
            "-mz" => (Transform::mirror(2), 1),
            "-i" => {
                // A negative count is none, and fractions are cut off, as in Radiance; the cast saturates.
                self.groups.push((Repeat::Times(number(1)? as u64), Transform::IDENTITY));
                return Ok(2);
            }
            "-a" => {
                let count = number(1)? as u64;
                if count == 0 {
                    return Err(Wrong::new("a count of at least 1 after -a", words.get(1).copied()));
                }
                self.groups.push((Repeat::Copies(count), Transform::IDENTITY));
                return Ok(2);
            }
            _ => return Ok(0),
        };
        if let Some((_, group)) = self.groups.last_mut() {
            *group = group.then(&operation);
        }
        Ok(used)
    }

    /// The counts of `-a`, outermost first.
    pub(crate) fn copies(&self) -> impl Iterator<Item = u64> {
        self.groups.iter().filter_map(|(repeat, _)| match repeat {
            Repeat::Copies(n) => Some(*n),
            Repeat::Times(_) => None,
        })
    }

    /// The transformation of the copy with these indices, one for each `-a`.
    pub(crate) fn copy(&self, indices: &[u64]) -> Transform {
        let mut indices = indices.iter();
        self.groups.iter().fold(Transform::IDENTITY, |total, (repeat, each)| {
            let times = match repeat {
                Repeat::Times(n) => *n,
                Repeat::Copies(_) => indices.next().copied().unwrap_or(0),
            };
            total.then(&each.power(times))
        })
    }
}

/// The one transformation that all the words together make, as at the end of a material's string arguments.
pub(super) fn single(words: &[String]) -> Result<Transform, Wrong> {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let mut steps = Steps::default();
    let mut at = 0;
    while at < words.len() {
        match steps.take(&words[at..])? {
            0 => return Err(Wrong::new("a transformation", Some(words[at]))),
            used => at += used,
        }
    }
    if steps.copies().next().is_some() {
        return Err(Wrong::new("a single transformation", Some("-a")));
    }
    Ok(steps.copy(&[]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single_of(text: &str) -> Result<Transform, Wrong> {
        single(&super::super::words::split(text))
    }

    #[test]
    fn operations_apply_in_the_order_written() {
        let t = single_of("-t 1 0 0 -i 2 -t 0 1 0 -i 3 -rz 30").unwrap();
        // xform of Radiance puts the origin at (-2, 1, 0).
        assert!(t.point(DVec3::ZERO).distance(DVec3::new(-2.0, 1.0, 0.0)) < 1e-15);
    }

    #[test]
    fn right_angles_are_exact() {
        assert_eq!(single_of("-rx 90 -rz -270").unwrap().point(DVec3::Y), DVec3::Z);
    }

    #[test]
    fn huge_iterations_cost_nothing() {
        let t = single_of("-i 1000000000000 -rz 360").unwrap();
        assert_eq!(t.point(DVec3::X), DVec3::X);
        assert!(!single_of("-i 1e30 -s 2").unwrap().is_finite());
    }

    #[test]
    fn negative_scale_mirrors() {
        let t = single_of("-s -2").unwrap();
        assert!(t.mirrored);
        assert_eq!(t.scale, 2.0);
        assert!(!single_of("-s -2 -mx").unwrap().mirrored);
    }

    #[test]
    fn wrong_words_are_named() {
        for (text, expected, found) in [
            ("-t 1 2", "a number as argument 3 of -t", "the end of the words"),
            ("-rx x", "a number as argument 1 of -rx", "'x'"),
            ("-s 0", "a factor other than 0 after -s", "'0'"),
            ("-q", "a transformation", "'-q'"),
            ("-rz inf", "a number as argument 1 of -rz", "'inf'"),
            ("-a 3 -t 1 0 0", "a single transformation", "'-a'"),
            ("-a -1", "a count of at least 1 after -a", "'-1'"),
        ] {
            let wrong = single_of(text).unwrap_err();
            assert_eq!((&*wrong.expected, &*wrong.found), (expected, found), "{text}");
        }
    }
}
