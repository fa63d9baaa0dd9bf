//! What was counted, and the blocks that it is counted in.
//!
//! In: blocks of a range of path numbers, in any order. Out: rows of all incident cells. Invariant: ranges follow each other, and
//! each block of a range is added once, so every sum is made in one order and has the same bits whatever order the blocks come in.

use std::ops::Range;
use std::slice::ChunksMut;

use bsdftree::Side;

use crate::diffuse::{Laid, SideRows, mean_of};
use crate::estimate::Counted;
use crate::scatter::Flux;
use crate::tally::{Row, added};

/// All that was counted.
pub(crate) struct Counts<S> {
    /// By band and side asked for.
    pub counted: Vec<Vec<Counted<S>>>,
    /// What was laid down by walks from the front and from the back.
    pub laid: Option<[SideRows; 2]>,
}

/// Incident cells that are counted together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub side: Side,
    pub first_cell: usize,
    pub n_cells: usize,
    /// Whether exits are kept, or only what is laid down.
    pub wanted: bool,
}

/// What was counted at a place.
#[derive(Clone, Debug)]
pub(crate) struct Block<S> {
    /// For each band reflected and transmitted exits by incident cell, if wanted.
    pub rows: Vec<[Vec<Row<S>>; 2]>,
    /// The same of full paths of light that is diffused, if that is followed apart.
    pub diffused: Vec<[Vec<Row<S>>; 2]>,
    /// What each half of the walks laid down.
    pub laid: Option<[Laid; 2]>,
    /// Paths that never ended.
    pub lost: u64,
    /// What it took \[s\], divided by the number of threads.
    pub seconds: f64,
}

/// Paths that never ended, and the time that counting took \[s\].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spent {
    pub lost: u64,
    pub seconds: f64,
}

impl std::ops::Add for Spent {
    type Output = Spent;

    fn add(self, other: Spent) -> Spent {
        Spent { lost: self.lost + other.lost, seconds: self.seconds + other.seconds }
    }
}

/// A block to look at.
pub(crate) struct View<'a, S> {
    pub rows: Vec<[&'a [Row<S>]; 2]>,
    pub diffused: Vec<[&'a [Row<S>]; 2]>,
    pub laid: Option<[&'a Laid; 2]>,
    pub lost: u64,
    pub seconds: f64,
}

/// What a block of a slot has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub n_bands: usize,
    /// Reflected, or transmitted, rows of a band.
    pub n_rows: usize,
    /// Those of light that is diffused.
    pub n_diffused: usize,
    /// Numbers that each half laid down, sent or arrived.
    pub n_laid: Option<usize>,
    /// Exitant cells.
    pub n_exitant: usize,
}

/// Where the counts of a block belong.
pub(crate) struct Slot<'a, S> {
    pub place: Place,
    /// By band.
    pub rows: Vec<[&'a mut [Row<S>]; 2]>,
    pub diffused: Vec<[&'a mut [Row<S>]; 2]>,
    pub laid: Option<[&'a mut Laid; 2]>,
}

impl<S: Flux> Counts<S> {
    /// Exits that were counted.
    pub fn n_exits(&self) -> u64 {
        let counted = self.counted.iter().flatten();
        let rows = counted.flat_map(|c| c.rows.iter().chain(&c.diffused)).flatten();
        rows.map(|row| row.len() as u64).sum()
    }

    /// All blocks of so many of the `n_incident` cells of a side, front before back.
    pub fn slots(&mut self, n_incident: usize, n_cells: usize) -> Vec<Slot<'_, S>> {
        let [front, back] = match &mut self.laid {
            None => [None, None],
            Some([front, back]) => [Some(front), Some(back)],
        };
        let mut counted: Vec<_> = self.counted.iter_mut().flatten().collect();
        let mut slots = Vec::new();
        for (side, laid) in [(Side::Front, front), (Side::Back, back)] {
            let of_side: Vec<_> = counted.extract_if(.., |c| c.side == side).collect();
            if laid.is_none() && of_side.is_empty() {
                continue;
            }
            let wanted = !of_side.is_empty();
            let (mut rows, mut diffused): (Vec<_>, Vec<_>) = of_side
                .into_iter()
                .map(|c| (chunks(&mut c.rows, n_cells), chunks(&mut c.diffused, n_cells)))
                .unzip();
            let mut laid = laid.map(|halves| halves.each_mut().map(|half| half.iter_mut()));
            for first_cell in (0..n_incident).step_by(n_cells) {
                slots.push(Slot {
                    place: Place { side, first_cell, n_cells: n_cells.min(n_incident - first_cell), wanted },
                    rows: rows.iter_mut().map(next).collect(),
                    diffused: diffused.iter_mut().map(next).collect(),
                    laid: laid
                        .as_mut()
                        .map(|halves| halves.each_mut().map(|half| half.next().expect("a row per block"))),
                });
            }
        }
        slots
    }
}

/// Reflected and transmitted rows, block by block.
fn chunks<S>(rows: &mut [Vec<Row<S>>; 2], n_cells: usize) -> [ChunksMut<'_, Row<S>>; 2] {
    rows.each_mut().map(|rows| rows.chunks_mut(n_cells))
}

/// Those of the next block.
fn next<'a, S>(chunks: &mut [ChunksMut<'a, Row<S>>; 2]) -> [&'a mut [Row<S>]; 2] {
    chunks.each_mut().map(|chunks| chunks.next().unwrap_or_default())
}

impl<S> Block<S> {
    pub fn nothing() -> Block<S> {
        Block { rows: Vec::new(), diffused: Vec::new(), laid: None, lost: 0, seconds: 0.0 }
    }

    pub fn view(&self) -> View<'_, S> {
        View {
            rows: self.rows.iter().map(|band| band.each_ref().map(|r| &r[..])).collect(),
            diffused: self.diffused.iter().map(|band| band.each_ref().map(|r| &r[..])).collect(),
            laid: self.laid.as_ref().map(|halves| halves.each_ref()),
            lost: self.lost,
            seconds: self.seconds,
        }
    }
}

impl<S: Flux> Slot<'_, S> {
    /// All that was added, in which so much was lost and spent.
    pub fn view(&self, lost: u64, seconds: f64) -> View<'_, S> {
        View {
            rows: self.rows.iter().map(|band| band.each_ref().map(|r| &**r)).collect(),
            diffused: self.diffused.iter().map(|band| band.each_ref().map(|r| &**r)).collect(),
            laid: self.laid.as_ref().map(|halves| halves.each_ref().map(|half| &**half)),
            lost,
            seconds,
        }
    }

    /// Adds what paths of these numbers counted.
    pub fn add(&mut self, block: Block<S>, paths: &Range<u64>) {
        for (kept, new) in [(&mut self.rows, block.rows), (&mut self.diffused, block.diffused)] {
            for (kept, new) in kept.iter_mut().flatten().zip(new.into_iter().flatten()) {
                kept.iter_mut().zip(new).for_each(|(row, new)| *row = added(std::mem::take(row), new));
            }
        }
        for (row, new) in self.laid.iter_mut().flatten().zip(block.laid.iter().flatten()) {
            mean_of(row, paths.start, new, paths.end - paths.start);
        }
    }
}
