//! The tracer's own frame: the device moved to the origin and scaled into the cube [−1, 1]³.
//!
//! Enters: the device's bounds \[m\]. Leaves: exact powers of two for the scale, so that only the shift rounds,
//! and `grain`, the resolution of an f64 position of this device in this frame.
//! Invariant: every point of the device has local coordinates in [−1, 1].

use glam::DVec3;

use super::ray::Ray;

/// How far from the device's box a ray from outside is taken up, local units: errors of the filters allow for twice that.
const APPROACH: f64 = 1.0 / 64.0;

/// `local = (device − center) · inv_scale`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub center: DVec3,
    pub scale: f64,
    pub inv_scale: f64,
    /// Bound on the rounding of one position, in local units.
    pub grain: f64,
    /// Corners of the device in local units.
    pub bounds: [DVec3; 2],
    /// The larger box that rays from afar are taken up to.
    near: [DVec3; 2],
}

impl Frame {
    /// Of a device with these corners, finite and not so far apart that f64 ends.
    pub fn new(corners: [DVec3; 2]) -> Frame {
        let center = corners[0] * 0.5 + corners[1] * 0.5;
        let half = (corners[1] * 0.5 - corners[0] * 0.5).max_element();
        // A device of one point still needs a scale; one that is far away cannot be finer than f64 is there.
        let half = half.max(center.abs().max_element() * f64::EPSILON).max(f64::MIN_POSITIVE * 16.0);
        let power = half.log2().ceil().exp2();
        let scale = if power < half { 2.0 * power } else { power };
        let inv_scale = 1.0 / scale;
        let grain = f64::EPSILON * (2.0 + center.abs().max_element() * inv_scale);
        let bounds = corners.map(|c| (c - center) * inv_scale);
        let near = [bounds[0] - APPROACH, bounds[1] + APPROACH];
        Frame { center, scale, inv_scale, grain, bounds, near }
    }

    #[inline(always)]
    pub fn local_from_device(&self, p: DVec3) -> DVec3 {
        (p - self.center) * self.inv_scale
    }

    /// Whether a ray can be followed from this local position on: it is as near as any that the filters are proven for.
    #[inline(always)]
    pub fn is_near(p: DVec3) -> bool {
        p.abs().cmple(DVec3::splat(1.0 + APPROACH)).all()
    }

    /// Where a ray from outside comes near the device's box, local, and how far that is \[m\]. `None` if it misses the
    /// box or starts where f64 does not resolve it.
    #[inline(never)]
    pub fn approach(&self, ray: &Ray) -> Option<(DVec3, f64)> {
        let [low, high] = self.bounds;
        let origin = self.local_from_device(ray.origin);
        // No infinity, which would make NaN of a ray in the plane of a face.
        let inv = ray.direction.map(|d| 1.0 / d.abs().max(1e-30).copysign(d));
        // Up to a larger box, so that what lies in the faces of the device's own is still ahead.
        let (a, b) = ((self.near[0] - origin) * inv, (self.near[1] - origin) * inv);
        let (enter, leave) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
        let skipped = enter * self.scale;
        let origin = self.local_from_device(ray.origin + ray.direction * skipped);
        let near = origin.cmpge(low - 2.0 * APPROACH) & origin.cmple(high + 2.0 * APPROACH);
        (near.all() && enter <= leave).then_some((origin, skipped))
    }

    #[inline(always)]
    pub fn device_from_local(&self, p: DVec3) -> DVec3 {
        p * self.scale + self.center
    }
}
