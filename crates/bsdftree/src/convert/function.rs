//! Trees from a function of two directions, refined where it changes.
//!
//! In: a function that takes many pairs of directions at once. Out: trees whose values are its means over cells. A cell is judged by the
//! values at the middles of its children and by what a first look ([`super::scout`]) found in it; it is split where their mean
//! distance from their mean is more than half the tolerance times its own mean or the whole function's. Cells of the finest level
//! that hold something much narrower are split further, up to [`extra_levels`] times, only to take their mean.
//!
//! Source: the function mode of Radiance's bsdf2ttree, which evaluates a full grid and then culls it.

use super::ConvertError;
use super::grow::{Branch, Grower};
use super::scout::{Found, Place, Scout, even_places, ridge_places, star};
use super::{TreeOptions, xyz};
use crate::bsdf::{Band, Bsdf, Component, Part};
use crate::direction::Direction;
use crate::square::disk_from_square;
use crate::tree::{Rank, Tree, child_cell};

/// Level that is always reached.
const BASE: u32 = 3;

/// Levels below the finest, for means only.
fn extra_levels(rank: Rank) -> u32 {
    match rank {
        Rank::Three => 3,
        Rank::Four => 2,
    }
}

/// Cells that are evaluated at once.
const CHUNK: usize = 4096;

/// Spread over mean of a finest cell above which it is split further: what the middles of its children get wrong by a percent or two.
const NARROW: f64 = 0.2;

/// Standard error over mean of places that are scattered, above which more of them are taken.
const UNCERTAIN: f64 = 0.1;

/// Spread over mean below which values in the middle of finest cells are their means, within half a percent or so.
const SMOOTH: f64 = 0.3;

/// How many times brighter than the mean a ridge is looked at closely.
const BRIGHT: f64 = 4.0;

/// What is wrong with a function.
#[derive(Debug)]
pub enum FunctionError<E> {
    /// Options out of range, or a tree too large.
    Convert(ConvertError),
    /// The function itself failed.
    Function(E),
    /// A value that is not a finite number ≥ 0.
    Value {
        /// Where light came from.
        incident: Direction,
        /// Where it went.
        exitant: Direction,
        /// The value \[1/sr\].
        value: f64,
    },
}

impl<E, F: Into<ConvertError>> From<F> for FunctionError<E> {
    fn from(error: F) -> Self {
        FunctionError::Convert(error.into())
    }
}

/// What makes a component: for pairs of directions, one value each \[1/sr\] or X, Y, Z, one pair after the other.
type Evaluate<'a, E> = dyn FnMut(&[Direction], &[Direction], &mut [f64]) -> Result<(), E> + 'a;

impl Bsdf {
    /// A BSDF of the band Visible from a function of incident and exitant direction, for each of `parts`; black ones are left out.
    ///
    /// `f` fills in one value \[1/sr\] (no cosine) for each pair, or with `color` CIE X, Y and Z. At rank 3 the incident directions lie
    /// in the half-plane y = 0, x ≤ 0, and the function is taken to be isotropic.
    ///
    /// # Errors
    /// If the options are out of range, or `f` fails or gives a value that is negative or not finite.
    pub fn from_function<E>(
        mut f: impl FnMut(&[Direction], &[Direction], &mut [f64]) -> Result<(), E>,
        parts: &[Part],
        color: bool,
        options: &TreeOptions,
    ) -> Result<Bsdf, FunctionError<E>> {
        let options = options.validated()?;
        let mut band = Band::new("Visible");
        for &part in parts {
            let n = if color { 3 } else { 1 };
            let mut trees = Refinement::new(&mut f, part, n, options)?.trees()?;
            let luminance = trees.remove(n / 2);
            if luminance.arena().n_nodes() == 0 && luminance.leaves().all(|leaf| leaf.value == 0.0) {
                continue;
            }
            let component = match <[Tree; 2]>::try_from(trees) {
                Ok([x, z]) => xyz::from_channels([x.into(), luminance.into(), z.into()])?,
                Err(_) => Component::grey(luminance.into()),
            };
            band.insert(part, component);
        }
        Ok(Bsdf { bands: vec![band], ..Bsdf::default() })
    }
}

/// A cell.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Lower corner in units of its edge.
    at: [u32; 4],
    /// What the scout found in it.
    found: Found,
}

/// A component being refined.
struct Refinement<'a, E> {
    f: &'a mut Evaluate<'a, E>,
    part: Part,
    /// 1, or 3 for X, Y, Z.
    n_channels: usize,
    options: TreeOptions,
    scout: Scout,
    growers: Vec<Grower>,
    /// Mean of the whole function, all channels together.
    mean: f64,
}

impl<'a, E> Refinement<'a, E> {
    fn new(
        f: &'a mut Evaluate<'_, E>,
        part: Part,
        n_channels: usize,
        options: TreeOptions,
    ) -> Result<Self, FunctionError<E>> {
        let TreeOptions { rank, log2_res, .. } = options;
        let mut values_at = |places: &[Place]| -> Result<Vec<f64>, FunctionError<E>> {
            let mut values = Vec::with_capacity(places.len() * n_channels);
            for chunk in places.chunks(CHUNK * 16) {
                values.extend(evaluate(f, part, rank, n_channels, chunk)?);
            }
            Ok(values)
        };
        let sums = |values: &[f64]| -> Vec<f64> {
            values.chunks_exact(n_channels).map(|of_place| of_place.iter().sum()).collect()
        };
        let mut places = even_places(rank);
        let even = values_at(&places)?;
        let mean_of =
            |channel: usize| even.iter().skip(channel).step_by(n_channels).sum::<f64>() / places.len() as f64;
        let means: Vec<f64> = (0..n_channels).map(mean_of).collect();
        let mut values = sums(&even);
        let ridges = ridge_places(rank, log2_res);
        let heights = sums(&values_at(&ridges)?);
        let bright = BRIGHT * means.iter().sum::<f64>();
        let stars: Vec<Place> = ridges
            .iter()
            .zip(&heights)
            .filter(|&(_, &height)| height > bright)
            .flat_map(|(&ridge, _)| star(rank, log2_res, ridge))
            .collect();
        values.extend(heights);
        values.extend(sums(&values_at(&stars)?));
        places.extend(ridges);
        places.extend(stars);
        let scout = Scout::new(rank, log2_res, &places, &values);
        let growers = means.iter().map(|&mean| Grower::new(options.rank, options.tolerance, mean)).collect();
        let mean = scout.mean();
        Ok(Refinement { f, part, n_channels, options, scout, growers, mean })
    }

    fn trees(mut self) -> Result<Vec<Tree>, FunctionError<E>> {
        let whole = Cell { at: [0; 4], found: self.scout.all() };
        let root = self.refined(0, &[whole])?;
        Ok(self.growers.into_iter().zip(root).map(|(grower, root)| grower.finish(root)).collect())
    }

    /// What becomes of cells of a level: for each, a branch for each channel.
    fn refined(&mut self, level: u32, cells: &[Cell]) -> Result<Vec<Branch>, FunctionError<E>> {
        let mut branches = Vec::with_capacity(cells.len() * self.n_channels);
        for chunk in cells.chunks(CHUNK) {
            self.refined_chunk(level, chunk, &mut branches)?;
        }
        Ok(branches)
    }

    fn refined_chunk(
        &mut self,
        level: u32,
        cells: &[Cell],
        branches: &mut Vec<Branch>,
    ) -> Result<(), FunctionError<E>> {
        let (rank, channels) = (self.options.rank, self.n_channels);
        let n_children = rank.n_children();
        let finest = level == self.options.log2_res + extra_levels(rank);
        // Regular places lie on ridges more often than others do.
        let scattered = level > self.options.log2_res;
        let is_coarse = level < BASE.min(self.options.log2_res);
        let values = if is_coarse {
            Vec::new()
        } else {
            let points: Vec<_> = cells
                .iter()
                .flat_map(|&cell| (0..n_children).map(move |k| point(level, cell.at, k, scattered)))
                .collect();
            evaluate(self.f, self.part, rank, channels, &points)?
        };
        let is_unread = |cell: &Cell| rank == Rank::Three && level > 0 && cell.at[0] >> (level - 1) > 0;
        let of_cell = |k: usize| &values[k * n_children * channels..][..n_children * channels];
        let fate = |k: usize| match () {
            () if is_unread(&cells[k]) || finest => Fate::Leaf,
            () if is_coarse => Fate::Split,
            // Siblings share their fate: if those were left that happened to look dark, light would be lost.
            () if scattered => {
                let first = k - k % n_children;
                self.fate_of_siblings(
                    &values[first * n_children * channels..][..n_children.pow(2) * channels],
                )
            }
            () => self.fate(level, cells[k], of_cell(k)),
        };
        let fates: Vec<Fate> = (0..cells.len()).map(fate).collect();
        let is_asked = |k: usize, child: usize| {
            let judged = !is_coarse && level < self.options.log2_res;
            !(judged && self.is_calm(level + 1, cells[k], of_cell(k), child))
        };
        let asked: Vec<Vec<usize>> = (0..cells.len())
            .map(|k| match fates[k] {
                Fate::Split => (0..n_children).filter(|&child| is_asked(k, child)).collect(),
                _ => Vec::new(),
            })
            .collect();
        let children: Vec<Cell> = cells
            .iter()
            .zip(&asked)
            .flat_map(|(cell, asked)| asked.iter().map(|&child| self.child(level + 1, cell, child)))
            .collect();
        let grown = if children.is_empty() { Vec::new() } else { self.refined(level + 1, &children)? };
        let mut grown = grown.chunks_exact(channels);
        for (k, cell) in cells.iter().enumerate() {
            let below: Vec<&[Branch]> = grown.by_ref().take(asked[k].len()).collect();
            for channel in 0..channels {
                let grower = &mut self.growers[channel];
                branches.push(match fates[k] {
                    Fate::Split => {
                        let children: Vec<_> = (0..n_children)
                            .map(|child| match asked[k].iter().position(|&asked| asked == child) {
                                Some(at) => below[at][channel],
                                None => {
                                    let value = of_cell(k)[child * channels + channel];
                                    grower.leaf(value, level + 1, child_cell(cell.at, child)[0])
                                }
                            })
                            .collect();
                        if level >= self.options.log2_res {
                            grower.blend(&children)
                        } else {
                            grower.join(&children)?
                        }
                    }
                    Fate::Leaf if is_unread(cell) => grower.unread(),
                    Fate::Known => {
                        let values = of_cell(k).iter().skip(channel).step_by(channels).enumerate();
                        let leaf = |(child, &v)| grower.leaf(v, level + 1, child_cell(cell.at, child)[0]);
                        let children: Vec<_> = values.map(leaf).collect();
                        grower.join(&children)?
                    }
                    Fate::Leaf => {
                        let sum: f64 = of_cell(k).iter().skip(channel).step_by(channels).sum();
                        grower.leaf(sum / n_children as f64, level, cell.at[0])
                    }
                });
            }
        }
        Ok(())
    }

    /// Whether a child of a cell that is split may be one leaf, of the value in its middle, as far as its siblings tell how steep the
    /// function is there, and the scout.
    fn is_calm(&self, level: u32, parent: Cell, values: &[f64], child: usize) -> bool {
        /// For what is not a plane.
        const CURVED: f64 = 1.5;
        let channels = self.n_channels;
        let n_children = self.options.rank.n_children();
        let value = |child: usize| &values[child * channels..][..channels];
        let mean: f64 = value(child).iter().sum();
        // Along an axis the function changes by ±half of the step to the next sibling: a quarter of it on average.
        let steps: f64 = (0..self.options.rank.dimensions())
            .flat_map(|i| value(child).iter().zip(value(child ^ 1 << i)))
            .map(|(a, b)| (a - b).powi(2))
            .sum();
        let limit = 0.5 * self.options.tolerance * mean.max(self.mean);
        let error = CURVED * 0.25 * steps.sqrt();
        if error > limit {
            return false;
        }
        let cell = self.child(level, &parent, child);
        let (n_even, even, ridge) = self.scout.spread(cell.found, level, mean);
        let n = n_children as f64;
        (error * n + even) / (n + n_even as f64) + ridge <= limit
    }

    /// A child, of the level given, of a cell.
    fn child(&self, level: u32, parent: &Cell, child: usize) -> Cell {
        let at = child_cell(parent.at, child);
        Cell { at, found: self.scout.within(parent.found, level, at) }
    }

    /// What is to become of a cell with these values, at the middles of its children and where the scout was.
    fn fate(&self, level: u32, cell: Cell, values: &[f64]) -> Fate {
        let n = (values.len() / self.n_channels) as f64;
        let mean = values.iter().sum::<f64>() / n;
        let spread: f64 = (0..self.n_channels)
            .map(|channel| {
                let of_channel = || values.iter().skip(channel).step_by(self.n_channels);
                let mean = of_channel().sum::<f64>() / n;
                of_channel().map(|v| (v - mean).abs()).sum::<f64>()
            })
            .sum();
        let (n_even, even, ridge) = self.scout.spread(cell.found, level, mean);
        let error = (spread + even) / (n + n_even as f64) + ridge;
        if level == self.options.log2_res {
            let is_narrow = error > NARROW * mean && error > 0.5 * self.mean;
            return if is_narrow { Fate::Split } else { Fate::Leaf };
        }
        if error <= 0.5 * self.options.tolerance * mean.max(self.mean) {
            Fate::Leaf
        } else if level + 1 == self.options.log2_res && error < SMOOTH * mean {
            Fate::Known
        } else {
            Fate::Split
        }
    }
}

impl<E> Refinement<'_, E> {
    /// What is to become of all children of a cell of the finest level or below, with the values of all: more of them are taken if the
    /// standard error of their mean is over [`UNCERTAIN`].
    fn fate_of_siblings(&self, values: &[f64]) -> Fate {
        let n = (values.len() / self.n_channels) as f64;
        let sums = || values.chunks_exact(self.n_channels).map(|of_place| of_place.iter().sum::<f64>());
        let mean = sums().sum::<f64>() / n;
        let variance = sums().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        let error = (variance / n).sqrt();
        if error > UNCERTAIN * mean && error > UNCERTAIN * self.mean { Fate::Split } else { Fate::Leaf }
    }
}

/// What becomes of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// One value.
    Leaf,
    /// The values of its children, which are of the finest level.
    Known,
    /// Its children are looked at.
    Split,
}

/// The middle of a child of a cell, or, `scattered`, a place in the child that hangs on nothing else.
fn point(level: u32, cell: [u32; 4], child: usize, scattered: bool) -> [f64; 4] {
    let scale = 0.5f64.powi(level as i32 + 1);
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let corner = child_cell(cell, child);
    std::array::from_fn(|i| {
        let offset = if scattered {
            // SplitMix64 of all coordinates (G. Steele et al., OOPSLA 2014).
            for &c in &cell {
                state = mixed(state ^ u64::from(c) ^ (child as u64) << 40 ^ (i as u64) << 50);
            }
            (state >> 11) as f64 / (1u64 << 53) as f64
        } else {
            0.5
        };
        (f64::from(corner[i]) + offset) * scale
    })
}

fn mixed(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// Values at places of a tree's coordinates.
fn evaluate<E>(
    f: &mut Evaluate<'_, E>,
    part: Part,
    rank: Rank,
    n_channels: usize,
    places: &[[f64; 4]],
) -> Result<Vec<f64>, FunctionError<E>> {
    let (from, to) = (part.incident_side(), part.exitant_side());
    let (incident, exitant): (Vec<_>, Vec<_>) = places
        .iter()
        .map(|&[a, b, c, d]| match rank {
            Rank::Four => {
                let incident = disk_from_square([a, b]).map(|c| -c);
                (from.direction_from_disk(incident), to.direction_from_disk(disk_from_square([c, d])))
            }
            Rank::Three => {
                let sin_theta = (1.0 - 2.0 * a).clamp(0.0, 1.0);
                (
                    from.direction_from_disk([-sin_theta, 0.0]),
                    to.direction_from_disk(disk_from_square([b, c])),
                )
            }
        })
        .unzip();
    let mut values = vec![0.0; places.len() * n_channels];
    f(&incident, &exitant, &mut values).map_err(FunctionError::Function)?;
    match values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
        Some(k) => {
            let at = k / n_channels;
            Err(FunctionError::Value { incident: incident[at], exitant: exitant[at], value: values[k] })
        }
        None => Ok(values),
    }
}
