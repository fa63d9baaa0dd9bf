//! Closest hits per second, one thread, incoherent rays; and what whole paths cost beside the closest hits they ask for.

#[path = "../tests/bvh_scenes/mod.rs"]
mod bvh_scenes;

use std::time::Instant;

use bsdftree::{Rank, Side};
use bsdftree_device::Device;
use bsdftree_generate::bvh::{Bvh, Ray, Simd};
use bsdftree_generate::path::Scene;
use bsdftree_generate::random::{Start, Stratified};
use bsdftree_generate::{Layout, Options, Progress, Sides, generate};
use bvh_scenes::{Random, blind, mesh, mixture, sphere_mesh};
use criterion::{BatchSize, Criterion, Throughput, criterion_group};
use glam::DVec3;

const N_RAYS: usize = 1 << 16;

/// Half of the rays start in the device's box in a random direction, half leave a surface on the side they came from:
/// the two kinds a path tracer sends; unsorted.
fn rays(bvh: &Bvh) -> Vec<Ray> {
    let mut random = Random(1);
    let bounds = bvh.bounds();
    let mut rays = Vec::with_capacity(N_RAYS);
    while rays.len() < N_RAYS {
        let ray = Ray { origin: random.point(bounds), direction: random.direction(), from: None };
        rays.push(ray);
        if let Some(hit) = bvh.closest(&ray) {
            let side = if hit.front { hit.normal } else { -hit.normal };
            let direction = (side + random.direction() * 0.999).normalize();
            rays.push(Ray { origin: hit.position, direction, from: Some(hit.part) });
        }
    }
    rays.truncate(N_RAYS);
    rays
}

fn bench(c: &mut Criterion, name: &str, device: &Device) {
    let bvh = Bvh::build(device).expect("the bench scenes are valid");
    let rays = rays(&bvh);
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(N_RAYS as u64));
    let kernels = [Simd::Avx2, Simd::Portable];
    let expected = rays.iter().filter(|r| bvh.closest(r).is_some()).count();
    for bvh in kernels.iter().filter_map(|&simd| bvh.clone().with_simd(simd).map(|b| (simd, b))) {
        let (simd, bvh) = bvh;
        group.bench_function(format!("{simd:?}"), |b| {
            b.iter(|| {
                let found = rays.iter().filter(|r| bvh.closest(r).is_some()).count();
                assert_eq!(found, expected);
                found
            })
        });
    }
    group.finish();
}

fn scenes(c: &mut Criterion) {
    let ball = mesh(&sphere_mesh(200, 250, 0.1));
    bench(c, "blind of 720 triangles", &blind());
    bench(c, "mesh of 100 k triangles", &ball);
    bench(c, "1000 quadrics", &mixture(1000, 0.05, false, &mut Random(2)));
    c.bench_function("build of 100 k triangles", |b| {
        b.iter_batched(|| (), |()| Bvh::build(&ball).expect("valid"), BatchSize::PerIteration)
    });
}

const LAYOUT: Layout = Layout::Tree { rank: Rank::Four, log2_res: 4 };
const N_INCIDENT: usize = 256;
/// Times are the shortest of so many.
const REPEATS: usize = 40;

/// Every ray of `n` paths from each incident cell of the front.
fn rays_of_paths(scene: &Scene<f64>, [low, high]: [DVec3; 2], n: u64) -> Vec<Ray> {
    let mut rays = Vec::new();
    for cell in 0..N_INCIDENT {
        let mut points = Stratified::new(0, cell as u64);
        for sample in 0..n {
            let Start { incident: [u, v], origin: [s, t], mut random } = points.start(0, cell as u64, sample);
            let direction = DVec3::from(Side::Back.direction_from_disk(LAYOUT.incident_disk(cell, u, v)));
            let place = (low + DVec3::new(s, t, 1.0) * (high - low)) - direction * 1e-6;
            scene.follow_seen(place, direction, None, &mut random, |ray| rays.push(*ray));
        }
    }
    rays
}

/// Seconds that finding the first surface on each ray takes.
fn seconds_bare(bvh: &Bvh, rays: &[Ray]) -> f64 {
    let once = || {
        let begin = Instant::now();
        let sum: f64 = rays.iter().filter_map(|ray| bvh.closest(ray)).map(|hit| hit.t).sum();
        assert!(sum > 0.0);
        begin.elapsed().as_secs_f64()
    };
    (0..REPEATS).map(|_| once()).fold(f64::INFINITY, f64::min)
}

/// Paths per second of a generation, without what follows on tracing.
fn paths_per_second(device: &Device, threads: usize) -> f64 {
    let options =
        Options { samples: 512, sides: Sides::Front, threads: Some(threads), ..Options::new(LAYOUT) };
    let once = || {
        let report = generate(device, &options, &Progress::default()).expect("a legal device").report;
        report.paths as f64 / report.tracing.as_secs_f64()
    };
    (0..REPEATS).map(|_| once()).fold(0.0, f64::max)
}

fn whole_paths() {
    println!("device                      M paths/s  2 threads  rays/path  bare M rays/s  path / its rays");
    for spec in ["blinds", "blinds:angle=30,rise=0.005", "sawtooth", "prism"] {
        let device = Device::from_spec(spec).expect("a family that is there");
        let scene = Scene::<f64>::new(&device).expect("a legal device");
        let n = 64;
        let rays = rays_of_paths(&scene, device.bounds().expect("something"), n);
        let per_path = rays.len() as f64 / (N_INCIDENT as f64 * n as f64);
        let bare = rays.len() as f64 / seconds_bare(scene.bvh(), &rays);
        let [one, two] = [1, 2].map(|threads| paths_per_second(&device, threads));
        let ratio = bare / (one * per_path);
        let [one, two, bare] = [one, two, bare].map(|rate| rate / 1e6);
        println!("{spec:27} {one:9.2} {two:10.2} {per_path:10.2} {bare:14.1} {ratio:16.2}");
    }
}

fn main() {
    // Not where `cargo test` only wants to know whether benchmarks run.
    if std::env::args().any(|argument| argument == "--bench") {
        whole_paths();
    }
    benches();
    Criterion::default().configure_from_args().final_summary();
}

criterion_group!(benches, scenes);
