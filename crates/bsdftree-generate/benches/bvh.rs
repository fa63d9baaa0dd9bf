//! Closest hits per second, one thread, incoherent rays.

#[path = "../tests/bvh_scenes/mod.rs"]
mod bvh_scenes;

use bsdftree_device::Device;
use bsdftree_generate::bvh::{Bvh, Ray, Simd};
use bvh_scenes::{Random, blind, mesh, mixture, sphere_mesh};
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};

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
            rays.push(Ray { origin: hit.position, direction, from: Some(hit.surface) });
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

criterion_group!(benches, scenes);
criterion_main!(benches);
