//! Radiance's compiled triangle meshes, as `obj2mesh` writes them.
//!
//! In: bytes. Out: a [`MeshFile`] with the materials it brings along. Source: files written by `obj2mesh` (2025), taken apart.
//!
//! Layout after what [`compiled`](super::compiled) has: limits of texture coordinates; voxels; materials; patches. A patch is up
//! to 256 vertices: places as 32-bit fractions of the cube, normals of 32 bits, texture coordinates as 32-bit fractions of their
//! limits; triangles among them; materials, one for all or one each; and triangles that share one or two vertices with
//! other patches, each with its material. A vertex elsewhere is named by its patch and its number in it.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};

use super::compiled::{Objects, Reader};
use super::direction::decoded;
use super::parts::{Made, Part};
use super::{MeshFile, Vertices};
use crate::error::{DeviceError, Place};
use crate::options::Limits;
use crate::rad::too_large;

/// Fractions are of this.
const WHOLE: f64 = 4_294_967_296.0;

const HAS_NORMALS: u64 = 2;
const HAS_UVS: u64 = 4;

/// A triangle's vertices, by patch and number, and the number of its material.
type Triangle = ([(u64, u64); 3], i64);

pub(super) fn read(bytes: &[u8], file: &str, limits: &Limits) -> Result<MeshFile, DeviceError> {
    let mut reader = Reader::open(bytes, file, "Radiance_tmesh", 319)?;
    let (corner, size) = reader.cube()?;
    let mut uv_limits = [[0.0; 2]; 2];
    for limit in uv_limits.as_flattened_mut() {
        *limit = reader.real("limits of texture coordinates")?;
    }
    reader.skip_voxels()?;
    let objects = reader.scene()?;
    let materials = objects.statements(&reader)?;
    let mut patches = Patches {
        corner: DVec3::from_array(corner),
        size,
        uv_limits,
        vertices: Vertices::default(),
        firsts: Vec::new(),
        triangles: Vec::new(),
    };
    let n_patches = reader.count(4, 9, "a number of patches")?;
    for _ in 0..n_patches {
        patches.read(&mut reader)?;
        if patches.triangles.len() as u64 > limits.surfaces {
            let at = Place { file: file.into(), line: 1 };
            return Err(too_large(&at, "triangles", limits.surfaces));
        }
    }
    let parts = patches.parts(&objects, &reader)?;
    Ok(MeshFile { vertices: Arc::new(patches.vertices), parts, materials, warnings: Vec::new() })
}

struct Patches {
    corner: DVec3,
    size: f64,
    /// Of u and of v, each from and to.
    uv_limits: [[f64; 2]; 2],
    vertices: Vertices,
    /// Index of the first vertex of each patch.
    firsts: Vec<usize>,
    triangles: Vec<Triangle>,
}

impl Patches {
    fn read(&mut self, reader: &mut Reader) -> Result<(), DeviceError> {
        let patch = self.firsts.len() as u64;
        let flags = reader.unsigned(1, "a patch")?;
        let n = reader.count(2, 12, "a number of vertices")?;
        self.firsts.push(self.vertices.positions.len());
        for _ in 0..n {
            let mut fraction = DVec3::ZERO;
            for axis in 0..3 {
                fraction[axis] = (reader.unsigned(4, "a vertex")? as f64 + 0.5) / WHOLE;
            }
            self.vertices.positions.push(self.corner + fraction * self.size);
        }
        let all = self.vertices.positions.len();
        if flags & HAS_NORMALS != 0 {
            self.vertices.normals.resize(all - n, Vec3::ZERO);
            for _ in 0..n {
                self.vertices.normals.push(decoded(reader.unsigned(4, "a normal")? as u32));
            }
        }
        if flags & HAS_UVS != 0 {
            self.vertices.uvs.resize(all - n, Vec2::ZERO);
            for _ in 0..n {
                let mut uv = [0.0; 2];
                for (coordinate, [low, high]) in uv.iter_mut().zip(self.uv_limits) {
                    // Nothing is 0, elsewhere 0 does not occur.
                    let code = reader.unsigned(4, "texture coordinates")?;
                    *coordinate =
                        if code == 0 { 0.0 } else { low + (high - low) * (code as f64 + 0.5) / WHOLE };
                }
                self.vertices.uvs.push(Vec2::new(uv[0] as f32, uv[1] as f32));
            }
        }
        self.read_triangles(patch, reader)
    }

    fn read_triangles(&mut self, patch: u64, reader: &mut Reader) -> Result<(), DeviceError> {
        let n = reader.count(2, 3, "a number of triangles")?;
        let first = self.triangles.len();
        for _ in 0..n {
            let mut corners = [(patch, 0); 3];
            for corner in &mut corners {
                corner.1 = reader.unsigned(1, "a vertex of a triangle")?;
            }
            self.triangles.push((corners, -1));
        }
        let at = reader.offset();
        let n_materials = reader.count(2, 2, "a number of materials")?;
        if n_materials > 1 && n_materials != n {
            return Err(reader.wrong_at(
                at,
                "one material, or one for each triangle",
                &n_materials.to_string(),
            ));
        }
        let mut sole = -1;
        for k in 0..n_materials {
            sole = reader.integer(2, "a material")?;
            if n_materials > 1 {
                self.triangles[first + k].1 = sole;
            }
        }
        if n_materials == 1 {
            self.triangles[first..].iter_mut().for_each(|triangle| triangle.1 = sole);
        }
        for n_elsewhere in [1, 2] {
            let n = reader.count(2, 6, "a number of triangles across patches")?;
            for _ in 0..n {
                let mut corners = [(patch, 0); 3];
                for (k, corner) in corners.iter_mut().enumerate() {
                    if k < n_elsewhere {
                        let vertex = reader.unsigned(4, "a vertex elsewhere")?;
                        *corner = (vertex >> 8, vertex & 0xff);
                    } else {
                        corner.1 = reader.unsigned(1, "a vertex of a triangle")?;
                    }
                }
                self.triangles.push((corners, reader.integer(2, "a material")?));
            }
        }
        Ok(())
    }

    /// The triangles by their materials.
    fn parts(&mut self, objects: &Objects, reader: &Reader) -> Result<Vec<Part>, DeviceError> {
        let all = self.vertices.positions.len();
        // Lists go on to the last vertex.
        if !self.vertices.normals.is_empty() {
            self.vertices.normals.resize(all, Vec3::ZERO);
        }
        if !self.vertices.uvs.is_empty() {
            self.vertices.uvs.resize(all, Vec2::ZERO);
        }
        let index = |(patch, number): (u64, u64)| {
            let first = *self.firsts.get(patch as usize)?;
            let end = self.firsts.get(patch as usize + 1).copied().unwrap_or(all);
            let index = first + number as usize;
            (index < end).then_some(index as u32)
        };
        let mut by_material = std::collections::BTreeMap::<i64, Vec<[u32; 3]>>::new();
        for (corners, material) in &self.triangles {
            let [a, b, c] = corners.map(index);
            let (Some(a), Some(b), Some(c)) = (a, b, c) else {
                return Err(reader.wrong_at(
                    reader.offset(),
                    "triangles of vertices that are there",
                    &format!("{corners:?}"),
                ));
            };
            if *material < -1 || *material >= objects.len() as i64 {
                return Err(reader.wrong_at(
                    reader.offset(),
                    "materials that are there",
                    &material.to_string(),
                ));
            }
            by_material.entry(*material).or_default().push([a, b, c]);
        }
        let made = |material: i64| match usize::try_from(material) {
            Ok(k) => Made::Own(objects.name(k)),
            Err(_) => Made::Unsaid,
        };
        let parts = by_material.into_iter();
        Ok(parts.map(|(material, triangles)| Part { material: made(material), triangles, line: 1 }).collect())
    }
}
