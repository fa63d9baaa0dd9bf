//! How much each measured incident direction counts at another: cardinal weights, which sum to 1 and are 1 at their own direction.
//!
//! * On the disk of the hemisphere ([`Plane`]): the thin-plate spline through all measured directions (Duchon 1977), of which the
//!   largest weights are kept, or the linear interpolant over triangles.
//! * In θ alone ([`Line`]), for isotropic samples: the natural cubic spline through ±θ, or the linear interpolant.
//!
//! Outside the measured directions the weights are those of the nearest place inside.

use crate::lambert::{self, Ray};

/// Weights kept of a spline: more change nothing that noise does not.
const N_KEPT: usize = 14;

/// How weights go from one measured direction to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// Along splines: smooth, with some weights below 0.
    Spline,
    /// Linearly between nearest directions.
    Linear,
}

/// Numbers of scans with their weights.
pub(crate) type Weights = Vec<(usize, f64)>;

/// How far from a scan a direction with these weights is: 1 − Σw², 0 at a scan.
pub(crate) fn apart(weights: &Weights) -> f32 {
    (1.0 - weights.iter().map(|(_, w)| w * w).sum::<f64>()).clamp(0.0, 1.0) as f32
}

/// Measured incident directions, ready to be asked.
#[derive(Clone, Debug)]
pub(crate) enum Incidence {
    Line(Line),
    Plane(Plane),
}

impl Incidence {
    /// Weights at an incident direction (upper hemisphere), and how far outside the measured ones it is, as a distance on the disk.
    pub fn weights(&self, incident: Ray) -> (Weights, f64) {
        match self {
            Incidence::Line(line) => line.weights(lambert_radius(incident)),
            Incidence::Plane(plane) => plane.weights(lambert::point(incident).map(f64::from)),
        }
    }
}

pub(crate) fn lambert_radius(incident: Ray) -> f64 {
    f64::from(1.0 - incident[2]).max(0.0).sqrt()
}

/// Directions by their radius on the disk; radii mirrored to below 0, so that splines are even.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    nodes: Vec<f64>,
    scans: Vec<usize>,
    /// Second derivatives at all nodes of the cardinal function of each node, row by row.
    curvatures: Vec<f64>,
    blend: Blend,
}

impl Line {
    /// From radii and the scans they are of.
    pub fn new(radii: &[f64], scans: &[usize], blend: Blend) -> Line {
        let mut nodes: Vec<(f64, usize)> = radii.iter().copied().zip(scans.iter().copied()).collect();
        nodes.extend(radii.iter().zip(scans).filter(|(r, _)| **r > 1e-4).map(|(&r, &s)| (-r, s)));
        nodes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (nodes, scans): (Vec<f64>, Vec<usize>) = nodes.into_iter().unzip();
        let curvatures = cardinal_curvatures(&nodes);
        Line { nodes, scans, curvatures, blend }
    }

    fn weights(&self, radius: f64) -> (Weights, f64) {
        let n = self.nodes.len();
        let last = self.nodes[n - 1];
        let outside = (radius - last).max(0.0);
        let x = radius.min(last);
        if n == 1 {
            return (vec![(self.scans[0], 1.0)], outside);
        }
        let upper = self.nodes.partition_point(|&node| node < x).clamp(1, n - 1);
        let h = self.nodes[upper] - self.nodes[upper - 1];
        let b = (x - self.nodes[upper - 1]) / h;
        let a = 1.0 - b;
        let mut by_node = vec![0.0; n];
        by_node[upper - 1] = a;
        by_node[upper] += b;
        if self.blend == Blend::Spline {
            let [ca, cb] = [a * (a * a - 1.0), b * (b * b - 1.0)].map(|c| c * h * h / 6.0);
            for (k, weight) in by_node.iter_mut().enumerate() {
                *weight += ca * self.curvatures[k * n + upper - 1] + cb * self.curvatures[k * n + upper];
            }
        }
        let mut weights: Weights = Vec::new();
        for (k, &w) in by_node.iter().enumerate() {
            match weights.iter_mut().find(|(scan, _)| *scan == self.scans[k]) {
                Some((_, sum)) => *sum += w,
                None => weights.push((self.scans[k], w)),
            }
        }
        (largest(weights), outside)
    }
}

/// Second derivatives of the natural cubic spline that is 1 at node k and 0 at the others, for each k.
fn cardinal_curvatures(nodes: &[f64]) -> Vec<f64> {
    let n = nodes.len();
    let mut all = Vec::with_capacity(n * n);
    for k in 0..n {
        let y = |j: usize| f64::from(u8::from(j == k));
        let (mut second, mut u) = (vec![0.0; n], vec![0.0; n]);
        for j in 1..n.max(1) - 1 {
            let (h0, h1) = (nodes[j] - nodes[j - 1], nodes[j + 1] - nodes[j]);
            let sigma = h0 / (h0 + h1);
            let p = sigma * second[j - 1] + 2.0;
            let slopes = (y(j + 1) - y(j)) / h1 - (y(j) - y(j - 1)) / h0;
            u[j] = (6.0 * slopes / (h0 + h1) - sigma * u[j - 1]) / p;
            second[j] = (sigma - 1.0) / p;
        }
        for j in (0..n.saturating_sub(1)).rev() {
            second[j] = second[j] * second[j + 1] + u[j];
        }
        all.extend(second);
    }
    all
}

/// Directions by their points of the disk.
#[derive(Clone, Debug)]
pub(crate) struct Plane {
    nodes: Vec<[f64; 2]>,
    scans: Vec<usize>,
    hull: Vec<[f64; 2]>,
    /// Inverse of the system of the thin-plate spline; only of splines, if directions do not lie on one line.
    inverse: Option<Vec<f64>>,
    /// Only of linear blends, if directions do not lie on one line.
    triangles: Vec<[usize; 3]>,
}

impl Plane {
    /// From points of the disk and the scans they are of.
    pub fn new(nodes: &[[f64; 2]], scans: &[usize], blend: Blend) -> Plane {
        let (inverse, triangles) = match blend {
            _ if !is_spread(nodes) => (None, Vec::new()),
            Blend::Spline => (thin_plate(nodes), Vec::new()),
            Blend::Linear => (None, triangles(nodes)),
        };
        Plane { nodes: nodes.to_vec(), scans: scans.to_vec(), hull: hull(nodes), inverse, triangles }
    }

    pub fn weights(&self, point: [f64; 2]) -> (Weights, f64) {
        let (inside, outside) = nearest_in_hull(&self.hull, point);
        let weights = match &self.inverse {
            None => self.in_triangle(inside).unwrap_or_else(|| self.by_distance(inside)),
            Some(inverse) => {
                let n = self.nodes.len();
                let m = n + 3;
                let mut row: Vec<f64> = self.nodes.iter().map(|&node| kernel(node, inside)).collect();
                row.extend([1.0, inside[0], inside[1]]);
                // The inverse of a symmetric matrix is one too: rows added up are many sums side by side.
                let mut sums = vec![0.0; n];
                for (inverse, x) in inverse.chunks_exact(m).zip(row) {
                    sums.iter_mut().zip(inverse).for_each(|(sum, y)| *sum += x * y);
                }
                self.scans.iter().copied().zip(sums).collect()
            }
        };
        (largest(weights), outside)
    }

    /// For values at the directions, in the order in which these were given: how far each is from what the others foresee (leaving one out
    /// of a spline takes no new spline: S. Rippa, Adv. Comput. Math. 11, 1999). `None` if directions lie on one line.
    pub fn surprises(&self, values: &[f64]) -> Option<Vec<f64>> {
        let inverse = self.inverse.as_ref()?;
        let m = self.nodes.len() + 3;
        let surprise = |k: usize| {
            let row = &inverse[k * m..(k + 1) * m];
            values.iter().zip(row).map(|(v, a)| v * a).sum::<f64>() / row[k]
        };
        Some((0..values.len()).map(surprise).collect())
    }

    /// Two nearest directions: all there is where directions lie on one line.
    fn by_distance(&self, point: [f64; 2]) -> Weights {
        let mut near: Vec<(f64, usize)> =
            self.nodes.iter().zip(&self.scans).map(|(&node, &scan)| (squared(node, point), scan)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.truncate(2);
        let sum: f64 = near.iter().map(|(d, _)| 1.0 / (d.sqrt() + 1e-9)).sum();
        near.iter().map(|&(d, scan)| (scan, 1.0 / (d.sqrt() + 1e-9) / sum)).collect()
    }

    fn in_triangle(&self, p: [f64; 2]) -> Option<Weights> {
        let shares = |&[a, b, c]: &[usize; 3]| {
            let [a, b, c] = [a, b, c].map(|k| self.nodes[k]);
            let area = cross(a, b, c);
            [cross(p, b, c) / area, cross(a, p, c) / area, cross(a, b, p) / area]
        };
        let least = |s: &[f64; 3]| s.iter().copied().fold(f64::MAX, f64::min);
        let all = self.triangles.iter().map(|t| (t, shares(t)));
        let (t, s) = all.max_by(|a, b| least(&a.1).total_cmp(&least(&b.1)))?;
        Some(t.iter().zip(s).map(|(&k, w)| (self.scans[k], w.max(0.0))).collect())
    }
}

/// The largest weights, scaled to the sum 1.
fn largest(mut weights: Weights) -> Weights {
    weights.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()).then(a.0.cmp(&b.0)));
    weights.truncate(N_KEPT);
    weights.retain(|(_, w)| w.abs() > 1e-4);
    let sum: f64 = weights.iter().map(|(_, w)| w).sum();
    weights.iter_mut().for_each(|(_, w)| *w /= sum);
    weights
}

fn squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

fn kernel(a: [f64; 2], b: [f64; 2]) -> f64 {
    let r2 = squared(a, b);
    if r2 > 0.0 { r2 * r2.ln() } else { 0.0 }
}

fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether there are more than three, and they do not lie on one line.
fn is_spread(nodes: &[[f64; 2]]) -> bool {
    let mut areas = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| cross(nodes[0], a, b).abs()));
    nodes.len() >= 4 && areas.any(|area| area >= 1e-3)
}

/// Inverse of the system of the thin-plate spline, if it has one.
fn thin_plate(nodes: &[[f64; 2]]) -> Option<Vec<f64>> {
    let n = nodes.len();
    let m = n + 3;
    let mut matrix = vec![0.0; m * m];
    for (i, &a) in nodes.iter().enumerate() {
        for (j, &b) in nodes.iter().enumerate() {
            matrix[i * m + j] = kernel(a, b);
        }
        for (d, p) in [1.0, a[0], a[1]].into_iter().enumerate() {
            matrix[i * m + n + d] = p;
            matrix[(n + d) * m + i] = p;
        }
    }
    inverted(matrix, m)
}

/// Gauss and Jordan with partial pivots; `None` if the matrix has no inverse.
fn inverted(mut a: Vec<f64>, m: usize) -> Option<Vec<f64>> {
    let mut inverse: Vec<f64> = (0..m * m).map(|k| f64::from(u8::from(k / m == k % m))).collect();
    for column in 0..m {
        let pivot =
            (column..m).max_by(|&i, &j| a[i * m + column].abs().total_cmp(&a[j * m + column].abs()))?;
        if a[pivot * m + column].abs() < 1e-12 {
            return None;
        }
        if pivot != column {
            for j in 0..m {
                a.swap(pivot * m + j, column * m + j);
                inverse.swap(pivot * m + j, column * m + j);
            }
        }
        let scale = 1.0 / a[column * m + column];
        for matrix in [&mut a, &mut inverse] {
            matrix[column * m..(column + 1) * m].iter_mut().for_each(|x| *x *= scale);
        }
        // Columns before this one are those of the unit matrix already.
        let row = a[column * m + column..(column + 1) * m].to_vec();
        let inverse_row = inverse[column * m..(column + 1) * m].to_vec();
        for i in (0..m).filter(|&i| i != column) {
            let factor = a[i * m + column];
            let subtract = |to: &mut [f64], row: &[f64]| {
                to.iter_mut().zip(row).for_each(|(to, x)| *to -= factor * x);
            };
            if factor != 0.0 {
                subtract(&mut a[i * m + column..(i + 1) * m], &row);
                subtract(&mut inverse[i * m..(i + 1) * m], &inverse_row);
            }
        }
    }
    Some(inverse)
}

fn triangles(nodes: &[[f64; 2]]) -> Vec<[usize; 3]> {
    use spade::{DelaunayTriangulation, Point2, Triangulation};
    let points = nodes.iter().map(|p| Point2::new(p[0], p[1])).collect();
    let mesh = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(points).expect("positions are finite");
    mesh.inner_faces().map(|face| face.vertices().map(|v| v.fix().index())).collect()
}

/// Convex hull, counter-clockwise (Andrew 1979).
fn hull(nodes: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = nodes.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut hull: Vec<[f64; 2]> = Vec::new();
    for pass in 0..2 {
        let start = hull.len();
        let chain: Box<dyn Iterator<Item = &[f64; 2]>> =
            if pass == 0 { Box::new(sorted.iter()) } else { Box::new(sorted.iter().rev()) };
        for &p in chain {
            while hull.len() >= start + 2 && cross(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 1e-12 {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    }
    if hull.is_empty() {
        sorted.truncate(1);
        sorted
    } else {
        hull
    }
}

fn nearest_in_hull(hull: &[[f64; 2]], p: [f64; 2]) -> ([f64; 2], f64) {
    let n = hull.len();
    if n >= 3 && (0..n).all(|k| cross(hull[k], hull[(k + 1) % n], p) >= -1e-12) {
        return (p, 0.0);
    }
    let on_edge = |k: usize| {
        let (a, b) = (hull[k], hull[(k + 1) % n]);
        let length2 = squared(a, b);
        let along = (p[0] - a[0]) * (b[0] - a[0]) + (p[1] - a[1]) * (b[1] - a[1]);
        let t = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
        [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
    };
    let nearest = (0..n).map(on_edge).min_by(|a, b| squared(*a, p).total_cmp(&squared(*b, p)));
    let nearest = nearest.expect("there is a direction");
    (nearest, squared(nearest, p).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_reproduce_planes_and_their_nodes() {
        let nodes = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [-0.5, 0.1], [0.1, -0.6], [0.4, 0.4]];
        let scans: Vec<usize> = (0..6).collect();
        for blend in [Blend::Spline, Blend::Linear] {
            let plane = Plane::new(&nodes, &scans, blend);
            let at = |p: [f64; 2]| {
                plane
                    .weights(p)
                    .0
                    .iter()
                    .map(|&(k, w)| w * (1.0 + nodes[k][0] - 2.0 * nodes[k][1]))
                    .sum::<f64>()
            };
            assert!((at([0.1, 0.1]) - 0.9).abs() < 1e-3, "{blend:?}");
            assert!((plane.weights([0.5, 0.0]).0[0].1 - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn surprises_are_what_splines_without_a_direction_miss() {
        let nodes = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [-0.5, 0.1], [0.1, -0.6], [0.4, 0.4]];
        let values = [0.3, -1.0, 0.2, 0.9, 0.0, 2.0];
        let found = Plane::new(&nodes, &[0, 1, 2, 3, 4, 5], Blend::Spline).surprises(&values).unwrap();
        let others = Plane::new(&nodes[1..], &[1, 2, 3, 4, 5], Blend::Spline);
        let foreseen: f64 = others.weights(nodes[0]).0.iter().map(|&(k, w)| w * values[k]).sum();
        assert!((found[0] - (values[0] - foreseen)).abs() < 1e-9, "{found:?} {foreseen}");
    }

    #[test]
    fn splines_in_theta_are_even_and_exact_at_nodes() {
        let line = Line::new(&[0.0, 0.2, 0.5, 0.8], &[0, 1, 2, 3], Blend::Spline);
        let (weights, outside) = line.weights(0.5);
        assert_eq!(weights, vec![(2, 1.0)]);
        assert_eq!(outside, 0.0);
        let at = |r: f64| line.weights(r).0.iter().map(|&(k, w)| w * [0.0, 0.04, 0.25, 0.64][k]).sum::<f64>();
        assert!((at(0.35) - 0.1225).abs() < 0.01, "{}", at(0.35));
        assert!((line.weights(0.9).1 - 0.1).abs() < 1e-12);
    }
}
