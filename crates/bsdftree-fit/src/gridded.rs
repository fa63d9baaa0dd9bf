//! One scan as numbers over the disk: triangles between its points (Delaunay), linear within.
//!
//! In: directions of the upper hemisphere and values. Out: a [`Raster`], and for each point the projected solid angle it stands for, so
//! that Σ weight·value is the integral of the linear interpolant times the cosine. Between the outermost points and the horizon values go on
//! as they are at the nearest points.

use bsdftree::Part;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::lambert::{self, Ray};
use crate::prepare::Points;
use crate::raster::{EXTENT, Raster};
use crate::residual::{Blended, Residual};

/// Points beyond the horizon that carry values outward.
const N_GHOSTS: usize = 96;
const GHOST_RADIUS: f32 = 1.7;

/// One scan on the disk.
#[derive(Clone, Debug)]
pub(crate) struct Gridded {
    /// Where light came from, upper hemisphere.
    pub incident: Ray,
    /// What the scan is of.
    pub part: Part,
    /// Which measured scan it is of: copies by symmetry share it.
    pub group: usize,
    /// Measured directions, upper hemisphere.
    pub exitant: Vec<Ray>,
    /// Values \[1/sr\], one list per channel (after them, perhaps standard errors).
    pub values: Vec<Vec<f32>>,
    /// Projected solid angle of each point \[sr\].
    pub weights: Vec<f32>,
    /// Values over the disk, one per channel.
    pub rasters: Vec<Raster>,
    /// Directional-hemispherical total of each channel.
    pub totals: Vec<f64>,
    /// Whether a pixel lies between measured points: 1, or 0.
    pub covered: Raster,
    /// Standard errors over the disk, if there are any.
    pub noise: Option<Raster>,
    /// Estimate of the squared relative error of going linearly between points, up to [`MOST_BEND`]; [`UNKNOWN`] beside the measured points.
    pub doubt: Raster,
}

/// An edge of a triangle longer than this is a hole in what was measured \[disk\]: 25° around the normal.
const HOLE: f64 = 0.3;

/// Most of what [`Gridded::doubt`] says between points, and what it says elsewhere.
pub(crate) const MOST_BEND: f32 = 0.1;
pub(crate) const UNKNOWN: f32 = MOST_BEND + 0.0125;

struct Vertex {
    position: Point2<f64>,
    /// Number of the point, or for a ghost where its value is from.
    point: usize,
    ghost: bool,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// Three pixels' worth of a triangle: where its corners are and which points they are.
type Corner = (Point2<f64>, usize, bool);

impl Gridded {
    /// Lays values over `n` × `n` pixels. Points are distinct (see [`distinct`]) and there is at least one.
    pub fn new(points: Points, n: usize) -> Gridded {
        let Points { part, incident, group, exitant, values, noisy } = points;
        let triangles = triangles(&exitant);
        let n_channels = values.len();
        let mut rasters = vec![vec![0f32; n * n]; n_channels];
        let mut filled = vec![false; n * n];
        let mut covered = vec![0f32; n * n];
        let mut weights = vec![0f64; exitant.len()];
        let pixel = (2.0 * f64::from(EXTENT) / n as f64).powi(2) * lambert::SOLID_ANGLE;
        for corners in &triangles {
            let covers = f32::from(u8::from(is_between_points(corners)));
            over_pixels(corners, n, |k, shares| {
                if std::mem::replace(&mut filled[k], true) {
                    return;
                }
                covered[k] = covers;
                for (raster, values) in rasters.iter_mut().zip(&values) {
                    raster[k] = corners.iter().zip(shares).map(|(c, s)| values[c.1] * s as f32).sum();
                }
                let cosine = lambert::direction(Raster::center(n, k % n, k / n))[2];
                if cosine > 0.0 {
                    let part = pixel * f64::from(cosine);
                    corners.iter().zip(shares).for_each(|(c, s)| weights[c.1] += part * s);
                }
            });
        }
        let weights: Vec<f32> = weights.into_iter().map(|w| w as f32).collect();
        let total = |v: &Vec<f32>| v.iter().zip(&weights).map(|(&v, &w)| f64::from(v) * f64::from(w)).sum();
        let totals: Vec<f64> = values.iter().map(total).collect();
        let doubt = doubt(&triangles, &values[values.len() / 2], totals[values.len() / 2], n);
        let mut rasters: Vec<Raster> = rasters.into_iter().map(|values| Raster::new(n, values)).collect();
        let noise = if noisy { rasters.pop() } else { None };
        let covered = Raster::new(n, covered);
        Gridded { part, incident, group, exitant, values, weights, rasters, totals, covered, noise, doubt }
    }

    /// The channel that choices are made by: Y of X, Y, Z.
    pub fn main(&self) -> usize {
        self.rasters.len() / 2
    }

    /// Every fifth point predicted from the others, where those surround it: how far off triangles are.
    pub fn held_out(&self) -> Vec<Residual> {
        let channel = self.main();
        let (kept, left): (Vec<usize>, Vec<usize>) = (0..self.exitant.len()).partition(|k| k % 5 != 2);
        let values = kept.iter().map(|&k| self.values[channel][k]).collect();
        let exitant = kept.iter().map(|&k| self.exitant[k]).collect();
        let (part, incident, group) = (self.part, self.incident, self.group);
        let points = Points { part, incident, group, exitant, values: vec![values], noisy: false };
        let fewer = Gridded::new(points, self.rasters[0].n());
        let inside = left.into_iter().filter(|&k| fewer.covered.at(lambert::point(self.exitant[k])) > 0.99);
        inside
            .map(|k| Residual {
                predicted: Blended {
                    value: fewer.rasters[0].at(lambert::point(self.exitant[k])),
                    spread: 0.0,
                },
                measured: self.values[channel][k],
                weight: self.weights[k],
            })
            .collect()
    }
}

/// See [`Gridded::doubt`]. An exponential that changes by a factor e^Δ over a triangle is Δ²/8 above or below its chord.
fn doubt(triangles: &[[Corner; 3]], values: &[f32], total: f64, n: usize) -> Raster {
    /// Below this part of the mean values are as good as equal.
    const FLOOR: f64 = 0.02;
    let floor = (FLOOR * total / std::f64::consts::PI).max(1e-12) as f32;
    let mut doubt = vec![UNKNOWN; n * n];
    for corners in triangles.iter().filter(|corners| is_between_points(corners)) {
        let [a, b, c] = corners.map(|corner| values[corner.1] + floor);
        let change = (a.max(b).max(c) / a.min(b).min(c)).ln();
        let bend = (change * change / 8.0).powi(2).min(MOST_BEND);
        over_pixels(corners, n, |k, _| doubt[k] = bend);
    }
    Raster::new(n, doubt)
}

fn is_between_points(corners: &[Corner; 3]) -> bool {
    let edge = |a: &Corner, b: &Corner| (a.0.x - b.0.x).hypot(a.0.y - b.0.y);
    let [a, b, c] = corners;
    corners.iter().all(|corner| !corner.2) && [edge(a, b), edge(b, c), edge(c, a)].iter().all(|&l| l < HOLE)
}

fn triangles(exitant: &[Ray]) -> Vec<[Corner; 3]> {
    let points: Vec<[f32; 2]> = exitant.iter().map(|&o| lambert::point(o)).collect();
    let vertex = |[x, y]: [f32; 2], point, ghost| Vertex {
        position: Point2::new(f64::from(x), f64::from(y)),
        point,
        ghost,
    };
    let mut vertices: Vec<Vertex> = points.iter().enumerate().map(|(k, &p)| vertex(p, k, false)).collect();
    for k in 0..N_GHOSTS {
        let (s, c) = (std::f32::consts::TAU * k as f32 / N_GHOSTS as f32).sin_cos();
        let rim = [c, s];
        let distance = |p: &[f32; 2]| (p[0] - rim[0]).powi(2) + (p[1] - rim[1]).powi(2);
        let near = (0..points.len()).min_by(|&a, &b| distance(&points[a]).total_cmp(&distance(&points[b])));
        vertices.push(vertex([GHOST_RADIUS * c, GHOST_RADIUS * s], near.expect("there is a point"), true));
    }
    let mesh = DelaunayTriangulation::<Vertex>::bulk_load_stable(vertices).expect("positions are finite");
    let corner = |v: &Vertex| (v.position, v.point, v.ghost);
    mesh.inner_faces().map(|face| face.vertices().map(|v| corner(v.data()))).collect()
}

/// Calls `visit` with each pixel whose middle lies in the triangle and the shares of the corners in it.
fn over_pixels(corners: &[Corner; 3], n: usize, mut visit: impl FnMut(usize, [f64; 3])) {
    let [a, b, c] = corners.map(|(p, _, _)| p);
    let area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if area.abs() < 1e-18 {
        return;
    }
    let step = 2.0 * f64::from(EXTENT) / n as f64;
    let place = |x: f64| (x + f64::from(EXTENT)) / step - 0.5;
    let range = |values: [f64; 3]| {
        let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
        let first = place(low).ceil().max(0.0) as usize;
        let last = place(high).floor().min(n as f64 - 1.0);
        first..(if last < 0.0 { 0 } else { last as usize + 1 })
    };
    for row in range([a.y, b.y, c.y]) {
        let y = (row as f64 + 0.5) * step - f64::from(EXTENT);
        for column in range([a.x, b.x, c.x]) {
            let x = (column as f64 + 0.5) * step - f64::from(EXTENT);
            let wb = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
            let wc = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
            let wa = 1.0 - wb - wc;
            if wa >= -1e-9 && wb >= -1e-9 && wc >= -1e-9 {
                visit(row * n + column, [wa, wb, wc]);
            }
        }
    }
}

/// Points that are all different: those closer than `near` (chord) become their mean.
pub(crate) fn distinct(exitant: &[Ray], values: &[Vec<f32>], near: f32) -> (Vec<Ray>, Vec<Vec<f32>>) {
    let mut order: Vec<usize> = (0..exitant.len()).collect();
    order.sort_by(|&a, &b| exitant[a][0].total_cmp(&exitant[b][0]));
    let mut taken = vec![false; exitant.len()];
    let (mut kept, mut means) = (Vec::new(), vec![Vec::new(); values.len()]);
    for (rank, &k) in order.iter().enumerate() {
        if taken[k] {
            continue;
        }
        let mut same = vec![k];
        for &l in &order[rank + 1..] {
            if exitant[l][0] - exitant[k][0] > near {
                break;
            }
            let d2: f32 = (0..3).map(|d| (exitant[l][d] - exitant[k][d]).powi(2)).sum();
            if !taken[l] && d2 <= near * near {
                taken[l] = true;
                same.push(l);
            }
        }
        kept.push(exitant[k]);
        for (mean, values) in means.iter_mut().zip(values) {
            mean.push(same.iter().map(|&l| values[l]).sum::<f32>() / same.len() as f32);
        }
    }
    (kept, means)
}
