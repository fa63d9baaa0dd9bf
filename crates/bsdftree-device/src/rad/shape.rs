//! Surface primitives of a scene file to [`Shape`]s in place.
//!
//! In: a primitive, the transformation to metres, and whether it is turned over. Out: a shape, or why it is dropped.
//! Illegal radii, unknown axes and empty areas drop the surface with a warning, and negative radii turn it over, as
//! in Radiance. A mirrored polygon lists its vertices backwards, so that its front stays its front.

use glam::DVec3;

use super::statement::Primitive;
use super::transform::Transform;
use crate::shape::Shape;

/// What became of a surface primitive.
#[derive(Debug, PartialEq)]
pub(crate) enum Shaped {
    /// A surface, and perhaps something to tell.
    Shape(Shape, Option<&'static str>),
    /// Nothing, and why.
    Dropped(&'static str),
}

/// How many real arguments a surface type takes; polygons take three a vertex.
pub(super) fn expected_reals(kind: &str, n: usize) -> Option<&'static str> {
    let (right, expected) = match kind {
        "polygon" => (n >= 9 && n.is_multiple_of(3), "three coordinates for each of at least three vertices"),
        "sphere" | "bubble" => (n == 4, "4 real arguments (centre, radius)"),
        "cylinder" | "tube" => (n == 7, "7 real arguments (two ends, radius)"),
        "cone" | "cup" => (n == 8, "8 real arguments (two ends, two radii)"),
        _ => (n == 8, "8 real arguments (centre, direction, two radii)"),
    };
    if right { None } else { Some(expected) }
}

/// Places a surface. The number of real arguments has been checked by [`expected_reals`].
pub(super) fn place(primitive: &Primitive, to: &Transform, invert: bool) -> Shaped {
    let r = &primitive.reals;
    let point = |k: usize| to.point(DVec3::new(r[k], r[k + 1], r[k + 2]));
    let inward = matches!(&*primitive.kind, "bubble" | "tube" | "cup") != invert;
    match &*primitive.kind {
        "polygon" => {
            let mut vertices: Vec<DVec3> = (0..r.len()).step_by(3).map(point).collect();
            if to.mirrored != invert {
                vertices.reverse();
            }
            polygon(vertices)
        }
        "sphere" | "bubble" => sphere(point(0), r[3] * to.scale, inward),
        "cylinder" | "tube" => cone([point(0), point(3)], [r[6] * to.scale; 2], inward),
        "cone" | "cup" => cone([point(0), point(3)], [r[6] * to.scale, r[7] * to.scale], inward),
        _ => {
            let direction = to.vector(DVec3::new(r[3], r[4], r[5])) * if invert { -1.0 } else { 1.0 };
            ring(point(0), direction, [r[6] * to.scale, r[7] * to.scale])
        }
    }
}

pub(crate) fn polygon(vertices: Vec<DVec3>) -> Shaped {
    let finite = vertices.iter().all(|v| v.is_finite());
    let shape = Shape::Polygon(vertices);
    // Overflow is an error of its own.
    if finite && shape.is_degenerate() {
        return Shaped::Dropped("it has no area");
    }
    let bent = (!shape.is_planar()).then_some("its vertices are not in one plane");
    Shaped::Shape(shape, bent)
}

pub(crate) fn sphere(center: DVec3, radius: f64, inward: bool) -> Shaped {
    if radius == 0.0 {
        return Shaped::Dropped("its radius is 0");
    }
    let turned = (radius < 0.0).then_some("its negative radius turns it over");
    Shaped::Shape(Shape::Sphere { center, radius: radius.abs(), inward: inward != (radius < 0.0) }, turned)
}

pub(crate) fn cone(ends: [DVec3; 2], radii: [f64; 2], inward: bool) -> Shaped {
    if ends[0] == ends[1] {
        return Shaped::Dropped("its axis has no length");
    }
    if radii == [0.0; 2] || radii[0] * radii[1] < 0.0 {
        return Shaped::Dropped("its radii are both 0 or of opposite sign");
    }
    let negative = radii[0] < 0.0 || radii[1] < 0.0;
    let inward = inward != negative;
    let radii = radii.map(f64::abs);
    let shape = if radii[0] == radii[1] {
        Shape::Cylinder { ends, radius: radii[0], inward }
    } else {
        Shape::Cone { ends, radii, inward }
    };
    Shaped::Shape(shape, negative.then_some("its negative radius turns it over"))
}

pub(crate) fn ring(center: DVec3, direction: DVec3, radii: [f64; 2]) -> Shaped {
    let [a, b] = radii;
    if a < 0.0 || b < 0.0 || a == b {
        return Shaped::Dropped("its radii are negative or equal");
    }
    match unit(direction) {
        Some(normal) => Shaped::Shape(Shape::Ring { center, normal, radii: [a.min(b), a.max(b)] }, None),
        None => Shaped::Dropped("its direction has no length"),
    }
}

/// The unit vector, exactly the vector itself if it has unit length up to rounding; so writing and reading again
/// changes nothing.
pub(super) fn unit(v: DVec3) -> Option<DVec3> {
    if (v.length_squared() - 1.0).abs() <= 4.0 * f64::EPSILON { Some(v) } else { v.try_normalize() }
}
