//! Whole paths per second, with one thread and two, on the devices of the demonstration.

use bsdftree::Rank;
use bsdftree_device::Device;
use bsdftree_generate::{Layout, Options, Progress, Sides, generate};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn paths(c: &mut Criterion) {
    for spec in ["blinds", "blinds:angle=30,rise=0.005", "sawtooth", "prism"] {
        let device = Device::from_spec(spec).expect("a family that is there");
        for threads in [1, 2] {
            let options = Options {
                samples: 1000,
                sides: Sides::Front,
                threads: Some(threads),
                ..Options::new(Layout::Tree { rank: Rank::Four, log2_res: 4 })
            };
            let mut group = c.benchmark_group(format!("generate {spec}"));
            group.throughput(Throughput::Elements(256 * options.samples));
            group.bench_function(format!("{threads} threads"), |b| {
                b.iter(|| generate(&device, &options, &Progress::default()).expect("a legal device"));
            });
            group.finish();
        }
    }
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = paths }
criterion_main!(benches);
