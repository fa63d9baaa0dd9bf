//! Whole paths per second beside the closest hits they ask for. `paths [DEVICE…]` prints a line for each device:
//! its name, paths/s with one thread and with two, bare closest hits/s, rays of a path, and how much longer a path takes
//! than its closest hits. Paths are counted in cells, nothing is reduced. See `benches/generate/raw_speed.py`.

use std::hint::black_box;
use std::time::Instant;

use bsdftree::{Rank, Side};
use bsdftree_device::Device;
use bsdftree_generate::bvh::Ray;
use bsdftree_generate::path::Scene;
use bsdftree_generate::random::{Start, Stratified};
use bsdftree_generate::{Layout, Options, Progress, Sides, generate};
use glam::DVec3;

const N_PATHS: u64 = 1 << 17;

fn main() {
    let named: Vec<String> = std::env::args().skip(1).collect();
    let specs = ["blinds", "blinds:angle=30,rise=0.005", "sawtooth", "prism"].map(str::to_owned);
    for spec in if named.is_empty() { &specs[..] } else { &named } {
        let device = Device::from_spec(spec).expect("a family that is there");
        let rays = rays(&device);
        let bare = bare(&device, &rays);
        let one = paths(&device, 1);
        let two = paths(&device, 2);
        let n_rays = rays.len() as f64 / N_PATHS as f64;
        let ratio = bare / (one * n_rays);
        println!("{spec} {one:.0} {two:.0} {bare:.0} {:.2} {ratio:.2}", rays.len() as f64 / N_PATHS as f64);
    }
}

/// Rays of paths from the front, path after path.
fn rays(device: &Device) -> Vec<Ray> {
    let layout = Layout::Tree { rank: Rank::Four, log2_res: 3 };
    let scene = Scene::<f64>::new(device).expect("a legal device");
    let [low, high] = device.bounds().expect("a device");
    let mut rays = Vec::new();
    let n_cells = layout.n_incident() as u64;
    for cell in 0..n_cells {
        let mut points = Stratified::new(0, cell << 1);
        for sample in 0..N_PATHS / n_cells {
            let Start { incident: [u, v], origin: [s, t], mut random } = points.start(0, cell << 1, sample);
            let disk = layout.incident_disk(cell as usize, u, v);
            let direction = DVec3::from_array(Side::Back.direction_from_disk(disk));
            let place = low + DVec3::new(s, t, 1.0) * (high - low);
            let origin = place - direction * 1e-6;
            scene.follow_seen(origin, direction, None, &mut random, |ray| rays.push(*ray));
        }
    }
    rays
}

/// Closest hits per second.
fn bare(device: &Device, rays: &[Ray]) -> f64 {
    let scene = Scene::<f64>::new(device).expect("a legal device");
    let bvh = scene.bvh();
    let seconds = (0..10).map(|_| {
        let begin = Instant::now();
        for ray in rays {
            black_box(bvh.closest(ray));
        }
        begin.elapsed().as_secs_f64()
    });
    rays.len() as f64 / seconds.fold(f64::INFINITY, f64::min)
}

/// Paths per second.
fn paths(device: &Device, threads: usize) -> f64 {
    let options = Options {
        samples: 1 << 15,
        sides: Sides::Front,
        threads: Some(threads),
        reuse: false,
        reciprocity: Some(false),
        ..Options::new(Layout::Tree { rank: Rank::Four, log2_res: 3 })
    };
    let rate = |_| {
        let report = generate(device, &options, &Progress::default()).expect("a legal device").report;
        report.paths as f64 / report.tracing.as_secs_f64()
    };
    (0..5).map(rate).fold(0.0, f64::max)
}
