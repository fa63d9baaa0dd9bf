//! Figures, not claims: `cargo test --release -p bsdftree-generate --lib diffuse::tests::measure -- --ignored --nocapture`.

use std::time::Instant;

use bsdftree::{Part, Rank};
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
    for (spec, tiled) in [("sawtooth", true), ("sawtooth", false), ("blinds:angle=30", true), ("blinds:angle=30", false)] {
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
                if variance[k] > 0.0 { z2 += (total[k] - plain[k]).powi(2) / variance[k]; }
            }
            let noise: f64 = variance.iter().map(|v| (v * 2.0 / std::f64::consts::PI).sqrt()).sum();
            println!("  {side:?} mean total {:.5} plain {:.5} worst {worst:.5}, L1 {:.5} (noise {:.5}) z2 {:.2}",
                total.iter().sum::<f64>() * omega / n as f64, flux * omega / n as f64, l1 / flux, noise / flux, z2/total.len() as f64);
        }
    }
}
