//! Cost of a random block and of one scattering, by material: `cargo bench -p bsdftree-generate --bench scatter`.

use std::hint::black_box;

use bsdftree_device::material::{Gloss, GlossKind, Material, Medium};
use bsdftree_generate::random::{Random, Stratified, philox4x32};
use bsdftree_generate::scatter::{Meeting, PreparedMaterial, Spectrum};
use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;

const PAINT: Gloss = Gloss {
    kind: GlossKind::Plastic,
    color: DVec3::splat(0.6),
    specular: 0.0,
    roughness: [0.0; 2],
    orientation: None,
    transmission: 0.0,
    transmitted_specular: 0.0,
};

fn random_numbers(c: &mut Criterion) {
    let mut group = c.benchmark_group("random");
    let mut counter = [0; 4];
    group.bench_function("block", |b| {
        b.iter(|| {
            counter[0] += 1;
            philox4x32(counter, black_box([1, 2]))
        });
    });
    let mut points = Stratified::new(1, 2);
    let mut sample = 0;
    group.bench_function("stratified point", |b| {
        b.iter(|| {
            sample += 1;
            points.start(1, 2, sample)
        });
    });
    let mut random = Random::new(1, 2, 3);
    group.bench_function("number", |b| b.iter(|| random.next_open()));
}

fn bench_material<S: Spectrum>(c: &mut Criterion, name: &str, material: &Material) {
    let prepared = PreparedMaterial::<S>::new(material);
    let normal = DVec3::new(0.1, 0.2, 0.97).normalize();
    let incoming = DVec3::new(0.6, 0.0, -0.8);
    let mut random = Random::new(1, 2, 3);
    c.bench_function(name, |b| {
        b.iter(|| prepared.scatter(&Meeting::new(black_box(normal), black_box(incoming)), &mut random))
    });
}

fn materials(c: &mut Criterion) {
    let rough = Gloss { specular: 0.2, roughness: [0.1; 2], ..PAINT };
    let glass = Material::Glass { transmissivity: DVec3::splat(0.96), index: 1.52 };
    let block = Material::Dielectric {
        inside: Medium { transmittance: DVec3::ONE, index: 1.52 },
        outside: Medium::VACUUM,
    };
    bench_material::<f64>(c, "scatter/diffuse grey", &Material::Gloss(PAINT));
    bench_material::<DVec3>(c, "scatter/diffuse color", &Material::Gloss(PAINT));
    bench_material::<f64>(
        c,
        "scatter/smooth plastic grey",
        &Material::Gloss(Gloss { specular: 0.05, ..PAINT }),
    );
    bench_material::<f64>(c, "scatter/rough plastic grey", &Material::Gloss(rough));
    bench_material::<f64>(
        c,
        "scatter/rough metal grey",
        &Material::Gloss(Gloss { kind: GlossKind::Metal, specular: 1.0, ..rough }),
    );
    bench_material::<f64>(c, "scatter/glass grey", &glass);
    bench_material::<f64>(c, "scatter/dielectric grey", &block);
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(30).measurement_time(std::time::Duration::from_secs(2));
    targets = random_numbers, materials
}
criterion_main!(benches);
