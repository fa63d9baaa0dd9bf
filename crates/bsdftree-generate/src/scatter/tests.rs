//! Claims about whole materials. Statistics: fixed seeds; bounds on |z| are such that a right sampler would exceed
//! them with a probability below 1e-4 a test.

use std::f64::consts::{FRAC_1_PI, PI};

use bsdftree_device::material::{Gloss, GlossKind, Material, Medium};
use glam::DVec3;

use super::test_support::{Cells, direction, polar};
use super::*;

const PAINT: Gloss = Gloss {
    kind: GlossKind::Plastic,
    color: DVec3::new(0.6, 0.6, 0.6),
    specular: 0.0,
    roughness: [0.0; 2],
    orientation: None,
    transmission: 0.0,
    transmitted_specular: 0.0,
};

fn metal(roughness: [f64; 2]) -> Gloss {
    Gloss { kind: GlossKind::Metal, color: DVec3::ONE, specular: 1.0, roughness, ..PAINT }
}

fn sheet() -> Gloss {
    Gloss {
        kind: GlossKind::Trans,
        color: DVec3::new(0.9, 0.7, 0.4),
        specular: 0.1,
        roughness: [0.25; 2],
        transmission: 0.6,
        transmitted_specular: 0.5,
        ..PAINT
    }
}

fn glossy(gloss: Gloss) -> PreparedMaterial<f64> {
    PreparedMaterial::new(&Material::Gloss(gloss))
}

/// A material with random legal parameters.
fn any_material(random: &mut Random) -> Material {
    fn rgb(random: &mut Random) -> DVec3 {
        let saturated = |u: f64| (1.2 * u - 0.1).clamp(0.0, 1.0);
        DVec3::from_array(std::array::from_fn(|_| saturated(random.next_f64())))
    }
    fn fraction(random: &mut Random) -> f64 {
        (1.4 * random.next_f64() - 0.2).clamp(0.0, 1.0)
    }
    let medium = |random: &mut Random| Medium { transmittance: rgb(random), index: 1.0 + random.next_f64() };
    match random.next_u32() % 6 {
        0 => Material::Glass { transmissivity: rgb(random), index: 1.0 + random.next_f64() },
        1 => Material::Dielectric { inside: medium(random), outside: medium(random) },
        2 => Material::Mirror { reflectance: rgb(random) },
        kind => {
            let kind = [GlossKind::Plastic, GlossKind::Metal, GlossKind::Trans][kind as usize - 3];
            let transmits = if kind == GlossKind::Trans { 1.0 } else { 0.0 };
            Material::Gloss(Gloss {
                kind,
                color: rgb(random),
                specular: fraction(random),
                roughness: [fraction(random), fraction(random)].map(|r| 0.5 * r),
                orientation: random.next_u32().is_multiple_of(2).then(|| 3.0 * direction(random)),
                transmission: transmits * fraction(random),
                transmitted_specular: transmits * fraction(random),
            })
        }
    }
}

#[test]
fn no_material_gains_energy_and_all_directions_are_unit() {
    let mut random = Random::new(11, 0, 0);
    let n = 4000;
    for case in 0..600 {
        let material = any_material(&mut random);
        let prepared = PreparedMaterial::<DVec3>::new(&material);
        let normal = direction(&mut random);
        let mut incoming = direction(&mut random);
        if case % 7 == 0 {
            // Grazing to the last bit: perpendicular to the normal as far as rounding allows.
            incoming = (incoming - normal * incoming.dot(normal)).normalize();
        }
        let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for _ in 0..n {
            let Some(s) = prepared.scatter(&Meeting::new(normal, incoming), &mut random) else { continue };
            assert!((s.direction.length() - 1.0).abs() < 1e-12, "{material:?}");
            let crossed = s.direction.dot(normal) * incoming.dot(normal) > 0.0;
            assert!(
                crossed == s.transmitted || s.direction.dot(normal).abs() < 1e-12 || case % 7 == 0,
                "{material:?}"
            );
            assert!(s.weight.min_element() >= 0.0 && s.weight.is_finite(), "{material:?} {}", s.weight);
            sum += s.weight;
            squares += s.weight * s.weight;
        }
        let mean = sum / n as f64;
        let error = ((squares / n as f64 - mean * mean).max(DVec3::ZERO) / n as f64).map(f64::sqrt);
        assert!((mean - 5.5 * error).max_element() <= 1.0 + 1e-9, "{mean} ± {error}: {material:?}");
    }
}

#[test]
fn exact_grazing_and_axis_aligned_rays_give_unit_directions() {
    let mut random = Random::new(12, 0, 0);
    for _ in 0..2000 {
        let prepared = PreparedMaterial::<DVec3>::new(&any_material(&mut random));
        for normal in [DVec3::X, -DVec3::Y, DVec3::Z, -DVec3::Z] {
            for incoming in [DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z] {
                if let Some(s) = prepared.scatter(&Meeting::new(normal, incoming), &mut random) {
                    assert!((s.direction.length() - 1.0).abs() < 1e-12 && s.weight.is_finite());
                }
            }
        }
    }
}

#[test]
fn diffuse_reflection_is_cosine_distributed() {
    // χ² with 119 degrees of freedom: 190 is exceeded with probability 4e-5.
    let cells = Cells { rings: 10, sectors: 12 };
    let paint = glossy(PAINT);
    for (incoming, up) in [(-polar(70.0, 20.0), 1.0), (polar(10.0, 0.0), -1.0)] {
        let mut counts = vec![0.0; cells.count()];
        let mut random = Random::new(13, 0, 0);
        for _ in 0..120_000 {
            let s = paint.scatter(&Meeting::new(DVec3::Z, incoming), &mut random).unwrap();
            assert!((s.weight - 0.6).abs() < 1e-15 && !s.transmitted && s.direction.z * up > 0.0);
            counts[cells.find(s.direction)] += 1.0;
        }
        let chi2: f64 = counts.iter().map(|n: &f64| (n - 1000.0).powi(2) / 1000.0).sum();
        assert!(chi2 < 190.0, "χ² = {chi2}");
    }
}

#[test]
fn diffuse_directions_follow_a_tilted_normal() {
    // Mean of cosine-distributed directions: ⅔ of the normal; standard error of each component below 1e-3.
    let mut random = Random::new(14, 0, 0);
    let normal = polar(130.0, 77.0);
    let n = 400_000;
    let mean = (0..n)
        .map(|_| glossy(PAINT).scatter(&Meeting::new(normal, -normal), &mut random).unwrap().direction)
        .sum::<DVec3>()
        / f64::from(n);
    assert!((mean - normal * (2.0 / 3.0)).abs().max_element() < 4e-3, "{mean}");
}

#[test]
fn samples_are_distributed_as_the_evaluated_lobes() {
    let cells = Cells { rings: 12, sectors: 16 };
    let anisotropic = Gloss { orientation: Some(DVec3::new(1.0, 0.5, 0.3)), ..metal([0.4, 0.15]) };
    let mixed = Gloss { color: DVec3::new(0.7, 0.5, 0.2), specular: 0.3, ..metal([0.3; 2]) };
    let streaked = Gloss { roughness: [0.15, 0.35], orientation: Some(DVec3::Y), ..sheet() };
    for gloss in [metal([0.2; 2]), metal([0.5; 2]), anisotropic, mixed, sheet(), streaked] {
        for (theta, normal) in [(0.0, DVec3::Z), (30.0, DVec3::Z), (60.0, -DVec3::Z), (75.0, DVec3::Z)] {
            let incident = polar(theta, 25.0);
            for sign in [1.0, -1.0] {
                let expected =
                    cells.integrate(sign, 40, |exitant| evaluate::<f64>(&gloss, incident, exitant, normal));
                let mut random = Random::new(15, theta as u64, 0);
                let prepared = glossy(gloss);
                let z = cells.compare(
                    &expected,
                    300_000,
                    || prepared.scatter(&Meeting::new(normal, -incident), &mut random),
                    sign < 0.0,
                );
                // 48 comparisons of up to 192 cells: 5.7 is exceeded by one of them with probability 1e-4.
                assert!(z < 5.7, "z = {z} at {theta}°, side {sign}: {gloss:?}");
            }
        }
    }
}

/// Directional albedo of a rough metal by quadrature over the lobe's slopes, on a disk of radius 6 standard widths:
/// there is next to nothing beyond, and no peak is missed at any roughness.
fn albedo(gloss: &Gloss, incident: DVec3) -> f64 {
    let n = 700;
    let cell = 12.0 / n as f64;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let place = [i, j].map(|k| -6.0 + (k as f64 + 0.5) * cell);
            let half =
                DVec3::new(place[0] * gloss.roughness[0], place[1] * gloss.roughness[1], 1.0).normalize();
            let exitant = half * (2.0 * half.dot(incident)) - incident;
            if exitant.z > 0.0 && half.dot(incident) > 0.0 {
                // dω of the exitant for d(slope u) d(slope v): 4 (i·h) h_z³.
                let area =
                    4.0 * incident.dot(half) * half.z.powi(3) * gloss.roughness[0] * gloss.roughness[1];
                sum += evaluate::<f64>(gloss, incident, exitant, DVec3::Z) * exitant.z * area * cell * cell;
            }
        }
    }
    sum
}

#[test]
fn albedo_of_rough_metal_matches_quadrature_and_stays_bounded() {
    for roughness in [[0.05; 2], [0.2; 2], [0.5; 2], [0.1, 0.4]] {
        let gloss = Gloss { orientation: Some(DVec3::X), ..metal(roughness) };
        let prepared = glossy(gloss);
        for theta in [0.0, 30.0, 60.0, 80.0, 88.0] {
            let incident = polar(theta, 40.0);
            let expected = albedo(&gloss, incident);
            assert!(expected <= 1.0 + 1e-6, "{expected} at {theta}° with {roughness:?}");
            let (n, mut random) = (200_000, Random::new(16, theta as u64, 0));
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..n {
                let w = prepared
                    .scatter(&Meeting::new(DVec3::Z, -incident), &mut random)
                    .map_or(0.0, |s| s.weight);
                sum += w;
                squares += w * w;
            }
            let mean = sum / f64::from(n);
            let error = ((squares / f64::from(n) - mean * mean) / f64::from(n)).sqrt();
            assert!((mean - expected).abs() < 4.5 * error + 1e-6, "{mean} {expected} ± {error} {theta}");
        }
    }
}

#[test]
fn rough_transmission_keeps_all_it_is_given() {
    // A spread ray never comes back to the incident side: the albedo is that of the parts.
    let gloss = Gloss { specular: 0.0, transmission: 1.0, transmitted_specular: 1.0, ..sheet() };
    for theta in [0.0, 50.0, 85.0] {
        let mut random = Random::new(17, 0, 0);
        for _ in 0..10_000 {
            let s = glossy(gloss).scatter(&Meeting::new(DVec3::Z, -polar(theta, 0.0)), &mut random).unwrap();
            assert!(s.transmitted && s.direction.z < 0.0);
            assert!((s.weight - gloss.color.luminance()).abs() < 1e-12);
        }
    }
}

#[test]
fn reflection_is_reciprocal() {
    let gloss = Gloss { orientation: Some(DVec3::new(1.0, 2.0, 0.5)), ..metal([0.3, 0.12]) };
    let mut random = Random::new(18, 0, 0);
    for gloss in [gloss, sheet(), PAINT] {
        for _ in 0..2000 {
            let [a, b] = [(); 2].map(|()| direction(&mut random));
            let [a, b] = [a, if a.z * b.z > 0.0 { b } else { -b }];
            let [there, back] = [(a, b), (b, a)].map(|(i, o)| evaluate::<f64>(&gloss, i, o, DVec3::Z));
            assert!((there - back).abs() <= 1e-9 * there, "{there} {back}");
        }
    }
}

#[test]
fn evaluation_has_the_closed_form_at_the_lobes_centre() {
    // Normal incidence, h = 2n: ρ/(π αu αv) · 4/16; diffuse c/π.
    let value = evaluate::<f64>(&metal([0.2, 0.1]), DVec3::Z, DVec3::Z, DVec3::Z);
    assert!((value - 0.25 / (PI * 0.02)).abs() < 1e-12, "{value}");
    let value = evaluate::<f64>(&PAINT, DVec3::Z, polar(50.0, 3.0), -DVec3::Z);
    assert!((value - 0.6 * FRAC_1_PI).abs() < 1e-15);
    assert_eq!(evaluate::<f64>(&PAINT, DVec3::Z, -DVec3::Z, DVec3::Z), 0.0);
}

#[test]
fn lobe_is_wider_along_the_rougher_direction() {
    let u = DVec3::new(1.0, 1.0, 5.0);
    let gloss = Gloss { orientation: Some(u), ..metal([0.2, 0.05]) };
    let prepared = glossy(gloss);
    let along = DVec3::new(1.0, 1.0, 0.0).normalize();
    let across = DVec3::new(-1.0, 1.0, 0.0).normalize();
    for normal in [DVec3::Z, -DVec3::Z] {
        let mut random = Random::new(19, 0, 0);
        let mut spread = [0.0; 2];
        for _ in 0..20_000 {
            let d = prepared.scatter(&Meeting::new(normal, -DVec3::Z), &mut random).unwrap().direction;
            let half = (d + DVec3::Z) / (d.z + 1.0);
            spread = [spread[0] + half.dot(along).powi(2), spread[1] + half.dot(across).powi(2)];
        }
        // The variance of a slope is α²/2; relative standard error 1 %.
        for (sum, alpha) in spread.iter().zip(gloss.roughness) {
            assert!((sum / 20_000.0 / (alpha * alpha / 2.0) - 1.0).abs() < 0.045, "{spread:?}");
        }
    }
}

#[test]
fn orientation_along_the_normal_falls_back_to_the_mean_square() {
    let lost = Gloss { orientation: Some(2.0 * DVec3::Z), ..metal([0.1, 0.3]) };
    let mean = metal([(0.05_f64).sqrt(); 2]);
    let exitant = polar(20.0, 33.0);
    let [a, b] = [lost, mean].map(|g| evaluate::<f64>(&g, polar(10.0, 0.0), exitant, DVec3::Z));
    assert!((a - b).abs() < 1e-12 * b);
}

#[test]
fn grey_path_carries_the_luminance_of_the_coloured_one() {
    let mut parameters = Random::new(20, 0, 0);
    for case in 0..500 {
        let material = any_material(&mut parameters);
        let (normal, incoming) = (direction(&mut parameters), direction(&mut parameters));
        let grey = PreparedMaterial::<f64>::new(&material);
        let color = PreparedMaterial::<DVec3>::new(&material);
        for sample in 0..20 {
            let [mut a, mut b] = [(); 2].map(|()| Random::new(21, case, sample));
            match (
                grey.scatter(&Meeting::new(normal, incoming), &mut a),
                color.scatter(&Meeting::new(normal, incoming), &mut b),
            ) {
                (None, None) => {}
                (Some(g), Some(c)) => {
                    assert_eq!((g.direction, g.transmitted), (c.direction, c.transmitted));
                    assert!((g.weight - c.weight.luminance()).abs() < 1e-12, "{material:?}");
                }
                other => panic!("{other:?} of {material:?}"),
            }
        }
    }
}

/// Mean weight (RGB) of the samples that `keep` holds for, with its standard error.
fn mean_weight(material: Material, incoming: DVec3, keep: impl Fn(&Scatter<DVec3>) -> bool) -> [DVec3; 2] {
    let prepared = PreparedMaterial::<DVec3>::new(&material);
    let (n, mut random) = (200_000, Random::new(22, 0, 0));
    let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
    for _ in 0..n {
        if let Some(s) = prepared.scatter(&Meeting::new(DVec3::Z, incoming), &mut random).filter(&keep) {
            sum += s.weight;
            squares += s.weight * s.weight;
        }
    }
    let mean = sum / f64::from(n);
    [mean, ((squares / f64::from(n) - mean * mean).max(DVec3::ZERO) / f64::from(n)).map(f64::sqrt)]
}

fn assert_mean([mean, error]: [DVec3; 2], expected: DVec3) {
    let excess = (mean - expected).abs() - 4.5 * error;
    assert!(excess.max_element() < 1e-9, "{mean} ± {error}, expected {expected}");
}

#[test]
fn smooth_surfaces_mirror_with_the_fresnel_approximation() {
    let color = DVec3::new(0.8, 0.5, 0.3);
    for (kind, specular) in [(GlossKind::Plastic, 0.05), (GlossKind::Metal, 0.7), (GlossKind::Plastic, 0.01)]
    {
        for theta in [0.0, 45.0, 80.0, 89.0] {
            let gloss = Gloss { kind, color, specular, ..PAINT };
            let cosine = f64::to_radians(theta).cos();
            let f = if specular > 0.018 { (-5.85 * cosine).exp() - 0.00202943064 } else { 0.0 };
            let highlight = if kind == GlossKind::Metal { color } else { DVec3::ONE };
            let incoming = -polar(theta, 0.0);
            let image = incoming.with_z(-incoming.z);
            let mirrored = |s: &Scatter<DVec3>| (s.direction - image).length() < 1e-12;
            assert_mean(
                mean_weight(Material::Gloss(gloss), incoming, mirrored),
                highlight * specular * (1.0 - f) + f,
            );
            assert_mean(
                mean_weight(Material::Gloss(gloss), incoming, |s| !mirrored(s)),
                color * (1.0 - specular) * (1.0 - f),
            );
        }
    }
}

#[test]
fn smooth_sheet_splits_light_as_the_manual_says() {
    let gloss = Gloss { roughness: [0.0; 2], specular: 0.0, ..sheet() };
    for incoming in [-polar(40.0, 10.0), polar(40.0, 10.0)] {
        let straight = |s: &Scatter<DVec3>| s.transmitted && s.direction == incoming;
        let material = Material::Gloss(gloss);
        let [t, ts] = [gloss.transmission, gloss.transmitted_specular];
        assert_mean(mean_weight(material.clone(), incoming, straight), gloss.color * t * ts);
        assert_mean(
            mean_weight(material.clone(), incoming, |s| s.transmitted && !straight(s)),
            gloss.color * t * (1.0 - ts),
        );
        assert_mean(mean_weight(material, incoming, |s| !s.transmitted), gloss.color * (1.0 - t));
    }
}

#[test]
fn pane_splits_light_by_its_reflectance_and_transmittance() {
    let transmissivity = DVec3::new(0.9, 0.6, 0.3);
    for theta in [0.0, 30.0, 60.0, 80.0] {
        let incoming = polar(theta, 70.0);
        let [reflectance, transmittance] =
            glass::Pane::new(transmissivity, 1.52).reflectance_transmittance(incoming.z);
        let material = Material::Glass { transmissivity, index: 1.52 };
        assert_mean(
            mean_weight(material.clone(), incoming, |s| s.transmitted && s.direction == incoming),
            transmittance,
        );
        let image = incoming.with_z(-incoming.z);
        assert_mean(
            mean_weight(material, incoming, |s| !s.transmitted && (s.direction - image).length() < 1e-12),
            reflectance,
        );
    }
}

#[test]
fn mirrors_void_and_black_do_what_their_names_say() {
    let mut random = Random::new(23, 0, 0);
    let incoming = -polar(30.0, 0.0);
    let mirror = PreparedMaterial::<f64>::new(&Material::Mirror { reflectance: DVec3::splat(0.5) });
    let front = mirror.scatter(&Meeting::new(DVec3::Z, incoming), &mut random).unwrap();
    assert!((front.direction - polar(30.0, 180.0)).length() < 1e-15 && (front.weight - 0.5).abs() < 1e-15);
    assert_eq!(mirror.scatter(&Meeting::new(-DVec3::Z, incoming), &mut random), None);
    let void =
        PreparedMaterial::<f64>::new(&Material::Void).scatter(&Meeting::new(DVec3::Z, incoming), &mut random);
    assert_eq!(void, Some(Scatter { direction: incoming, weight: 1.0, transmitted: true }));
    assert_eq!(
        PreparedMaterial::<f64>::new(&Material::Black)
            .scatter(&Meeting::new(DVec3::Z, incoming), &mut random),
        None
    );
    let paint = Gloss { color: DVec3::ZERO, ..PAINT };
    assert_eq!(glossy(paint).scatter(&Meeting::new(DVec3::Z, incoming), &mut random), None);
}

#[test]
fn media_are_told_by_the_side_of_the_surface() {
    let inside = Medium { transmittance: DVec3::new(0.1, 0.2, 0.3), index: 1.5 };
    let block = PreparedMaterial::<f64>::new(&Material::Dielectric { inside, outside: Medium::VACUUM });
    assert_eq!([true, false].map(|f| block.medium_plain(f)), [Some(DVec3::ONE), Some(inside.transmittance)]);
    assert_eq!(glossy(PAINT).medium_plain(true), None);
}

#[test]
fn only_materials_without_colour_are_neutral() {
    assert!(is_neutral(&Material::Gloss(PAINT)) && !is_neutral(&Material::Gloss(sheet())));
    let tinted = Medium { transmittance: DVec3::new(1.0, 1.0, 0.9), index: 1.5 };
    assert!(!is_neutral(&Material::Dielectric { inside: tinted, outside: Medium::VACUUM }));
    assert!(is_neutral(&Material::Glass { transmissivity: DVec3::splat(0.9), index: 1.52 }));
}
