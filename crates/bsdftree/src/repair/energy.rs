//! Directions that scatter more than they bring, scaled down.
//!
//! Every pair of directions is multiplied by the smaller of the factors that its two ends ask for, 1/total where a total is over 1. That keeps
//! what is reciprocal reciprocal, and no total over 1. Leaves over which the factor varies by over 2 % are divided.

use super::side_of_reverse;
use super::values::{mapped_patches, of_light};
use crate::bsdf::{Band, Component, Part, Scattering};
use crate::check::energy;
use crate::direction::{Direction, Side};
use crate::klems::{Basis, Matrix};
use crate::query::Lobes;
use crate::square::disk_from_square;
use crate::tree::{Arena, Content, Rank, Slot, Tree, TreeBuilder, child_cell};

/// What a factor may vary over a leaf.
const VARIATION: f64 = 0.02;
/// Totals that are over 1 by less are rounded.
const ROUNDING: f64 = 1e-6;
/// Finest resolution at which factors of trees are known.
const MAX_LOG2: u32 = 8;
/// Where totals are means over cells that do not fit each other, it takes more than one round.
const MAX_ROUNDS: usize = 8;

/// Scales a band down until no direction scatters more than it brings.
pub(super) fn scale_down(band: &mut Band) -> bool {
    for _ in 0..MAX_ROUNDS {
        let sides = [Side::Front, Side::Back];
        let most = sides.into_iter().filter_map(|side| Some(energy(band, side)?.max)).fold(0.0, f64::max);
        if most <= 1.0 + ROUNDING {
            return true;
        }
        let made: Vec<(Part, Component)> =
            band.components().map(|(part, component)| (part, scaled(band, component, part))).collect();
        for (part, component) in made {
            band.insert(part, component);
        }
    }
    true
}

fn scaled(band: &Band, component: &Component, part: Part) -> Component {
    let sides = [part.incident_side(), side_of_reverse(part)];
    match &component.luminance {
        Scattering::Tree(tree) => {
            let factors = sides.map(|side| Factors::new(band, tree, side));
            of_light(component, |f| match f {
                Scattering::Tree(tree) => limited(tree, &factors).into(),
                Scattering::Matrix(_) => f.clone(),
            })
        }
        Scattering::Matrix(matrix) => {
            let [incident, exitant] = patch_factors(band, matrix, sides);
            of_light(component, |f| match f {
                Scattering::Matrix(m) => mapped_patches(m, |i, o, v| v * incident[i].min(exitant[o])).into(),
                Scattering::Tree(_) => f.clone(),
            })
        }
    }
}

/// What a total asks for.
fn factor(total: f64) -> f64 {
    if total > 1.0 { (1.0 - 0.5 * ROUNDING) / total } else { 1.0 }
}

fn patch_factors(band: &Band, matrix: &Matrix, [from, to]: [Side; 2]) -> [Vec<f64>; 2] {
    let of = |basis: &Basis, side: Side, sign: f64| -> Vec<f64> {
        let total = |k: usize| {
            let direction = side.direction_from_disk(basis.disk_point(k, 0.5, 0.5).map(|c| sign * c));
            factor(band.hemispherical(direction, Lobes::All))
        };
        (0..basis.n_patches()).map(total).collect()
    };
    [of(matrix.incident(), from, -1.0), of(matrix.exitant(), to, 1.0)]
}

/// Factors of all incident directions of a side: smallest and largest in each cell of each level, x slow. Isotropic: in rings, level by level.
struct Factors {
    log2: u32,
    levels: Vec<Vec<[f64; 2]>>,
}

impl Factors {
    fn new(band: &Band, tree: &Tree, side: Side) -> Factors {
        let log2 = tree.arena().log2_res().clamp(1, MAX_LOG2);
        let directions: Vec<Direction> = match tree.rank() {
            Rank::Four => {
                let n = 1usize << log2;
                let at = |k: usize| (k as f64 + 0.5) / n as f64;
                let disk = |k: usize| disk_from_square([at(k / n), at(k % n)]).map(|c| -c);
                (0..n * n).map(|k| side.direction_from_disk(disk(k))).collect()
            }
            Rank::Three => {
                let n = 1usize << (log2 - 1);
                (0..n).map(|k| side.direction_from_disk([-(k as f64 + 0.5) / n as f64, 0.0])).collect()
            }
        };
        let mut totals = vec![0.0; directions.len()];
        for lobes in [Lobes::Reflection, Lobes::Transmission] {
            let mut part = vec![0.0; directions.len()];
            for (_, function, reversed) in band.exits(directions[0], lobes) {
                function.hemispherical_many(&directions, reversed, &mut part);
            }
            totals.iter_mut().zip(part).for_each(|(total, part)| *total += part);
        }
        let finest = totals.into_iter().map(|total| [factor(total); 2]).collect();
        Factors::with_coarser(finest, log2, tree.rank())
    }

    fn with_coarser(finest: Vec<[f64; 2]>, log2: u32, rank: Rank) -> Factors {
        let both = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let mut levels = vec![finest];
        if rank == Rank::Four {
            for level in (0..log2).rev() {
                let n = 1usize << level;
                let below = &levels[levels.len() - 1];
                let child =
                    |k: usize, dx: usize, dy: usize| below[(2 * (k / n) + dx) * 2 * n + 2 * (k % n) + dy];
                let merged =
                    |k| both(both(child(k, 0, 0), child(k, 0, 1)), both(child(k, 1, 0), child(k, 1, 1)));
                levels.push((0..n * n).map(merged).collect());
            }
            levels.reverse();
        }
        Factors { log2, levels }
    }

    /// Over a cell of the incident square.
    fn in_cell(&self, level: u32, [x, y]: [u32; 2]) -> [f64; 2] {
        let up = level.saturating_sub(self.log2);
        let level = level - up;
        self.levels[level as usize][(((x >> up) << level) | (y >> up)) as usize]
    }

    /// Over a ring of radii.
    fn in_ring(&self, [inner, outer]: [f64; 2]) -> [f64; 2] {
        let rings = &self.levels[0];
        let n = rings.len();
        let first = ((inner * n as f64 + 1e-9) as usize).min(n - 1);
        let end = ((outer * n as f64 - 1e-9).ceil() as usize).clamp(first + 1, n);
        rings[first..end].iter().fold([1.0, 0.0], |[a, b], r| [a.min(r[0]), f64::max(b, r[1])])
    }
}

/// Smallest and largest factor over a leaf.
fn range(rank: Rank, [incident, exitant]: &[Factors; 2], level: u32, cell: [u32; 4]) -> [f64; 2] {
    let (a, b) = match rank {
        Rank::Four => {
            let opposite = |c: u32| (1u32 << level) - 1 - c;
            let there = [opposite(cell[2]), opposite(cell[3])];
            (incident.in_cell(level, [cell[0], cell[1]]), exitant.in_cell(level, there))
        }
        Rank::Three => {
            let edge = 0.5f64.powi(level as i32);
            let bounds = |c: u32| [f64::from(c) * edge, f64::from(c + 1) * edge];
            let [lower, upper] = bounds(cell[0]);
            let half = |c: u32| {
                let [a, b] = bounds(c).map(|d| (2.0 * d - 1.0).abs());
                [if level == 0 { 0.0 } else { a.min(b) }, a.max(b)]
            };
            let [p, q] = [half(cell[1]), half(cell[2])];
            let radii = [(1.0 - 2.0 * upper).max(0.0), (1.0 - 2.0 * lower).max(0.0)];
            (incident.in_ring(radii), exitant.in_ring([p[0].max(q[0]), p[1].max(q[1])]))
        }
    };
    [a[0].min(b[0]), a[1].min(b[1])]
}

fn limited(tree: &Tree, factors: &[Factors; 2]) -> Tree {
    fn grow(
        arena: &Arena,
        slot: Slot,
        (level, cell): (u32, [u32; 4]),
        factors: &[Factors; 2],
        builder: &mut TreeBuilder,
    ) -> Slot {
        let content = slot.content();
        if let Content::Leaf(value) = content {
            let [least, most] = range(arena.rank(), factors, level, cell);
            if value == 0.0 || most - least <= VARIATION || level >= factors[0].log2 {
                return Slot::leaf((f64::from(value) * least) as f32);
            }
        }
        let n = arena.rank().n_children();
        let mut children = [slot; 16];
        for (k, child) in children[..n].iter_mut().enumerate() {
            let inside = match content {
                Content::Leaf(_) => slot,
                Content::Node(node) => arena.child(node, k),
            };
            *child = grow(arena, inside, (level + 1, child_cell(cell, k)), factors, builder);
        }
        builder.node_or_leaf(&children[..n]).expect("no deeper than the finest of the band's trees")
    }
    let mut builder = TreeBuilder::new(tree.rank());
    let root = grow(tree.arena(), tree.arena().root(), (0, [0; 4]), factors, &mut builder);
    Tree::new(builder.finish(root))
}
