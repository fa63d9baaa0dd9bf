//! The area-preserving map between the square \[0,1\]² and the unit disk.
//!
//! P. Shirley and K. Chiu, "A low distortion map between disk and square", Journal of Graphics
//! Tools 2(3), 1997. A point of the disk is the (x, y) of a direction, so equal areas of the square are
//! equal projected solid angles: the whole square is π.
//!
//! Deviation: the paper's four sectors are folded into one by symmetry (the larger coordinate is ±r, the
//! smaller one r·(4/π)·φ within the sector), which gives the same points without branches on the angle.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_4};

/// The point of the unit disk over a point of the square.
#[inline(always)]
pub fn disk_from_square([x, y]: [f64; 2]) -> [f64; 2] {
    let (a, b) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    let a_leads = a.abs() >= b.abs();
    let (major, minor) = if a_leads { (a, b) } else { (b, a) };
    let divisor = if major == 0.0 { 1.0 } else { major };
    let (sin, cos) = sin_cos_eighth(FRAC_PI_4 * (minor / divisor).abs());
    let (along, across) = (major * cos, (major.abs() * sin).copysign(minor));
    if a_leads { [along, across] } else { [across, along] }
}

/// The point of the square under a point of the unit disk; clamped to \[0,1\]² for points outside the disk.
///
/// Without branches: over arrays the compiler makes it vector instructions, with the same bits.
#[inline(always)]
pub fn square_from_disk([x, y]: [f64; 2]) -> [f64; 2] {
    square_from_polar((x * x + y * y).sqrt(), [x, y])
}

/// [`square_from_disk`] of the point at a distance from the centre, in the direction of (x, y), which may have any length.
#[inline(always)]
pub(crate) fn square_from_polar(r: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let r = r.min(1.0);
    let x_leads = x.abs() >= y.abs();
    let (major, minor) = if x_leads { (x, y) } else { (y, x) };
    let divisor = if major == 0.0 { 1.0 } else { major.abs() };
    let along = r.copysign(major);
    let across = (r * eighths(minor.abs(), divisor)).copysign(minor);
    let (a, b) = if x_leads { (along, across) } else { (across, along) };
    [0.5 * (a + 1.0), 0.5 * (b + 1.0)]
}

/// (4/π)·atan(minor/major) for 0 ≤ minor ≤ major, within 3e-16. The same bits on every machine, and without the branches of the
/// platform's function. Above tan(π/8) the angle is taken from π/4: atan t = π/4 + atan((t − 1)/(t + 1)). What is left of the series,
/// atan(u)/u over u² up to tan²(π/8), is its Chebyshev approximation of degree 11, off by 1.3e-18.
#[inline(always)]
fn eighths(minor: f64, major: f64) -> f64 {
    const TAN_PI_8: f64 = 0.414_213_562_373_095_03;
    const SERIES: [f64; 12] = [
        1.0,
        -0.333_333_333_333_331_2,
        0.199_999_999_999_408_37,
        -0.142_857_142_792_449_68,
        0.111_111_107_446_570_99,
        -0.090_908_968_014_728_13,
        0.076_920_451_945_614_81,
        -0.066_629_502_460_367_92,
        0.058_468_667_522_751_39,
        -0.050_350_497_953_124_39,
        0.037_963_903_161_110_83,
        -0.017_803_896_394_812_563,
    ];
    let far = minor > TAN_PI_8 * major;
    let (above, below) = if far { (minor - major, minor + major) } else { (minor, major) };
    let u = above / below;
    let (q, square) = (u * u, (u * u) * (u * u));
    let c = &SERIES;
    // Thirds side by side: fewer steps that wait for one another.
    let part = |k: usize| c[k] + q * c[k + 1];
    let low = part(0) + square * part(2);
    let middle = part(4) + square * part(6);
    let high = part(8) + square * part(10);
    let (fourth, eighth) = (square * square, (square * square) * (square * square));
    let angle = u * (low + fourth * middle + eighth * high);
    angle * FRAC_4_PI + if far { 1.0 } else { 0.0 }
}

/// 4/π.
const FRAC_4_PI: f64 = 4.0 * FRAC_1_PI;

/// sin and cos of an angle in [0, π/4], within 2e-16: Taylor polynomials, whose last terms are below the rounding of the first. The
/// same bits on every machine, and six times as fast as the platform's functions.
#[inline(always)]
fn sin_cos_eighth(angle: f64) -> (f64, f64) {
    // (−1)ᵏ / (2k + odd)!
    const fn taylor(odd: usize) -> [f64; 9] {
        let mut c = [1.0; 9];
        let mut k = 1;
        while k < 9 {
            let n = 2 * k + odd;
            c[k] = -c[k - 1] / ((n - 1) * n) as f64;
            k += 1;
        }
        c
    }
    const COS: [f64; 9] = taylor(0);
    const SIN: [f64; 9] = taylor(1);
    let q = angle * angle;
    let square = q * q;
    // The even coefficients beside the odd ones: half the steps that wait for one another.
    let series = |c: &[f64; 9]| {
        let even = (((c[8] * square + c[6]) * square + c[4]) * square + c[2]) * square + c[0];
        let odd = ((c[7] * square + c[5]) * square + c[3]) * square + c[1];
        even + q * odd
    };
    (angle * series(&SIN), series(&COS))
}

/// Single-precision twin of [`disk_from_square`], within 2e-7, without calls to the mathematical library.
#[inline]
pub fn disk_from_square_f32([x, y]: [f32; 2]) -> [f32; 2] {
    let (a, b) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    let a_leads = a.abs() >= b.abs();
    let (major, minor) = if a_leads { (a, b) } else { (b, a) };
    let ratio = minor / if major == 0.0 { 1.0 } else { major };
    let (sin, cos) = sin_cos_quarter_pi(ratio);
    let (along, across) = (major * cos, major * sin);
    if a_leads { [along, across] } else { [across, along] }
}

/// Single-precision twin of [`square_from_disk`], within 3e-7, without calls to the mathematical library.
#[inline]
pub fn square_from_disk_f32([x, y]: [f32; 2]) -> [f32; 2] {
    let r = (x * x + y * y).sqrt().min(1.0);
    let x_leads = x.abs() >= y.abs();
    let (major, minor) = if x_leads { (x, y) } else { (y, x) };
    let ratio = minor / if major == 0.0 { 1.0 } else { major };
    let along = r.copysign(major);
    let across = along * atan_over_quarter_pi(ratio);
    let (a, b) = if x_leads { (along, across) } else { (across, along) };
    [0.5 * (a + 1.0), 0.5 * (b + 1.0)]
}

/// sin and cos of (π/4)·t for |t| ≤ 1: Taylor polynomials, whose last term is below f32 rounding there.
#[inline]
fn sin_cos_quarter_pi(t: f32) -> (f32, f32) {
    let angle = std::f32::consts::FRAC_PI_4 * t;
    let q = angle * angle;
    let sin = angle * (1.0 + q * (-1.0 / 6.0 + q * (1.0 / 120.0 + q * (-1.0 / 5040.0 + q / 362_880.0))));
    let cos =
        1.0 + q * (-0.5 + q * (1.0 / 24.0 + q * (-1.0 / 720.0 + q * (1.0 / 40_320.0 - q / 3_628_800.0))));
    (sin, cos)
}

/// (4/π)·atan(t) for |t| ≤ 1. Halving the angle, atan t = 2·atan(t / (1 + √(1+t²))), brings the argument
/// below 0.4143, where the series converges fast.
#[inline]
fn atan_over_quarter_pi(t: f32) -> f32 {
    let h = t / (1.0 + (1.0 + t * t).sqrt());
    let q = h * h;
    let series = 1.0
        + q * (-1.0 / 3.0
            + q * (1.0 / 5.0
                + q * (-1.0 / 7.0 + q * (1.0 / 9.0 + q * (-1.0 / 11.0 + q * (1.0 / 13.0 - q / 15.0))))));
    (8.0 * std::f32::consts::FRAC_1_PI) * h * series
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize) -> impl Iterator<Item = [f64; 2]> {
        (0..=n).flat_map(move |i| (0..=n).map(move |j| [i as f64 / n as f64, j as f64 / n as f64]))
    }

    #[test]
    fn inverse_undoes_the_map() {
        for p in grid(97) {
            let q = square_from_disk(disk_from_square(p));
            assert!((p[0] - q[0]).abs() < 1e-14 && (p[1] - q[1]).abs() < 1e-14, "{p:?} {q:?}");
        }
    }

    #[test]
    fn the_angle_is_that_of_the_platform() {
        for k in 0..=100_000 {
            let t = f64::from(k) / 100_000.0;
            let error = eighths(3.0 * t, 3.0) - t.atan() / FRAC_PI_4;
            assert!(error.abs() < 4e-16, "{t}: {error:e}");
        }
        assert_eq!([eighths(0.0, 0.7), eighths(0.7, 0.7)], [0.0, 1.0]);
    }

    #[test]
    fn agrees_with_the_four_sectors_of_the_paper() {
        use std::f64::consts::PI;
        for [x, y] in grid(41) {
            let (a, b) = (2.0 * x - 1.0, 2.0 * y - 1.0);
            let (r, phi) = if a > -b {
                if a > b { (a, PI / 4.0 * (b / a)) } else { (b, PI / 4.0 * (2.0 - a / b)) }
            } else if a < b {
                (-a, PI / 4.0 * (4.0 + b / a))
            } else {
                (-b, if b != 0.0 { PI / 4.0 * (6.0 - a / b) } else { 0.0 })
            };
            let d = disk_from_square([x, y]);
            assert!((d[0] - r * phi.cos()).abs() < 1e-14 && (d[1] - r * phi.sin()).abs() < 1e-14);
        }
    }

    #[test]
    fn equal_areas_stay_equal() {
        // Jacobian by central differences: the square of area 1 becomes a disk of area π everywhere.
        let h = 1e-6;
        for [x, y] in grid(23) {
            let [x, y] = [0.013 + 0.97 * x, 0.0171 + 0.96 * y];
            let d = |x, y| disk_from_square([x, y]);
            let (px, mx, py, my) = (d(x + h, y), d(x - h, y), d(x, y + h), d(x, y - h));
            let j = [(px[0] - mx[0]) / (2.0 * h), (px[1] - mx[1]) / (2.0 * h)];
            let k = [(py[0] - my[0]) / (2.0 * h), (py[1] - my[1]) / (2.0 * h)];
            let area = j[0] * k[1] - j[1] * k[0];
            assert!((area - std::f64::consts::PI).abs() < 1e-3, "{x} {y}: {area}");
        }
    }

    #[test]
    fn opposite_directions_are_opposite_points() {
        for p in grid(31) {
            let d = disk_from_square(p);
            let q = square_from_disk([-d[0], -d[1]]);
            assert!((p[0] + q[0] - 1.0).abs() < 1e-14 && (p[1] + q[1] - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn single_precision_stays_within_its_bound() {
        for p in grid(201) {
            let d = disk_from_square(p);
            let d32 = disk_from_square_f32(p.map(|c| c as f32));
            let q = square_from_disk_f32(d.map(|c| c as f32));
            for k in 0..2 {
                assert!((d[k] - f64::from(d32[k])).abs() < 2e-7, "{p:?}: {d:?} {d32:?}");
                assert!((p[k] - f64::from(q[k])).abs() < 3e-7, "{p:?}: {q:?}");
            }
        }
    }
}
