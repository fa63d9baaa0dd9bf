//! Colour: CIE X, Y, Z and the u′, v′ that tensor-tree files carry beside Y.

/// u′, v′ of equal-energy white, for places where Y is 0 and colour is undefined.
pub const WHITE_UV: [f64; 2] = [4.0 / 19.0, 9.0 / 19.0];

/// X, Y, Z from luminance and CIE 1976 u′, v′.
pub fn xyz_from_yuv(y: f64, [u, v]: [f64; 2]) -> [f64; 3] {
    if v <= 0.0 {
        return [0.0, y, 0.0];
    }
    [y * 9.0 * u / (4.0 * v), y, y * (12.0 - 3.0 * u - 20.0 * v) / (4.0 * v)]
}

/// CIE 1976 u′, v′ from X, Y, Z; white where there is no light.
pub fn uv_from_xyz([x, y, z]: [f64; 3]) -> [f64; 2] {
    let denominator = x + 15.0 * y + 3.0 * z;
    if denominator > 0.0 { [4.0 * x / denominator, 9.0 * y / denominator] } else { WHITE_UV }
}

/// X, Y, Z from Radiance's RGB: primaries R (.640, .330), G (.290, .600), B (.150, .060), white (⅓, ⅓), white's Y = 1.
/// The rows follow from those chromaticities.
pub fn xyz_from_rgb(rgb: [f64; 3]) -> [f64; 3] {
    XYZ_FROM_RGB.map(|row| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2])
}

const XYZ_FROM_RGB: [[f64; 3]; 3] = [
    [0.514_144_620_811, 0.323_884_479_718, 0.161_970_899_471],
    [0.265_105_820_106, 0.670_105_820_106, 0.064_788_359_788],
    [0.024_100_529_101, 0.122_852_733_686, 0.853_046_737_213],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chromaticity_round_trips() {
        for xyz in [[0.2, 0.3, 0.4], [1.0, 1.0, 1.0], [0.05, 0.9, 0.01]] {
            let back = xyz_from_yuv(xyz[1], uv_from_xyz(xyz));
            for k in 0..3 {
                assert!((back[k] - xyz[k]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn rgb_matrix_follows_from_the_primaries() {
        let primaries = [[0.640, 0.330], [0.290, 0.600], [0.150, 0.060]];
        for (k, [x, y]) in primaries.into_iter().enumerate() {
            let mut rgb = [0.0; 3];
            rgb[k] = 1.0;
            let xyz = xyz_from_rgb(rgb);
            let sum: f64 = xyz.iter().sum();
            assert!((xyz[0] / sum - x).abs() < 1e-11 && (xyz[1] / sum - y).abs() < 1e-11, "{k}: {xyz:?}");
        }
        for white in xyz_from_rgb([1.0; 3]) {
            assert!((white - 1.0).abs() < 1e-11);
        }
    }
}
