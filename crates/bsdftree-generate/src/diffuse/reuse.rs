//! Rounds of walks and of full paths, and the model that follows from them.
//!
//! In: rounds of path numbers per incident cell. Out: exits of walks that were never diffused, exits of full paths that were, and
//! what walks laid down at sites, kept for cells of the model: of trees finer than it, for the incident cells in one of its cells
//! together. Replicates are split in two halves for the model's two estimates.

use std::ops::Range;

use bsdftree::Side;
use bsdftree_device::Device;

use super::deposit::{Deposits, Row as Laid, Walker};
use super::model::{MAX_LOG2, Model, SideRows, model_layout};
use super::sites::{Fineness, Sites};
use crate::entrance::Entrance;
use crate::layout::Layout;
use crate::options::Options;
use crate::path::Scene;
use crate::random::N_REPLICATES;
use crate::scatter::Spectrum;
use crate::tally::Exited;
use crate::tile::Tile;

/// Walks per full path. Few are needed: what they say is averaged over as many directions as agree.
const WALKS_PER_PATH: u64 = 8;

/// Walks per walk from a side that is not asked for.
const PER_UNWANTED: u64 = 4;

/// Walks between sites per walk from an incident cell, within these limits.
const EXCHANGE: u64 = 4;
const EXCHANGE_LIMITS: [u64; 2] = [512, 8192];

/// Walks from each cell of a model that is as fine as a model can be; with fewer it is as exact with cells twice as large, at a third of
/// the time in all.
const FOR_FINEST: u64 = 256;

/// What a device needs for its diffused light to be followed from both ends.
pub(crate) struct Reuse {
    sites: Sites,
    entrance: Entrance,
    /// Cells of the model.
    layout: Layout,
}

impl Reuse {
    /// `None` if nothing is diffuse, the layout is no rank-4 tree, or what surfaces do varies over them: sites take it for the same
    /// wherever the material is, and for the same both ways.
    pub fn new<S: Spectrum>(
        scene: &Scene<S>,
        device: &Device,
        options: &Options,
        entrance: &Entrance,
        tile: Option<&Tile>,
    ) -> Option<Reuse> {
        let Layout::Tree { .. } = options.layout else { return None };
        let layout = model_layout(&options.layout).filter(|_| scene.is_plain())?;
        let sites = Sites::build(scene, device, entrance, tile, Fineness::default(), options.seed)?;
        Some(Reuse { sites, entrance: entrance.clone(), layout })
    }

    /// Numbers of the full paths that belong to a round of walks.
    pub fn paths(round: &Range<u64>) -> Range<u64> {
        round.start.div_ceil(WALKS_PER_PATH)..round.end.div_ceil(WALKS_PER_PATH)
    }

    /// Numbers of the walks from a side that is not asked for, from which light only leaves.
    pub fn unwanted(round: &Range<u64>) -> Range<u64> {
        round.start.div_ceil(PER_UNWANTED)..round.end.div_ceil(PER_UNWANTED)
    }

    /// Cells of the model of each side.
    pub fn n_cells(&self) -> usize {
        self.layout.n_incident()
    }

    /// Patches of surface.
    pub fn n_sites(&self) -> usize {
        self.sites.len()
    }

    pub fn walker<'a, S>(
        &'a self,
        scene: &'a Scene<S>,
        tile: Option<&'a Tile>,
        layout: &'a Layout,
        options: &Options,
    ) -> Walker<'a, S> {
        Walker {
            scene,
            sites: &self.sites,
            entrance: &self.entrance,
            tile,
            layout,
            seed: options.seed,
            stratified: options.stratified,
        }
    }

    pub fn deposits<S: Spectrum>(&self) -> [Deposits<S>; 2] {
        [Deposits::new(&self.sites), Deposits::new(&self.sites)]
    }

    /// The model of what was laid down by `samples` walks from each incident cell.
    pub fn model<S: Spectrum>(&self, walker: &Walker<'_, S>, rows: &[SideRows; 2], samples: u64) -> Model<S> {
        let walks = (samples * EXCHANGE).clamp(EXCHANGE_LIMITS[0], EXCHANGE_LIMITS[1]);
        let mut rows = rows.each_ref().map(|side| Some(side.clone()));
        let mut layout = self.layout.clone();
        let walks_per_cell = samples * (walker.layout.n_incident() / layout.n_incident()) as u64;
        if let Layout::Tree { log2_res: log2_res @ MAX_LOG2, .. } = &mut layout
            && walks_per_cell < FOR_FINEST
        {
            *log2_res -= 1;
            rows = rows.map(|side| side.map(|replicates| replicates.map(pooled)));
        }
        Model::new(walker, &layout, rows, walks)
    }
}

impl<S: Spectrum> Walker<'_, S> {
    /// A round of walks from an incident cell: what leaves is told to `left`, what does not is laid down in halves of the replicates.
    /// Returns how many did not end.
    pub fn count_walks(
        &self,
        side: Side,
        cell: usize,
        round: &Range<u64>,
        left: &mut impl FnMut(Exited<S>),
        deposits: &mut [Deposits<S>; 2],
    ) -> u64 {
        let n = N_REPLICATES as u64;
        let mut lost = 0;
        for replicate in 0..N_REPLICATES {
            let number = |sample: u64| (sample + n - 1 - replicate as u64) / n;
            let walks = number(round.start)..number(round.end);
            if walks.is_empty() {
                continue;
            }
            let half = &mut deposits[2 * replicate / N_REPLICATES];
            lost += self.walk_cell(side, cell, walks, replicate, half, |disk, exitant, weight| {
                let transmitted = Side::of(exitant.to_array()) != side;
                let cell = self.layout.exitant_cell(disk, [exitant.x, exitant.y]);
                left(Exited { transmitted, cell, weight, replicate });
            });
        }
        lost
    }

    /// The full paths of a round, told to `left`.
    pub fn count_diffused(
        &self,
        side: Side,
        cell: usize,
        round: &Range<u64>,
        left: &mut impl FnMut(Exited<S>),
    ) -> u64 {
        self.follow_diffused(side, cell, Reuse::paths(round), |path, disk, exitant, weight| {
            let transmitted = Side::of(exitant.to_array()) != side;
            let replicate = (path % N_REPLICATES as u64) as usize;
            let cell = self.layout.exitant_cell(disk, [exitant.x, exitant.y]);
            left(Exited { transmitted, cell, weight, replicate });
        })
    }
}

/// Rows of cells of a tree as those of the next coarser ones: means over fours.
fn pooled(rows: Vec<Laid>) -> Vec<Laid> {
    let mean = |four: &[Laid], values: fn(&Laid) -> &[f32]| -> Vec<f32> {
        (0..values(&four[0]).len())
            .map(|k| 0.25 * four.iter().map(|row| values(row)[k]).sum::<f32>())
            .collect()
    };
    let pool =
        |four: &[Laid]| Laid { sent: mean(four, |row| &row.sent), arrived: mean(four, |row| &row.arrived) };
    rows.chunks_exact(4).map(pool).collect()
}

/// Means of `before` walks and of `more` walks after them as means of all.
pub(crate) fn mean_of(row: &mut Laid, before: u64, new: &Laid, more: u64) {
    if row.sent.is_empty() {
        row.clone_from(new);
        return;
    }
    let share = more as f32 / (before + more) as f32;
    let mix = |old: &mut Vec<f32>, new: &[f32]| {
        old.iter_mut().zip(new).for_each(|(old, new)| *old += share * (new - *old));
    };
    mix(&mut row.sent, &new.sent);
    mix(&mut row.arrived, &new.arrived);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pooled_rows_are_means_of_four() {
        let row = |k: usize| Laid { sent: vec![k as f32, 1.0], arrived: vec![0.0, 2.0 * k as f32] };
        let pooled = pooled((0..8).map(row).collect());
        assert_eq!(pooled.len(), 2);
        assert_eq!((&pooled[1].sent[..], &pooled[1].arrived[..]), (&[5.5, 1.0][..], &[0.0, 11.0][..]));
    }
}
