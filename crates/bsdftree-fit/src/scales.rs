//! What brings slices to the totals that scans foresee, by incident direction.
//!
//! Blending logarithms loses light between scans that differ, and none at a scan. So what is tabulated over the disk of incident directions is not the
//! factor s but (s − 1)/a, where a = 1 − Σw² says how far from a scan its weights are: 0 at scans, whatever the table's resolution.
//! Outside the measured directions lobes move below the horizon, and the factor itself is tabulated.

use crate::lambert::{self, Ray};

/// Nodes of an edge.
pub(crate) const N: usize = 33;

/// Nothing is divided by less than this.
const LEAST_APART: f32 = 0.02;

/// A factor where it was computed: (s, a), and whether that is inside the measured directions.
pub(crate) type Sample = (f32, f32, bool);

/// Factors of one channel.
#[derive(Clone, Debug)]
pub(crate) struct Scales {
    line: bool,
    samples: Vec<Sample>,
}

impl Scales {
    /// Incident directions of the table's nodes: along x < 0 of isotropic samples, else all over the disk.
    pub fn nodes(line: bool) -> Vec<Ray> {
        let at = |j: usize| 2.0 * j as f32 / (N - 1) as f32 - 1.0;
        let node = |k: usize| {
            let point = if line { [-(k as f32) / (N - 1) as f32, 0.0] } else { [at(k % N), at(k / N)] };
            let r = point[0].hypot(point[1]);
            // Corners have the value of the rim.
            lambert::direction(if r > 1.0 { point.map(|x| x / r) } else { point })
        };
        (0..if line { N } else { N * N }).map(node).collect()
    }

    /// From the factors at the nodes.
    pub fn new(line: bool, samples: Vec<Sample>) -> Scales {
        Scales { line, samples }
    }

    /// The factor for an incident direction, `apart` from scans, inside the measured ones or not.
    pub fn at(&self, incident: Ray, apart: f32, inside: bool) -> f32 {
        let last = (N - 1) as f32;
        let [u, v] = lambert::point(incident);
        let [x, y] = match self.line {
            true => [u.hypot(v) * last, 0.0],
            false => [u, v].map(|w| (w + 1.0) * 0.5 * last),
        };
        let [x, y] = [x, y].map(|w| w.clamp(0.0, last - 1e-3));
        let (i, j) = (x as usize, y as usize);
        let (s, t) = (x - i as f32, y - j as f32);
        let rows = if self.line { 1 } else { 2 };
        let (mut sum, mut weights, mut plain) = (0.0, 0.0, 0.0);
        for (row, wy) in [1.0 - t, t].into_iter().enumerate().take(rows) {
            for (column, wx) in [1.0 - s, s].into_iter().enumerate() {
                let (factor, a, is_inside) = self.samples[(j + row) * N + i + column];
                let weight = wx * if rows == 1 { 1.0 } else { wy };
                plain += weight * factor;
                if inside && is_inside {
                    sum += weight * (factor - 1.0) / a.max(LEAST_APART);
                    weights += weight;
                }
            }
        }
        if weights > 0.0 { (1.0 + apart * sum / weights).max(0.0) } else { plain }
    }
}
