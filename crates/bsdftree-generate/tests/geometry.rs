//! The geometry inside a BSDF file: put there by a generation, and generated again from. Fixed seeds.

use std::sync::Arc;

use bsdftree::xml::{Strictness, read_file};
use bsdftree::{Band, Basis, Bsdf, LengthUnit, Lobes, Side};
use bsdftree_device::{Device, Unit};
use bsdftree_generate::{Aperture, Generated, Layout, Options, Progress, generate};
use bsdftree_testing::real_file;

fn options(samples: u64) -> Options {
    Options { samples, ..Options::new(Layout::Klems(Arc::new(Basis::full()))) }
}

fn visible(bsdf: &Bsdf) -> &Band {
    bsdf.band("Visible").unwrap()
}

#[test]
fn a_generation_puts_its_device_into_the_file() {
    let device = Device::from_spec("blinds:depth=0.05,spacing=0.04,glazing=0.88").unwrap();
    let options = Options { geometry: true, unit: LengthUnit::Inch, ..options(1) };
    let Generated { bsdf, report, .. } = generate(&device, &options, &Progress::default()).unwrap();
    let geometry = bsdf.header.geometry.unwrap();
    assert_eq!(geometry.unit, LengthUnit::Inch);
    let again = Device::from_bsdf_geometry(&geometry, Unit::Meter).unwrap();
    assert_eq!((again.surfaces.len(), again.warnings.len()), (device.surfaces.len(), 0));
    let Aperture { min, max } = report.aperture;
    let [low, high] = again.bounds().unwrap();
    for (k, (low, high)) in [(low.x, high.x), (low.y, high.y)].into_iter().enumerate() {
        assert!((low + high).abs() < 1e-12, "{k} is centred");
        assert!((high - low - (max[k] - min[k])).abs() < 1e-12);
    }
    assert!((low.z - min[2]).abs() < 1e-12 && (high.z - max[2]).abs() < 1e-12);
}

#[test]
fn a_device_that_repeats_is_as_large_as_its_geometry() {
    let device = Device::from_spec("blinds:depth=0.05,spacing=0.04,width=0.5,height=0.2").unwrap();
    for (geometry, height) in [(true, 0.16), (false, 0.04)] {
        // Slats that lie flat: the drawing ends half a spacing below the top and above the bottom.
        let options = Options { tile: true, geometry, ..options(1) };
        let Generated { bsdf, .. } = generate(&device, &options, &Progress::default()).unwrap();
        assert!((bsdf.header.height.unwrap() - height).abs() < 1e-12);
    }
}

#[test]
fn what_the_geometry_does_not_say_is_warned_of() {
    let device = Device::from_spec("mirror").unwrap();
    let options = Options { geometry: true, ..options(1) };
    let warnings = generate(&device, &options, &Progress::default()).unwrap().report.warnings;
    assert!(
        warnings.iter().any(|w| w.starts_with("the geometry in the file does not say all: material")),
        "{warnings:?}"
    );
    let without = generate(&device, &self::options(1), &Progress::default()).unwrap();
    assert!(without.bsdf.header.geometry.is_none() && without.report.warnings.is_empty());
}

/// Asserts that the hemispherical totals of a file are those of a generation from its own geometry: in the mean over all patches
/// within `mean`, and of each patch within half a percent and four standard errors of the file's `n` samples.
fn assert_made_of_its_geometry(name: &str, sides: &[Side], n: f64, mean: f64) {
    let Some(path) = real_file(name) else { return };
    let (file, _) = read_file(&path, Strictness::Repair).unwrap();
    let device = Device::read_bsdf_geometry(&path, Unit::Meter).unwrap().unwrap();
    let header = &file.header;
    let [width, height, thickness] = [header.width, header.height, header.thickness].map(Option::unwrap);
    let aperture =
        Aperture { min: [-width / 2.0, -height / 2.0, -thickness], max: [width / 2.0, height / 2.0, 0.0] };
    let options = Options { aperture: Some(aperture), reuse: false, ..options(4000) };
    let made = generate(&device, &options, &Progress::default()).unwrap().bsdf;
    let basis = Basis::full();
    for &side in sides {
        for lobes in [Lobes::Reflection, Lobes::Transmission] {
            let mut differences = 0.0;
            for patch in 0..basis.n_patches() {
                let incident = side.direction_from_disk(basis.disk_point(patch, 0.5, 0.5));
                let [a, b] = [&made, &file].map(|bsdf| visible(bsdf).hemispherical(incident, lobes));
                let noise = ((b * (1.0 - b)).max(0.01) / n).sqrt();
                assert!(
                    (a - b).abs() < 0.005 + 4.0 * noise,
                    "{name} {side:?} {lobes:?} patch {patch}: {a} made, {b} in the file"
                );
                differences += a - b;
            }
            let difference = differences / basis.n_patches() as f64;
            assert!(difference.abs() < mean, "{name} {side:?} {lobes:?}: {difference}");
        }
    }
}

/// Blinds behind a pane, 10 000 samples. The pane's transmittance taken as its transmissivity would show.
#[test]
fn blinds_of_pyradiance_come_again_from_their_geometry() {
    assert_made_of_its_geometry("pyradiance/blinds.xml", &[Side::Front, Side::Back], 1e4, 0.001);
}

/// Light from the room only, 500 samples, a part of the device.
#[test]
fn blinds_of_frads_come_again_from_their_geometry() {
    assert_made_of_its_geometry("frads/blinds30.xml", &[Side::Front], 500.0, 0.002);
}

/// Half of the light from the front comes back; from behind, nothing is there.
#[test]
fn one_sided_faces_are_not_there_from_behind() {
    let square = "v a =\np -1 -1 0\nv b =\np 1 -1 0\nv c =\np 1 1 0\nv d =\np -1 1 0\n";
    for (sides, behind) in [(1, [0.0, 1.0]), (2, [0.5, 0.0])] {
        let text = format!("m x =\nrd .5\nsides {sides}\n{square}f a b c d\n");
        let device = Device::parse_mgf(&text, "face.mgf", ".".as_ref(), Unit::Meter).unwrap();
        let bsdf = generate(&device, &options(200), &Progress::default()).unwrap().bsdf;
        let basis = Basis::full();
        for patch in 0..basis.n_patches() {
            let point = basis.disk_point(patch, 0.5, 0.5);
            for (side, expected) in [(Side::Front, [0.5, 0.0]), (Side::Back, behind)] {
                let incident = side.direction_from_disk(point);
                for (lobes, expected) in [Lobes::Reflection, Lobes::Transmission].into_iter().zip(expected) {
                    let total = visible(&bsdf).hemispherical(incident, lobes);
                    assert!((total - expected).abs() < 1e-3, "sides {sides} {side:?} {lobes:?}: {total}");
                }
            }
        }
    }
}

/// At normal incidence: what is said of the material is what the surface does. Facets of rough highlights lose one percent of them.
#[test]
fn surfaces_do_what_mgf_says() {
    let square = "v a =\np -1 -1 0\nv b =\np 1 -1 0\nv c =\np 1 1 0\nv d =\np -1 1 0\nf a b c d\n";
    for (material, reflected, transmitted) in [
        ("rd .5\nrs .05 .1", 0.55, 0.0),
        ("c\ncxy .4 .4\nrd .5\nc\nrs .15 .1", 0.65, 0.0),
        ("c\ncxy .4 .4\nrd .1\nrs .6 .1", 0.7, 0.0),
        ("c\ncxy .4 .4\nrd .02\nrs .01 .1", 0.03, 0.0),
        ("rd .3\ntd .2\nts .1 .1\nrs .05 .1", 0.35, 0.3),
        ("td .004\nrd .4", 0.4, 0.004),
        ("c\ncct 3000\ntd .7\nc\nrs .1 .1", 0.1, 0.7),
        (
            "c\ncxy .4 .4\nrd .2\nc\ncxy .25 .3\ntd .3\nc\ncxy .3 .4\nts .2 .1\nc\ncxy .35 .3\nrs .1 .2",
            0.3,
            0.5,
        ),
        ("ir 1.52 0\nrs .08 0\nts .88 0", 0.0802, 0.88),
        ("rd 0", 0.0, 0.0),
    ] {
        let text = format!("m x =\n{material}\n{square}");
        let device = Device::parse_mgf(&text, "face.mgf", ".".as_ref(), Unit::Meter).unwrap();
        let bsdf = generate(&device, &options(4000), &Progress::default()).unwrap().bsdf;
        for incident in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
            let total = |lobes| visible(&bsdf).hemispherical(incident, lobes);
            let (r, t) = (total(Lobes::Reflection), total(Lobes::Transmission));
            assert!((r - reflected).abs() < 0.008 && (t - transmitted).abs() < 0.008, "{material}: {r} {t}");
        }
    }
}
