//! A triangle as the f64 test sees it: a plane and three edge planes, all as signed distances.
//!
//! Enters: three corners in the local frame. Leaves: where a ray meets the triangle, to the rounding of f64.
//! Invariant: distances to edges are positive inside; neighbours overlap by `slack`, more than both round, so no ray
//! passes between them. Source: Möller & Haines, *Real-Time Rendering*, 22.8 (edge planes). Deviation: distances
//! instead of barycentric coordinates, so that the slack is a length, the same for a needle and for a wall.

use glam::DVec3;

/// Widest slack of an edge, local units: it must stay well inside the padding of boxes and the slack of the filter.
pub(super) const WIDEST_SLACK: f64 = 1.0 / (1 << 24) as f64;

/// Rows: triangle plane, three edge planes; one array per coordinate so that a test is six 4-wide operations.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Facet {
    pub x: [f64; 4],
    pub y: [f64; 4],
    pub z: [f64; 4],
    pub w: [f64; 4],
}

impl Facet {
    /// `None` if the corners are in line to f64 precision. `plane` is the unit normal of the front and a point of the
    /// polygon's plane; without it the triangle's own, counter-clockwise, is taken.
    pub fn new(corners: [DVec3; 3], plane: Option<(DVec3, DVec3)>) -> Option<Facet> {
        let [a, mut b, mut c] = corners;
        let cross = (b - a).cross(c - a);
        let longest = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
        if cross.length() <= f64::EPSILON * longest {
            return None;
        }
        let (normal, point) = plane.unwrap_or((cross.normalize(), (a + b + c) / 3.0));
        if cross.dot(normal) < 0.0 {
            std::mem::swap(&mut b, &mut c);
        }
        let edge = |from: DVec3, to: DVec3| {
            let inward = normal.cross(to - from).normalize();
            (inward, -inward.dot(from * 0.5 + to * 0.5))
        };
        let rows = [(normal, -normal.dot(point)), edge(a, b), edge(b, c), edge(c, a)];
        Some(Facet {
            x: rows.map(|r| r.0.x),
            y: rows.map(|r| r.0.y),
            z: rows.map(|r| r.0.z),
            w: rows.map(|r| r.1),
        })
    }

    /// Unit normal of the front.
    pub fn normal(&self) -> DVec3 {
        DVec3::new(self.x[0], self.y[0], self.z[0])
    }

    /// Distance along the ray, if it is met at `0 ≤ t ≤ t_max`. An origin within `on_plane` of the plane has left it.
    #[inline(always)]
    pub fn hit(&self, origin: DVec3, direction: DVec3, t_max: f64, on_plane: f64, slack: f64) -> Option<f64> {
        let mut height = [0.0; 4];
        let mut slope = [0.0; 4];
        for i in 0..4 {
            height[i] = (self.x[i] * origin.x + self.y[i] * origin.y) + (self.z[i] * origin.z + self.w[i]);
            slope[i] = self.x[i] * direction.x + self.y[i] * direction.y + self.z[i] * direction.z;
        }
        let inv = 1.0 / slope[0];
        let t = -height[0] * inv;
        let slack = -(slack * inv.abs()).min(WIDEST_SLACK);
        let inside = (height[1] + t * slope[1] >= slack)
            & (height[2] + t * slope[2] >= slack)
            & (height[3] + t * slope[3] >= slack);
        (inside & (t >= 0.0) & (t <= t_max) & (height[0].abs() >= on_plane)).then_some(t)
    }

    /// Whether the distances of `p` from all edges are at least `inset`.
    #[inline(always)]
    pub fn is_inside(&self, p: DVec3, inset: f64) -> bool {
        let mut distance = [0.0; 4];
        for i in 0..4 {
            distance[i] = (self.x[i] * p.x + self.y[i] * p.y) + (self.z[i] * p.z + self.w[i]);
        }
        (distance[1] >= inset) & (distance[2] >= inset) & (distance[3] >= inset)
    }

    /// The point on the way from `p`, on or near an edge, to the centre of the inscribed circle that is `inset` from the
    /// edge: a ray that leaves from there is on the right side of the neighbours.
    #[cold]
    pub fn inset(&self, p: DVec3, inset: f64) -> DVec3 {
        let inward: [DVec3; 3] =
            std::array::from_fn(|i| DVec3::new(self.x[i + 1], self.y[i + 1], self.z[i + 1]));
        let distance: [f64; 3] = std::array::from_fn(|i| inward[i].dot(p) + self.w[i + 1]);
        // Edges are as long as the sine of the angle they face, and all are at the inscribed radius from its centre.
        let pair = |i: usize| [(i + 1) % 3, (i + 2) % 3];
        let length: [f64; 3] = std::array::from_fn(|i| inward[pair(i)[0]].cross(inward[pair(i)[1]]).length());
        let sum: f64 = (0..3).map(|i| length[i] * distance[i]).sum();
        let radius = sum / length.iter().sum::<f64>();
        let widest = (0..3).fold(0, |best, i| if length[i] > length[best] { i } else { best });
        let [a, b] = pair(widest);
        let cosine = inward[a].dot(inward[b]);
        let (to_a, to_b) = (radius - distance[a], radius - distance[b]);
        let to_center = inward[a] * (to_a - cosine * to_b) + inward[b] * (to_b - cosine * to_a);
        p + to_center / (1.0 - cosine * cosine) * (inset / radius).clamp(0.0, 1.0)
    }
}
