//! `gensurf`: a surface over s and t, in quadrangles where they are flat, else in triangles.

use glam::DVec3;

use super::arguments::Arguments;
use super::functions::Functions;
use super::grid::{self, Grid, Table};
use super::output::Output;
use super::{Environment, Names};
use crate::error::DeviceError;

/// Sine of the angle between two triangles that still are a quadrangle.
const TINY: f64 = 1e-6;

pub(super) fn generate(
    arguments: &mut Arguments,
    environment: &Environment,
    output: &mut Output,
) -> Result<(), DeviceError> {
    let names = Names::take(arguments)?;
    let formulas = [arguments.word("x(s,t)")?, arguments.word("y(s,t)")?, arguments.word("z(s,t)")?];
    let counts =
        [arguments.word("m, the number of steps of s,")?, arguments.word("n, the number of steps of t,")?];
    let mut functions = Functions::new();
    let (mut is_smooth, mut is_reversed) = (false, false);
    while let Some(option) = arguments.next() {
        match option {
            "-s" => is_smooth = true,
            "-i" => is_reversed = true,
            other if functions.option(other, arguments, environment)? => {}
            other => return Err(arguments.unknown(other)),
        }
    }
    let m = functions.count(counts[0], "the number of steps of s", arguments, environment)?;
    let n = functions.count(counts[1], "the number of steps of t", arguments, environment)?;
    output.expect(m.saturating_mul(n).saturating_mul(1 + is_smooth as u64))?;
    let counts = [m as usize, n as usize];
    let grid = points(&formulas, counts, is_smooth, &functions, arguments, environment)?;
    Surface { names, grid, is_smooth, is_reversed, count: 0 }.draw(output)
}

fn points(
    formulas: &[&str; 3],
    counts: [usize; 2],
    is_smooth: bool,
    functions: &Functions,
    arguments: &Arguments,
    environment: &Environment,
) -> Result<Grid, DeviceError> {
    let [x, y, z] = *formulas;
    let [m, n] = counts;
    if z == "-" {
        return Err(arguments.unexpected("a file of numbers or formulas; commands have no input", Some(z)));
    }
    if !(environment.is_file)(z) {
        let mut formulas = formulas.to_vec();
        if functions.has("valid") {
            formulas.push("valid(s,t)");
        }
        let mut curve = functions.compile(&formulas, &["s", "t"], environment)?;
        return Grid::fill(m, n, is_smooth, |s, t| grid::by_formulas(&mut curve, s, t));
    }
    if x == z && y == z {
        let table = Table::read(z, counts, 3, arguments, environment)?;
        return Grid::fill(m, n, is_smooth, |s, t| Ok((DVec3::from_array(table.at(s, t)), true)));
    }
    let table = Table::read(z, counts, 1, arguments, environment)?;
    let mut formulas = vec![x, y, "0"];
    if functions.has("valid") {
        formulas.push("valid(s,t)");
    }
    let mut curve = functions.compile(&formulas, &["s", "t"], environment)?;
    Grid::fill(m, n, is_smooth, |s, t| {
        let (point, is_there) = grid::by_formulas(&mut curve, s, t)?;
        Ok((point.with_z(table.at(s, t)[0]), is_there))
    })
}

struct Surface {
    names: Names,
    grid: Grid,
    is_smooth: bool,
    is_reversed: bool,
    count: u64,
}

/// A corner of a cell, if it is there.
type Corner = Option<DVec3>;

impl Surface {
    fn draw(&mut self, output: &mut Output) -> Result<(), DeviceError> {
        for i in 0..self.grid.m {
            for j in 0..self.grid.n {
                self.cell(i, j, output)?;
            }
        }
        Ok(())
    }

    /// Draws the cell between (i, j) and (i + 1, j + 1).
    fn cell(&mut self, i: usize, j: usize, output: &mut Output) -> Result<(), DeviceError> {
        let corner = |di: usize, dj: usize| self.grid.point(i + di, j + dj);
        let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
        // Cells are cut along the one and the other diagonal in turn, unless a corner is missing there.
        let along_ac =
            if j.is_multiple_of(2) { a.is_some() && c.is_some() } else { b.is_none() || d.is_none() };
        let (whole, halves) = match along_ac {
            true => ([b, c, d, a], [[b, c, a], [a, c, d]]),
            false => ([a, b, c, d], [[a, b, d], [d, b, c]]),
        };
        let normals = halves.map(|half| area(half).and_then(DVec3::try_normalize));
        let at = [i, j];
        match normals {
            [Some(first), Some(second)] if first.distance(second) <= TINY => {
                let [p, q, r, s] = whole;
                self.polygon(at, first, &if self.is_reversed { [p, s, r, q] } else { whole }, output)
            }
            [first, second] => {
                let [[a, b, c], [d, e, f]] = halves;
                let turned = if self.is_reversed { [[a, c, b], [e, d, f]] } else { halves };
                for (half, normal) in turned.into_iter().zip([first, second]) {
                    if let Some(normal) = normal {
                        self.polygon(at, normal, &half, output)?;
                    }
                }
                Ok(())
            }
        }
    }

    fn polygon(
        &mut self,
        at: [usize; 2],
        normal: DVec3,
        corners: &[Corner],
        output: &mut Output,
    ) -> Result<(), DeviceError> {
        let texture = if self.is_smooth { self.texture(at, normal) } else { None };
        let modifier = match texture {
            Some(reals) => {
                let strings = ["surf_dx", "surf_dy", "surf_dz", "surf.cal"];
                output.primitive(&self.names.modifier, "texfunc", "Phong".to_owned(), &strings, reals)?;
                "Phong"
            }
            None => &self.names.modifier,
        };
        self.count += 1;
        output.polygon(modifier, self.names.part(self.count), corners.iter().flatten().copied())
    }

    /// Arguments of the functions of `surf.cal` for a cell: the axis its corners' normals face most, and what is added to the normal
    /// as a polynomial in the next two axes, u and v: factors of uv, u, v and 1. It leads to the normals at the corners.
    fn texture(&self, [i, j]: [usize; 2], normal: DVec3) -> Option<Vec<f64>> {
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[di, dj]| [i + di, j + dj]);
        let normals = corners.map(|[i, j]| self.grid.normal(i, j));
        let axis = normals.iter().sum::<DVec3>().abs().max_position();
        let mut rows = [[0.0; 7]; 4];
        for (row, ([i, j], wanted)) in rows.iter_mut().zip(corners.into_iter().zip(normals)) {
            let p = self.grid.position(i, j);
            let added = wanted - normal;
            let (u, v) = (p[(axis + 1) % 3], p[(axis + 2) % 3]);
            *row = [u * v, u, v, 1.0, added.x, added.y, added.z];
        }
        let factors = solve(rows)?;
        let sign = if self.is_reversed { -1.0 } else { 1.0 };
        let mut reals = vec![axis as f64];
        reals.extend(factors.as_flattened().iter().map(|x| x * sign));
        Some(reals)
    }
}

/// Area of a triangle along its normal, twice, if all corners are there.
fn area([a, b, c]: [Corner; 3]) -> Option<DVec3> {
    let (a, b, c) = (a?, b?, c?);
    Some((b - a).cross(c - a))
}

/// Solves four equations for three right sides, by elimination with row exchange; `None` if they depend on each other.
fn solve(mut rows: [[f64; 7]; 4]) -> Option<[[f64; 3]; 4]> {
    let largest = rows.iter().flat_map(|row| &row[..4]).fold(0.0, |a: f64, b| a.max(b.abs()));
    for k in 0..4 {
        let pivot = (k..4).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))?;
        rows.swap(k, pivot);
        if rows[k][k].abs() <= 1e-14 * largest {
            return None;
        }
        for other in (0..4).filter(|&other| other != k) {
            let factor = rows[other][k] / rows[k][k];
            for column in k..7 {
                rows[other][column] -= factor * rows[k][column];
            }
        }
    }
    Some(std::array::from_fn(|k| std::array::from_fn(|c| rows[k][4 + c] / rows[k][k])))
}
