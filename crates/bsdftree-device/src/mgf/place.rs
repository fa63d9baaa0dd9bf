//! Surfaces where they belong.
//!
//! In: a [`Piece`] in the file's coordinates and the transformation to metres. Out: a shape, or why it is dropped. A mirrored face lists
//! its vertices backwards, so that its front stays its front.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::piece::{Piece, Vertex};
use crate::mesh::{Mesh, Vertices};
use crate::rad::Transform;
use crate::rad::shape::{self, Shaped};
use crate::shape::Shape;

/// A piece in metres: its kind, about how many bytes it takes, its shape.
pub(super) fn placed(piece: Piece, to: &Transform) -> (&'static str, usize, Shaped) {
    match piece {
        Piece::Polygon(points) => {
            let mut points: Vec<DVec3> = points.into_iter().map(|p| to.point(p)).collect();
            if to.mirrored {
                points.reverse();
            }
            ("face", 24 * points.len(), shape::polygon(points))
        }
        Piece::Smooth(corners, triangles) => ("face", 256, smooth(&corners, triangles, to)),
        Piece::Sphere { center, radius } => {
            ("sphere", 0, shape::sphere(to.point(center), radius.abs() * to.scale, radius < 0.0))
        }
        Piece::Cone { ends, radii } => {
            let inward = radii.iter().any(|&r| r < 0.0);
            ("cone", 0, shape::cone(ends.map(|p| to.point(p)), radii.map(|r| r.abs() * to.scale), inward))
        }
        Piece::Ring { center, normal, radii } => {
            ("ring", 0, shape::ring(to.point(center), to.vector(normal), radii.map(|r| r * to.scale)))
        }
    }
}

fn smooth(corners: &[Vertex], triangles: &[[u32; 3]], to: &Transform) -> Shaped {
    let normal = |v: &Vertex| to.vector(v.normal).normalize_or_zero().as_vec3();
    let vertices = Vertices {
        positions: corners.iter().map(|v| to.point(v.point)).collect(),
        normals: corners.iter().map(normal).collect::<Vec<Vec3>>(),
        uvs: Vec::new(),
    };
    let turned = |&[a, b, c]: &[u32; 3]| if to.mirrored { [c, b, a] } else { [a, b, c] };
    let mesh = Mesh { vertices: Arc::new(vertices), triangles: triangles.iter().map(turned).collect() };
    let finite = mesh.vertices.positions.iter().all(|p| p.is_finite());
    let shape = Shape::Mesh(Arc::new(mesh));
    // Overflow is an error of its own.
    if finite && shape.is_degenerate() {
        Shaped::Dropped("it has no area")
    } else {
        Shaped::Shape(shape, None)
    }
}
