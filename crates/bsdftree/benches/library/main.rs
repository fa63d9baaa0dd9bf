//! What the library does in a second, on one thread: values, samples, densities, totals, resolution, files.
//!
//! `cargo bench -p bsdftree --bench library -- [--json] [--only=FIGURE] [--pairs=N] [--save=FOLDER] [FILE …]`: trees that are made here (at
//! rank 3, and at rank 4 up to 2^5 and 2^6), or those in files; `--save` only writes them. Directions are random, and by
//! default as many as that no cache holds their cells. Each figure is the best of several runs, in time of the
//! processor, so that other programs matter less; of two threads the longer time counts.

mod trees;

use std::hint::black_box;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

use bsdftree::binary::{self, Packing};
use bsdftree::square::disk_from_square;
use bsdftree::tree::Instructions;
use bsdftree::xml::{self, Strictness};
use bsdftree::{Band, Bsdf, Component, Direction, Lobes, Part, Rank, Sample, Scattering, Side, Tree};
use trees::{Shape, smooth};

/// Pairs of directions, unless told otherwise.
const PAIRS: usize = 1 << 18;

/// One figure.
struct Figure {
    what: &'static str,
    unit: &'static str,
    value: f64,
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let (options, files): (Vec<_>, Vec<_>) = words.iter().partition(|word| word.starts_with("--"));
    let as_json = options.iter().any(|option| *option == "--json");
    let only = options.iter().find_map(|option| option.strip_prefix("--only="));
    let pairs = options.iter().find_map(|option| option.strip_prefix("--pairs="));
    let pairs = pairs.map_or(PAIRS, |pairs| pairs.parse().expect("a number of pairs"));
    let wanted = || Figures { only: only.map(str::to_owned), pairs, all: Vec::new() };
    let shapes = [
        ("smooth-rank-3", Shape { rank: Rank::Three, log2_res: 6, tolerance: 0.02 }),
        ("smooth-5", Shape { rank: Rank::Four, log2_res: 5, tolerance: 0.6 }),
        ("smooth-6", Shape { rank: Rank::Four, log2_res: 6, tolerance: 0.25 }),
    ];
    if let Some(folder) = options.iter().find_map(|option| option.strip_prefix("--save=")) {
        for (name, shape) in shapes {
            let path = Path::new(folder).join(format!("{name}.bsdft"));
            binary::write_file(&alone(smooth(&shape).into()), Packing::Raw, path)
                .unwrap_or_else(|e| panic!("{e}"));
        }
        return;
    }
    if files.is_empty() {
        for (name, shape) in shapes {
            show(name, &alone(smooth(&shape).into()), wanted(), as_json);
        }
    }
    for name in files {
        let (bsdf, _) = bsdftree::file::read(name, Strictness::Repair).unwrap_or_else(|e| panic!("{e}"));
        show(name, &bsdf, wanted(), as_json);
    }
}

/// A reflection from the room.
fn alone(function: Scattering) -> Bsdf {
    let mut bsdf = Bsdf::default();
    bsdf.band_mut("Visible").insert(Part::ReflectionBack, Component::grey(function));
    bsdf
}

/// Queries are about the component with the most values, files about all.
fn show(name: &str, bsdf: &Bsdf, mut figures: Figures, as_json: bool) {
    let functions = bsdf.bands.iter().flat_map(|band| band.components()).map(|(_, c)| &c.luminance);
    let largest = functions.max_by_key(|function| function.n_values()).expect("a component").clone();
    let (n_values, n_bytes) = (largest.n_values(), largest.n_bytes());
    queries(&alone(largest.clone()).bands[0], &mut figures);
    if let Scattering::Tree(tree) = &largest {
        tables(tree, &mut figures);
    }
    files(bsdf, &mut figures);
    if !as_json {
        println!("{name}: {n_values} values, {:.2} MB", n_bytes as f64 / 1e6);
    }
    for Figure { what, unit, value } in figures.all {
        match as_json {
            true => println!(
                "{{\"on\": {name:?}, \"what\": {what:?}, \"unit\": {unit:?}, \"value\": {value}, \"values\": {n_values}, \
                 \"bytes\": {n_bytes}}}"
            ),
            false => println!("  {what:<32} {value:>10.4} {unit}"),
        }
    }
}

/// Time that this thread has had of the processor \[s\].
fn thread_time() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the place is there; the clock is one that all Unix systems have.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Time of one run \[s\].
fn timed<T>(work: impl FnOnce() -> T) -> f64 {
    let start = thread_time();
    black_box(work());
    thread_time() - start
}

/// The shortest of several runs \[s\].
fn best<T>(mut work: impl FnMut() -> T) -> f64 {
    shortest(|| timed(&mut work))
}

fn shortest(mut run: impl FnMut() -> f64) -> f64 {
    let begin = Instant::now();
    let (mut shortest, mut n) = (f64::INFINITY, 0);
    while n < 9 || (begin.elapsed().as_secs_f64() < 0.5 && n < 10_000) {
        shortest = shortest.min(run());
        n += 1;
    }
    shortest
}

/// Random directions on the front, uniform in projected solid angle, and random numbers.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        // SplitMix64.
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> Direction {
        Side::Front.direction_from_disk(disk_from_square([self.unit(), self.unit()]))
    }
}

/// Figures, measured if they are wanted.
struct Figures {
    only: Option<String>,
    pairs: usize,
    all: Vec<Figure>,
}

impl Figures {
    fn is_wanted(&self, what: &str) -> bool {
        self.only.as_ref().is_none_or(|only| only == what)
    }

    fn add(&mut self, what: &'static str, unit: &'static str, value: impl FnOnce() -> f64) {
        if self.is_wanted(what) {
            let value = value();
            self.all.push(Figure { what, unit, value });
        }
    }

    /// Of as many things as there are pairs in some seconds.
    fn rate(&mut self, what: &'static str, seconds: impl FnOnce() -> f64) {
        let pairs = self.pairs as f64;
        self.add(what, "M/s", || pairs / seconds() / 1e6);
    }
}

fn queries(band: &Band, figures: &mut Figures) {
    let (mut random, n) = (Random(1), figures.pairs);
    let incident: Vec<Direction> = (0..n).map(|_| random.direction()).collect();
    let exitant: Vec<Direction> = (0..n).map(|_| random.direction()).collect();
    let u: Vec<f64> = (0..n).map(|_| random.unit()).collect();
    let mut numbers = vec![0.0; n];
    let black = Sample { exitant: [0.0; 3], pdf: 0.0, weight: 0.0 };
    let mut samples = vec![black; n];
    let pairs = || incident.iter().zip(&exitant);
    figures.rate("eval", || best(|| band.eval_many(&incident, &exitant, &mut numbers)));
    figures.rate("sample, pdf, weight", || {
        best(|| band.sample_many(&incident, &u, None, Lobes::All, &mut samples))
    });
    figures.rate("pdf", || best(|| band.pdf_many(&incident, &exitant, Lobes::All, &mut numbers)));
    figures.rate("hemispherical", || best(|| band.hemispherical_many(&incident, Lobes::All, &mut numbers)));
    figures.rate("projected solid angle", || {
        best(|| band.projected_solid_angle_many(&incident, &exitant, &mut numbers))
    });
    if let Some((_, Component { luminance: Scattering::Tree(tree), .. })) = band.components().next() {
        let mut with =
            |instructions| best(|| tree.eval_many_with(instructions, &incident, &exitant, &mut numbers));
        if Instructions::best() > Instructions::Avx2 {
            figures.rate("eval, AVX2 alone", || with(Instructions::Avx2));
        }
        figures.rate("eval, portable", || with(Instructions::Portable));
    }
    figures.rate("eval, single calls", || best(|| pairs().map(|(&i, &o)| band.eval(i, o)).sum::<f64>()));
    figures.rate("sample, single calls", || {
        best(|| incident.iter().zip(&u).map(|(&i, &u)| band.sample(i, u, None, Lobes::All).pdf).sum::<f64>())
    });
    figures.rate("pdf, single calls", || {
        best(|| pairs().map(|(&i, &o)| band.pdf(i, o, Lobes::All)).sum::<f64>())
    });
    figures.rate("hemispherical, single calls", || {
        best(|| incident.iter().map(|&i| band.hemispherical(i, Lobes::All)).sum::<f64>())
    });
    figures.add("eval, two threads", "×", || {
        gain_of_two(&mut numbers, &|range, numbers| {
            band.eval_many(&incident[range.clone()], &exitant[range], numbers);
        })
    });
    figures.add("sample, two threads", "×", || {
        gain_of_two(&mut samples, &|range, samples| {
            band.sample_many(&incident[range.clone()], &u[range], None, Lobes::All, samples);
        })
    });
}

/// How many times as fast two threads are that share the work, what results they write and for which things, by the longer of
/// their times. Runs of one and of two take turns, so that both have the same neighbours.
fn gain_of_two<T: Send>(results: &mut [T], work: &(dyn Fn(Range<usize>, &mut [T]) + Sync)) -> f64 {
    let n = results.len();
    let mut alone = f64::INFINITY;
    let together = shortest(|| {
        alone = alone.min(timed(|| work(0..n, results)));
        let (first, second) = results.split_at_mut(n / 2);
        std::thread::scope(|threads| {
            let other = threads.spawn(|| timed(|| work(0..n / 2, first)));
            let this = timed(|| work(n / 2..n, second));
            this.max(other.join().expect("no panic"))
        })
    });
    alone / together
}

fn tables(tree: &Tree, figures: &mut Figures) {
    figures.add("all tables", "ms", || {
        1e3 * shortest(|| {
            // What it has made belongs to a tree.
            let tree = tree.clone();
            timed(|| tree.make_tables())
        })
    });
    figures.add("memory of all tables", "MB", || tree.make_tables() as f64 / 1e6);
}

fn files(bsdf: &Bsdf, figures: &mut Figures) {
    let components = bsdf.bands.iter().flat_map(|band| band.components());
    let n_values: usize =
        components.flat_map(|(_, c)| c.functions()).map(|function| function.n_values()).sum();
    let mut text = Vec::new();
    xml::write(bsdf, &mut text).expect("writing to memory");
    let length = text.len() as f64;
    figures.add("XML", "MB", || length / 1e6);
    figures.add("XML read", "MB/s", || {
        length / best(|| xml::read(&text, Strictness::Strict).expect("own file")) / 1e6
    });
    let mut out = Vec::with_capacity(text.len());
    let mut write = || {
        best(|| {
            out.clear();
            xml::write(bsdf, &mut out).expect("writing to memory");
        })
    };
    figures.add("XML write", "MB/s", || length / write() / 1e6);
    figures.add("XML write, values", "M/s", || n_values as f64 / write() / 1e6);
    let bytes = |packing| {
        let mut bytes = Vec::new();
        binary::write(bsdf, packing, &mut bytes).expect("writing to memory");
        bytes
    };
    figures.add("own XML by bsdft", "times", || length / bytes(Packing::Raw).len() as f64);
    figures.add("own XML by bsdft packed at 3", "times", || length / bytes(Packing::Packed(3)).len() as f64);
    figures
        .add("own XML by bsdft packed at 19", "times", || length / bytes(Packing::Packed(19)).len() as f64);
    figures.add("bsdft packed at 3, read", "ms", || {
        let packed = bytes(Packing::Packed(3));
        1e3 * best(|| binary::read(&packed).expect("own file"))
    });
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.bsdft");
    binary::write_file(bsdf, Packing::Raw, &path).expect("a temporary file");
    let (incident, exitant) = ([0.3, 0.2, 0.932_737_905_308_881_5], [0.1, -0.5, 0.860_232_526_704_262_6]);
    figures.add("bsdft opened, first value", "µs", || {
        1e6 * best(|| binary::open(&path).expect("own file").bands[0].eval(incident, exitant))
    });
    figures.add("bsdft verified", "ms", || {
        let opened = binary::open(&path).expect("own file");
        1e3 * best(|| opened.verify())
    });
}
