//! Closed forms: BSDFs made of known peaks, lobes and noise.

use std::f64::consts::PI;
use std::sync::Arc;

use super::*;
use crate::bsdf::Component;
use crate::klems::{Basis, Matrix};
use crate::square::{disk_from_square, square_from_disk};
use crate::tree::Tree;

/// Points of an incident cell along each axis.
const SUB: usize = 8;

fn families_of(part: Part, scattering: Scattering) -> Vec<PeakFamily> {
    let mut band = Band::new("Visible");
    band.insert(part, Component::grey(scattering));
    peaks(&band, PeakOptions::default())
}

/// A rank-4 tree of light that leaves, by fraction, in given directions; from even points of each incident cell; over
/// a floor \[1/sr\].
fn rays(part: Part, log2: u32, floor: f64, exits: impl Fn(Direction) -> Vec<(Direction, f64)>) -> Scattering {
    let n = 1usize << log2;
    let mut values = vec![floor; n * n * n * n];
    let point = |k: usize| (k as f64 + 0.5) / (n * SUB) as f64;
    let cell = |x: f64| ((x * n as f64) as usize).min(n - 1);
    let share = 1.0 / (SUB * SUB) as f64 / (PI / (n * n) as f64);
    for a in 0..n * SUB {
        for b in 0..n * SUB {
            let incident =
                back(Side::Front.direction_from_disk(disk_from_square([point(a), point(b)])), part);
            for (exitant, fraction) in exits(incident) {
                let [p, q] = square_from_disk([exitant[0], exitant[1]]).map(cell);
                values[((a / SUB * n + b / SUB) * n + p) * n + q] += share * fraction;
            }
        }
    }
    let values: Vec<f32> = values.into_iter().map(|v| v as f32).collect();
    Tree::from_grid(Rank::Four, &values).unwrap().into()
}

/// A Klems Full matrix of a function of incident and exitant direction, both in the middle of their patches.
fn patches(part: Part, f: impl Fn(Direction, Direction, bool, f64) -> f64) -> Scattering {
    let basis = Arc::new(Basis::full());
    let middle = |k: usize| Side::Front.direction_from_disk(basis.disk_point(k, 0.5, 0.5));
    let n = basis.n_patches();
    let values = (0..n * n).map(|k| {
        let (i, o) = (k / n, k % n);
        let exitant = on_side(middle(o), part.exitant_side());
        f(back(middle(i), part), exitant, i == o, basis.projected_solid_angle(o)) as f32
    });
    Matrix::new(Arc::clone(&basis), Arc::clone(&basis), values.collect()).unwrap().into()
}

fn angle_deg(a: Direction, b: Direction) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum::<f64>().clamp(-1.0, 1.0).acos().to_degrees()
}

/// Transmittance of a pane of index 1.5 without absorption, unpolarised, all reflections inside.
fn pane(cos: f64) -> f64 {
    let inside = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
    let s = ((cos - 1.5 * inside) / (cos + 1.5 * inside)).powi(2);
    let p = ((1.5 * cos - inside) / (1.5 * cos + inside)).powi(2);
    0.5 * ((1.0 - s) / (1.0 + s) + (1.0 - p) / (1.0 + p))
}

#[test]
fn a_mirror_of_80_percent_is_found_in_trees_of_both_ranks_and_matrices() {
    let rank4 = rays(Part::ReflectionBack, 3, 0.0, |[x, y, z]| vec![([-x, -y, z], 0.8)]);
    // The two cells beside (1 − d0, ½) share the light.
    let cell = PI / 256.0;
    let rank3: Vec<f32> = (0..4096)
        .map(|k| {
            let [a, p, q] = [k >> 8, k >> 4 & 15, k & 15];
            if a < 8 && p == 15 - a && (q == 7 || q == 8) { (0.4 / cell) as f32 } else { 0.0 }
        })
        .collect();
    let klems = patches(Part::ReflectionBack, |_, _, same, area| if same { 0.8 / area } else { 0.0 });
    for (scattering, n) in
        [(rank4, 64), (Tree::from_grid(Rank::Three, &rank3).unwrap().into(), 8), (klems, 145)]
    {
        let found = families_of(Part::ReflectionBack, scattering);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((found[0].map, found[0].peaks.len(), found[0].n_directions), (Map::Mirror, n, n));
        assert!(found[0].residual_deg < 1.1, "{}", found[0].residual_deg);
        for peak in &found[0].peaks {
            assert!((peak.strength - 0.8).abs() < 1e-6 && peak.surround == 0.0 && peak.resolution_limited);
        }
    }
}

#[test]
fn a_pane_has_fresnels_transmittance_at_every_angle() {
    let scattering = rays(Part::TransmissionFront, 4, 0.0, |i| vec![(i.map(|c| -c), pane(i[2].abs()))]);
    let found = families_of(Part::TransmissionFront, scattering);
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].map, found[0].peaks.len()), (Map::Straight, 256));
    for peak in &found[0].peaks {
        // Between the values at the corners of the incident cell.
        let [x, y] = square_from_disk([-peak.incident[0], -peak.incident[1]]);
        let corner = |c: f64, k: usize| ((c * 16.0).floor() + k as f64) / 16.0;
        let at = |k: usize| {
            let disk = disk_from_square([corner(x, k & 1), corner(y, k >> 1)]);
            pane(Side::Front.direction_from_disk(disk)[2])
        };
        let (low, high) = (0..4).map(at).fold((1.0f64, 0.0f64), |(lo, hi), t| (lo.min(t), hi.max(t)));
        assert!((low..=high).contains(&peak.strength), "{low} {} {high}", peak.strength);
    }
}

#[test]
fn the_normal_of_a_tilted_mirror_is_found_within_half_a_degree() {
    for (tilt, azimuth) in [(10.0f64, 90.0f64), (20.0, 33.0), (35.0, 200.0)] {
        let (tilt, azimuth) = (tilt.to_radians(), azimuth.to_radians());
        let normal = [tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos()];
        let map = Map::Facet { normal };
        let tilted = |i| map.exitant(i, Side::Front).map(|o| (o, 0.7)).into_iter().collect();
        let found = families_of(Part::ReflectionBack, rays(Part::ReflectionBack, 4, 0.02, tilted));
        for f in &found {
            eprintln!(
                "{:?} {} {:?}",
                f.map,
                f.peaks.len(),
                f.peaks.iter().map(|p| (p.incident, p.exitant, p.strength)).take(12).collect::<Vec<_>>()
            );
        }
        let Map::Facet { normal: fitted } = found[0].map else { panic!("{:?}", found[0].map) };
        assert!(angle_deg(normal, fitted) < 0.5, "{}", angle_deg(normal, fitted));
        // Where all of an incident cell is mirrored to the front.
        let whole = found[0].peaks.iter().filter(|p| p.exitant[2] > 0.5 && p.incident[2] > 0.5);
        assert!(whole.clone().count() > 30);
        whole.for_each(|p| assert!((p.strength - 0.7).abs() < 0.07, "{p:?}"));
    }
}

#[test]
fn the_facets_of_a_prism_are_found_and_their_index() {
    let tilt = 25.0f64.to_radians();
    for flat_first in [true, false] {
        let map = Map::Prism { normal: [0.0, tilt.sin(), tilt.cos()], index: 1.49, flat_first };
        let exits = |i| map.exitant(i, Side::Front).map(|o| (o, 0.6)).into_iter().collect();
        let found = families_of(Part::TransmissionFront, rays(Part::TransmissionFront, 5, 0.0, exits));
        let Map::Prism { normal, index, flat_first: first } = found[0].map else {
            panic!("{:?}", found[0].map)
        };
        assert_eq!(first, flat_first);
        assert!(
            (index - 1.49).abs() < 0.05 && angle_deg(normal, [0.0, tilt.sin(), tilt.cos()]) < 4.0,
            "{:?}",
            found[0]
        );
        assert!(found[0].residual_deg < 1.5, "{}", found[0].residual_deg);
        assert!(found[0].peaks.len() * 10 > 8 * found.iter().map(|f| f.peaks.len()).sum::<usize>());
    }
}

#[test]
fn right_angled_grooves_send_light_back_across_them() {
    let exits = |[x, y, z]: Direction| vec![([-x, y, z], 0.5)];
    let found = families_of(Part::ReflectionFront, rays(Part::ReflectionFront, 4, 0.0, exits));
    assert_eq!(found.len(), 1);
    let Map::Groove { axis } = found[0].map else { panic!("{:?}", found[0].map) };
    assert!(axis[0].abs() > 1.0 - 1e-9 && found[0].peaks.len() == 256 && found[0].residual_deg < 1e-6);
}

#[test]
fn several_peaks_at_once_are_told_apart() {
    // Straight through, two orders of a grating, and diffuse light.
    let exits = |[x, y, z]: Direction| {
        let order = |shift: f64| {
            let disk = [shift - x, -y];
            (disk[0].hypot(disk[1]) < 1.0).then(|| (Side::Front.direction_from_disk(disk), 0.1))
        };
        [Some(([-x, -y, -z], 0.3)), order(0.5), order(-0.5)].into_iter().flatten().collect()
    };
    let found = families_of(Part::TransmissionFront, rays(Part::TransmissionFront, 5, 0.1, exits));
    assert_eq!(found.len(), 3, "{:?}", found.iter().map(|f| f.map).collect::<Vec<_>>());
    assert_eq!(found[0].map, Map::Straight);
    assert!((found[0].mean_strength() - 0.3).abs() < 0.002, "{}", found[0].mean_strength());
    let mut shifts: Vec<f64> = found[1..]
        .iter()
        .map(|family| match family.map {
            Map::Shift { cosines: [x, y] } if y.abs() < 0.01 => x,
            other => panic!("{other:?}"),
        })
        .collect();
    shifts.sort_by(f64::total_cmp);
    assert!((shifts[0] + 0.5).abs() < 0.01 && (shifts[1] - 0.5).abs() < 0.01, "{shifts:?}");
}

#[test]
fn diffuse_light_below_a_peak_is_not_counted_to_it() {
    let strength = |floor| {
        let scattering = rays(Part::TransmissionFront, 4, floor, |i| vec![(i.map(|c| -c), 0.25)]);
        let found = families_of(Part::TransmissionFront, scattering);
        assert_eq!(found.len(), 1);
        found[0].mean_strength()
    };
    assert!((strength(0.0) - 0.25).abs() < 1e-6);
    assert!((strength(0.2) - 0.25).abs() < 1e-6);
}

#[test]
fn a_lambertian_surface_has_no_peaks() {
    let klems = patches(Part::ReflectionBack, |_, _, _, _| 0.8 / PI);
    for scattering in [Tree::uniform(Rank::Three, 0.2).into(), Tree::uniform(Rank::Four, 0.2).into(), klems] {
        assert!(families_of(Part::ReflectionBack, scattering).is_empty());
    }
}

#[test]
fn a_lobe_of_20_degrees_has_no_peaks() {
    // exp(−α²/2σ²) about the mirrored direction, 20° wide at half its height, holding 60 %.
    let sigma = 20.0 / (8.0 * 2.0f64.ln()).sqrt();
    let height = 0.6 / (2.0 * PI * sigma.to_radians().powi(2));
    let lobe = |[x, y, z]: Direction, o: Direction| {
        0.02 + height * (-0.5 * (angle_deg([-x, -y, z], o) / sigma).powi(2)).exp()
    };
    for log2 in [4u32, 5] {
        let n = 1usize << log2;
        let middle = |k: usize| (k as f64 + 0.5) / n as f64;
        let direction = |a, b| Side::Front.direction_from_disk(disk_from_square([middle(a), middle(b)]));
        let values: Vec<f32> = (0..n.pow(4))
            .map(|k| {
                let axis = |j: u32| k >> (j * log2) & (n - 1);
                lobe(back(direction(axis(3), axis(2)), Part::ReflectionBack), direction(axis(1), axis(0)))
                    as f32
            })
            .collect();
        let found = families_of(Part::ReflectionBack, Tree::from_grid(Rank::Four, &values).unwrap().into());
        assert!(found.is_empty(), "2^{log2}: {:?}", found.iter().map(|f| f.map).collect::<Vec<_>>());
    }
    assert!(
        families_of(Part::ReflectionBack, patches(Part::ReflectionBack, |i, o, _, _| lobe(i, o))).is_empty()
    );
}

#[test]
fn counting_noise_has_no_peaks() {
    // A diffuser of 50 %, few rays counted: Poisson numbers of mean 2 (or ¼) in every cell, by inversion.
    let mut state = 7u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    for mean in [2.0f64, 0.25] {
        let mut poisson = || {
            let (u, mut k, mut term) = (uniform(), 0u32, (-mean).exp());
            let mut sum = term;
            while u > sum && k < 60 {
                k += 1;
                term *= mean / f64::from(k);
                sum += term;
            }
            f64::from(k)
        };
        let values: Vec<f32> = (0..1 << 20).map(|_| (0.5 / PI * poisson() / mean) as f32).collect();
        let found = families_of(Part::ReflectionBack, Tree::from_grid(Rank::Four, &values).unwrap().into());
        assert!(
            found.is_empty(),
            "{mean}: {:?}",
            found.iter().map(|f| (f.map, f.peaks.len())).collect::<Vec<_>>()
        );
    }
}

#[test]
fn a_prism_turns_normal_light_by_snells_law() {
    let tilt = 20.0f64.to_radians();
    let normal = [tilt.sin(), 0.0, tilt.cos()];
    let turned = (1.5 * tilt.sin()).asin() - tilt;
    let out =
        Map::Prism { normal, index: 1.5, flat_first: true }.exitant([0.0, 0.0, -1.0], Side::Front).unwrap();
    // Away from the facet's normal: towards −x.
    assert!((out[0] + turned.sin()).abs() < 1e-12 && (out[2] - turned.cos()).abs() < 1e-12, "{out:?}");
    // The way back.
    let path = Map::Prism { normal, index: 1.5, flat_first: false }.exitant(out, Side::Back).unwrap();
    assert!((path[0]).abs() < 1e-12 && (path[2] + 1.0).abs() < 1e-12, "{path:?}");
    // Total reflection beyond asin(1/1.5) = 41.8°.
    let steep = Map::Prism { normal: [0.7, 0.0, 0.51f64.sqrt()], index: 1.5, flat_first: true };
    assert_eq!(steep.exitant([0.0, 0.0, -1.0], Side::Front), None);
}

#[test]
fn an_empty_band_has_no_peaks() {
    assert!(peaks(&Band::new("Visible"), PeakOptions::default()).is_empty());
}
