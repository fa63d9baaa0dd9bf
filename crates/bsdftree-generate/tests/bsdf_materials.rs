//! Surfaces that scatter as BSDF files say: beside the files themselves, and beside Radiance.
//!
//! Statistics: fixed seeds; bounds on |z| are exceeded by a right sampler with a probability below 1e-4 a test.

mod radiance;

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use bsdftree::color::{uv_from_xyz, xyz_from_rgb};
use bsdftree::{Band, Basis, Component, Lobes, Part, Rank, Scattering, Side, Tree, xml};
use bsdftree_device::field::{File, digest};
use bsdftree_device::material::{BsdfFile, Measured, Orientation};
use bsdftree_device::{Device, Material, NamedMaterial, Shape, Surface, Unit};
use bsdftree_generate::path::{Outcome, Scene};
use bsdftree_generate::random::Random;
use bsdftree_generate::{Layout, Options, Progress, generate, generate_bands};
use bsdftree_testing::READABLE;
use glam::DVec3;

fn read(name: &str) -> Option<BsdfFile> {
    let path = radiance::real_file(name)?;
    let bytes = std::fs::read(&path).unwrap();
    let file = File { path: path.display().to_string().into(), digest: digest(&bytes) };
    Some(BsdfFile::parse(&bytes, file).unwrap().0)
}

/// A large pane at z = 0 whose front is up.
fn pane(material: Material) -> Device {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let shape = Shape::Polygon(corners.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect());
    Device {
        surfaces: vec![Surface { name: "pane".into(), shape, material: 0 }],
        materials: vec![NamedMaterial { name: "m".into(), material }],
        ..Device::default()
    }
}

fn measured(file: &BsdfFile, through: bool) -> Measured {
    Measured { file: file.clone(), up: Orientation::Constant(DVec3::Y), diffuse: [DVec3::ZERO; 3], through }
}

/// Incident directions, uniform in projected solid angle, half of them from the back.
fn incident(random: &mut Random, k: usize) -> DVec3 {
    let (radius, phi) = (random.next_f64().sqrt(), TAU * random.next_f64());
    let side = if k.is_multiple_of(2) { Side::Front } else { Side::Back };
    DVec3::from_array(side.direction_from_disk([radius * phi.cos(), radius * phi.sin()]))
}

/// What becomes of `n` paths from one direction.
fn follow(
    scene: &Scene<f64>,
    incident: DVec3,
    n: u64,
    seed: u64,
) -> impl Iterator<Item = Option<(DVec3, f64)>> {
    (0..n).map(move |k| {
        let mut random = Random::new(seed, 0, k);
        match scene.follow(incident + DVec3::new(0.01, 0.02, 0.0), -incident, None, &mut random) {
            Outcome::Left(direction, weight) => Some((direction, weight)),
            Outcome::Absorbed => None,
            Outcome::Lost => panic!("one surface holds no path"),
        }
    })
}

/// Mean of the weights of `n` paths, and its standard error.
fn moments(weights: impl Iterator<Item = f64>, n: u64) -> [f64; 2] {
    let (sum, squares) = weights.fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
    let mean = sum / n as f64;
    [mean, ((squares / n as f64 - mean * mean).max(0.0) / n as f64).sqrt()]
}

/// Largest |z| of the paths that leave by each cell of a band, of those that expect at least 25, and how many there are.
fn compare(band: &Band, scene: &Scene<f64>, incident: DVec3, n: u64, seed: u64) -> (f64, usize) {
    let from = Side::of(incident.to_array());
    let mut cells: HashMap<(bool, u64), (f64, f64, f64)> = HashMap::new();
    for (direction, weight) in follow(scene, incident, n, seed).flatten() {
        let to = Side::of(direction.to_array());
        let (component, reversed) = band.answering(from, to).expect("light leaves where the file has data");
        let function = &component.luminance;
        let cell = function.cell(incident.to_array(), direction.to_array(), reversed);
        let entry = cells.entry((from == to, cell.key)).or_default();
        *entry = (entry.0 + weight, entry.1 + weight * weight, cell.value * cell.projected_solid_angle);
    }
    let n = n as f64;
    let z =
        cells.values().filter(|(_, _, expected)| n * expected >= 25.0).map(|&(sum, squares, expected)| {
            // What all light leaves by has no variance, but rounding.
            (sum - n * expected).abs() / (squares - sum * sum / n).max((1e-6 * n * expected).powi(2)).sqrt()
        });
    (z.clone().fold(0.0, f64::max), z.count())
}

#[test]
fn a_pane_of_a_file_has_its_bsdf_cell_by_cell() {
    let mut random = Random::new(41, 0, 0);
    let mut n_cells = 0;
    for name in READABLE {
        let Some(file) = read(name) else { return };
        let scene = Scene::<f64>::new(&pane(Material::Measured(Arc::new(measured(&file, false))))).unwrap();
        for k in 0..10 {
            let incident = incident(&mut random, k);
            // The extent of the cells of a reversed rank-3 tree is not known.
            let from = Side::of(incident.to_array());
            let is_reversed = file.band().answering(from, from.opposite()).is_some_and(|(c, reversed)| {
                reversed && matches!(&c.luminance, bsdftree::Scattering::Tree(t) if t.rank() == bsdftree::Rank::Three)
            });
            if is_reversed {
                continue;
            }
            let (z, n) = compare(file.band(), &scene, incident, 40_000, 100 + k as u64);
            // Up to 300 cells of each of 180 directions: 6.3 is exceeded by one of them with probability 2e-5.
            assert!(z < 6.3, "{name} from {incident}: {z}");
            n_cells += n;
        }
    }
    assert!(n_cells > 2000, "{n_cells} cells were compared");
}

#[test]
fn a_pane_of_a_file_has_its_totals() {
    let mut random = Random::new(42, 0, 0);
    for name in READABLE {
        let Some(file) = read(name) else { return };
        let scene = Scene::<f64>::new(&pane(Material::Measured(Arc::new(measured(&file, false))))).unwrap();
        let direct = Scene::<f64>::new(&pane(Material::Measured(Arc::new(measured(&file, true))))).unwrap();
        for k in 0..20 {
            let incident = incident(&mut random, k);
            let from = Side::of(incident.to_array());
            for scene in [&scene, &direct] {
                for lobes in [Lobes::Reflection, Lobes::Transmission] {
                    let expected = file.band().hemispherical(incident.to_array(), lobes);
                    let leaves = |d: &DVec3| (Side::of(d.to_array()) == from) == (lobes == Lobes::Reflection);
                    let paths = follow(scene, incident, 4000, 7 + k as u64).flatten();
                    let [mean, deviation] = moments(paths.filter(|(d, _)| leaves(d)).map(|(_, w)| w), 4000);
                    let difference = (mean - expected).abs();
                    // 1440 comparisons.
                    assert!(
                        difference <= 5.6 * deviation + 1e-9,
                        "{name} {incident} {lobes:?}: {difference} ± {deviation}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_turned_pane_turns_its_bsdf() {
    let Some(file) = read("pyradiance/blinds.xml") else { return };
    // Up is along −X, so that the BSDF's right is along Y of the device.
    let material =
        Measured { up: Orientation::Constant(DVec3::new(-2.0, 0.0, 0.7)), ..measured(&file, false) };
    let scene = Scene::<f64>::new(&pane(Material::Measured(Arc::new(material)))).unwrap();
    let turned = |v: DVec3| DVec3::new(v.y, -v.x, v.z);
    for (k, incident) in [radiance::polar(40.0, 20.0), radiance::polar(120.0, -70.0)].into_iter().enumerate()
    {
        let (own, n) = (turned(incident), 40_000);
        let band = file.band();
        let from = Side::of(own.to_array());
        let mut sums: HashMap<(bool, u64), (f64, f64)> = HashMap::new();
        for (direction, weight) in follow(&scene, incident, n, 60 + k as u64).flatten() {
            let exitant = turned(direction);
            let to = Side::of(exitant.to_array());
            let (component, reversed) = band.answering(from, to).unwrap();
            let cell = component.luminance.cell(own.to_array(), exitant.to_array(), reversed);
            let entry = sums.entry((from == to, cell.key)).or_default();
            *entry = (entry.0 + weight, cell.value * cell.projected_solid_angle * n as f64);
        }
        let all = band.hemispherical(own.to_array(), Lobes::All);
        for (sum, expected) in sums.values().filter(|(_, expected)| *expected >= 25.0) {
            assert!((sum - expected).abs() < 5.5 * (all * expected).sqrt(), "{sum} {expected}");
        }
    }
}

#[test]
fn added_diffuse_light_adds_up() {
    let Some(file) = read("mermet/E_Screen_3pct_White.xml") else { return };
    let diffuse = [0.05, 0.02, 0.03].map(DVec3::splat);
    let scene = Scene::<f64>::new(&pane(Material::Measured(Arc::new(Measured {
        diffuse,
        ..measured(&file, false)
    }))))
    .unwrap();
    for (incident, own) in [(radiance::polar(30.0, 0.0), 0.05), (radiance::polar(150.0, 0.0), 0.02)] {
        let n = 100_000;
        let mut sums = [0.0; 2];
        for (direction, weight) in follow(&scene, incident, n, 9).flatten() {
            sums[usize::from(direction.z * incident.z < 0.0)] += weight / n as f64;
        }
        let expected = [(Lobes::Reflection, own), (Lobes::Transmission, 0.03)]
            .map(|(lobes, added)| file.band().hemispherical(incident.to_array(), lobes) + added);
        for (sum, expected) in sums.iter().zip(expected) {
            // Weights are at most 1.1: a standard deviation below 0.0018.
            assert!((sum - expected).abs() < 0.008, "{sums:?} {expected:?}");
        }
    }
}

#[test]
fn through_light_of_an_absdf_is_as_in_radiance() {
    if radiance::programs().is_none() {
        return;
    }
    let mut n_through = 0;
    for name in [
        "pyradiance/clear.xml",
        "pyradiance/blindsT3.xml",
        "mermet/E_Screen_3pct_White.xml",
        "pyradiance/t3.xml",
    ] {
        let Some(file) = read(name) else { return };
        let scene = Scene::<f64>::new(&pane(Material::Measured(Arc::new(measured(&file, true))))).unwrap();
        let text = format!(
            "{}void aBSDF m 5 {} 0 1 0 . 0 0\nm polygon p 0 0 12 -9 -9 0 9 -9 0 9 9 0 -9 9 0\n",
            radiance::SKIES,
            file.file.path
        );
        for (k, theta) in [4.0, 17.0, 33.0, 52.0, 68.0, 110.0, 152.0].into_iter().enumerate() {
            if theta > 90.0 && name == "pyradiance/t3.xml" {
                // It has no such transmission, and Radiance cannot tell the extents of a reversed one of rank 3.
                continue;
            }
            let incident = radiance::polar(theta, 33.0 + 11.0 * k as f64);
            // Without scattered rays, what is left is what goes straight on.
            let [seen, _] = radiance::mean(&text, "-ab 0 -st 1.0001 -lw 1e-9", incident, 1);
            let theirs = if incident.z > 0.0 { seen.y } else { seen.x };
            let n = 40_000;
            let straight = |d: &DVec3| *d == -incident;
            let sum: f64 = follow(&scene, incident, n, 70 + k as u64)
                .flatten()
                .filter(|(d, _)| straight(d))
                .map(|(_, w)| w)
                .sum();
            let ours = sum / n as f64;
            let all = file.band().hemispherical(incident.to_array(), Lobes::All);
            let deviation = (ours * (all - ours).max(0.0) / n as f64).sqrt();
            // Radiance varies values by up to 0.03 % by their place.
            assert!(
                (ours - theirs).abs() < 4.5 * deviation + 0.001 * theirs,
                "{name} at {theta}°: {ours} ± {deviation}, rtrace {theirs}"
            );
            n_through += u32::from(theirs > 0.0);
        }
    }
    assert!(n_through > 20, "{n_through} peaks");
}

#[test]
fn totals_are_those_of_radiance() {
    if radiance::programs().is_none() {
        return;
    }
    for name in [
        "pyradiance/ven45.xml",
        "pyradiance/blindsT3.xml",
        "mermet/E_Screen_3pct_White.xml",
        "frads/ec60.xml",
    ] {
        let Some(file) = read(name) else { return };
        let scene = Scene::<f64>::new(&pane(Material::Measured(Arc::new(measured(&file, false))))).unwrap();
        let text = format!(
            "{}void BSDF m 6 0 {} 0 1 0 . 0 0\nm polygon p 0 0 12 -9 -9 0 9 -9 0 9 9 0 -9 9 0\n",
            radiance::SKIES,
            file.file.path
        );
        for theta in [7.0, 31.0, 58.0, 125.0] {
            let incident = radiance::polar(theta, 20.0);
            let options = "-ab 1 -ad 64 -as 0 -aa 0 -lw 1e-9 -st 0 -ss 1";
            let [seen, error] = radiance::mean(&text, options, incident, 2000);
            let theirs = if incident.z > 0.0 { [seen.x, seen.y] } else { [seen.y, seen.x] };
            // Radiance spreads the incident direction over a square as large as the smallest cell it meets.
            let width = file
                .band()
                .projected_solid_angle_range(incident.to_array(), Lobes::All)
                .map_or(0.0, |[smallest, _]| smallest.sqrt());
            let mut ours = [0.0; 2];
            let n = 100_000;
            for k in 0..n {
                let mut random = Random::new(8, theta as u64, k);
                let [x, y] = [(); 2].map(|()| width * (random.next_f64() - 0.5));
                let incident = (incident + DVec3::new(x, y, 0.0)).normalize();
                let origin = incident + DVec3::new(0.01, 0.02, 0.0);
                if let Outcome::Left(direction, weight) = scene.follow(origin, -incident, None, &mut random) {
                    ours[usize::from(direction.z * incident.z < 0.0)] += weight / n as f64;
                }
            }
            for k in 0..2 {
                assert!(
                    (ours[k] - theirs[k]).abs() < 0.005 + 4.0 * error.max_element(),
                    "{name} at {theta}°: {ours:?}, rtrace {theirs:?} ± {error}"
                );
            }
        }
    }
}

#[test]
fn a_pattern_acts_on_what_is_lambertian_and_what_is_transmitted() {
    let Some(path) = radiance::real_file("mermet/E_Screen_3pct_White.xml") else { return };
    let text = format!(
        "void brightfunc half 2 .5 . 0 0\nhalf BSDF m 6 0 {} 0 1 0 . 0 0\nm polygon p 0 0 12 -9 -9 0 9 -9 0 9 9 0 -9 9 0\n",
        path.canonicalize().unwrap().display()
    );
    let device = Device::parse_rad(&text, "half.rad", ".".as_ref(), Unit::Meter).unwrap();
    let scene = Scene::<f64>::new(&device).unwrap();
    let file = read("mermet/E_Screen_3pct_White.xml").unwrap();
    for theta in [10.0, 50.0, 140.0] {
        let incident = radiance::polar(theta, 15.0);
        let from = Side::of(incident.to_array());
        let lambertian = file.band().answering(from, from).unwrap().0.luminance.lambertian();
        let [reflected, transmitted] = [Lobes::Reflection, Lobes::Transmission]
            .map(|lobes| file.band().hemispherical(incident.to_array(), lobes));
        let mut sums = [0.0; 2];
        let n = 100_000;
        for (direction, weight) in follow(&scene, incident, n, 3).flatten() {
            sums[usize::from(direction.z * incident.z < 0.0)] += weight / n as f64;
        }
        let expected = [reflected - 0.5 * lambertian, 0.5 * transmitted];
        for k in 0..2 {
            assert!((sums[k] - expected[k]).abs() < 0.008, "{theta}: {sums:?}, expected {expected:?}");
        }
        if radiance::programs().is_some() {
            let options = "-ab 1 -ad 64 -as 0 -aa 0 -lw 1e-9 -st 0 -ss 1";
            let [seen, error] =
                radiance::mean(&format!("{}{text}", radiance::SKIES), options, incident, 1000);
            let theirs = if incident.z > 0.0 { [seen.x, seen.y] } else { [seen.y, seen.x] };
            for k in 0..2 {
                let difference = (expected[k] - theirs[k]).abs();
                assert!(
                    difference < 0.006 + 4.0 * error.max_element(),
                    "{theta}: {expected:?}, rtrace {theirs:?}"
                );
            }
        }
    }
}

#[test]
fn colours_of_a_file_are_those_of_the_light() {
    // A reddish tree, and one whose green no screen can show.
    for (uv, in_gamut) in [([0.30, 0.50], true), ([0.02, 0.58], false)] {
        let mut bsdf = bsdftree::Bsdf::default();
        let uniform = |value: f64| Scattering::from(Tree::uniform(Rank::Four, value as f32));
        let chroma = Some([uniform(uv[0]), uniform(uv[1])]);
        bsdf.band_mut("Visible").insert(Part::ReflectionBack, Component { luminance: uniform(0.2), chroma });
        let mut bytes = Vec::new();
        xml::write(&bsdf, &mut bytes).unwrap();
        let file = File { path: "colour.xml".into(), digest: digest(&bytes) };
        let (file, _) = BsdfFile::parse(&bytes, file).unwrap();
        assert!(file.has_color());
        let device = pane(Material::Measured(Arc::new(measured(&file, false))));
        let scene = Scene::<DVec3>::new(&device).unwrap();
        let Outcome::Left(_, weight) = scene.follow(DVec3::Z, DVec3::NEG_Z, None, &mut Random::new(1, 0, 0))
        else {
            panic!("absorbed")
        };
        let xyz = xyz_from_rgb(weight.to_array());
        assert!((xyz[1] - 0.2 * PI).abs() < 1e-6, "{xyz:?}");
        let found = uv_from_xyz(xyz);
        let same = (0..2).all(|k| (found[k] - uv[k]).abs() < 1e-6);
        assert_eq!(same, in_gamut, "{found:?}");
        assert!(weight.min_element() >= 0.0);
    }
}

#[test]
fn generation_gives_the_file_back() {
    // Klems: an incident patch of the generation is one of the file.
    for name in ["pyradiance/blinds.xml", "frads/blinds30.xml"] {
        let Some(file) = read(name) else { return };
        let device = pane(Material::Measured(Arc::new(measured(&file, false))));
        let basis = Arc::new(Basis::full());
        let options = Options { samples: 16384, ..Options::new(Layout::Klems(basis.clone())) };
        let generated = generate(&device, &options, &Progress::default()).unwrap();
        let ours = generated.bsdf.band("Visible").expect("generated");
        let mut n_compared = 0;
        for (part, component) in file.band().components() {
            let ours = &ours.component(part).expect("what the file has").luminance;
            let (Scattering::Matrix(theirs), Scattering::Matrix(ours)) = (&component.luminance, ours) else {
                panic!("not Klems")
            };
            for (k, (theirs, ours)) in theirs.values().iter().zip(ours.values()).enumerate() {
                let (theirs, ours) = (f64::from(*theirs), f64::from(*ours));
                let hits = theirs * basis.projected_solid_angle(k % basis.n_patches()) * 16384.0;
                if hits >= 50.0 {
                    n_compared += 1;
                    // Even points scatter less than independent ones do.
                    let z = (ours / theirs - 1.0) * hits.sqrt();
                    assert!(z.abs() < 5.5, "{name} {part:?} {k}: {theirs} {ours}");
                }
            }
        }
        assert!(n_compared > 800, "{n_compared}");
    }
}

#[test]
fn reuse_of_diffused_light_leaves_such_devices_alone() {
    let Some(file) = read("pyradiance/blinds.xml") else { return };
    let mut device = Device::from_spec("blinds").unwrap();
    let [low, high] = device.bounds().unwrap();
    let corners = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)];
    let shape = Shape::Polygon(corners.iter().map(|&(x, y)| DVec3::new(x, y, low.z - 0.01)).collect());
    device.materials.push(NamedMaterial {
        name: "m".into(),
        material: Material::Measured(Arc::new(measured(&file, true))),
    });
    let material = device.materials.len() as u32 - 1;
    device.surfaces.push(Surface { name: "pane".into(), shape, material });
    let run = |reuse| {
        let layout = Layout::Tree { rank: Rank::Four, log2_res: 2 };
        let options = Options { samples: 512, reuse, ..Options::new(layout) };
        generate(&device, &options, &Progress::default()).unwrap()
    };
    let [with, without] = [true, false].map(run);
    for (a, b) in with.report.totals.iter().zip(&without.report.totals) {
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
    }
    assert!(!with.report.totals.is_empty());
}

#[test]
fn a_fabric_behind_glass_is_as_in_radiance() {
    let Some(path) = radiance::real_file("mermet/E_Screen_3pct_White.xml") else { return };
    if radiance::programs().is_none() {
        return;
    }
    let text = format!(
        "void glass clear 0 0 3 .93 .93 .93\nclear polygon g 0 0 12 -60 -60 -.05 60 -60 -.05 60 60 -.05 -60 60 -.05\n\
         void BSDF screen 6 0 {} 0 1 0 . 0 0\nscreen polygon s 0 0 12 -60 -60 0 60 -60 0 60 60 0 -60 60 0\n",
        path.canonicalize().unwrap().display()
    );
    let device = Device::parse_rad(&text, "stack.rad", ".".as_ref(), Unit::Meter).unwrap();
    let scene = Scene::<f64>::new(&device).unwrap();
    for theta in [20.0, 50.0, 130.0, 160.0] {
        let incident = radiance::polar(theta, 30.0);
        let options = "-ab 6 -ad 16 -as 0 -aa 0 -lw 1e-5 -lr 12 -st 0 -ss 1";
        let [seen, error] = radiance::mean(&format!("{}{text}", radiance::SKIES), options, incident, 1500);
        let theirs = if incident.z > 0.0 { [seen.x, seen.y] } else { [seen.y, seen.x] };
        let mut ours = [0.0; 2];
        let n = 100_000;
        for (direction, weight) in follow(&scene, incident, n, 5).flatten() {
            ours[usize::from(direction.z * incident.z < 0.0)] += weight / n as f64;
        }
        for k in 0..2 {
            assert!(
                (ours[k] - theirs[k]).abs() < 0.005 + 4.0 * error.max_element(),
                "{theta}°: {ours:?}, rtrace {theirs:?} ± {error}"
            );
        }
    }
}

#[test]
fn bands_of_a_file_are_those_of_the_device() {
    let Some(file) = read("mermet/E_Screen_3pct_White.xml") else { return };
    let device = pane(Material::Measured(Arc::new(measured(&file, false))));
    let bands = ["Visible", "Solar", "NIR"].map(|name| name.parse().unwrap()).to_vec();
    let options = Options { samples: 1024, bands, ..Options::new(Layout::Klems(Arc::new(Basis::quarter()))) };
    let made = generate_bands(&device, &[], &options, &Progress::default()).unwrap();
    let incident = radiance::polar(35.0, 10.0).to_array();
    let totals = |bsdf: &bsdftree::Bsdf, name: &str| {
        let band = bsdf.band(name).unwrap_or_else(|| panic!("no {name}"));
        [Lobes::Reflection, Lobes::Transmission].map(|lobes| band.hemispherical(incident, lobes))
    };
    // What the file does not know is as it is where it is seen.
    for (name, as_in) in [("Visible", "Visible"), ("Solar", "Solar"), ("NIR", "Visible")] {
        let (ours, theirs) = (totals(&made.bsdf, name), totals(file.bsdf(), as_in));
        for k in 0..2 {
            // Patches of the generation hold several of the file.
            assert!((ours[k] - theirs[k]).abs() < 0.02, "{name}: {ours:?} {theirs:?}");
        }
    }
    let [visible, solar] = ["Visible", "Solar"].map(|name| totals(file.bsdf(), name)[0]);
    assert!((visible - solar).abs() > 0.03, "{visible} {solar}");
    assert!(
        made.report.warnings.iter().any(|w| w.contains("no spectrum says")),
        "{:?}",
        made.report.warnings
    );
}
