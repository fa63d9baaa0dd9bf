//! A fitted model → trees.

use std::cell::OnceCell;

use bsdftree::Rank;
use bsdftree::square::disk_from_square;
use bsdftree::tree::{Content, Leaf, Slot, Tree, TreeBuilder, TreeError};
use rayon::prelude::*;

use crate::cells::{self, Cells};
use crate::fit::FitError;
use crate::forward::turned;
use crate::lambert::Ray;
use crate::model::Model;
use crate::progress::{Progress, Stopped};

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
        let mut grid = match (cells.rank, self.back()) {
            (Rank::Four, Some(back)) => self.averaged(channel, cells, (&exitant, back), progress)?,
            _ => {
                let done = || progress.count(1);
                means(cells, &exitant, |i| self.turn(i), |i| self.slice(channel, i), done)?
            }
        };
        let rows = grid.par_chunks_mut(cells.n_exitant()).take(cells.n_incident()).enumerate();
        rows.try_for_each(|(cell, row)| {
            progress.go_on()?;
            self.to_total(channel, cells, cell, others, row);
            Ok::<(), Stopped>(())
        })?;
        Ok(Tree::from_grid(cells.rank, &grid)?)
    }

    /// Brings an incident cell to the total that was measured; with other parts no more than all light that came in.
    fn to_total(&self, channel: usize, cells: Cells, cell: usize, others: &[&Model], row: &mut [f32]) {
        let points = cells.incident(cell).map(|i| turned(i, self.turn(i)));
        let mean = |model: &Model| {
            let total = |k: usize| model.slice(channel, points[k]).total();
            cells::FOUR.map(total).iter().sum::<f64>() / cells::FOUR.len() as f64
        };
        let own = mean(self);
        let all = own + others.iter().map(|other| mean(other)).sum::<f64>();
        let total = own / all.max(1.0);
        let sum = row.iter().map(|&v| f64::from(v)).sum::<f64>() * cells.omega();
        if sum > 0.0 {
            let scale = (total / sum) as f32;
            row.iter_mut().for_each(|v| *v *= scale);
        }
    }

    /// The tree with a standard error in place of each leaf's value: the mean of the errors at some places of the leaf. They are of one
    /// interpolation, so they do not average out.
    pub(crate) fn error_tree(&self, tree: &Tree) -> Result<Tree, TreeError> {
        let leaves: Vec<Leaf> = tree.leaves().collect();
        let rank = tree.rank();
        // Leaves of one incident cell together: what is made ready for an incident direction serves them all.
        let incident =
            |leaf: &Leaf| (leaf.level, leaf.cell[0], if rank == Rank::Four { leaf.cell[1] } else { 0 });
        let mut order: Vec<u32> = (0..leaves.len() as u32).collect();
        order.par_sort_unstable_by_key(|&k| (incident(&leaves[k as usize]), k));
        let together: Vec<&[u32]> =
            order.chunk_by(|&a, &b| incident(&leaves[a as usize]) == incident(&leaves[b as usize])).collect();
        let of_cell = |members: &&[u32]| {
            let first = &leaves[members[0] as usize];
            let places = PLACES.map(|place| self.error_at(rank, first, place));
            let error = |&k: &u32| {
                let sum: f64 = places.iter().map(|error| error(&leaves[k as usize])).sum();
                (k, (sum / places.len() as f64) as f32)
            };
            members.iter().map(error).collect::<Vec<_>>()
        };
        let mut errors = vec![0f32; leaves.len()];
        for (k, error) in together.par_iter().flat_map_iter(of_cell).collect::<Vec<_>>() {
            errors[k as usize] = error;
        }
        let mut errors = errors.into_iter();
        let mut builder = TreeBuilder::new(rank);
        let root = copied(tree, tree.arena().root(), &mut errors, &mut builder)?;
        Ok(Tree::new(builder.finish(root)))
    }

    /// Errors at one place of leaves that share the incident cell of `leaf`.
    fn error_at(&self, rank: Rank, leaf: &Leaf, place: [f64; 4]) -> impl Fn(&Leaf) -> f64 + '_ {
        let edge = 0.5f64.powi(leaf.level as i32);
        let at = move |cell: [u32; 4], d: usize| (f64::from(cell[d]) + place[d]) * edge;
        let incident = match rank {
            Rank::Four => disk_from_square([at(leaf.cell, 0), at(leaf.cell, 1)]).map(|x| -x),
            Rank::Three => [(2.0 * at(leaf.cell, 0) - 1.0).min(0.0), 0.0],
        };
        let incident = cells::upper(incident);
        let turn = self.turn(incident);
        let error = self.error_slice(turned(incident, turn));
        let first = rank.dimensions() - 2;
        move |leaf: &Leaf| {
            let exitant = cells::upper(disk_from_square([at(leaf.cell, first), at(leaf.cell, first + 1)]));
            error(turned(exitant, turn))
        }
    }
}

/// All exitant directions for one incident direction.
pub(crate) trait Values {
    /// The directional-hemispherical total that is foreseen, in [0, 1].
    fn total(&self) -> f64;

    /// The value in one direction.
    fn value(&self, o: Ray) -> f32;
}

/// Means over all pairs of cells, each incident one after `done` says whether to go on. `turn` brings an incident direction to where `slice` is asked.
pub(crate) fn means<S: Values>(
    cells: Cells,
    exitant: &[[Ray; cells::N_POINTS]],
    turn: impl Fn(Ray) -> [f32; 2] + Sync,
    slice: impl Fn(Ray) -> S + Sync,
    done: impl Fn() -> Result<(), Stopped> + Sync,
) -> Result<Vec<f32>, Stopped> {
    let mut grid = vec![0f32; cells.n().pow(cells.rank.dimensions() as u32)];
    let rows = grid.par_chunks_mut(cells.n_exitant()).take(cells.n_incident()).enumerate();
    rows.try_for_each(|(cell, row)| {
        let points = cells.incident(cell);
        let turns = points.map(&turn);
        let slices: [OnceCell<S>; cells::N_POINTS] = std::array::from_fn(|_| OnceCell::new());
        let at = |k: usize| slices[k].get_or_init(|| slice(turned(points[k], turns[k])));
        let total = cells::FOUR.map(|k| at(k).total()).iter().sum::<f64>() / cells::FOUR.len() as f64;
        let level = 0.2 * (total / std::f64::consts::PI) as f32;
        let (at, turns) = (&at, &turns);
        cells::means(level, cells, row, |c| move |i, o| at(i).value(turned(exitant[c][o], turns[i])));
        done()
    })?;
    Ok(grid)
}

/// Places in a leaf at which errors are taken.
const PLACES: [[f64; 4]; 2] = [[0.3, 0.7, 0.25, 0.4], [0.7, 0.3, 0.75, 0.6]];

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
