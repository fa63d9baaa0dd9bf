//! Surface primitives, as Radiance's reference manual defines them. Lengths in metres.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use crate::mesh::Mesh;
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
    /// Triangles over shared vertices.
    Mesh(Arc<Mesh>),
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
            Shape::Mesh(mesh) => mesh.area(),
        }
    }

    /// Whether a polygon or a mesh has no area to speak of; other shapes never are.
    pub fn is_degenerate(&self) -> bool {
        match self {
            Shape::Polygon(vertices) => triangulate::is_degenerate(vertices),
            Shape::Mesh(mesh) => mesh.solid().next().is_none(),
            _ => false,
        }
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

    /// Triangles of a polygon or a mesh, vertices taken over unchanged and turned as they are; none for other shapes.
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
            Shape::Mesh(mesh) => mesh.solid().map(|(_, corners)| corners).collect(),
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
            Shape::Mesh(mesh) => mesh.bounds(),
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

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, TAU};

    use glam::dvec3;
    use proptest::prelude::*;

    use super::*;

    fn assert_bounds(shape: &Shape, low: DVec3, high: DVec3) {
        let [a, b] = shape.bounds();
        assert!(a.distance(low) < 1e-12 && b.distance(high) < 1e-12, "{a} {b} is not {low} {high}");
    }

    #[test]
    fn bounds_are_tight() {
        let ends = [DVec3::ZERO, dvec3(0.0, 3.0, 3.0)];
        let r = FRAC_1_SQRT_2;
        let cylinder = Shape::Cylinder { ends, radius: 1.0, inward: false };
        assert_bounds(&cylinder, dvec3(-1.0, -r, -r), dvec3(1.0, 3.0 + r, 3.0 + r));
        let cone = Shape::Cone { ends, radii: [1.0, 0.0], inward: false };
        assert_bounds(&cone, dvec3(-1.0, -r, -r), dvec3(1.0, 3.0, 3.0));
        let ring = Shape::Ring { center: DVec3::ONE, normal: DVec3::Z, radii: [0.5, 2.0] };
        assert_bounds(&ring, dvec3(-1.0, -1.0, 1.0), dvec3(3.0, 3.0, 1.0));
        let sphere = Shape::Sphere { center: DVec3::ONE, radius: 2.0, inward: true };
        assert_bounds(&sphere, DVec3::splat(-1.0), DVec3::splat(3.0));
    }

    #[test]
    fn areas_are_the_closed_forms() {
        let ends = [DVec3::ZERO, dvec3(0.0, 3.0, 4.0)];
        let areas = [
            (Shape::Cylinder { ends, radius: 2.0, inward: true }, 20.0 * PI),
            (
                Shape::Cone { ends: [DVec3::ZERO, 4.0 * DVec3::Z], radii: [3.0, 0.0], inward: false },
                15.0 * PI,
            ),
            (
                Shape::Cone { ends: [DVec3::ZERO, 4.0 * DVec3::Z], radii: [4.0, 1.0], inward: false },
                25.0 * PI,
            ),
            (Shape::Sphere { center: DVec3::ONE, radius: 2.0, inward: false }, 16.0 * PI),
            (Shape::Ring { center: DVec3::ONE, normal: DVec3::Z, radii: [1.0, 2.0] }, 3.0 * PI),
            (Shape::Polygon(vec![DVec3::ZERO, 3.0 * DVec3::X, dvec3(0.0, 3.0, 4.0)]), 7.5),
        ];
        for (shape, area) in areas {
            assert!((shape.area() / area - 1.0).abs() < 1e-14, "{shape:?}");
        }
    }

    #[test]
    fn degenerate_and_bent_polygons_are_told() {
        let line = Shape::Polygon(vec![DVec3::ZERO, DVec3::X, 3.0 * DVec3::X]);
        assert!(line.is_degenerate() && line.triangulate().is_empty());
        let slat = vec![DVec3::ZERO, 10.0 * DVec3::X, dvec3(10.0, 1e-7, 0.0), dvec3(0.0, 1e-7, 0.0)];
        assert!(!Shape::Polygon(slat).is_degenerate());
        let bent = |z| Shape::Polygon(vec![DVec3::ZERO, DVec3::X, dvec3(1.0, 1.0, z), DVec3::Y]);
        assert!(bent(1e-7).is_planar() && !bent(0.01).is_planar());
    }

    proptest! {
        #[test]
        fn bounds_hold_every_point_and_touch_some(
            axis in prop::array::uniform3(-1.0..1.0f64), radii in prop::array::uniform2(0.1..2.0f64)
        ) {
            let axis = DVec3::from(axis);
            prop_assume!(axis.length() > 0.1);
            let shape = Shape::Cone { ends: [DVec3::ONE, DVec3::ONE + axis], radii, inward: false };
            let [low, high] = shape.bounds();
            let (u, v) = axis.normalize().any_orthonormal_pair();
            let (mut seen_low, mut seen_high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for k in 0..10_000 {
                let (sin, cos) = (TAU * k as f64 / 10_000.0).sin_cos();
                for end in [0, 1] {
                    let p = DVec3::ONE + end as f64 * axis + radii[end] * (cos * u + sin * v);
                    (seen_low, seen_high) = (seen_low.min(p), seen_high.max(p));
                }
            }
            prop_assert!((seen_low - low).abs().max_element() < 1e-6 && (seen_low - low).min_element() > -1e-12);
            prop_assert!((seen_high - high).abs().max_element() < 1e-6 && (high - seen_high).min_element() > -1e-12);
        }
    }
}
