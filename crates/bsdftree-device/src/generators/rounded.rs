//! A rounded box of polygons, as `genbox -r -n` makes it.
//!
//! Each corner is an eighth of a sphere, an octahedron's face that is cut in four again and again; each edge is strips. Smooth ones
//! carry the texture that interpolates normals in triangles, and are listed edges first, corners backwards.

use glam::DVec3;

use super::boxes::{Block, EDGES};
use super::output::Output;
use crate::error::DeviceError;
use crate::mesh::smooth_texture;

/// Edges and faces shorter than this are not there.
const TINY: f64 = 1e-6;

pub(super) struct Rounded<'a> {
    pub block: &'a Block,
    /// Segments of an edge as a power of two.
    pub log2: u32,
    pub is_smooth: bool,
}

/// A point of the box and the unit normal there.
#[derive(Clone, Copy)]
struct Point {
    position: DVec3,
    normal: DVec3,
}

impl Rounded<'_> {
    pub fn generate(&self, output: &mut Output) -> Result<(), DeviceError> {
        let corners = self.corners();
        let mut count = 0;
        let modifier = &self.block.names.modifier;
        if self.is_smooth {
            for [a, b, c, d] in self.strips() {
                self.triangle([b, c, d], &mut count, output)?;
                self.triangle([d, a, b], &mut count, output)?;
            }
            for &corner in corners.iter().rev() {
                self.triangle(corner, &mut count, output)?;
            }
        } else {
            for corner in corners {
                output.polygon(modifier, self.name(&mut count), corner.map(|p| p.position))?;
            }
            for strip in self.strips() {
                output.polygon(modifier, self.name(&mut count), strip.map(|p| p.position))?;
            }
        }
        for face in (0..6).rev() {
            let face = self.block.face(face);
            if face[0].distance(face[1]) > TINY && face[1].distance(face[2]) > TINY {
                output.polygon(modifier, self.name(&mut count), face)?;
            }
        }
        Ok(())
    }

    fn name(&self, count: &mut u64) -> String {
        *count += 1;
        self.block.names.part(*count)
    }

    fn triangle(&self, corners: [Point; 3], count: &mut u64, output: &mut Output) -> Result<(), DeviceError> {
        let name = self.name(count);
        let positions = corners.map(|p| p.position);
        let (axis, rows) = smooth_texture(positions, corners.map(|p| p.normal));
        let reals = [&[axis as f64][..], rows.as_flattened()].concat();
        let strings = ["dx", "dy", "dz", "tmesh.cal"];
        output.primitive(&self.block.names.modifier, "texfunc", "Phong".to_owned(), &strings, reals)?;
        output.polygon("Phong", name, positions)
    }

    /// The point of the rounding at this corner of the box where the normal is this. All is reflected if it is inverted.
    fn point(&self, corner: u8, normal: DVec3) -> Point {
        let inset = self.block.inside(corner, DVec3::splat(self.block.cut));
        let outward = if self.block.inverted { -normal } else { normal };
        Point { position: inset + outward * self.block.cut, normal }
    }

    /// Triangles of all eight corners.
    fn corners(&self) -> Vec<[Point; 3]> {
        let mut triangles = Vec::with_capacity(8 << (2 * self.log2));
        for corner in (0..8u8).rev() {
            let axis = |k: usize| if corner >> k & 1 == 1 { DVec3::AXES[k] } else { -DVec3::AXES[k] };
            let [b, c] = if corner.count_ones() % 2 == 1 { [axis(1), axis(0)] } else { [axis(0), axis(1)] };
            self.divide(corner, [axis(2), b, c], self.log2, &mut triangles);
        }
        triangles
    }

    fn divide(&self, corner: u8, [a, b, c]: [DVec3; 3], levels: u32, triangles: &mut Vec<[Point; 3]>) {
        if levels == 0 {
            triangles.push([c, b, a].map(|normal| self.point(corner, normal)));
            return;
        }
        let between = |p: DVec3, q: DVec3| (p + q).normalize();
        let (ab, bc, ac) = (between(a, b), between(b, c), between(a, c));
        for part in [[ac, ab, bc], [ab, ac, a], [bc, ab, b], [ac, bc, c]] {
            self.divide(corner, part, levels - 1, triangles);
        }
    }

    /// Quadrangles of all edges that have a length.
    fn strips(&self) -> impl Iterator<Item = [Point; 4]> {
        EDGES.iter().rev().flat_map(move |edge| {
            let mut ends = [edge.as_bytes()[0] - b's', edge.as_bytes()[1] - b's'];
            let along = (ends[0] ^ ends[1]).trailing_zeros() as usize;
            let first = ends[0];
            let is_far = |axis: usize| first >> axis & 1 == 1;
            let across = [(along + 1) % 3, (along + 2) % 3];
            let [u, v] = across.map(|k| if is_far(k) { DVec3::AXES[k] } else { -DVec3::AXES[k] });
            ends.sort_unstable();
            if is_far(across[0]) != is_far(across[1]) {
                ends.reverse();
            }
            let length = self.block.size[along] - 2.0 * self.block.cut;
            let n = if length > TINY { 1u32 << self.log2 } else { 0 };
            let normal = move |k: u32| {
                let (sin, cos) = (std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(n)).sin_cos();
                u * cos + v * sin
            };
            (0..n).map(move |k| {
                let (near, next) = (normal(k), normal(k + 1));
                let [a, b] = ends;
                [self.point(a, next), self.point(b, next), self.point(b, near), self.point(a, near)]
            })
        })
    }
}
