//! Devices that repeat for ever against large finite ones, and what a tile must not lose. Fixed seeds.

use std::sync::Arc;

use bsdftree::square::disk_from_square;
use bsdftree::{Band, Basis, Bsdf, Lobes, Rank, Side};
use bsdftree_device::Device;
use bsdftree_generate::{Aperture, Generated, Layout, Options, Progress, generate};

const SAMPLES: u64 = 4000;

fn run(spec: &str, options: &Options) -> Bsdf {
    let Generated { bsdf, report, .. } =
        generate(&Device::from_spec(spec).unwrap(), options, &Progress::default()).unwrap();
    assert_eq!(report.lost, 0);
    bsdf
}

fn klems() -> Options {
    Options { samples: SAMPLES, ..Options::new(Layout::Klems(Arc::new(Basis::quarter()))) }
}

fn visible(bsdf: &Bsdf) -> &Band {
    bsdf.band("Visible").unwrap()
}

/// Compares totals of all patches from both sides, at five standard errors of the difference of two counts.
fn agree(tiled: &Bsdf, large: &Bsdf) {
    let basis = Basis::quarter();
    for side in [Side::Front, Side::Back] {
        for patch in 0..basis.n_patches() {
            let incident = side.direction_from_disk(basis.disk_point(patch, 0.5, 0.5));
            for lobes in [Lobes::Reflection, Lobes::Transmission] {
                let [a, b] = [tiled, large].map(|bsdf| visible(bsdf).hemispherical(incident, lobes));
                let error = (2.0 * (a * (1.0 - a)).max(0.01) / SAMPLES as f64).sqrt();
                assert!(
                    (a - b).abs() < 5.0 * error,
                    "{side:?} patch {patch} {lobes:?}: {a} tiled, {b} large"
                );
            }
        }
    }
}

#[test]
fn a_tile_of_blinds_scatters_as_the_middle_of_a_50_times_larger_blind() {
    let tiled = run("blinds:angle=30,specular=0.1", &Options { tile: true, ..klems() });
    let large = "blinds:angle=30,specular=0.1,width=50,height=50";
    let [low, high] = Device::from_spec(large).unwrap().tile.unwrap();
    let middle = Aperture { min: [-0.5, low.y, low.z], max: [0.5, high.y, high.z] };
    agree(&tiled, &run(large, &Options { aperture: Some(middle), ..klems() }));
}

#[test]
fn a_tile_of_a_prismatic_panel_refracts_as_the_middle_of_a_large_one() {
    let tiled = run("prism", &Options { tile: true, ..klems() });
    let large = "prism:width=50,height=50";
    let [low, high] = Device::from_spec(large).unwrap().tile.unwrap();
    let middle = Aperture { min: [-0.5, low.y, low.z], max: [0.5, high.y, high.z] };
    agree(&tiled, &run(large, &Options { aperture: Some(middle), ..klems() }));
}

#[test]
fn tiles_of_opaque_devices_let_nothing_through_and_tiles_of_lossless_ones_lose_nothing() {
    let tree = Options {
        tile: true,
        samples: 300,
        reuse: false,
        reciprocity: Some(false),
        ..Options::new(Layout::Tree { rank: Rank::Four, log2_res: 3 })
    };
    let totals = |bsdf: &Bsdf, lobes| {
        let band = visible(bsdf).clone();
        (0..64).map(move |k| {
            let square = [k / 8, k % 8].map(|c| (f64::from(c) + 0.5) / 8.0);
            band.hemispherical(Side::Front.direction_from_disk(disk_from_square(square)), lobes)
        })
    };
    let sawtooth = run("sawtooth", &tree);
    assert!(totals(&sawtooth, Lobes::Transmission).all(|t| t == 0.0));
    let clear = run("prism:transmittance=1", &Options { pruned: false, ..tree.clone() });
    for total in totals(&clear, Lobes::All) {
        assert!((total - 1.0).abs() < 1e-6, "{total}");
    }
    let sheet = run("perforated:reflectance=1,thickness=0", &Options { pruned: false, ..tree });
    for total in totals(&sheet, Lobes::All) {
        assert!((total - 1.0).abs() < 1e-6, "{total}");
    }
}

#[test]
fn a_device_of_unknown_period_is_not_tiled() {
    let device = Device::from_spec("mirror:shape=disk").unwrap();
    let error = generate(&device, &Options { tile: true, ..klems() }, &Progress::default()).unwrap_err();
    assert!(error.to_string().contains("--dim"), "{error}");
}
