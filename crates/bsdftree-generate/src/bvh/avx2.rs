//! The filters of `kernel.rs` in AVX2 and FMA: one register holds all eight lanes.
//!
//! Safety throughout: the caller runs inside a function with `#[target_feature(enable = "avx2,fma")]`, into which these
//! bodies are inlined.

use std::arch::x86_64::*;

use glam::DVec3;

use super::facet::{Facet, WIDEST_SLACK};
use super::kernel::{AXES, DEPTH_SLACK, Kernel, PLANES, SMALLEST, T_SLACK};
use super::node::{Leaf, Node, WIDTH};

/// AVX2 and FMA.
pub(crate) struct Avx2 {
    inv_direction: [__m256; 3],
    scaled_origin: [__m256; 3],
    /// Planes met first, then those met last.
    planes: &'static [usize; 6],
    /// Axes with the main direction last; origin and shear in that order.
    axes: &'static [u32; 4],
    origin: [f32; 4],
    shear: [f32; 4],
}

/// # Safety
/// Needs AVX.
#[inline(always)]
unsafe fn load(lanes: &[f32; WIDTH]) -> __m256 {
    // SAFETY: the reference covers eight f32; unaligned loads have no further condition.
    unsafe { _mm256_loadu_ps(lanes.as_ptr()) }
}

/// # Safety
/// Needs AVX.
#[inline(always)]
unsafe fn single(v: DVec3) -> __m128 {
    // SAFETY: the caller has AVX.
    unsafe {
        // In two parts, as the vector was written: one load of all would wait for both.
        let xy = _mm_cvtpd_ps(_mm_set_pd(v.y, v.x));
        _mm_movelh_ps(xy, _mm_cvtsd_ss(_mm_setzero_ps(), _mm_set_sd(v.z)))
    }
}

/// # Safety
/// Needs AVX.
#[inline(always)]
unsafe fn load4(row: &[f64; 4]) -> __m256d {
    // SAFETY: the reference covers four f64; unaligned loads have no further condition.
    unsafe { _mm256_loadu_pd(row.as_ptr()) }
}

/// The rows of a facet that are edges.
const EDGES: i32 = 0b1110;

/// Signed distances of a point from the planes of a facet.
///
/// # Safety
/// Needs AVX.
#[inline(always)]
unsafe fn distances(facet: &Facet, p: DVec3) -> __m256d {
    // SAFETY: the caller has AVX.
    unsafe {
        let x = _mm256_mul_pd(load4(&facet.x), _mm256_set1_pd(p.x));
        let y = _mm256_mul_pd(load4(&facet.y), _mm256_set1_pd(p.y));
        let z = _mm256_mul_pd(load4(&facet.z), _mm256_set1_pd(p.z));
        _mm256_add_pd(_mm256_add_pd(x, y), _mm256_add_pd(z, load4(&facet.w)))
    }
}

impl Kernel for Avx2 {
    #[inline(always)]
    unsafe fn new(origin: DVec3, direction: DVec3) -> Avx2 {
        // SAFETY: the caller has AVX2 and FMA; a mask of three bits is an index below 8.
        unsafe {
            let minus = _mm_set1_ps(-0.0);
            let (o, d) = (single(origin), single(direction));
            let size = _mm_andnot_ps(minus, d);
            let size_yzx = _mm_shuffle_ps::<0b11_00_10_01>(size, size);
            let size_zxy = _mm_shuffle_ps::<0b11_01_00_10>(size, size);
            let largest = _mm_max_ps(size, _mm_max_ps(size_yzx, size_zxy));
            let main = _mm_movemask_ps(_mm_cmpeq_ps(size, largest)) as usize & 7;
            let axes = &AXES[main];
            let nonzero = _mm_or_ps(_mm_max_ps(size, _mm_set1_ps(SMALLEST)), _mm_and_ps(d, minus));
            let inv = _mm_div_ps(_mm_set1_ps(1.0), nonzero);
            let scaled = _mm_mul_ps(o, inv);
            let order = _mm_loadu_si128(axes.as_ptr().cast());
            let per_z = _mm_permutevar_ps(inv, _mm_shuffle_epi32::<0b10_10_10_10>(order));
            // Ray length per unit z takes the place of the last component, which is 1.
            let unit = _mm_blend_ps::<0b1100>(_mm_permutevar_ps(d, order), _mm_set1_ps(1.0));
            let mut kernel = Avx2 {
                inv_direction: [
                    _mm256_broadcastss_ps(inv),
                    _mm256_broadcastss_ps(_mm_movehdup_ps(inv)),
                    _mm256_broadcastss_ps(_mm_movehl_ps(inv, inv)),
                ],
                scaled_origin: [
                    _mm256_broadcastss_ps(scaled),
                    _mm256_broadcastss_ps(_mm_movehdup_ps(scaled)),
                    _mm256_broadcastss_ps(_mm_movehl_ps(scaled, scaled)),
                ],
                planes: &PLANES[_mm_movemask_ps(d) as usize & 7],
                axes,
                origin: [0.0; 4],
                shear: [0.0; 4],
            };
            _mm_storeu_ps(kernel.origin.as_mut_ptr(), _mm_permutevar_ps(o, order));
            _mm_storeu_ps(kernel.shear.as_mut_ptr(), _mm_mul_ps(unit, per_z));
            kernel
        }
    }

    #[inline(always)]
    unsafe fn boxes(&self, node: &Node, t_max: f32, near: &mut [f32; WIDTH]) -> u32 {
        // SAFETY: the caller has AVX2 and FMA; plane indices are below 6 by construction.
        unsafe {
            let [ix, iy, iz] = self.inv_direction;
            let [sx, sy, sz] = self.scaled_origin;
            let plane = |k: usize| load(node.planes.get_unchecked(self.planes[k]));
            let near_x = _mm256_fmsub_ps(plane(0), ix, sx);
            let near_y = _mm256_fmsub_ps(plane(1), iy, sy);
            let near_z = _mm256_fmsub_ps(plane(2), iz, sz);
            let far_x = _mm256_fmsub_ps(plane(3), ix, sx);
            let far_y = _mm256_fmsub_ps(plane(4), iy, sy);
            let far_z = _mm256_fmsub_ps(plane(5), iz, sz);
            // Zero comes second, so that −0 does not become a bound: its bits would sort last.
            let enter =
                _mm256_max_ps(_mm256_max_ps(near_x, near_y), _mm256_max_ps(near_z, _mm256_setzero_ps()));
            let leave =
                _mm256_min_ps(_mm256_min_ps(far_x, far_y), _mm256_min_ps(far_z, _mm256_set1_ps(t_max)));
            _mm256_storeu_ps(near.as_mut_ptr(), enter);
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u32
        }
    }

    #[inline(always)]
    unsafe fn triangles(&self, leaf: &Leaf, t_max: f32, from: u32) -> u32 {
        // SAFETY: the caller has AVX2 and FMA; axes are below 3 by construction.
        unsafe {
            let (kx, ky, kz) = (self.axes[0] as usize, self.axes[1] as usize, self.axes[2] as usize);
            let (o, s) = (&self.origin, &self.shear);
            let (ox, oy, oz) =
                (_mm256_broadcast_ss(&o[0]), _mm256_broadcast_ss(&o[1]), _mm256_broadcast_ss(&o[2]));
            let (sx, sy, sz) =
                (_mm256_broadcast_ss(&s[0]), _mm256_broadcast_ss(&s[1]), _mm256_broadcast_ss(&s[2]));
            let corner = |c: usize| {
                let corner = leaf.corners.get_unchecked(c);
                let z = _mm256_sub_ps(load(corner.get_unchecked(kz)), oz);
                let x = _mm256_fnmadd_ps(sx, z, _mm256_sub_ps(load(corner.get_unchecked(kx)), ox));
                let y = _mm256_fnmadd_ps(sy, z, _mm256_sub_ps(load(corner.get_unchecked(ky)), oy));
                (x, y, z)
            };
            let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (corner(0), corner(1), corner(2));
            let u = _mm256_fmsub_ps(bx, cy, _mm256_mul_ps(by, cx));
            let v = _mm256_fmsub_ps(cx, ay, _mm256_mul_ps(cy, ax));
            let w = _mm256_fmsub_ps(ax, by, _mm256_mul_ps(ay, bx));
            let slack = load(&leaf.slack);
            let minus = _mm256_set1_ps(-0.0);
            let lowest = _mm256_min_ps(_mm256_min_ps(u, v), w);
            let highest = _mm256_max_ps(_mm256_max_ps(u, v), w);
            let inside = _mm256_or_ps(
                _mm256_cmp_ps::<_CMP_GE_OQ>(lowest, _mm256_xor_ps(slack, minus)),
                _mm256_cmp_ps::<_CMP_LE_OQ>(highest, slack),
            );
            let parts = _mm256_loadu_si256(leaf.parts.as_ptr().cast());
            let left = _mm256_castsi256_ps(_mm256_cmpeq_epi32(parts, _mm256_set1_epi32(from as i32)));
            let inside = _mm256_andnot_ps(left, inside);
            let det = _mm256_add_ps(_mm256_add_ps(u, v), w);
            let depth = _mm256_fmadd_ps(u, az, _mm256_fmadd_ps(v, bz, _mm256_mul_ps(w, cz)));
            let t_det = _mm256_xor_ps(_mm256_mul_ps(depth, sz), _mm256_and_ps(det, minus));
            let det = _mm256_andnot_ps(minus, det);
            let slack_t = _mm256_mul_ps(_mm256_set1_ps(DEPTH_SLACK), slack);
            let upper = _mm256_fmadd_ps(det, _mm256_set1_ps(t_max + T_SLACK), slack_t);
            let lower = _mm256_fmadd_ps(det, _mm256_set1_ps(T_SLACK), slack_t);
            let in_range = _mm256_and_ps(
                _mm256_cmp_ps::<_CMP_LE_OQ>(t_det, upper),
                _mm256_cmp_ps::<_CMP_GE_OQ>(t_det, _mm256_xor_ps(lower, minus)),
            );
            _mm256_movemask_ps(_mm256_and_ps(inside, in_range)) as u32
        }
    }

    // Products and sums apart and in the order of `Facet`, for the same bits.
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
        // SAFETY: the caller has AVX2 and FMA.
        unsafe {
            let height = distances(facet, origin);
            let rows = [load4(&facet.x), load4(&facet.y), load4(&facet.z)];
            let slope = _mm256_add_pd(
                _mm256_add_pd(
                    _mm256_mul_pd(rows[0], _mm256_set1_pd(direction.x)),
                    _mm256_mul_pd(rows[1], _mm256_set1_pd(direction.y)),
                ),
                _mm256_mul_pd(rows[2], _mm256_set1_pd(direction.z)),
            );
            let plane = _mm256_cvtsd_f64(height);
            let inv = 1.0 / _mm256_cvtsd_f64(slope);
            let t = -plane * inv;
            let slack = -(slack * inv.abs()).min(WIDEST_SLACK);
            let there = _mm256_add_pd(height, _mm256_mul_pd(_mm256_set1_pd(t), slope));
            let inside = _mm256_cmp_pd::<_CMP_GE_OQ>(there, _mm256_set1_pd(slack));
            let inside = _mm256_movemask_pd(inside) & EDGES == EDGES;
            (inside & (t >= 0.0) & (t <= t_max) & (plane.abs() >= on_plane)).then_some(t)
        }
    }

    #[inline(always)]
    unsafe fn is_inside(&self, facet: &Facet, p: DVec3, inset: f64) -> bool {
        // SAFETY: the caller has AVX2 and FMA.
        unsafe {
            let inside = _mm256_cmp_pd::<_CMP_GE_OQ>(distances(facet, p), _mm256_set1_pd(inset));
            _mm256_movemask_pd(inside) & EDGES == EDGES
        }
    }
}
