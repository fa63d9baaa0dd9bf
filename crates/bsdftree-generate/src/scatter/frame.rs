//! Directions around a normal: tangents, the mirror direction, cosine-distributed directions.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::random::Random;

/// Two unit vectors that with the unit vector `normal` form a right-handed orthonormal frame.
///
/// Source: T. Duff et al., "Building an orthonormal basis, revisited", JCGT 6 (2017).
#[inline]
pub(super) fn tangents(normal: DVec3) -> [DVec3; 2] {
    let sign = 1.0_f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

/// (cos, sin) of a full turn times (`word` + ½)/2³², within 1e-15.
///
/// Own series instead of the platform's functions: faster, and the same bits everywhere.
#[inline]
pub(super) fn cos_sin(word: u32) -> [f64; 2] {
    // Taylor coefficients of cos x and (sin x)/x in x²: ±1/n!.
    const COS: [f64; 9] = taylor(0);
    const SIN: [f64; 9] = taylor(1);
    // The two leading bits of the nearest quarter turn, and what is left of the angle: within ±π/4.
    let quarter = u64::from(word.wrapping_add(1 << 29) >> 30);
    let x = (f64::from((word << 2) as i32) + 2.0) * (TAU / 4.0 * 2.0_f64.powi(-32));
    let square = x * x;
    let (cos, sin) = (series(&COS, square).to_bits(), (x * series(&SIN, square)).to_bits());
    // In odd quarters they change places; not by a branch, which would be guessed wrong half the time.
    let change = (cos ^ sin) & (quarter & 1).wrapping_neg();
    let signed = |bits: u64, negative: u64| f64::from_bits(bits ^ (negative << 62 & 1 << 63));
    [signed(cos ^ change, quarter + 1), signed(sin ^ change, quarter)]
}

/// The polynomial with these coefficients, the even ones beside the odd ones: half the steps that wait for one another.
#[inline]
fn series(c: &[f64; 9], x: f64) -> f64 {
    let square = x * x;
    let even = (((c[8] * square + c[6]) * square + c[4]) * square + c[2]) * square + c[0];
    let odd = ((c[7] * square + c[5]) * square + c[3]) * square + c[1];
    even + x * odd
}

/// (−1)ᵏ / (2k + odd)! for k = 0…8, of which the last is below the rounding of the first within ±π/4.
const fn taylor(odd: usize) -> [f64; 9] {
    let mut coefficients = [1.0; 9];
    let mut k = 1;
    while k < 9 {
        let n = 2 * k + odd;
        coefficients[k] = -coefficients[k - 1] / ((n - 1) * n) as f64;
        k += 1;
    }
    coefficients
}

/// A unit direction on `normal`'s side, with density cos θ / π.
#[inline]
pub(super) fn cosine_direction(normal: DVec3, random: &mut Random) -> DVec3 {
    let u = random.next_open();
    let [cos, sin] = cos_sin(random.next_u32());
    let radius = u.sqrt();
    let [t, b] = tangents(normal);
    t * (radius * cos) + b * (radius * sin) + normal * (1.0 - u).sqrt()
}

/// `v`, nearly of unit length, made unit to rounding: one Newton step, so that hundreds of bounces do not drift.
#[inline]
pub(super) fn renormalized(v: DVec3) -> DVec3 {
    v * (1.5 - 0.5 * v.length_squared())
}

/// The mirror image of a unit `incoming` on a surface with `normal`; `cosine` is −incoming·normal.
#[inline]
pub(super) fn mirrored(incoming: DVec3, normal: DVec3, cosine: f64) -> DVec3 {
    renormalized(incoming + normal * (2.0 * cosine))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scatter::test_support::direction;

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        let mut random = Random::new(1, 0, 0);
        let axes = [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(0.0, 0.0, -1.0), DVec3::new(1e-9, 0.0, -1.0)];
        for n in axes.into_iter().chain((0..1000).map(|_| direction(&mut random))) {
            let [t, b] = tangents(n);
            for (value, expected) in
                [(t.dot(n), 0.0), (b.dot(n), 0.0), (t.dot(b), 0.0), (t.cross(b).dot(n), 1.0)]
            {
                assert!((value - expected).abs() < 1e-14, "{n}");
            }
        }
    }

    #[test]
    fn series_equal_the_library_functions() {
        let mut random = Random::new(2, 0, 0);
        let edges = (0..8).flat_map(|k| [k << 29, (k << 29) - u32::from(k > 0)]).chain([u32::MAX]);
        for word in edges.chain((0..100_000).map(|_| random.next_u32())) {
            let [cos, sin] = cos_sin(word);
            let exact = ((f64::from(word) + 0.5) * 2.0_f64.powi(-32) * TAU).sin_cos();
            assert!((cos - exact.1).abs() < 1e-15 && (sin - exact.0).abs() < 1e-15, "{word}");
        }
    }
}
