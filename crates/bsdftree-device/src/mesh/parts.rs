//! A mesh file as it was read, and how readers put one together.
//!
//! Invariant: corners with the same place, normal and texture coordinates are one vertex; every triangle has an area.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};

use super::Vertices;
use crate::error::{DeviceError, Place};
use crate::options::Limits;
use crate::rad::{Statement, too_large};
use crate::triangulate;

/// What is in a mesh file, in its unit of length.
#[derive(Clone)]
pub(crate) struct MeshFile {
    pub vertices: Arc<Vertices>,
    /// Triangles by what they are made of.
    pub parts: Vec<Part>,
    /// The materials that the file brings along, as statements of a scene.
    pub materials: Vec<Statement>,
    /// Things the user should know.
    pub warnings: Vec<String>,
}

/// Triangles of one material.
#[derive(Clone)]
pub(crate) struct Part {
    pub material: Made,
    pub triangles: Vec<[u32; 3]>,
    /// Where it begins.
    pub line: u32,
}

/// What a part is made of, as far as its file tells.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Made {
    /// Nothing is said.
    Unsaid,
    /// Something that is to be defined outside of the file.
    Named(String),
    /// A modifier that the file brings along.
    Own(String),
}

/// Corner of a polygon: its place, and its texture coordinates and its normal if it has them.
pub(super) type Corner = (u32, Option<u32>, Option<u32>);

/// A mesh file that grows, polygon by polygon.
pub(super) struct Builder<'a> {
    pub positions: Vec<DVec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    vertices: Vertices,
    known: HashMap<Corner, u32>,
    /// Vertices of plain corners, by their place.
    plain: Vec<u32>,
    parts: Vec<Part>,
    indices: HashMap<Made, usize>,
    n_triangles: u64,
    n_degenerate: u64,
    limits: &'a Limits,
    file: Arc<str>,
}

/// No vertex yet.
const NONE: u32 = u32::MAX;

impl<'a> Builder<'a> {
    pub fn new(file: &str, limits: &'a Limits) -> Self {
        Builder {
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            vertices: Vertices::default(),
            known: HashMap::new(),
            plain: Vec::new(),
            parts: Vec::new(),
            indices: HashMap::new(),
            n_triangles: 0,
            n_degenerate: 0,
            limits,
            file: file.into(),
        }
    }

    pub fn place(&self, line: u32) -> Place {
        Place { file: self.file.clone(), line }
    }

    /// The part of this material, for [`Builder::polygon`].
    pub fn part(&mut self, material: Made, line: u32) -> usize {
        let parts = &mut self.parts;
        *self.indices.entry(material.clone()).or_insert_with(|| {
            parts.push(Part { material, triangles: Vec::new(), line });
            parts.len() - 1
        })
    }

    /// Adds a polygon in triangles. Its corners' indices must be in range.
    pub fn polygon(&mut self, part: usize, corners: &[Corner], line: u32) -> Result<(), DeviceError> {
        self.n_triangles += corners.len().saturating_sub(2) as u64;
        if self.n_triangles > self.limits.surfaces {
            return Err(too_large(&self.place(line), "triangles", self.limits.surfaces));
        }
        let positions: Vec<DVec3> = corners.iter().map(|c| self.positions[c.0 as usize]).collect();
        let triangles = triangulate::corners_of_triangles(&positions);
        if triangles.is_empty() {
            self.n_degenerate += 1;
            return Ok(());
        }
        let vertices = corners.iter().map(|&corner| self.vertex(corner));
        let vertices = vertices.collect::<Option<Vec<u32>>>();
        let vertices = vertices.ok_or_else(|| too_large(&self.place(line), "vertices", NONE as u64))?;
        self.parts[part].triangles.extend(triangles.into_iter().map(|t| t.map(|k| vertices[k as usize])));
        Ok(())
    }

    fn vertex(&mut self, corner: Corner) -> Option<u32> {
        let (position, uv, normal) = corner;
        let next = u32::try_from(self.vertices.positions.len()).ok().filter(|&k| k != NONE)?;
        let known = if uv.is_none() && normal.is_none() {
            self.plain.resize(self.positions.len(), NONE);
            &mut self.plain[position as usize]
        } else {
            self.known.entry(corner).or_insert(NONE)
        };
        if *known != NONE {
            return Some(*known);
        }
        *known = next;
        let Vertices { positions, normals, uvs } = &mut self.vertices;
        positions.push(self.positions[position as usize]);
        // Lists begin with the first vertex that has something to list.
        if let Some(k) = normal {
            normals.resize(next as usize, Vec3::ZERO);
            normals.push(self.normals[k as usize]);
        } else if !normals.is_empty() {
            normals.push(Vec3::ZERO);
        }
        if let Some(k) = uv {
            uvs.resize(next as usize, Vec2::ZERO);
            uvs.push(self.uvs[k as usize]);
        } else if !uvs.is_empty() {
            uvs.push(Vec2::ZERO);
        }
        Some(next)
    }

    pub fn finish(self, mut warnings: Vec<String>) -> MeshFile {
        if self.n_degenerate > 0 {
            warnings
                .push(format!("{}: {} faces are left out: they have no area", self.file, self.n_degenerate));
        }
        let parts = self.parts.into_iter().filter(|part| !part.triangles.is_empty()).collect();
        MeshFile { vertices: Arc::new(self.vertices), parts, materials: Vec::new(), warnings }
    }
}
