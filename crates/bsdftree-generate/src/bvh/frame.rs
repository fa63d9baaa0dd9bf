//! The tracer's own frame: the device moved to the origin and scaled into the cube [−1, 1]³.
//!
//! Enters: the device's bounds \[m\]. Leaves: exact powers of two for the scale, so that only the shift rounds,
//! and `grain`, the resolution of an f64 position of this device in this frame.
//! Invariant: every point of the device has local coordinates in [−1, 1].

use glam::DVec3;

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
        Frame { center, scale, inv_scale, grain, bounds }
    }

    #[inline(always)]
    pub fn local_from_device(&self, p: DVec3) -> DVec3 {
        (p - self.center) * self.inv_scale
    }

    #[inline(always)]
    pub fn device_from_local(&self, p: DVec3) -> DVec3 {
        p * self.scale + self.center
    }
}
