//! A fitted model → trees.

use std::sync::atomic::Ordering;

use bsdftree::Rank;
use bsdftree::square::disk_from_square;
use bsdftree::tree::{Content, Slot, Tree, TreeBuilder, TreeError};
use rayon::prelude::*;

use crate::cells::{self, Cells};
use crate::fit::{FitError, Progress};
use crate::lambert::Ray;
use crate::model::{Model, turned};

impl Model {
    /// The finest tree of one channel. `others` are models of the light that leaves on the other side.
    pub(crate) fn tree(
        &self,
        channel: usize,
        cells: Cells,
        others: &[&Model],
        progress: &Progress,
    ) -> Result<Tree, FitError> {
        let exitant: Vec<[Ray; cells::N_POINTS]> = (0..cells.n_exitant()).map(|c| cells.exitant(c)).collect();
        let mut grid = vec![0f32; cells.n().pow(cells.rank.dimensions() as u32)];
        let rows = grid.par_chunks_mut(cells.n_exitant()).take(cells.n_incident()).enumerate();
        rows.try_for_each(|(cell, row)| {
            self.fill(channel, cells, cell, others, &exitant, row);
            progress.one_done().then_some(())
        })
        .ok_or(FitError::Stopped)?;
        debug_assert!(!progress.stop.load(Ordering::Relaxed) || grid.is_empty());
        Ok(Tree::from_grid(cells.rank, &grid)?)
    }

    /// One incident cell, brought to the total that was measured; with other parts no more than all light that came in.
    fn fill(
        &self,
        channel: usize,
        cells: Cells,
        cell: usize,
        others: &[&Model],
        exitant: &[[Ray; cells::N_POINTS]],
        row: &mut [f32],
    ) {
        let turns = cells.incident(cell).map(|i| self.turn(i));
        let mut points = cells.incident(cell);
        points.iter_mut().zip(turns).for_each(|(i, turn)| *i = turned(*i, turn));
        let slices = points.map(|i| self.slice(channel, i));
        let mean =
            |total: &dyn Fn(usize) -> f64| (0..points.len()).map(total).sum::<f64>() / points.len() as f64;
        let own = mean(&|k| slices[k].1);
        let all = own + others.iter().map(|other| mean(&|k| other.slice(channel, points[k]).1)).sum::<f64>();
        let total = own / all.max(1.0);
        let level = 0.2 * (total / std::f64::consts::PI) as f32;
        for (value, exitant) in row.iter_mut().zip(exitant) {
            *value = cells::mean(level, |i, o| slices[i].0.value(turned(exitant[o], turns[i])));
        }
        let sum = row.iter().map(|&v| f64::from(v)).sum::<f64>() * cells.omega();
        if sum > 0.0 {
            let scale = (total / sum) as f32;
            row.iter_mut().for_each(|v| *v *= scale);
        }
    }

    /// The tree with a standard error in place of each leaf's value: the mean of the errors at eight places of the leaf. They are of one
    /// interpolation, so they do not average out.
    pub(crate) fn error_tree(&self, tree: &Tree) -> Result<Tree, TreeError> {
        let leaves: Vec<_> = tree.leaves().collect();
        let rank = tree.rank();
        let errors: Vec<f32> =
            leaves.par_iter().map(|leaf| self.leaf_error(rank, leaf.cell, leaf.level)).collect();
        let mut errors = errors.into_iter();
        let mut builder = TreeBuilder::new(rank);
        let root = copied(tree, tree.arena().root(), &mut errors, &mut builder)?;
        Ok(Tree::new(builder.finish(root)))
    }

    fn leaf_error(&self, rank: Rank, cell: [u32; 4], level: u32) -> f32 {
        const N: usize = 8;
        let edge = 0.5f64.powi(level as i32);
        // Coordinates of the first points of a rank-1 lattice: well spread in up to four dimensions.
        let at = |k: usize, d: usize| {
            let shift = ((k as f64 + 0.5) * [0.5, 0.618_034, 0.754_878, 0.819_173][d]).fract();
            (f64::from(cell[d]) + shift) * edge
        };
        let mut sum = 0.0;
        for k in 0..N {
            let (incident, exitant) = match rank {
                Rank::Four => {
                    let [x, y] = disk_from_square([at(k, 0), at(k, 1)]);
                    ([-x, -y], disk_from_square([at(k, 2), at(k, 3)]))
                }
                Rank::Three => {
                    ([(2.0 * at(k, 0) - 1.0).min(0.0), 0.0], disk_from_square([at(k, 1), at(k, 2)]))
                }
            };
            let (i, o) = (cells::upper(incident), cells::upper(exitant));
            let turn = self.turn(i);
            let (i, o) = (turned(i, turn), turned(o, turn));
            sum += self.error_slice(i)(o);
        }
        (sum / N as f64) as f32
    }
}

fn copied(
    tree: &Tree,
    slot: Slot,
    errors: &mut impl Iterator<Item = f32>,
    builder: &mut TreeBuilder,
) -> Result<Slot, TreeError> {
    let Content::Node(node) = slot.content() else {
        return Ok(Slot::leaf(errors.next().expect("as many errors as leaves")));
    };
    let children = tree.arena().children(node).to_vec();
    let children = children
        .into_iter()
        .map(|child| copied(tree, child, errors, builder))
        .collect::<Result<Vec<_>, _>>()?;
    builder.node(&children)
}
