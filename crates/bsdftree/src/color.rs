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

/// Radiance's RGB from X, Y, Z: the inverse of [`xyz_from_rgb`]. Negative where the colour is outside of the primaries' triangle.
pub fn rgb_from_xyz(xyz: [f64; 3]) -> [f64; 3] {
    RGB_FROM_XYZ.map(|row| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2])
}

const XYZ_FROM_RGB: [[f64; 3]; 3] = [
    [0.514_144_620_811, 0.323_884_479_718, 0.161_970_899_471],
    [0.265_105_820_106, 0.670_105_820_106, 0.064_788_359_788],
    [0.024_100_529_101, 0.122_852_733_686, 0.853_046_737_213],
];

const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [2.565_312_843_032_79, -1.166_849_615_808_505_3, -0.398_463_227_224_284_6],
    [-1.022_108_172_129_403_4, 1.978_286_616_660_339_2, 0.043_821_555_469_064_4],
    [0.074_724_377_295_520_64, -0.251_939_567_169_581_66, 1.177_215_189_874_061],
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
    fn rgb_round_trips() {
        for rgb in [[0.2, 0.3, 0.4], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let back = rgb_from_xyz(xyz_from_rgb(rgb));
            for k in 0..3 {
                assert!((back[k] - rgb[k]).abs() < 1e-15, "{back:?}");
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
