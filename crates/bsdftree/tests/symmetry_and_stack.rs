//! Devices in other positions, and layers: closed forms, inverses, and real files.

use std::f64::consts::PI;
use std::sync::Arc;

use bsdftree::convert::{ConvertError, Mirror, StackDomain, default_domain, merge, relative_l1, stack};
use bsdftree::direction::direction_from_polar;
use bsdftree::xml::{Strictness, read_file};
use bsdftree::{Basis, Bsdf, Component, Direction, Lobes, Matrix, Part, Rank, Scattering, Tree};
use bsdftree_testing::real_file;

fn with(parts: &[(Part, Scattering)]) -> Bsdf {
    let mut bsdf = Bsdf::default();
    for (part, function) in parts {
        bsdf.band_mut("Visible").insert(*part, Component::grey(function.clone()));
    }
    bsdf
}

/// All values different.
fn tree(rank: Rank, log2_res: u32) -> Scattering {
    let n = 1usize << (log2_res as usize * rank.dimensions());
    let values: Vec<f32> = (0..n).map(|k| (k * 7919 % n) as f32 / n as f32).collect();
    Tree::from_grid(rank, &values).unwrap().into()
}

fn matrix(basis: Basis) -> Scattering {
    let basis = Arc::new(basis);
    let n = basis.n_patches();
    let values = (0..n * n).map(|k| (k * 7919 % (n * n)) as f32 / (n * n) as f32).collect();
    Matrix::new(basis.clone(), basis, values).unwrap().into()
}

fn all_four(function: &Scattering) -> Bsdf {
    with(&Part::ALL.map(|part| (part, function.clone())))
}

fn pairs() -> impl Iterator<Item = (Direction, Direction)> {
    (1..300).map(|k| {
        let at = |step: f64| (0.371_93 + f64::from(k) * step).fract();
        let theta = |u: f64| u.sqrt().asin();
        let side = |theta: f64, back: bool| if back { PI - theta } else { theta };
        (
            direction_from_polar(side(theta(at(0.856_674_883)), k % 2 == 0), 2.0 * PI * at(0.733_891_856)),
            direction_from_polar(side(theta(at(0.628_706_721)), k % 3 == 0), 2.0 * PI * at(0.538_597_257)),
        )
    })
}

fn assert_moved(before: &Bsdf, after: &Bsdf, back: impl Fn(Direction) -> Direction) {
    for (i, o) in pairs() {
        let (old, new) = (before.bands[0].eval(back(i), back(o)), after.bands[0].eval(i, o));
        assert!((old - new).abs() < 1e-6, "{i:?} {o:?}: {old} {new}");
    }
}

#[test]
fn mirrored_and_flipped_devices_have_the_values_of_mirrored_directions() {
    for function in
        [tree(Rank::Four, 3), tree(Rank::Three, 4), matrix(Basis::quarter()), matrix(Basis::full())]
    {
        let bsdf = all_four(&function);
        assert_moved(&bsdf, &bsdf.mirrored(Mirror::X), |[x, y, z]| [-x, y, z]);
        assert_moved(&bsdf, &bsdf.mirrored(Mirror::Y), |[x, y, z]| [x, -y, z]);
    }
    let bsdf =
        with(&[(Part::ReflectionFront, tree(Rank::Four, 2)), (Part::TransmissionBack, tree(Rank::Four, 3))]);
    assert_moved(&bsdf, &bsdf.flipped(), |[x, y, z]| [-x, y, -z]);
    assert_moved(&bsdf, &bsdf.flipped().flipped(), |d| d);
}

#[test]
fn turns_by_quarters_and_whole_patches_are_exact() {
    let turned_back = |azimuth: f64| {
        move |[x, y, z]: Direction| {
            let (s, c) = f64::sin_cos(-azimuth);
            [c * x - s * y, s * x + c * y, z]
        }
    };
    for function in
        [tree(Rank::Four, 3), tree(Rank::Three, 4), matrix(Basis::quarter()), matrix(Basis::full())]
    {
        let bsdf = all_four(&function);
        for azimuth in [0.5 * PI, PI, -0.5 * PI, 2.0 * PI] {
            assert_moved(&bsdf, &bsdf.turned(azimuth).unwrap(), turned_back(azimuth));
        }
    }
    let ring = |a, b, n_phi| bsdftree::klems::Ring { bounds_deg: [a, b], n_phi };
    let basis = Basis::new("even", vec![ring(0.0, 30.0, 1), ring(30.0, 90.0, 12)]).unwrap();
    let bsdf = all_four(&matrix(basis));
    assert_moved(&bsdf, &bsdf.turned(PI / 6.0).unwrap(), turned_back(PI / 6.0));
}

#[test]
fn any_turn_keeps_light_and_a_turn_back_comes_near() {
    // A broad lobe in one azimuth.
    let lobe = |i: Direction, o: Direction| {
        0.05 + (-((i[0] + o[0] - 0.3).powi(2) + (i[1] + o[1]).powi(2)) / 0.3).exp()
    };
    let n = 16usize;
    let at =
        |k: usize| bsdftree::square::disk_from_square([k / n, k % n].map(|c| (c as f64 + 0.5) / n as f64));
    let values: Vec<f32> = (0..n.pow(4))
        .map(|k| {
            let (i, o) = (at(k / (n * n)), at(k % (n * n)));
            lobe([-i[0], -i[1], 0.0], [o[0], o[1], 0.0]) as f32
        })
        .collect();
    let function = Scattering::from(Tree::from_grid(Rank::Four, &values).unwrap());
    let bsdf = with(&[(Part::ReflectionBack, function)]);
    let klems = bsdf.to_klems(&Arc::new(Basis::full())).unwrap();
    for bsdf in [bsdf, klems] {
        let light = |b: &Bsdf| {
            let theta = |k: u32| ((f64::from(k % 64) + 0.5) / 64.0).sqrt().asin();
            let ring = |k: u32| direction_from_polar(theta(k), 2.399_963 * f64::from(k));
            (0..64 * 64).map(|k| b.bands[0].hemispherical(ring(k), Lobes::All)).sum::<f64>()
        };
        let function = |b: &Bsdf| b.bands[0].component(Part::ReflectionBack).unwrap().luminance.clone();
        for azimuth in [0.4, 2.0, -1.0] {
            let turned = bsdf.turned(azimuth).unwrap();
            assert!(
                (light(&turned) / light(&bsdf) - 1.0).abs() < 3e-3,
                "{} {}",
                light(&turned),
                light(&bsdf)
            );
            let apart = relative_l1(&function(&bsdf), &function(&turned));
            let back = relative_l1(&function(&bsdf), &function(&turned.turned(-azimuth).unwrap()));
            assert!(back < 0.15 && back < 0.5 * apart, "{azimuth}: {back} {apart}");
        }
    }
}

#[test]
fn lambertian_layers_stack_as_in_the_closed_form() {
    // Two layers with R1, T1, R2, T2: T = T1 T2 / (1 − R1 R2), R = R1 + T1² R2 / (1 − R1 R2).
    let lambertian = |rho: f64| Scattering::from(Tree::uniform(Rank::Four, (rho / PI) as f32));
    let layer = |r: f64, t: f64| {
        with(&[
            (Part::ReflectionFront, lambertian(r)),
            (Part::ReflectionBack, lambertian(r)),
            (Part::TransmissionFront, lambertian(t)),
        ])
    };
    let (a, b) = (layer(0.5, 0.4), layer(0.7, 0.2));
    for domain in
        [StackDomain::Klems(Arc::new(Basis::full())), StackDomain::Tree { log2_res: 3, tolerance: 0.0 }]
    {
        let made = stack(&[&a, &b], &domain).unwrap();
        let inter = 1.0 / (1.0 - 0.5 * 0.7);
        for (theta, lobes, expected) in [
            (2.5, Lobes::Transmission, 0.4 * 0.2 * inter),
            (0.5, Lobes::Transmission, 0.4 * 0.2 * inter),
            (2.5, Lobes::Reflection, 0.5 + 0.4 * 0.4 * 0.7 * inter),
            (0.5, Lobes::Reflection, 0.7 + 0.2 * 0.2 * 0.5 * inter),
        ] {
            let total = made.bands[0].hemispherical(direction_from_polar(theta, 1.0), lobes);
            assert!((total - expected).abs() < 1e-6, "{theta} {lobes:?}: {total} {expected}");
        }
        // Three layers are two and one.
        let three = stack(&[&a, &b, &a], &domain).unwrap();
        let nested = stack(&[&a, &stack(&[&b, &a], &domain).unwrap()], &domain).unwrap();
        for (i, o) in pairs().take(20) {
            assert!((three.bands[0].eval(i, o) - nested.bands[0].eval(i, o)).abs() < 1e-6);
        }
    }
}

#[test]
fn nothing_in_front_of_a_layer_changes_nothing() {
    for (domain, function) in [
        (StackDomain::Klems(Arc::new(Basis::quarter())), matrix(Basis::quarter())),
        (StackDomain::Tree { log2_res: 3, tolerance: 0.0 }, tree(Rank::Four, 3)),
    ] {
        // Light goes straight through a hole: 1/Λ on the diagonal.
        let open = match &domain {
            StackDomain::Klems(basis) => {
                let n = basis.n_patches();
                let values =
                    (0..n * n)
                        .map(|k| {
                            if k / n == k % n {
                                (1.0 / basis.projected_solid_angle(k % n)) as f32
                            } else {
                                0.0
                            }
                        })
                        .collect();
                Scattering::from(Matrix::new(basis.clone(), basis.clone(), values).unwrap())
            }
            StackDomain::Tree { log2_res, .. } => {
                let n = 1usize << (2 * log2_res);
                let values: Vec<f32> =
                    (0..n * n).map(|k| if k / n == k % n { (n as f64 / PI) as f32 } else { 0.0 }).collect();
                Tree::from_grid(Rank::Four, &values).unwrap().into()
            }
        };
        let hole = with(&[(Part::TransmissionFront, open.clone()), (Part::TransmissionBack, open)]);
        // Less than all light.
        let layer = with(&[(Part::ReflectionFront, function.clone()), (Part::TransmissionFront, function)]);
        for layers in [[&hole, &layer], [&layer, &hole]] {
            assert_moved(&layer, &stack(&layers, &domain).unwrap(), |d| d);
        }
    }
}

#[test]
fn a_mirror_in_front_of_itself_traps_light() {
    let mirror =
        with(&Part::ALL.map(|part| (part, Scattering::from(Tree::uniform(Rank::Four, (1.0 / PI) as f32)))));
    let domain = StackDomain::Tree { log2_res: 2, tolerance: 0.0 };
    assert!(matches!(stack(&[&mirror, &mirror], &domain), Err(ConvertError::Trapped)));
    assert!(matches!(stack(&[], &domain), Err(ConvertError::NoLayers)));
    let mut solar = mirror.clone();
    solar.bands[0].name = "Solar".into();
    assert!(matches!(stack(&[&mirror, &solar], &domain), Err(ConvertError::NoCommonBand)));
}

#[test]
fn real_layers_stack_over_the_basis_they_have() {
    let (Some(glass), Some(shade)) =
        (real_file("pyradiance/clear.xml"), real_file("mermet/E_Screen_3pct_White.xml"))
    else {
        return;
    };
    let [glass, shade] = [glass, shade].map(|path| read_file(&path, Strictness::Repair).unwrap().0);
    let domain = default_domain(&[&glass, &shade]);
    assert!(matches!(&domain, StackDomain::Klems(basis) if basis.n_patches() == 145));
    let made = stack(&[&glass, &shade], &domain).unwrap();
    assert_eq!(made.bands.len(), 2);
    for theta in [0.0, 0.5, 1.0, 2.0, 2.6, PI] {
        for band in &made.bands {
            let at = direction_from_polar(theta, 0.3);
            let total = band.hemispherical(at, Lobes::All);
            let alone = shade.band(&band.name).unwrap().hemispherical(at, Lobes::Transmission);
            let through = band.hemispherical(at, Lobes::Transmission);
            assert!(
                total < 1.0 && through < alone && through > 0.3 * alone,
                "{theta}: {total} {through} {alone}"
            );
        }
    }
}

#[test]
fn merging_joins_what_fits_and_says_what_does_not() {
    let front = with(&[(Part::ReflectionFront, tree(Rank::Four, 2))]);
    let back = with(&[(Part::ReflectionBack, tree(Rank::Four, 3))]);
    let (made, remarks) = merge(&[&front, &back]).unwrap();
    assert_eq!((made.bands[0].components().count(), remarks.len()), (2, 0));
    assert!(matches!(merge(&[&front, &front]), Err(ConvertError::Twice { .. })));
    let other = with(&[(Part::ReflectionBack, matrix(Basis::quarter()))]);
    let error = merge(&[&front, &other]).unwrap_err().to_string();
    assert!(
        error.contains("reflection_back") && error.contains("rank 4") && error.contains("Quarter"),
        "{error}"
    );
    let mut wide = back.clone();
    wide.header.width = Some(2.0);
    let mut narrow = front.clone();
    narrow.header.width = Some(1.0);
    assert_eq!(merge(&[&narrow, &wide]).unwrap().1.len(), 1);
}
