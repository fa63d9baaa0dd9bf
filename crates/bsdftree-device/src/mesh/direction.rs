//! A direction in 32 bits, as Radiance's compiled meshes have their normals.
//!
//! Source: normals written by `obj2mesh` and read by `rtrace` (2025), compared. From the lowest bit: signs of x, y and z; whether the first field
//! is |x|, not |y|; whether the second is |z|, not the other one of |x| and |y|; two fields of 13 bits, rounded to
//! units of 1/11584.5. What is in no field is the largest component, as long as unit length leaves.

use glam::{DVec3, Vec3};

const UNIT: f64 = 1.0 / 11584.5;

/// The direction, of unit length; zero for 0, which is none.
pub(super) fn decoded(code: u32) -> Vec3 {
    if code == 0 {
        return Vec3::ZERO;
    }
    let field = |shift: u32| f64::from(code >> shift & 0x1fff) * UNIT;
    let first = if code & 8 != 0 { 0 } else { 1 };
    let second = if code & 16 != 0 { 2 } else { 1 - first };
    let mut direction = DVec3::ZERO;
    (direction[first], direction[second]) = (field(5), field(18));
    direction[3 - first - second] = (1.0 - direction.length_squared()).max(0.0).sqrt();
    for axis in 0..3 {
        if code >> axis & 1 != 0 {
            direction[axis] = -direction[axis];
        }
    }
    direction.normalize_or_zero().as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normals and the codes that obj2mesh gave them.
    #[test]
    fn codes_of_obj2mesh_are_read() {
        for (code, [x, y, z]) in [
            (0b00100100010010110101110100011001, [-0.59455, 0.77867, 0.20046]),
            (0b01110001111110000100101000010101, [-0.77519, 0.05109, -0.62966]),
            (0b01001101100110011111010101101111, [-0.34621, -0.42864, -0.83451]),
            (0b01111011111111000101101111100001, [-0.68493, 0.06345, 0.72585]),
            (0b00100111100010000101011100111010, [0.06019, -0.97400, 0.21840]),
            (0b01000010000110010000100001110000, [0.91287, 0.18257, 0.36515]),
        ] {
            assert!(decoded(code).distance(Vec3::new(x, y, z)) < 1e-4, "{code:b}");
        }
        assert_eq!(decoded(0b01100), Vec3::NEG_Z);
        assert_eq!(decoded(0b11010), Vec3::NEG_Y);
        assert_eq!(decoded(0), Vec3::ZERO);
    }
}
