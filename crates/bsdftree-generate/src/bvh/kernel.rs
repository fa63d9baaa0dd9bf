//! The two f32 filters a ray runs through, and their portable form.
//!
//! Enters: a ray rounded to f32, a node or a leaf, a bound on t. Leaves: a bit for each child or triangle that *may* be met.
//! Invariant: a bit is set wherever the exact ray meets the exact box or triangle (see `node.rs` for the error bounds), so
//! implementations may round differently and results are the same bits.
//! Sources: Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, for the shear that makes an
//! edge the same for both its triangles. Deviation: a slack instead of a second evaluation, as f64 decides afterwards.

use glam::{DVec3, Vec3};

use super::node::{Leaf, Node, U, WIDTH};

/// Relative slack of t: rounding of shear, products and the bound itself is below 48 u.
pub(super) const T_SLACK: f32 = 64.0 * U;
/// Slack of t times determinant, in edge slacks: 6 for an edge-on triangle whose determinant has the wrong sign, at a depth
/// of at most 2, times √3 for the shear's unit; rounded up.
pub(super) const DEPTH_SLACK: f32 = 32.0;

/// A ray in the local frame, f32, with what both filters need.
#[derive(Clone, Copy, Debug)]
pub(super) struct FilterRay {
    pub origin: [f32; 3],
    pub inv_direction: [f32; 3],
    /// `origin · inv_direction`.
    pub scaled_origin: [f32; 3],
    /// Index into `Node::planes` of the planes met first and last.
    pub near: [usize; 3],
    pub far: [usize; 3],
    /// Axes with the main direction last.
    pub axes: [usize; 3],
    /// x and y per unit z, and ray length per unit z.
    pub shear: [f32; 3],
}

impl FilterRay {
    #[inline(always)]
    pub fn new(origin: DVec3, direction: DVec3) -> FilterRay {
        let origin: Vec3 = origin.as_vec3();
        let d = direction.as_vec3().to_array();
        let size = d.map(f32::abs);
        let main = if size[0] > size[1] {
            if size[0] > size[2] { 0 } else { 2 }
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][main];
        // A component of 0 would give 0 · ∞: at 2⁻⁶⁰ the ray is shifted by less than any rounding.
        let inv_direction = d.map(|c| 1.0 / c.abs().max(2f32.powi(-60)).copysign(c));
        let per_z = inv_direction[axes[2]];
        let origin = origin.to_array();
        let near: [usize; 3] = std::array::from_fn(|i| 2 * i + d[i].is_sign_negative() as usize);
        FilterRay {
            origin,
            inv_direction,
            scaled_origin: std::array::from_fn(|i| origin[i] * inv_direction[i]),
            near,
            far: near.map(|plane| plane ^ 1),
            axes,
            shear: [d[axes[0]] * per_z, d[axes[1]] * per_z, per_z],
        }
    }
}

/// One implementation of the filters.
pub(super) trait Kernel {
    /// # Safety
    /// The processor must have the features the implementation names.
    unsafe fn new(ray: &FilterRay) -> Self;

    /// Children whose box the ray meets at `0 ≤ t ≤ t_max`, and lower bounds of t there.
    ///
    /// # Safety
    /// As [`Kernel::new`].
    unsafe fn boxes(&self, node: &Node, t_max: f32, near: &mut [f32; WIDTH]) -> u32;

    /// Triangles the ray may meet at `0 ≤ t ≤ t_max`, except those of surface `from`.
    ///
    /// # Safety
    /// As [`Kernel::new`].
    unsafe fn triangles(&self, leaf: &Leaf, t_max: f32, from: u32) -> u32;
}

/// Plain Rust, for any processor.
pub(super) struct Portable(FilterRay);

type Lanes = [f32; WIDTH];

#[inline(always)]
fn lanes(f: impl Fn(usize) -> f32) -> Lanes {
    std::array::from_fn(f)
}

#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn bits(f: impl Fn(usize) -> bool) -> u32 {
    let set: [u8; WIDTH] = std::array::from_fn(|i| (f(i) as u8) << i);
    set.iter().fold(0, |all, bit| all | bit) as u32
}

impl Kernel for Portable {
    #[inline(always)]
    unsafe fn new(ray: &FilterRay) -> Portable {
        Portable(*ray)
    }

    #[inline(always)]
    unsafe fn boxes(&self, node: &Node, t_max: f32, near: &mut [f32; WIDTH]) -> u32 {
        let ray = &self.0;
        let mut far = [t_max; WIDTH];
        *near = [0.0; WIDTH];
        for axis in 0..3 {
            let (n, f) = (&node.planes[ray.near[axis]], &node.planes[ray.far[axis]]);
            let (inv, start) = (ray.inv_direction[axis], ray.scaled_origin[axis]);
            *near = lanes(|i| most(n[i] * inv - start, near[i]));
            far = lanes(|i| least(f[i] * inv - start, far[i]));
        }
        bits(|i| near[i] <= far[i])
    }

    #[inline(always)]
    unsafe fn triangles(&self, leaf: &Leaf, t_max: f32, from: u32) -> u32 {
        let ray = &self.0;
        let [kx, ky, kz] = ray.axes;
        let [sx, sy, sz] = ray.shear;
        let (ox, oy, oz) = (ray.origin[kx], ray.origin[ky], ray.origin[kz]);
        let z = leaf.corners.each_ref().map(|c| lanes(|i| c[kz][i] - oz));
        let x: [Lanes; 3] = std::array::from_fn(|c| lanes(|i| (leaf.corners[c][kx][i] - ox) - sx * z[c][i]));
        let y: [Lanes; 3] = std::array::from_fn(|c| lanes(|i| (leaf.corners[c][ky][i] - oy) - sy * z[c][i]));
        let edge = |a: usize, b: usize| lanes(|i| x[a][i] * y[b][i] - y[a][i] * x[b][i]);
        let (u, v, w) = (edge(1, 2), edge(2, 0), edge(0, 1));
        let inside = bits(|i| {
            let lowest = least(least(u[i], v[i]), w[i]);
            let highest = most(most(u[i], v[i]), w[i]);
            (lowest >= -leaf.slack[i]) | (highest <= leaf.slack[i])
        });
        if inside == 0 {
            return 0;
        }
        let det = lanes(|i| u[i] + v[i] + w[i]);
        let depth = lanes(|i| (u[i] * z[0][i] + v[i] * z[1][i] + w[i] * z[2][i]) * sz);
        inside
            & bits(|i| {
                let t_det = if det[i] < 0.0 { -depth[i] } else { depth[i] };
                let (det, slack) = (det[i].abs(), DEPTH_SLACK * leaf.slack[i]);
                (t_det <= det * (t_max + T_SLACK) + slack)
                    & (t_det >= -(det * T_SLACK + slack))
                    & (leaf.surfaces[i] != from)
            })
    }
}
