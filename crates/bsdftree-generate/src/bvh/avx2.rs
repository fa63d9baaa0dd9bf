//! The filters of `kernel.rs` in AVX2 and FMA: one register holds all eight lanes.
//!
//! Safety throughout: the caller runs inside a function with `#[target_feature(enable = "avx2,fma")]`, into which these
//! bodies are inlined.

use std::arch::x86_64::*;

use super::kernel::{DEPTH_SLACK, FilterRay, Kernel, T_SLACK};
use super::node::{Leaf, Node, WIDTH};

/// AVX2 and FMA.
pub(super) struct Avx2 {
    ray: FilterRay,
    inv_direction: [__m256; 3],
    scaled_origin: [__m256; 3],
}

/// # Safety
/// Needs AVX.
#[inline(always)]
unsafe fn load(lanes: &[f32; WIDTH]) -> __m256 {
    // SAFETY: the reference covers eight f32; unaligned loads have no further condition.
    unsafe { _mm256_loadu_ps(lanes.as_ptr()) }
}

impl Kernel for Avx2 {
    #[inline(always)]
    unsafe fn new(ray: &FilterRay) -> Avx2 {
        // SAFETY: the caller has AVX2 and FMA.
        unsafe {
            let spread = |v: [f32; 3]| [_mm256_set1_ps(v[0]), _mm256_set1_ps(v[1]), _mm256_set1_ps(v[2])];
            Avx2 {
                ray: *ray,
                inv_direction: spread(ray.inv_direction),
                scaled_origin: spread(ray.scaled_origin),
            }
        }
    }

    #[inline(always)]
    unsafe fn boxes(&self, node: &Node, t_max: f32, near: &mut [f32; WIDTH]) -> u32 {
        // SAFETY: the caller has AVX2 and FMA; plane indices are below 6 by construction.
        unsafe {
            let [ix, iy, iz] = self.inv_direction;
            let [sx, sy, sz] = self.scaled_origin;
            let plane = |k: usize| load(node.planes.get_unchecked(k));
            let near_x = _mm256_fmsub_ps(plane(self.ray.near[0]), ix, sx);
            let near_y = _mm256_fmsub_ps(plane(self.ray.near[1]), iy, sy);
            let near_z = _mm256_fmsub_ps(plane(self.ray.near[2]), iz, sz);
            let far_x = _mm256_fmsub_ps(plane(self.ray.far[0]), ix, sx);
            let far_y = _mm256_fmsub_ps(plane(self.ray.far[1]), iy, sy);
            let far_z = _mm256_fmsub_ps(plane(self.ray.far[2]), iz, sz);
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
            let ray = &self.ray;
            let [kx, ky, kz] = ray.axes;
            let axis_origin = |k: usize| _mm256_set1_ps(*ray.origin.get_unchecked(k));
            let (ox, oy, oz) = (axis_origin(kx), axis_origin(ky), axis_origin(kz));
            let [sx, sy, sz] =
                [_mm256_set1_ps(ray.shear[0]), _mm256_set1_ps(ray.shear[1]), _mm256_set1_ps(ray.shear[2])];
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
            if _mm256_movemask_ps(inside) == 0 {
                return 0;
            }
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
            let surfaces = _mm256_loadu_si256(leaf.surfaces.as_ptr().cast());
            let left = _mm256_castsi256_ps(_mm256_cmpeq_epi32(surfaces, _mm256_set1_epi32(from as i32)));
            _mm256_movemask_ps(_mm256_andnot_ps(left, _mm256_and_ps(inside, in_range))) as u32
        }
    }
}
