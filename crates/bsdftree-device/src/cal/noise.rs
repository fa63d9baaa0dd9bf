//! Pseudo-random functions of position: `rand`, `noise3` with its slopes, `fnoise3`, and Hermite interpolation.
//!
//! Values agree with Radiance's, because patterns are made to look as they do there. Smooth noise: K. Perlin, "Improving
//! noise", SIGGRAPH 2002, with the permutation published with it; its slopes are backward differences over half a
//! thousandth. (Radiance before version 5.3 had the noise of 1985.) Fractal noise: the midpoint displacement of
//! A. Fournier, D. Fussell and L. Carpenter, "Computer rendering of stochastic models", CACM 1982, in a cube, down to
//! half a thousandth of its edge; its random numbers are the integer noise of H. Elias.

use std::array::from_fn;

/// A number in [0, 1) that looks random, the same for the same `x`.
#[expect(
    clippy::approx_constant,
    reason = "e and π/4 with as many digits as in Radiance, because all of them count"
)]
pub(super) fn rand(x: f64) -> f64 {
    let stretched = x * (1.0 / (1.0 + x * x) + 2.71828182845904);
    let scattered = 1e5 / (stretched + (0.785398163397447 - stretched.floor()));
    scattered - scattered.floor()
}

/// The cubic through `p0` at t = 0 and `p1` at t = 1 with slopes `r0` and `r1` there.
pub(super) fn hermite(p0: f64, p1: f64, r0: f64, r1: f64, t: f64) -> f64 {
    let s = 1.0 - t;
    p0 * s * s * (1.0 + 2.0 * t) + p1 * t * t * (3.0 - 2.0 * t) + r0 * t * s * s - r1 * t * t * s
}

/// Slopes are differences over this distance.
const STEP: f64 = 0.0005;

/// Slope of the smooth noise along an axis.
pub(super) fn slope(point: [f64; 3], axis: usize) -> f64 {
    let mut before = point;
    before[axis] -= STEP;
    (smooth(point) - smooth(before)) / STEP
}

/// Smooth noise at a point, about in (-1, 1); 0 at lattice points.
pub(super) fn smooth(point: [f64; 3]) -> f64 {
    let base = point.map(|x| x.floor() as i64);
    let inside: [f64; 3] = from_fn(|axis| point[axis] - base[axis] as f64);
    let mut corners: [f64; 8] = from_fn(|corner| {
        let is_upper: [i64; 3] = from_fn(|axis| (corner >> axis & 1) as i64);
        let hash = (0..3)
            .fold(0i64, |hash, axis| permuted(hash.wrapping_add(base[axis]).wrapping_add(is_upper[axis])));
        along_gradient(hash, from_fn(|axis| inside[axis] - is_upper[axis] as f64))
    });
    // Corners that differ along the axis lie side by side, and are joined.
    for axis in 0..3 {
        let t = inside[axis];
        let weight = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        for pair in 0..4 >> axis {
            let [low, high] = [corners[2 * pair], corners[2 * pair + 1]];
            corners[pair] = low + weight * (high - low);
        }
    }
    corners[0]
}

/// Product of an offset with the gradient that the hash selects.
fn along_gradient(hash: i64, offset: [f64; 3]) -> f64 {
    let gradient = GRADIENTS[(hash & 15) as usize];
    offset[0] * gradient[0] + offset[1] * gradient[1] + offset[2] * gradient[2]
}

/// From the middle of a cube to those of its twelve edges, four of them twice.
#[rustfmt::skip]
const GRADIENTS: [[f64; 3]; 16] = [
    [1., 1., 0.], [-1., 1., 0.], [1., -1., 0.], [-1., -1., 0.],
    [1., 0., 1.], [-1., 0., 1.], [1., 0., -1.], [-1., 0., -1.],
    [0., 1., 1.], [0., -1., 1.], [0., 1., -1.], [0., -1., -1.],
    [1., 1., 0.], [0., -1., 1.], [-1., 1., 0.], [0., -1., -1.],
];

fn permuted(i: i64) -> i64 {
    PERMUTATION[(i & 255) as usize].into()
}

#[rustfmt::skip]
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225,
    140, 36, 103, 30, 69, 142, 8, 99, 37, 240, 21, 10, 23, 190, 6, 148,
    247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32,
    57, 177, 33, 88, 237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175,
    74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83, 111, 229, 122,
    60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54,
    65, 25, 63, 161, 1, 216, 80, 73, 209, 76, 132, 187, 208, 89, 18, 169,
    200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173, 186, 3, 64,
    52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126, 255, 82, 85, 212,
    207, 206, 59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213,
    119, 248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9,
    129, 22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232, 178, 185, 112, 104,
    218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179, 162, 241,
    81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157,
    184, 84, 204, 176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93,
    222, 114, 67, 29, 24, 72, 243, 141, 128, 195, 78, 66, 215, 61, 156, 180,
];

/// Edge of the fractal's first cube in its steps.
const FRACTAL_STEPS: i64 = 2000;

/// Fractal noise at a point, about in (-1, 1).
pub(super) fn fractal(point: [f64; 3]) -> f64 {
    let n = FRACTAL_STEPS as f64;
    let target = point.map(|x| (n * x) as i64);
    let mut low = point.map(|x| (n * x.floor()) as i64);
    let mut edge = FRACTAL_STEPS;
    let mut corners: [f64; 8] = from_fn(|corner| {
        displacement(from_fn(|axis| low[axis].wrapping_add((corner >> axis & 1) as i64 * edge)))
    });
    loop {
        let half = edge / 2;
        if half == 0 {
            return 0.125 * corners.iter().sum::<f64>();
        }
        let middle = low.map(|x| x.wrapping_add(half));
        let upper = |axis: usize| target[axis] > middle[axis];
        let kept = (0..3).map(|axis| usize::from(upper(axis)) << axis).sum::<usize>();
        // The corner `kept` of the cube is one of the half cube; each other one is the midpoint of those corners of the
        // cube that agree with `kept` along the axes along which it does.
        let halved = from_fn(|corner| {
            let moved = corner ^ kept;
            if moved == 0 {
                return corners[kept];
            }
            let parents = (0..8).filter(|parent| (parent ^ kept) & !moved == 0);
            let mean =
                parents.map(|parent| corners[parent]).sum::<f64>() / f64::from(1 << moved.count_ones());
            let at = from_fn(|axis| match (moved >> axis & 1, upper(axis)) {
                (1, _) => middle[axis],
                (_, true) => middle[axis].wrapping_add(half),
                (_, false) => middle[axis].wrapping_sub(half),
            });
            mean + half as f64 / n * displacement(at)
        });
        corners = halved;
        low = from_fn(|axis| if upper(axis) { middle[axis] } else { low[axis] });
        edge = half;
    }
}

/// A number in (-1, 1] from a lattice point.
fn displacement([x, y, z]: [i64; 3]) -> f64 {
    let seed =
        [(x, 17), (y, 23), (z, 29)].iter().fold(0i64, |sum, &(x, k)| sum.wrapping_add(x.wrapping_mul(k)));
    let mixed = (seed << 13) ^ seed;
    let cubed = mixed.wrapping_mul(mixed.wrapping_mul(mixed).wrapping_mul(15731).wrapping_add(789221));
    1.0 - (cubed.wrapping_add(1376312589) & 0x7fff_ffff) as f64 / 1_073_741_824.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_permutation_has_each_number_once() {
        let mut sorted = PERMUTATION;
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(at, &number)| at == usize::from(number)));
    }

    #[test]
    fn noise_is_defined_everywhere() {
        for x in [0.0, -1.0, 1e18, -1e18, 1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            let _ = (smooth([x, 0.5, x]), fractal([x, x, 0.5]), rand(x), slope([x; 3], 1));
        }
    }

    #[test]
    fn smooth_noise_is_continuous_across_lattice_planes() {
        for x in [-1.0, 0.0, 1.0, 255.0, 256.0] {
            let [before, after] = [x - 1e-9, x + 1e-9].map(|x| smooth([x, 0.3, -0.7]));
            assert!((before - after).abs() < 1e-8, "{x}: {before} {after}");
        }
    }
}
