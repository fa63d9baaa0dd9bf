//! Matrices as trees, and trees as coarser ones.
//!
//! A value is the mean over its cell of the function, by projected solid angle, so no light is lost; cells on a border between patches
//! mix them. How much that costs is what [`super::relative_l1`] measures: patches have borders everywhere, so
//! a matrix over 145 patches needs 2^6 cells per axis or more.

use super::ConvertError;
use super::grow::{Branch, Grower};
use super::isotropic::Isotropic;
use super::overlap::Overlap;
use crate::bsdf::Scattering;
use crate::klems::Matrix;
use crate::tree::{Content, Rank, Slot, Tree, TreeError, child_cell};

/// A function as a tree of at most 2^log2_res cells per axis.
pub(super) fn tree(
    function: &Scattering,
    rank: Rank,
    log2_res: u32,
    tolerance: f64,
) -> Result<Tree, ConvertError> {
    Ok(match (function, rank) {
        (Scattering::Matrix(matrix), Rank::Four) => from_matrix(matrix, log2_res, tolerance)?,
        (Scattering::Matrix(matrix), Rank::Three) => {
            Isotropic::of_matrix(matrix).tree(log2_res, tolerance)?
        }
        (Scattering::Tree(tree), rank) if tree.rank() == rank => coarsened(tree, log2_res, tolerance)?,
        (Scattering::Tree(tree), _) => return Err(ConvertError::Ranks { from: tree.rank().dimensions() }),
    })
}

fn from_matrix(matrix: &Matrix, log2_res: u32, tolerance: f64) -> Result<Tree, TreeError> {
    let overlaps = [matrix.incident(), matrix.exitant()].map(|basis| Overlap::new(basis, log2_res));
    let [incident, exitant] = overlaps.each_ref().map(Overlap::areas);
    let n = exitant.len();
    let mean: f64 = matrix
        .values()
        .chunks_exact(n)
        .zip(incident)
        .map(|(row, area)| area * row.iter().zip(exitant).map(|(&v, a)| f64::from(v) * a).sum::<f64>())
        .sum();
    let mut growth =
        Growth { matrix, overlaps: &overlaps, log2_res, grower: Grower::new(Rank::Four, tolerance, mean) };
    let root = growth.grow(0, [0; 4])?;
    Ok(growth.grower.finish(root))
}

/// A rank-4 tree being grown from a matrix.
struct Growth<'a> {
    matrix: &'a Matrix,
    overlaps: &'a [Overlap; 2],
    log2_res: u32,
    grower: Grower,
}

impl Growth<'_> {
    fn grow(&mut self, level: u32, cell: [u32; 4]) -> Result<Branch, TreeError> {
        let [a, b, c, d] = cell;
        let (incident, p) = self.overlaps[0].row(level, [a, b]);
        let (exitant, q) = self.overlaps[1].row(level, [c, d]);
        let n = self.overlaps[1].areas().len();
        let values = self.matrix.values();
        let row = |i: u32| &values[i as usize * n..][..n];
        let first = row(incident[0].0)[exitant[0].0 as usize];
        let is_one = incident.iter().all(|&(i, _)| exitant.iter().all(|&(o, _)| row(i)[o as usize] == first));
        if is_one {
            return Ok(self.grower.leaf(f64::from(first), level, a));
        }
        if level == self.log2_res {
            let light =
                |i: u32| exitant.iter().map(|&(o, area)| f64::from(row(i)[o as usize]) * area).sum::<f64>();
            let sum: f64 = incident.iter().map(|&(i, area)| area * light(i)).sum();
            return Ok(self.grower.leaf(sum * p * q * 16f64.powi(level as i32), level, a));
        }
        let mut children = [self.grower.unread(); 16];
        for (k, child) in children.iter_mut().enumerate() {
            *child = self.grow(level + 1, child_cell(cell, k))?;
        }
        self.grower.join(&children)
    }
}

/// A tree with leaves of 2^-log2_res at least, joined to a tolerance.
pub(super) fn coarsened(tree: &Tree, log2_res: u32, tolerance: f64) -> Result<Tree, TreeError> {
    let mean = Coarsening { tree, log2_res: 0, grower: Grower::new(tree.rank(), 0.0, 0.0) }.grow(
        tree.arena().root(),
        0,
        0,
    )?;
    let mut coarsening =
        Coarsening { tree, log2_res, grower: Grower::new(tree.rank(), tolerance, mean.mean()) };
    let root = coarsening.grow(tree.arena().root(), 0, 0)?;
    Ok(coarsening.grower.finish(root))
}

/// A tree being grown from a finer one.
struct Coarsening<'a> {
    tree: &'a Tree,
    log2_res: u32,
    grower: Grower,
}

impl Coarsening<'_> {
    fn grow(&mut self, slot: Slot, level: u32, layer: u32) -> Result<Branch, TreeError> {
        let node = match slot.content() {
            Content::Leaf(value) => return Ok(self.grower.leaf(f64::from(value), level, layer)),
            Content::Node(node) => node,
        };
        let arena = self.tree.arena();
        let mut children = [self.grower.unread(); 16];
        for (k, branch) in children[..arena.rank().n_children()].iter_mut().enumerate() {
            *branch = self.grow(arena.child(node, k), level + 1, layer << 1 | (k as u32 & 1))?;
        }
        let children = &children[..arena.rank().n_children()];
        if level >= self.log2_res { Ok(self.grower.blend(children)) } else { self.grower.join(children) }
    }
}
