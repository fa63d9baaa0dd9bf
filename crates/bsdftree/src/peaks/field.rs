//! What light from one direction does, as cells that know their neighbours.
//!
//! In: a tree or a matrix and one of its incident cells. Out: exitant cells with value, projected solid angle and mean
//! direction, and which cells touch which, over corners too. Invariant: the areas add up to π.
//! Cells of a tree finer than [`MAX_LOG2_RES`] are averaged: 2^9 cells per axis are 0.2°, narrower than the sun.

use std::f64::consts::PI;

use crate::direction::{Direction, Side, normalized};
use crate::klems::{Basis, Matrix};
use crate::square::disk_from_square;
use crate::tree::{Content, Rank, Slot, Tree};

/// Finest cells that are told apart.
const MAX_LOG2_RES: u32 = 9;

/// An exitant cell over one incident cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Value \[1/sr\].
    pub value: f64,
    /// Projected solid angle \[sr\].
    pub area: f64,
    /// Mean direction of the exitant cell by projected solid angle; as if to the front.
    pub exitant: Direction,
    /// Mean of (−x, −y, |z|) of the incident directions that this value stands for: a coarse leaf stands for many
    /// cells.
    pub onward: Direction,
}

/// The exitant cells of one incident direction.
pub(super) struct Field<'a> {
    pub cells: Vec<Cell>,
    layout: Layout<'a>,
}

enum Layout<'a> {
    /// Lower corner and edge of each cell in pixels of a square image of 2^log2 per axis, and the cell of each pixel.
    Square { log2: u32, blocks: Vec<[u32; 3]>, image: Vec<u32> },
    /// Touching patches, by patch.
    Patches(&'a [Vec<u32>]),
}

impl Field<'_> {
    /// Calls `visit` with each cell that touches a cell, maybe more than once.
    pub fn for_neighbours(&self, cell: u32, mut visit: impl FnMut(u32)) {
        match &self.layout {
            Layout::Patches(neighbours) => neighbours[cell as usize].iter().for_each(|&k| visit(k)),
            Layout::Square { log2, blocks, image } => {
                let n = 1i64 << log2;
                let [x, y, edge] = blocks[cell as usize].map(i64::from);
                let mut pixel = |x: i64, y: i64| {
                    if (0..n).contains(&x) && (0..n).contains(&y) {
                        visit(image[(y << log2 | x) as usize]);
                    }
                };
                for k in -1..=edge {
                    pixel(x + k, y - 1);
                    pixel(x + k, y + edge);
                }
                for k in 0..edge {
                    pixel(x - 1, y + k);
                    pixel(x + edge, y + k);
                }
            }
        }
    }
}

/// The incident cells of a tree or matrix that are looked at, and which of them touch.
pub(super) struct Incident<'a> {
    source: Source<'a>,
    /// The mean of (−x, −y, |z|) of each.
    pub onward: Vec<Direction>,
    /// Those that touch, by incident cell.
    pub neighbours: Vec<Vec<u32>>,
    /// Touching exitant patches of a matrix.
    patches: Vec<Vec<u32>>,
}

enum Source<'a> {
    /// With the incident cells at the tree's own resolution.
    Tree(&'a Tree, Vec<[u32; 2]>),
    Matrix(&'a Matrix),
}

impl<'a> Incident<'a> {
    /// Evenly spread finest incident cells of a tree, at most 2^log2 per axis.
    pub fn of_tree(tree: &'a Tree, log2: u32) -> Incident<'a> {
        let log2_res = tree.arena().log2_res();
        let log2 = log2.min(log2_res);
        // The finest cell above the middle of each coarse one.
        let finest =
            |k: u32| (k << (log2_res - log2)) + if log2 < log2_res { 1 << (log2_res - log2 - 1) } else { 0 };
        let n = 1u32 << log2;
        let (cells, neighbours): (Vec<_>, Vec<_>) = match tree.rank() {
            // The half d0 ≥ ½ is not used.
            Rank::Three => {
                let n = (n / 2).max(1);
                let near = |k: u32| (k.saturating_sub(1)..(k + 2).min(n)).filter(move |&j| j != k);
                (0..n).map(|k| ([finest(k), 0], near(k).collect())).unzip()
            }
            Rank::Four => {
                let near = |k: u32| k.saturating_sub(1)..(k + 2).min(n);
                let around = |x: u32, y: u32| {
                    near(y)
                        .flat_map(move |j| near(x).map(move |i| j * n + i))
                        .filter(move |&k| k != y * n + x)
                };
                let cell = |k: u32| ([finest(k % n), finest(k / n)], around(k % n, k / n).collect());
                (0..n * n).map(cell).unzip()
            }
        };
        let onward = cells.iter().map(|&cell| incident_mean(tree.rank(), cell, log2_res)).collect();
        Incident { source: Source::Tree(tree, cells), onward, neighbours, patches: Vec::new() }
    }

    /// All incident patches of a matrix.
    pub fn of_matrix(matrix: &'a Matrix) -> Incident<'a> {
        let neighbours = touching(matrix.incident());
        let patches = if matrix.incident() == matrix.exitant() {
            neighbours.clone()
        } else {
            touching(matrix.exitant())
        };
        Incident {
            source: Source::Matrix(matrix),
            onward: patch_means(matrix.incident()),
            neighbours,
            patches,
        }
    }

    /// What light in one of the incident cells does.
    pub fn field(&self, index: usize) -> Field<'_> {
        match &self.source {
            Source::Tree(tree, cells) => tree_field(tree, cells[index]),
            Source::Matrix(matrix) => {
                let basis = matrix.exitant();
                let n = basis.n_patches();
                let cells = patch_means(basis).into_iter().enumerate().map(|(k, exitant)| Cell {
                    value: f64::from(matrix.values()[index * n + k]),
                    area: basis.projected_solid_angle(k),
                    exitant,
                    onward: self.onward[index],
                });
                Field { cells: cells.collect(), layout: Layout::Patches(&self.patches) }
            }
        }
    }
}

/// (−x, −y, |z|) in the middle of an incident cell of edge 2^-level. Rank 3 has it along +X.
fn incident_mean(rank: Rank, [a, b]: [u32; 2], level: u32) -> Direction {
    match rank {
        Rank::Three => {
            // A leaf over both halves is used for all polar angles, of which √½ is the middle in projected solid angle.
            let middle = (f64::from(a) + 0.5) * 0.5f64.powi(level as i32);
            Side::Front
                .direction_from_disk([if level == 0 { 0.5f64.sqrt() } else { 1.0 - 2.0 * middle }, 0.0])
        }
        Rank::Four => cell_mean([a, b], level),
    }
}

/// Mean direction of a cell of the square: by Gauss's rule of two points along each axis.
fn cell_mean(cell: [u32; 2], level: u32) -> Direction {
    let at =
        |k: u32, sign: f64| (f64::from(k) + 0.5 + sign * (1.0f64 / 12.0).sqrt()) * 0.5f64.powi(level as i32);
    let mut sum = [0.0; 3];
    for (s, t) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let point = Side::Front.direction_from_disk(disk_from_square([at(cell[0], s), at(cell[1], t)]));
        (0..3).for_each(|k| sum[k] += point[k]);
    }
    normalized(sum).expect("its z is positive")
}

struct Walk<'a> {
    tree: &'a Tree,
    incident: [u32; 2],
    cells: Vec<Cell>,
    blocks: Vec<[u32; 3]>,
    /// In units of 2^-MAX_LOG2_RES until the finest level is known.
    finest: u32,
}

fn tree_field(tree: &Tree, incident: [u32; 2]) -> Field<'static> {
    let mut walk = Walk { tree, incident, cells: Vec::new(), blocks: Vec::new(), finest: 0 };
    walk.descend(tree.arena().root(), 0, [0, 0]);
    let Walk { cells, mut blocks, finest: log2, .. } = walk;
    let mut image = vec![0; 1 << (2 * log2)];
    for (k, block) in blocks.iter_mut().enumerate() {
        let [x, y, edge] = block.map(|c| c >> (MAX_LOG2_RES - log2));
        *block = [x, y, edge];
        for row in y..y + edge {
            image[(row << log2 | x) as usize..][..edge as usize].fill(k as u32);
        }
    }
    Field { cells, layout: Layout::Square { log2, blocks, image } }
}

impl Walk<'_> {
    fn descend(&mut self, slot: Slot, level: u32, [x, y]: [u32; 2]) {
        match slot.content() {
            Content::Node(node) if level < MAX_LOG2_RES => {
                for k in 0..4 {
                    let child = self.child(node, level, k);
                    self.descend(child, level + 1, [x << 1 | k & 1, y << 1 | k >> 1]);
                }
            }
            _ => {
                let (arena, rank) = (self.tree.arena(), self.tree.rank());
                let up = arena.log2_res().saturating_sub(level);
                let onward = incident_mean(rank, self.incident.map(|c| c >> up), level);
                let area = PI * 0.25f64.powi(level as i32);
                let exitant = cell_mean([x, y], level);
                self.cells.push(Cell { value: self.mean(slot, level), area, exitant, onward });
                self.blocks.push([x, y, 1].map(|c| c << (MAX_LOG2_RES - level)));
                self.finest = self.finest.max(level);
            }
        }
    }

    /// The child of a node in an exitant quadrant.
    fn child(&self, node: u32, level: u32, quadrant: u32) -> Slot {
        let arena = self.tree.arena();
        let bit = |c: u32| (c >> (arena.log2_res() - 1 - level) & 1) as usize;
        let (fixed, shift) = match self.tree.rank() {
            Rank::Three => (bit(self.incident[0]), 1),
            Rank::Four => (bit(self.incident[0]) | bit(self.incident[1]) << 1, 2),
        };
        arena.child(node, fixed | (quadrant as usize) << shift)
    }

    fn mean(&self, slot: Slot, level: u32) -> f64 {
        match slot.content() {
            Content::Leaf(value) => f64::from(value),
            Content::Node(node) => {
                0.25 * (0..4).map(|k| self.mean(self.child(node, level, k), level + 1)).sum::<f64>()
            }
        }
    }
}

/// The mean direction of each patch.
fn patch_means(basis: &Basis) -> Vec<Direction> {
    let mut means = Vec::with_capacity(basis.n_patches());
    for ring in basis.rings() {
        let n = f64::from(ring.n_phi);
        let [a, b] = ring.bounds_deg.map(|t| t.to_radians().sin());
        let [c, d] = ring.bounds_deg.map(|t| t.to_radians().cos());
        // Of a sector of half-angle π/n; the whole disk's is its middle.
        let flat = if ring.n_phi == 1 { 0.0 } else { (PI / n).sin() / (PI / n) };
        let r = 2.0 / 3.0 * (b * b + a * b + a * a) / (a + b) * flat;
        let z = 2.0 / 3.0 * (c * c + c * d + d * d) / (c + d);
        means.extend((0..ring.n_phi).map(|k| {
            let phi = 2.0 * PI * f64::from(k) / n;
            normalized([r * phi.cos(), r * phi.sin(), z]).expect("its z is positive")
        }));
    }
    means
}

/// The patches that touch each patch.
fn touching(basis: &Basis) -> Vec<Vec<u32>> {
    let rings = basis.rings();
    let firsts: Vec<u32> = rings
        .iter()
        .scan(0, |next, ring| {
            *next += ring.n_phi;
            Some(*next - ring.n_phi)
        })
        .collect();
    let mut all = Vec::with_capacity(basis.n_patches());
    for (r, ring) in rings.iter().enumerate() {
        let n = ring.n_phi;
        for k in 0..n {
            let mut near = Vec::new();
            if n > 1 {
                near.extend([firsts[r] + (k + 1) % n, firsts[r] + (k + n - 1) % n]);
            }
            for other in [r.checked_sub(1), Some(r + 1)].into_iter().flatten().filter(|&o| o < rings.len()) {
                near.extend(overlapping(k, n, rings[other].n_phi).map(|j| firsts[other] + j));
            }
            near.sort_unstable();
            near.dedup();
            all.push(near);
        }
    }
    all
}

/// The patches of a ring of `m` whose azimuths meet those of patch `k` of `n`.
fn overlapping(k: u32, n: u32, m: u32) -> impl Iterator<Item = u32> {
    // Middles lie at k/n and j/m of the circle, half-widths are 1/2n and 1/2m; over corners too.
    let (middle, reach) = (f64::from(k) / f64::from(n), 0.5 / f64::from(n) + 0.5 / f64::from(m) + 1e-9);
    let first = ((middle - reach) * f64::from(m)).ceil() as i64;
    let last = ((middle + reach) * f64::from(m)).floor() as i64;
    (first..=last).take(m as usize).map(move |j| j.rem_euclid(i64::from(m)) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn areas_of_a_field_add_up_to_the_hemisphere() {
        let values: Vec<f32> = (0..4096).map(|k| ((k * 7919) % 13) as f32).collect();
        let tree = Tree::from_grid(Rank::Four, &values).unwrap();
        let basis = Arc::new(Basis::half());
        let matrix = Matrix::new(Arc::clone(&basis), basis, vec![0.1; 77 * 77]).unwrap();
        for incident in [Incident::of_tree(&tree, 2), Incident::of_matrix(&matrix)] {
            for k in 0..incident.onward.len() {
                let sum: f64 = incident.field(k).cells.iter().map(|c| c.area).sum();
                assert!((sum - PI).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn touching_is_mutual() {
        for basis in [Basis::full(), Basis::half_73(), Basis::quarter().subdivided(2).unwrap()] {
            let near = touching(&basis);
            assert!(near.iter().all(|n| n.len() >= 3));
            for (k, list) in near.iter().enumerate() {
                assert!(list.iter().all(|&j| near[j as usize].contains(&(k as u32)) && j as usize != k));
            }
        }
    }

    #[test]
    fn cells_of_a_tree_touch_their_eight_neighbours() {
        let values: Vec<f32> = (0..4096).map(|k| k as f32).collect();
        let tree = Tree::from_grid(Rank::Four, &values).unwrap();
        let incident = Incident::of_tree(&tree, 3);
        let field = incident.field(17);
        let mut counts = [0; 9];
        for k in 0..field.cells.len() {
            let mut near = Vec::new();
            field.for_neighbours(k as u32, |j| near.push(j));
            counts[near.len()] += 1;
        }
        // Corners, sides, the inside of 8 × 8.
        assert_eq!([counts[3], counts[5], counts[8]], [4, 24, 36]);
    }

    #[test]
    fn leaves_below_the_finest_cells_are_averaged() {
        // One bright leaf in the corner, 12 levels down; its branch over incident cell 0.
        let mut builder = crate::tree::TreeBuilder::new(Rank::Four);
        let mut slot = Slot::leaf(4096.0);
        for _ in 0..12 {
            let mut children = [Slot::leaf(0.0); 16];
            children[0] = slot;
            slot = builder.node(&children).unwrap();
        }
        let tree = Tree::new(builder.finish(slot));
        let field = tree_field(&tree, [0, 0]);
        let flux: f64 = field.cells.iter().map(|c| c.value * c.area).sum();
        assert!((flux - 4096.0 * PI * 0.25f64.powi(12)).abs() < 1e-12);
        let most = field.cells.iter().map(|c| c.value).fold(0.0, f64::max);
        assert_eq!(most, 4096.0 / 64.0);
    }
}
