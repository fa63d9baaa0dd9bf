//! The hemisphere as a disk in which equal areas are equal solid angles (Lambert, 1772): r = √(1 − cos θ).
//!
//! The horizon is the unit circle; directions below it go on outside, so what is moved across the horizon still has a place.

/// Solid angle [sr] of a unit of area of the disk.
pub(crate) const SOLID_ANGLE: f64 = 2.0;

/// A direction in single precision, as many are looked up.
pub(crate) type Ray = [f32; 3];

/// The point of a direction.
#[inline(always)]
pub(crate) fn point([x, y, z]: Ray) -> [f32; 2] {
    let scale = 1.0 / (1.0 + z).max(1e-6).sqrt();
    [x * scale, y * scale]
}

/// Between the points of two directions.
pub(crate) fn distance(a: Ray, b: Ray) -> f64 {
    let ([ax, ay], [bx, by]) = (point(a).map(f64::from), point(b).map(f64::from));
    (ax - bx).hypot(ay - by)
}

/// The direction at a point within √2 of the centre.
pub(crate) fn direction([u, v]: [f32; 2]) -> Ray {
    let r2 = (u * u + v * v).min(2.0);
    let scale = (2.0 - r2).sqrt();
    [u * scale, v * scale, 1.0 - r2]
}

/// Mirrored to the upper hemisphere, where all sides are compared.
pub(crate) fn upper([x, y, z]: [f64; 3]) -> Ray {
    [x as f32, y as f32, z.abs() as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_come_back() {
        for p in [[0.0, 0.0], [0.3, -0.4], [1.0, 0.0], [0.7, 0.9]] {
            let q = point(direction(p));
            assert!((p[0] - q[0]).abs() + (p[1] - q[1]).abs() < 1e-5, "{p:?} {q:?}");
        }
    }
}
