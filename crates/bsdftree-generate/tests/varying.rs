//! Devices whose surfaces vary, against closed forms. Fixed seeds; a right generation passes each bound on a deviation but for a
//! probability below 1e-4.

use bsdftree::direction::direction_from_polar;
use bsdftree::{Direction, Lobes, Part, Rank};
use bsdftree_device::{Device, ReadOptions, Unit};
use bsdftree_generate::random::Random;
use bsdftree_generate::scatter::{Faults, Meeting, PreparedMaterial};
use bsdftree_generate::{GenerateError, Generated, Layout, Options, Progress, Report, Sides, generate};
use glam::DVec3;

const PANE: &str = "polygon pane 0 0 12  0 0 0  1 0 0  1 1 0  0 1 0";

/// A device from a text and files beside it.
fn device_with(text: &str, files: &[(&str, &str)], unit: Unit) -> Device {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let options = ReadOptions { unit, search: Some(Vec::new()), ..ReadOptions::default() };
    Device::parse_rad(text, "test.rad", folder.path(), options).unwrap_or_else(|e| panic!("{e}"))
}

fn device(text: &str) -> Device {
    device_with(text, &[], Unit::Meter)
}

fn options(samples: u64) -> Options {
    let layout = Layout::Tree { rank: Rank::Four, log2_res: 3 };
    Options { samples, sides: Sides::Front, ..Options::new(layout) }
}

fn run(device: &Device, options: &Options) -> Generated {
    generate(device, options, &Progress::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn incident(theta_deg: f64) -> Direction {
    direction_from_polar(theta_deg.to_radians(), 1.0)
}

const PATH: f64 = 2.5e-3;

/// Every total of a part is the expected one, to 5 standard errors and one path of a replicate or two: a choice that
/// even points make is right to that, and then all replicates may agree.
fn totals_are(report: &Report, part: Part, expected: impl Fn(usize) -> f64) {
    let totals = report.totals.iter().find(|totals| totals.part == part).unwrap();
    for (k, (value, error)) in totals.values.iter().zip(&totals.errors).enumerate() {
        let expected = expected(k);
        assert!(
            (value - expected).abs() <= 5.0 * error + PATH,
            "cell {k}: {value} ± {error}, not {expected}"
        );
    }
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let known = mean(&totals.errors) / (totals.errors.len() as f64).sqrt();
    let all = mean(&(0..totals.values.len()).map(&expected).collect::<Vec<_>>());
    assert!(
        (mean(&totals.values) - all).abs() <= 5.0 * known + 0.2 * PATH,
        "{} ± {known}, not {all}",
        mean(&totals.values)
    );
}

/// The material of the first surface, alone.
fn prepared(device: &Device) -> PreparedMaterial<f64> {
    let material = &device.materials[device.surfaces[0].material as usize];
    PreparedMaterial::new(&material.material)
}

const CHECKS: &str = "checks(d) = if(.5 - mod(floor(Px/d) + floor(Py/d), 2), A1, A2);";

#[test]
fn a_checkerboard_reflects_its_mean() {
    let text = format!(
        "void brightfunc checks 2 checks(.25) c.cal 0 2 .25 .75\nchecks plastic paint 0 0 5 .8 .8 .8 0 0\npaint {PANE}"
    );
    let Generated { report, bsdf, .. } =
        run(&device_with(&text, &[("c.cal", CHECKS)], Unit::Meter), &options(2000));
    totals_are(&report, Part::ReflectionBack, |_| 0.4);
    assert_eq!(bsdf.band("Visible").unwrap().hemispherical(incident(30.0), Lobes::Transmission), 0.0);
}

#[test]
fn functions_see_the_units_of_their_file() {
    // Quarters of an inch are quarters of this pane, which is an inch wide; a tenth of it is dark.
    let text = format!(
        "void brightfunc dark 2 if(Px-.1,.5,0) . 0 0\ndark plastic paint 0 0 5 1 1 1 0 0\npaint {PANE}"
    );
    let Generated { report, .. } = run(&device_with(&text, &[], Unit::Inch), &options(2000));
    totals_are(&report, Part::ReflectionBack, |_| 0.45);
}

#[test]
fn a_texture_tilts_a_mirror() {
    let text =
        format!("void texfunc tilt 4 .2 -.1 0 . 0 0\ntilt mirror silver 0 0 3 .9 .9 .9\nsilver {PANE}");
    let material = prepared(&device(&text));
    let normal = DVec3::new(0.2, -0.1, 1.0).normalize();
    for theta in [0.0, 20.0, 50.0] {
        let incoming = -DVec3::from_array(incident(theta));
        let scatter = material.scatter(&Meeting::new(DVec3::Z, incoming), &mut Random::new(0, 0, 0)).unwrap();
        let expected = incoming - normal * (2.0 * normal.dot(incoming));
        assert!(scatter.direction.distance(expected) < 1e-12 && (scatter.weight - 0.9).abs() < 1e-12);
    }
    // What a tilt would send below the surface, the surface itself mirrors.
    let incoming = -DVec3::from_array(direction_from_polar(1.5, std::f64::consts::PI - 0.4636));
    let scatter = material.scatter(&Meeting::new(DVec3::Z, incoming), &mut Random::new(0, 0, 0)).unwrap();
    assert!(scatter.direction.z > 0.0 && !scatter.transmitted, "{scatter:?}");
}

#[test]
fn smooth_meshes_scatter_by_their_own_normal() {
    // As a texture does, without one: what a mesh tells of a place is added to the normal.
    let perturbation = DVec3::new(0.3, 0.1, -0.05);
    let normal = (DVec3::Z + perturbation).normalize();
    let meeting = |incoming: DVec3| Meeting {
        local: bsdftree_generate::scatter::Local { uv: [0.0; 2], perturbation },
        ..Meeting::new(DVec3::Z, incoming)
    };
    for side in [1.0, -1.0] {
        let incoming = -side * DVec3::from_array(incident(25.0));
        let metal = prepared(&device(&format!("void metal m 0 0 5 .9 .9 .9 1 0\nm {PANE}")));
        let scatter = metal.scatter(&meeting(incoming), &mut Random::new(0, 0, 0)).unwrap();
        assert!(scatter.direction.distance(incoming - normal * (2.0 * normal.dot(incoming))) < 1e-12);
        // Directions of diffuse light have the mean of ⅔ of that normal, but for the few that would be below the surface.
        let paint = prepared(&device(&format!("void plastic m 0 0 5 .5 .5 .5 0 0\nm {PANE}")));
        let mut random = Random::new(11, 0, 0);
        let n = 100_000;
        let mut sum = DVec3::ZERO;
        for _ in 0..n {
            if let Some(s) = paint.scatter(&meeting(incoming), &mut random) {
                assert!(s.direction.z * side > 0.0);
                sum += s.direction;
            }
        }
        assert!((sum / f64::from(n)).distance(normal * (side * 2.0 / 3.0)) < 0.03, "{}", sum / f64::from(n));
    }
}

#[test]
fn waves_turn_a_mirror_where_they_are_steep() {
    // The slope is ±1/10 on halves of the pane, so that half of the light goes to either of two directions.
    let text =
        format!("void texfunc waves 4 if(Px-.5,.1,-.1) 0 0 . 0 0\nwaves mirror m 0 0 3 1 1 1\nm {PANE}");
    let Generated { bsdf, report, .. } = run(
        &device(&text),
        &Options { layout: Layout::Tree { rank: Rank::Four, log2_res: 5 }, ..options(500) },
    );
    totals_are(&report, Part::ReflectionBack, |_| 1.0);
    let band = bsdf.band("Visible").unwrap();
    let incident = [0.01, 0.01, 0.9999];
    for side in [-1.0, 1.0] {
        let normal = DVec3::new(0.1 * side, 0.0, 1.0).normalize();
        let incoming = -DVec3::from_array(incident);
        let exitant = incoming - normal * (2.0 * normal.dot(incoming));
        // Mean over the cells around, of which each is π/1024.
        let spread: f64 = [(-0.03, -0.03), (-0.03, 0.03), (0.03, -0.03), (0.03, 0.03)]
            .iter()
            .map(|(x, y)| band.eval(incident, (exitant + DVec3::new(*x, *y, 0.0)).normalize().to_array()))
            .sum();
        assert!((0.3..0.6).contains(&(spread * std::f64::consts::PI / 1024.0)), "{side}: {spread}");
    }
}

#[test]
fn a_mixture_of_greys_is_their_mean() {
    let text = format!(
        "void plastic light 0 0 5 .8 .8 .8 0 0\nvoid plastic dark 0 0 5 .2 .2 .2 0 0\n\
         void mixfunc mix 4 light dark .3 . 0 0\nmix {PANE}"
    );
    let Generated { report, .. } = run(&device(&text), &options(2000));
    totals_are(&report, Part::ReflectionBack, |_| 0.3 * 0.8 + 0.7 * 0.2);
}

#[test]
fn mixtures_nest_and_let_light_through_where_nothing_is() {
    // 40 % of it is a mixture of half white and half nothing, 60 % are grey behind a pattern.
    let text = format!(
        "void plastic white 0 0 5 1 1 1 0 0\nvoid mixfunc lace 4 white void .5 . 0 0\n\
         void brightfunc half 2 .5 . 0 0\nhalf plastic grey 0 0 5 .6 .6 .6 0 0\n\
         void mixfunc mix 4 lace grey .4 . 0 0\nmix {PANE}"
    );
    let Generated { report, bsdf, .. } = run(&device(&text), &options(2000));
    totals_are(&report, Part::ReflectionBack, |_| 0.4 * 0.5 + 0.6 * 0.3);
    totals_are(&report, Part::TransmissionBack, |_| 0.4 * 0.5);
    // Light that goes through is not turned: all of it leaves by the cell opposite.
    let band = bsdf.band("Visible").unwrap();
    let (incident, cell) = ([0.1, 0.2, 0.9747], std::f64::consts::PI / 64.0);
    let through = band.eval(incident, incident.map(|x| -x)) * cell;
    assert!((through - 0.2).abs() < 0.05, "{through}");
}

#[test]
fn a_pattern_before_a_mixture_reaches_both_sides() {
    let text = format!(
        "void plastic light 0 0 5 .8 .8 .8 0 0\nvoid mirror silver 0 0 3 .9 .9 .9\n\
         void mixfunc mix 4 light silver .5 . 0 0\nmix brightfunc dim 2 .5 . 0 0\ndim {PANE}"
    );
    let Generated { report, .. } = run(&device(&text), &options(1000));
    totals_are(&report, Part::ReflectionBack, |_| 0.5 * (0.5 * 0.8 + 0.5 * 0.9));
}

#[test]
fn patterns_act_on_what_has_the_materials_colour() {
    // Of the weight of a ray: what the manual says of each material, at normal incidence on a rough or smooth surface.
    let fresnel = (-5.85_f64).exp() - 0.00202943064;
    for (material, expected) in [
        ("plastic m 0 0 5 .8 .8 .8 .1 .02", 0.9 * 0.8 * 0.25 + 0.1),
        ("metal m 0 0 5 .8 .8 .8 .1 .02", 0.8 * 0.25),
        ("plastic m 0 0 5 .8 .8 .8 .1 0", (0.9 * 0.8 * 0.25 + 0.1) * (1.0 - fresnel) + fresnel),
        ("metal m 0 0 5 .8 .8 .8 .1 0", 0.8 * 0.25 * (1.0 - fresnel) + fresnel),
        ("trans m 0 0 7 .8 .8 .8 .1 .02 .6 .3", 0.9 * 0.8 * 0.25 + 0.1),
        ("mirror m 0 0 3 .8 .8 .8", 0.8 * 0.25),
    ] {
        let text = format!("void brightfunc quarter 2 .25 . 0 0\nquarter {material}\nm {PANE}");
        let material = prepared(&device(&text));
        let (mut sum, mut squares) = (0.0, 0.0);
        let mut random = Random::new(7, 0, 0);
        let n = 100_000;
        for _ in 0..n {
            let weight = material
                .scatter(&Meeting::new(DVec3::Z, DVec3::NEG_Z), &mut random)
                .map_or(0.0, |s| s.weight);
            sum += weight;
            squares += weight * weight;
        }
        let mean = sum / f64::from(n);
        let error = ((squares / f64::from(n) - mean * mean).max(0.0) / f64::from(n)).sqrt();
        // Of what rough surfaces reflect, the square of the roughness is lost.
        assert!((mean - expected).abs() < 4.5 * error + 1e-4, "{text}: {mean} ± {error}, not {expected}");
    }
}

#[test]
fn a_pattern_on_glass_dims_what_goes_through_only() {
    let plain = prepared(&device(&format!("void glass m 0 0 3 .96 .96 .96\nm {PANE}")));
    let dimmed = prepared(&device(&format!(
        "void brightfunc half 2 .5 . 0 0\nhalf glass m 0 0 3 .96 .96 .96\nm {PANE}"
    )));
    let split = |material: &PreparedMaterial<f64>| {
        let mut random = Random::new(8, 0, 0);
        let mut sums = [0.0; 2];
        for _ in 0..200_000 {
            let incoming = -DVec3::from_array(incident(60.0));
            let scatter = material.scatter(&Meeting::new(DVec3::Z, incoming), &mut random).unwrap();
            sums[usize::from(scatter.transmitted)] += scatter.weight / 200_000.0;
        }
        sums
    };
    let ([r, t], [r_dimmed, t_dimmed]) = (split(&plain), split(&dimmed));
    // Standard errors of both are below 1e-3.
    assert!(
        (r - r_dimmed).abs() < 5e-3 && (0.5 * t - t_dimmed).abs() < 5e-3,
        "{r} {t}, {r_dimmed} {t_dimmed}"
    );
}

#[test]
fn a_pattern_on_a_medium_is_for_one_unit_of_the_scene() {
    // A block two units thick of .9 per unit, with a pattern of .8: (.9 · .8)² of what gets in, but for inner reflections.
    let block = "glass polygon front 0 0 12 0 0 0 90 0 0 90 90 0 0 90 0\nglass polygon back 0 0 12 0 90 -2 90 90 -2 90 0 -2 0 0 -2";
    let text = format!("void brightfunc dye 2 .8 . 0 0\ndye dielectric glass 0 0 5 .9 .9 .9 1.5 0\n{block}");
    for unit in [Unit::Meter, Unit::Inch] {
        let device = device_with(&text, &[], unit);
        let aperture = bsdftree_generate::Aperture {
            min: [44.0, 44.0, -2.0].map(|x| x * unit.meters()),
            max: [46.0, 46.0, 0.0].map(|x| x * unit.meters()),
        };
        let klems = Layout::Klems(std::sync::Arc::new(bsdftree::Basis::full()));
        let Generated { report, .. } =
            run(&device, &Options { layout: klems, aperture: Some(aperture), ..options(2000) });
        let totals = report.totals.iter().find(|t| t.part == Part::TransmissionBack).unwrap();
        // The first patch is within 5° of normal incidence.
        let (r, inside) = (0.04, (0.9_f64 * 0.8).powi(2));
        let expected = (1.0 - r) * (1.0 - r) * inside / (1.0 - (r * inside).powi(2));
        assert!(
            (totals.values[0] - expected).abs() < 5.0 * totals.errors[0] + 1e-3,
            "{unit:?}: {} ± {}, not {expected}",
            totals.values[0],
            totals.errors[0]
        );
    }
}

#[test]
fn function_materials_that_are_constant_are_diffuse() {
    for (material, reflected, transmitted) in [
        ("plasfunc m 2 flat f.cal 0 4 .5 .5 .5 .4", 0.6 * 0.5 + 0.4, 0.0),
        ("metfunc m 2 flat f.cal 0 4 .5 .5 .5 .4", 0.5, 0.0),
        ("transfunc m 2 flat f.cal 0 6 .5 .5 .5 .4 .5 .2", 0.6 * 0.5 * 0.5 + 0.4, 0.6 * 0.5 * 0.5),
        ("plasdata m 4 take d.dat f.cal across 0 4 .5 .5 .5 .4", 0.6 * 0.5 + 0.4, 0.0),
        (
            "BRTDfunc m 10 .1 .1 .1 .2 .2 .2 flat flat flat f.cal 0 9 .05 .05 .05 .9 .9 .9 .03 .03 .03",
            0.1 + 0.05 + 1.0,
            0.2 + 0.03 + 1.0,
        ),
    ] {
        let files = [
            ("f.cal", "flat(x,y,z,o) = 1/PI; take(v,x,y,z,o) = v; across(x,y,z,o) = x*x + y*y;"),
            ("d.dat", "1\n0 1 2\n.318309886 .318309886\n"),
        ];
        let device = device_with(&format!("void {material}\nm {PANE}"), &files, Unit::Meter);
        let Generated { report, .. } = run(&device, &options(4000));
        totals_are(&report, Part::ReflectionBack, |_| reflected);
        totals_are(&report, Part::TransmissionBack, |_| transmitted);
    }
}

#[test]
fn brtdfunc_mirrors_and_lets_through_by_the_angle() {
    let text = format!(
        "void BRTDfunc m 10 .9*Rdot .9*Rdot .9*Rdot .5-.5*Rdot .5-.5*Rdot .5-.5*Rdot 0 0 0 . 0 9 0 0 0 0 0 0 0 0 0\nm {PANE}"
    );
    let material = prepared(&device(&text));
    for theta in [10.0_f64, 40.0, 75.0] {
        let cosine = theta.to_radians().cos();
        let incoming = -DVec3::from_array(incident(theta));
        let mut random = Random::new(9, 0, 0);
        let mut sums = [0.0; 2];
        for _ in 0..100_000 {
            let s = material.scatter(&Meeting::new(DVec3::Z, incoming), &mut random).unwrap();
            let expected = if s.transmitted { incoming } else { incoming * DVec3::new(1.0, 1.0, -1.0) };
            assert!(s.direction.distance(expected) < 1e-12);
            sums[usize::from(s.transmitted)] += s.weight / 100_000.0;
        }
        // Standard errors below 1.6e-3.
        assert!((sums[0] - 0.9 * cosine).abs() < 7e-3, "{theta}: {sums:?}");
        assert!((sums[1] - (0.5 - 0.5 * cosine)).abs() < 7e-3, "{theta}: {sums:?}");
    }
}

#[test]
fn orientations_that_vary_follow_their_functions() {
    // Rough along u: with u along x, the reflected light spreads along x; with u along y, along y.
    let text = format!("void metal2 m 4 if(Px-.5,1,0) if(Px-.5,0,1) 0 . 0 6 1 1 1 1 .3 .05\nm {PANE}");
    let material = prepared(&device(&text));
    for (x, wide) in [(0.25, 1), (0.75, 0)] {
        let mut random = Random::new(10, 0, 0);
        let mut squares = [0.0; 2];
        for _ in 0..10_000 {
            let meeting =
                Meeting { position: DVec3::new(x, 0.5, 0.0), ..Meeting::new(DVec3::Z, DVec3::NEG_Z) };
            if let Some(s) = material.scatter(&meeting, &mut random) {
                squares[0] += s.direction.x.powi(2);
                squares[1] += s.direction.y.powi(2);
            }
        }
        assert!(squares[wide] > 10.0 * squares[1 - wide], "{x}: {squares:?}");
    }
}

#[test]
fn a_function_that_fails_ends_the_run_with_its_name() {
    for (function, file, expected) in [
        ("1/(Px-Px)", "", "'1/(Px-Px)' has no finite value"),
        ("sqrt(-1-Px)", "", "has no finite value"),
        ("forever(1)", "\n\nforever(x) = forever(x + 1);", "f.cal:3: "),
        ("nothing", "", "'nothing`f' is not defined"),
        ("A3", "", "arg(3) is missing, found 1 real arguments"),
    ] {
        let text =
            format!("void brightfunc p 2 {function} f.cal 0 1 1\np plastic m 0 0 5 .5 .5 .5 0 0\nm {PANE}");
        let device = device_with(&text, &[("f.cal", file)], Unit::Meter);
        let error = generate(&device, &options(10), &Progress::default()).unwrap_err();
        assert!(matches!(error, GenerateError::Function(_)), "{error}");
        let message = error.to_string();
        assert!(
            message.starts_with("test.rad:1: brightfunc \"p\": ") && message.contains(expected),
            "{message}"
        );
    }
}

#[test]
fn more_light_out_than_in_is_told() {
    let text = |factor: &str| {
        format!("void brightfunc p 2 {factor} . 0 0\np plastic paint 0 0 5 .8 .8 .8 0 0\npaint {PANE}")
    };
    let warnings = |factor| run(&device(&text(factor)), &options(100)).report.warnings;
    let told = warnings("if(Px-.9,1.5,1)");
    assert!(told.iter().any(|w| w.contains("'paint' sends out more light than it gets")), "{told:?}");
    assert!(warnings("1.25").is_empty());
    // Not cut off: as bright as it is said to be.
    totals_are(&run(&device(&text("1.5")), &options(500)).report, Part::ReflectionBack, |_| 1.2);
}

#[test]
fn negative_patterns_are_black() {
    let text = format!("void brightfunc p 2 -1 . 0 0\np plastic m 0 0 5 .8 .8 .8 0 0\nm {PANE}");
    totals_are(&run(&device(&text), &options(100)).report, Part::ReflectionBack, |_| 0.0);
}

/// Blinds whose paint is halved by a constant, by a function, and by its colour alone.
#[test]
fn varying_paint_without_reuse_agrees_with_plain_paint_with_it() {
    let blinds = Device::from_spec("blinds").unwrap().to_rad();
    let halved = |name: &str| {
        blinds.replace("void plastic", &format!("void brightfunc half 2 {name} . 0 0\nhalf plastic"))
    };
    let plain = {
        let mut device = device(&blinds);
        for named in &mut device.materials {
            if let bsdftree_device::Material::Gloss(gloss) = &mut named.material {
                gloss.color *= 0.5;
            }
        }
        device
    };
    let varying = device(&halved(".5+0*Px"));
    assert!(matches!(varying.materials[0].material, bsdftree_device::Material::Modified { .. }));
    let options = Options { sides: Sides::Both, ..options(4000) };
    let (a, b) = (run(&plain, &options), run(&varying, &options));
    let (mut chi2, mut n) = (0.0, 0.0);
    for (p, q) in a.report.totals.iter().zip(&b.report.totals) {
        for k in 0..p.values.len() {
            let variance = p.errors[k].powi(2) + q.errors[k].powi(2);
            if variance > 1e-12 {
                chi2 += (p.values[k] - q.values[k]).powi(2) / variance;
                n += 1.0;
            }
        }
    }
    // Errors of 8 replicates: a squared difference over their estimate has the mean 14/12 and the variance 3.3 for Student's 14.
    let z = (chi2 - n * 14.0 / 12.0) / (3.3 * n).sqrt();
    assert!(n > 200.0 && z.abs() < 5.0, "{chi2} of {n}: z = {z}");
}

#[test]
fn results_do_not_depend_on_threads() {
    let text = format!(
        "void texfunc t 4 .2*sin(40*Px) 0 0 . 0 0\nt brightfunc b 2 .5+.4*noise3(9*Px,9*Py,0) . 0 0\n\
         void plastic white 0 0 5 .9 .9 .9 .05 .1\nb metal shiny 0 0 5 .8 .7 .6 .9 .05\n\
         void mixfunc mix 4 white shiny .5+.5*sin(30*Py) . 0 0\nmix {PANE}"
    );
    let with = |threads| {
        let options = Options { threads: Some(threads), color: true, ..options(300) };
        format!("{:?}", run(&device(&text), &options).bsdf.bands)
    };
    assert!(with(1) == with(2));
}

#[test]
fn faults_are_told_once_for_all_threads() {
    let text = format!("void brightfunc p 2 log(-1) . 0 0\np plastic m 0 0 5 .5 .5 .5 0 0\nm {PANE}");
    let device = device(&text);
    let faults = std::sync::Arc::new(Faults::default());
    let material = PreparedMaterial::<f64>::prepare(&device.materials[0].material, "m", &faults);
    assert!(faults.error().is_none());
    assert!(material.scatter(&Meeting::new(DVec3::Z, DVec3::NEG_Z), &mut Random::new(0, 0, 0)).is_none());
    assert!(faults.error().unwrap().to_string().contains("brightfunc \"p\""));
}
