//! The wavelengths of a path against all lines of the tables.

use super::grid::{N, place, wavelengths_nm};
use super::weights::{Weights, cie_xyz, importance, solar_between, value_at};
use super::{RANGE_NM, VISIBLE_NM, cie, resampled, solar};

/// Lines of a table with their trapezoids, normalised.
fn lines(table: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let table: Vec<_> = table.collect();
    let step = |j: usize| 0.5 * (table[(j + 1).min(table.len() - 1)].0 - table[j.saturating_sub(1)].0);
    let sum: f64 = table.iter().enumerate().map(|(j, line)| line.1 * step(j)).sum();
    table.iter().enumerate().map(|(j, &(nm, value))| (nm, value * step(j) / sum)).collect()
}

/// A name, lines of a table, and the same as weights.
type Functional = (&'static str, Vec<(f64, f64)>, Weights);

/// X, Y, Z and sunlight.
fn functionals() -> [Functional; 4] {
    let cie =
        |k: usize| lines(cie::COLOR_MATCHING.iter().enumerate().map(|(j, bar)| (380.0 + j as f64, bar[k])));
    let sun = lines(solar::IRRADIANCE.iter().enumerate().map(|(j, &w)| (solar::wavelength_nm(j), w)));
    let [x, y, z] = *cie_xyz();
    [("X", cie(0), x), ("Y", cie(1), y), ("Z", cie(2), z), ("Solar", sun, solar_between(RANGE_NM))]
}

fn by_lines(lines: &[(f64, f64)], f: impl Fn(f64) -> f64) -> f64 {
    lines.iter().map(|&(nm, weight)| weight * f(nm)).sum()
}

fn by_grid(weights: &Weights, f: impl Fn(f64) -> f64) -> f64 {
    wavelengths_nm().iter().zip(weights).map(|(&nm, &weight)| f64::from(weight) * f(nm)).sum()
}

#[test]
fn wavelengths_rise_and_end_where_the_range_does() {
    let nm = wavelengths_nm();
    assert!(nm.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!([nm[0], nm[N - 1]], RANGE_NM);
    assert_eq!((place(380.0), place(2500.0), place(551.0)), ((8, 0.0), (N - 2, 1.0), (42, 0.2)));
    assert_eq!((place(0.0), place(1e9)), ((0, 0.0), (N - 2, 1.0)));
}

#[test]
fn cubics_are_exact() {
    for (name, lines, weights) in functionals() {
        for coefficients in
            [[1.0, 0.0, 0.0, 0.0], [0.1, 0.9, 0.0, 0.0], [0.5, -0.2, 0.3, 0.0], [0.4, 0.3, -0.5, 0.6]]
        {
            let f = |nm: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * (nm - 300.0) / 2200.0 + c);
            let [a, b] = [by_grid(&weights, f), by_lines(&lines, f)];
            assert!((a - b).abs() < 3e-7, "{name}: {a} is not {b}");
        }
    }
}

/// The largest errors of X, Y, Z and of sunlight, of single spectra, of products of two, and of products of four: steps and bands whose flanks or widths are
/// `width_nm` wide, wherever they are.
fn errors(width_nm: f64) -> [[f64; 3]; 2] {
    let edge = |at: f64, width: f64| move |nm: f64| 0.05 + 0.9 / (1.0 + (-4.4 * (nm - at) / width).exp());
    let band = |at: f64, width: f64| move |nm: f64| 0.9 * (-2.77 * ((nm - at) / width).powi(2)).exp();
    let mut worst = [[0.0f64; 3]; 2];
    for (k, (_, lines, weights)) in functionals().into_iter().enumerate() {
        for step in 0..40 {
            let at = 390.0 + 23.3 * f64::from(step);
            // Beyond the visible range spectra of building materials are smoother: so are the tables that they are published in.
            let width = if at > VISIBLE_NM[1] { 3.0 * width_nm } else { width_nm };
            let (one, other) = (edge(at, width), band(at + 0.4 * width, 1.5 * width));
            let two = |nm: f64| one(nm) * other(nm);
            let products: [(usize, &dyn Fn(f64) -> f64); 4] =
                [(0, &one), (0, &other), (1, &two), (2, &|nm| two(nm).powi(2))];
            for (order, f) in products {
                let error = (by_grid(&weights, f) - by_lines(&lines, f)).abs();
                worst[k / 3][order] = worst[k / 3][order].max(error);
            }
        }
    }
    worst
}

#[test]
fn errors_of_the_grid_are_small() {
    println!("flanks [nm]   largest errors of one, two, four spectra: X, Y, Z; sunlight");
    for (width, bounds) in [(20.0, [2e-5, 4e-3]), (50.0, [2e-5, 6e-4]), (100.0, [5e-6, 1e-4])] {
        let errors = errors(width);
        let shown = errors.map(|errors| errors.map(|error| format!("{error:.1e}")).join(", "));
        println!("{width:11}   {}; {}", shown[0], shown[1]);
        for (errors, bound) in errors.into_iter().zip(bounds) {
            assert!(errors.iter().all(|&error| error < bound), "{width} nm: {errors:?}");
        }
    }
}

#[test]
fn every_wavelength_counts() {
    let sum: f64 = importance().iter().map(|&w| f64::from(w)).sum();
    assert!((sum - 1.0).abs() < 1e-6 && importance().iter().all(|&w| w > 5e-4));
    assert_eq!(value_at(555.0).iter().filter(|&&w| w > 0.0).count(), 1);
}

#[test]
fn samples_are_joined_and_end_as_in_radiance() {
    let nm = wavelengths_nm();
    let at = |values: &[f64; N], wanted: f64| values[nm.iter().position(|&x| x == wanted).unwrap()];
    let filter = resampled(&[500.0, 520.0, 540.0], &[0.2, 0.6, 0.4]);
    let expected =
        [(485.0, 0.0), (490.0, 0.2), (500.0, 0.2), (505.0, 0.3), (530.0, 0.5), (550.0, 0.4), (555.0, 0.0)];
    for (wavelength, value) in expected {
        assert!((at(&filter, wavelength) - value).abs() < 1e-12, "{wavelength}");
    }
    let paint = resampled(&[400.0, 550.0, 700.0], &[0.3, 0.5, 0.1]);
    for (wavelength, value) in [(300.0, 0.3), (380.0, 0.3), (475.0, 0.4), (780.0, 0.1), (2500.0, 0.1)] {
        assert!((at(&paint, wavelength) - value).abs() < 1e-12, "{wavelength}");
    }
}

#[test]
fn close_samples_all_count() {
    let nm: Vec<f64> = (300..=2500).map(f64::from).collect();
    // Of fringes of 3 nm, samples 5 or 50 nm apart would give anything between 0 and 1.
    let fringes: Vec<f64> = nm.iter().map(|nm| 0.5 + 0.5 * (nm * 2.1).cos()).collect();
    let mean = resampled(&nm, &fringes);
    assert!(mean[88..N - 1].iter().all(|v| (v - 0.5).abs() < 0.15), "{:?}", &mean[88..]);
    let cubic = |nm: f64| {
        let t = (nm - 300.0) / 2200.0;
        0.2 + t * (0.9 - t * (1.3 - 0.7 * t))
    };
    let smooth: Vec<f64> = nm.iter().map(|&nm| cubic(nm)).collect();
    for (found, nm) in resampled(&nm, &smooth).into_iter().zip(wavelengths_nm()) {
        assert!((found - cubic(nm)).abs() < 2e-7, "{nm}: {found} is not {}", cubic(nm));
    }
}

/// What a spectrum comes to line by line: X, Y, Z or Solar.
pub(crate) fn by_table(name: &str, f: impl Fn(f64) -> f64) -> f64 {
    let all = functionals();
    by_lines(&all.iter().find(|functional| functional.0 == name).expect("a functional").1, f)
}

/// The library's locus is that of the table: colours of single wavelengths lie on it, mixtures of two within.
#[test]
fn the_locus_of_the_library_is_that_of_the_observer() {
    use bsdftree::{color::uv_from_xyz, locus::possible};
    let beyond = |uv: [f64; 2]| {
        let [u, v] = possible(uv);
        (uv[0] - u).hypot(uv[1] - v)
    };
    let white = bsdftree::color::WHITE_UV;
    for xyz in cie::COLOR_MATCHING {
        let uv = uv_from_xyz(xyz);
        assert!(beyond(uv) < 0.002, "{uv:?}");
        let far = [white[0] + 1.03 * (uv[0] - white[0]), white[1] + 1.03 * (uv[1] - white[1])];
        assert!(beyond(far) > 0.0, "{far:?}");
        let mixture = std::array::from_fn(|k| xyz[k] + 0.3 * cie::COLOR_MATCHING[230][k]);
        assert!(beyond(uv_from_xyz(mixture)) < 0.002);
    }
}
