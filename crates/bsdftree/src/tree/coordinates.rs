//! From pairs of directions to places in a tree.
//!
//! * Rank 4: (d0, d1) = square(−incident.xy), (d2, d3) = square(exitant.xy): a mirror's peak and light that goes
//!   straight through both lie on the diagonal d2 = d0, d3 = d1.
//! * Rank 3: d0 = ½ − ½·sin θ_incident, so that only d0 < ½ is used; the exitant direction is turned about Z until
//!   the incident one lies in the plane y = 0, and (d1, d2) is its square.
//!
//! **A direction on the border between cells belongs to the upper cell** in each coordinate. Coordinates are rounded
//! to multiples of 2⁻⁴⁰ first, so that rounding noise does not choose the cell: normal incidence is (½, ½) and lies in
//! the upper cell of both incident dimensions. (In Radiance it lies where the last bit of the input puts it.)

use crate::direction::{Direction, Side};
use crate::square::{disk_from_square, square_from_disk, square_from_polar};
use crate::tree::arena::Rank;

/// Bits of a quantised coordinate.
pub(super) const QUANTUM_BITS: u32 = 40;

/// Radiance moves d0 of rank 3 down by this much, which puts normal incidence into the used half.
pub(super) const RANK3_SHIFT: f64 = 1e-6;

/// A place in a tree: one coordinate per dimension as a multiple of 2⁻⁴⁰; incident ones first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position(pub(super) [u64; 4]);

/// A coordinate in \[0, 1\] as a multiple of 2⁻⁴⁰.
#[inline(always)]
pub(super) fn quantized(x: f64) -> u64 {
    const QUANTA: f64 = (1u64 << QUANTUM_BITS) as f64;
    let quantum = x * QUANTA + 0.5;
    // Comparisons that NaN fails, each one instruction.
    let quantum = if quantum > 0.0 { quantum } else { 0.0 };
    let quantum = if quantum < QUANTA - 1.0 { quantum } else { QUANTA - 1.0 };
    // SAFETY: it lies in [0, 2^40).
    unsafe { quantum.to_int_unchecked::<i64>() as u64 }
}

/// The incident part of a position: (d0, d1) for rank 4, (d0, 0) for rank 3.
pub(super) fn incident_coordinates(rank: Rank, incident: Direction) -> [u64; 2] {
    match rank {
        Rank::Four => square_from_disk([-incident[0], -incident[1]]).map(quantized),
        Rank::Three => [quantized(rank3_coordinate(incident)), 0],
    }
}

/// The direction on the front whose incident coordinates these are; at rank 3 in the plane y = 0.
pub(super) fn incident_direction(rank: Rank, coordinates: [f64; 2]) -> Direction {
    let disk = match rank {
        Rank::Four => disk_from_square(coordinates),
        Rank::Three => [(1.0 - 2.0 * RANK3_SHIFT - 2.0 * coordinates[0]).max(0.0), 0.0],
    };
    Side::Front.direction_from_disk(disk.map(|x| -x))
}

/// d0 of rank 3.
#[inline(always)]
pub(super) fn rank3_coordinate(incident: Direction) -> f64 {
    0.5 - RANK3_SHIFT - 0.5 * sin_theta(incident).min(1.0)
}

#[inline(always)]
pub(super) fn sin_theta([x, y, _]: Direction) -> f64 {
    (x * x + y * y).sqrt()
}

/// Cosine and sine of the azimuth of `−incident`: rank 3 turns exitant directions back by it. (1, 0) at normal incidence.
#[inline(always)]
pub(super) fn azimuth(incident: Direction) -> [f64; 2] {
    let r = sin_theta(incident);
    let divisor = if r > 0.0 { r } else { 1.0 };
    [if r > 0.0 { -incident[0] / divisor } else { 1.0 }, if r > 0.0 { -incident[1] / divisor } else { 0.0 }]
}

/// A point turned back by [`azimuth`], except for its length: no root and no quotient to wait for.
#[inline(always)]
pub(super) fn rank3_turned(incident: Direction, [x, y]: [f64; 2]) -> [f64; 2] {
    let tilted = sin_theta(incident) > 0.0;
    let [c, s] = [if tilted { -incident[0] } else { 1.0 }, if tilted { -incident[1] } else { 0.0 }];
    [c * x + s * y, c * y - s * x]
}

/// A point turned by the azimuth with this cosine and sine.
#[inline(always)]
pub(super) fn turned([x, y]: [f64; 2], [c, s]: [f64; 2]) -> [f64; 2] {
    [c * x - s * y, s * x + c * y]
}

/// The exitant square coordinates, unquantised.
#[inline(always)]
pub(super) fn exitant_square(rank: Rank, incident: Direction, exitant: Direction) -> [f64; 2] {
    let [x, y] = [exitant[0], exitant[1]];
    match rank {
        Rank::Four => square_from_disk([x, y]),
        Rank::Three => square_from_polar(sin_theta(exitant), rank3_turned(incident, [x, y])),
    }
}

impl Position {
    /// The place of a pair of directions. Which sides they lie on does not matter here.
    #[inline]
    pub fn new(rank: Rank, incident: Direction, exitant: Direction) -> Position {
        match rank {
            Rank::Three => {
                let [p, q] = exitant_square(rank, incident, exitant).map(quantized);
                Position([quantized(rank3_coordinate(incident)), p, q, 0])
            }
            Rank::Four => {
                // Side by side, so that neither waits for the other.
                let points = [[-incident[0], -incident[1]], [exitant[0], exitant[1]]];
                let [[a, b], [p, q]] = points.map(square_from_disk);
                Position([a, b, p, q].map(quantized))
            }
        }
    }

    /// The lower corner of the cell of edge 2^-level that holds it, in units of the edge.
    pub fn corner(self, level: u32) -> [u64; 4] {
        self.0.map(|c| c >> (QUANTUM_BITS - level))
    }

    /// The place at given coordinates in \[0, 1), as many as the tree has dimensions.
    pub fn from_coordinates(coordinates: &[f64]) -> Position {
        let mut position = [0; 4];
        position.iter_mut().zip(coordinates).for_each(|(p, &x)| *p = quantized(x));
        Position(position)
    }
}
