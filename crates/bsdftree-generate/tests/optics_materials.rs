//! Antimatter, prisms, `ashik2` and `WGMDfunc`: beside closed forms, and beside Radiance.
//!
//! Where every ray goes one way, paths are compared one by one with what rtrace sees of a sky that tells directions; else means are.
//! Statistics: fixed seeds; bounds on |z| are exceeded by a right sampler with a probability below 1e-4 a test.

mod radiance;

use std::f64::consts::TAU;

use bsdftree_device::{Device, Unit};
use bsdftree_generate::path::{Outcome, Scene};
use bsdftree_generate::random::Random;
use glam::DVec3;
use radiance::{DIRECTIONS, polar, seen};

fn device(text: &str) -> Device {
    Device::parse_rad(text, "test.rad", ".".as_ref(), Unit::Meter).unwrap()
}

fn scene(text: &str) -> Scene<f64> {
    Scene::new(&device(text)).unwrap()
}

/// Where a path leaves, and with which weight.
fn follow(scene: &Scene<f64>, (origin, direction): (DVec3, DVec3), seed: u64) -> Option<(DVec3, f64)> {
    match scene.follow(origin, direction, None, &mut Random::new(77, 0, seed)) {
        Outcome::Left(direction, weight) => Some((direction, weight)),
        Outcome::Absorbed => None,
        Outcome::Lost => panic!("a path was lost"),
    }
}

/// Rays from around towards a ball.
fn rays_to(center: DVec3, radius: f64, n: u64) -> Vec<(DVec3, DVec3)> {
    (0..n)
        .map(|k| {
            let mut random = Random::new(76, 0, k);
            let mut ball = || {
                let z = 2.0 * random.next_f64() - 1.0;
                let (sin, cos) = (TAU * random.next_f64()).sin_cos();
                let r = (1.0 - z * z).sqrt();
                DVec3::new(r * cos, r * sin, z)
            };
            let (from, to) = (center + ball() * 10.0, center + ball() * radius);
            (from, (to - from).normalize())
        })
        .collect()
}

/// Compares each path with what rtrace sees; all of the device's surfaces are mirrors. How many were seen to be changed.
fn assert_seen_alike(text: &str, rays: &[(DVec3, DVec3)]) -> usize {
    let theirs = radiance::rtrace(&format!("{DIRECTIONS}{text}"), "-ab 0 -lr 60 -lw 1e-12 -st 0 -ss 0", rays);
    let scene = scene(text);
    let mut changed = 0;
    let mut wrong = Vec::new();
    for (k, (ray, theirs)) in rays.iter().zip(&theirs).enumerate() {
        // Roulette ends faint paths; its mean is what is compared.
        let n = 32;
        let sum: DVec3 = (0..n)
            .filter_map(|i| follow(&scene, *ray, (k as u64) << 8 | i))
            .map(|(direction, weight)| seen(direction, weight))
            .sum();
        let ours = sum / n as f64;
        let same = (ours - *theirs).abs().max_element() < 2e-4;
        wrong.extend((!same).then(|| format!("ray {k} {ray:?}: {ours}, rtrace {theirs}")));
        changed += usize::from((*theirs - seen(ray.1, 1.0)).length() > 1e-3);
    }
    // Rays along edges may go either way, in f32 there and in f64 here.
    assert!(wrong.len() <= rays.len() / 200, "{} of {}:\n{}", wrong.len(), rays.len(), wrong.join("\n"));
    changed
}

const SPHERES: &str = "void metal red 0 0 5 .8 .8 .8 1 0\nvoid metal blue 0 0 5 .5 .5 .5 1 0\n";

#[test]
fn antimatter_cuts_objects_as_in_radiance() {
    if radiance::programs().is_none() {
        return;
    }
    for (names, n_hidden) in
        [("1 red", 1), ("2 void red", 1), ("2 blue red", 2), ("2 red blue", 2), ("1 void", 0)]
    {
        let text = format!(
            "{SPHERES}void antimatter hole {names} 0 0\n\
             red sphere a 0 0 4 0 0 0 1\nblue sphere b 0 0 4 1.1 .2 .1 .6\nhole sphere c 0 0 4 .5 0 .8 .7\n"
        );
        let rays = rays_to(DVec3::new(0.4, 0.0, 0.3), 1.2, 2000);
        let changed = assert_seen_alike(&text, &rays);
        assert!(changed > 1000 && n_hidden < 3, "{changed}");
    }
}

#[test]
fn what_is_cut_out_of_glass_is_as_if_it_had_never_been() {
    // A block of glass, less its upper half and a hole, against the same drawn by its own surfaces.
    let brick = |name: &str, material: &str, x: [f64; 2], y: [f64; 2], z: [f64; 2]| {
        let corner = |k: usize| [x[k & 1], y[k >> 1 & 1], z[k >> 2]];
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let polygon = |(k, face): (usize, [usize; 4])| {
            let vertices: Vec<String> = face.iter().flat_map(|&c| corner(c)).map(|v| v.to_string()).collect();
            format!("{material} polygon {name}{k} 0 0 12 {}\n", vertices.join(" "))
        };
        faces.into_iter().enumerate().map(polygon).collect::<String>()
    };
    let glass = "void dielectric glass 0 0 5 .8 .8 .8 1.5 0\n";
    let cut = format!(
        "{glass}void antimatter none 1 glass 0 0\n{}{}",
        brick("g", "glass", [0.0, 1.0], [0.0, 1.0], [0.0, 1.0]),
        brick("n", "none", [-1.0, 2.0], [-1.0, 2.0], [0.4, 3.0])
    );
    let whole = format!("{glass}{}", brick("g", "glass", [0.0, 1.0], [0.0, 1.0], [0.0, 0.4]));
    let [cut, whole] = [cut, whole].map(|text| scene(&text));
    let rays = rays_to(DVec3::new(0.5, 0.5, 0.3), 0.8, 4000);
    let mut met = 0;
    for (k, ray) in rays.iter().enumerate() {
        let [a, b] = [&cut, &whole].map(|scene| follow(scene, *ray, k as u64));
        match (a, b) {
            (Some((da, wa)), Some((db, wb))) => {
                // Roulette may end one path and not the other; it weighs the survivors.
                let same = da.distance(db) < 1e-9 && (wa - wb).abs() < 1e-9;
                assert!(same, "{k}: {a:?} {b:?}");
                met += usize::from(da.distance(ray.1) > 1e-6 || wa < 1.0);
            }
            (None, None) => {}
            other => panic!("{k}: {other:?}"),
        }
    }
    assert!(met > 1000, "{met}");
}

#[test]
fn a_hole_inside_of_glass_has_a_surface_on_both_sides() {
    // A bubble of nothing in a glass ball: the same as a ball of air whose surface is glass turned over.
    let glass = "void dielectric glass 0 0 5 .9 .9 .9 1.5 0\n";
    let cut = scene(&format!(
        "{glass}void antimatter air 1 glass 0 0\nglass sphere a 0 0 4 0 0 0 1\nair sphere b 0 0 4 .1 .2 0 .5\n"
    ));
    let drawn = scene(&format!("{glass}glass sphere a 0 0 4 0 0 0 1\nglass bubble b 0 0 4 .1 .2 0 .5\n"));
    for (k, ray) in rays_to(DVec3::ZERO, 1.0, 4000).iter().enumerate() {
        let [a, b] = [&cut, &drawn].map(|scene| follow(scene, *ray, k as u64));
        let same = match (a, b) {
            (Some((da, wa)), Some((db, wb))) => da.distance(db) < 1e-7 && (wa - wb).abs() < 1e-9,
            (a, b) => a == b,
        };
        assert!(same, "{k}: {a:?} {b:?}");
    }
}

#[test]
fn overlapping_antimatter_is_one_volume() {
    let scene_of = |surfaces: &str| {
        scene(&format!(
            "{SPHERES}void antimatter hole 1 red 0 0\nvoid antimatter other 1 red 0 0\nred sphere a 0 0 4 0 0 0 1\n{surfaces}"
        ))
    };
    // The second volume lies inside the first one.
    let one = scene_of("hole sphere c 0 0 4 .5 0 .8 .7\n");
    let two = scene_of("hole sphere c 0 0 4 .5 0 .8 .7\nother sphere d 0 0 4 .4 0 .7 .3\n");
    for (k, ray) in rays_to(DVec3::new(0.3, 0.0, 0.5), 1.0, 2000).iter().enumerate() {
        let [a, b] = [&one, &two].map(|scene| follow(scene, *ray, k as u64));
        let same = match (a, b) {
            (Some((da, wa)), Some((db, wb))) => da.distance(db) < 1e-9 && (wa - wb).abs() < 1e-9,
            (a, b) => a == b,
        };
        assert!(same, "{k}: {a:?} {b:?}");
    }
}

#[test]
fn prisms_send_light_as_in_radiance() {
    if radiance::programs().is_none() {
        return;
    }
    let Some(functions) = radiance::real_file("radiance/prism.cal") else { return };
    let functions = functions.canonicalize().unwrap();
    let functions = functions.display();
    let pane = "m polygon pane 0 0 12 -9 -9 0 9 -9 0 9 9 0 -9 9 0\n";
    let materials = [
        format!("void prism1 m 9 coef1 dx1 dy1 dz1 {functions} -rx 90 -rz 20 0 4 1.52 .2 .1 .2\n"),
        format!(
            "void prism2 m 11 coef1 dx1 dy1 dz1 coef2 dx2 dy2 dz2 {functions} -rx 90 0 4 1.52 .2 .1 .2\n"
        ),
        "void prism1 m 5 .7 Dx+.3 Dy Dz . 0 0\n".to_owned(),
        "void prism1 m 5 if(Dz,.9,.4) Dy -Dx -Dz . 0 0\n".to_owned(),
        "void prism2 m 9 .5 Dx Dy Dz .3 Dx Dy -Dz . 0 0\n".to_owned(),
        "void prism1 m 5 -.5 sqrt(-1-Dx*Dx) 0 0 . 0 0\n".to_owned(),
    ];
    for material in materials {
        let text = format!("{material}{pane}");
        let rays: Vec<(DVec3, DVec3)> = (0..60)
            .map(|k| {
                let towards = polar(3.0 + 2.8 * f64::from(k), 47.0 * f64::from(k));
                (towards + DVec3::new(0.1, 0.2, 0.0), -towards)
            })
            .collect();
        let theirs = radiance::rtrace(&format!("{DIRECTIONS}{text}"), "-ab 0 -lr 9 -lw 1e-12 -st 0", &rays);
        let scene = scene(&text);
        for (k, (ray, theirs)) in rays.iter().zip(&theirs).enumerate() {
            let n = 4000;
            let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
            for i in 0..n {
                let v = follow(&scene, *ray, (k as u64) << 16 | i).map_or(DVec3::ZERO, |(d, w)| seen(d, w));
                sum += v;
                squares += v * v;
            }
            let mean = sum / n as f64;
            let error = ((squares / n as f64 - mean * mean).max(DVec3::ZERO) / n as f64).map(f64::sqrt);
            assert!(scene.faults().error().is_none(), "{:?}", scene.faults().error());
            // 1080 comparisons.
            assert!(
                ((mean - *theirs).abs() - 5.5 * error).max_element() < 2e-4,
                "{material} ray {k} {ray:?}: {mean} ± {error}, rtrace {theirs}"
            );
        }
    }
}

#[test]
fn a_prism_makes_no_light() {
    let scene =
        scene("void prism2 m 9 .8 Dx Dy Dz .6 Dx Dy -Dz . 0 0\nm polygon p 0 0 9 -9 -9 0 9 -9 0 0 9 0\n");
    let mut straight = 0.0;
    for k in 0..20_000 {
        let (direction, weight) = follow(&scene, (DVec3::Z, DVec3::NEG_Z), k).unwrap();
        assert!((weight - 1.0).abs() < 1e-12);
        straight += f64::from(u8::from(direction.z < 0.0)) / 20_000.0;
    }
    // A share of 4/7 with a standard deviation of 0.0035.
    assert!((straight - 4.0 / 7.0).abs() < 0.014, "{straight}");
    assert_eq!(scene.faults().too_bright().len(), 1);
}

/// Compares means over what is scattered from several directions.
fn assert_scattered_alike(material: &str, options: &str, thetas: &[f64], tolerance: f64) {
    let text = format!("{material}m polygon p 0 0 12 -99 -99 0 99 -99 0 99 99 0 -99 99 0\n");
    let lit = format!("{DIRECTIONS}{text}");
    let scene = scene(&text);
    for (k, &theta) in thetas.iter().enumerate() {
        let incident = polar(theta, 25.0 + 40.0 * k as f64);
        let [theirs, their_error] = radiance::mean(&lit, options, incident, 3000);
        let n = 100_000;
        let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for i in 0..n {
            let ray = (incident + DVec3::new(0.013, 0.027, 0.0), -incident);
            let v = follow(&scene, ray, (k as u64) << 32 | i).map_or(DVec3::ZERO, |(d, w)| seen(d, w));
            sum += v;
            squares += v * v;
        }
        let ours = sum / n as f64;
        let error =
            ((squares / n as f64 - ours * ours) / n as f64 + their_error * their_error).map(f64::sqrt);
        assert!(
            ((ours - theirs).abs() - 4.5 * error).max_element() < tolerance,
            "{material} at {theta}°: {ours}, rtrace {theirs} ± {error}"
        );
    }
}

/// One bounce of everything, diffuse light included.
const ONE_BOUNCE: &str = "-ab 1 -ad 64 -as 0 -aa 0 -lw 1e-12 -lr 8 -st 0";

#[test]
fn ashik2_is_as_in_radiance() {
    if radiance::programs().is_none() {
        return;
    }
    for material in [
        "void ashik2 m 4 1 .5 3 . 0 8 .3 .3 .3 .2 .2 .2 20 200\n",
        "void ashik2 m 4 1 .5 Px . 0 8 .1 .1 .1 .5 .5 .5 5 2\n",
        "void ashik2 m 4 1 0 0 . 0 8 .6 .6 .6 0 0 0 50 50\n",
        "void brightfunc half 2 .5 . 0 0\nhalf ashik2 m 4 1 0 0 . 0 8 .6 .6 .6 .3 .3 .3 50 50\n",
    ] {
        assert_scattered_alike(material, &format!("{ONE_BOUNCE} -ss 1"), &[4.0, 33.0, 60.0, 155.0], 2e-4);
    }
}

#[test]
fn wgmdfunc_is_as_in_radiance() {
    if radiance::programs().is_none() {
        return;
    }
    let zero = "0 9 0 0 0 0 0 0 0 0 0\n";
    let diffuse = "0 9 .2 .2 .2 .1 .1 .1 .3 .3 .3\n";
    let before = "void brightfunc half 2 .5 . 0 0\nvoid brightfunc side 2 if(Rdot,.3,.8) . 0 0\n\
                  void texfunc tilt 4 .2 0 0 . 0 0\n";
    for material in [
        format!("void WGMDfunc m 13 void 0 0 0 void 0 0 0 void 1 0 0 . {diffuse}"),
        // A mirror with Fresnel, and straight through.
        format!("void WGMDfunc m 13 void .1 0 0 void .3 0 0 void 1 0 0 . {diffuse}"),
        format!("void WGMDfunc m 13 void .01 0 0 void .3 0 0 void 1 0 0 . {diffuse}"),
        // Rough lobes, with coefficients that depend on side and angle.
        format!("void WGMDfunc m 13 void if(Rdot,.5,.2) .2 .1 void 0 0 0 void 1 1 0 . {zero}"),
        format!("void WGMDfunc m 13 void 0 0 0 void .6*RdotP .15 .3 void 1 1 0 . {zero}"),
        format!("void WGMDfunc m 15 void .4 .2 .1 void .3 .1 .1 void Px Py 1 . -rz 30 {diffuse}"),
        // Modifiers of the parts.
        format!("{before}half WGMDfunc m 13 inherit .1 0 0 void .3 0 0 side 1 0 0 . {diffuse}"),
        format!("{before}half WGMDfunc m 13 side .2 0 0 inherit .3 0 0 inherit 1 0 0 . {diffuse}"),
        format!("{before}tilt WGMDfunc m 13 tilt .3 0 0 void .3 0 0 void 1 0 0 . {zero}"),
        format!("{before}void WGMDfunc m 13 void .3 .1 .1 tilt .3 0 0 void 1 0 0 . {zero}"),
    ] {
        // With more than one sample a lobe, rtrace weighs them as the lobe asks for.
        assert_scattered_alike(&material, &format!("{ONE_BOUNCE} -ss 16"), &[5.0, 40.0, 66.0, 140.0], 3e-4);
    }
}
