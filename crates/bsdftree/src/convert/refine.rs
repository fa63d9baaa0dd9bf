//! A function refined into trees where it changes.
//!
//! A cell is judged by the values at the middles of its children and by what a first look ([`super::scout`]) found in it; it is split
//! where their mean distance from their mean is more than half the tolerance times its own mean or the whole function's. Cells of
//! the finest level that hold something much narrower are split further, up to [`extra_levels`] times, only to take their mean.

use super::TreeOptions;
use super::asker::Asker;
use super::function::{Evaluate, FunctionError};
use super::grow::{Branch, Grower};
use super::scout::{Found, Place, Scout, even_places, ridge_places, star};
use crate::bsdf::Part;
use crate::tree::{Rank, Tree, TreeError, child_cell};

/// Level that is always reached.
const BASE: u32 = 3;

/// Levels below the finest, for means only.
fn extra_levels(rank: Rank) -> u32 {
    match rank {
        Rank::Three => 3,
        Rank::Four => 2,
    }
}

/// Cells that are asked about at once: with what is asked and answered, about what a cache holds.
const CHUNK: usize = 1024;

/// Spread over mean of a finest cell above which it is split further: what the middles of its children get wrong by a percent or two.
const NARROW: f64 = 0.2;

/// Standard error over mean of places that are scattered, above which more of them are taken.
const UNCERTAIN: f64 = 0.1;

/// Spread over mean below which values in the middle of finest cells are their means, within half a percent or so.
const SMOOTH: f64 = 0.3;

/// How many times brighter than the mean a ridge is looked at closely.
const BRIGHT: f64 = 4.0;

/// A cell.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Lower corner in units of its edge.
    at: [u32; 4],
    /// What the scout found in it.
    found: Found,
}

/// How cells of a level are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Not at all: all are split.
    Coarse,
    /// At the middles of their children.
    Judged,
    /// The same, on the finest level.
    Finest,
    /// At scattered places, for their means alone: regular ones lie on ridges more often than others do.
    Below,
    /// The same, for the last time.
    Last,
}

/// Cells of a level, and what the function is in each.
struct Look<'a> {
    level: u32,
    stage: Stage,
    cells: &'a [Cell],
    values: Vec<f64>,
}

impl Look<'_> {
    /// The values in some cells that follow each other.
    fn values(&self, first: usize, n: usize) -> &[f64] {
        let each = self.values.len() / self.cells.len();
        &self.values[each * first..each * (first + n)]
    }
}

/// A component being refined.
pub(super) struct Refinement<'a, E> {
    asker: Asker<'a, E>,
    /// 1, or 3 for X, Y, Z.
    n_channels: usize,
    options: TreeOptions,
    scout: Scout,
    growers: Vec<Grower>,
    /// Mean of the whole function, all channels together.
    mean: f64,
}

impl<'a, E> Refinement<'a, E> {
    pub fn new(
        f: &'a mut Evaluate<'_, E>,
        part: Part,
        n_channels: usize,
        options: TreeOptions,
    ) -> Result<Self, FunctionError<E>> {
        let TreeOptions { rank, log2_res, .. } = options;
        let mut asker = Asker::new(f, part, rank, n_channels);
        let mut values_at = |places: &[Place]| -> Result<Vec<f64>, FunctionError<E>> {
            let mut values = Vec::with_capacity(places.len() * n_channels);
            for chunk in places.chunks(CHUNK * 16) {
                chunk.iter().for_each(|&place| asker.place(place));
                values.extend(asker.answers()?);
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
        Ok(Refinement { asker, n_channels, options, scout, growers, mean })
    }

    pub fn trees(mut self) -> Result<Vec<Tree>, FunctionError<E>> {
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
        let look = self.look(level, cells)?;
        let fates: Vec<Fate> = (0..cells.len()).map(|k| self.fate(&look, k)).collect();
        let children: Vec<Cell> = (0..cells.len())
            .flat_map(|k| children_of(fates[k]).map(move |child| (k, child)))
            .map(|(k, child)| self.child(level + 1, &cells[k], child))
            .collect();
        let grown = if children.is_empty() { Vec::new() } else { self.refined(level + 1, &children)? };
        let mut grown = grown.chunks_exact(self.n_channels);
        for (k, &fate) in fates.iter().enumerate() {
            let below: Vec<&[Branch]> = grown.by_ref().take(children_of(fate).count()).collect();
            for channel in 0..self.n_channels {
                let mut below = below.iter().map(|branches| branches[channel]);
                branches.push(self.branch(&look, k, fate, channel, &mut below)?);
            }
        }
        Ok(())
    }

    fn stage(&self, level: u32) -> Stage {
        let finest = self.options.log2_res;
        match () {
            () if level < BASE.min(finest) => Stage::Coarse,
            () if level < finest => Stage::Judged,
            () if level == finest => Stage::Finest,
            () if level < finest + extra_levels(self.options.rank) => Stage::Below,
            () => Stage::Last,
        }
    }

    /// Asks the function about cells.
    fn look<'c>(&mut self, level: u32, cells: &'c [Cell]) -> Result<Look<'c>, FunctionError<E>> {
        let stage = self.stage(level);
        let values = match stage {
            Stage::Coarse => Vec::new(),
            Stage::Judged | Stage::Finest => {
                cells.iter().for_each(|cell| self.asker.middles(level, cell.at));
                self.asker.answers()?
            }
            Stage::Below | Stage::Last => {
                cells.iter().for_each(|cell| self.asker.scattered(level, cell.at));
                self.asker.answers()?
            }
        };
        Ok(Look { level, stage, cells, values })
    }

    /// Whether a cell lies in the half of a rank-3 tree that is never read.
    fn is_unread(&self, level: u32, cell: &Cell) -> bool {
        self.options.rank == Rank::Three && level > 0 && cell.at[0] >> (level - 1) > 0
    }

    /// What is to become of a cell.
    fn fate(&self, look: &Look<'_>, k: usize) -> Fate {
        let n = self.options.rank.n_children();
        if self.is_unread(look.level, &look.cells[k]) {
            return Fate::Unread;
        }
        match look.stage {
            Stage::Coarse => Fate::Split(all_children(n)),
            Stage::Last => Fate::Leaf,
            // Siblings share their fate: if those were left that happened to look dark, light would be lost.
            Stage::Below => self.fate_of_siblings(look.values(k - k % n, n)),
            Stage::Finest => self.fate_of_finest(look.cells[k], look.values(k, 1)),
            Stage::Judged => self.fate_of_judged(look.level, look.cells[k], look.values(k, 1)),
        }
    }

    /// What a cell becomes in one channel, when those of its children that were looked at have become what `below` gives in turn.
    fn branch(
        &mut self,
        look: &Look<'_>,
        k: usize,
        fate: Fate,
        channel: usize,
        below: &mut impl Iterator<Item = Branch>,
    ) -> Result<Branch, TreeError> {
        let (level, cell) = (look.level, &look.cells[k]);
        let (n, channels) = (self.options.rank.n_children(), self.n_channels);
        let grower = &mut self.growers[channel];
        let looked_at = match fate {
            Fate::Unread => return Ok(grower.unread()),
            Fate::Leaf => {
                let of_channel = look.values(k, 1).iter().skip(channel).step_by(channels);
                let mean = of_channel.clone().sum::<f64>() / of_channel.len() as f64;
                return Ok(grower.leaf(mean, level, cell.at[0]));
            }
            Fate::Known => 0,
            Fate::Split(children) => children,
        };
        let mut children = [grower.unread(); 16];
        for (child, branch) in children[..n].iter_mut().enumerate() {
            *branch = match looked_at >> child & 1 {
                1 => below.next().expect("a branch for each child that was looked at"),
                _ => {
                    let value = look.values(k, 1)[child * channels + channel];
                    grower.leaf(value, level + 1, child_cell(cell.at, child)[0])
                }
            };
        }
        match look.stage {
            Stage::Coarse | Stage::Judged => grower.join(&children[..n]),
            Stage::Finest | Stage::Below | Stage::Last => Ok(grower.blend(&children[..n])),
        }
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

    /// What is to become of a cell of a level that is judged, with its values.
    fn fate_of_judged(&self, level: u32, cell: Cell, values: &[f64]) -> Fate {
        let (mean, error) = self.spread(level, cell, values);
        if error <= 0.5 * self.options.tolerance * mean.max(self.mean) {
            return Fate::Leaf;
        }
        if level + 1 == self.options.log2_res && error < SMOOTH * mean {
            return Fate::Known;
        }
        let n = self.options.rank.n_children();
        let calm = (0..n).filter(|&child| self.is_calm(level + 1, cell, values, child));
        Fate::Split(calm.fold(all_children(n), |asked, child| asked & !(1 << child)))
    }

    /// The same on the finest level.
    fn fate_of_finest(&self, cell: Cell, values: &[f64]) -> Fate {
        let (mean, error) = self.spread(self.options.log2_res, cell, values);
        match error > NARROW * mean && error > 0.5 * self.mean {
            true => Fate::Split(all_children(self.options.rank.n_children())),
            false => Fate::Leaf,
        }
    }

    /// The mean of a cell with these values, at the middles of its children, and how far they and what the scout found are from it, on
    /// average.
    fn spread(&self, level: u32, cell: Cell, values: &[f64]) -> (f64, f64) {
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
        (mean, (spread + even) / (n + n_even as f64) + ridge)
    }

    /// What is to become of all children of a cell of the finest level or below, with the values of all: more of them are taken if the
    /// standard error of their mean is over [`UNCERTAIN`].
    fn fate_of_siblings(&self, values: &[f64]) -> Fate {
        let n = (values.len() / self.n_channels) as f64;
        let sums = || values.chunks_exact(self.n_channels).map(|of_place| of_place.iter().sum::<f64>());
        let mean = sums().sum::<f64>() / n;
        let variance = sums().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        let error = (variance / n).sqrt();
        match error > UNCERTAIN * mean && error > UNCERTAIN * self.mean {
            true => Fate::Split(all_children(self.options.rank.n_children())),
            false => Fate::Leaf,
        }
    }
}

/// What becomes of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// Nothing: it is never read.
    Unread,
    /// One value.
    Leaf,
    /// The values of its children, which are of the finest level.
    Known,
    /// These of its children are looked at, a bit for each; the others are leaves.
    Split(u16),
}

/// The bits of n children.
fn all_children(n: usize) -> u16 {
    u16::MAX >> (16 - n)
}

/// The children of a cell that are looked at.
fn children_of(fate: Fate) -> impl Iterator<Item = usize> {
    let looked_at = if let Fate::Split(children) = fate { children } else { 0 };
    (0..16).filter(move |child| looked_at >> child & 1 == 1)
}
