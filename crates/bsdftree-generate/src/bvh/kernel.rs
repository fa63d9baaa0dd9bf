//! The two f32 filters a ray runs through, and their portable form.
//!
//! Enters: a ray rounded to f32, a node or a leaf, a bound on t. Leaves: a bit for each child or triangle that *may* be met.
//! Invariant: a bit is set wherever the exact ray meets the exact box or triangle (see `node.rs` for the error bounds), so
//! implementations may round differently and results are the same bits.
//! Sources: Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, for the shear that makes an
//! edge the same for both its triangles. Deviation: a slack instead of a second evaluation, as f64 decides afterwards.

use glam::DVec3;

use super::facet::Facet;
use super::node::{Leaf, Node, U, WIDTH};

/// Relative slack of t: rounding of shear, products and the bound itself is below 48 u.
pub(super) const T_SLACK: f32 = 64.0 * U;
/// Slack of t times determinant, in edge slacks: 6 for an edge-on triangle whose determinant has the wrong sign, at a depth
/// of at most 2, times √3 for the shear's unit; rounded up.
pub(super) const DEPTH_SLACK: f32 = 32.0;

/// Smallest component of a direction: 0 would give 0 · ∞. At 2⁻⁶⁰ the ray is shifted by less than any rounding.
pub(super) const SMALLEST: f32 = 1.0 / (1u64 << 60) as f32;

/// By the signs of a direction, x in the low bit: indices into `Node::planes` of the planes met first, then of those met last.
pub(super) static PLANES: [[usize; 6]; 8] = {
    let mut table = [[0, 2, 4, 1, 3, 5]; 8];
    let mut signs = 0;
    while signs < 8 {
        let mut axis = 0;
        while axis < 3 {
            let negative = signs >> axis & 1;
            table[signs][axis] = 2 * axis + negative;
            table[signs][axis + 3] = 2 * axis + 1 - negative;
            axis += 1;
        }
        signs += 1;
    }
    table
};

/// By which components of a direction are largest, x in the low bit: the axes in cyclic order with one of those last, and
/// that one once more.
pub(super) static AXES: [[u32; 4]; 8] = {
    const X: [u32; 4] = [1, 2, 0, 0];
    const Y: [u32; 4] = [2, 0, 1, 1];
    const Z: [u32; 4] = [0, 1, 2, 2];
    [Z, X, Y, X, Z, X, Y, X]
};

/// One implementation of the filters.
pub(crate) trait Kernel {
    /// # Safety
    /// The processor must have the features the implementation names.
    unsafe fn new(origin: DVec3, direction: DVec3) -> Self;

    /// Children whose box the ray meets at `0 ≤ t ≤ t_max`, and lower bounds of t there.
    ///
    /// # Safety
    /// As [`Kernel::new`].
    unsafe fn boxes(&self, node: &Node, t_max: f32, near: &mut [f32; WIDTH]) -> u32;

    /// Triangles the ray may meet at `0 ≤ t ≤ t_max`, except those of part `from`.
    ///
    /// # Safety
    /// As [`Kernel::new`].
    unsafe fn triangles(&self, leaf: &Leaf, t_max: f32, from: u32) -> u32;

    /// [`Facet::hit`], to the bit.
    ///
    /// # Safety
    /// As [`Kernel::new`].
    #[inline(always)]
    unsafe fn facet(
        &self,
        facet: &Facet,
        origin: DVec3,
        direction: DVec3,
        t_max: f64,
        on_plane: f64,
        slack: f64,
    ) -> Option<f64> {
        facet.hit(origin, direction, t_max, on_plane, slack)
    }

    /// [`Facet::is_inside`], to the bit.
    ///
    /// # Safety
    /// As [`Kernel::new`].
    #[inline(always)]
    unsafe fn is_inside(&self, facet: &Facet, p: DVec3, inset: f64) -> bool {
        facet.is_inside(p, inset)
    }
}

/// Plain Rust, for any processor.
pub(crate) struct Portable {
    origin: [f32; 3],
    inv_direction: [f32; 3],
    /// `origin · inv_direction`.
    scaled_origin: [f32; 3],
    planes: &'static [usize; 6],
    axes: &'static [u32; 4],
    /// x and y per unit z, and ray length per unit z, in the order of `axes`.
    shear: [f32; 3],
}

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
    unsafe fn new(origin: DVec3, direction: DVec3) -> Portable {
        let origin = origin.as_vec3().to_array();
        let d = direction.as_vec3().to_array();
        let size = d.map(f32::abs);
        let largest = most(size[0], most(size[1], size[2]));
        let mask = |f: &dyn Fn(usize) -> bool| (0..3).fold(0, |mask, i| mask | usize::from(f(i)) << i);
        let axes = &AXES[mask(&|i| size[i] == largest)];
        let inv_direction = d.map(|c| 1.0 / most(c.abs(), SMALLEST).copysign(c));
        let [x, y, z, _] = axes.map(|axis| axis as usize);
        let per_z = inv_direction[z];
        Portable {
            origin,
            inv_direction,
            scaled_origin: std::array::from_fn(|i| origin[i] * inv_direction[i]),
            planes: &PLANES[mask(&|i| d[i].is_sign_negative())],
            axes,
            shear: [d[x] * per_z, d[y] * per_z, per_z],
        }
    }

    #[inline(always)]
    unsafe fn boxes(&self, node: &Node, t_max: f32, near: &mut [f32; WIDTH]) -> u32 {
        let mut far = [t_max; WIDTH];
        *near = [0.0; WIDTH];
        for axis in 0..3 {
            let (n, f) = (&node.planes[self.planes[axis]], &node.planes[self.planes[axis + 3]]);
            let (inv, start) = (self.inv_direction[axis], self.scaled_origin[axis]);
            *near = lanes(|i| most(n[i] * inv - start, near[i]));
            far = lanes(|i| least(f[i] * inv - start, far[i]));
        }
        bits(|i| near[i] <= far[i])
    }

    #[inline(always)]
    unsafe fn triangles(&self, leaf: &Leaf, t_max: f32, from: u32) -> u32 {
        let [kx, ky, kz, _] = self.axes.map(|axis| axis as usize);
        let [sx, sy, sz] = self.shear;
        let (ox, oy, oz) = (self.origin[kx], self.origin[ky], self.origin[kz]);
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
                    & (leaf.parts[i] != from)
            })
    }
}
