//! Chromaticities of spectra, by the CIE 1931 standard observer.
//!
//! In: a spectrum as a function of wavelength \[nm\]. Out: its X, Y, Z up to a common factor. The observer's table (CIE 15,
//! every 10 nm) is taken as linear in between, and each column is made to sum to 1, so that an equal-energy spectrum is
//! exactly neutral, as in Radiance. Deviation from mgf2rad: it rounds a spectrum to 41 values of four digits.

/// First wavelength of the table \[nm\].
const FIRST: f64 = 380.0;
/// Between wavelengths of the table \[nm\].
const STEP: f64 = 10.0;
/// Points of the integral between two wavelengths of the table.
const FINE: usize = 10;

/// x̄, ȳ, z̄ from 380 to 780 nm.
#[rustfmt::skip]
const OBSERVER: [[f64; 3]; 41] = [
    [0.0014, 0.0000, 0.0065], [0.0042, 0.0001, 0.0201], [0.0143, 0.0004, 0.0679], [0.0435, 0.0012, 0.2074],
    [0.1344, 0.0040, 0.6456], [0.2839, 0.0116, 1.3856], [0.3483, 0.0230, 1.7471], [0.3362, 0.0380, 1.7721],
    [0.2908, 0.0600, 1.6692], [0.1954, 0.0910, 1.2876], [0.0956, 0.1390, 0.8130], [0.0320, 0.2080, 0.4652],
    [0.0049, 0.3230, 0.2720], [0.0093, 0.5030, 0.1582], [0.0633, 0.7100, 0.0782], [0.1655, 0.8620, 0.0422],
    [0.2904, 0.9540, 0.0203], [0.4334, 0.9950, 0.0087], [0.5945, 0.9950, 0.0039], [0.7621, 0.9520, 0.0021],
    [0.9163, 0.8700, 0.0017], [1.0263, 0.7570, 0.0011], [1.0622, 0.6310, 0.0008], [1.0026, 0.5030, 0.0003],
    [0.8544, 0.3810, 0.0002], [0.6424, 0.2650, 0.0000], [0.4479, 0.1750, 0.0000], [0.2835, 0.1070, 0.0000],
    [0.1649, 0.0610, 0.0000], [0.0874, 0.0320, 0.0000], [0.0468, 0.0170, 0.0000], [0.0227, 0.0082, 0.0000],
    [0.0114, 0.0041, 0.0000], [0.0058, 0.0021, 0.0000], [0.0029, 0.0010, 0.0000], [0.0014, 0.0005, 0.0000],
    [0.0007, 0.0003, 0.0000], [0.0003, 0.0001, 0.0000], [0.0002, 0.0001, 0.0000], [0.0001, 0.0000, 0.0000],
    [0.0000, 0.0000, 0.0000],
];

/// X, Y, Z of a spectrum, relative to the same spectrum's if it were 1 everywhere.
pub(crate) fn xyz(spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
    let (mut sums, mut whites) = ([0.0; 3], [0.0; 3]);
    for (interval, ends) in OBSERVER.windows(2).enumerate() {
        for part in 0..FINE {
            let t = (part as f64 + 0.5) / FINE as f64;
            let value = spectrum(FIRST + STEP * (interval as f64 + t));
            for k in 0..3 {
                let weight = ends[0][k] * (1.0 - t) + ends[1][k] * t;
                sums[k] += weight * value;
                whites[k] += weight;
            }
        }
    }
    [0, 1, 2].map(|k| sums[k] / whites[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_energy_is_white() {
        assert_eq!(xyz(|_| 0.5), [0.5; 3]);
    }

    /// CIE 15: illuminant A, a black body of 2856 K, is at x = 0.4476, y = 0.4074.
    #[test]
    fn illuminant_a_is_where_it_should_be() {
        let planck = |nm: f64| (560.0 / nm).powi(5) / ((1.435e7 / (2848.0 * nm)).exp() - 1.0);
        let [x, y, z] = xyz(planck);
        let sum = x + y + z;
        assert!(
            (x / sum - 0.4476).abs() < 3e-4 && (y / sum - 0.4074).abs() < 3e-4,
            "{} {}",
            x / sum,
            y / sum
        );
    }
}
