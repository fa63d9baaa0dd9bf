//! Surface primitives, as Radiance's reference manual defines them. Lengths in metres.

use std::f64::consts::PI;

use glam::DVec3;

use crate::triangulate::{self, area_vector};

/// A surface primitive. The front of each is the side its normal points to.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Planar; vertices counter-clockwise seen from the front. Holes are cut by seams, as in Radiance: the outline
    /// runs to the hole, around it clockwise, and back along the same edge.
    Polygon(Vec<DVec3>),
    /// `sphere` faces out, `bubble` faces in.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius, > 0.
        radius: f64,
        /// Whether the normal points to the centre.
        inward: bool,
    },
    /// `cylinder` faces out, `tube` faces in. Open ends.
    Cylinder {
        /// The two ends of the axis.
        ends: [DVec3; 2],
        /// Radius, > 0.
        radius: f64,
        /// Whether the normal points to the axis.
        inward: bool,
    },
    /// `cone` faces out, `cup` faces in. Open ends, possibly truncated.
    Cone {
        /// The two ends of the axis.
        ends: [DVec3; 2],
        /// Radius at each end, ≥ 0, not equal.
        radii: [f64; 2],
        /// Whether the normal points to the axis.
        inward: bool,
    },
    /// A disk, or a disk with a concentric hole.
    Ring {
        /// Centre.
        center: DVec3,
        /// Unit normal.
        normal: DVec3,
        /// Inner (≥ 0) and outer radius.
        radii: [f64; 2],
    },
}

impl Shape {
    /// Area of one side \[m²\].
    pub fn area(&self) -> f64 {
        match self {
            Shape::Polygon(vertices) => area_vector(vertices).length(),
            Shape::Sphere { radius, .. } => 4.0 * PI * radius * radius,
            Shape::Cylinder { ends, radius, .. } => 2.0 * PI * radius * ends[0].distance(ends[1]),
            Shape::Cone { ends, radii, .. } => {
                PI * (radii[0] + radii[1]) * ends[0].distance(ends[1]).hypot(radii[0] - radii[1])
            }
            Shape::Ring { radii, .. } => PI * (radii[1] - radii[0]) * (radii[1] + radii[0]),
        }
    }

    /// Whether a polygon has no area to speak of; other shapes never are.
    pub fn is_degenerate(&self) -> bool {
        matches!(self, Shape::Polygon(vertices) if triangulate::is_degenerate(vertices))
    }

    /// Whether all vertices of a polygon are in one plane, up to 1e-6 of its size; other shapes always are.
    pub fn is_planar(&self) -> bool {
        let Shape::Polygon(v) = self else { return true };
        let Some(normal) = area_vector(v).try_normalize() else { return true };
        let center = v.iter().sum::<DVec3>() / v.len() as f64;
        let [low, high] = self.bounds();
        let tolerance = 1e-6 * low.distance(high);
        v.iter().all(|&p| (p - center).dot(normal).abs() <= tolerance)
    }

    /// Triangles of a polygon, vertices taken over unchanged and turned as the polygon is; none for other shapes.
    ///
    /// Concave outlines and holes cut by seams are right; repeated and collinear vertices make no triangle.
    ///
    /// ```
    /// use bsdftree_device::Shape;
    /// use glam::dvec3;
    /// let square = Shape::Polygon(vec![
    ///     dvec3(0.0, 0.0, 0.0), dvec3(1.0, 0.0, 0.0), dvec3(1.0, 1.0, 0.0), dvec3(0.0, 1.0, 0.0),
    /// ]);
    /// assert_eq!(square.triangulate().len(), 2);
    /// ```
    pub fn triangulate(&self) -> Vec<[DVec3; 3]> {
        match self {
            Shape::Polygon(vertices) => triangulate::triangles(vertices),
            _ => Vec::new(),
        }
    }

    /// Corners of the tight axis-aligned bounding box \[m\].
    pub fn bounds(&self) -> [DVec3; 2] {
        match self {
            Shape::Polygon(v) => {
                v.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |b, &p| [b[0].min(p), b[1].max(p)])
            }
            Shape::Sphere { center, radius, .. } => {
                [center - DVec3::splat(*radius), center + DVec3::splat(*radius)]
            }
            Shape::Cylinder { ends, radius, .. } => disks_bounds(*ends, ends[1] - ends[0], [*radius; 2]),
            Shape::Cone { ends, radii, .. } => disks_bounds(*ends, ends[1] - ends[0], *radii),
            Shape::Ring { center, normal, radii } => disks_bounds([*center; 2], *normal, [radii[1]; 2]),
        }
    }
}

/// Box around two disks that share an axis: a disk reaches r·√(1−a²) along a coordinate with axis cosine a.
fn disks_bounds(centers: [DVec3; 2], axis: DVec3, radii: [f64; 2]) -> [DVec3; 2] {
    let axis = axis.normalize_or_zero();
    let reach = (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt);
    let corner = |k: usize, sign: f64| centers[k] + reach * (sign * radii[k]);
    [corner(0, -1.0).min(corner(1, -1.0)), corner(0, 1.0).max(corner(1, 1.0))]
}
