//! The spectral locus: colours that there are.
//!
//! In: CIE 1976 u′, v′. Out: the colour itself if light can have it, else the last one on the way from white to it that light can
//! have. Colours of light are mixtures of those of single wavelengths, so they fill the locus and the line of purples that closes it.

use crate::color::WHITE_UV;

/// u′, v′ of single wavelengths from 400 to 700 nm, where the locus bends little or none is left out; they follow from the CIE 1931 standard
/// observer (2°) that `bsdftree-generate` has, and are tested beside it.
#[rustfmt::skip]
const LOCUS: [[f64; 2]; 42] = [
    [0.2558, 0.0159], [0.2522, 0.0169], [0.2461, 0.0226], [0.2348, 0.0349], [0.2266, 0.0437], [0.2161, 0.0550], [0.2033, 0.0689],
    [0.1877, 0.0871], [0.1690, 0.1119], [0.1441, 0.1510], [0.1147, 0.2044], [0.0828, 0.2708], [0.0521, 0.3427], [0.0282, 0.4117],
    [0.0119, 0.4698], [0.0035, 0.5131], [0.0014, 0.5432], [0.0046, 0.5638], [0.0123, 0.5770], [0.0231, 0.5837], [0.0360, 0.5861],
    [0.0501, 0.5868], [0.0643, 0.5865], [0.0792, 0.5856], [0.0953, 0.5841], [0.1127, 0.5821], [0.1319, 0.5795], [0.1531, 0.5766],
    [0.2026, 0.5694], [0.2623, 0.5604], [0.3315, 0.5501], [0.4035, 0.5393], [0.4691, 0.5296], [0.5202, 0.5219], [0.5565, 0.5165],
    [0.5830, 0.5125], [0.6005, 0.5099], [0.6108, 0.5084], [0.6161, 0.5076], [0.6199, 0.5070], [0.6226, 0.5066], [0.6234, 0.5065],
];

/// The colour nearest to u′, v′ on the way to equal-energy white that light can have; itself if it is one.
///
/// ```
/// use bsdftree::locus::possible;
/// assert_eq!(possible([0.2, 0.5]), [0.2, 0.5]);
/// let [u, v] = possible([0.0, 0.7]);
/// assert!(u > 0.0 && v < 0.6);
/// ```
pub fn possible(uv: [f64; 2]) -> [f64; 2] {
    let way = [uv[0] - WHITE_UV[0], uv[1] - WHITE_UV[1]];
    let corner = |k: usize| LOCUS[k % LOCUS.len()];
    // The locus is seen from white without folds: the way out meets one edge, at `t` of the way.
    let reach = (0..LOCUS.len()).filter_map(|k| {
        let [a, b] = [corner(k), corner(k + 1)].map(|[u, v]| [u - WHITE_UV[0], v - WHITE_UV[1]]);
        let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
        let edge = [b[0] - a[0], b[1] - a[1]];
        let across = cross(way, edge);
        let [t, s] = [cross(a, edge) / across, cross(a, way) / across];
        (t > 0.0 && (0.0..=1.0).contains(&s)).then_some(t)
    });
    let t = reach.fold(f64::INFINITY, f64::min);
    if t >= 1.0 || t.is_nan() { uv } else { [WHITE_UV[0] + t * way[0], WHITE_UV[1] + t * way[1]] }
}
