//! Each mistake is put into a BSDF that has none, is found, named and undone; and is not found where it is not.

mod common;

use std::sync::Arc;

use bsdftree::check::{BandReport, Finding, Kind, Motion, Repair, Severity, Tolerance, check};
use bsdftree::repair::repaired;
use bsdftree::xml::Strictness;
use bsdftree::{Basis, Bsdf, Component, Direction, Matrix, Part, Rank, Scattering, Side, Tree, file};
use bsdftree_testing::{READABLE, real_file};

type Formula = fn(Direction, Direction) -> f64;

fn lobe(x: f64, y: f64) -> f64 {
    0.01 + 0.3 * (-3.0 * (x * x + y * y)).exp()
}

/// A reflection that is reciprocal, and as the device is neither left to right nor top to bottom.
fn reflection(i: Direction, o: Direction) -> f64 {
    lobe(i[0] + o[0] - 0.4, i[1] + o[1] + 0.3) * (1.0 + 0.5 * i[0] * o[0])
}

/// Transmission from outside, and what comes back from the room.
fn inward(i: Direction, o: Direction) -> f64 {
    lobe(i[0] + 0.6 * o[0] - 0.3, i[1] + o[1] - 0.4) * (1.0 + 0.4 * i[1])
}

fn outward(i: Direction, o: Direction) -> f64 {
    inward(o, i)
}

const LAWFUL: [(Part, Formula); 4] = [
    (Part::ReflectionFront, |i, o| reflection([i[1], i[0], i[2]], [o[1], o[0], o[2]])),
    (Part::ReflectionBack, reflection),
    (Part::TransmissionFront, inward),
    (Part::TransmissionBack, outward),
];

fn matrix(part: Part, f: impl Fn(Direction, Direction) -> f64) -> Scattering {
    let basis = Arc::new(Basis::full());
    let n = basis.n_patches();
    // The one patch of the first ring is centred on the normal.
    let disk = |k: usize| if k == 0 { [0.0; 2] } else { basis.disk_point(k, 0.5, 0.5) };
    let values = (0..n * n).map(|k| {
        let incident = part.incident_side().direction_from_disk(disk(k / n).map(|c| -c));
        f(incident, part.exitant_side().direction_from_disk(disk(k % n))) as f32
    });
    Matrix::new(basis.clone(), basis.clone(), values.collect()).unwrap().into()
}

fn tree(part: Part, f: impl Fn(Direction, Direction) -> f64) -> Scattering {
    let at = |c: usize| (c as f64 + 0.5) / 16.0;
    let disk = |x, y| bsdftree::square::disk_from_square([at(x), at(y)]);
    let values: Vec<f32> = (0..1 << 16)
        .map(|k| {
            let incident = part.incident_side().direction_from_disk(disk(k >> 12, k >> 8 & 15).map(|c| -c));
            f(incident, part.exitant_side().direction_from_disk(disk(k >> 4 & 15, k & 15))) as f32
        })
        .collect();
    Tree::from_grid(Rank::Four, &values).unwrap().into()
}

/// Makes one component of a formula.
type Maker = fn(Part, &dyn Fn(Direction, Direction) -> f64) -> Scattering;

const MAKERS: [Maker; 2] = [|part, f| matrix(part, f), |part, f| tree(part, f)];

/// The lawful device, with a mistake in what it says.
fn device(make: Maker, mistake: impl Fn(Part, Formula, Direction, Direction) -> f64) -> Bsdf {
    let mut bsdf = Bsdf::default();
    for (part, f) in LAWFUL {
        let function = make(part, &|i, o| mistake(part, f, i, o));
        bsdf.band_mut("Visible").insert(part, Component::grey(function));
    }
    bsdf
}

fn lawful(make: Maker) -> Bsdf {
    device(make, |_, f, i, o| f(i, o))
}

fn report(bsdf: &Bsdf) -> BandReport {
    check(bsdf, Tolerance::default()).bands.remove(0)
}

fn of_kind(bsdf: &Bsdf, kind: Kind) -> Vec<Finding> {
    let report = check(bsdf, Tolerance::default());
    report.all().filter(|(_, f)| f.kind == kind).map(|(_, f)| f.clone()).collect()
}

/// How far the components of two devices are from each other at most (relative L1).
fn distance(a: &Bsdf, b: &Bsdf) -> f64 {
    let bands = a.bands.iter().zip(&b.bands);
    bands
        .flat_map(|(a, b)| {
            a.components().map(move |(part, component)| {
                let other = b.component(part).expect("the same components");
                bsdftree::convert::relative_l1(&component.luminance, &other.luminance)
            })
        })
        .fold(0.0, f64::max)
}

/// Found, named, undone, and not there afterwards.
fn assert_undone(clean: &Bsdf, wrong: &Bsdf, kind: Kind, tolerance: f64) {
    assert_eq!(of_kind(clean, kind), [], "nothing is wrong with the device itself");
    let found = of_kind(wrong, kind);
    assert!(found.iter().any(|f| f.repair.is_some()), "{found:?}");
    let (mended, done) = repaired(wrong, &[kind], Tolerance::default());
    assert!(!done.is_empty());
    assert_eq!(of_kind(&mended, kind), [], "after {done:?}");
    let distance = distance(clean, &mended);
    assert!(distance < tolerance, "{distance} after {done:?}");
}

#[test]
fn a_lawful_device_of_either_kind_is_only_what_it_is() {
    for make in MAKERS {
        let bsdf = lawful(make);
        for r in report(&bsdf).reciprocity {
            assert!(r.max < 1e-5, "{r:?}");
        }
        assert_eq!(report(&bsdf).findings, []);
        let (after, done) = repaired(&bsdf, &Kind::ALL, Tolerance::default());
        assert!(done.is_empty());
        assert_eq!(distance(&bsdf, &after), 0.0);
    }
}

#[test]
fn rows_and_columns_exchanged_in_one_transmission_are_found_and_undone() {
    for make in MAKERS {
        // Exchanged: the incident patch of −i is that of o.
        let wrong = device(make, |part, f, i, o| match part {
            Part::TransmissionBack => f([-o[0], -o[1], o[2]], [-i[0], -i[1], i[2]]),
            _ => f(i, o),
        });
        assert_undone(&lawful(make), &wrong, Kind::Orientation, 1e-6);
        let told = of_kind(&wrong, Kind::Orientation);
        assert!(told[0].message.contains("rows and columns are exchanged"), "{told:?}");
    }
}

#[test]
fn one_transmission_written_as_the_other_is_found_and_undone() {
    for make in MAKERS {
        let wrong = device(make, |part, f, i, o| match part {
            Part::TransmissionBack => inward(i, o),
            _ => f(i, o),
        });
        assert_undone(&lawful(make), &wrong, Kind::Orientation, 1e-6);
        assert!(of_kind(&wrong, Kind::Orientation)[0].message.contains("the values of Transmission Front"));
    }
}

#[test]
fn a_transmission_seen_from_its_own_side_is_found_and_undone() {
    for make in MAKERS {
        for motion in Motion::ALL {
            let wrong = device(make, |part, f, i, o| match part {
                Part::TransmissionBack => f(motion.of(i), motion.of(o)),
                _ => f(i, o),
            });
            // Rings of 20 patches and the like have quarter turns; others share.
            let tolerance =
                if matches!(motion, Motion::QuarterTurn | Motion::QuarterBack) { 0.1 } else { 1e-6 };
            assert_undone(&lawful(make), &wrong, Kind::Orientation, tolerance);
        }
    }
}

#[test]
fn incident_directions_that_count_otherwise_are_found_and_undone() {
    for make in MAKERS {
        for motion in [Motion::HalfTurn, Motion::MirrorX, Motion::MirrorY] {
            let wrong = device(make, |_, f, i, o| f(motion.of(i), o));
            assert_undone(&lawful(make), &wrong, Kind::Orientation, 1e-6);
            let told = of_kind(&wrong, Kind::Orientation);
            assert!(told.iter().all(|f| f.repair == Some(Repair::MoveIncident(motion))), "{told:?}");
            assert_eq!(told.len(), 4, "{told:?}");
        }
    }
}

#[test]
fn values_times_a_cosine_are_found_and_undone() {
    for (make, tolerance) in MAKERS.into_iter().zip([0.06, 0.06]) {
        let wrong = device(make, |_, f, i, o| f(i, o) * o[2].abs());
        assert_undone(&lawful(make), &wrong, Kind::Units, tolerance);
        assert!(of_kind(&wrong, Kind::Units)[0].message.contains("cosine"));
    }
}

#[test]
fn values_times_a_solid_angle_are_found_and_undone() {
    let basis = Basis::full();
    let clean = lawful(MAKERS[0]);
    for (name, angle) in [("projected solid angle", true), ("the solid angle", false)] {
        let wrong = device(MAKERS[0], |_, f, i, o| {
            let patch = basis.patch(o);
            let projected = basis.projected_solid_angle(patch);
            let mut ring = basis.rings()[0];
            for r in basis.rings() {
                if r.bounds_deg[0] <= o[0].hypot(o[1]).asin().to_degrees() {
                    ring = *r;
                }
            }
            let [a, b] = ring.bounds_deg.map(|t| t.to_radians().cos());
            let solid = std::f64::consts::TAU * (a - b) / f64::from(ring.n_phi);
            f(i, o) * if angle { projected } else { solid }
        });
        assert_undone(&clean, &wrong, Kind::Units, 1e-4);
        assert!(of_kind(&wrong, Kind::Units)[0].message.contains(name));
    }
}

#[test]
fn percentages_are_found_and_undone() {
    for make in MAKERS {
        let wrong = device(make, |_, f, i, o| 100.0 * f(i, o));
        assert_undone(&lawful(make), &wrong, Kind::Units, 1e-6);
    }
}

#[test]
fn more_light_out_than_in_is_scaled_down_and_stays_reciprocal() {
    for make in MAKERS {
        let wrong = device(make, |_, f, i, o| 2.5 * f(i, o));
        let before = report(&wrong);
        let worst = before.findings.iter().find(|f| f.kind == Kind::Energy).expect("too much energy");
        assert!(
            worst.severity == Severity::Violation && worst.at.is_some() && worst.amount > 0.05,
            "{worst:?}"
        );
        let (after, _) = repaired(&wrong, &[Kind::Energy], Tolerance::default());
        let after = report(&after);
        for e in &after.energy {
            assert!(e.max < 1.0 + 1e-5 && e.max > 0.9 && e.over < 1e-9, "{e:?}");
        }
        for (before, after) in before.reciprocity.iter().zip(&after.reciprocity) {
            assert!(after.mean < before.mean + 0.003, "{after:?}");
        }
    }
}

#[test]
fn what_is_not_reciprocal_becomes_so_and_keeps_its_light() {
    for make in MAKERS {
        // No factor of one direction alone, and no motion.
        let wrong = device(make, |part, f, i, o| {
            f(i, o) * if part.is_reflection() { 1.0 + 0.95 * (7.0 * (i[0] - o[1])).sin() } else { 1.0 }
        });
        assert_eq!(of_kind(&lawful(make), Kind::Reciprocity), []);
        let found = of_kind(&wrong, Kind::Reciprocity);
        assert_eq!(found.len(), 2, "{found:?}");
        let (after, done) = repaired(&wrong, &[Kind::Reciprocity], Tolerance::default());
        assert!(done.iter().all(|d| d.before > 0.25 && d.after < 1e-6), "{done:?}");
        let light = |bsdf: &Bsdf| report(bsdf).energy.iter().map(|e| e.mean[0]).sum::<f64>();
        assert!((light(&after) / light(&wrong) - 1.0).abs() < 1e-4);
    }
}

#[test]
fn reflections_in_each_others_place_are_found_by_energy_and_undone() {
    for make in MAKERS {
        let of = |part: Part, _: Formula, _: Direction, _: Direction| match part {
            Part::ReflectionFront => 0.25,
            Part::ReflectionBack => 0.05,
            Part::TransmissionFront | Part::TransmissionBack => 0.0,
        };
        // Light from the room is let through, that from outside is not: by a device that is no window.
        let one_way = |part: Part, f: Formula, i: Direction, o: Direction| match part {
            Part::TransmissionBack => 0.2,
            part => of(part, f, i, o),
        };
        let clean = device(make, one_way);
        let wrong = device(make, |part, f, i, o| {
            let swapped = match part {
                Part::ReflectionFront => Part::ReflectionBack,
                Part::ReflectionBack => Part::ReflectionFront,
                other => other,
            };
            one_way(swapped, f, i, o)
        });
        assert_undone(&clean, &wrong, Kind::Sides, 1e-6);
    }
}

#[test]
fn a_reflection_that_is_a_transmission_is_found_and_left_out() {
    let wrong = device(MAKERS[0], |part, f, i, o| match part {
        Part::ReflectionBack => inward(i, o),
        _ => f(i, o),
    });
    let found = of_kind(&wrong, Kind::Sides);
    assert_eq!((found[0].part, found[0].repair), (Some(Part::ReflectionBack), Some(Repair::Drop)));
    let (after, _) = repaired(&wrong, &[Kind::Sides], Tolerance::default());
    assert!(after.bands[0].component(Part::ReflectionBack).is_none());
}

#[test]
fn colours_that_there_are_none_of_are_found_and_become_possible() {
    let uv = |function: &Scattering, u: f32, v: f32| -> [Scattering; 2] {
        match function {
            Scattering::Tree(_) => [u, v].map(|c| Tree::uniform(Rank::Four, c).into()),
            Scattering::Matrix(y) => {
                let xyz = bsdftree::color::xyz_from_yuv(1.0, [f64::from(u), f64::from(v)]);
                [xyz[0], xyz[2]].map(|c| {
                    let values = y.values().iter().map(|&v| v * c as f32).collect();
                    Matrix::new(y.incident().clone(), y.exitant().clone(), values).unwrap().into()
                })
            }
        }
    };
    for make in MAKERS {
        let coloured = |u, v| {
            let mut bsdf = lawful(make);
            for part in Part::ALL {
                let component = bsdf.bands[0].component_mut(part).unwrap();
                component.chroma = Some(uv(&component.luminance, u, v));
            }
            bsdf
        };
        assert_eq!(of_kind(&coloured(0.2, 0.5), Kind::Colour), []);
        // Possible, but no mixture of RGB's primaries: a note without a repair.
        let saturated = of_kind(&coloured(0.05, 0.57), Kind::Colour);
        assert!(
            saturated.iter().all(|f| f.severity == Severity::Note && f.repair.is_none()),
            "{saturated:?}"
        );
        assert_eq!(saturated.len(), 4);
        let impossible = coloured(0.005, 0.45);
        let found = of_kind(&impossible, Kind::Colour);
        assert!((found[0].amount - 1.0).abs() < 1e-9 && found[0].severity == Severity::Warning);
        let (after, done) = repaired(&impossible, &[Kind::Colour], Tolerance::default());
        assert_eq!(done.len(), 4);
        assert!(done.iter().all(|d| d.before == 1.0 && d.after == 0.0), "{done:?}");
        assert_eq!(distance(&impossible, &after), 0.0, "luminance is kept");
    }
}

#[test]
fn components_turned_against_each_other_are_told_and_one_lying_on_its_side_is_guessed() {
    let slats = |i: Direction, o: Direction| 0.01 + 0.3 * (-9.0 * (i[1] + o[1] - 0.5).powi(2)).exp();
    let turned = |i: Direction, o: Direction| 0.01 + 0.3 * (-9.0 * (i[0] + o[0] - 0.5).powi(2)).exp();
    for make in MAKERS {
        let upright = device(make, |_, _, i, o| slats(i, o));
        assert_eq!(of_kind(&upright, Kind::Orientation), []);
        let on_its_side = of_kind(&device(make, |_, _, i, o| turned(i, o)), Kind::Orientation);
        assert_eq!(on_its_side.len(), 1, "{on_its_side:?}");
        assert!(on_its_side[0].severity == Severity::Note && on_its_side[0].message.contains("a guess"));
        let mixed =
            device(make, |part, _, i, o| if part.is_reflection() { slats(i, o) } else { turned(i, o) });
        let found = of_kind(&mixed, Kind::Orientation);
        assert!(found.iter().any(|f| f.severity == Severity::Warning && f.message.contains("turned by 90°")));
    }
}

/// Normal numbers from even ones, Box and Muller's way.
fn normal(k: u64) -> f64 {
    // SplitMix64 (Steele, Lea and Flood, 2014).
    let even = |k: u64| {
        let mut x = (k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ x >> 31) >> 11) as f64 / (1u64 << 53) as f64
    };
    (-2.0 * (1.0 - even(2 * k)).ln()).sqrt() * (std::f64::consts::TAU * even(2 * k + 1)).cos()
}

/// Noise of a known relative standard deviation is measured within 12 % of it, and that of smooth data is below 2 %.
#[test]
fn noise_of_known_level_is_measured() {
    for make in MAKERS {
        let of = |sigma: f64| {
            let counter = std::cell::Cell::new(0u64);
            let noisy = device(make, |_, f, i, o| {
                counter.set(counter.get() + 1);
                (f(i, o) * (1.0 + sigma * normal(counter.get()))).max(0.0)
            });
            report(&noisy).noise
        };
        for noise in of(0.0) {
            assert!(noise.level.is_none_or(|level| level < 0.02), "{noise:?}");
        }
        for sigma in [0.05, 0.1, 0.2] {
            for noise in of(sigma) {
                let level = noise.level.expect("a level");
                assert!((level / sigma - 1.0).abs() < 0.12, "σ = {sigma}: {noise:?}");
                let told = [noise.neighbours, noise.reversal].into_iter().flatten();
                assert!(told.clone().count() == 2);
                for level in told {
                    assert!((level / sigma - 1.0).abs() < 0.25, "σ = {sigma}: {noise:?}");
                }
            }
        }
    }
}

fn real(name: &str) -> Option<Bsdf> {
    Some(file::read(&real_file(name)?, Strictness::Repair).unwrap().0)
}

/// Only what is known to be wrong of each real file is told; `kind part` of violations and warnings.
#[test]
fn real_files_give_no_false_alarm() {
    for name in READABLE {
        let Some(bsdf) = real(name) else { continue };
        let report = check(&bsdf, Tolerance::default());
        let told: Vec<_> = report
            .all()
            .filter(|(_, f)| f.severity != Severity::Note)
            // What is not there is not there.
            .filter(|(_, f)| !(f.kind == Kind::Sides && f.message.starts_with("no ")))
            .map(|(band, f)| format!("{} {}", band.unwrap_or("header"), f.kind.name()))
            .collect();
        let known: &[&str] = match name {
            // Solar: Reflection Back is Transmission Front once more, which makes 137 %.
            "frads/ec60.xml" => &["Solar energy", "Solar sides"],
            // Its one value is in the half that is not read; Radiance too finds it black.
            "ignis/simple_tensor_d2_t3_trans.xml" => &["Visible orientation"],
            // Numbers of nobody's device.
            "ignis/simple_tensor_d2_refl.xml" => &["Visible reciprocity", "Visible reciprocity"],
            // A formula that scatters 80 times what comes in; Radiance's file says "Bogus".
            "radiance/testBSDF.xml" => &["Visible energy", "Visible units"],
            _ => &[],
        };
        assert_eq!(told, known, "{name}");
    }
}

/// Real, four components, good to 1 %, and another device upside down.
const BLINDS: &str = "pyradiance/blinds.xml";

#[test]
fn mistakes_planted_in_a_real_file_are_found_and_undone() {
    let Some(clean) = real(BLINDS) else { return };
    type Plant = fn(&Matrix, Part) -> Vec<f32>;
    fn table(m: &Matrix, f: impl Fn(usize, usize) -> f32) -> Vec<f32> {
        (0..m.values().len()).map(|k| f(k / 145, k % 145)).collect()
    }
    fn opposite(k: usize) -> usize {
        let basis = Basis::full();
        let d = Side::Front.direction_from_disk(basis.disk_point(k, 0.5, 0.5));
        basis.patch([-d[0], -d[1], d[2]])
    }
    fn middle_cosine(patch: usize) -> f32 {
        let mut first = 0;
        for ring in Basis::full().rings() {
            first += ring.n_phi as usize;
            if patch < first {
                let middle =
                    if patch == 0 { 0.0f64 } else { 0.5 * (ring.bounds_deg[0] + ring.bounds_deg[1]) };
                return middle.to_radians().cos() as f32;
            }
        }
        unreachable!("a patch of the basis")
    }
    let plants: [(Kind, Plant); 3] = [
        (Kind::Orientation, |m, _| table(m, |i, o| m.values()[opposite(i) * 145 + o])),
        (Kind::Units, |m, _| table(m, |i, o| m.values()[i * 145 + o] * middle_cosine(o))),
        (Kind::Units, |m, _| {
            table(m, |i, o| m.values()[i * 145 + o] * m.exitant().projected_solid_angle(o) as f32)
        }),
    ];
    for (k, (kind, plant)) in plants.into_iter().enumerate() {
        let mut wrong = clean.clone();
        for part in Part::ALL {
            let component = wrong.bands[0].component_mut(part).expect("all four");
            let Scattering::Matrix(m) = &component.luminance else { panic!("matrices") };
            let made = Matrix::new(m.incident().clone(), m.exitant().clone(), plant(m, part)).unwrap();
            component.luminance = made.into();
        }
        println!("plant {k}");
        assert_undone(&clean, &wrong, kind, 0.05);
    }
}
