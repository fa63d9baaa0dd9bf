//! A rank-4 grid averaged with swapped pairs.
//!
//! Incident and exitant cells are of the same directions, so a swapped pair of cells is a pair of cells too: what scans say forward is
//! averaged over cells once, and each mean is averaged with that of the swapped cells of the light that goes back. What the forward one
//! counts ([`crate::swapped`]) is the mean over two pairs of points. Pair by pair that would take a look at all scans of the exitant
//! direction for each point.

use rayon::prelude::*;

use crate::cells::{self, Cells};
use crate::forward::{Forward, Place, turned};
use crate::lambert::Ray;
use crate::model::Model;
use crate::progress::{Progress, Stopped};
use crate::tree::means;

/// Incident cells at a time: their swapped means lie side by side.
const BLOCK: usize = 16;

/// Pairs of points at which shares are taken.
const N_SHARES: usize = 2;

impl Model {
    /// The means over all pairs of cells, not brought to totals; `back` is the light that goes back.
    pub(crate) fn averaged(
        &self,
        channel: usize,
        cells: Cells,
        (exitant, back): (&[[Ray; cells::N_POINTS]], &Forward),
        progress: &Progress,
    ) -> Result<Vec<f32>, Stopped> {
        let forward = &*self.forward();
        let grid = forward.means(channel, cells, exitant, || progress.count(1))?;
        let other = match std::ptr::eq(forward, back) {
            true => None,
            false => Some(back.means(channel, cells, exitant, || progress.go_on())?),
        };
        let swapped = other.as_deref().unwrap_or(&grid);
        let places: Vec<[Place; N_SHARES]> =
            exitant.par_iter().map(|points| pairs().map(|(_, o)| back.place(channel, points[o]))).collect();
        let n = cells.n_exitant();
        let mut averaged = vec![0f32; grid.len()];
        let blocks = averaged.par_chunks_mut(BLOCK * n).enumerate();
        blocks.try_for_each(|(block, rows)| {
            progress.go_on()?;
            for (k, row) in rows.chunks_mut(n).enumerate() {
                self.shares(channel, cells.incident(block * BLOCK + k), (exitant, &places), row);
            }
            for o in 0..n {
                // Cells count from one end of an axis for light that comes in, from the other for light that goes out.
                let back = &swapped[(n - 1 - o) * n..][..n];
                for k in 0..rows.len() / n {
                    let (i, share) = (block * BLOCK + k, &mut rows[k * n + o]);
                    *share = *share * grid[i * n + o] + (1.0 - *share) * back[n - 1 - i];
                }
            }
            Ok(())
        })?;
        Ok(averaged)
    }

    /// What forward means count, one for each exitant cell.
    fn shares(
        &self,
        channel: usize,
        points: [Ray; cells::N_POINTS],
        (exitant, places): (&[[Ray; cells::N_POINTS]], &[[Place; N_SHARES]]),
        row: &mut [f32],
    ) {
        row.fill(0.0);
        for (k, (i, o)) in pairs().into_iter().enumerate() {
            let turn = self.turn(points[i]);
            let both = self.slice(channel, turned(points[i], turn));
            for ((share, points), places) in row.iter_mut().zip(exitant).zip(places) {
                *share += both.share(turned(points[o], turn), &places[k]) / N_SHARES as f32;
            }
        }
    }
}

/// Incident and exitant points of a pair of cells at which shares are taken.
fn pairs() -> [(usize, usize); N_SHARES] {
    std::array::from_fn(|k| (cells::FOUR[k], cells::partner(cells::FOUR[k])))
}

impl Forward {
    fn means(
        &self,
        channel: usize,
        cells: Cells,
        exitant: &[[Ray; cells::N_POINTS]],
        done: impl Fn() -> Result<(), Stopped> + Sync,
    ) -> Result<Vec<f32>, Stopped> {
        means(cells, exitant, |i| self.turn(i), |i| self.scaled(channel, i), done)
    }
}
