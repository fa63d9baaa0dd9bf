//! Generation in several bands: what is known in closed form, and that nothing depends on how the work was divided.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use bsdftree::color::{uv_from_xyz, xyz_from_rgb};
use bsdftree::xml::Strictness;
use bsdftree::{Basis, Bsdf, Direction, Lobes, Part, Rank, Scattering};
use bsdftree_device::{Device, Unit};
use bsdftree_generate::{Band, Generated, Layout, Options, Progress, Sides, generate, generate_bands};

fn device(text: &str) -> Device {
    Device::parse_rad(text, "test.rad", Path::new("."), Unit::Meter).unwrap()
}

fn bands(names: &str) -> Vec<Band> {
    names.split(',').map(|name| name.parse().unwrap()).collect()
}

fn klems() -> Layout {
    Layout::Klems(Arc::new(Basis::quarter()))
}

fn tree(log2_res: u32) -> Layout {
    Layout::Tree { rank: Rank::Four, log2_res }
}

fn run(device: &Device, options: &Options) -> Generated {
    generate(device, options, &Progress::default()).unwrap()
}

fn total(bsdf: &Bsdf, band: &str, incident: Direction, lobes: Lobes) -> f64 {
    bsdf.band(band).unwrap_or_else(|| panic!("no {band}")).hemispherical(incident, lobes)
}

/// Hemispherical X, Y, Z of a part of a matrix.
fn xyz(bsdf: &Bsdf, part: Part, incident: Direction) -> [f64; 3] {
    let component = bsdf.band("Visible").unwrap().component(part).unwrap();
    let [x, z] = component.chroma.as_ref().unwrap();
    [x, &component.luminance, z].map(|scattering| scattering.hemispherical(incident, false))
}

const DOWN: Direction = [0.36, 0.48, 0.8];
const PANE: &str = "polygon pane 0 0 12  0 0 0  1 0 0  1 1 0  0 1 0";

#[test]
fn one_coloured_surface_is_the_same_with_rgb_and_with_wavelengths() {
    let rgb = [0.8, 0.1, 0.3];
    let [r, g, b] = rgb;
    for material in
        [format!("void mirror m 0 0 3 {r} {g} {b}"), format!("void plastic m 0 0 5 {r} {g} {b} 0 0")]
    {
        let red = device(&format!("{material}\nm {PANE}"));
        let options = Options {
            samples: 64,
            sides: Sides::Front,
            color: true,
            // Averaging with the way back keeps totals but for 1e-4.
            reciprocity: Some(false),
            ..Options::new(klems())
        };
        let spectral = run(&red, &Options { bands: bands("Visible,Solar"), ..options.clone() });
        let plain = run(&red, &options);
        let [found, by_rgb] = [&spectral, &plain].map(|made| xyz(&made.bsdf, Part::ReflectionBack, DOWN));
        for k in 0..3 {
            let expected = xyz_from_rgb(rgb)[k];
            assert!((by_rgb[k] - expected).abs() < 1e-6, "{k}: {} is not {expected}", by_rgb[k]);
            assert!((found[k] - expected).abs() < 2e-6, "{k}: {} is not {expected}", found[k]);
        }
        // Beyond the visible range, and told so, the grey of its luminance.
        let infrared = run(&red, &Options { bands: bands("NIR"), ..options });
        let luminance = xyz_from_rgb(rgb)[1];
        let found = total(&infrared.bsdf, "NIR", DOWN, Lobes::Reflection);
        assert!((found - luminance).abs() < 2e-3, "{found} is not {luminance}");
        assert!(spectral.report.warnings.iter().any(|w| w.contains("what m are beyond the visible range")));
        assert!(plain.report.warnings.is_empty());
    }
}

#[test]
fn greys_are_the_same_in_every_band_and_colourless() {
    let grey = device(&format!("void plastic m 0 0 5 .5 .5 .5 0 0\nm {PANE}"));
    let options = Options { samples: 64, sides: Sides::Front, color: true, ..Options::new(tree(3)) };
    let made = run(&grey, &Options { bands: bands("Visible,Solar,NIR,UV,550,PAR:400-700"), ..options });
    let white = uv_from_xyz([1.0; 3]);
    for band in &made.bsdf.bands {
        let component = band.component(Part::ReflectionBack).unwrap();
        assert!((component.luminance.hemispherical(DOWN, false) - 0.5).abs() < 0.02, "{}", band.name);
        assert_eq!(component.chroma.is_some(), band.name == "Visible");
        for (k, chroma) in component.chroma.iter().flatten().enumerate() {
            let Scattering::Tree(tree) = chroma else { panic!("a matrix") };
            assert!(tree.leaves().all(|leaf| (f64::from(leaf.value) - white[k]).abs() < 1e-5));
        }
    }
    let names: Vec<_> = made.report.bands.iter().map(|band| band.name.as_str()).collect();
    assert_eq!(names, ["Visible", "Solar", "NIR", "UV", "550", "PAR"]);
}

/// Three coloured slats before a coloured wall.
fn coloured() -> Device {
    let mut text = String::from(
        "void plastic red 0 0 5 .8 .2 .1 .05 .1\nvoid metal green 0 0 5 .2 .7 .3 .5 .2\nvoid trans blue 0 0 7 .3 .4 .9 0 0 .5 .3\n",
    );
    for (k, material) in ["red", "green", "blue"].into_iter().enumerate() {
        let x = k as f64;
        writeln!(
            text,
            "{material} polygon slat{k} 0 0 12 {x} 0 -.5 {x} 2 -.5 {} 2 0 {} 0 0",
            x + 0.7,
            x + 0.7
        )
        .unwrap();
    }
    text += "green polygon wall 0 0 12 0 0 -.6 1.4 0 -.6 1.4 2 -.6 0 2 -.6\n";
    device(&text)
}

fn bits(made: &Generated) -> String {
    format!("{:?} {:?} {}", made.bsdf.bands, made.errors.bands, made.report.paths)
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for reuse in [true, false] {
        let options = Options {
            samples: 96,
            color: true,
            bands: bands("Visible,Solar"),
            reuse,
            ..Options::new(tree(3))
        };
        let of = |threads| bits(&run(&coloured(), &Options { threads: Some(threads), ..options.clone() }));
        let one = of(1);
        assert!(of(2) == one && of(7) == one, "reuse {reuse}");
    }
}

#[test]
fn a_generation_that_was_stopped_goes_on_with_the_same_bits() {
    let directory = tempfile::tempdir().unwrap();
    let options = Options { samples: 128, bands: bands("Visible,NIR"), ..Options::new(tree(2)) };
    let whole = bits(&run(&coloured(), &options));
    let kept = Options { checkpoint: Some(directory.path().into()), ..options.clone() };
    run(&coloured(), &Options { samples: 64, ..kept.clone() });
    let file = directory.path().join("0-64.blocks");
    let length = std::fs::metadata(&file).unwrap().len();
    std::fs::File::options().write(true).open(&file).unwrap().set_len(length * 2 / 3).unwrap();
    assert!(bits(&run(&coloured(), &kept)) == whole);
    let other =
        generate(&coloured(), &Options { bands: bands("Visible,Solar"), ..kept }, &Progress::default());
    let error = other.unwrap_err().to_string();
    assert!(error.contains("bands Visible, Solar here, but Visible, NIR there"), "{error}");
}

#[test]
fn reuse_and_full_paths_agree_in_every_band() {
    let options = Options {
        samples: 1024,
        sides: Sides::Front,
        bands: bands("Visible,NIR,450"),
        reciprocity: Some(false),
        ..Options::new(tree(2))
    };
    let device = coloured();
    let [reused, plain] = [true, false].map(|reuse| run(&device, &Options { reuse, ..options.clone() }));
    let mut squares = Vec::new();
    for (a, b) in reused.report.bands.iter().zip(&plain.report.bands) {
        for (a, b) in a.totals.iter().zip(&b.totals) {
            for k in 0..a.values.len() {
                let error = a.errors[k].hypot(b.errors[k]);
                assert!(error > 0.0 && error < 0.05, "{:?} {k}: {error}", a.part);
                squares.push(((a.values[k] - b.values[k]) / error).powi(2));
            }
        }
    }
    // Means of squares of 96 values of Student's t with 7 degrees of freedom, a little correlated: 1.4 ± 0.3.
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!(mean < 2.5, "{mean} of {}", squares.len());
    assert!(squares.iter().all(|z| *z < 49.0), "{squares:?}");
}

#[test]
fn bands_with_materials_of_their_own_are_generations_of_their_own() {
    let pane = |reflectance: f64| {
        device(&format!("void mirror m 0 0 3 {reflectance} {reflectance} {reflectance}\nm {PANE}"))
    };
    let options = Options { samples: 32, sides: Sides::Front, ..Options::new(klems()) };
    let own = [("Solar".parse().unwrap(), pane(0.3)), (Band::named("FIR").unwrap(), pane(0.9))];
    let made = generate_bands(&pane(0.6), &own, &options, &Progress::default()).unwrap();
    for (band, expected) in [("Visible", 0.6), ("Solar", 0.3), ("FIR", 0.9)] {
        assert!((total(&made.bsdf, band, DOWN, Lobes::Reflection) - expected).abs() < 1e-6, "{band}");
        assert!(made.errors.band(band).is_some() && made.report.bands.iter().any(|b| b.name == band));
    }
    assert_eq!(made.report.paths, 3 * 41 * 32);
    assert!(made.report.warnings.is_empty(), "{:?}", made.report.warnings);
    let twice = [own[0].clone(), own[0].clone()];
    let error = generate_bands(&pane(0.6), &twice, &options, &Progress::default()).unwrap_err();
    assert!(error.to_string().contains("two devices for the band Solar"));
}

#[test]
fn what_is_the_same_in_two_bands_comes_out_the_same() {
    let options = Options { samples: 64, ..Options::new(tree(3)) };
    let blinds = Device::from_spec("blinds").unwrap();
    let own = [("Solar".parse().unwrap(), blinds.clone())];
    let made = generate_bands(&blinds, &own, &options, &Progress::default()).unwrap();
    let [visible, solar] =
        [0, 1].map(|k| format!("{:?}", made.bsdf.bands[k]).replacen("Solar", "Visible", 1));
    assert!(visible == solar);
}

#[test]
fn files_of_several_bands_come_back() {
    let options =
        Options { samples: 64, color: true, bands: bands("Visible,Solar,NIR,850"), ..Options::new(tree(3)) };
    let made = run(&coloured(), &options).bsdf;
    let mut text = Vec::new();
    bsdftree::xml::write(&made, &mut text).unwrap();
    let (back, repairs) = bsdftree::xml::read(&text, Strictness::Strict).unwrap();
    assert!(repairs.is_empty());
    assert_eq!(format!("{:?}", back.bands), format!("{:?}", made.bands));
    let text = String::from_utf8(text).unwrap();
    assert!(
        text.contains("<Wavelength unit=\"Nanometer\">850<")
            && text.contains("<Wavelength unit=\"Integral\">NIR<")
    );
}
