//! The ray tracer: closest hits on a [`Device`].
//!
//! Enters: a device, rays. Leaves: [`Hit`]s, in f64 and in metres.
//!
//! An 8-wide tree of f32 boxes and triangles filters out all but a few candidates; f64 arithmetic on the unrounded
//! geometry decides on those. The filters are proven never to lose a hit, so a result is a property of the device alone:
//! the same bits with AVX2 and without, for any tree, on any machine.
//!
//! No distance is "too small to hit". A ray says which surface it has left ([`Ray::from`]); a flat one cannot be met
//! again, a curved one only at its other root, and where a position lies on an edge it is moved inward by some roundings of
//! f64, so that the ray starts on the right side of the neighbours.

mod analytic;
#[cfg(target_arch = "x86_64")]
mod avx2;
mod collapse;
mod error;
mod facet;
mod frame;
mod kernel;
mod node;
mod primitives;
mod ray;
#[cfg(test)]
mod soundness;
mod split;
mod traverse;

use bsdftree_device::Device;
use bsdftree_device::mesh::MeshPoint;
use glam::DVec3;

use analytic::Analytic;
#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
pub use error::BvhError;
use facet::Facet;
use frame::Frame;
pub(crate) use kernel::{Kernel, Portable};
use node::{Child, Leaf, Node, WIDTH, edge_slack};
use primitives::{Bounds, MeshParts, Primitives, Triangle};
pub use ray::{Hit, Ray};

/// A tree of up to this size \[byte\] stays in the caches next to a core, where waiting costs less than asking.
const NEARBY: usize = 512 << 10;

/// No part of a device has this number.
const NO_PART: u32 = u32::MAX;

/// Which implementation of the filters runs. Results do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simd {
    /// Plain Rust.
    Portable,
    /// x86-64 with AVX2 and FMA.
    Avx2,
}

impl Simd {
    /// The fastest this processor has.
    pub fn detect() -> Simd {
        if Simd::Avx2.is_available() { Simd::Avx2 } else { Simd::Portable }
    }

    /// Whether this processor can run it.
    pub fn is_available(self) -> bool {
        match self {
            Simd::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Simd::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(not(target_arch = "x86_64"))]
            Simd::Avx2 => false,
        }
    }
}

/// A device ready to be traced.
///
/// ```
/// use bsdftree_device::{Device, NamedMaterial, Shape, Surface, material::Material};
/// use bsdftree_generate::bvh::{Bvh, Ray};
/// use glam::DVec3;
///
/// let ball = Shape::Sphere { center: DVec3::ZERO, radius: 1.0, inward: false };
/// let device = Device {
///     surfaces: vec![Surface { name: "ball".into(), shape: ball, material: 0 }],
///     materials: vec![NamedMaterial { name: "black".into(), material: Material::Black }],
///     ..Device::default()
/// };
/// let bvh = Bvh::build(&device)?;
/// let from_above = Ray { origin: DVec3::Z * 3.0, direction: -DVec3::Z, from: None };
/// let hit = bvh.closest(&from_above).expect("above the ball");
/// assert!((hit.t - 2.0).abs() < 1e-15 && hit.front && hit.normal == DVec3::Z);
/// let through = Ray { origin: hit.position, direction: -DVec3::Z, from: Some(hit.part) };
/// assert!(bvh.closest(&through).is_some_and(|far| !far.front));
/// # Ok::<(), bsdftree_generate::bvh::BvhError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bvh {
    frame: Frame,
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    facets: Vec<Facet>,
    analytic: Vec<(Analytic, u32)>,
    /// Material of each surface of the device.
    materials: Vec<u32>,
    /// Parts below this number are surfaces, others are triangles of meshes.
    n_surfaces: u32,
    /// By their parts.
    meshes: Vec<MeshParts>,
    simd: Simd,
    /// Whether it is worth asking for memory before it is needed.
    is_large: bool,
    /// An origin that has left a surface and is this near to a plane lies on it, local units.
    on_plane: f64,
    /// Overlap of neighbouring edges at normal incidence, local units.
    slack: f64,
    /// Least distance of a position from an edge, local units: far more than slack and `on_plane`.
    inset: f64,
}

impl Bvh {
    /// Build for a device. Void surfaces are left out. Takes about a second per million triangles and core.
    ///
    /// # Errors
    /// No surface that can be hit; a coordinate or radius that is not finite or out of range; a missing material; more
    /// than 2²⁷ primitives.
    pub fn build(device: &Device) -> Result<Bvh, BvhError> {
        let Primitives { frame, triangles, analytic, meshes, .. } = Primitives::gather(device)?;
        let n_primitives = triangles.len() + analytic.len();
        if n_primitives > Child::LIMIT {
            return Err(BvhError::TooMany { found: n_primitives, limit: Child::LIMIT });
        }
        let mut boxes: Vec<Bounds> = triangles.iter().map(|t| Bounds::of(&t.corners)).collect();
        boxes.extend(analytic.iter().map(|a| a.1));
        let wide = collapse::collapse(&split::binary_tree(&boxes), triangles.len());
        let mut facets = Vec::with_capacity(triangles.len());
        let leaves: Vec<Leaf> =
            wide.leaves.iter().map(|items| leaf(items, &triangles, &mut facets)).collect();
        let analytic = wide.analytic.iter().map(|&i| {
            let (shape, _, surface) = &analytic[i as usize - triangles.len()];
            (shape.clone(), *surface)
        });
        let analytic: Vec<(Analytic, u32)> = analytic.collect();
        let bytes = size_of_val(&wide.nodes[..])
            + size_of_val(&leaves[..])
            + size_of_val(&facets[..])
            + size_of_val(&analytic[..]);
        Ok(Bvh {
            frame,
            nodes: wide.nodes,
            leaves,
            facets,
            analytic,
            materials: device.surfaces.iter().map(|s| s.material).collect(),
            n_surfaces: device.surfaces.len() as u32,
            meshes,
            simd: Simd::detect(),
            is_large: bytes > NEARBY,
            on_plane: 4.0 * frame.grain,
            slack: 8.0 * frame.grain,
            inset: 4096.0 * frame.grain,
        })
    }

    /// The same with another implementation of the filters; `None` if this processor cannot run it.
    pub fn with_simd(mut self, simd: Simd) -> Option<Bvh> {
        self.simd = simd;
        simd.is_available().then_some(self)
    }

    /// Corners of what can be hit \[m\].
    pub fn bounds(&self) -> [DVec3; 2] {
        self.frame.bounds.map(|p| self.frame.device_from_local(p))
    }

    /// What the mesh that was met knows of that point: nothing, if it was no mesh.
    #[inline]
    pub fn mesh_point(&self, hit: &Hit) -> Option<MeshPoint> {
        if hit.part < self.n_surfaces {
            return None;
        }
        let MeshParts { first, mesh, .. } = self.mesh_of(hit.part);
        Some(mesh.at((hit.part - first) as usize, hit.position))
    }

    /// The number that [`Hit::part`] has on a surface, on this triangle if it is a mesh.
    pub(crate) fn part(&self, surface: u32, triangle: usize) -> u32 {
        match self.meshes.binary_search_by_key(&surface, |mesh| mesh.surface) {
            Ok(k) => self.meshes[k].first + triangle as u32,
            Err(_) => surface,
        }
    }

    /// The mesh that a part is a triangle of.
    #[cold]
    fn mesh_of(&self, part: u32) -> &MeshParts {
        &self.meshes[self.meshes.partition_point(|mesh| mesh.first <= part) - 1]
    }

    /// Which implementation runs.
    pub(crate) fn simd(&self) -> Simd {
        self.simd
    }

    /// [`Bvh::closest`] in the caller, which so shares registers and instructions with it.
    ///
    /// # Safety
    /// The processor must have the features `K` names.
    #[inline(always)]
    pub(crate) unsafe fn closest_by<K: Kernel>(&self, ray: &Ray) -> Option<Hit> {
        // SAFETY: passed on to the caller.
        unsafe { traverse::closest::<K>(self, ray) }
    }

    /// The first surface on a ray.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        match self.simd {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `simd` is set only after detection.
            Simd::Avx2 => unsafe { self.closest_avx2(ray) },
            _ => self.closest_portable(ray),
        }
    }

    /// # Safety
    /// The processor must have AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn closest_avx2(&self, ray: &Ray) -> Option<Hit> {
        // SAFETY: this function has the features of the kernel.
        unsafe { traverse::closest::<avx2::Avx2>(self, ray) }
    }

    #[inline(never)]
    fn closest_portable(&self, ray: &Ray) -> Option<Hit> {
        // SAFETY: the portable kernel needs nothing.
        unsafe { traverse::closest::<kernel::Portable>(self, ray) }
    }
}

fn leaf(items: &[u32], triangles: &[Triangle], facets: &mut Vec<Facet>) -> Leaf {
    debug_assert!(items.len() <= WIDTH);
    let mut leaf = Leaf { first: facets.len() as u32, ..Leaf::default() };
    for (lane, &item) in items.iter().enumerate() {
        let triangle = &triangles[item as usize];
        for (corner, p) in triangle.corners.iter().enumerate() {
            for axis in 0..3 {
                leaf.corners[corner][axis][lane] = p[axis] as f32;
            }
        }
        let bounds = Bounds::of(&triangle.corners);
        let extent = (0..3).map(|axis| bounds.extent(axis)).fold(0.0, f32::max);
        leaf.slack[lane] = edge_slack(extent + 4.0 * node::U);
        leaf.parts[lane] = triangle.part;
        facets.push(triangle.facet.clone());
    }
    leaf
}
