//! The walk through the tree: filters in f32 choose, f64 decides.
//!
//! Enters: a ray. Leaves: the surface with the least (t, index) among all that f64 arithmetic meets. As filters lose
//! nothing, this does not depend on the order of the walk, the shape of the tree, or the kernel.

use std::mem::MaybeUninit;

use glam::DVec3;

use super::analytic::Query;
use super::kernel::{FilterRay, Kernel};
use super::node::{Child, Target, WIDTH};
use super::ray::{Hit, Ray};
use super::{Bvh, NO_SURFACE};

/// Room for 7 waiting siblings on each of 73 levels; `split.rs` keeps trees below 36 + 27.
const STACK: usize = 512;

/// Most leaves have no more facets than this.
const N_PREFETCHED: usize = 6;

/// No hit is this far, local units. Not infinite: times a determinant of 0 it must not be NaN in the filters.
const FARTHEST: f64 = 1e30;

/// What is met so far, in the local frame.
struct Nearest {
    t: f64,
    surface: u32,
    /// Facet, or `!index` of an analytic surface.
    primitive: u32,
}

/// A ray brought into the local frame and up to the device's box.
pub(super) struct LocalRay {
    pub origin: DVec3,
    pub direction: DVec3,
    /// Distance \[m\] skipped in front of the box.
    pub skipped: f64,
    /// Surface just left, or [`NO_SURFACE`].
    pub from: u32,
}

impl LocalRay {
    /// `None` if the ray misses the device's box or is not finite.
    #[inline(always)]
    pub fn new(bvh: &Bvh, ray: &Ray) -> Option<LocalRay> {
        let origin = bvh.frame.local_from_device(ray.origin);
        let [low, high] = bvh.frame.bounds;
        let from = ray.from.unwrap_or(NO_SURFACE);
        if (origin.cmpge(low) & origin.cmple(high)).all() {
            return Some(LocalRay { origin, direction: ray.direction, skipped: 0.0, from });
        }
        let (origin, skipped) = bvh.frame.approach(ray)?;
        Some(LocalRay { origin, direction: ray.direction, skipped, from })
    }
}

/// The first hit.
///
/// # Safety
/// The processor must have the features `K` names.
#[inline(always)]
pub(super) unsafe fn closest<K: Kernel>(bvh: &Bvh, ray: &Ray) -> Option<Hit> {
    let local = LocalRay::new(bvh, ray)?;
    let mut best = Nearest { t: FARTHEST, surface: NO_SURFACE, primitive: 0 };
    // SAFETY: passed on to the caller.
    unsafe { walk::<K>(bvh, &local, &mut best) };
    (best.surface != NO_SURFACE).then(|| bvh.describe(ray, &local, &best))
}

/// # Safety
/// As [`closest`].
#[inline(always)]
unsafe fn walk<K: Kernel>(bvh: &Bvh, ray: &LocalRay, best: &mut Nearest) {
    // SAFETY: `K`'s features are the caller's promise. Indices come from the builder, which put every child there. The
    // stack holds what it was given before it is read, and cannot overflow: see STACK.
    unsafe {
        let kernel = K::new(&FilterRay::new(ray.origin, ray.direction));
        // An entry is the bits of a lower bound of t ≥ 0, which sort as integers, above the child.
        let mut stack = [MaybeUninit::<u64>::uninit(); STACK];
        let mut height = 0;
        let mut entry = 0u64;
        let mut near = [0.0f32; WIDTH];
        loop {
            match Child(entry as u32).target() {
                Target::Node(index) => {
                    let node = bvh.nodes.get_unchecked(index);
                    let mut hits = kernel.boxes(node, best.t as f32, &mut near);
                    if hits != 0 {
                        let base = height;
                        while hits != 0 {
                            let lane = hits.trailing_zeros() as usize & (WIDTH - 1);
                            hits &= hits - 1;
                            bvh.prefetch(node.children[lane]);
                            let key = (near[lane].to_bits() as u64) << 32 | node.children[lane].0 as u64;
                            // Insert so that the nearest lies on top.
                            let mut k = height;
                            while k > base && stack.get_unchecked(k - 1).assume_init() < key {
                                *stack.get_unchecked_mut(k) = *stack.get_unchecked(k - 1);
                                k -= 1;
                            }
                            *stack.get_unchecked_mut(k) = MaybeUninit::new(key);
                            height += 1;
                        }
                        height -= 1;
                        entry = stack.get_unchecked(height).assume_init();
                        continue;
                    }
                }
                Target::Leaf(index) => {
                    let leaf = bvh.leaves.get_unchecked(index);
                    prefetch(&bvh.facets, leaf.first as usize, N_PREFETCHED);
                    let mut hits = kernel.triangles(leaf, best.t as f32, ray.from);
                    while hits != 0 {
                        let lane = hits.trailing_zeros() as usize & (WIDTH - 1);
                        hits &= hits - 1;
                        bvh.decide_facet(ray, leaf.first as usize + lane, leaf.surfaces[lane], best);
                    }
                }
                Target::Analytic(first, count) => {
                    for index in first..first + count {
                        bvh.decide_analytic(ray, index, best);
                    }
                }
            }
            loop {
                if height == 0 {
                    return;
                }
                height -= 1;
                entry = stack.get_unchecked(height).assume_init();
                if f32::from_bits((entry >> 32) as u32) <= best.t as f32 {
                    break;
                }
            }
        }
    }
}

/// Ask for items that are soon needed; waiting for memory is most of the time in a large mesh.
#[inline(always)]
fn prefetch<T>(items: &[T], first: usize, count: usize) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..(count * size_of::<T>()).div_ceil(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let place = items.as_ptr().wrapping_add(first).cast::<i8>().wrapping_add(64 * line);
        // SAFETY: a prefetch may name any address; SSE is part of x86-64.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(place) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (items, first, count);
}

impl Bvh {
    #[inline(always)]
    fn prefetch(&self, child: Child) {
        match child.target() {
            Target::Node(index) => prefetch(&self.nodes, index, 1),
            Target::Leaf(index) => prefetch(&self.leaves, index, 1),
            Target::Analytic(first, _) => prefetch(&self.analytic, first, 1),
        }
    }

    #[inline(always)]
    fn decide_facet(&self, ray: &LocalRay, index: usize, surface: u32, best: &mut Nearest) {
        let on_plane = if ray.from == NO_SURFACE { 0.0 } else { self.on_plane };
        // SAFETY: leaves name only facets the builder wrote.
        let facet = unsafe { self.facets.get_unchecked(index) };
        if let Some(t) = facet.hit(ray.origin, ray.direction, best.t, on_plane, self.slack) {
            best.take(t, surface, index as u32);
        }
    }

    fn decide_analytic(&self, ray: &LocalRay, index: usize, best: &mut Nearest) {
        let (shape, surface) = &self.analytic[index];
        let query = Query {
            origin: ray.origin,
            direction: ray.direction,
            t_max: best.t,
            leaving: *surface == ray.from,
            on_plane: if ray.from == NO_SURFACE { 0.0 } else { self.on_plane },
            slack: self.slack,
        };
        if let Some(t) = shape.hit(&query) {
            best.take(t, *surface, !(index as u32));
        }
    }

    #[inline(always)]
    fn describe(&self, ray: &Ray, local: &LocalRay, best: &Nearest) -> Hit {
        let t = best.t * self.frame.scale + local.skipped;
        let p = local.origin + local.direction * best.t;
        let material = self.materials[best.surface as usize];
        let mut position = ray.origin + ray.direction * t;
        let normal = if best.primitive as i32 >= 0 {
            let facet = &self.facets[best.primitive as usize];
            if !facet.is_inside(p, self.inset) {
                position += (facet.inset(p, self.inset) - p) * self.frame.scale;
            }
            facet.normal()
        } else {
            let (shape, _) = &self.analytic[!best.primitive as usize];
            position += (shape.inset(p, self.inset) - p) * self.frame.scale;
            shape.normal(p)
        };
        Hit { t, position, normal, front: normal.dot(ray.direction) < 0.0, surface: best.surface, material }
    }
}

impl Nearest {
    #[inline(always)]
    fn take(&mut self, t: f64, surface: u32, primitive: u32) {
        if t < self.t || (t == self.t && surface < self.surface) {
            *self = Nearest { t, surface, primitive };
        }
    }
}
