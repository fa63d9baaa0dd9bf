//! The walk through the tree: filters in f32 choose, f64 decides.
//!
//! Enters: a ray. Leaves: the surface with the least (t, index) among all that f64 arithmetic meets. As filters lose
//! nothing, this does not depend on the order of the walk, the shape of the tree, or the kernel.

use std::mem::MaybeUninit;

use glam::DVec3;

use super::analytic::Query;
use super::kernel::{FilterRay, Kernel};
use super::node::{Target, WIDTH};
use super::ray::{Hit, Ray};
use super::{Bvh, NO_SURFACE};

/// Room for 7 waiting siblings on each of 73 levels; `split.rs` keeps trees below 36 + 27.
const STACK: usize = 512;

/// How far from the device's box a ray from outside is taken up, local units.
const APPROACH: f64 = 1.0 / 64.0;

/// What is met so far, in the local frame.
struct Nearest {
    t: f64,
    surface: u32,
    /// Facet, or `!index` of an analytic surface.
    primitive: u32,
}

/// A ray brought into the local frame and up to the device's box.
pub(super) struct LocalRay {
    origin: DVec3,
    direction: DVec3,
    /// Distance \[m\] skipped in front of the box.
    skipped: f64,
    /// Surface just left, or [`NO_SURFACE`].
    from: u32,
}

impl LocalRay {
    /// `None` if the ray misses the device's box or is not finite.
    #[inline(always)]
    pub fn new(bvh: &Bvh, ray: &Ray) -> Option<LocalRay> {
        let frame = &bvh.frame;
        let mut origin = frame.local_from_device(ray.origin);
        let [low, high] = frame.bounds;
        let mut skipped = 0.0;
        if !(origin.cmpge(low) & origin.cmple(high)).all() {
            // No infinity, which would make NaN of a ray in the plane of a face.
            let inv = ray.direction.map(|d| 1.0 / d.abs().max(1e-30).copysign(d));
            // Up to a larger box, so that what lies in the faces of the device's own is still ahead.
            let (a, b) = ((low - APPROACH - origin) * inv, (high + APPROACH - origin) * inv);
            let (enter, leave) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
            skipped = enter * frame.scale;
            origin = frame.local_from_device(ray.origin + ray.direction * skipped);
            let near = origin.cmpge(low - 2.0 * APPROACH) & origin.cmple(high + 2.0 * APPROACH);
            if !(near.all() && enter <= leave) {
                return None;
            }
        }
        ray.direction.is_finite().then_some(LocalRay {
            origin,
            direction: ray.direction,
            skipped,
            from: ray.from.unwrap_or(NO_SURFACE),
        })
    }
}

/// The first hit.
///
/// # Safety
/// The processor must have the features `K` names.
#[inline(always)]
pub(super) unsafe fn closest<K: Kernel>(bvh: &Bvh, ray: &Ray) -> Option<Hit> {
    let local = LocalRay::new(bvh, ray)?;
    let mut best = Nearest { t: f64::INFINITY, surface: NO_SURFACE, primitive: 0 };
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
            match super::node::Child(entry as u32).target() {
                Target::Node(index) => {
                    let node = bvh.nodes.get_unchecked(index);
                    let mut hits = kernel.boxes(node, best.t as f32, &mut near);
                    if hits != 0 {
                        let base = height;
                        while hits != 0 {
                            let lane = hits.trailing_zeros() as usize & (WIDTH - 1);
                            hits &= hits - 1;
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

impl Bvh {
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

    fn describe(&self, ray: &Ray, local: &LocalRay, best: &Nearest) -> Hit {
        let t = best.t * self.frame.scale + local.skipped;
        let p = local.origin + local.direction * best.t;
        let attributes = &self.surfaces[best.surface as usize];
        let (inset, normal) = if best.primitive as i32 >= 0 {
            let facet = &self.facets[best.primitive as usize];
            (facet.inset(p, self.inset), facet.normal())
        } else {
            let shape = &self.analytic[!best.primitive as usize].0;
            let outward = shape.outward(p);
            (shape.inset(p, self.inset), if attributes.inward { -outward } else { outward })
        };
        let mut position = ray.origin + ray.direction * t;
        if inset != p {
            position += (inset - p) * self.frame.scale;
        }
        Hit {
            t,
            position,
            normal,
            front: normal.dot(ray.direction) < 0.0,
            surface: best.surface,
            material: attributes.material,
        }
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
