//! Trees from functions, against closed forms.

use std::convert::Infallible;

use bsdftree::convert::{FunctionError, TreeOptions};
use bsdftree::{Bsdf, Direction, Lobes, Part, Rank, Side};

fn options(rank: Rank, log2_res: u32, tolerance: f64) -> TreeOptions {
    TreeOptions { rank, log2_res, tolerance }
}

/// A tree of the function, and how often that was asked.
fn tree_of(f: impl Fn(Direction, Direction) -> f64, part: Part, options: &TreeOptions) -> (Bsdf, usize) {
    let mut n = 0;
    let many = |i: &[Direction], o: &[Direction], values: &mut [f64]| {
        n += values.len();
        values.iter_mut().enumerate().for_each(|(k, value)| *value = f(i[k], o[k]));
        Ok::<(), Infallible>(())
    };
    let bsdf = Bsdf::from_function(many, &[part], false, options).unwrap();
    (bsdf, n)
}

/// A lobe of unit flux per projected solid angle about the mirror direction, so narrow that little of it is cut off by the horizon.
fn lobe(i: Direction, o: Direction, width: f64) -> f64 {
    let d2 = (i[0] + o[0]).powi(2) + (i[1] + o[1]).powi(2);
    (-d2 / (width * width)).exp() / (std::f64::consts::PI * width * width)
}

fn at(theta: f64, phi: f64) -> Direction {
    bsdftree::direction::direction_from_polar(theta, phi)
}

#[test]
fn a_lambertian_function_is_one_leaf() {
    let (bsdf, _) = tree_of(|_, _| 0.25, Part::TransmissionFront, &options(Rank::Four, 6, 0.01));
    let component = bsdf.bands[0].component(Part::TransmissionFront).unwrap();
    assert_eq!(component.luminance.n_values(), 1);
    assert_eq!(bsdf.bands[0].eval(at(2.0, 0.0), at(0.3, 1.0)), 0.25);
}

#[test]
fn black_components_are_left_out() {
    let (bsdf, _) = tree_of(|_, _| 0.0, Part::TransmissionFront, &options(Rank::Four, 6, 0.01));
    assert_eq!(bsdf.bands[0].components().count(), 0);
}

#[test]
fn totals_are_those_of_lobes_wide_and_narrow() {
    for (rank, log2_res, most) in [(Rank::Four, 4, 40), (Rank::Three, 6, 4)] {
        for width in [0.3, 0.1, 0.05, 0.03] {
            let (bsdf, n) =
                tree_of(|i, o| lobe(i, o, width) + 0.1, Part::ReflectionBack, &options(rank, log2_res, 0.02));
            let expected = 1.0 + 0.1 * std::f64::consts::PI;
            for theta in [0.2, 0.4, 0.7] {
                let totals: Vec<f64> = (0..48)
                    .map(|k| bsdf.bands[0].hemispherical(at(theta, 0.13 * f64::from(k)), Lobes::All))
                    .collect();
                let mean = totals.iter().sum::<f64>() / 48.0;
                let r: f64 = 1.0 - theta.sin();
                let cut = if width > 0.2 { (-(r / width).powi(2)).exp() } else { 0.0 };
                assert!(
                    mean < 1.015 * expected && mean > 0.985 * (expected - cut),
                    "{rank:?} {width} {theta}: {mean} {expected}"
                );
                // Of a cell a peak in which is a twentieth of it, 256 places are few.
                let worst = totals.iter().map(|t| (t / mean - 1.0).abs()).fold(0.0, f64::max);
                assert!(worst < 0.1, "{rank:?} {width} {theta}: {worst}");
            }
            assert!(n < most * 1_000_000, "{rank:?} {width}: {n} evaluations");
            println!(
                "{rank:?} width {width}: {n} evaluations, {} values",
                bsdf.bands[0].components().next().unwrap().1.luminance.n_values()
            );
        }
    }
}

#[test]
fn values_are_means_within_the_tolerance() {
    let f = |i: Direction, o: Direction| 0.1 + lobe(i, o, 0.4) * (1.0 + 0.5 * o[0]);
    let (bsdf, n) = tree_of(f, Part::ReflectionBack, &options(Rank::Four, 5, 0.05));
    let (mut error, mut light) = (0.0, 0.0);
    for k in 0..200_000 {
        let u = [0.857, 0.734, 0.629, 0.539].map(|s: f64| (0.5 + f64::from(k) * s * 1.000_123).fract());
        let point =
            |a: f64, b: f64| Side::Front.direction_from_disk(bsdftree::square::disk_from_square([a, b]));
        let (i, o) = (point(u[0], u[1]), point(u[2], u[3]));
        error += (bsdf.bands[0].eval(i, o) - f(i, o)).abs();
        light += f(i, o);
    }
    println!("relative L1 {}, {n} evaluations", error / light);
    assert!(error < 0.06 * light, "{}", error / light);
    assert!(n < 16 << 20, "fewer than the full grid's {n}");
}

#[test]
fn a_peak_far_narrower_than_the_first_cells_is_found() {
    // Straight through, and back where it came from: nothing a coarse grid sees.
    for sign in [1.0, -1.0] {
        let f = |i: Direction, o: Direction| lobe(i.map(|c| sign * c), o, 0.015);
        let (bsdf, _) = tree_of(f, Part::TransmissionBack, &options(Rank::Four, 5, 0.05));
        for theta in [0.2, 0.6, 0.9] {
            let total =
                |k: u32| bsdf.bands[0].hemispherical(at(theta, 0.07 + 0.13 * f64::from(k)), Lobes::All);
            let mean = (0..48).map(total).sum::<f64>() / 48.0;
            assert!((mean - 1.0).abs() < 0.03, "{sign} {theta}: {mean}");
        }
    }
}

#[test]
fn colour_is_refined_together() {
    let many = |i: &[Direction], o: &[Direction], values: &mut [f64]| {
        for (k, xyz) in values.chunks_exact_mut(3).enumerate() {
            let f = 0.1 + lobe(i[k], o[k], 0.3);
            xyz.copy_from_slice(&[0.9 * f, f, 0.3 + 0.2 * o[k][0]]);
        }
        Ok::<(), Infallible>(())
    };
    let bsdf =
        Bsdf::from_function(many, &[Part::ReflectionBack], true, &options(Rank::Four, 4, 0.05)).unwrap();
    let (i, o) = (at(0.5, 1.0), at(1.0, 2.0));
    let [x, y, z] = bsdf.bands[0].eval_xyz(i, o);
    assert!((x / y - 0.9).abs() < 0.03, "{x} {y}");
    assert!((z - 0.3 - 0.2 * o[0]).abs() < 0.02, "{z}");
}

#[test]
fn what_is_no_bsdf_is_refused_with_its_place() {
    let run = |value: f64| {
        let many = |_: &[Direction], _: &[Direction], values: &mut [f64]| {
            values.fill(value);
            if value == 2.0 { Err("broken") } else { Ok(()) }
        };
        Bsdf::from_function(many, &[Part::ReflectionBack], false, &options(Rank::Four, 4, 0.05)).unwrap_err()
    };
    for value in [-0.1, f64::NAN, f64::INFINITY] {
        assert!(matches!(run(value), FunctionError::Value { incident, .. } if incident[2] > 0.0));
    }
    assert!(matches!(run(2.0), FunctionError::Function("broken")));
}
