//! Pseudo-random functions of position: `rand`, `noise3` with its gradient, `fnoise3`, and Hermite interpolation.
//!
//! Values agree with Radiance's, because patterns are made to look as they do there. Smooth noise: K. Perlin, "An image
//! synthesizer", SIGGRAPH 1985, as random values and random slopes on the integer lattice, joined by cubic Hermite
//! curves, one axis after the other. Fractal noise: the midpoint displacement of A. Fournier, D. Fussell and L. Carpenter,
//! "Computer rendering of stochastic models", CACM 1982, in a cube, down to a thousandth of its edge. The hash of
//! lattice points is the integer noise function of H. Elias's page on Perlin noise.

use std::array::from_fn;

/// A number in [0, 1) that looks random, the same for the same `x`.
pub(super) fn rand(x: f64) -> f64 {
    // 2.718… and 0.785… are e and π/4.
    let stretched = x * (1.0 / (1.0 + x * x) + 2.71828182845904);
    let scattered = 1e5 / (stretched + (0.785398163397447 - stretched.floor()));
    scattered - scattered.floor()
}

/// The cubic through `p0` at t = 0 and `p1` at t = 1 with slopes `r0` and `r1` there.
pub(super) fn hermite(p0: f64, p1: f64, r0: f64, r1: f64, t: f64) -> f64 {
    let [at_0, at_1] = value_weights(t);
    let [slope_0, slope_1] = slope_weights(t);
    p0 * at_0 + p1 * at_1 + r0 * slope_0 + r1 * slope_1
}

fn value_weights(t: f64) -> [f64; 2] {
    [(2.0 * t - 3.0) * t * t + 1.0, (-2.0 * t + 3.0) * t * t]
}

fn slope_weights(t: f64) -> [f64; 2] {
    [((t - 2.0) * t + 1.0) * t, (t - 1.0) * t * t]
}

/// Factors that make one number of a lattice point: for the slopes along x, y, z, and for the value.
const LATTICE: [[i64; 3]; 4] = [[67, 59, 71], [73, 79, 83], [89, 97, 101], [103, 107, 109]];

/// Smooth noise at a point: slopes along x, y, z, and the value, each in (-1, 1].
pub(super) fn smooth(point: [f64; 3]) -> [f64; 4] {
    let base = point.map(|x| x.floor() as i64);
    let inside: [f64; 3] = from_fn(|axis| point[axis] - base[axis] as f64);
    let mut corners: [[f64; 4]; 8] = from_fn(|corner| {
        let at: [i64; 3] = from_fn(|axis| base[axis].wrapping_add((corner >> axis & 1) as i64));
        LATTICE.map(|factors| hash_of(at, factors))
    });
    // Corners that differ along the axis lie side by side, and are joined.
    for axis in 0..3 {
        let [at_0, at_1] = value_weights(inside[axis]);
        let [slope_0, slope_1] = slope_weights(inside[axis]);
        for pair in 0..4 >> axis {
            let [low, high] = [corners[2 * pair], corners[2 * pair + 1]];
            let mut joined: [f64; 4] = from_fn(|i| low[i] * at_0 + high[i] * at_1);
            joined[3] += low[axis] * slope_0 + high[axis] * slope_1;
            corners[pair] = joined;
        }
    }
    corners[0]
}

/// Edge of the fractal's first cube in its steps.
const FRACTAL_STEPS: i64 = 1000;

/// Fractal noise at a point, about in (-1, 1).
pub(super) fn fractal(point: [f64; 3]) -> f64 {
    let n = FRACTAL_STEPS as f64;
    let target = point.map(|x| (n * x) as i64);
    let mut low = point.map(|x| (n * x.floor()) as i64);
    let mut edge = FRACTAL_STEPS;
    let displaced = |at: [i64; 3]| hash_of(at, [17, 23, 29]);
    let mut corners: [f64; 8] = from_fn(|corner| {
        displaced(from_fn(|axis| low[axis].wrapping_add((corner >> axis & 1) as i64 * edge)))
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
            mean + half as f64 * 0.001 * displaced(at)
        });
        corners = halved;
        low = from_fn(|axis| if upper(axis) { middle[axis] } else { low[axis] });
        edge = half;
    }
}

/// A number in (-1, 1] from a lattice point.
fn hash_of(at: [i64; 3], factors: [i64; 3]) -> f64 {
    let seed = (0..3).fold(0i64, |sum, axis| sum.wrapping_add(at[axis].wrapping_mul(factors[axis])));
    let mixed = (seed << 13) ^ seed;
    let cubed = mixed.wrapping_mul(mixed.wrapping_mul(mixed).wrapping_mul(15731).wrapping_add(789221));
    1.0 - (cubed.wrapping_add(1376312589) & 0x7fff_ffff) as f64 / 1_073_741_824.0
}
