//! The walk through the tree: filters in f32 choose, f64 decides.
//!
//! Enters: a ray. Leaves: the surface with the least (t, part) among all that f64 arithmetic meets. As filters lose
//! nothing, this does not depend on the order of the walk, the shape of the tree, or the kernel.

use std::mem::MaybeUninit;

use glam::DVec3;

use super::analytic::Query;
use super::frame::Frame;
use super::kernel::Kernel;
use super::node::{Child, Target, WIDTH};
use super::ray::{Hit, Ray};
use super::{Bvh, NO_PART};

/// Room for 7 waiting siblings on each of 73 levels; `split.rs` keeps trees below 36 + 27.
const STACK: usize = 512;

/// Most leaves have no more facets than this.
const N_PREFETCHED: usize = 6;

/// No hit is this far, local units. Not infinite: times a determinant of 0 it must not be NaN in the filters.
const FARTHEST: f64 = 1e30;

/// What is met so far, in the local frame.
#[derive(Clone, Copy)]
struct Nearest {
    t: f64,
    part: u32,
    /// Facet, or `!index` of an analytic surface.
    primitive: u32,
}

/// A ray brought into the local frame and up to the device's box.
pub(super) struct LocalRay<'a> {
    /// As it was asked for; directions are the same in both frames.
    pub ray: &'a Ray,
    pub origin: DVec3,
    /// Distance \[m\] skipped in front of the box.
    pub skipped: f64,
    /// Part just left, or [`NO_PART`].
    pub from: u32,
}

impl<'a> LocalRay<'a> {
    /// `None` if the ray misses the device's box or is not finite.
    #[inline(always)]
    pub fn new(bvh: &Bvh, ray: &'a Ray) -> Option<LocalRay<'a>> {
        let origin = bvh.frame.local_from_device(ray.origin);
        let from = ray.from.unwrap_or(NO_PART);
        if Frame::is_near(origin) {
            return Some(LocalRay { ray, origin, skipped: 0.0, from });
        }
        let (origin, skipped) = bvh.frame.approach(ray)?;
        Some(LocalRay { ray, origin, skipped, from })
    }
}

/// The first hit.
///
/// # Safety
/// The processor must have the features `K` names.
#[inline(always)]
pub(super) unsafe fn closest<K: Kernel>(bvh: &Bvh, ray: &Ray) -> Option<Hit> {
    let local = LocalRay::new(bvh, ray)?;
    // SAFETY: passed on to the caller.
    unsafe {
        let kernel = K::new(local.origin, ray.direction);
        let best = walk(bvh, &kernel, &local);
        if best.part == NO_PART {
            return None;
        }
        Some(bvh.describe(&kernel, &local, best))
    }
}

/// # Safety
/// As [`closest`].
#[inline(always)]
unsafe fn walk<K: Kernel>(bvh: &Bvh, kernel: &K, ray: &LocalRay) -> Nearest {
    // SAFETY: `K`'s features are the caller's promise. Indices come from the builder, which put every child there. The
    // stack holds what it was given before it is read, and cannot overflow: see STACK.
    unsafe {
        let mut best = Nearest { t: FARTHEST, part: NO_PART, primitive: 0 };
        let mut limit = best.t as f32;
        let on_plane = if ray.from == NO_PART { 0.0 } else { bvh.on_plane };
        // An entry is the bits of a lower bound of t ≥ 0, which sort as integers, above the child.
        let mut stack = [MaybeUninit::<u64>::uninit(); STACK];
        let mut height = 0;
        let mut child = Child::node(0);
        let mut near = [0.0f32; WIDTH];
        loop {
            match child.target() {
                Target::Node(index) => {
                    let node = bvh.nodes.get_unchecked(index);
                    let hits = kernel.boxes(node, limit, &mut near);
                    if hits != 0 {
                        let entry = |hits: u32| {
                            let lane = hits.trailing_zeros() as usize & (WIDTH - 1);
                            let child = node.children[lane];
                            bvh.prefetch(child);
                            (near[lane].to_bits() as u64) << 32 | child.0 as u64
                        };
                        let first = entry(hits);
                        let mut hits = hits & (hits - 1);
                        if hits == 0 {
                            child = Child(first as u32);
                            continue;
                        }
                        let second = entry(hits);
                        hits &= hits - 1;
                        let base = height;
                        *stack.get_unchecked_mut(height) = MaybeUninit::new(first.max(second));
                        height += 1;
                        let mut nearest = first.min(second);
                        while hits != 0 {
                            let next = entry(hits);
                            hits &= hits - 1;
                            // Insert so that the nearer lie higher.
                            let key = nearest.max(next);
                            nearest = nearest.min(next);
                            let mut k = height;
                            while k > base && stack.get_unchecked(k - 1).assume_init() < key {
                                *stack.get_unchecked_mut(k) = *stack.get_unchecked(k - 1);
                                k -= 1;
                            }
                            *stack.get_unchecked_mut(k) = MaybeUninit::new(key);
                            height += 1;
                        }
                        child = Child(nearest as u32);
                        continue;
                    }
                }
                Target::Leaf(index) => {
                    let leaf = bvh.leaves.get_unchecked(index);
                    if bvh.is_large {
                        prefetch(&bvh.facets, leaf.first as usize, N_PREFETCHED);
                    }
                    let mut hits = kernel.triangles(leaf, limit, ray.from);
                    while hits != 0 {
                        let lane = hits.trailing_zeros() as usize & (WIDTH - 1);
                        hits &= hits - 1;
                        let facet = leaf.first + lane as u32;
                        let direction = ray.ray.direction;
                        let found = kernel.facet(
                            bvh.facets.get_unchecked(facet as usize),
                            ray.origin,
                            direction,
                            best.t,
                            on_plane,
                            bvh.slack,
                        );
                        if let Some(t) = found {
                            best = best.or(t, leaf.parts[lane], facet);
                            limit = best.t as f32;
                        }
                    }
                }
                Target::Analytic(first, count) => {
                    for index in first..first + count {
                        best = bvh.decide_analytic(ray, index, best);
                    }
                    limit = best.t as f32;
                }
            }
            loop {
                if height == 0 {
                    return best;
                }
                height -= 1;
                let entry = stack.get_unchecked(height).assume_init();
                if f32::from_bits((entry >> 32) as u32) <= limit {
                    child = Child(entry as u32);
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
        if !self.is_large {
            return;
        }
        match child.target() {
            Target::Node(index) => prefetch(&self.nodes, index, 1),
            Target::Leaf(index) => prefetch(&self.leaves, index, 1),
            Target::Analytic(first, _) => prefetch(&self.analytic, first, 1),
        }
    }

    #[inline(never)]
    fn decide_analytic(&self, ray: &LocalRay, index: usize, best: Nearest) -> Nearest {
        let (shape, surface) = &self.analytic[index];
        let query = Query {
            origin: ray.origin,
            direction: ray.ray.direction,
            t_max: best.t,
            leaving: *surface == ray.from,
            on_plane: if ray.from == NO_PART { 0.0 } else { self.on_plane },
            slack: self.slack,
        };
        match shape.hit(&query) {
            Some(t) => best.or(t, *surface, !(index as u32)),
            None => best,
        }
    }

    #[inline(always)]
    unsafe fn describe<K: Kernel>(&self, kernel: &K, local: &LocalRay, best: Nearest) -> Hit {
        let (origin, direction) = (local.ray.origin, local.ray.direction);
        let t = best.t * self.frame.scale + local.skipped;
        let p = local.origin + direction * best.t;
        let part = best.part;
        let surface = if part < self.n_surfaces { part } else { self.mesh_of(part).surface };
        let material = self.materials[surface as usize];
        let mut position = origin + direction * t;
        if best.primitive as i32 >= 0 {
            let facet = &self.facets[best.primitive as usize];
            // SAFETY: passed on to the caller.
            if !unsafe { kernel.is_inside(facet, p, self.inset) } {
                position += (facet.inset(p, self.inset) - p) * self.frame.scale;
            }
            let normal = facet.normal();
            return Hit { t, position, normal, front: normal.dot(direction) < 0.0, surface, part, material };
        }
        let (shape, _) = &self.analytic[!best.primitive as usize];
        position += (shape.inset(p, self.inset) - p) * self.frame.scale;
        let normal = shape.normal(p);
        Hit { t, position, normal, front: normal.dot(direction) < 0.0, surface, part, material }
    }
}

impl Nearest {
    /// The nearer; of equally near ones the lower part.
    #[inline(always)]
    fn or(self, t: f64, part: u32, primitive: u32) -> Nearest {
        if t < self.t || (t == self.t && part < self.part) { Nearest { t, part, primitive } } else { self }
    }
}
