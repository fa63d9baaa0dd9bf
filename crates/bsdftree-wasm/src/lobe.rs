//! What surfaces of radius f(ω) are made of: a hemisphere as a net whose knots lie at the middles of the cells of a square grid, n × n, and on its border,
//! so that no leaf of a tree of that resolution is missed and the net reaches the horizon.
//!
//! In: a [`Band`], an incident direction, n. Out: one item for each of (n + 2)² knots, the first coordinate slowest.

use bsdftree::square::disk_from_square;
use bsdftree::{Band, Direction, Side};

use crate::view::{Tone, pixels, values};

/// The finest net.
const MOST_CELLS: usize = 512;

/// How far the border's knots stay off the horizon, where sides meet, in coordinates of the square.
const BORDER: f64 = 1e-6;

/// The directions of the knots.
pub fn knots(side: Side, n: usize) -> Vec<Direction> {
    let n = n.clamp(1, MOST_CELLS);
    let place = |k: usize| ((k as f64 - 0.5) / n as f64).clamp(BORDER, 1.0 - BORDER);
    let all = (0..n + 2).flat_map(|k| (0..n + 2).map(move |l| (k, l)));
    all.map(|(k, l)| side.direction_from_disk(disk_from_square([place(k), place(l)]))).collect()
}

/// Values \[1/sr\] at the knots. Those that are not on the border have the largest of `per_knot` × `per_knot` places of their cell, so that a coarse net
/// has narrow peaks too.
pub fn lobe(band: &Band, incident: Direction, side: Side, n: usize, per_knot: usize) -> Vec<f32> {
    let n = n.clamp(1, MOST_CELLS);
    let per_knot = per_knot.clamp(1, MOST_CELLS.div_ceil(n));
    let mut net = values(band, incident, &knots(side, n));
    if per_knot == 1 {
        return net;
    }
    let fine = values(band, incident, &knots(side, n * per_knot));
    let width = n * per_knot + 2;
    for (place, value) in net.iter_mut().enumerate() {
        let (k, l) = (place / (n + 2), place % (n + 2));
        if (1..=n).contains(&k) && (1..=n).contains(&l) {
            let (row, column) = ((k - 1) * per_knot + 1, (l - 1) * per_knot + 1);
            let cell = (row..row + per_knot).flat_map(|row| &fine[row * width + column..][..per_knot]);
            *value = cell.copied().fold(0.0, f32::max);
        }
    }
    net
}

/// Pixels of sRGB with alpha at the knots.
pub fn lobe_colours(band: &Band, incident: Direction, side: Side, n: usize, tone: Tone) -> Vec<u8> {
    pixels(band, incident, &knots(side, n), tone).concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdftree::{Component, Part, Rank, Tree};

    #[test]
    fn every_leaf_has_a_knot() {
        let n = 8_usize;
        let incident = [0.1, 0.2, 0.95_f64.sqrt()];
        for k in 0..n * n {
            // One exitant cell of all incident ones.
            let values: Vec<f32> =
                (0..n.pow(4)).map(|place| f32::from(u8::from(place % (n * n) == k))).collect();
            let mut band = Band::new("Visible");
            band.insert(
                Part::ReflectionBack,
                Component::grey(Tree::from_grid(Rank::Four, &values).unwrap().into()),
            );
            let found = lobe(&band, incident, Side::Front, n, 1);
            assert_eq!(found.len(), (n + 2) * (n + 2));
            assert_eq!(found[(k / n + 1) * (n + 2) + k % n + 1], 1.0, "{k}");
            let coarse = lobe(&band, incident, Side::Front, n / 4, 4);
            assert_eq!(coarse[(k / n / 4 + 1) * (n / 4 + 2) + k % n / 4 + 1], 1.0, "{k}");
        }
    }

    #[test]
    fn the_net_reaches_the_horizon_on_its_own_side() {
        let knots = knots(Side::Back, 16);
        assert!(knots.iter().all(|&[x, y, z]| z < 0.0 && (x * x + y * y + z * z - 1.0).abs() < 1e-9));
        assert!(knots[..18].iter().all(|&[_, _, z]| z > -0.01));
    }
}
