//! Meshes as Radiance polygons, smooth ones with the texture that Radiance's `obj2rad` gives such triangles.
//!
//! In: a mesh. Out: one polygon a triangle; before it, where normals are to be interpolated, a `texfunc` of `tmesh.cal`: the
//! normal is linear in two coordinates, those across the axis the triangle faces most. Texture coordinates are not
//! written: no primitive has a place for them.

use std::fmt::{self, Write};

use glam::{DVec3, Vec3};

use super::Mesh;

/// Writes all triangles that have an area, named after the mesh with their numbers.
pub(crate) fn write_polygons(to: &mut String, modifier: &str, name: &str, mesh: &Mesh) -> fmt::Result {
    for (k, corners) in mesh.solid() {
        let texture = texture(mesh, k, corners);
        if let Some((axis, rows)) = texture {
            writeln!(to, "\n{modifier} texfunc {name}.{k}.smooth\n4 dx dy dz tmesh.cal\n0\n10 {axis}")?;
            for [a, b, c] in rows {
                writeln!(to, "  {a:?} {b:?} {c:?}")?;
            }
            writeln!(to, "\n{name}.{k}.smooth polygon {name}.{k}\n0\n0\n9")?;
        } else {
            writeln!(to, "\n{modifier} polygon {name}.{k}\n0\n0\n9")?;
        }
        for DVec3 { x, y, z } in corners {
            writeln!(to, "  {x:?} {y:?} {z:?}")?;
        }
    }
    Ok(())
}

/// The texture of a triangle, if it is to look smooth and is not flat anyway.
fn texture(mesh: &Mesh, triangle: usize, corners: [DVec3; 3]) -> Option<(usize, [[f64; 3]; 3])> {
    let normals = &mesh.vertices.normals;
    if normals.is_empty() {
        return None;
    }
    let normals = mesh.triangles[triangle].map(|k| normals[k as usize]);
    let [a, b, c] = corners;
    let flat = (b - a).cross(c - a).normalize_or_zero().as_vec3();
    if normals.contains(&Vec3::ZERO) || normals.iter().all(|n| n.distance(flat) < 1e-6) {
        return None;
    }
    Some(smooth_texture(corners, normals.map(Vec3::as_dvec3)))
}

/// Arguments of the functions of `tmesh.cal` for a triangle with these normals at its corners: the axis it faces most, and for
/// each component of the normal its slopes along the next two axes and its value at the origin.
pub(crate) fn smooth_texture([a, b, c]: [DVec3; 3], normals: [DVec3; 3]) -> (usize, [[f64; 3]; 3]) {
    let facing = (b - a).cross(c - a);
    let axis = facing.abs().max_position();
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let ([b, c], doubled) = ([b - a, c - a], facing[axis]);
    let rows = [0, 1, 2].map(|component| {
        let [of_a, of_b, of_c] = normals.map(|n| n[component]);
        let (to_b, to_c) = (of_b - of_a, of_c - of_a);
        let along_u = (to_b * c[v] - to_c * b[v]) / doubled;
        let along_v = (to_c * b[u] - to_b * c[u]) / doubled;
        [along_u, along_v, of_a - along_u * a[u] - along_v * a[v]]
    });
    (axis, rows)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::dvec3;

    use super::*;
    use crate::mesh::Vertices;

    #[test]
    fn textures_give_the_normals_at_the_corners() {
        for turn in 0..3 {
            let turned = |v: DVec3| DVec3::from_array(std::array::from_fn(|k| v[(k + turn) % 3]));
            let positions: Vec<DVec3> =
                [dvec3(1.0, 2.0, 0.1), dvec3(3.0, 2.5, 0.0), dvec3(1.5, 4.0, 0.3)].map(turned).to_vec();
            let normals: Vec<Vec3> = [dvec3(0.1, 0.2, 1.0), dvec3(0.5, -0.2, 1.0), dvec3(0.0, 0.4, 1.0)]
                .map(|n| turned(n.normalize()).as_vec3())
                .to_vec();
            let vertices = Vertices { positions, normals, uvs: Vec::new() };
            let mesh = Mesh { vertices: Arc::new(vertices), triangles: vec![[0, 1, 2]] };
            let (axis, rows) = texture(&mesh, 0, mesh.corners(0)).unwrap();
            assert_eq!(axis, (5 - turn) % 3);
            for (p, n) in mesh.corners(0).into_iter().zip(&mesh.vertices.normals) {
                let (u, v) = (p[(axis + 1) % 3], p[(axis + 2) % 3]);
                let at = DVec3::from_array(rows.map(|[a, b, c]| a * u + b * v + c));
                assert!(at.distance(n.as_dvec3()) < 1e-14);
            }
        }
    }
}
