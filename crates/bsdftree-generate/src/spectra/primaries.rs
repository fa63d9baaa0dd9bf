//! Spectra for red, green and blue: what a path with wavelengths takes a material for of which RGB is all that is known.
//!
//! Between 0 and 1, together 1 at every wavelength, as even as can be (least squares of differences between neighbours), and, in the
//! light of illuminant E, of the X, Y, Z of Radiance's primaries. So light that meets one coloured surface has the Y, u′, v′ that
//! it has with RGB, and greys are the same all over. Found by `scipy.optimize.minimize` (trust-constr) with the weights of
//! [`weights`](super::weights). Source of the idea: I. Mallett, C. Yuksel, "Spectral primary decomposition for rendering with sRGB
//! reflectance", EGSR 2019. Deviation: Radiance takes three boxes, with borders at 480 and 588 nm, whose Y comes out right and whose
//! X and Z do not.

/// How many: one for each 5 nm from 380 to 780 nm.
pub(crate) const N: usize = 81;

/// Red, green; blue is what is left.
#[rustfmt::skip]
pub(crate) const RED_GREEN: [[f64; 2]; N] = [
    [0.09151418, 0.00000029], [0.09150281, 0.00000006], [0.09142522, 0.00000004], [0.09125382, 0.00000002],
    [0.0908966, 0.00000001], [0.09021053, 0.00000001], [0.08898606, 0.0], [0.08679961, 0.0],
    [0.08295103, 0.0], [0.07643463, 0.0], [0.06632964, 0.0], [0.05268138, 0.0],
    [0.03695835, 0.0], [0.02193985, 0.0], [0.01157669, 0.00000003], [0.00130282, 0.01951952],
    [0.0, 0.05363004], [0.0, 0.10477703], [0.0, 0.17132302], [0.0, 0.24988271],
    [0.0, 0.33683158], [0.0, 0.42869894], [0.0, 0.52232145], [0.0, 0.61487414],
    [0.0, 0.70369877], [0.0, 0.78611723], [0.0, 0.85922839], [0.0, 0.91997539],
    [0.0, 0.96530881], [0.0, 0.99260412], [0.0, 1.0], [0.0, 1.0],
    [0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0],
    [0.0, 1.0], [0.0, 0.98306167], [0.0, 0.94865609], [0.05773301, 0.86983442],
    [0.21507317, 0.72780835], [0.42545226, 0.54816444], [0.6428071, 0.35630042], [0.82379588, 0.17620412],
    [0.95059626, 0.04940374], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0],
    [1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0],
    [1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0],
    [1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0],
    [1.0, 0.0], [1.0, 0.0], [0.99999999, 0.0], [0.99999999, 0.0],
    [0.99999999, 0.00000001], [0.99999999, 0.00000001], [0.99999998, 0.00000001], [0.99999997, 0.00000001],
    [0.99999996, 0.00000002], [0.99999994, 0.00000003], [0.99999991, 0.00000005], [0.99999987, 0.00000006],
    [0.99999987, 0.00000008], [0.99999974, 0.00000012], [0.99999977, 0.00000007], [0.99999947, 0.00000022],
    [0.99999898, 0.00000051], [0.99999894, 0.00000079], [0.99999951, 0.00000047], [0.99999644, 0.00000185],
    [0.99999648, 0.00000172],
];
