//! A function, asked for its values at places of a tree.
//!
//! In: places and cells. Out: for each place, in the order in which they were named, one value for each channel, looked at: finite
//! and ≥ 0.

use super::function::{Evaluate, FunctionError};
use super::scout::Place;
use crate::bsdf::Part;
use crate::direction::Direction;
use crate::square::disk_from_square;
use crate::tree::{Rank, child_cell};

/// A function of one component, and the places that it is to be asked about next.
pub(super) struct Asker<'a, E> {
    f: &'a mut Evaluate<'a, E>,
    part: Part,
    rank: Rank,
    /// 1, or 3 for X, Y, Z.
    n_channels: usize,
    incident: Vec<Direction>,
    exitant: Vec<Direction>,
}

impl<'a, E> Asker<'a, E> {
    pub fn new(f: &'a mut Evaluate<'_, E>, part: Part, rank: Rank, n_channels: usize) -> Asker<'a, E> {
        Asker { f, part, rank, n_channels, incident: Vec::new(), exitant: Vec::new() }
    }

    /// A place.
    pub fn place(&mut self, place: Place) {
        let n = self.rank.dimensions() - 2;
        let pair = (self.from([place[0], place[1]]), self.to([place[n], place[n + 1]]));
        self.push(pair);
    }

    /// The middles of the children of a cell, in order. What they share is computed once.
    pub fn middles(&mut self, level: u32, cell: [u32; 4]) {
        let scale = 0.5f64.powi(level as i32 + 1);
        let middle = |i: usize, half: usize| (f64::from(cell[i] << 1 | half as u32) + 0.5) * scale;
        let n = self.rank.dimensions() - 2;
        let halves = |i: usize, k: usize| [middle(i, k & 1), middle(i + 1, k >> 1)];
        let from: [Direction; 4] = std::array::from_fn(|k| self.from(halves(0, k)));
        let to: [Direction; 4] = std::array::from_fn(|k| self.to(halves(n, k)));
        for child in 0..self.rank.n_children() {
            self.push((from[child & ((1 << n) - 1)], to[child >> n]));
        }
    }

    /// How many places [`Asker::scattered`] names.
    pub fn n_scattered(&self) -> usize {
        match self.rank {
            Rank::Three => 8,
            Rank::Four => 4,
        }
    }

    /// Places all over a cell that hang on nothing else, each in a child of its own: at rank 4 in four of them, two in each half along
    /// each dimension.
    pub fn scattered(&mut self, level: u32, cell: [u32; 4]) {
        const SPREAD: [usize; 4] = [0b0000, 0b0110, 0b1011, 0b1101];
        let mut state = cell.iter().fold(0x9e37_79b9_7f4a_7c15, |state, &c| mixed(state ^ u64::from(c)));
        let change = state as usize & 15;
        let scale = 0.5f64.powi(level as i32 + 1);
        for k in 0..self.n_scattered() {
            let child = match self.rank {
                Rank::Three => k,
                Rank::Four => SPREAD[k] ^ change,
            };
            let corner = child_cell(cell, child);
            self.place(corner.map(|corner| {
                state = mixed(state);
                (f64::from(corner) + (state >> 11) as f64 / (1u64 << 53) as f64) * scale
            }));
        }
    }

    /// What the function says of all places that were named.
    pub fn answers(&mut self) -> Result<Vec<f64>, FunctionError<E>> {
        let mut values = vec![0.0; self.incident.len() * self.n_channels];
        (self.f)(&self.incident, &self.exitant, &mut values).map_err(FunctionError::Function)?;
        if let Some(k) = values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
            let at = k / self.n_channels;
            let (incident, exitant) = (self.incident[at], self.exitant[at]);
            return Err(FunctionError::Value { incident, exitant, value: values[k] });
        }
        self.incident.clear();
        self.exitant.clear();
        Ok(values)
    }

    /// The incident direction at the first coordinates of a place.
    fn from(&self, [a, b]: [f64; 2]) -> Direction {
        let side = self.part.incident_side();
        match self.rank {
            Rank::Four => side.direction_from_disk(disk_from_square([a, b]).map(|c| -c)),
            Rank::Three => side.direction_from_disk([-(1.0 - 2.0 * a).clamp(0.0, 1.0), 0.0]),
        }
    }

    /// The exitant direction at the last two.
    fn to(&self, square: [f64; 2]) -> Direction {
        self.part.exitant_side().direction_from_disk(disk_from_square(square))
    }

    fn push(&mut self, (incident, exitant): (Direction, Direction)) {
        self.incident.push(incident);
        self.exitant.push(exitant);
    }
}

/// SplitMix64 (G. Steele et al., OOPSLA 2014).
fn mixed(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
