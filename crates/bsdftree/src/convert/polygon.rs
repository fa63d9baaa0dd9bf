//! Convex polygons of the square.
//!
//! Under the map of [`crate::square`] a circle about the centre of the disk is a square about the centre of the square, and a radius
//! is a straight line on which azimuth is minor/major coordinate. So every patch of an angle basis is a union of a few convex
//! polygons of the square (one in each quarter between the diagonals that it touches), and what it shares with a
//! cell of a tree is cut out exactly. A turn about the normal shears each quarter, so that turned cells are polygons too.
//!
//! Coordinates here have the centre as origin and reach to ±1: twice those of the square, less one.

use std::f64::consts::FRAC_PI_4;

/// Enough for a cell (4 corners) cut by two diagonals, the border of a quarter and another cell.
const MOST: usize = 16;

/// A convex polygon, counter-clockwise; empty if it has no corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    n: usize,
    corners: [[f64; 2]; MOST],
}

impl Polygon {
    pub fn new(points: &[[f64; 2]]) -> Polygon {
        let mut corners = [[0.0; 2]; MOST];
        corners[..points.len()].copy_from_slice(points);
        Polygon { n: points.len(), corners }
    }

    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.n]
    }

    /// What of it lies where a·x + b·y ≥ c.
    pub fn clipped(&self, [a, b, c]: [f64; 3]) -> Polygon {
        let mut out = Polygon { n: 0, corners: [[0.0; 2]; MOST] };
        let height = |p: [f64; 2]| a * p[0] + b * p[1] - c;
        for (k, &p) in self.corners().iter().enumerate() {
            let q = self.corners[(k + 1) % self.n];
            let (hp, hq) = (height(p), height(q));
            if hp >= 0.0 {
                out.push(p);
            }
            if (hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0) {
                let t = hp / (hp - hq);
                out.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
            }
        }
        out
    }

    fn push(&mut self, point: [f64; 2]) {
        self.corners[self.n] = point;
        self.n += 1;
    }

    pub fn area(&self) -> f64 {
        let corners = self.corners();
        let Some(&first) = corners.first() else { return 0.0 };
        // About a corner, so that small areas far from the origin keep their digits.
        let from = |p: [f64; 2]| [p[0] - first[0], p[1] - first[1]];
        let triangle = |pair: &[[f64; 2]]| {
            let ([ax, ay], [bx, by]) = (from(pair[0]), from(pair[1]));
            0.5 * (ax * by - ay * bx)
        };
        corners.windows(2).map(triangle).sum::<f64>().max(0.0)
    }

    pub fn mapped(&self, f: impl Fn([f64; 2]) -> [f64; 2]) -> Polygon {
        let mut out = *self;
        out.corners[..self.n].iter_mut().for_each(|p| *p = f(*p));
        out
    }

    /// Smallest and largest coordinate along an axis.
    fn extent(&self, axis: usize) -> [f64; 2] {
        self.corners()
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], p| [lo.min(p[axis]), hi.max(p[axis])])
    }

    /// Tells `f` of each cell of edge 2^-level that it touches, and of the area they share as a fraction of the cell.
    pub fn each_cell(&self, level: u32, mut f: impl FnMut([u32; 2], f64)) {
        let n = (1u64 << level) as f64;
        // In units of a cell, borders are whole numbers.
        let scaled = self.mapped(|p| p.map(|c| 0.5 * (c + 1.0) * n));
        let cells = |polygon: &Polygon, axis: usize| {
            let [lo, hi] = polygon.extent(axis);
            lo.floor().max(0.0) as u32..hi.ceil().clamp(0.0, n) as u32
        };
        for x in cells(&scaled, 0) {
            let (lo, hi) = (f64::from(x), f64::from(x) + 1.0);
            let column = scaled.clipped([1.0, 0.0, lo]).clipped([-1.0, 0.0, -hi]);
            for y in cells(&column, 1) {
                let (lo, hi) = (f64::from(y), f64::from(y) + 1.0);
                let area = column.clipped([0.0, 1.0, lo]).clipped([0.0, -1.0, -hi]).area();
                // Less is rounding at a border that both share.
                if area > 1e-11 {
                    f([x, y], area);
                }
            }
        }
    }
}

/// A point of the quarter around +x, put into the k-th quarter counter-clockwise.
fn into_quarter(k: usize, [x, y]: [f64; 2]) -> [f64; 2] {
    [[x, y], [-y, x], [-x, -y], [y, -x]][k % 4]
}

/// The part of the square over a part of the disk, between two radii and two azimuths \[rad\] at most 2π apart.
pub(super) fn sector([inner, outer]: [f64; 2], [from, to]: [f64; 2]) -> Vec<Polygon> {
    let mut polygons = Vec::new();
    // Azimuth in units of half a quarter: the k-th quarter reaches from 2k − 1 to 2k + 1.
    let [from, to] = [from, to].map(|phi| phi / FRAC_PI_4);
    let first = ((from + 1.0) / 2.0).floor() as i64;
    let last = ((to + 1.0) / 2.0).ceil() as i64;
    for k in first..last {
        let middle = 2.0 * k as f64;
        let (t0, t1) = ((from - middle).max(-1.0), (to - middle).min(1.0));
        if t1 <= t0 {
            continue;
        }
        let corners = [[inner, inner * t0], [outer, outer * t0], [outer, outer * t1], [inner, inner * t1]];
        polygons.push(Polygon::new(&corners).mapped(|p| into_quarter(k.rem_euclid(4) as usize, p)));
    }
    polygons
}

/// A cell of edge 2^-level, turned counter-clockwise about the centre of the disk by an azimuth \[rad\].
pub(super) fn turned_cell(level: u32, cell: [u32; 2], azimuth: f64) -> Vec<Polygon> {
    let n = (1u64 << level) as f64;
    let [x, y] = cell.map(|c| 2.0 * f64::from(c) / n - 1.0);
    let e = 2.0 / n;
    let cell = Polygon::new(&[[x, y], [x + e, y], [x + e, y + e], [x, y + e]]);
    // Whole quarters, and what is left: a shear by s in [0, 2) halves of a quarter.
    let turn = (azimuth / FRAC_PI_4).rem_euclid(8.0);
    let (quarters, s) = ((turn / 2.0).floor() as usize, turn.rem_euclid(2.0));
    let mut polygons = Vec::new();
    for k in 0..4 {
        let local = cell.mapped(|p| into_quarter(4 - k, p));
        let quarter = local.clipped([1.0, 1.0, 0.0]).clipped([1.0, -1.0, 0.0]);
        let stays = quarter.clipped([1.0 - s, -1.0, 0.0]).mapped(|[a, b]| [a, b + s * a]);
        let leaves = quarter.clipped([s - 1.0, 1.0, 0.0]).mapped(|[a, b]| [a, b + (s - 2.0) * a]);
        for (polygon, quarter) in [(stays, k + quarters), (leaves, k + quarters + 1)] {
            if polygon.n > 2 && polygon.area() > 0.0 {
                polygons.push(polygon.mapped(|p| into_quarter(quarter, p)));
            }
        }
    }
    polygons
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::square::{disk_from_square, square_from_disk};
    use std::f64::consts::{PI, TAU};

    fn inside(polygons: &[Polygon], [x, y]: [f64; 2]) -> bool {
        let p = [2.0 * x - 1.0, 2.0 * y - 1.0];
        polygons.iter().any(|polygon| {
            let c = polygon.corners();
            (0..c.len()).all(|k| {
                let ([ax, ay], [bx, by]) = (c[k], c[(k + 1) % c.len()]);
                (bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax) >= -1e-12
            })
        })
    }

    fn points() -> impl Iterator<Item = [f64; 2]> {
        (1..4000).map(|k| [f64::from(k) * 0.754_877_666_25 % 1.0, f64::from(k) * 0.569_840_290_99 % 1.0])
    }

    #[test]
    fn sectors_of_the_disk_are_polygons_of_the_square() {
        for (radii, azimuths) in
            [([0.2, 0.5], [-0.3, 1.9]), ([0.0, 0.4], [0.0, TAU]), ([0.7, 1.0], [5.9, 6.4])]
        {
            let polygons = sector(radii, azimuths);
            let area: f64 = polygons.iter().map(Polygon::area).sum();
            let expected =
                (radii[1] * radii[1] - radii[0] * radii[0]) * (azimuths[1] - azimuths[0]) / TAU * 4.0;
            assert!((area - expected).abs() < 1e-14, "{area} {expected}");
            for p in points() {
                let [x, y] = disk_from_square(p);
                let (r, phi) = (x.hypot(y), (y.atan2(x) - azimuths[0]).rem_euclid(TAU));
                let within = (radii[0]..radii[1]).contains(&r) && phi < azimuths[1] - azimuths[0];
                assert_eq!(inside(&polygons, p), within, "{p:?}");
            }
        }
    }

    #[test]
    fn turned_cells_hold_the_turned_points() {
        for azimuth in [0.0, 0.3, PI / 4.0, 1.0, PI / 2.0, 2.9, -1.2, 6.0] {
            let (sin, cos) = f64::sin_cos(azimuth);
            for cell in [[0, 0], [3, 4], [4, 4], [5, 1], [6, 6]] {
                let polygons = turned_cell(3, cell, azimuth);
                let area: f64 = polygons.iter().map(Polygon::area).sum();
                assert!((area - 1.0 / 16.0).abs() < 1e-14);
                for p in points() {
                    let [x, y] = disk_from_square(p);
                    let turned = square_from_disk([cos * x - sin * y, sin * x + cos * y]);
                    let within = p.map(|c| (c * 8.0) as u32) == cell;
                    assert_eq!(inside(&polygons, turned), within, "{azimuth} {cell:?} {p:?}");
                }
            }
        }
    }

    #[test]
    fn cells_share_out_the_whole_polygon() {
        for polygon in sector([0.31, 0.77], [0.4, 3.3]) {
            let mut sum = 0.0;
            polygon.each_cell(5, |_, share| sum += share / 256.0);
            assert!((sum - polygon.area()).abs() < 1e-12);
        }
    }
}
