//! A device to a BSDF: paths from every incident cell, counted by exitant cell, reduced to trees or matrices.
//!
//! In: device and options. Out: the BSDF, its standard errors, a report. Paths are counted in rounds until there are enough; a round of
//! which something is in the checkpoint goes on from there. Invariant: the result is a function of device, options and the
//! number of paths alone.

use std::ops::Range;
use std::time::{Duration, Instant};

use bsdftree::color::xyz_from_rgb;
use bsdftree::tree::TreeError;
use bsdftree::{Bsdf, Header, Part, Rank};
use bsdftree_device::field::FieldError;
use bsdftree_device::{Device, Material};
use glam::DVec3;
use thiserror::Error;

use crate::bands::{Band, Detector, Plain, Spectrometer};
use crate::bvh::BvhError;
use crate::checkpoint::{Checkpoint, CheckpointError, Counted, Job};
use crate::count::Counter;
use crate::counts::{Counts, Spent};
use crate::diffuse::Reuse;
use crate::entrance::Entrance;
use crate::estimate::{Estimator, pyramid};
use crate::geometry;
use crate::layout::Layout;
use crate::options::{Aperture, Options};
use crate::path::Scene;
use crate::progress::{Progress, Resumed};
use crate::pyramid::Pyramid;
use crate::scatter::{Flux, Xyz, is_neutral, is_reciprocal, spectral_range_nm};
use crate::schedule::{Stop, affordable, round_after};
use crate::spectra::{REACH_NM, VISIBLE_NM};
use crate::tally::Exit;
use crate::tile::Tile;
use crate::totals::Totals;

/// Most memory that counted paths may take \[byte\].
const MAX_BYTES: u64 = 8 << 30;

/// Why there is no BSDF.
#[derive(Debug, Error)]
pub enum GenerateError {
    /// The device cannot be traced.
    #[error("{0}")]
    Device(#[from] BvhError),
    /// An option has no meaning.
    #[error("cannot generate with {0}")]
    Option(String),
    /// The device, seen from the front, is a line or a point.
    #[error(
        "the device has no extent along {0}; turn it to face +Z (--up, or xform in the scene), or give the aperture that it stands for (--dim)"
    )]
    Flat(char),
    /// The device is to be repeated, but nobody said how.
    #[error(
        "nothing says with which period this device repeats; give the box that repeats as its aperture (--dim)"
    )]
    NotPeriodic,
    /// Counting the paths could take more memory than allowed.
    #[error("counting more than {samples} paths in each of {cells} incident cells can take {gib:.1} GiB; at most {max} are allowed: lower the samples or the resolution", max = MAX_BYTES >> 30)]
    Memory {
        /// Paths per cell.
        samples: u64,
        /// Incident cells.
        cells: u64,
        /// Memory needed.
        gib: f64,
    },
    /// A function of the device failed.
    #[error("{0}")]
    Function(FieldError),
    /// What was counted cannot be kept, or is of another generation.
    #[error("{0}")]
    Checkpoint(#[from] CheckpointError),
    /// [`Progress::cancel`] was called.
    #[error("cancelled")]
    Cancelled,
    /// The result is not a legal tree.
    #[error("{0}")]
    Tree(#[from] TreeError),
    /// The result is not a legal matrix.
    #[error("{0}")]
    Matrix(String),
    /// The threads could not be started.
    #[error("cannot start threads: {0}")]
    Threads(String),
}

/// What a generation did.
#[derive(Clone, Debug)]
pub struct Report {
    /// Paths followed.
    pub paths: u64,
    /// Paths per incident cell and side.
    pub samples: u64,
    /// Why there were no more.
    pub stop: Stop,
    /// The largest [error](BandReport::error) of a band.
    pub error: f64,
    /// The largest [error of a direction](BandReport::direction_error) in a band.
    pub direction_error: f64,
    /// Hemispherical totals of each incident cell in the first band, and their standard errors.
    pub totals: Vec<Totals>,
    /// What is known of each band.
    pub bands: Vec<BandReport>,
    /// Paths that never ended, which are missing from the result.
    pub lost: u64,
    /// Time spent following paths.
    pub tracing: Duration,
    /// Time spent reducing them.
    pub reducing: Duration,
    /// The box that stood for the device.
    pub aperture: Aperture,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// What is known of a band.
#[derive(Clone, Debug)]
pub struct BandReport {
    /// As in the file.
    pub name: String,
    /// Estimated Σ|error| / Σ BSDF over all finest cells (of a matrix: weighted by projected solid angles).
    pub error: f64,
    /// The largest error of a hemispherical total of an incident cell (95 %, or what the tree departs from what was
    /// counted), relative to the total, or to 0.1 if that is more.
    pub direction_error: f64,
    /// Hemispherical totals of each incident cell, and their standard errors.
    pub totals: Vec<Totals>,
}

/// A BSDF and how well it is known.
#[derive(Clone, Debug)]
pub struct Generated {
    /// The BSDF.
    pub bsdf: Bsdf,
    /// The standard error of each of its values, in trees or matrices of the same form. ±2.36 of them is an interval of 95 %.
    pub errors: Bsdf,
    /// What was done.
    pub report: Report,
}

/// Generates the BSDF of a device.
///
/// # Errors
/// See [`GenerateError`].
pub fn generate(device: &Device, options: &Options, progress: &Progress) -> Result<Generated, GenerateError> {
    if let Some(problem) = options.problem() {
        return Err(GenerateError::Option(problem));
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads.unwrap_or(0))
        .build()
        .map_err(|e| GenerateError::Threads(e.to_string()))?;
    pool.install(|| match by_wavelengths(device, options) {
        false => by_rgb(device, options, progress),
        true if options.color => {
            let xyz: fn(Xyz) -> [f64; 3] = |xyz| xyz.0.to_array();
            let detector = Spectrometer::new(&options.bands).ok_or_else(|| no_wavelengths(options))?;
            Generator::new(device, options, progress, detector, Some(xyz))?.run(device)
        }
        true => {
            let detector = Spectrometer::<f64>::new(&options.bands).ok_or_else(|| no_wavelengths(options))?;
            Generator::new(device, options, progress, detector, None)?.run(device)
        }
    })
}

fn by_rgb(device: &Device, options: &Options, progress: &Progress) -> Result<Generated, GenerateError> {
    // Luminances multiply only where no two factors are coloured.
    let neutral = device.materials.iter().all(|m| is_neutral(&m.material));
    if neutral && !options.color {
        Generator::new(device, options, progress, Plain::<f64>::new(), None)?.run(device)
    } else {
        let xyz: fn(DVec3) -> [f64; 3] = |rgb| xyz_from_rgb(rgb.to_array());
        let xyz = options.color.then_some(xyz);
        Generator::new(device, options, progress, Plain::<DVec3>::new(), xyz)?.run(device)
    }
}

/// Whether paths have to carry spectra: there are some, or what is asked for does not follow from RGB.
fn by_wavelengths(device: &Device, options: &Options) -> bool {
    let own = |band: &Band| band.is_visible() || options.own_band;
    !options.bands.iter().all(own)
        || device.materials.iter().any(|m| spectral_range_nm(&m.material).is_some())
}

fn no_wavelengths(options: &Options) -> GenerateError {
    let names: Vec<_> = options.bands.iter().map(Band::name).collect();
    GenerateError::Option(format!(
        "spectra of materials in the bands {}; of one of them the wavelengths are not known",
        names.join(", ")
    ))
}

struct Generator<'a, D: Detector> {
    counter: Counter<'a, D>,
    options: &'a Options,
    checkpoint: Option<Checkpoint>,
    reciprocity: bool,
    /// Of what is counted in the visible band, where colour is asked for.
    xyz: Option<fn(D::Flux) -> [f64; 3]>,
}

/// A round, and whether it has to be the last.
struct Next {
    round: Range<u64>,
    last: bool,
}

impl<'a, D: Detector> Generator<'a, D> {
    fn new(
        device: &Device,
        options: &'a Options,
        progress: &'a Progress,
        detector: D,
        xyz: Option<fn(D::Flux) -> [f64; 3]>,
    ) -> Result<Self, GenerateError> {
        let scene = Scene::<D::Light>::new(device)?;
        let aperture = match (options.aperture, options.tile) {
            (Some(aperture), _) => aperture,
            (None, false) => bounding_box(device)?,
            (None, true) => {
                let [min, max] = device.tile.ok_or(GenerateError::NotPeriodic)?.map(|p| p.to_array());
                Aperture { min, max }
            }
        };
        let tile = options.tile.then(|| Tile::new(aperture));
        let reciprocity = options.reciprocity.unwrap_or_else(|| is_symmetric(device, options, &aperture));
        let entrance = Entrance::new(device, &aperture, tile.as_ref());
        let reuse = match options.reuse {
            true => Reuse::new(&scene, device, options, &entrance, tile.as_ref()),
            false => None,
        };
        let counted = Counted { spectral: D::SPECTRAL, n_channels: D::Flux::CHANNELS };
        let job = |n_sites| Job::new(device, options, &entrance, counted, n_sites);
        let checkpoint = match &options.checkpoint {
            Some(directory) => Some(Checkpoint::open(directory, &job(reuse.as_ref().map(Reuse::n_sites)))?),
            None => None,
        };
        let counter = Counter { detector, scene, options, aperture, entrance, tile, reuse, progress };
        Ok(Generator { counter, options, checkpoint, reciprocity, xyz })
    }

    fn run(&self, device: &Device) -> Result<Generated, GenerateError> {
        let begin = Instant::now();
        let options = self.options;
        let mut counts = self.counter.nothing();
        let mut samples = 0;
        let mut spent = Spent::default();
        let mut reducing = Duration::ZERO;
        let (stop, estimated) = loop {
            // Reducing takes longer the more was counted.
            let left = options
                .time_budget
                .map(|budget| budget.saturating_sub(begin.elapsed()).saturating_sub(2 * reducing));
            let Some(Next { round, last }) = self.next(samples, spent, left)? else {
                break (Stop::Time, None);
            };
            // What was begun was found to fit.
            if let Some(gib) = self.gib_after(&counts, &round).filter(|_| !self.has(&round)) {
                if samples > 0 && (options.tolerance.is_some() || options.time_budget.is_some()) {
                    break (Stop::Memory, None);
                }
                let cells = options.layout.n_incident() as u64;
                return Err(GenerateError::Memory { samples, cells, gib });
            }
            spent = self.count(&mut counts, &round, spent)?;
            samples = round.end;
            if samples == options.samples {
                break (Stop::Samples, None);
            }
            if last {
                break (Stop::Time, None);
            }
            // What was counted after this round was counted because this round was not enough.
            let enough = !self.has(&round_after(samples, options.samples));
            if enough
                && (options.tolerance.is_some() || (options.time_budget.is_some() && reducing.is_zero()))
            {
                let started = Instant::now();
                let estimated = self.estimated(&counts, samples)?;
                reducing = started.elapsed();
                let reached = |tolerance: f64| {
                    largest(&estimated.bands, |band| band.error) <= tolerance
                        && largest(&estimated.bands, |band| band.direction_error)
                            <= options.direction_tolerance
                };
                if options.tolerance.is_some_and(reached) {
                    break (Stop::Tolerance, Some(estimated));
                }
            }
        };
        if self.checkpoint.is_some() {
            // Said unless it was said before.
            let all = Resumed { samples, round_end: samples, share: 0.0, n_dropped: 0 };
            self.counter.progress.resume(Some(all));
        }
        let started = Instant::now();
        let Results { bsdf, errors, bands } = match estimated {
            Some(estimated) => estimated,
            None => self.estimated(&counts, samples)?,
        };
        let (mut bsdf, mut warnings) = (bsdf, self.warnings(device, spent.lost));
        if options.geometry {
            let aperture = &self.counter.aperture;
            warnings.extend(geometry::put(&mut bsdf.header, device, options.unit, aperture, options.tile));
        }
        let report = Report {
            paths: self.counter.paths(samples),
            samples,
            stop,
            error: largest(&bands, |band| band.error),
            direction_error: largest(&bands, |band| band.direction_error),
            totals: bands[0].totals.clone(),
            bands,
            lost: spent.lost,
            tracing: Duration::from_secs_f64(spent.seconds),
            reducing: reducing.max(started.elapsed()),
            aperture: self.counter.aperture,
            warnings,
        };
        Ok(Generated { bsdf, errors, report })
    }

    /// What to count after `samples` paths on which so much was spent, if there is time `left` for it.
    fn next(
        &self,
        samples: u64,
        spent: Spent,
        left: Option<Duration>,
    ) -> Result<Option<Next>, GenerateError> {
        let whole = round_after(samples, self.options.samples);
        if samples == 0 {
            let base = self.checkpoint.as_ref().map(|kept| kept.base(self.options.samples)).transpose()?;
            return Ok(Some(Next { round: base.flatten().unwrap_or(whole), last: false }));
        }
        let Some(left) = left.filter(|_| !self.has(&whole)) else {
            return Ok(Some(Next { round: whole, last: false }));
        };
        let seconds = Duration::from_secs_f64(spent.seconds);
        let end = affordable(samples, seconds, left).unwrap_or(samples).min(whole.end);
        // What was cut short earlier is as good as what would be cut shorter now.
        let cut = self.checkpoint.as_ref().map(|kept| kept.cut(samples)).transpose()?.flatten();
        let end = end.max(cut.filter(|&cut| cut <= whole.end).unwrap_or(samples));
        let next = Next { round: samples..end, last: end < whole.end };
        Ok((end > samples).then_some(next))
    }

    fn has(&self, round: &Range<u64>) -> bool {
        self.checkpoint.as_ref().is_some_and(|kept| kept.has(round))
    }

    /// Counts a round, or what is not in the checkpoint of it; returns what was spent on all of them.
    fn count(
        &self,
        counts: &mut Counts<D::Flux>,
        round: &Range<u64>,
        before: Spent,
    ) -> Result<Spent, GenerateError> {
        let counter = &self.counter;
        let total = match self.options.tolerance.is_some() || self.options.time_budget.is_some() {
            true => round.end,
            false => self.options.samples,
        };
        counter.progress.begin(counter.paths(total), counter.paths(round.start));
        let mut file = self.checkpoint.as_ref().map(|kept| kept.round(round)).transpose()?;
        let spent = before + counter.count(counts, file.as_mut(), round)?;
        if let (Some(kept), Some(file)) = (&self.checkpoint, file) {
            file.sync()?;
            kept.complete(round, &counter.slots(counts), spent)?;
        }
        Ok(spent)
    }

    /// Memory that a round may take, if that is too much.
    fn gib_after(&self, counts: &Counts<D::Flux>, round: &Range<u64>) -> Option<f64> {
        // A round can hold as much again as what there is.
        let exits = match round.start {
            0 => {
                let paths = self.counter.paths(round.end.min(self.options.layout.n_exitant() as u64));
                paths * self.options.bands.len() as u64
            }
            _ => 2 * counts.n_exits(),
        };
        let bytes = exits * size_of::<Exit<D::Flux>>() as u64;
        (bytes > MAX_BYTES).then(|| bytes as f64 / (1u64 << 30) as f64)
    }

    fn warnings(&self, device: &Device, lost: u64) -> Vec<String> {
        let mut warnings = device.warnings.clone();
        if D::SPECTRAL {
            warnings.extend(unknown_light(device, &self.options.bands));
        }
        if lost > 0 {
            warnings.push(format!("{lost} paths were trapped in the device and are missing"));
        }
        for name in self.counter.scene.faults().too_bright() {
            warnings.push(format!("material '{name}' sends out more light than it gets where its patterns make it brighter than white"));
        }
        if self.counter.aperture.max[2] > 1e-5 {
            warnings.push(format!(
                "the device reaches {:.4} m into the room (z > 0)",
                self.counter.aperture.max[2]
            ));
        }
        warnings
    }

    fn header(&self) -> Header {
        let Aperture { min, max } = self.counter.aperture;
        Header {
            name: "Device".into(),
            manufacturer: "Manufacturer".into(),
            thickness: Some((-min[2]).max(0.0)),
            width: Some(max[0] - min[0]),
            height: Some(max[1] - min[1]),
            unit: self.options.unit,
            ..Header::default()
        }
    }

    fn estimated(&self, counts: &Counts<D::Flux>, samples: u64) -> Result<Results, GenerateError> {
        let Counter { reuse, detector, .. } = &self.counter;
        let model = reuse.as_ref().zip(counts.laid.as_ref());
        let model = model.map(|(reuse, laid)| reuse.model(&self.counter.walker(reuse), laid, samples));
        let nothing = || Bsdf { header: self.header(), ..Bsdf::default() };
        let mut results = Results { bsdf: nothing(), errors: nothing(), bands: Vec::new() };
        for (k, (band, counted)) in self.options.bands.iter().zip(&counts.counted).enumerate() {
            let xyz = self.xyz.filter(|_| band.is_visible());
            let model =
                model.as_ref().map(|model| move |part| pyramid(model, part, detector, k, xyz.is_some()));
            let estimator = Estimator {
                options: self.options,
                band: band.name(),
                model: model.as_ref().map(|model| model as &dyn Fn(Part) -> Pyramid),
                n_diffused: Reuse::paths(&(0..samples)).end as f64,
                reciprocity: self.reciprocity,
                xyz,
                n: samples as f64,
            };
            let estimated = estimator.estimated(counted)?;
            results.bsdf.bands.push(estimated.band);
            results.errors.bands.push(estimated.errors);
            results.bands.push(BandReport {
                name: band.name().into(),
                error: estimated.error,
                direction_error: estimated.direction_error,
                totals: estimated.totals,
            });
        }
        Ok(results)
    }
}

/// What follows from all that was counted.
struct Results {
    bsdf: Bsdf,
    /// Standard errors, in the same form.
    errors: Bsdf,
    bands: Vec<BandReport>,
}

/// Says of which materials less is known than bands ask for.
fn unknown_light(device: &Device, bands: &[Band]) -> Vec<String> {
    let asked = bands.iter().map(Band::range_nm).fold(VISIBLE_NM, |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let names = |which: &dyn Fn(&Material) -> bool| {
        let mut names: Vec<&str> =
            device.materials.iter().filter(|m| which(&m.material)).map(|m| m.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        (!names.is_empty()).then(|| shortened(&names))
    };
    let has_rgb = |material: &Material| {
        asked != VISIBLE_NM
            && !matches!(material, Material::Void | Material::Black)
            && spectral_range_nm(material).is_none()
    };
    // At the ends of the visible range little is missing.
    let needed = [
        if asked[0] < VISIBLE_NM[0] { asked[0] } else { REACH_NM[0] },
        if asked[1] > VISIBLE_NM[1] { asked[1] } else { REACH_NM[1] },
    ];
    let is_short = |material: &Material| {
        spectral_range_nm(material).is_some_and(|[from, to]| from > needed[0] || to < needed[1])
    };
    let [from, to] = asked;
    let grey = names(&has_rgb).map(|names| {
        format!("no spectrum says what {names} are beyond the visible range (380 to 780 nm): there taken as grey of the same luminance")
    });
    let short = names(&is_short).map(|names| {
        format!("spectra of {names} do not reach from {from} to {to} nm: beyond, they go on if they reach to 400 or 700 nm, and else are 0")
    });
    grey.into_iter().chain(short).collect()
}

/// Names, or the first of many.
fn shortened(names: &[&str]) -> String {
    const MOST: usize = 8;
    match names.len() {
        0..=MOST => names.join(", "),
        n => format!("{} and {} more", names[..MOST].join(", "), n - MOST),
    }
}

fn largest(bands: &[BandReport], of: impl Fn(&BandReport) -> f64) -> f64 {
    bands.iter().map(of).fold(0.0, f64::max)
}

/// Whether light sent back comes back as it went: materials are reciprocal, and no light leaves beside the aperture that it could
/// not come in by.
fn is_symmetric(device: &Device, options: &Options, aperture: &Aperture) -> bool {
    let Aperture { min, max } = aperture;
    let is_flat = max[2] - min[2] <= 1e-6 * (max[0] - min[0]).min(max[1] - min[1]);
    let is_all =
        device.bounds().is_some_and(|[low, high]| (0..3).all(|k| min[k] <= low[k] && high[k] <= max[k]));
    !matches!(options.layout, Layout::Tree { rank: Rank::Three, .. })
        && device.materials.iter().all(|m| is_reciprocal(&m.material))
        && (options.tile || (is_flat && is_all))
}

fn bounding_box(device: &Device) -> Result<Aperture, GenerateError> {
    let [min, max] = device.bounds().ok_or(BvhError::NothingToHit { n_surfaces: device.surfaces.len() })?;
    for (k, name) in ['X', 'Y'].into_iter().enumerate() {
        if max[k] <= min[k] {
            return Err(GenerateError::Flat(name));
        }
    }
    Ok(Aperture { min: min.to_array(), max: max.to_array() })
}
