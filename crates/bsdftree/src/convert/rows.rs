//! A rank-4 tree from its rows: all exitant cells of one incident cell at a time.
//!
//! In: a function from an incident cell of the finest level to the values of all exitant cells, the first coordinate slowest. Out: the
//! root of the tree. Four incident cells make one of the next coarser level at once, so only 4 rows of each level are in memory.

use super::grow::{Branch, Grower};
use crate::tree::TreeError;

/// Grows a tree of 2^log2_res cells per axis.
pub(super) fn from_rows(
    log2_res: u32,
    grower: &mut Grower,
    row: &mut dyn FnMut([u32; 2]) -> Vec<f64>,
) -> Result<Branch, TreeError> {
    let root = block(0, [0, 0], log2_res, grower, row)?;
    Ok(root[0])
}

/// What becomes of an incident cell of a level, for each exitant cell of this level.
fn block(
    level: u32,
    incident: [u32; 2],
    log2_res: u32,
    grower: &mut Grower,
    row: &mut dyn FnMut([u32; 2]) -> Vec<f64>,
) -> Result<Vec<Branch>, TreeError> {
    if level == log2_res {
        return Ok(row(incident).into_iter().map(|v| grower.leaf(v, level, incident[0])).collect());
    }
    let mut below = Vec::with_capacity(4);
    for k in 0..4 {
        let child = [incident[0] << 1 | (k & 1), incident[1] << 1 | k >> 1];
        below.push(block(level + 1, child, log2_res, grower, row)?);
    }
    let n = 1usize << level;
    let mut branches = Vec::with_capacity(n * n);
    for (x, y) in (0..n).flat_map(|x| (0..n).map(move |y| (x, y))) {
        let children: [Branch; 16] = std::array::from_fn(|k| {
            let (p, q) = (x << 1 | (k >> 2 & 1), y << 1 | k >> 3);
            below[k & 3][p << (level + 1) | q]
        });
        branches.push(grower.join(&children)?);
    }
    Ok(branches)
}
