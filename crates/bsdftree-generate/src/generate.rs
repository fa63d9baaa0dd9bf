//! A device to a BSDF: paths from every incident cell, counted by exitant cell, reduced to trees or matrices.
//!
//! The unit of work is an incident cell of one side. Its paths are numbered, and everything random about one follows
//! from (seed, cell, number), so the result has the same bits whatever the number of threads.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bsdftree::color::xyz_from_rgb;
use bsdftree::tree::TreeError;
use bsdftree::{Bsdf, Component, Header, Matrix, Part, Scattering, Side};
use bsdftree_device::Device;
use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

use crate::bvh::BvhError;
use crate::layout::Layout;
use crate::options::{Aperture, Options};
use crate::path::{Outcome, Scene};
use crate::progress::Progress;
use crate::random::{Random, Stratified};
use crate::reciprocity;
use crate::reduce::reduce;
use crate::scatter::{Spectrum, is_neutral};
use crate::tally::{Row, Tally};
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
    #[error("counting {samples} paths in each of {cells} incident cells can take {gib:.1} GiB; at most {max} are allowed: lower the samples or the resolution", max = MAX_BYTES >> 30)]
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

/// Generates the BSDF of a device.
///
/// # Errors
/// See [`GenerateError`].
pub fn generate(
    device: &Device,
    options: &Options,
    progress: &Progress,
) -> Result<(Bsdf, Report), GenerateError> {
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
    xyz: Option<fn(S) -> [f64; 3]>,
}

/// Counted paths of one side: reflected and transmitted rows, and how many were lost.
struct Traced<S> {
    rows: [Vec<Row<S>>; 2],
    lost: u64,
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
        let layout = &options.layout;
        let (cells, kept) = (layout.n_incident() as u64, options.samples.min(layout.n_exitant() as u64));
        let bytes =
            cells * options.sides.iter().count() as u64 * kept * size_of::<crate::tally::Exit<S>>() as u64;
        if bytes > MAX_BYTES {
            let gib = bytes as f64 / (1u64 << 30) as f64;
            return Err(GenerateError::Memory { samples: options.samples, cells, gib });
        }
        Ok(Generator { scene, options, aperture, tile, progress, xyz })
    }

    fn run(&self, device: &Device) -> Result<(Bsdf, Report), GenerateError> {
        let begin = Instant::now();
        let n_sides = self.options.sides.iter().count() as u64;
        let paths = n_sides * self.options.layout.n_incident() as u64 * self.options.samples;
        self.progress.begin(paths);
        let mut traced = Vec::new();
        for side in self.options.sides.iter() {
            traced.push((side, self.trace(side)?));
        }
        let tracing = begin.elapsed();
        let begin = Instant::now();
        let lost = traced.iter().map(|(_, t)| t.lost).sum();
        let mut bsdf = Bsdf { header: self.header(), ..Bsdf::default() };
        let components = self.components(traced);
        let headroom = [Side::Front, Side::Back].map(|side| self.headroom(&components, side));
        for (part, rows) in components {
            let headroom = &headroom[usize::from(part.incident_side() == Side::Back)];
            bsdf.band_mut("Visible").insert(part, self.component(&rows, headroom)?);
        }
        if self.options.reciprocity && matches!(self.options.layout, Layout::Klems(_)) {
            crate::klems::make_reciprocal(bsdf.band_mut("Visible")).map_err(GenerateError::Matrix)?;
        }
        let warnings = self.warnings(device, lost);
        let report =
            Report { paths, lost, tracing, reducing: begin.elapsed(), aperture: self.aperture, warnings };
        Ok((bsdf, report))
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

    fn trace(&self, side: Side) -> Result<Traced<S>, GenerateError> {
        let layout = &self.options.layout;
        let cells: Vec<_> = (0..layout.n_incident())
            .into_par_iter()
            .map_init(
                || [0; 2].map(|_| Tally::new(layout.n_exitant())),
                |tallies, cell| {
                    if self.progress.is_cancelled() {
                        return Err(GenerateError::Cancelled);
                    }
                    let lost = self.trace_cell(side, cell, tallies);
                    self.progress.add(self.options.samples);
                    let [reflected, transmitted] = tallies;
                    Ok((reflected.drain(), transmitted.drain(), lost))
                },
            )
            .collect::<Result<_, _>>()?;
        let mut traced = Traced { rows: [Vec::new(), Vec::new()], lost: 0 };
        for (reflected, transmitted, lost) in cells {
            traced.rows[0].push(reflected);
            traced.rows[1].push(transmitted);
            traced.lost += lost;
        }
        Ok(traced)
    }

    fn trace_cell(&self, side: Side, cell: usize, [reflected, transmitted]: &mut [Tally<S>; 2]) -> u64 {
        let layout = &self.options.layout;
        let Aperture { min, max } = self.aperture;
        let z = if side == Side::Front { max[2] } else { min[2] };
        // Starting a little before the plane of the aperture, a ray meets also what lies in that plane.
        let margin = 1e-6 * (max[0] - min[0]).min(max[1] - min[1]);
        let stream = (cell as u64) << 1 | u64::from(side == Side::Back);
        let stratified = Stratified::new(self.options.seed, stream);
        let mut lost = 0;
        for sample in 0..self.options.samples {
            let [u, v, s, t] = stratified.point(sample);
            let disk = layout.incident_disk(cell, u, v);
            let toward = side.opposite().direction_from_disk(disk);
            let direction = DVec3::from_array(toward);
            let place = DVec3::new(min[0] + s * (max[0] - min[0]), min[1] + t * (max[1] - min[1]), z);
            let mut random = Random::new(self.options.seed, stream, sample);
            match self.scene.follow(place - direction * margin, direction, self.tile.as_ref(), &mut random) {
                Outcome::Left(exitant, weight) => {
                    let tally = if Side::of(exitant.to_array()) == side {
                        &mut *reflected
                    } else {
                        &mut *transmitted
                    };
                    tally.add(layout.exitant_cell(disk, [exitant.x, exitant.y]), weight);
                }
                Outcome::Absorbed => {}
                Outcome::Lost => lost += 1,
            }
        }
        lost
    }

    /// The rows of each part, averaged with what travelled the other way if that is asked for.
    fn components(&self, traced: Vec<(Side, Traced<S>)>) -> Vec<(Part, Vec<Row<S>>)> {
        let mut parts = Vec::new();
        for (side, Traced { rows: [reflected, transmitted], .. }) in traced {
            parts.push((Part::between(side, side), reflected));
            parts.push((Part::between(side, side.opposite()), transmitted));
        }
        if self.options.reciprocity && matches!(self.options.layout, Layout::Tree { .. }) {
            let n = self.options.samples;
            for (_, rows) in parts.iter_mut().filter(|(part, _)| part.is_reflection()) {
                *rows = reciprocity::averaged(rows, rows, n);
            }
            if let [_, (_, a), _, (_, b)] = parts.as_mut_slice() {
                (*a, *b) = (reciprocity::averaged(a, b, n), reciprocity::averaged(b, a, n));
            }
        }
        parts
    }

    /// The part of the light from each incident cell of a side that did not leave the device.
    fn headroom(&self, components: &[(Part, Vec<Row<S>>)], side: Side) -> Vec<f64> {
        let mut headroom = vec![1.0; self.options.layout.n_incident()];
        for (_, rows) in components.iter().filter(|(part, _)| part.incident_side() == side) {
            for (room, row) in headroom.iter_mut().zip(rows) {
                let left: f64 = row.iter().map(|exit| exit.sum.luminance()).sum();
                *room -= left / self.options.samples as f64;
            }
        }
        headroom
    }

    fn component(&self, rows: &[Row<S>], headroom: &[f64]) -> Result<Component, GenerateError> {
        let n = self.options.samples;
        match &self.options.layout {
            Layout::Tree { rank, log2_res } => {
                let reduced = reduce(*rank, *log2_res, rows, n, headroom, self.options.pruned, self.xyz)?;
                let chroma = reduced.chroma.map(|trees| trees.map(Scattering::from));
                Ok(Component { luminance: reduced.luminance.into(), chroma })
            }
            Layout::Klems(basis) => {
                let matrix = |value: &dyn Fn(S) -> f64| {
                    let mut values = vec![0.0f32; basis.n_patches() * basis.n_patches()];
                    for (row, cells) in values.chunks_exact_mut(basis.n_patches()).zip(rows) {
                        for exit in cells {
                            let k = exit.cell as usize;
                            row[k] =
                                (value(exit.sum) / (n as f64 * self.options.layout.exitant_area(k))) as f32;
                        }
                    }
                    Matrix::new(Arc::clone(basis), Arc::clone(basis), values)
                        .map(Scattering::from)
                        .map_err(GenerateError::Matrix)
                };
                let chroma = match self.xyz {
                    None => None,
                    Some(xyz) => Some([matrix(&|s| xyz(s)[0])?, matrix(&|s| xyz(s)[2])?]),
                };
                Ok(Component { luminance: matrix(&|s| s.luminance())?, chroma })
            }
        }
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
