//! What a device is made of for the tracer: facets and analytic surfaces in the local frame.
//!
//! Enters: a `Device`. Leaves: checked, finite primitives in the order of the surfaces; void ones are left out.
//! Invariant: all facets of a planar polygon share its plane to the bit.

use std::sync::Arc;

use bsdftree_device::Device;
use bsdftree_device::material::Material;
use bsdftree_device::mesh::Mesh;
use bsdftree_device::shape::Shape;
use glam::DVec3;

use super::NO_PART;
use super::analytic::Analytic;
use super::error::BvhError;
use super::facet::Facet;
use super::frame::Frame;

/// \[m\]. Beyond this, squares of lengths leave the range of f64.
const FARTHEST: f64 = 1e100;

/// Axis-aligned box, local units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub lower: [f32; 3],
    pub upper: [f32; 3],
}

impl Bounds {
    pub const EMPTY: Bounds = Bounds { lower: [f32::INFINITY; 3], upper: [f32::NEG_INFINITY; 3] };

    pub fn of(points: &[DVec3]) -> Bounds {
        points.iter().fold(Bounds::EMPTY, |b, p| {
            let p = p.as_vec3().to_array();
            b.union(&Bounds { lower: p, upper: p })
        })
    }

    #[inline]
    pub fn union(&self, other: &Bounds) -> Bounds {
        Bounds {
            lower: std::array::from_fn(|i| self.lower[i].min(other.lower[i])),
            upper: std::array::from_fn(|i| self.upper[i].max(other.upper[i])),
        }
    }

    pub fn extent(&self, axis: usize) -> f32 {
        self.upper[axis] - self.lower[axis]
    }

    /// Half the surface area; 0 if empty.
    #[inline]
    pub fn half_area(&self) -> f32 {
        let [x, y, z] = std::array::from_fn(|i| self.extent(i).max(0.0));
        x * y + y * z + z * x
    }
}

/// What the tracer needs of one triangle.
pub(super) struct Triangle {
    pub corners: [DVec3; 3],
    pub facet: Facet,
    pub part: u32,
}

/// A mesh of a device; its triangles are parts that follow one another.
#[derive(Clone, Debug)]
pub(super) struct MeshParts {
    /// Part of its first triangle.
    pub first: u32,
    /// Index into `Device::surfaces`.
    pub surface: u32,
    pub mesh: Arc<Mesh>,
}

/// Triangles and analytic surfaces, and the frame they are in.
pub(super) struct Primitives {
    pub frame: Frame,
    pub triangles: Vec<Triangle>,
    pub analytic: Vec<(Analytic, Bounds, u32)>,
    /// In the order of the surfaces, and so of their parts.
    pub meshes: Vec<MeshParts>,
    /// Parts so far: those of the surfaces themselves come first.
    n_parts: u64,
}

impl Primitives {
    pub fn gather(device: &Device) -> Result<Primitives, BvhError> {
        for (index, surface) in device.surfaces.iter().enumerate() {
            if device.materials.len() <= surface.material as usize {
                return Err(BvhError::NoSuchMaterial {
                    name: surface.name.clone(),
                    index,
                    material: surface.material,
                    n_materials: device.materials.len(),
                });
            }
            check(&surface.shape).map_err(|(what, found, expected)| BvhError::BadShape {
                name: surface.name.clone(),
                index,
                what,
                found,
                expected,
            })?;
        }
        let nothing = BvhError::NothingToHit { n_surfaces: device.surfaces.len() };
        let solid =
            || {
                device.surfaces.iter().enumerate().filter(|(_, s)| {
                    !matches!(device.materials[s.material as usize].material, Material::Void)
                })
            };
        let corners = solid()
            .map(|(_, s)| s.shape.bounds())
            .filter(|b| b[0].cmple(b[1]).all())
            .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
            .ok_or(nothing.clone())?;
        let frame = Frame::new(corners);
        let n_parts = device.surfaces.len() as u64;
        let mut found =
            Primitives { frame, triangles: Vec::new(), analytic: Vec::new(), meshes: Vec::new(), n_parts };
        for (index, surface) in solid() {
            found.add(&surface.shape, index as u32);
        }
        if found.n_parts > NO_PART as u64 {
            return Err(BvhError::TooMany { found: found.n_parts as usize, limit: NO_PART as usize });
        }
        if found.triangles.is_empty() && found.analytic.is_empty() {
            return Err(nothing);
        }
        Ok(found)
    }

    fn add(&mut self, shape: &Shape, surface: u32) {
        let frame = self.frame;
        let local = |p: DVec3| frame.local_from_device(p);
        let length = |r: f64| r * frame.inv_scale;
        let analytic = match shape {
            Shape::Polygon(corners) => {
                let corners: Vec<DVec3> = corners.iter().map(|&p| local(p)).collect();
                let plane = common_plane(&corners, frame.grain);
                for corners in shape.triangulate() {
                    let corners = corners.map(local);
                    if let Some(facet) = Facet::new(corners, plane) {
                        self.triangles.push(Triangle { corners, facet, part: surface });
                    }
                }
                return;
            }
            Shape::Mesh(mesh) => {
                // More than fit make `gather` fail.
                let first = self.n_parts as u32;
                self.n_parts += mesh.triangles.len() as u64;
                self.meshes.push(MeshParts { first, surface, mesh: mesh.clone() });
                for k in 0..mesh.triangles.len() {
                    let corners = mesh.corners(k).map(local);
                    if let Some(facet) = Facet::new(corners, None) {
                        self.triangles.push(Triangle { corners, facet, part: first.wrapping_add(k as u32) });
                    }
                }
                return;
            }
            Shape::Sphere { center, radius, inward } => {
                Analytic::Sphere { center: local(*center), radius: length(*radius), inward: *inward }
            }
            Shape::Cylinder { ends, radius, inward } => taper(ends.map(local), [length(*radius); 2], *inward),
            Shape::Cone { ends, radii, inward } => taper(ends.map(local), radii.map(length), *inward),
            Shape::Ring { center, normal, radii } => {
                let slack = 8.0 * frame.grain;
                Analytic::Ring {
                    center: local(*center),
                    normal: normal.normalize(),
                    radii_squared: [
                        (length(radii[0]) - slack).max(0.0).powi(2),
                        (length(radii[1]) + slack).powi(2),
                    ],
                }
            }
        };
        let bounds = Bounds::of(&shape.bounds().map(local));
        self.analytic.push((analytic, bounds, surface));
    }
}

/// Unit normal and a point of the plane all corners lie in to the precision of f64, or `None`: then each triangle keeps
/// its own plane, or its edges would part from those of its neighbours.
fn common_plane(corners: &[DVec3], grain: f64) -> Option<(DVec3, DVec3)> {
    let center = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let next = corners.iter().cycle().skip(1);
    let area: DVec3 = corners.iter().zip(next).map(|(a, b)| (a - center).cross(b - center)).sum();
    let normal = area.try_normalize()?;
    corners.iter().all(|c| normal.dot(c - center).abs() <= 4.0 * grain).then_some((normal, center))
}

fn taper(ends: [DVec3; 2], radii: [f64; 2], inward: bool) -> Analytic {
    let along = ends[1] - ends[0];
    let length = along.length();
    let slope = (radii[1] - radii[0]) / length;
    Analytic::Taper { base: ends[0], axis: along / length, length, radius: radii[0], slope, inward }
}

const SOUND: &str = "indices of vertices, and for every vertex a normal and texture coordinates, or for none";

type Fault = (&'static str, String, &'static str);

fn check(shape: &Shape) -> Result<(), Fault> {
    let point = |what, p: &DVec3| match p.is_finite() && p.abs().max_element() <= FARTHEST {
        true => Ok(()),
        false => Err((what, format!("{:?}", p.to_array()), "finite coordinates up to 1e100 m")),
    };
    let length = |what, r: f64, least: bool| match (0.0..=FARTHEST).contains(&r) && (least || r > 0.0) {
        true => Ok(()),
        false if least => Err((what, r.to_string(), "a length from 0 to 1e100 m")),
        false => Err((what, r.to_string(), "a length above 0, up to 1e100 m")),
    };
    let axis = |ends: &[DVec3; 2]| {
        ends.iter().try_for_each(|p| point("an end", p))?;
        length("the distance between its ends", ends[0].distance(ends[1]), false)
    };
    match shape {
        Shape::Polygon(corners) => corners.iter().try_for_each(|p| point("a vertex", p)),
        Shape::Sphere { center, radius, .. } => {
            point("the centre", center)?;
            length("the radius", *radius, false)
        }
        Shape::Cylinder { ends, radius, .. } => {
            axis(ends)?;
            length("the radius", *radius, false)
        }
        Shape::Cone { ends, radii, .. } => {
            axis(ends)?;
            radii.iter().try_for_each(|&r| length("a radius", r, true))?;
            length("the larger radius", radii[0].max(radii[1]), false)
        }
        Shape::Ring { center, normal, radii } => {
            point("the centre", center)?;
            point("the normal", normal)?;
            length("the length of the normal", normal.length(), false)?;
            length("the inner radius", radii[0], true)?;
            length("the outer radius", radii[1], false)
        }
        Shape::Mesh(mesh) if !mesh.is_sound() => {
            Err(("a list of indices, normals or texture coordinates", "one that does not fit".into(), SOUND))
        }
        Shape::Mesh(mesh) => {
            let used = mesh.triangles.iter().flatten();
            used.map(|&k| &mesh.vertices.positions[k as usize]).try_for_each(|p| point("a vertex", p))
        }
    }
}
