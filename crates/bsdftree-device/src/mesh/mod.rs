//! Triangle meshes: many triangles over shared vertices, with what makes them look smooth and where pictures lie on them.
//!
//! In: the text or bytes of OBJ, PLY, STL or Radiance's compiled meshes. Out: [`Mesh`]es, one for each material, that
//! share their [`Vertices`].
//!
//! Modules in the order in which data flows: `format` → `obj`, `ply`, `stl`, `rtm` (`octree`, `compiled`,
//! `direction`) → `parts`; `write`.

mod compiled;
mod direction;
mod format;
mod obj;
mod octree;
mod parts;
mod ply;
mod rtm;
mod stl;
#[cfg(test)]
mod tests;
mod write;

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};

use crate::triangulate::is_degenerate;
pub(crate) use format::Format;
pub(crate) use octree::{Octree, read_octree};
pub(crate) use parts::{Made, MeshFile, Part};
pub(crate) use write::{smooth_texture, write_polygons};

/// Triangles over vertices that other meshes may share; the front is where they turn counter-clockwise.
///
/// ```
/// use bsdftree_device::mesh::{Mesh, Vertices};
/// use glam::{DVec3, Vec3};
/// use std::sync::Arc;
/// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
/// let normals = vec![Vec3::Z, Vec3::X, Vec3::Z];
/// let vertices = Arc::new(Vertices { positions, normals, uvs: Vec::new() });
/// let mesh = Mesh { vertices, triangles: vec![[0, 1, 2]] };
/// let point = mesh.at(0, DVec3::new(0.5, 0.0, 0.0));
/// assert!(point.normal.unwrap().distance(DVec3::new(0.5, 0.0, 0.5).normalize()) < 1e-7);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// What the triangles stand on.
    pub vertices: Arc<Vertices>,
    /// Indices into [`Vertices::positions`].
    pub triangles: Vec<[u32; 3]>,
}

/// Vertices of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vertices {
    /// Where they are \[m\].
    pub positions: Vec<DVec3>,
    /// Unit normals of the surface that the mesh stands for, as many as positions; zero where there is none. Empty: the
    /// mesh is as it is, faceted.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, as many as positions; Radiance's Lu and Lv. Empty: all are zero.
    pub uvs: Vec<Vec2>,
}

/// What a mesh knows of a point on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshPoint {
    /// Unit normal of the surface that the mesh stands for, if all vertices around have one.
    pub normal: Option<DVec3>,
    /// Texture coordinates.
    pub uv: [f64; 2],
}

impl Mesh {
    /// Corners of a triangle \[m\].
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|k| self.vertices.positions[k as usize])
    }

    /// All triangles that have an area.
    pub fn solid(&self) -> impl Iterator<Item = (usize, [DVec3; 3])> {
        let all = (0..self.triangles.len()).map(|k| (k, self.corners(k)));
        all.filter(|(_, corners)| !is_degenerate(corners))
    }

    /// Whether all indices name vertices, and normals and texture coordinates are as many as vertices or none.
    pub fn is_sound(&self) -> bool {
        let Vertices { positions, normals, uvs } = &*self.vertices;
        let n = positions.len();
        let as_many = |m: usize| m == 0 || m == n;
        as_many(normals.len())
            && as_many(uvs.len())
            && self.triangles.iter().flatten().all(|&k| (k as usize) < n)
    }

    /// What lies at a point of a triangle: linear between its corners.
    pub fn at(&self, triangle: usize, point: DVec3) -> MeshPoint {
        let Vertices { normals, uvs, .. } = &*self.vertices;
        let corners = self.triangles[triangle].map(|k| k as usize);
        let weights = weights(self.corners(triangle), point);
        let mut uv = [0.0; 2];
        if !uvs.is_empty() {
            for (k, weight) in corners.into_iter().zip(weights) {
                uv[0] += weight * uvs[k].x as f64;
                uv[1] += weight * uvs[k].y as f64;
            }
        }
        let smooth = !normals.is_empty() && corners.iter().all(|&k| normals[k] != Vec3::ZERO);
        let normal = smooth.then(|| {
            let sum: DVec3 = corners.into_iter().zip(weights).map(|(k, w)| normals[k].as_dvec3() * w).sum();
            sum.try_normalize()
        });
        MeshPoint { normal: normal.flatten(), uv }
    }

    /// Area of one side \[m²\].
    pub fn area(&self) -> f64 {
        let area = |k| {
            let [a, b, c] = self.corners(k);
            0.5 * (b - a).cross(c - a).length()
        };
        (0..self.triangles.len()).map(area).sum()
    }

    /// Corners of the box around all triangles \[m\].
    pub fn bounds(&self) -> [DVec3; 2] {
        let corners = self.triangles.iter().flatten().map(|&k| self.vertices.positions[k as usize]);
        corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |b, p| [b[0].min(p), b[1].max(p)])
    }
}

impl Vertices {
    /// The vertices moved: `point` takes places, `direction` takes normals, whose length does not matter.
    pub fn moved(&self, point: impl Fn(DVec3) -> DVec3, direction: impl Fn(DVec3) -> DVec3) -> Vertices {
        let unit = |n: &Vec3| match *n {
            Vec3::ZERO => Vec3::ZERO,
            n => direction(n.as_dvec3()).normalize_or_zero().as_vec3(),
        };
        Vertices {
            positions: self.positions.iter().map(|&p| point(p)).collect(),
            normals: self.normals.iter().map(unit).collect(),
            uvs: self.uvs.clone(),
        }
    }
}

/// Meshes that are moved one after another; vertices they share are moved once and stay shared.
#[derive(Default)]
pub(crate) struct Moving {
    last: Option<(Arc<Vertices>, Arc<Vertices>)>,
}

impl Moving {
    /// See [`Vertices::moved`].
    pub(crate) fn moved(
        &mut self,
        mesh: &Mesh,
        point: impl Fn(DVec3) -> DVec3,
        direction: impl Fn(DVec3) -> DVec3,
    ) -> Mesh {
        let vertices = match &self.last {
            Some((from, to)) if Arc::ptr_eq(from, &mesh.vertices) => to.clone(),
            _ => Arc::new(mesh.vertices.moved(point, direction)),
        };
        self.last = Some((mesh.vertices.clone(), vertices.clone()));
        Mesh { vertices, triangles: mesh.triangles.clone() }
    }
}

/// Shares of the corners at a point, which add up to 1.
fn weights([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let area = (b - a).cross(c - a);
    let whole = area.length_squared();
    if whole == 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let of_b = (p - a).cross(c - a).dot(area) / whole;
    let of_c = (b - a).cross(p - a).dot(area) / whole;
    // Rounding may leave the point beside its triangle.
    let [of_b, of_c] = [of_b, of_c].map(|w| w.clamp(0.0, 1.0));
    [(1.0 - of_b - of_c).max(0.0), of_b, of_c]
}
