//! The points of a surface over s and t, from formulas or from a file of numbers.
//!
//! In: formulas or numbers. Out: points at steps of 1/m and 1/n, one step beyond the surface on each side where normals
//! are wanted. A point where `valid(s,t)` is not above 0 is none.

use glam::DVec3;

use super::Environment;
use super::arguments::Arguments;
use super::functions::Curve;
use crate::error::DeviceError;
use crate::rad::{quoted, real};

/// Points in rows of equal s, from `-margin` to `m + margin` and `n + margin`.
pub(super) struct Grid {
    pub m: usize,
    pub n: usize,
    margin: usize,
    /// Where it is, and whether it is there.
    points: Vec<(DVec3, bool)>,
}

impl Grid {
    /// Takes the points for their s and t from `point`.
    pub fn fill(
        m: usize,
        n: usize,
        is_smooth: bool,
        mut point: impl FnMut(f64, f64) -> Result<(DVec3, bool), DeviceError>,
    ) -> Result<Grid, DeviceError> {
        let margin = is_smooth as usize;
        let step = |k: usize, count: usize| (k as f64 - margin as f64) / count as f64;
        let mut points = Vec::with_capacity((m + 1 + 2 * margin) * (n + 1 + 2 * margin));
        for i in 0..=m + 2 * margin {
            for j in 0..=n + 2 * margin {
                points.push(point(step(i, m), step(j, n))?);
            }
        }
        Ok(Grid { m, n, margin, points })
    }

    /// At these steps; they may be −1 or one beyond the last if there is a margin.
    fn get(&self, i: isize, j: isize) -> (DVec3, bool) {
        let place = |k: isize| (k + self.margin as isize) as usize;
        self.points[place(i) * (self.n + 1 + 2 * self.margin) + place(j)]
    }

    /// The point at these steps, if it is there.
    pub fn point(&self, i: usize, j: usize) -> Option<DVec3> {
        let (position, is_there) = self.get(i as isize, j as isize);
        is_there.then_some(position)
    }

    /// Where the point at these steps is, or would be.
    pub fn position(&self, i: usize, j: usize) -> DVec3 {
        self.get(i as isize, j as isize).0
    }

    /// Unit normal at a point, of the four steps around it as far as they lead to points; 0 where there is none.
    pub fn normal(&self, i: usize, j: usize) -> DVec3 {
        let Some(here) = self.point(i, j) else { return DVec3::ZERO };
        let (i, j) = (i as isize, j as isize);
        let step = |di: isize, dj: isize| match self.get(i + di, j + dj) {
            (position, true) => position - here,
            (_, false) => DVec3::ZERO,
        };
        (step(1, 0) - step(-1, 0)).cross(step(0, 1) - step(0, -1)).normalize_or_zero()
    }
}

/// A point by formulas of x, y, z, and of `valid` if that is a fourth.
pub(super) fn by_formulas(curve: &mut Curve, s: f64, t: f64) -> Result<(DVec3, bool), DeviceError> {
    let value = curve.at(&[s, t])?;
    let is_there = value.get(3).is_none_or(|&valid| valid > 0.0);
    Ok((DVec3::new(value[0], value[1], value[2]), is_there))
}

/// Numbers of a file over s and t, `size` of them at each place.
pub(super) struct Table {
    numbers: Vec<f64>,
    size: usize,
    /// Places along s and t.
    counts: [usize; 2],
    /// Whether the places are the centres of the cells, not their corners.
    is_centered: bool,
}

impl Table {
    pub fn read(
        file: &str,
        [m, n]: [usize; 2],
        size: usize,
        arguments: &Arguments,
        environment: &Environment,
    ) -> Result<Table, DeviceError> {
        let text = (environment.read)(file)?;
        let number = |word: &str| {
            let what = format!("a number in {}", quoted(file));
            real(word).ok_or_else(|| arguments.unexpected(&what, Some(word)))
        };
        let numbers: Vec<f64> = text.split_ascii_whitespace().map(number).collect::<Result<_, _>>()?;
        let is_centered = numbers.len() == size * m * n && m > 1 && n > 1;
        let counts = if is_centered { [m, n] } else { [m + 1, n + 1] };
        if numbers.len() != size * counts[0] * counts[1] {
            let (corners, centers) = (size * (m + 1) * (n + 1), size * m * n);
            let what =
                format!("{corners} numbers (corners) or {centers} (centres of cells) in {}", quoted(file));
            return Err(arguments.unexpected(&what, Some(&numbers.len().to_string())));
        }
        Ok(Table { numbers, size, counts, is_centered })
    }

    /// The numbers at s and t, linear between places and beyond them.
    pub fn at(&self, s: f64, t: f64) -> [f64; 3] {
        let [(i, u), (j, v)] = [(s, self.counts[0]), (t, self.counts[1])].map(|(x, count)| {
            let x = if self.is_centered { x * count as f64 - 0.5 } else { x * (count - 1) as f64 };
            let cell = x.floor().clamp(0.0, (count - 2) as f64);
            (cell as usize, x - cell)
        });
        std::array::from_fn(|k| {
            let number = |i: usize, j: usize| {
                self.numbers.get((j * self.counts[0] + i) * self.size + k).copied().unwrap_or(0.0)
            };
            let row = |j: usize| number(i, j) * (1.0 - u) + number(i + 1, j) * u;
            row(j) * (1.0 - v) + row(j + 1) * v
        })
    }
}
