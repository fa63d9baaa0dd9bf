//! Conversions between trees and matrices: means that are exact, totals that are kept, on closed forms and real files.

use std::sync::Arc;

use bsdftree::convert::{TreeOptions, relative_l1};
use bsdftree::xml::{Strictness, read_file};
use bsdftree::{Basis, Bsdf, Component, Direction, Lobes, Matrix, Part, Rank, Scattering, Side, Tree};
use bsdftree_testing::{READABLE, real_file};

fn bases() -> Vec<Basis> {
    let full = Basis::full();
    vec![Basis::quarter(), Basis::half(), Basis::half_73(), full.subdivided(2).unwrap(), full]
}

fn single(part: Part, function: impl Into<Scattering>) -> Bsdf {
    let mut bsdf = Bsdf::default();
    bsdf.band_mut("Visible").insert(part, Component::grey(function.into()));
    bsdf
}

fn luminance(bsdf: &Bsdf, part: Part) -> &Scattering {
    &bsdf.bands[0].component(part).expect("it is there").luminance
}

fn matrix_of(function: &Scattering) -> &Matrix {
    match function {
        Scattering::Matrix(matrix) => matrix,
        Scattering::Tree(_) => panic!("a matrix"),
    }
}

/// ∫∫ f over incident and exitant projected solid angle, by π².
fn light(function: &Scattering) -> f64 {
    match function {
        Scattering::Tree(tree) => {
            let volume = |level: u32| 0.5f64.powi(level as i32 * tree.rank().dimensions() as i32);
            match tree.rank() {
                Rank::Four => tree.leaves().map(|l| f64::from(l.value) * volume(l.level)).sum(),
                Rank::Three => {
                    let ring = |l: &bsdftree::tree::Leaf| {
                        let edge = 0.5f64.powi(l.level as i32);
                        let d0 = f64::from(l.cell[0]) * edge;
                        let r = |d: f64| (1.0 - 2.0 * d).max(0.0).powi(2);
                        (r(d0) - r(d0 + edge)) * edge * edge
                    };
                    tree.leaves().map(|l| f64::from(l.value) * ring(&l)).sum()
                }
            }
        }
        Scattering::Matrix(matrix) => {
            let area = |b: &Basis, k| b.projected_solid_angle(k) / std::f64::consts::PI;
            let n = matrix.exitant().n_patches();
            let values = matrix.values().iter().enumerate();
            values
                .map(|(k, &v)| f64::from(v) * area(matrix.incident(), k / n) * area(matrix.exitant(), k % n))
                .sum()
        }
    }
}

fn options(rank: Rank, log2_res: u32) -> TreeOptions {
    TreeOptions { rank, log2_res, tolerance: 0.0 }
}

#[test]
fn a_uniform_tree_is_a_uniform_matrix() {
    for basis in bases() {
        let basis = Arc::new(basis);
        let bsdf = single(Part::ReflectionBack, Tree::uniform(Rank::Four, 0.25)).to_klems(&basis).unwrap();
        let values = matrix_of(luminance(&bsdf, Part::ReflectionBack)).values();
        assert!(values.iter().all(|v| (v - 0.25).abs() < 1e-6), "{}", basis.name());
    }
}

#[test]
fn a_matrix_value_is_the_mean_over_both_patches() {
    // f = 0.1 + 0.2·x_out² − 0.05·x_in on a fine tree; its means over patches by many points.
    let log2_res = 4;
    let n = 1usize << log2_res;
    let centre = |k: usize| {
        bsdftree::square::disk_from_square([(k / n) as f64, (k % n) as f64].map(|c| (c + 0.5) / n as f64))
    };
    let values: Vec<f32> = (0..n.pow(4))
        .map(|k| (0.1 + 0.2 * centre(k % (n * n))[0].powi(2) - 0.05 * centre(k / (n * n))[0]) as f32)
        .collect();
    let tree = Scattering::from(Tree::from_grid(Rank::Four, &values).unwrap());
    let basis = Arc::new(Basis::quarter());
    let bsdf = single(
        Part::ReflectionBack,
        match &tree {
            Scattering::Tree(t) => Tree::clone(t),
            _ => unreachable!(),
        },
    );
    let converted = bsdf.to_klems(&basis).unwrap();
    let matrix = matrix_of(luminance(&converted, Part::ReflectionBack));
    for (i, o) in [(0, 0), (3, 17), (40, 33), (12, 12)] {
        let mut sum = 0.0;
        let n_points = 1u32 << 18;
        for k in 0..n_points {
            let at = |step: f64| (0.5 + f64::from(k) * step).fract();
            let to = basis.disk_point(o, at(0.856_674_883_854_502_9), at(0.733_891_856_627_125_7));
            let from = basis.disk_point(i, at(0.628_706_721_037_808_8), at(0.538_597_257_223_612_9));
            let incident = Side::Front.direction_from_disk(from.map(|c| -c));
            sum += tree.eval(incident, Side::Front.direction_from_disk(to), false);
        }
        let (value, expected) =
            (f64::from(matrix.values()[i * basis.n_patches() + o]), sum / f64::from(n_points));
        assert!((value / expected - 1.0).abs() < 1e-4, "{i} {o}: {value} {expected}");
    }
}

#[test]
fn conversions_keep_the_light_of_real_files() {
    for file in READABLE {
        let Some(path) = real_file(file) else { continue };
        let (bsdf, _) = read_file(&path, Strictness::Repair).unwrap();
        let klems = bsdf.to_klems(&Arc::new(Basis::full())).unwrap();
        let mut converted = vec![klems];
        for (rank, log2_res) in [(Rank::Three, 5), (Rank::Four, 4)] {
            converted.extend(bsdf.to_tree(&options(rank, log2_res)).ok());
        }
        assert!(converted.len() > 1, "{file}");
        for made in &converted {
            for (band, other) in bsdf.bands.iter().zip(&made.bands) {
                for (part, component) in band.components() {
                    let new = other.component(part).expect("the same parts");
                    let (before, after) = (light(&component.luminance), light(&new.luminance));
                    assert!((after - before).abs() <= 1e-6 * before, "{file} {part:?}: {before} {after}");
                    assert_eq!(component.chroma.is_some(), new.chroma.is_some());
                }
            }
        }
    }
}

#[test]
fn totals_of_a_patch_are_those_of_the_tree_on_average() {
    let Some(path) = real_file("pyradiance/t3.xml") else { return };
    let (bsdf, _) = read_file(&path, Strictness::Strict).unwrap();
    let basis = Arc::new(Basis::full());
    let klems = bsdf.to_klems(&basis).unwrap();
    let (tree, matrix) = (&bsdf.bands[0], &klems.bands[0]);
    let (part, _) = tree.components().next().unwrap();
    for patch in [0, 5, 30, 80, 144] {
        let mut mean = 0.0;
        let n = 64;
        for k in 0..n * n {
            let (u, v) = ((f64::from(k / n) + 0.5) / f64::from(n), (f64::from(k % n) + 0.5) / f64::from(n));
            let disk = basis.disk_point(patch, u, v).map(|c| -c);
            let incident = part.incident_side().direction_from_disk(disk);
            mean += tree.hemispherical(incident, Lobes::All) / f64::from(n * n);
        }
        let disk = basis.disk_point(patch, 0.5, 0.5).map(|c| -c);
        let total = matrix.hemispherical(part.incident_side().direction_from_disk(disk), Lobes::All);
        assert!((total / mean - 1.0).abs() < 1e-3, "{patch}: {total} {mean}");
    }
}

#[test]
fn a_matrix_that_becomes_a_fine_tree_and_comes_back_is_itself() {
    let basis = Arc::new(Basis::quarter());
    let n = basis.n_patches();
    let values: Vec<f32> = (0..n * n).map(|k| 0.01 + (k * 7919 % 101) as f32 / 100.0).collect();
    let matrix = Matrix::new(basis.clone(), basis.clone(), values).unwrap();
    let original = single(Part::TransmissionBack, matrix);
    let mut last = f64::INFINITY;
    for log2_res in [3, 4, 5] {
        let tree = original.to_tree(&options(Rank::Four, log2_res)).unwrap();
        let error = relative_l1(
            luminance(&original, Part::TransmissionBack),
            luminance(&tree, Part::TransmissionBack),
        );
        let back = tree.to_klems(&basis).unwrap();
        let round = relative_l1(
            luminance(&original, Part::TransmissionBack),
            luminance(&back, Part::TransmissionBack),
        );
        assert!(error < 0.75 * last, "2^{log2_res}: {error} after {last}");
        assert!(round < error, "{round} {error}");
        last = error;
    }
}

#[test]
fn tolerance_bounds_the_error_and_saves_leaves() {
    let basis = Arc::new(Basis::quarter());
    let n = basis.n_patches();
    let values: Vec<f32> =
        (0..n * n).map(|k| if k / n == k % n { 3.0 } else { 0.2 + 0.01 * (k % 7) as f32 }).collect();
    let original = single(Part::ReflectionBack, Matrix::new(basis.clone(), basis, values).unwrap());
    let part = Part::ReflectionBack;
    let exact = original.to_tree(&options(Rank::Four, 5)).unwrap();
    for tolerance in [0.01, 0.05] {
        let joined = original.to_tree(&TreeOptions { tolerance, ..options(Rank::Four, 5) }).unwrap();
        let error = relative_l1(luminance(&exact, part), luminance(&joined, part));
        assert!(error <= 1.02 * tolerance, "{error} {tolerance}");
        assert!(luminance(&joined, part).n_values() < luminance(&exact, part).n_values());
        assert!((light(luminance(&joined, part)) / light(luminance(&exact, part)) - 1.0).abs() < 1e-6);
    }
}

#[test]
fn isotropic_matrices_and_rank_3_agree_through_each_other() {
    // A lobe about the mirror direction, by ring and relative azimuth.
    let basis = Arc::new(Basis::full());
    let n = basis.n_patches();
    let centre = |k| basis.disk_point(k, 0.5, 0.5);
    let values: Vec<f32> = (0..n * n)
        .map(|k| {
            let (i, o) = (centre(k / n), centre(k % n));
            (2.0 * (-20.0 * ((i[0] - o[0]).powi(2) + (i[1] - o[1]).powi(2))).exp() + 0.05) as f32
        })
        .collect();
    let matrix = Scattering::from(Matrix::new(basis.clone(), basis.clone(), values).unwrap());
    let original = single(
        Part::ReflectionBack,
        match &matrix {
            Scattering::Matrix(m) => Matrix::clone(m),
            _ => unreachable!(),
        },
    );
    let tree = original.to_tree(&options(Rank::Three, 6)).unwrap();
    let back = tree.to_klems(&basis).unwrap();
    // Two spreads over patches, no more: the lobe is about as wide as a patch.
    let error = relative_l1(&matrix, luminance(&back, Part::ReflectionBack));
    assert!(error < 0.2, "{error}");
    assert!((light(luminance(&back, Part::ReflectionBack)) / light(&matrix) - 1.0).abs() < 1e-6);
    // Turning changes nothing.
    let at = |phi: f64| {
        let i: Direction = bsdftree::direction::direction_from_polar(0.6, phi);
        let o = bsdftree::direction::direction_from_polar(0.5, phi + 3.0);
        luminance(&tree, Part::ReflectionBack).eval(i, o, false)
    };
    assert_eq!(at(0.0), at(1.234));
}

#[test]
fn rank_3_from_one_transmission_has_both() {
    let basis = Arc::new(Basis::quarter());
    let n = basis.n_patches();
    let values = (0..n * n).map(|k| 0.01 + (k / n) as f32 * 0.002).collect();
    let original = single(Part::TransmissionFront, Matrix::new(basis.clone(), basis, values).unwrap());
    let tree = original.to_tree(&options(Rank::Three, 5)).unwrap();
    let (given, made) =
        (luminance(&original, Part::TransmissionFront), luminance(&tree, Part::TransmissionBack));
    assert!((light(made) / light(given) - 1.0).abs() < 1e-6);
    // Patches of a ring differ by 12 % here, which an isotropic tree has no room for.
    let at = |theta: f64| bsdftree::direction::direction_from_polar(theta, 1.0);
    let (reversed, own) = (original.bands[0].eval(at(0.3), at(2.2)), tree.bands[0].eval(at(0.3), at(2.2)));
    assert!((reversed / own - 1.0).abs() < 0.13, "{reversed} {own}");
}

#[test]
fn bad_requests_are_refused() {
    let bsdf = single(Part::ReflectionBack, Tree::uniform(Rank::Four, 0.1));
    for (rank, log2_res, tolerance) in [
        (Rank::Four, 0, 0.0),
        (Rank::Four, 11, 0.0),
        (Rank::Four, 4, 1.0),
        (Rank::Four, 4, f64::NAN),
        (Rank::Three, 4, 0.0),
    ] {
        assert!(bsdf.to_tree(&TreeOptions { rank, log2_res, tolerance }).is_err());
    }
}
