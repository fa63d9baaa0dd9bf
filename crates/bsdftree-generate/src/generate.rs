//! A device to a BSDF: paths from every incident cell, counted by exitant cell, reduced to trees or matrices.
//!
//! The unit of work is an incident cell of one side. Its paths are numbered, and everything random about one follows
//! from (seed, cell, number), so the result has the same bits whatever the number of threads.

use std::ops::Range;
use std::time::{Duration, Instant};

use bsdftree::color::xyz_from_rgb;
use bsdftree::tree::TreeError;
use bsdftree::{Bsdf, Header, Rank, Side};
use bsdftree_device::Device;
use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

use crate::bvh::BvhError;
use crate::diffuse::{Laid, Reuse, SideRows, mean_of};
use crate::estimate::{Counted, Estimated, Estimator};
use crate::layout::Layout;
use crate::options::{Aperture, Options};
use crate::path::{Outcome, Scene};
use crate::progress::Progress;
use crate::random::{N_REPLICATES, Start, Stratified};
use crate::scatter::{Spectrum, is_neutral, is_reciprocal};
use crate::schedule::{Stop, affordable, round_after};
use crate::tally::{Exit, Row, Tally, added};
use crate::tile::Tile;

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
    #[error("the device has no extent along {0}; give the aperture that it stands for (--dim)")]
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
    /// Estimated Σ|error| / Σ BSDF over all finest cells (of a matrix: weighted by projected solid angles).
    pub error: f64,
    /// The largest error of a hemispherical total of an incident cell (95 %, or what the tree departs from what was
    /// counted), relative to the total, or to 0.1 if that is more.
    pub direction_error: f64,
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
    // Luminances multiply only where no two factors are coloured.
    let neutral = device.materials.iter().all(|m| is_neutral(&m.material));
    pool.install(|| {
        if neutral && !options.color {
            Generator::<f64>::new(device, options, progress, None)?.run(device)
        } else {
            let xyz: fn(DVec3) -> [f64; 3] = |rgb| xyz_from_rgb(rgb.to_array());
            Generator::<DVec3>::new(device, options, progress, options.color.then_some(xyz))?.run(device)
        }
    })
}

struct Generator<'a, S> {
    scene: Scene<S>,
    options: &'a Options,
    aperture: Aperture,
    tile: Option<Tile>,
    progress: &'a Progress,
    reciprocity: bool,
    reuse: Option<Reuse>,
    xyz: Option<fn(S) -> [f64; 3]>,
}

/// All that was counted.
struct Counts<S> {
    /// By side asked for.
    counted: Vec<Counted<S>>,
    /// What was laid down by walks from the front and from the back.
    laid: Option<[SideRows; 2]>,
}

impl<'a, S: Spectrum> Generator<'a, S> {
    fn new(
        device: &Device,
        options: &'a Options,
        progress: &'a Progress,
        xyz: Option<fn(S) -> [f64; 3]>,
    ) -> Result<Self, GenerateError> {
        let scene = Scene::new(device)?;
        let aperture = match (options.aperture, options.tile) {
            (Some(aperture), _) => aperture,
            (None, false) => bounding_box(device)?,
            (None, true) => {
                let [min, max] = device.tile.ok_or(GenerateError::NotPeriodic)?.map(|p| p.to_array());
                Aperture { min, max }
            }
        };
        let tile = options.tile.then(|| Tile::new(aperture));
        let possible = !matches!(options.layout, Layout::Tree { rank: Rank::Three, .. })
            && device.materials.iter().all(|m| is_reciprocal(&m.material));
        let reciprocity = options.reciprocity.unwrap_or(possible);
        let reuse = match options.reuse {
            true => Reuse::new(&scene, device, options, &aperture, tile.as_ref()),
            false => None,
        };
        Ok(Generator { reuse, scene, options, aperture, tile, progress, reciprocity, xyz })
    }

    fn run(&self, device: &Device) -> Result<Generated, GenerateError> {
        let begin = Instant::now();
        let options = self.options;
        let mut counts = self.nothing();
        let (mut samples, mut lost) = (0, 0);
        let (mut tracing, mut reducing) = (Duration::ZERO, Duration::ZERO);
        let (stop, estimated) = loop {
            let mut round = round_after(samples, options.samples);
            if let Some(budget) = options.time_budget {
                // Reducing takes longer the more was counted.
                let left = budget.saturating_sub(begin.elapsed()).saturating_sub(2 * reducing);
                match samples {
                    0 => {}
                    _ => match affordable(samples, tracing, left) {
                        Some(end) => round.end = round.end.min(end),
                        None => break (Stop::Time, None),
                    },
                }
            }
            if let Some(gib) = self.gib_after(&counts, &round) {
                if samples > 0 && (options.tolerance.is_some() || options.time_budget.is_some()) {
                    break (Stop::Memory, None);
                }
                let cells = options.layout.n_incident() as u64;
                return Err(GenerateError::Memory { samples, cells, gib });
            }
            let started = Instant::now();
            lost += self.count(&mut counts, round.clone())?;
            samples = round.end;
            tracing += started.elapsed();
            if samples == options.samples {
                break (Stop::Samples, None);
            }
            if options.tolerance.is_some() || (options.time_budget.is_some() && reducing.is_zero()) {
                let started = Instant::now();
                let estimated = self.estimated(&counts, samples)?;
                reducing = started.elapsed();
                let reached = |tolerance: f64| {
                    estimated.error <= tolerance && estimated.direction_error <= options.direction_tolerance
                };
                if options.tolerance.is_some_and(reached) {
                    break (Stop::Tolerance, Some(estimated));
                }
            }
        };
        let started = Instant::now();
        let Estimated { bsdf, errors, error, direction_error } = match estimated {
            Some(estimated) => estimated,
            None => self.estimated(&counts, samples)?,
        };
        let report = Report {
            paths: self.paths(samples),
            samples,
            stop,
            error,
            direction_error,
            lost,
            tracing,
            reducing: reducing.max(started.elapsed()),
            aperture: self.aperture,
            warnings: self.warnings(device, lost),
        };
        Ok(Generated { bsdf, errors, report })
    }

    fn nothing(&self) -> Counts<S> {
        let counted = self.options.sides.iter().map(|side| self.nothing_of(side)).collect();
        let laid = |reuse: &Reuse| [(); 2].map(|()| [(); 2].map(|()| vec![Laid::default(); reuse.n_cells()]));
        Counts { counted, laid: self.reuse.as_ref().map(laid) }
    }

    /// Paths of all incident cells: walks from both sides and full paths from those asked for, where diffused light is reused.
    fn paths(&self, samples: u64) -> u64 {
        let n_sides = self.options.sides.iter().count() as u64;
        let each = match self.reuse {
            None => n_sides * samples,
            Some(_) => 2 * samples + n_sides * Reuse::paths(&(0..samples)).end,
        };
        each * self.options.layout.n_incident() as u64
    }

    /// Memory that a round may take, if that is too much.
    fn gib_after(&self, counts: &Counts<S>, round: &Range<u64>) -> Option<f64> {
        let rows = || counts.counted.iter().flat_map(|c| c.rows.iter().chain(&c.diffused)).flatten();
        // A round can hold as much again as what there is.
        let exits = match round.start {
            0 => self.paths(round.end.min(self.options.layout.n_exitant() as u64)),
            _ => 2 * rows().map(|row| row.len() as u64).sum::<u64>(),
        };
        let bytes = exits * size_of::<Exit<S>>() as u64;
        (bytes > MAX_BYTES).then(|| bytes as f64 / (1u64 << 30) as f64)
    }

    fn warnings(&self, device: &Device, lost: u64) -> Vec<String> {
        let mut warnings = device.warnings.clone();
        if lost > 0 {
            warnings.push(format!("{lost} paths were trapped in the device and are missing"));
        }
        if self.aperture.max[2] > 1e-5 {
            warnings.push(format!("the device reaches {:.4} m into the room (z > 0)", self.aperture.max[2]));
        }
        warnings
    }

    fn header(&self) -> Header {
        let Aperture { min, max } = self.aperture;
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

    /// Follows a round of paths from every incident cell and adds them to what was counted; returns how many were lost.
    fn count(&self, counts: &mut Counts<S>, round: Range<u64>) -> Result<u64, GenerateError> {
        let total = match self.options.tolerance.is_some() || self.options.time_budget.is_some() {
            true => round.end,
            false => self.options.samples,
        };
        self.progress.begin(self.paths(total), self.paths(round.start));
        match (&self.reuse, &mut counts.laid) {
            (Some(reuse), Some(laid)) => self.count_reused(reuse, &mut counts.counted, laid, &round),
            _ => self.count_paths(&mut counts.counted, &round),
        }
    }

    fn tallies(&self) -> [Tally<S>; 2] {
        [(); 2].map(|()| Tally::new(self.options.layout.n_exitant()))
    }

    fn count_paths(&self, counted: &mut [Counted<S>], round: &Range<u64>) -> Result<u64, GenerateError> {
        let mut lost = 0;
        for Counted { side, rows: [reflected, transmitted], .. } in counted {
            let cells = reflected.par_iter_mut().zip(transmitted).enumerate();
            lost += cells
                .map_init(
                    || self.tallies(),
                    |tallies, (cell, rows)| {
                        self.check_cancelled()?;
                        let lost = self.count_cell(*side, cell, round.clone(), tallies);
                        self.progress.add(round.end - round.start);
                        drain([rows.0, rows.1], tallies);
                        Ok::<_, GenerateError>(lost)
                    },
                )
                .try_reduce(|| 0, |a, b| Ok(a + b))?;
        }
        Ok(lost)
    }

    /// As [`count_paths`](Self::count_paths), of walks that are never diffused, and of full paths that are.
    fn count_reused(
        &self,
        reuse: &Reuse,
        counted: &mut [Counted<S>],
        laid: &mut [SideRows; 2],
        round: &Range<u64>,
    ) -> Result<u64, GenerateError> {
        let walker = reuse.walker(&self.scene, self.tile.as_ref(), &self.options.layout, self.options.seed);
        // Incident cells in one cell of the model.
        let group = self.options.layout.n_incident() / reuse.n_cells();
        let mut lost = 0;
        for (side, [first, second]) in [Side::Front, Side::Back].into_iter().zip(laid) {
            // Light from a side that is not asked for is wanted only for where it is laid down.
            let mut unwanted = self.nothing_of(side);
            let wanted = counted.iter_mut().find(|c| c.side == side);
            let keep = wanted.is_some();
            let Counted { rows: [reflected, transmitted], diffused: [r, t], .. } =
                wanted.unwrap_or(&mut unwanted);
            let rows = reflected.par_chunks_mut(group).zip(transmitted.par_chunks_mut(group));
            let diffused = r.par_chunks_mut(group).zip(t.par_chunks_mut(group));
            let halves = first.par_iter_mut().zip(second);
            lost += rows
                .zip(diffused)
                .zip(halves)
                .enumerate()
                .map_init(
                    || (self.tallies(), reuse.deposits()),
                    |(tallies, deposits), (block, ((rows, diffused), halves))| {
                        self.check_cancelled()?;
                        let mut lost = 0;
                        for k in 0..group {
                            let cell = block * group + k;
                            lost += walker.count_walks(side, cell, round, tallies, deposits);
                            let mut done = round.end - round.start;
                            if keep {
                                drain([&mut rows.0[k], &mut rows.1[k]], tallies);
                                lost += walker.count_diffused(side, cell, round, tallies);
                                drain([&mut diffused.0[k], &mut diffused.1[k]], tallies);
                                done += Reuse::paths(round).count() as u64;
                            } else {
                                tallies.iter_mut().for_each(|tally| drop(tally.drain()));
                            }
                            self.progress.add(done);
                        }
                        for (row, deposits) in [halves.0, halves.1].into_iter().zip(deposits) {
                            mean_of(row, round.start, &deposits.drain(), round.end - round.start);
                        }
                        Ok::<_, GenerateError>(lost)
                    },
                )
                .try_reduce(|| 0, |a, b| Ok(a + b))?;
        }
        Ok(lost)
    }

    fn nothing_of(&self, side: Side) -> Counted<S> {
        let empty = || [(); 2].map(|()| vec![Row::new(); self.options.layout.n_incident()]);
        Counted { side, rows: empty(), diffused: empty() }
    }

    fn check_cancelled(&self) -> Result<(), GenerateError> {
        if self.progress.is_cancelled() { Err(GenerateError::Cancelled) } else { Ok(()) }
    }

    fn count_cell(
        &self,
        side: Side,
        cell: usize,
        round: Range<u64>,
        [reflected, transmitted]: &mut [Tally<S>; 2],
    ) -> u64 {
        let Options { layout, seed, stratified, .. } = self.options;
        let Aperture { min, max } = self.aperture;
        let z = if side == Side::Front { max[2] } else { min[2] };
        // Starting a little before the plane of the aperture, a ray meets also what lies in that plane.
        let margin = 1e-6 * (max[0] - min[0]).min(max[1] - min[1]);
        let stream = (cell as u64) << 1 | u64::from(side == Side::Back);
        let points = Stratified::new(*seed, stream);
        let mut lost = 0;
        for sample in round {
            let mut start = match stratified {
                true => points.start(*seed, stream, sample),
                false => Start::independent(*seed, stream, sample),
            };
            let [u, v] = start.incident;
            let [s, t] = start.origin;
            let disk = layout.incident_disk(cell, u, v);
            let direction = DVec3::from_array(side.opposite().direction_from_disk(disk));
            let place = DVec3::new(min[0] + s * (max[0] - min[0]), min[1] + t * (max[1] - min[1]), z);
            let origin = place - direction * margin;
            match self.scene.follow(origin, direction, self.tile.as_ref(), &mut start.random) {
                Outcome::Left(exitant, weight) => {
                    let tally = if Side::of(exitant.to_array()) == side {
                        &mut *reflected
                    } else {
                        &mut *transmitted
                    };
                    let replicate = (sample % N_REPLICATES as u64) as usize;
                    tally.add(layout.exitant_cell(disk, [exitant.x, exitant.y]), weight, replicate);
                }
                Outcome::Absorbed => {}
                Outcome::Lost => lost += 1,
            }
        }
        lost
    }

    fn estimated(&self, counts: &Counts<S>, samples: u64) -> Result<Estimated, GenerateError> {
        let (tile, seed) = (self.tile.as_ref(), self.options.seed);
        let model = self.reuse.as_ref().zip(counts.laid.as_ref()).map(|(reuse, laid)| {
            let walker = reuse.walker(&self.scene, tile, &self.options.layout, seed);
            reuse.model(&walker, laid, samples)
        });
        let estimator = Estimator {
            options: self.options,
            model,
            n_diffused: Reuse::paths(&(0..samples)).end as f64,
            reciprocity: self.reciprocity,
            xyz: self.xyz,
            n: samples as f64,
        };
        estimator.estimated(&counts.counted, Bsdf { header: self.header(), ..Bsdf::default() })
    }
}

/// Moves counts to the rows they belong to.
fn drain<S: Spectrum>(rows: [&mut Row<S>; 2], tallies: &mut [Tally<S>; 2]) {
    for (row, tally) in rows.into_iter().zip(tallies) {
        *row = added(std::mem::take(row), tally.drain());
    }
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
