//! Uniform grids: values that are none of a BSDF found, told and mended; trees of them.
//!
//! In: values row by row, dimension 0 slowest, from anyone. Out: a tree whose equal neighbours are one leaf, or which values are bad, or
//! the same values with others in place of those.

use std::fmt;

use super::{MAX_LOG2_RES, Rank, Slot, Tree, TreeBuilder, TreeError};

/// Largest value of a grid \[1/sr\]. All light in one cell of the finest tree there is, 2^15 per axis, is 4^15/π, or 3.4·10⁸.
pub const LARGEST_VALUE: f32 = 1e12;

fn is_good(value: f32) -> bool {
    (0.0..=LARGEST_VALUE).contains(&value)
}

/// Values of a grid that a BSDF cannot have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BadValues {
    /// How many values there are in all.
    pub n_values: usize,
    /// How many are not numbers.
    pub n_nan: usize,
    /// How many are infinite, or over [`LARGEST_VALUE`].
    pub n_huge: usize,
    /// How many are negative.
    pub n_negative: usize,
    /// The first one, and its index.
    pub first: (usize, f32),
    /// Where that is along each axis, and how many axes there are.
    at: ([usize; 4], usize),
}

impl BadValues {
    fn of(rank: Rank, log2: u32, values: &[f32]) -> Option<BadValues> {
        // Many at once is faster than to stop at each.
        let chunk = values.chunks(4096).position(|c| !c.iter().fold(true, |all, &v| all & is_good(v)))?;
        let index = 4096 * chunk + values[4096 * chunk..].iter().position(|&v| !is_good(v))?;
        let count = |is: &dyn Fn(f32) -> bool| values[index..].iter().filter(|&&v| is(v)).count();
        let mut at = [0; 4];
        let d = rank.dimensions();
        at[..d].iter_mut().rev().fold(index, |rest, c| {
            *c = rest & ((1 << log2) - 1);
            rest >> log2
        });
        Some(BadValues {
            n_values: values.len(),
            n_nan: count(&f32::is_nan),
            n_huge: count(&|v| v > LARGEST_VALUE || v == f32::NEG_INFINITY),
            n_negative: count(&|v| v < 0.0 && v.is_finite()),
            first: (index, values[index]),
            at: (at, d),
        })
    }
}

impl fmt::Display for BadValues {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kinds = [
            (self.n_nan, "not a number"),
            (self.n_huge, "infinite or over 1e12"),
            (self.n_negative, "negative"),
        ];
        let n: usize = kinds.iter().map(|(n, _)| n).sum();
        write!(f, "{n} of {} values of the grid cannot be those of a BSDF (", self.n_values)?;
        for (k, (n, kind)) in kinds.iter().filter(|(n, _)| *n > 0).enumerate() {
            write!(f, "{}{n} {kind}", if k > 0 { ", " } else { "" })?;
        }
        let ((at, d), (_, value)) = (self.at, self.first);
        write!(f, "); the first is {value} at index {:?}", &at[..d])
    }
}

/// The logarithm of the number of cells along each axis of a grid whose values are all good.
pub(crate) fn log2_of(rank: Rank, values: &[f32]) -> Result<u32, TreeError> {
    match bad_values(rank, values)? {
        None => log2_of_length(rank, values.len()),
        Some(bad) => Err(TreeError::BadValues(bad.into())),
    }
}

/// The values of a grid that a BSDF cannot have, if there are such.
///
/// # Errors
/// If it is no grid.
pub fn bad_values(rank: Rank, values: &[f32]) -> Result<Option<BadValues>, TreeError> {
    let log2 = log2_of_length(rank, values.len())?;
    Ok(BadValues::of(rank, log2, values))
}

fn log2_of_length(rank: Rank, len: usize) -> Result<u32, TreeError> {
    let dimensions = rank.dimensions();
    let log2 = len.checked_ilog2().unwrap_or(0) / dimensions as u32;
    match len == 1 << (dimensions as u32 * log2) && log2 <= MAX_LOG2_RES {
        true => Ok(log2),
        false => Err(TreeError::NotAGrid { len, dimensions }),
    }
}

/// Replaces the bad values of a grid: negative ones by 0, others by the mean of those that are not in the smallest block of cells of a tree
/// that has such. What was replaced, if anything was.
///
/// # Errors
/// If it is no grid, or no value is good.
pub fn mend(rank: Rank, values: &mut [f32]) -> Result<Option<BadValues>, TreeError> {
    let log2 = log2_of_length(rank, values.len())?;
    let Some(bad) = bad_values(rank, values)? else { return Ok(None) };
    for value in values.iter_mut().filter(|v| **v < 0.0 && v.is_finite()) {
        *value = 0.0;
    }
    let mut mender = Mender { d: rank.dimensions(), log2, values };
    match mender.mend(log2, [0; 4]) {
        (_, 0) => Err(TreeError::BadValues(bad.into())),
        _ => Ok(Some(bad)),
    }
}

struct Mender<'a> {
    d: usize,
    log2: u32,
    values: &'a mut [f32],
}

impl Mender<'_> {
    /// Mends a block of 2^level cells per axis that has a good value; the sum of such and how many there were.
    fn mend(&mut self, level: u32, corner: [usize; 4]) -> (f64, usize) {
        if level == 0 {
            let value = self.values[self.index(corner)];
            return if is_good(value) { (f64::from(value), 1) } else { (0.0, 0) };
        }
        let corners = self.corners(level, corner);
        let n = 1 << self.d;
        let found: Vec<_> = corners[..n].iter().map(|&corner| self.mend(level - 1, corner)).collect();
        let (sum, count) = found.iter().fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        if count > 0 {
            let empty = corners[..n].iter().zip(&found).filter(|(_, (_, count))| *count == 0);
            for (&corner, _) in empty {
                self.fill(level - 1, corner, (sum / count as f64) as f32);
            }
        }
        (sum, count)
    }

    fn fill(&mut self, level: u32, corner: [usize; 4], value: f32) {
        if level == 0 {
            let index = self.index(corner);
            self.values[index] = value;
            return;
        }
        let corners = self.corners(level, corner);
        corners[..1 << self.d].iter().for_each(|&corner| self.fill(level - 1, corner, value));
    }

    fn corners(&self, level: u32, corner: [usize; 4]) -> [[usize; 4]; 16] {
        std::array::from_fn(|k| std::array::from_fn(|i| corner[i] + ((k >> i & 1) << (level - 1))))
    }

    fn index(&self, corner: [usize; 4]) -> usize {
        corner[..self.d].iter().fold(0, |index, &c| index << self.log2 | c)
    }
}

impl Tree {
    /// A tree of a uniform grid, 2^N cells along each of `rank` axes, row-major; equal neighbours become one leaf.
    ///
    /// # Errors
    /// If the length is not (2^N)^rank, or a value is negative, not finite or over [`LARGEST_VALUE`]; [`mend`] replaces such.
    pub fn from_grid(rank: Rank, values: &[f32]) -> Result<Tree, TreeError> {
        let log2 = log2_of(rank, values)?;
        let mut builder = TreeBuilder::new(rank);
        let root = slot(&mut builder, rank.dimensions(), values, [log2, log2], [0; 4])?;
        Ok(Tree::new(builder.finish(root)))
    }
}

/// A block of 2^level cells per axis of a grid of 2^log2.
fn slot(
    builder: &mut TreeBuilder,
    d: usize,
    values: &[f32],
    [log2, level]: [u32; 2],
    corner: [usize; 4],
) -> Result<Slot, TreeError> {
    if level == 0 {
        let index = corner[..d].iter().fold(0, |index, &c| index << log2 | c);
        return Ok(Slot::leaf(values[index]));
    }
    let mut children = [Slot::leaf(0.0); 16];
    for (k, child) in children[..1 << d].iter_mut().enumerate() {
        let at = std::array::from_fn(|i| corner[i] + ((k >> i & 1) << (level - 1)));
        *child = slot(builder, d, values, [log2, level - 1], at)?;
    }
    builder.node_or_leaf(&children[..1 << d])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_values_are_counted_and_the_first_is_named() {
        let mut values = vec![0.5f32; 256];
        for (k, bad) in
            [(17, f32::NAN), (40, -2.0), (41, f32::INFINITY), (99, 1e30), (255, f32::NEG_INFINITY)]
        {
            values[k] = bad;
        }
        let error = Tree::from_grid(Rank::Four, &values).unwrap_err().to_string();
        assert!(error.contains("5 of 256 values"), "{error}");
        assert!(error.contains("(1 not a number, 3 infinite or over 1e12, 1 negative)"), "{error}");
        assert!(error.contains("the first is NaN at index [0, 1, 0, 1]"), "{error}");
    }

    #[test]
    fn bad_values_become_zero_or_the_mean_of_the_smallest_block_that_has_good_ones() {
        for rank in [Rank::Three, Rank::Four] {
            let d = rank.dimensions();
            let n = 1usize << (3 * d);
            let good: Vec<f32> = (0..n).map(|k| (k % 7) as f32).collect();
            let cell = |k: usize| (0..d).map(|i| k >> (3 * (d - 1 - i)) & 7).collect::<Vec<_>>();
            // A whole block of 2 per axis, one of 4 but for one value, and single ones.
            let is_bad = |k: usize| {
                let cell = cell(k);
                cell.iter().all(|&c| c < 2) || (cell.iter().all(|&c| c >= 4) && k != n - 1) || k == n / 2
            };
            let mut values: Vec<f32> = (0..n)
                .map(|k| if is_bad(k) { [f32::NAN, f32::INFINITY, 1e20][k % 3] } else { good[k] })
                .collect();
            values[2] = -0.1;
            let bad = mend(rank, &mut values).unwrap().expect("there are such");
            assert_eq!((bad.n_negative, bad.first.0), (1, 0));
            for k in 0..n {
                let expected = if k == 2 {
                    0.0
                } else if !is_bad(k) {
                    good[k]
                } else {
                    let block = (1..=3).find_map(|level| {
                        let inside = |j: &usize| {
                            let (a, b) = (cell(*j), cell(k));
                            (0..d).all(|i| a[i] >> level == b[i] >> level)
                        };
                        let found: Vec<f32> = (0..n)
                            .filter(|j| inside(j) && !is_bad(*j))
                            .map(|j| if j == 2 { 0.0 } else { good[j] })
                            .collect();
                        (!found.is_empty()).then(|| found.iter().sum::<f32>() / found.len() as f32)
                    });
                    block.expect("some value is good")
                };
                assert!((values[k] - expected).abs() < 1e-5, "{k}: {} {expected}", values[k]);
            }
            assert_eq!(mend(rank, &mut values).unwrap(), None);
        }
        assert!(matches!(mend(Rank::Three, &mut [f32::NAN; 8]), Err(TreeError::BadValues(_))));
        assert!(matches!(mend(Rank::Three, &mut [1.0; 9]), Err(TreeError::NotAGrid { .. })));
    }
}
