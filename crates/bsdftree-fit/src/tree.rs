//! A fitted model → trees.

use bsdftree::Rank;
use bsdftree::tree::{Tree, TreeError};
use rayon::prelude::*;

use crate::cells::{self, Cells};
use crate::lambert::Ray;
use crate::model::Model;

impl Model {
    /// The finest grid of a tree, row-major, of one channel. `done` is called with the number of incident cells done since the last call.
    ///
    /// # Errors
    /// If no tree can be so large.
    pub fn tree(&self, channel: usize, rank: Rank, log2_res: u32, done: &(dyn Fn(usize) + Sync)) -> Result<Tree, TreeError> {
        Tree::from_grid(rank, &self.grid(channel, Cells { rank, log2_res }, done))
    }

    fn grid(&self, channel: usize, cells: Cells, done: &(dyn Fn(usize) + Sync)) -> Vec<f32> {
        let exitant: Vec<[Ray; cells::N_POINTS]> = (0..cells.n_exitant()).map(|c| cells.exitant(c)).collect();
        let mut grid = vec![0f32; cells.n().pow(cells.rank.dimensions() as u32)];
        grid.par_chunks_mut(cells.n_exitant()).take(cells.n_incident()).enumerate().for_each(|(cell, row)| {
            self.fill(channel, cells, cell, &exitant, row);
            done(1);
        });
        grid
    }

    /// One incident cell.
    fn fill(&self, channel: usize, cells: Cells, cell: usize, exitant: &[[Ray; cells::N_POINTS]], row: &mut [f32]) {
        let points = cells.incident(cell);
        let slices = points.map(|i| self.slice(channel, i));
        let total = slices.iter().map(|(_, total)| total).sum::<f64>() / points.len() as f64;
        let level = 0.2 * (total / std::f64::consts::PI) as f32;
        for (value, exitant) in row.iter_mut().zip(exitant) {
            *value = cells::mean(level, |i, o| slices[i].0.value(exitant[o]));
        }
        let sum = row.iter().map(|&v| f64::from(v)).sum::<f64>() * cells.omega();
        if sum > 0.0 {
            let scale = (total / sum) as f32;
            row.iter_mut().for_each(|v| *v *= scale);
        }
    }
}
