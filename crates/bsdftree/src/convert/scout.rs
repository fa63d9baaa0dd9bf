//! A first look at a function, so that no narrow peak is missed between the points of a coarse grid.
//!
//! In: places, and the values found there. Out: how far those within a cell are from a mean. Two kinds of places: a low-discrepancy
//! sequence through everything, and the ridges where peaks of real surfaces lie, straight through or mirrored (exitant
//! coordinates equal to incident ones) and back where light came from (opposite ones), four places for each finest incident
//! cell, and more around them where they are bright.

use super::distance::even_point;
use crate::tree::Rank;

/// Places of the sequence.
const N_EVEN: u32 = 1 << 17;

/// Most ridge places per incident axis, as a power of two.
const MAX_RIDGE_LOG2: u32 = 7;

/// A place: coordinates in \[0, 1), as many as the rank has dimensions.
pub(super) type Place = [f64; 4];

/// Places everywhere.
pub(super) fn even_places(rank: Rank) -> Vec<Place> {
    let place = |k: u32| {
        let place = even_point(k);
        match rank {
            Rank::Four => place,
            Rank::Three => [0.5 * place[0], place[1], place[2], 0.0],
        }
    };
    (0..N_EVEN).map(place).collect()
}

/// Places on the ridges, near the corners of each incident cell: a peak that is narrow beside its cell reaches into the next ones from
/// there only.
pub(super) fn ridge_places(rank: Rank, log2_res: u32) -> Vec<Place> {
    const CORNERS: [f64; 2] = [0.06, 0.93];
    let n = 1u32 << log2_res.min(MAX_RIDGE_LOG2);
    let along =
        |n: u32| (0..n).flat_map(move |k| CORNERS.map(|offset| (f64::from(k) + offset) / f64::from(n)));
    match rank {
        Rank::Four => along(n)
            .flat_map(|a| along(n).map(move |b| (a, b)))
            .flat_map(|(a, b)| [[a, b, a, b], [a, b, 1.0 - a, 1.0 - b]])
            .collect(),
        Rank::Three => {
            along(n).filter(|&a| a < 0.5).flat_map(|a| [[a, 1.0 - a, 0.5, 0.0], [a, a, 0.5, 0.0]]).collect()
        }
    }
}

/// Places around one on a ridge, at distances from an eighth of a finest cell to an eighth of the square: how wide the peak is, and which
/// cells beside its own it reaches into.
pub(super) fn star(rank: Rank, log2_res: u32, ridge: Place) -> impl Iterator<Item = Place> {
    let first = rank.dimensions() - 2;
    (3..=log2_res + 3).flat_map(move |k| {
        (0..9).filter(|&toward| toward != 4).filter_map(move |toward: u32| {
            let mut place = ridge;
            place[first] += (f64::from(toward % 3) - 1.0) * 0.5f64.powi(k as i32);
            place[first + 1] += (f64::from(toward / 3) - 1.0) * 0.5f64.powi(k as i32);
            place.iter().all(|c| (0.0..1.0).contains(c)).then_some(place)
        })
    })
}

/// What was found, sorted so that the places in a cell stand together.
pub(super) struct Scout {
    rank: Rank,
    log2_res: u32,
    /// Cell number in Morton order, value, whether on a ridge.
    found: Vec<(u64, f64, bool)>,
}

impl Scout {
    /// Of places and values; the first are even.
    pub fn new(rank: Rank, log2_res: u32, places: &[Place], values: &[f64]) -> Scout {
        let n = f64::from(1u32 << log2_res);
        let cell = |place: &Place| place.map(|c| ((c * n) as u32).min((1 << log2_res) - 1));
        let mut found: Vec<_> = places
            .iter()
            .zip(values)
            .enumerate()
            .map(|(k, (place, &value))| (morton(rank, log2_res, cell(place)), value, k >= N_EVEN as usize))
            .collect();
        found.sort_by_key(|&(cell, ..)| cell);
        Scout { rank, log2_res, found }
    }

    /// Mean of what was found evenly; the ridges count by the cells they stand for.
    pub fn mean(&self) -> f64 {
        let even = self.found.iter().filter(|(.., ridge)| !ridge);
        even.map(|(_, value, _)| value).sum::<f64>() / f64::from(N_EVEN)
    }

    /// What was found in everything.
    pub fn all(&self) -> Found {
        Found { first: 0, last: self.found.len() as u32 }
    }

    /// What was found in a cell, of what was found in one that it lies in. Below the finest cells nothing more is known.
    pub fn within(&self, outer: Found, level: u32, cell: [u32; 4]) -> Found {
        if level > self.log2_res || outer.first == outer.last {
            return Found { first: 0, last: 0 };
        }
        let shift = self.rank.dimensions() as u32 * (self.log2_res - level);
        let cell = morton(self.rank, level, cell);
        let found = &self.found[outer.first as usize..outer.last as usize];
        let begin = found.partition_point(|&(at, ..)| at >> shift < cell);
        let n = found[begin..].partition_point(|&(at, ..)| at >> shift == cell);
        Found { first: outer.first + begin as u32, last: outer.first + (begin + n) as u32 }
    }

    /// In a cell of a level: number of even places, sum of |value − mean| over them, and over ridges as a fraction of the cell.
    pub fn spread(&self, found: Found, level: u32, mean: f64) -> (usize, f64, f64) {
        let (mut n, mut even, mut ridge) = (0, 0.0, 0.0);
        for &(_, value, on_ridge) in &self.found[found.first as usize..found.last as usize] {
            let off = (value - mean).abs();
            if on_ridge {
                ridge += off;
            } else {
                n += 1;
                even += off;
            }
        }
        let cells = self.rank.dimensions() as u32 * self.log2_res.saturating_sub(level);
        (n, even, ridge * 0.5f64.powi(cells as i32))
    }
}

/// Where in the scout's list a cell's places are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    first: u32,
    last: u32,
}

/// Bits of the coordinates in turn, the coarsest first.
fn morton(rank: Rank, level: u32, cell: [u32; 4]) -> u64 {
    let d = rank.dimensions();
    (0..level).rev().fold(0, |number, bit| {
        let child = (0..d).fold(0, |child, i| child | u64::from(cell[i] >> bit & 1) << i);
        number << d | child
    })
}
