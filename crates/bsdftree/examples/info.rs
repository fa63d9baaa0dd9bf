//! What is in a BSDF file: `cargo run --release -p bsdftree --example info -- blinds.xml`.
//!
//! The components of each band, and how much light from each side is reflected and transmitted, by polar angle and altogether. All
//! values are read, or, of a `.bsdft` file, verified. `--memory` adds the most memory that the process has had (Linux).

use bsdftree::direction::direction_from_polar;
use bsdftree::square::disk_from_square;
use bsdftree::xml::Strictness;
use bsdftree::{Band, Bsdf, Lobes, Scattering, Side, file};

/// Polar angles of the table \[degree\].
const THETAS_DEG: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];

fn main() {
    let (options, paths): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|word| word == "--memory");
    if paths.is_empty() {
        eprintln!("usage: info [--memory] FILE …");
        std::process::exit(2);
    }
    for path in paths {
        let read = file::read(&path, Strictness::Repair).map_err(|error| error.to_string());
        let verified = read.and_then(|(bsdf, repairs)| {
            bsdf.verify().map_err(|damage| format!("{path}: {damage}"))?;
            Ok((bsdf, repairs))
        });
        match verified {
            Ok((bsdf, repairs)) => {
                repairs.iter().for_each(|repair| eprintln!("{path}: {repair}"));
                show(&path, &bsdf);
            }
            Err(problem) => {
                eprintln!("{problem}");
                std::process::exit(1);
            }
        }
    }
    if !options.is_empty() {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        println!("memory at most: {}", peak.unwrap_or("not known").trim());
    }
}

fn show(path: &str, bsdf: &Bsdf) {
    println!("{path}: {} by {}", bsdf.header.name, bsdf.header.manufacturer);
    for band in &bsdf.bands {
        println!("{}", band.name);
        for (part, component) in band.components() {
            let function = &component.luminance;
            let kind = match function {
                Scattering::Tree(tree) => {
                    format!("tree, rank {}, 2^{}", tree.rank().dimensions(), tree.arena().log2_res())
                }
                Scattering::Matrix(matrix) => format!("matrix, {}", matrix.incident().name()),
            };
            println!("  {:<20} {kind:<28} {:>10} values", part.key(), function.n_values());
        }
        for side in [Side::Front, Side::Back] {
            for lobes in [Lobes::Reflection, Lobes::Transmission] {
                let by_angle =
                    THETAS_DEG.map(|theta| format!("{:6.2} %", 100.0 * at(band, side, theta, lobes)));
                let all = 100.0 * hemispherical(band, side, lobes);
                println!("  {side:?} {lobes:?}: {all:.2} %, by angle {}", by_angle.join(" "));
            }
        }
    }
}

/// Mean over the azimuth.
fn at(band: &Band, side: Side, theta_deg: f64, lobes: Lobes) -> f64 {
    const N: usize = 72;
    let total = |k: usize| {
        let [x, y, z] =
            direction_from_polar(theta_deg.to_radians(), std::f64::consts::TAU * k as f64 / N as f64);
        band.hemispherical([x, y, z * side.sign()], lobes)
    };
    (0..N).map(total).sum::<f64>() / N as f64
}

/// Mean over the hemisphere by projected solid angle.
fn hemispherical(band: &Band, side: Side, lobes: Lobes) -> f64 {
    const N: usize = 64;
    let center = |k: usize| (k as f64 + 0.5) / N as f64;
    let direction = |k: usize| side.direction_from_disk(disk_from_square([center(k / N), center(k % N)]));
    (0..N * N).map(|k| band.hemispherical(direction(k), lobes)).sum::<f64>() / (N * N) as f64
}
