//! Whether estimates are honest: totals without bias, and intervals that hold what they promise.
//!
//! Over 100 seeds, 95 % intervals of leaves and of hemispherical totals must hold the truth 93 to 97 times of 100, by flux. Leaves that
//! are exact (a diffuser seen alone) do not count. The truth comes of many more paths without any reuse or merging.

use bsdftree::tree::Position;
use bsdftree::{Bsdf, Part, Rank, Scattering, Tree};
use bsdftree_device::Device;
use bsdftree_generate::{Generated, Layout, Options, Progress, Sides, generate};

const LOG2_RES: u32 = 2;
const SEEDS: u64 = 100;
/// Half an interval of 95 % in standard errors of 8 replicates.
const STUDENT_95: f64 = 2.365;
const PARTS: [Part; 2] = [Part::ReflectionBack, Part::TransmissionBack];

fn options(samples: u64) -> Options {
    let layout = Layout::Tree { rank: Rank::Four, log2_res: LOG2_RES };
    Options { samples, tile: true, sides: Sides::Front, reciprocity: Some(false), ..Options::new(layout) }
}

fn run(spec: &str, options: &Options) -> Generated {
    generate(&Device::from_spec(spec).unwrap(), options, &Progress::default()).unwrap()
}

fn truth(spec: &str) -> Generated {
    run(spec, &Options { reuse: false, pruned: false, seed: u64::MAX, ..options(200_000) })
}

fn tree(bsdf: &Bsdf, part: Part) -> &Tree {
    match &bsdf.band("Visible").unwrap().component(part).unwrap().luminance {
        Scattering::Tree(tree) => tree,
        Scattering::Matrix(_) => panic!("a matrix"),
    }
}

/// What intervals held and what there was, and the sum of all values relative to the truth's.
#[derive(Default)]
struct Held {
    leaves: [f64; 2],
    totals: [f64; 2],
    ratios: Vec<f64>,
}

impl Held {
    fn add(&mut self, made: &Generated, truth: &Generated) {
        let (mut sum, mut expected) = (0.0, 0.0);
        for part in PARTS {
            for (value, error, mean, size) in leaves(made, tree(&truth.bsdf, part), part) {
                (sum, expected) = (sum + value * size, expected + mean * size);
                if error > 1e-6 * value {
                    let held = (value - mean).abs() <= STUDENT_95 * error;
                    self.leaves[0] += mean * size * f64::from(u8::from(held));
                    self.leaves[1] += mean * size;
                }
            }
        }
        self.ratios.push(sum / expected);
        for (made, truth) in made.report.totals.iter().zip(&truth.report.totals) {
            for ((value, error), expected) in made.values.iter().zip(&made.errors).zip(&truth.values) {
                if *error > 1e-9 {
                    self.totals[0] +=
                        expected * f64::from(u8::from((value - expected).abs() <= STUDENT_95 * error));
                    self.totals[1] += expected;
                }
            }
        }
    }

    fn over(spec: &str, options: &Options) -> Held {
        let truth = truth(spec);
        let mut held = Held::default();
        for seed in 0..SEEDS {
            held.add(&run(spec, &Options { seed, ..options.clone() }), &truth);
        }
        held
    }

    /// Standard errors by which the mean of all totals is off, that of the truth (about 1e-4) included.
    fn z(&self) -> f64 {
        let n = self.ratios.len() as f64;
        let mean = self.ratios.iter().sum::<f64>() / n;
        let variance = self.ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
        (mean - 1.0) / (variance + 1e-8).sqrt()
    }
}

/// Value, standard error, the truth's mean and number of cells of each leaf.
fn leaves(made: &Generated, truth: &Tree, part: Part) -> Vec<(f64, f64, f64, f64)> {
    let errors = tree(&made.errors, part);
    let of = |leaf: bsdftree::tree::Leaf| {
        let n = 1u32 << (LOG2_RES - leaf.level);
        let position = |k: u32| {
            let at = [k % n, k / n % n, k / n.pow(2) % n, k / n.pow(3)];
            let size = 0.5f64.powi(LOG2_RES as i32);
            Position::from_coordinates(&std::array::from_fn::<_, 4, _>(|axis| {
                (f64::from(leaf.cell[axis] * n + at[axis]) + 0.5) * size
            }))
        };
        let sum: f64 = (0..n.pow(4)).map(|k| f64::from(truth.value(position(k)))).sum();
        let size = f64::from(n.pow(4));
        (f64::from(leaf.value), f64::from(errors.value(position(0))), sum / size, size)
    };
    tree(&made.bsdf, part).leaves().map(of).collect()
}

fn assert_honest(held: &Held) {
    let share = |[held, all]: [f64; 2]| held / all;
    let (leaves, totals) = (share(held.leaves), share(held.totals));
    println!("leaves {leaves:.4}, totals {totals:.4}, z {:.2}", held.z());
    assert!((0.93..=0.97).contains(&leaves), "{leaves} of leaves' intervals hold the truth");
    assert!((0.93..=0.97).contains(&totals), "{totals} of totals' intervals hold the truth");
    assert!(held.z().abs() < 3.5, "z = {}", held.z());
}

#[test]
fn independent_paths_are_honest() {
    let options = Options { reuse: false, stratified: false, ..options(256) };
    assert_honest(&Held::over("blinds:angle=30", &options));
}

#[test]
fn evenly_spread_paths_are_honest() {
    assert_honest(&Held::over("blinds:angle=30", &Options { reuse: false, ..options(256) }));
}

#[test]
fn reused_light_is_honest() {
    assert_honest(&Held::over("blinds:angle=30", &options(64)));
}

#[test]
fn mirrors_among_diffuse_facets_are_honest() {
    assert_honest(&Held::over("sawtooth", &options(64)));
}

/// Σ|f − truth| over all cells, and the light in cells where the truth has none, both relative to all light.
fn off(made: &Generated, truth: &Generated) -> [f64; 2] {
    let n = 1u32 << LOG2_RES;
    let (mut wrong, mut astray, mut all) = (0.0, 0.0, 0.0);
    for part in PARTS {
        let (made, truth) = (tree(&made.bsdf, part), tree(&truth.bsdf, part));
        for k in 0..n.pow(4) {
            let at = [k % n, k / n % n, k / n.pow(2) % n, k / n.pow(3)];
            let position = Position::from_coordinates(&at.map(|c| (f64::from(c) + 0.5) / f64::from(n)));
            let [f, t] = [made, truth].map(|tree| f64::from(tree.value(position)));
            wrong += (f - t).abs();
            all += t;
            astray += if t == 0.0 { f } else { 0.0 };
        }
    }
    [wrong / all, astray / all]
}

#[test]
fn reciprocity_lowers_the_error_and_does_not_blur() {
    // Without merging, so that only what is counted matters.
    for spec in ["sawtooth", "blinds:angle=30"] {
        let truth = truth(spec);
        let plain = Options { reuse: false, pruned: false, sides: Sides::Both, ..options(256) };
        let mean = |reciprocity| {
            let sum = (0..20).fold([0.0; 2], |sum, seed| {
                let made = run(spec, &Options { seed, reciprocity: Some(reciprocity), ..plain.clone() });
                let [wrong, astray] = off(&made, &truth);
                [sum[0] + wrong / 20.0, sum[1] + astray / 20.0]
            });
            println!("{spec}, reciprocity {reciprocity}: L1 {:.4}, astray {:.2e}", sum[0], sum[1]);
            sum
        };
        let ([without, _], [with, astray]) = (mean(false), mean(true));
        assert!(with < 0.9 * without, "{spec}: {with}, without {without}");
        assert!(astray < 1e-4, "{spec}: {astray} of the light where there is none");
    }
}
