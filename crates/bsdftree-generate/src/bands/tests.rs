//! Spectral devices against sums over all lines of the tables.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use bsdftree::color::{uv_from_xyz, xyz_from_yuv};
use bsdftree::{Band as Kept, Basis, Part, Rank, Scattering};
use bsdftree_device::{Device, Unit};

use crate::spectra::tests::by_table;
use crate::{Generated, Layout, Options, Progress, Sides, generate};

const UP: [f64; 3] = [0.36, 0.48, 0.8];

/// A smooth reflectance, and one that falls where it rises.
fn rising(nm: f64) -> f64 {
    0.15 + 0.7 / (1.0 + (-(nm - 560.0) / 60.0).exp())
}

fn falling(nm: f64) -> f64 {
    0.9 - 0.8 / (1.0 + (-(nm - 600.0) / 90.0).exp())
}

/// `spectrum` of a function, each 5 nm from 300 to 2500 nm.
fn spectrum(name: &str, f: impl Fn(f64) -> f64) -> String {
    let mut text = format!("void spectrum {name} 0 0 443 300 2500");
    (0..=440).for_each(|k| write!(text, " {:.9}", f(300.0 + 5.0 * f64::from(k))).unwrap());
    text + "\n"
}

fn device(text: &str) -> Device {
    Device::parse_rad(text, "test.rad", Path::new("."), Unit::Meter).unwrap()
}

fn pane(material: &str, name: &str, z: f64) -> String {
    format!("{material} polygon {name} 0 0 12  0 0 {z}  1 0 {z}  1 1 {z}  0 1 {z}\n")
}

fn run(device: &Device, options: Options) -> Generated {
    let bands = ["Visible", "Solar"].map(|name| name.parse().unwrap());
    let options = Options { bands: bands.into(), sides: Sides::Front, ..options };
    generate(device, &options, &Progress::default()).unwrap()
}

fn klems() -> Options {
    // Averaging with the way back keeps totals but for 1e-4.
    Options {
        samples: 16,
        color: true,
        reciprocity: Some(false),
        ..Options::new(Layout::Klems(Arc::new(Basis::quarter())))
    }
}

/// X, Y, Z of a matrix's totals, and Solar.
fn totals(made: &Generated, part: Part) -> [f64; 4] {
    let of = |band: &Kept| band.component(part).unwrap().clone();
    let [visible, solar] = [0, 1].map(|k| of(&made.bsdf.bands[k]));
    let [x, z] = visible.chroma.unwrap();
    [x, visible.luminance, z, solar.luminance].map(|s| s.hemispherical(UP, false))
}

fn expected(f: impl Fn(f64) -> f64) -> [f64; 4] {
    ["X", "Y", "Z", "Solar"].map(|name| by_table(name, &f))
}

fn assert_near(found: [f64; 4], expected: [f64; 4], tolerance: [f64; 2]) {
    for (k, (found, expected)) in found.into_iter().zip(expected).enumerate() {
        assert!((found - expected).abs() < tolerance[k / 3], "{k}: {found} is not {expected}");
    }
}

#[test]
fn a_spectral_plane_has_the_colour_and_the_solar_reflectance_of_its_spectrum() {
    for material in ["mirror m 0 0 3 1 1 1", "plastic m 0 0 5 1 1 1 0 0", "metal m 0 0 5 1 1 1 .01 0"] {
        let text = spectrum("s", rising) + "s " + material + "\n" + &pane("m", "p", 0.0);
        let made = run(&device(&text), klems());
        assert_near(totals(&made, Part::ReflectionBack), expected(rising), [1e-6, 2e-6]);
        assert!(made.report.warnings.is_empty(), "{:?}", made.report.warnings);
    }
}

#[test]
fn colours_of_trees_are_those_of_the_spectrum() {
    let text = spectrum("s", falling) + "s plastic m 0 0 5 1 1 1 0 0\n" + &pane("m", "p", 0.0);
    let [x, y, z, solar] = expected(falling);
    for reuse in [true, false] {
        let layout = Layout::Tree { rank: Rank::Four, log2_res: 3 };
        let made = run(&device(&text), Options { reuse, color: true, samples: 256, ..Options::new(layout) });
        let component = made.bsdf.bands[0].component(Part::ReflectionBack).unwrap();
        let uv = component.chroma.as_ref().unwrap().each_ref().map(|scattering| match scattering {
            Scattering::Tree(tree) => tree.eval(UP, UP),
            Scattering::Matrix(_) => panic!("a matrix"),
        });
        let uv_expected = uv_from_xyz([x, y, z]);
        for k in 0..2 {
            // The finest difference of u′ and v′ that is kept is 0.001.
            assert!(
                (uv[k] - uv_expected[k]).abs() < 5e-4,
                "{reuse} {k}: {} is not {}",
                uv[k],
                uv_expected[k]
            );
        }
        assert!((xyz_from_yuv(y, uv_expected)[0] - x).abs() < 1e-9);
        let ratio =
            made.bsdf.bands[1].component(Part::ReflectionBack).unwrap().luminance.hemispherical(UP, false)
                / component.luminance.hemispherical(UP, false);
        assert!((ratio / (solar / y) - 1.0).abs() < 1e-4, "{reuse}: {ratio} is not {}", solar / y);
    }
}

#[test]
fn spectra_of_one_path_are_multiplied_before_they_are_averaged() {
    // Light goes straight through two sheets that reflect nothing.
    let text = spectrum("r", rising)
        + &spectrum("f", falling)
        + "r trans a 0 0 7 1 1 1 0 0 1 1\nf trans b 0 0 7 1 1 1 0 0 1 1\n"
        + &pane("a", "front", 0.0)
        + &pane("b", "back", -0.1);
    let options = Options {
        tile: true,
        aperture: Some(crate::Aperture { min: [0.0, 0.0, -0.1], max: [1.0, 1.0, 0.0] }),
        ..klems()
    };
    let found = totals(&run(&device(&text), options), Part::TransmissionBack);
    assert_near(found, expected(|nm| rising(nm) * falling(nm)), [1e-6, 3e-6]);
    let of_means: Vec<f64> = expected(rising).iter().zip(expected(falling)).map(|(a, b)| a * b).collect();
    assert!((found[1] - of_means[1]).abs() > 0.009 && (found[3] - of_means[3]).abs() > 0.06);
}

#[test]
fn a_cavity_has_the_sum_of_its_series_at_each_wavelength() {
    // A sheet that diffuses half of its light to each side, over a floor, both without end: of light between them, the floor sends up f, of which c/2 comes back.
    let text = spectrum("r", rising)
        + &spectrum("f", falling)
        + "r trans sheet 0 0 7 1 1 1 0 0 .5 0\nf plastic floor 0 0 5 1 1 1 0 0\n"
        + &pane("sheet", "front", 0.0)
        + &pane("floor", "back", -0.1);
    let reflectance = |nm: f64| {
        let (half, floor) = (0.5 * rising(nm), falling(nm));
        half + half * half * floor / (1.0 - floor * half)
    };
    let [_, y, _, solar] = expected(reflectance);
    let aperture = Some(crate::Aperture { min: [0.0, 0.0, -0.1], max: [1.0, 1.0, 0.0] });
    for reuse in [true, false] {
        let layout = Layout::Tree { rank: Rank::Four, log2_res: 3 };
        let made = run(
            &device(&text),
            Options { tile: true, aperture, reuse, samples: 512, ..Options::new(layout) },
        );
        for (band, expected) in made.report.bands.iter().zip([y, solar]) {
            let totals = band.totals.iter().find(|totals| totals.part == Part::ReflectionBack).unwrap();
            let n = totals.values.len() as f64;
            let mean = totals.values.iter().sum::<f64>() / n;
            let error = totals.errors.iter().map(|e| e * e).sum::<f64>().sqrt() / n;
            assert!(error < 2e-3, "{reuse} {}: {error}", band.name);
            // A model of light that is diffused knows wavelengths in groups.
            let limit = if reuse { 4.5 * error + 4e-4 } else { 4.5 * error };
            assert!((mean - expected).abs() < limit, "{reuse} {}: {mean} ± {error}, {expected}", band.name);
        }
    }
}

#[test]
fn spectra_that_end_early_are_told() {
    let text = "void spectrum s 0 0 6 400 700 .2 .4 .6 .8\ns mirror m 0 0 3 1 1 1\n".to_owned()
        + &pane("m", "p", 0.0);
    let made = run(&device(&text), klems());
    assert!(made.report.warnings.iter().any(|w| w.contains("spectra of m do not reach from 300 to 2500 nm")));
    let visible = Options { sides: Sides::Front, ..klems() };
    let made = generate(&device(&text), &visible, &Progress::default()).unwrap();
    assert!(made.report.warnings.is_empty(), "{:?}", made.report.warnings);
}
