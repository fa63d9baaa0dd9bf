//! One thread, random directions: values, samples, totals, and reading XML. Trees are made here, so that everyone has the same.

use std::hint::black_box;

use bsdftree::square::disk_from_square;
use bsdftree::xml::{self, Strictness};
use bsdftree::{Band, Bsdf, Component, Direction, Lobes, Part, Rank, Side, Tree};
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};

const N: usize = 10_000;

/// A smooth lobe with a peak along the diagonal, over 2^log2 cells per axis.
fn peaked(rank: Rank, log2: u32) -> Tree {
    let n = 1usize << log2;
    let d = rank.dimensions();
    let values: Vec<f32> = (0..1usize << (d as u32 * log2))
        .map(|k| {
            let c = |i: usize| ((k >> ((d - 1 - i) as u32 * log2) & (n - 1)) as f64 + 0.5) / n as f64;
            let (along, across) = match rank {
                Rank::Three => (1.0 - c(0) - c(1), 0.5 - c(2)),
                Rank::Four => (c(0) - c(2), c(1) - c(3)),
            };
            let distance = (along * along + across * across).sqrt();
            // Steps of 2^-8 let far cells merge.
            ((0.2 + 5.0 * (-(distance * 20.0)).exp()) * 256.0).round() as f32 / 256.0
        })
        .collect();
    Tree::from_grid(rank, &values).expect("a grid of powers of two")
}

fn bsdf(tree: Tree) -> Bsdf {
    let mut bsdf = Bsdf::default();
    bsdf.band_mut("Visible").insert(Part::ReflectionBack, Component::grey(tree.into()));
    bsdf
}

/// Points of the R₂ sequence as directions on the front.
fn directions() -> Vec<Direction> {
    let point =
        |k: usize| [0.754_877_666_246_693, 0.569_840_290_998_053_3].map(|a| (0.5 + a * k as f64).fract());
    // A stride far from the sequence's neighbours, so that consecutive queries touch distant cells.
    (0..N).map(|k| Side::Front.direction_from_disk(disk_from_square(point(k * 7919 % 104_729)))).collect()
}

fn queries(c: &mut Criterion) {
    let directions = directions();
    let pairs = || directions.iter().zip(directions.iter().rev());
    for (name, rank, log2) in [("rank 3, 2^6", Rank::Three, 6), ("rank 4, 2^5", Rank::Four, 5)] {
        let bsdf = bsdf(peaked(rank, log2));
        let band: &Band = &bsdf.bands[0];
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(N as u64));
        group.bench_function("eval", |b| {
            b.iter(|| pairs().map(|(&i, &o)| band.eval(black_box(i), o)).sum::<f64>());
        });
        group.bench_function("sample", |b| {
            let u = |k: usize| (k as f64 * 0.618_033_988_749_895).fract();
            b.iter(|| {
                let samples =
                    directions.iter().enumerate().map(|(k, &i)| band.sample(i, u(k), None, Lobes::All));
                samples.map(|s| s.pdf).sum::<f64>()
            });
        });
        group.bench_function("pdf", |b| {
            b.iter(|| pairs().map(|(&i, &o)| band.pdf(black_box(i), o, Lobes::All)).sum::<f64>());
        });
        group.bench_function("hemispherical", |b| {
            b.iter(|| directions.iter().map(|&i| band.hemispherical(black_box(i), Lobes::All)).sum::<f64>());
        });
        group.finish();
    }
}

fn files(c: &mut Criterion) {
    let bsdf = bsdf(peaked(Rank::Four, 5));
    let mut text = Vec::new();
    xml::write(&bsdf, &mut text).expect("writing to memory");
    let mut group = c.benchmark_group("xml");
    group.throughput(Throughput::Bytes(text.len() as u64));
    group.bench_function("read", |b| {
        b.iter_batched(
            || &text,
            |text| xml::read(text, Strictness::Strict).expect("own file"),
            BatchSize::LargeInput,
        );
    });
    group.bench_function("write", |b| {
        b.iter(|| {
            let mut out = Vec::with_capacity(text.len());
            xml::write(&bsdf, &mut out).expect("writing to memory");
            out
        });
    });
    group.finish();
}

criterion_group! { name = benches; config = Criterion::default().sample_size(20); targets = queries, files }
criterion_main!(benches);
