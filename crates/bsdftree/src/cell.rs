//! Which cell of the exitant hemisphere a direction lies in, so that light into one cell can be told from that into its neighbours.
//!
//! In: a pair of directions. Out: [`Cell`]. Invariant: for one incident direction, two exitant directions have equal keys if and
//! only if one cell holds both; so what has one key has one value.

use crate::bsdf::Scattering;
use crate::direction::Direction;
use crate::klems::Matrix;
use crate::tree::{Position, Rank, Tree};

/// A cell of the exitant hemisphere, for one incident direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Tells it from the other cells of this incident direction, and from no cell of another.
    pub key: u64,
    /// BSDF \[1/sr\], no cosine.
    pub value: f64,
    /// Its extent \[sr\].
    pub projected_solid_angle: f64,
}

impl Scattering {
    /// The cell that holds the exitant direction; which sides the directions lie on does not matter here. `reversed` as in
    /// [`Scattering::eval`].
    ///
    /// A rank-3 tree that is reversed has cells bounded by circles and radii; the extent given is that of the leaf they come from.
    ///
    /// ```
    /// use bsdftree::{Rank, Scattering, Tree};
    /// // One leaf: any exitant direction is in the same cell.
    /// let function = Scattering::from(Tree::uniform(Rank::Four, 0.25));
    /// let [a, b] = [[0.0, 0.6, 0.8], [0.8, 0.0, 0.6]].map(|exitant| function.cell([0.0, 0.0, 1.0], exitant, false));
    /// assert_eq!(a, b);
    /// assert!((a.projected_solid_angle - std::f64::consts::PI).abs() < 1e-12);
    /// ```
    pub fn cell(&self, incident: Direction, exitant: Direction, reversed: bool) -> Cell {
        match self {
            Scattering::Tree(tree) => tree_cell(tree, incident, exitant, reversed),
            Scattering::Matrix(matrix) => matrix_cell(matrix, incident, exitant, reversed),
        }
    }

    /// Projected solid angle \[sr\] of the smallest cell there is, for any incident direction.
    pub fn smallest_cell(&self) -> f64 {
        match self {
            Scattering::Tree(tree) => crate::tree::leaf_area(tree.arena().log2_res()),
            Scattering::Matrix(matrix) => {
                let basis = matrix.exitant();
                (0..basis.n_patches()).map(|k| basis.projected_solid_angle(k)).fold(f64::INFINITY, f64::min)
            }
        }
    }
}

fn tree_cell(tree: &Tree, incident: Direction, exitant: Direction, reversed: bool) -> Cell {
    let (from, to) = if reversed { (exitant, incident) } else { (incident, exitant) };
    let position = Position::new(tree.rank(), from, to);
    let (value, level) = tree.leaf_at(position);
    let corner = position.corner(level);
    // What of the leaf's place varies with the exitant direction: 15 bits each suffice.
    let varying = match (tree.rank(), reversed) {
        (Rank::Four, false) => [corner[2], corner[3], 0],
        (Rank::Four, true) => [corner[0], corner[1], 0],
        (Rank::Three, false) => [corner[1], corner[2], 0],
        (Rank::Three, true) => [corner[0], corner[1], corner[2]],
    };
    let key = varying.iter().fold(u64::from(level), |key, &c| key << 15 | c);
    Cell { key, value: f64::from(value), projected_solid_angle: crate::tree::leaf_area(level) }
}

fn matrix_cell(matrix: &Matrix, incident: Direction, exitant: Direction, reversed: bool) -> Cell {
    let (from, to) = if reversed { (exitant, incident) } else { (incident, exitant) };
    let [i, o] = matrix.patches(from, to);
    Cell {
        key: if reversed { i } else { o } as u64,
        value: f64::from(matrix.values()[i * matrix.exitant().n_patches() + o]),
        projected_solid_angle: matrix.projected_solid_angle(exitant, reversed),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;
    use std::sync::Arc;

    use super::*;
    use crate::direction::{Side, direction_from_polar};
    use crate::klems::Basis;
    use crate::tree::TreeBuilder;

    /// Fine where the first and third coordinates are low, coarse elsewhere; all values differ.
    fn uneven(rank: Rank) -> Scattering {
        let mut builder = TreeBuilder::new(rank);
        let n = 1usize << (2 * rank.dimensions());
        let mut fine = |k: usize| {
            let values: Vec<f32> = (0..n).map(|j| 100.0 + (k * n + j) as f32).collect();
            builder.grid(&values, 2).unwrap()
        };
        let children: Vec<_> = (0..rank.n_children())
            .map(|k| if k & 5 == 0 { fine(k) } else { crate::tree::Slot::leaf(2.0 + k as f32) })
            .collect();
        let root = builder.node(&children).unwrap();
        Tree::new(builder.finish(root)).into()
    }

    fn klems() -> Scattering {
        let basis = Arc::new(Basis::quarter());
        let n = basis.n_patches();
        let values = (0..n * n).map(|k| 0.1 + k as f32).collect();
        Matrix::new(basis.clone(), basis, values).unwrap().into()
    }

    #[test]
    fn one_key_is_one_value_and_one_extent() {
        for function in [uneven(Rank::Four), uneven(Rank::Three), klems()] {
            for reversed in [false, true] {
                for incident in [direction_from_polar(0.3, 0.2), direction_from_polar(1.2, 4.0)] {
                    let mut found: HashMap<u64, Cell> = HashMap::new();
                    let mut seen: HashMap<u64, u64> = HashMap::new();
                    for k in 0..4000 {
                        let (u, v) = (f64::from(k) / 4000.0, f64::from(k) * 0.618_033_988_75);
                        let disk = [
                            (u.sqrt() * (v * std::f64::consts::TAU).cos()),
                            u.sqrt() * (v * std::f64::consts::TAU).sin(),
                        ];
                        let exitant = Side::Back.direction_from_disk(disk);
                        let cell = function.cell(incident, exitant, reversed);
                        assert_eq!(cell.value, function.eval(incident, exitant, reversed));
                        assert_eq!(*found.entry(cell.key).or_insert(cell), cell);
                        // All values differ, so the other way round too.
                        assert_eq!(*seen.entry(cell.value.to_bits()).or_insert(cell.key), cell.key);
                        assert!(cell.projected_solid_angle >= function.smallest_cell());
                    }
                    assert!(found.len() >= 4);
                }
            }
        }
    }
}
