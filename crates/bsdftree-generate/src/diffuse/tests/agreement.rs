//! Models and light never diffused, together, against plain paths: totals of incident cells, and blocks of 4⁴.

use bsdftree::Rank;
use bsdftree_device::Device;

use super::super::*;
use super::support::*;
use crate::layout::Layout;
use crate::options::Aperture;

const WALKS: u64 = 2048;
const PATHS: u64 = 40_000;

/// Largest part by which patches may put totals wrong, and blocks: of themselves, and of the mean over blocks.
const OFF_TOTAL: f64 = 0.006;
const OFF_BLOCK: [f64; 2] = [0.02, 0.02];

fn blocks() -> Layout {
    Layout::Tree { rank: Rank::Four, log2_res: 2 }
}

fn agrees(setup: &Setup<f64>) {
    agrees_with(setup, Fineness::default());
}

fn agrees_with(setup: &Setup<f64>, fineness: Fineness) {
    let n = 16;
    let omega = std::f64::consts::PI / n as f64;
    let modelled = setup.model(fineness, WALKS, 4096);
    for side in SIDES {
        let f = setup.total(&modelled, side);
        let [plain, variance] = setup.plain(side, PATHS);
        for i in 0..n {
            let row = 2 * n * i..2 * n * (i + 1);
            let sum = |f: &[f64]| f[row.clone()].iter().sum::<f64>() * omega;
            let (total, expected) = (sum(&f), sum(&plain));
            // Light never diffused is counted from a tenth of the paths; 4.5 standard errors of both.
            let error = (11.0 * expected * (1.0 - expected).max(0.0) / PATHS as f64).sqrt();
            assert!(
                (total - expected).abs() <= OFF_TOTAL * expected + 4.5 * error,
                "{side:?} cell {i}: {total}, expected {expected} ± {error}"
            );
            assert!(total < 1.0 + 4.5 * error, "{side:?} cell {i}: {total}");
            for k in row {
                let error = (11.0 * variance[k]).sqrt() + 11.0 / (PATHS as f64 * omega);
                let off = OFF_BLOCK[0] * plain[k] + OFF_BLOCK[1] * expected / (2.0 * std::f64::consts::PI);
                assert!(
                    (f[k] - plain[k]).abs() < off + 5.0 * error,
                    "{side:?} cell {i} block {}: {}, expected {} ± {error}",
                    k % (2 * n),
                    f[k],
                    plain[k]
                );
            }
        }
    }
}

fn family(spec: &str, tiled: bool) -> Setup<f64> {
    Setup::new(Device::from_spec(spec).unwrap(), tiled, blocks())
}

#[test]
fn grooves_of_mirrors_and_diffusers() {
    agrees(&family("sawtooth", true));
    agrees(&family("sawtooth:height=0.2,width=0.1", false));
}

#[test]
fn blinds_that_repeat_and_that_end() {
    agrees(&family("blinds:angle=30,rise=0.005", true));
    agrees(&family(
        "blinds:angle=-20,reflectance=0.9,height=0.2,width=0.3,specular=0.1,roughness=0.1",
        false,
    ));
    agrees(&family("blinds:angle=45,glazing=0.8", true));
}

#[test]
fn a_part_of_a_device_seen_through_a_smaller_aperture() {
    let device = Device::from_spec("blinds:angle=30,height=0.2,width=0.3").unwrap();
    let [low, high] = device.bounds().unwrap();
    // Beside the aperture, and above its plane, there is more of the device.
    let aperture = Aperture { min: [-0.05, -0.04, low.z], max: [0.05, 0.04, 0.5 * (low.z + high.z)] };
    // Most of the device is in the dark, so that many patches are needed.
    let fineness = Fineness { max_sites: 1024, tolerance: 1e-6, n_pilot: 4096, ..Fineness::default() };
    agrees_with(&Setup::through(device, false, blocks(), aperture), fineness);
}

#[test]
fn valleys_of_nothing_but_diffusers() {
    let mut device = rad("void plastic white 0 0 5 .9 .9 .9 0 0
        white polygon up 0 0 12  0 0 -.5  1 0 -.5  1 .5 0  0 .5 0
        white polygon down 0 0 12  0 -.5 0  1 -.5 0  1 0 -.5  0 0 -.5");
    device.tile = device.bounds();
    agrees(&Setup::new(device, true, blocks()));
}

#[test]
fn translucent_plates() {
    let plate = "polygon plate 0 0 12  0 0 0  1 0 0  1 1 0  0 1 0";
    agrees(&Setup::new(rad(&format!("void trans t 0 0 7 .8 .8 .8 .05 0 .6 .3\nt {plate}")), false, blocks()));
    // Rough transmission, which is not the same both ways, before a diffuser.
    let behind = "void plastic white 0 0 5 .7 .7 .7 0 0
        white polygon behind 0 0 12  0 0 -.1  1 0 -.1  1 1 -.1  0 1 -.1";
    let rough = format!("void trans t 0 0 7 .8 .8 .8 .02 .2 .8 .8\nt {plate}\n{behind}");
    agrees(&Setup::new(rad(&rough), false, blocks()));
}

#[test]
fn diffusers_inside_a_dielectric() {
    // The tile goes on sideways for ever, so that the slab needs no edges. The medium absorbs, also between the two faces.
    let text = "void dielectric d 0 0 5 .5 .5 .5 1.5 0
        d polygon top 0 0 12  0 0 0  1 0 0  1 1 0  0 1 0
        void plastic white 0 0 5 .9 .9 .9 .04 0
        white polygon up 0 0 12  0 0 -.1  0 .5 -.7  1 .5 -.7  1 0 -.1
        white polygon down 0 0 12  0 .5 -.7  0 1 -.1  1 1 -.1  1 .5 -.7";
    let mut device = rad(text);
    device.tile = device.bounds();
    agrees(&Setup::new(device, true, blocks()));
}

#[test]
fn spheres_and_cylinders() {
    let mut text =
        String::from("void plastic shiny 0 0 5 .7 .7 .7 .05 0\nvoid metal rough 0 0 5 .8 .8 .8 .5 .2\n");
    for k in 0..3 {
        let y = 0.25 * f64::from(k);
        text += &format!("shiny cylinder c{k} 0 0 7  0 {y} -.1  1 {y} -.1  .1\n");
        text += &format!("rough sphere s{k} 0 0 4  {} .25 -.35 .12\n", 0.2 + 0.3 * f64::from(k));
    }
    text += "shiny cone top 0 0 8  .5 .7 -.4  .5 .7 -.05  .15 .02\n";
    agrees(&Setup::new(rad(&text), false, blocks()));
}

#[test]
fn a_mesh_that_is_a_bowl() {
    let bowl = bowl(24, 0.8);
    let setup = Setup::<f64>::new(bowl, false, blocks());
    agrees(&setup);
    // In a sphere all places see each other alike: half of what is sent out of the wall leaves a hemisphere. The
    // aperture is the square around the rim.
    let modelled = setup.model(Fineness::default(), 1024, 4096);
    let f = setup.total(&modelled, bsdftree::Side::Front);
    let expected = std::f64::consts::PI / 9.0 * 0.4 / (1.0 - 0.4);
    for i in 0..16 {
        let total = f[32 * i..32 * i + 16].iter().sum::<f64>() * std::f64::consts::PI / 16.0;
        assert!((total - expected).abs() < 0.02 * expected, "cell {i}: {total}, expected {expected}");
    }
}

/// A hemisphere of radius 1 below z = 0 of `n` × 4 `n` facets, with a black rim around it.
fn bowl(n: u32, reflectance: f64) -> Device {
    let mut text = format!("void plastic white 0 0 5 {reflectance} {reflectance} {reflectance} 0 0\n");
    let at = |i: u32, j: u32| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(n)).sin_cos();
        let (y, x) = (std::f64::consts::TAU * f64::from(j) / f64::from(4 * n)).sin_cos();
        format!("{} {} {}  ", sin * x, sin * y, -cos)
    };
    for i in 0..n {
        for j in 0..4 * n {
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1)];
            text += &format!("white polygon a{i}.{j} 0 0 9 {}\n", corners.concat());
            if i > 0 {
                let corners = [at(i, j), at(i + 1, j + 1), at(i, j + 1)];
                text += &format!("white polygon b{i}.{j} 0 0 9 {}\n", corners.concat());
            }
        }
    }
    text += "void plastic black 0 0 5 0 0 0 0 0\nblack ring rim 0 0 8  0 0 0  0 0 1  1 1.5\n";
    rad(&text)
}
