//! Figures, not claims: `cargo test --release -p bsdftree-generate --lib diffuse::tests::measure -- --ignored --nocapture`.

use std::time::Instant;

use bsdftree::{Part, Rank, Side};
use bsdftree_device::Device;

use super::super::*;
use super::support::*;
use crate::layout::Layout;

fn tree(log2_res: u32) -> Layout {
    Layout::Tree { rank: Rank::Four, log2_res }
}

#[test]
#[ignore = "prints figures"]
fn totals_beside_plain_paths() {
    for (spec, tiled) in
        [("sawtooth", true), ("sawtooth", false), ("blinds:angle=30", true), ("blinds:angle=30", false)]
    {
        let setup = Setup::<f64>::new(Device::from_spec(spec).unwrap(), tiled, tree(3));
        let t = Instant::now();
        let sites = setup.sites(Fineness::default());
        let t_sites = t.elapsed();
        let t = Instant::now();
        let modelled = setup.model_at(&sites, 1024, 4096);
        println!("{spec} {tiled}: {} sites in {t_sites:.2?}, rest {:.2?}", sites.len(), t.elapsed());
        for side in SIDES {
            let total = setup.total(&modelled, side);
            let [plain, variance] = setup.plain(side, 200_000);
            let n = 64;
            let omega = std::f64::consts::PI / n as f64;
            let (mut worst, mut l1, mut flux) = (0.0f64, 0.0, 0.0);
            for i in 0..n {
                let sum = |f: &[f64]| f[2 * n * i..2 * n * (i + 1)].iter().sum::<f64>() * omega;
                worst = worst.max((sum(&total) - sum(&plain)).abs());
            }
            let mut z2 = 0.0;
            for k in 0..total.len() {
                l1 += (total[k] - plain[k]).abs();
                flux += plain[k];
                if variance[k] > 0.0 {
                    z2 += (total[k] - plain[k]).powi(2) / variance[k];
                }
            }
            let noise: f64 = variance.iter().map(|v| (v * 2.0 / std::f64::consts::PI).sqrt()).sum();
            println!(
                "  {side:?} mean total {:.5} plain {:.5} worst {worst:.5}, L1 {:.5} (noise {:.5}) z2 {:.2}",
                total.iter().sum::<f64>() * omega / n as f64,
                flux * omega / n as f64,
                l1 / flux,
                noise / flux,
                z2 / total.len() as f64
            );
        }
    }
}

/// Σ|a − b| / Σ b.
fn l1(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / b.iter().sum::<f64>()
}

#[test]
#[ignore = "prints figures"]
fn bias_by_pilot_and_tolerance() {
    let specs = [
        ("sawtooth", true),
        ("sawtooth", false),
        ("blinds:angle=30", true),
        ("blinds:angle=30,rise=0.005", true),
    ];
    for (spec, tiled) in specs {
        let setup = Setup::<f64>::new(Device::from_spec(spec).unwrap(), tiled, tree(3));
        let finest = Fineness { n_pilot: 8192, tolerance: 1e-7, max_sites: 1024, n_points: 1 << 20 };
        let sites = setup.sites(finest);
        let reference = setup.model_at(&sites, 16384, 4096);
        let reference = SIDES.map(|side| setup.total(&reference, side));
        println!("{spec} {tiled}: reference of {} sites, cuts {:?}", sites.len(), sites.cuts());
        for n_pilot in [256, 1024] {
            for tolerance in [1e-3, 1e-4, 1e-5] {
                let t = Instant::now();
                let sites =
                    setup.sites(Fineness { n_pilot, tolerance, max_sites: 512, ..Fineness::default() });
                let time = t.elapsed();
                let modelled = setup.model_at(&sites, 16384, 16384);
                let [a, b] = [0, 1].map(|k| l1(&setup.total(&modelled, SIDES[k]), &reference[k]));
                println!(
                    "  pilot {n_pilot} tolerance {tolerance:e}: {} sites, {time:.2?}, L1 {a:.5} {b:.5} cuts {:?}",
                    sites.len(),
                    sites.cuts()
                );
            }
        }
    }
}

#[test]
#[ignore = "prints figures"]
fn time_and_noise_at_2_to_6() {
    for (spec, tiled) in [("sawtooth", true), ("blinds:angle=30", true), ("sawtooth", false)] {
        let setup = Setup::<f64>::new(Device::from_spec(spec).unwrap(), tiled, tree(6));
        let sites = setup.sites(Fineness::default());
        let reference =
            setup.exchanged(&sites, [Some(setup.rows(&sites, Side::Front, 2048, 11)), None], 65536, 11);
        let reference = reference.estimates(Part::ReflectionBack, 0).unwrap();
        let mean = |[a, b]: &[Vec<f32>; 2]| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| 0.5 * f64::from(a + b)).collect()
        };
        let reference = mean(&reference);
        for (walks, exchanged) in [(16, 4096), (64, 4096), (256, 4096), (64, 1024), (64, 16384)] {
            let t = [(); 5].map(|()| Instant::now());
            let sites = setup.sites(Fineness::default());
            let t1 = Instant::now();
            let rows = setup.rows(&sites, Side::Front, walks, 12);
            let t2 = Instant::now();
            let model = setup.exchanged(&sites, [Some(rows), None], exchanged, 12);
            let t3 = Instant::now();
            let both = model.estimates(Part::ReflectionBack, 0).unwrap();
            let t4 = Instant::now();
            let mean = mean(&both);
            let noise: f64 =
                both[0].iter().zip(&both[1]).map(|(a, b)| 0.5 * f64::from((a - b).abs())).sum::<f64>()
                    / mean.iter().sum::<f64>();
            println!(
                "{spec} {tiled} {walks}+{exchanged}: {} sites {:.2?}, walks {:.2?} ({:.2} M/s), exchange {:.2?}, product {:.2?}; L1 {:.4}, halves {noise:.4}",
                sites.len(),
                t1 - t[0],
                t2 - t1,
                2.0 * 4096.0 * walks as f64 / (t2 - t1).as_secs_f64() * 1e-6,
                t3 - t2,
                t4 - t3,
                l1(&mean, &reference)
            );
        }
        let t = Instant::now();
        let options = crate::Options {
            samples: 256,
            sides: crate::Sides::Front,
            pruned: false,
            tile: tiled,
            ..crate::Options::new(tree(5))
        };
        let report = crate::generate(&setup.device, &options, &crate::Progress::default()).unwrap().report;
        println!(
            "plain: {:.2} M paths/s, {:.2?}",
            report.paths as f64 / report.tracing.as_secs_f64() * 1e-6,
            t.elapsed()
        );
    }
}
