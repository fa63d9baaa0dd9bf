//! Surfaces as MGF gives them, before they are placed.
//!
//! In: vertices by value, radii, lengths. Out: [`Piece`]s: polygons, triangles with normals, spheres, cones, rings. Sources: MGF's
//! entities; orientations as mgf2rad's. Deviations from mgf2rad, each on the side of what the language says:
//! * A face with holes becomes triangles that leave them open, whichever way they turn; mgf2rad joins two or more holes by a seam that
//!   adds a triangle, and to the wrong side where a hole turns as its face does.
//! * Normals at vertices count as soon as one differs from the face's own by 0.1°; mgf2rad drops them below 5.7°.
//! * A torus is [`TORUS_CONES`] cones round its tube (mgf2rad: 20).

use std::f64::consts::TAU;

use glam::DVec3;

use crate::triangulate::{area_vector, triangles_around_holes};

/// MGF's vertex: a point, and a unit normal or zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vertex {
    pub point: DVec3,
    pub normal: DVec3,
}

/// A surface in the file's own coordinates. Negative radii mean that it faces in.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Piece {
    Polygon(Vec<DVec3>),
    /// One triangle, or two that share an edge.
    Smooth(Vec<Vertex>, &'static [[u32; 3]]),
    Sphere {
        center: DVec3,
        radius: f64,
    },
    /// Cylinders too.
    Cone {
        ends: [DVec3; 2],
        radii: [f64; 2],
    },
    Ring {
        center: DVec3,
        normal: DVec3,
        radii: [f64; 2],
    },
}

/// How many cones make a torus: the surface is within 8·10⁻⁵ of the tube's radius, its normal within 0.71°.
pub(super) const TORUS_CONES: usize = 256;

/// A polygon, smooth if three or four vertices have normals that say so.
pub(super) fn face(corners: &[Vertex]) -> Piece {
    // Of an angle of 0.1°.
    const FLAT: f64 = 1.0 - 1.5e-6;
    let points = || corners.iter().map(|v| v.point).collect();
    let smooth = (3..=4).contains(&corners.len()) && corners.iter().all(|v| v.normal != DVec3::ZERO);
    let first = [0, 1, 2].map(|k| corners[k].point);
    let normal = (first[1] - first[0]).cross(first[2] - first[1]).try_normalize();
    let Some(normal) = normal.filter(|_| smooth) else { return Piece::Polygon(points()) };
    let mut corners = corners.to_vec();
    let mut cosines: Vec<f64> = corners.iter().map(|v| v.normal.dot(normal)).collect();
    // The normals say which side is the front, as in mgf2rad.
    let turned = cosines[..3].iter().all(|&c| c < 0.0);
    if turned {
        corners[1..].reverse();
        cosines.iter_mut().for_each(|c| *c = -*c);
    }
    if cosines.iter().all(|&c| c >= FLAT) {
        return Piece::Polygon(corners.iter().map(|v| v.point).collect());
    }
    let triangles: &[[u32; 3]] = match (corners.len(), turned) {
        (3, _) => &[[0, 1, 2]],
        (_, false) => &[[0, 1, 2], [2, 3, 0]],
        (_, true) => &[[2, 3, 0], [0, 1, 2]],
    };
    Piece::Smooth(corners, triangles)
}

/// A polygon around holes.
pub(super) fn face_with_holes(outer: &[Vertex], holes: &[&[Vertex]]) -> Vec<Piece> {
    let mut points: Vec<DVec3> = outer.iter().map(|v| v.point).collect();
    let mut starts = Vec::new();
    for hole in holes {
        starts.push(points.len() as u32);
        points.extend(hole.iter().map(|v| v.point));
    }
    let triangles = triangles_around_holes(&points, &starts);
    triangles.into_iter().map(|t| Piece::Polygon(t.to_vec())).collect()
}

/// The base, the other end as far behind it as `length` says (in front of it and all turned over if negative), and the sides, smooth if
/// the vertices have normals; `None` if the base has no area.
pub(super) fn prism(base: &[Vertex], length: f64) -> Option<Vec<Piece>> {
    let points: Vec<DVec3> = base.iter().map(|v| v.point).collect();
    let behind = -length * area_vector(&points).try_normalize()?;
    let moved = |v: &Vertex| Vertex { point: v.point + behind, ..*v };
    let mut pieces = Vec::with_capacity(base.len() + 2);
    for (k, v) in base.iter().enumerate() {
        let before = &base[(k + base.len() - 1) % base.len()];
        pieces.push(face(&[moved(v), *v, *before, moved(before)]));
    }
    pieces.push(Piece::Polygon(points.iter().rev().map(|p| p + behind).collect()));
    pieces.push(Piece::Polygon(points));
    Some(pieces)
}

/// A torus about an axis from its innermost to its outermost radius; both negative, it faces in. `None` unless the second is
/// farther from 0 than the first, on the same side.
pub(super) fn torus(center: DVec3, axis: DVec3, [inner, outer]: [f64; 2]) -> Option<Vec<Piece>> {
    let sign = if inner == 0.0 { outer.signum() } else { inner.signum() };
    if sign * (outer - inner) <= 0.0 {
        return None;
    }
    let (tube, ring) = (0.5 * (outer - inner), 0.5 * (outer + inner));
    // From the top outwards: (height along the axis, radius). The innermost point of a horn torus is exactly on the axis.
    let at = |k: usize| {
        let (sin, cos) = (TAU * (k % TORUS_CONES) as f64 / TORUS_CONES as f64).sin_cos();
        let radius = if 4 * k == 3 * TORUS_CONES { inner } else { ring + tube * sin };
        (sign * tube * cos, radius)
    };
    let cone = |k: usize| {
        let ((low, from), (high, to)) = (at(k), at(k + 1));
        // The inner half faces the axis.
        let facing = if 2 * k < TORUS_CONES { 1.0 } else { -1.0 };
        Piece::Cone { ends: [center + low * axis, center + high * axis], radii: [facing * from, facing * to] }
    };
    Some((0..TORUS_CONES).map(cone).collect())
}
