//! Samples against exact expected counts, densities and totals against sums over cells.

mod common;

use std::f64::consts::PI;
use std::sync::Arc;

use bsdftree::square::{disk_from_square, square_from_disk};
use bsdftree::{Band, Basis, Component, Direction, Lobes, Matrix, Part, Rank, Scattering, Side};
use common::{Random, fits, random_tree};

const N_SAMPLES: usize = 40_000;
/// The finest cells of the test trees.
const BINS: usize = 16;

fn bin([x, y, _]: Direction) -> usize {
    let [p, q] = square_from_disk([x, y]).map(|c| ((c * BINS as f64) as usize).min(BINS - 1));
    p * BINS + q
}

fn band(part: Part, scattering: Scattering) -> Band {
    let mut band = Band::new("Visible");
    band.insert(part, Component::grey(scattering));
    band
}

fn random_matrix(random: &mut Random) -> Matrix {
    let (incident, exitant) = (Arc::new(Basis::quarter()), Arc::new(Basis::half()));
    let n = incident.n_patches() * exitant.n_patches();
    let values = (0..n).map(|_| (random.unit() - 0.2).max(0.0).powi(4) as f32).collect();
    Matrix::new(incident, exitant, values).unwrap()
}

/// Counts samples over a grid of the exitant square; each must carry the density and weight of its direction.
fn counts(band: &Band, incident: Direction, two_numbers: bool, random: &mut Random) -> Vec<u64> {
    let mut counts = vec![0; BINS * BINS];
    for k in 0..N_SAMPLES {
        let u = (k as f64 + random.unit()) / N_SAMPLES as f64;
        let (u, v) = if two_numbers { (random.unit(), Some(random.unit())) } else { (u, None) };
        let sample = band.sample(incident, u, v, Lobes::All);
        let d = sample.exitant;
        assert!((d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1.0).abs() < 1e-12, "{d:?} is not a unit vector");
        let pdf = band.pdf(incident, d, Lobes::All);
        assert!(
            (sample.pdf - pdf).abs() <= 1e-9 * pdf,
            "sampled with density {}, pdf says {pdf}",
            sample.pdf
        );
        let weight = band.eval(incident, d) * d[2].abs() / pdf;
        assert!((sample.weight - weight).abs() <= 1e-9 * weight);
        counts[bin(d)] += 1;
    }
    counts
}

/// Expected counts by fine midpoint sums of the BSDF over each bin: exact for trees, whose finest cells are the bins.
fn expected(band: &Band, incident: Direction, side: Side, refine: usize) -> Vec<f64> {
    let n = BINS * refine;
    let mut sums = vec![0.0; BINS * BINS];
    for i in 0..n {
        for j in 0..n {
            let center = [i, j].map(|k| (k as f64 + 0.5) / n as f64);
            let exitant = side.direction_from_disk(disk_from_square(center));
            sums[(i / refine) * BINS + j / refine] += band.eval(incident, exitant) * PI / (n * n) as f64;
        }
    }
    sums
}

#[test]
fn tree_samples_follow_their_exact_expected_counts() {
    let mut random = Random(1);
    for rank in [Rank::Four, Rank::Three] {
        for part in [Part::ReflectionBack, Part::TransmissionBack] {
            for (is_smooth, two_numbers) in [(false, false), (false, true), (true, false), (true, true)] {
                let tree = random_tree(rank, 4, &mut random);
                let band = band(part, if is_smooth { tree.smooth() } else { tree }.into());
                let incident = random.direction();
                // Rank 3 turns its cells with the incident azimuth: compare in the plane where they are not turned.
                let incident = if rank == Rank::Three {
                    [-incident[0].hypot(incident[1]), 0.0, incident[2]]
                } else {
                    incident
                };
                let sums = expected(&band, incident, part.exitant_side(), 1);
                let total: f64 = sums.iter().sum();
                assert!((total - band.hemispherical(incident, Lobes::All)).abs() < 1e-12 * total);
                let scaled: Vec<_> = sums.iter().map(|s| s / total * N_SAMPLES as f64).collect();
                fits(&counts(&band, incident, two_numbers, &mut random), &scaled).unwrap();
            }
        }
    }
}

#[test]
fn reversed_samples_follow_the_reversed_function() {
    let mut random = Random(2);
    let trees = [Rank::Four, Rank::Three].map(|rank| random_tree(rank, 4, &mut random));
    let smooth = trees.clone().map(|tree| Scattering::from(tree.smooth()));
    let matrix = Scattering::from(random_matrix(&mut random));
    for scattering in trees.map(Scattering::from).into_iter().chain(smooth).chain([matrix]) {
        let exact = matches!(&scattering, Scattering::Tree(t) if t.rank() == Rank::Four);
        // Light from the front, where only the component for light from the back is there.
        let band = band(Part::TransmissionFront, scattering);
        for _ in 0..4 {
            let incident = random.direction();
            let sums = expected(&band, incident, Side::Back, if exact { 1 } else { 32 });
            let total: f64 = sums.iter().sum();
            let hemispherical = band.hemispherical(incident, Lobes::All);
            assert!(
                (total - hemispherical).abs() < if exact { 1e-12 } else { 3e-3 } * total,
                "{total} {hemispherical}"
            );
            // A patch may enter a bin by less than the midpoints of the sum see.
            let floor = if exact { 0.0 } else { 0.05 };
            let scaled: Vec<_> = sums.iter().map(|s| (s / total * N_SAMPLES as f64).max(floor)).collect();
            fits(&counts(&band, incident, false, &mut random), &scaled).unwrap();
        }
    }
}

#[test]
fn matrix_samples_fill_patches_by_their_share() {
    let mut random = Random(3);
    let matrix = random_matrix(&mut random);
    let basis = Arc::clone(matrix.exitant());
    let band = band(Part::ReflectionBack, matrix.into());
    let incident = random.direction();
    let mut counts = vec![0; basis.n_patches()];
    for k in 0..N_SAMPLES {
        let u = (k as f64 + random.unit()) / N_SAMPLES as f64;
        let sample = band.sample(incident, u, None, Lobes::All);
        assert!((sample.pdf - band.pdf(incident, sample.exitant, Lobes::All)).abs() < 1e-9 * sample.pdf);
        counts[basis.patch(sample.exitant)] += 1;
    }
    let total = band.hemispherical(incident, Lobes::All);
    let share = |k: usize| {
        let exitant = Side::Front.direction_from_disk(basis.disk_point(k, 0.5, 0.5));
        band.eval(incident, exitant) * basis.projected_solid_angle(k) / total * N_SAMPLES as f64
    };
    fits(&counts, &(0..counts.len()).map(share).collect::<Vec<_>>()).unwrap();
}

#[test]
fn density_integrates_to_one_over_both_hemispheres() {
    let mut random = Random(4);
    let mut band = Band::new("Visible");
    band.insert(Part::ReflectionBack, Component::grey(random_tree(Rank::Four, 4, &mut random).into()));
    let smooth = random_tree(Rank::Four, 4, &mut random).smooth();
    band.insert(Part::TransmissionBack, Component::grey(smooth.into()));
    for _ in 0..20 {
        let incident = random.direction();
        let mut integral = 0.0;
        for side in [Side::Front, Side::Back] {
            for i in 0..BINS {
                for j in 0..BINS {
                    let center = [i, j].map(|k| (k as f64 + 0.5) / BINS as f64);
                    let d = side.direction_from_disk(disk_from_square(center));
                    // dΩ = dΩ_projected / |cos θ|
                    integral += band.pdf(incident, d, Lobes::All) / d[2].abs() * PI / (BINS * BINS) as f64;
                }
            }
        }
        assert!((integral - 1.0).abs() < 1e-12, "{integral}");
        let both = band.hemispherical(incident, Lobes::Reflection)
            + band.hemispherical(incident, Lobes::Transmission);
        assert!((both - band.hemispherical(incident, Lobes::All)).abs() < 1e-12);
    }
}

#[test]
fn reversed_rank4_tree_is_the_function_with_directions_swapped() {
    let mut random = Random(5);
    let band = band(Part::TransmissionFront, random_tree(Rank::Four, 4, &mut random).into());
    for _ in 0..1000 {
        let (a, b) = (random.direction(), random.direction());
        let below = [b[0], b[1], -b[2]];
        assert_eq!(band.eval(a, below), band.eval(below, a));
        let pdf = band.eval(a, below) * below[2].abs() / band.hemispherical(a, Lobes::All);
        assert!((band.pdf(a, below, Lobes::All) - pdf).abs() <= 1e-12 * pdf);
    }
}

#[test]
fn normal_incidence_lies_in_the_upper_cell_whatever_its_last_bits() {
    let mut random = Random(6);
    let band = band(Part::ReflectionBack, random_tree(Rank::Four, 3, &mut random).into());
    for _ in 0..100 {
        let exitant = random.direction();
        let value = band.eval([0.0, 0.0, 1.0], exitant);
        for noise in [1e-17, -1e-17, 6e-14, -6e-14] {
            assert_eq!(band.eval([noise, -noise, 1.0], exitant), value);
            assert_eq!(band.eval([-noise, -0.0, 1.0], exitant), value);
        }
        // The upper cell of −incident: an incident direction that leans towards −X, −Y.
        assert_eq!(band.eval([-1e-6, -1e-6, 1.0], exitant), value);
    }
}

#[test]
fn black_directions_have_no_density_and_no_weight() {
    let band = band(Part::ReflectionBack, bsdftree::Tree::uniform(Rank::Four, 0.0).into());
    for incident in [[0.0, 0.6, 0.8], [0.0, 0.6, -0.8]] {
        let sample = band.sample(incident, 0.5, None, Lobes::All);
        assert_eq!((sample.pdf, sample.weight), (0.0, 0.0));
        assert_eq!(band.pdf(incident, [0.0, 0.0, 1.0], Lobes::All), 0.0);
    }
}

#[test]
fn stratified_numbers_give_more_even_directions_than_random_ones() {
    let mut random = Random(9);
    let band = band(Part::ReflectionBack, random_tree(Rank::Four, 5, &mut random).into());
    let incident = random.direction();
    let caps: Vec<_> = (0..100).map(|_| (random.direction(), 0.5 + 0.4 * random.unit())).collect();
    let mut shares = |n: usize, stratified: bool| {
        let mut shares = vec![0.0; caps.len()];
        for k in 0..n {
            let u = if stratified { (k as f64 + random.unit()) / n as f64 } else { random.unit() };
            let [x, y, z] = band.sample(incident, u, None, Lobes::All).exitant;
            for (share, ([a, b, c], cos)) in shares.iter_mut().zip(&caps) {
                *share += if x * a + y * b + z * c > *cos { 1.0 / n as f64 } else { 0.0 };
            }
        }
        shares
    };
    let exact = shares(1 << 18, true);
    let mut error = |stratified: bool| -> f64 {
        (0..20)
            .map(|_| shares(4096, stratified).iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum::<f64>())
            .sum()
    };
    let (of_random, of_strata) = (error(false).sqrt(), error(true).sqrt());
    assert!(of_random > 3.0 * of_strata, "{of_random} {of_strata}");
}

#[test]
fn threads_see_the_same_samples() {
    let mut random = Random(7);
    let mut band = band(Part::TransmissionFront, random_tree(Rank::Three, 5, &mut random).into());
    let smooth = random_tree(Rank::Four, 5, &mut random).smooth();
    band.insert(Part::ReflectionBack, Component::grey(smooth.into()));
    let run = || {
        let mut random = Random(8);
        (0..3000)
            .map(|_| band.sample(random.direction(), random.unit(), None, Lobes::All))
            .collect::<Vec<_>>()
    };
    let alone = run();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(run)).collect();
        threads.into_iter().for_each(|t| assert!(t.join().unwrap() == alone));
    });
}
