//! One scan as numbers over the disk: triangles between its points (Delaunay), linear within.
//!
//! In: directions of the upper hemisphere and values. Out: a [`Raster`], and for each point the projected solid angle it stands for, so
//! that Σ weight·value is the integral of the linear interpolant times the cosine. Between the outermost points and the horizon values go on
//! as they are at the nearest points.

use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::lambert::{self, Ray};
use crate::raster::{EXTENT, Raster};

/// Points beyond the horizon that carry values outward.
const N_GHOSTS: usize = 96;
const GHOST_RADIUS: f32 = 1.7;

/// One scan on the disk.
#[derive(Clone, Debug)]
pub(crate) struct Gridded {
    /// Where light came from, upper hemisphere.
    pub incident: Ray,
    /// Which measured scan it is of: copies by symmetry share it.
    pub group: usize,
    /// Measured directions, upper hemisphere.
    pub exitant: Vec<Ray>,
    /// Values \[1/sr\], one list per channel.
    pub values: Vec<Vec<f32>>,
    /// Projected solid angle of each point \[sr\].
    pub weights: Vec<f32>,
    /// Values over the disk, one per channel.
    pub rasters: Vec<Raster>,
    /// Directional-hemispherical total of each channel.
    pub totals: Vec<f64>,
}

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
    pub fn new(incident: Ray, group: usize, exitant: Vec<Ray>, values: Vec<Vec<f32>>, n: usize) -> Gridded {
        let triangles = triangles(&exitant);
        let n_channels = values.len();
        let mut rasters = vec![vec![0f32; n * n]; n_channels];
        let mut filled = vec![false; n * n];
        let mut weights = vec![0f64; exitant.len()];
        let pixel = (2.0 * f64::from(EXTENT) / n as f64).powi(2) * lambert::SOLID_ANGLE;
        for corners in &triangles {
            over_pixels(corners, n, |k, shares| {
                if std::mem::replace(&mut filled[k], true) {
                    return;
                }
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
        let totals = values.iter().map(total).collect();
        let rasters = rasters.into_iter().map(|values| Raster::new(n, values)).collect();
        Gridded { incident, group, exitant, values, weights, rasters, totals }
    }

    /// The scan seen by who turns the sample by `angle` about its normal.
    pub fn peak(&self) -> f32 {
        self.values[self.values.len() / 2].iter().fold(0.0, |a, &b| a.max(b))
    }
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
