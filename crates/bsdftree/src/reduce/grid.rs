//! A grid as the full tree over its cells, without that tree in memory.
//!
//! In: values row by row, dimension 0 slowest, as NumPy has them, in memory or in a mapped file. Beside them there are a mean and an error
//! for each node: an eighth of the grid at rank 4. Values are read row by row three times, for means and the errors of the finest nodes, for
//! the errors of all others, and for what the result lost.
//!
//! A node's number within its level is its coordinates with their bits interleaved, dimension 0 lowest, as children are numbered.

use std::ops::Range;

use super::Norm;
use super::measure::Measures;
use super::source::{Source, Weights, Whole};
use crate::tree::{Arena, Content, Rank, Slot, TreeError, grid::log2_of, leaf_area};

/// Values of 2^N cells along each axis.
pub(super) struct Grid<'a> {
    rank: Rank,
    log2_res: u32,
    values: &'a [f32],
    weights: Weights,
    /// Bits of a coordinate, `rank` apart.
    spread: Vec<u32>,
    /// Number of the first node of each level.
    first: Vec<u32>,
    /// Where the cells of a finest node are after its first, every two of them side by side.
    pairs: [usize; 8],
    /// Of all values.
    whole: Whole,
    /// Of all incident cells, the first dimension fastest.
    totals: Vec<f64>,
}

impl<'a> Grid<'a> {
    /// Over values.
    ///
    /// # Errors
    /// If they are no grid, or one is negative or not finite.
    pub fn new(rank: Rank, values: &'a [f32]) -> Result<Grid<'a>, TreeError> {
        let log2_res = log2_of(rank, values)?;
        let d = rank.dimensions() as u32;
        let spread = |c: u32| (0..log2_res).map(|b| (c >> b & 1) << (d * b)).sum();
        let first = |level: u32| (0..level).map(|l| 1 << (d * l)).sum();
        let mut grid = Grid {
            rank,
            log2_res,
            values,
            weights: Weights::new(rank, log2_res),
            spread: (0..1 << log2_res).map(spread).collect(),
            first: (0..=log2_res).map(first).collect(),
            pairs: std::array::from_fn(|k| {
                (0..d - 1).fold(0, |index, i| index << log2_res | (k >> i & 1)) << log2_res
            }),
            whole: Whole::default(),
            totals: Vec::new(),
        };
        (grid.whole, grid.totals) = vectorised(|| grid.sums());
        Ok(grid)
    }

    /// Cells along an axis.
    fn side(&self) -> usize {
        1 << self.log2_res
    }

    /// Sums over all values, and over those of each incident cell.
    #[inline(always)]
    fn sums(&self) -> (Whole, Vec<f64>) {
        let mut whole = Whole::default();
        let (n, area) = (self.side(), leaf_area(self.log2_res));
        let rows = if self.rank == Rank::Four { n } else { 1 };
        let mut totals = vec![0.0; rows * n];
        for (index, values) in self.values.chunks_exact(n * n).enumerate() {
            // There the first dimension is the slowest, in totals the fastest.
            let (x, y) = (index / rows, index % rows);
            let weight = self.weights.of(self.log2_res, x as u32);
            let (mut light, mut power) = (0.0, 0.0);
            // So many sums side by side are added in one instruction each.
            for values in values.chunks(self.side()) {
                let (mut sums, mut squares) = ([0.0f64; 4], [0.0f64; 4]);
                let (fours, rest) = values.as_chunks::<4>();
                for four in fours {
                    for i in 0..4 {
                        let value = f64::from(four[i]);
                        sums[i] += value;
                        squares[i] += value * value;
                    }
                }
                let rest = rest.iter().map(|&v| f64::from(v));
                light += sums.iter().sum::<f64>() + rest.clone().sum::<f64>();
                power += squares.iter().sum::<f64>() + rest.map(|v| v * v).sum::<f64>();
            }
            totals[y * n + x] = area * light;
            whole.light += weight * light;
            whole.power += weight * power;
            let largest = values.iter().fold(0.0f32, |largest, &v| if v > largest { v } else { largest });
            whole.largest = whole.largest.max(f64::from(largest));
        }
        (whole, totals)
    }

    /// Number of the node with these coordinates within its level, but for the last one.
    fn row_number(&self, coordinates: &[usize]) -> usize {
        coordinates.iter().rev().fold(0, |number, &c| number << 1 | self.spread[c] as usize)
    }

    /// What is added to that for the last coordinate.
    #[inline(always)]
    fn column_number(&self, column: usize) -> usize {
        (self.spread[column] as usize) << (self.rank.dimensions() - 1)
    }

    /// The level of a node.
    #[inline]
    fn level(&self, node: u32) -> u32 {
        // Most nodes are on the finest levels.
        let above = self.first.iter().rev().position(|&first| first <= node).expect("the root's is 0");
        self.log2_res - above as u32
    }

    /// The level of a node, and its coordinates there.
    #[inline]
    fn place(&self, node: u32) -> (u32, [usize; 4]) {
        let level = self.level(node);
        let number = node - self.first[level as usize];
        let cell = match self.rank {
            Rank::Three => [every_third(number), every_third(number >> 1), every_third(number >> 2), 0],
            Rank::Four => [
                every_fourth(number),
                every_fourth(number >> 1),
                every_fourth(number >> 2),
                every_fourth(number >> 3),
            ],
        };
        (level, cell)
    }

    /// The values of a finest node, those side by side along the last dimension together, the others in the order of children.
    #[inline]
    fn cells(&self, cell: [usize; 4]) -> impl Iterator<Item = [f32; 2]> {
        let d = self.rank.dimensions();
        let first = cell[..d].iter().fold(0, |index, &c| (index << self.log2_res) | (2 * c));
        let values = &self.values[first..];
        self.pairs[..1 << (d - 1)].iter().map(|&at| [values[at], values[at + 1]])
    }

    /// Calls `f` for the nodes over cells, all that differ by the last coordinate together: with their other coordinates, and with the
    /// rows of cells below, of which the last bit of the number is that of the first coordinate.
    #[inline(always)]
    fn for_finest_rows(&self, mut f: impl FnMut(&[usize], &[&[f32]; 8])) {
        let (d, n, half) = (self.rank.dimensions(), self.side(), self.side() / 2);
        for prefix in 0..half.pow(d as u32 - 1) {
            let mut cell = [0; 3];
            let mut rest = prefix;
            for c in cell[..d - 1].iter_mut().rev() {
                (*c, rest) = (rest % half, rest / half);
            }
            let mut rows: [&[f32]; 8] = [&[]; 8];
            for (k, row) in rows[..1 << (d - 1)].iter_mut().enumerate() {
                let index = (0..d - 1).fold(0, |index, i| index * n + 2 * cell[i] + (k >> i & 1));
                *row = &self.values[index * n..][..n];
            }
            f(&cell[..d - 1], &rows);
        }
    }

    /// Means and errors of the nodes over cells.
    #[inline(always)]
    fn finest(&self, norm: Norm, scale: f64, measures: &mut Measures) {
        let (d, n, half) = (self.rank.dimensions(), self.side(), self.side() / 2);
        let (first, scale) = (self.first[self.log2_res as usize - 1] as usize, scale as f32);
        let (mut sums, mut means, mut errors) = (vec![0.0f64; n], vec![0.0f32; n], vec![0.0f32; n]);
        let mut columns = vec![0.0f32; n];
        self.for_finest_rows(|cell, rows| {
            let layer = 2 * cell[0] as u32;
            let weights = [self.weights.of(self.log2_res, layer), self.weights.of(self.log2_res, layer + 1)];
            // Where nobody reads there is a mean all the same.
            let shares = if weights[0] + weights[1] > 0.0 { weights } else { [1.0; 2] };
            let all = (1 << (d - 1)) as f64 * (shares[0] + shares[1]);
            sums.fill(0.0);
            for (k, row) in rows[..1 << (d - 1)].iter().enumerate() {
                let share = shares[k & 1] / all;
                sums.iter_mut().zip(*row).for_each(|(sum, &value)| *sum += share * f64::from(value));
            }
            for (pair, mean) in sums.as_chunks::<2>().0.iter().zip(means.as_chunks_mut::<2>().0) {
                *mean = [(pair[0] + pair[1]) as f32; 2];
            }
            errors.fill(0.0);
            for half in 0..2 {
                columns.fill(0.0);
                for row in rows[..1 << (d - 1)].iter().skip(half).step_by(2) {
                    add_errors(row, &means, norm, scale, &mut columns);
                }
                let weight = weights[half] as f32;
                errors.iter_mut().zip(&columns).for_each(|(error, column)| *error += weight * column);
            }
            let number = first + self.row_number(cell);
            for column in 0..half {
                let node = number + self.column_number(column);
                measures.means[node] = means[2 * column];
                measures.errors[node] = errors[2 * column] + errors[2 * column + 1];
            }
        });
    }

    /// For each of those nodes, the value of the leaf of a tree with branches cut off that it is in; NaN if there it is a node. The errors
    /// of cells below such nodes are added to sums.
    fn leaves_of(&self, reduced: &Arena, sums: &mut [f64; 2]) -> Vec<f32> {
        let mut leaves = vec![f32::NAN; self.values.len() / self.rank.n_children()];
        self.fill(reduced, reduced.root(), 0, &mut leaves, sums);
        leaves
    }

    /// Fills those from a number on.
    fn fill(&self, reduced: &Arena, slot: Slot, number: usize, leaves: &mut [f32], sums: &mut [f64; 2]) {
        match slot.content() {
            Content::Leaf(value) => leaves.fill(value),
            Content::Node(node) if leaves.len() == 1 => {
                let first = self.first[self.log2_res as usize - 1] as usize;
                let place = (first + number) as u32;
                let (_, cell) = self.place(place);
                let pairs = self.children(place).into_iter().zip(reduced.children(node));
                for (k, pair) in pairs.enumerate().filter(|(_, (whole, kept))| whole != *kept) {
                    let (Content::Leaf(f), Content::Leaf(g)) = (pair.0.content(), pair.1.content()) else {
                        panic!("a reduced tree is nowhere finer than the whole one")
                    };
                    let weight = self.weights.of(self.log2_res, 2 * cell[0] as u32 + (k as u32 & 1));
                    let difference = f64::from(f) - f64::from(g);
                    sums[0] += weight * difference.abs();
                    sums[1] += weight * difference * difference;
                }
            }
            Content::Node(node) => {
                let n = leaves.len() / self.rank.n_children();
                let below = leaves.chunks_exact_mut(n).enumerate();
                for ((k, leaves), &child) in below.zip(reduced.children(node)) {
                    self.fill(reduced, child, number + k * n, leaves, sums);
                }
            }
        }
    }

    /// Adds what cells lost that are in those leaves.
    #[inline(always)]
    fn add_lost(&self, leaves: &[f32], sums: &mut [f64; 2]) {
        let (d, n) = (self.rank.dimensions(), self.side());
        let mut values = vec![0.0f64; n];
        self.for_finest_rows(|cell, rows| {
            let number = self.row_number(cell);
            let pairs = values.as_chunks_mut::<2>().0.iter_mut().enumerate();
            pairs.for_each(|(column, pair)| {
                *pair = [f64::from(leaves[number + self.column_number(column)]); 2]
            });
            if values.iter().fold(true, |all, value| all & value.is_nan()) {
                return;
            }
            for (k, row) in rows[..1 << (d - 1)].iter().enumerate() {
                let weight = self.weights.of(self.log2_res, 2 * cell[0] as u32 + (k as u32 & 1));
                let (mut l1, mut squares) = ([0.0f64; 2], [0.0f64; 2]);
                for (row, values) in row.as_chunks::<2>().0.iter().zip(values.as_chunks::<2>().0) {
                    for i in 0..2 {
                        let difference = f64::from(row[i]) - values[i];
                        let difference = if difference.is_nan() { 0.0 } else { difference };
                        l1[i] += difference.abs();
                        squares[i] += difference * difference;
                    }
                }
                sums[0] += weight * (l1[0] + l1[1]);
                sums[1] += weight * (squares[0] + squares[1]);
            }
        });
    }

    /// Means of the nodes above those.
    fn means(&self, measures: &mut Measures) {
        let n_children = self.rank.n_children();
        for level in (0..self.log2_res - 1).rev() {
            let [first, below] = [level, level + 1].map(|l| self.first[l as usize] as usize);
            for number in 0..below - first {
                let children = &measures.means[below + number * n_children..][..n_children];
                let mean = match self.rank {
                    Rank::Four => children.iter().map(|&m| f64::from(m)).sum::<f64>() / n_children as f64,
                    Rank::Three => {
                        let layer = self.place((first + number) as u32).1[0] as u32;
                        let [a, b] = [0, 1].map(|k| self.weights.of(level + 1, 2 * layer + k));
                        let [a, b] = if a + b > 0.0 { [a, b] } else { [1.0; 2] };
                        let weights = [a, b, a, b, a, b, a, b];
                        let sum: f64 = children.iter().zip(weights).map(|(&m, w)| w * f64::from(m)).sum();
                        sum / (4.0 * (a + b))
                    }
                };
                measures.means[first + number] = mean as f32;
            }
        }
    }

    /// Errors of the nodes above the finest.
    #[inline(always)]
    fn errors(&self, norm: Norm, scale: f64, measures: &mut Measures) {
        let (d, n) = (self.rank.dimensions(), self.side());
        let n_above = self.first[self.log2_res as usize - 1] as usize;
        let mut errors = vec![0.0f64; n_above];
        let (mut means, mut columns) = (vec![0.0f32; n], vec![0.0f32; n]);
        for (index, plane) in self.values.chunks_exact(n * n).enumerate() {
            let incident = if d == 4 { [index / n, index % n] } else { [index, 0] };
            let weight = self.weights.of(self.log2_res, incident[0] as u32);
            if weight == 0.0 {
                continue;
            }
            for shift in 2..=self.log2_res {
                let first = self.first[(self.log2_res - shift) as usize] as usize;
                for (band, rows) in plane.chunks_exact(n << shift).enumerate() {
                    let mut cell = [incident[0] >> shift, incident[1] >> shift, 0];
                    cell[d - 2] = band;
                    let number = first + self.row_number(&cell[..d - 1]);
                    let nodes = || (0..n >> shift).map(|column| number + self.column_number(column));
                    for (mean, node) in means.chunks_exact_mut(1 << shift).zip(nodes()) {
                        mean.fill(measures.means[node]);
                    }
                    columns.fill(0.0);
                    for row in rows.chunks_exact(n) {
                        add_errors(row, &means, norm, scale as f32, &mut columns);
                    }
                    for (columns, node) in columns.chunks_exact(1 << shift).zip(nodes()) {
                        errors[node] += weight * f64::from(columns.iter().sum::<f32>());
                    }
                }
            }
        }
        for (kept, error) in measures.errors.iter_mut().zip(errors) {
            *kept = error as f32;
        }
    }
}

/// Runs what is inlined into it in instructions of eight numbers where the processor has them. Sums are the same.
#[inline(always)]
fn vectorised<R>(run: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        fn with_avx2<R>(run: impl FnOnce() -> R) -> R {
            run()
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2.
            return unsafe { with_avx2(run) };
        }
    }
    run()
}

/// Bits 0, 3, 6 and so on.
#[inline(always)]
fn every_third(bits: u32) -> usize {
    let bits = bits & 0x0924_9249;
    let bits = (bits | bits >> 2) & 0x030c_30c3;
    let bits = (bits | bits >> 4) & 0x0300_f00f;
    let bits = (bits | bits >> 8) & 0x0300_00ff;
    ((bits | bits >> 16) & 0x3ff) as usize
}

/// Bits 0, 4, 8 and so on.
#[inline(always)]
fn every_fourth(bits: u32) -> usize {
    let bits = bits & 0x1111_1111;
    let bits = (bits | bits >> 3) & 0x0303_0303;
    let bits = (bits | bits >> 6) & 0x000f_000f;
    ((bits | bits >> 12) & 0xff) as usize
}

/// Adds the errors of a row of values, each with the mean of its node, to those of rows above and below.
#[inline(always)]
fn add_errors(row: &[f32], means: &[f32], norm: Norm, scale: f32, columns: &mut [f32]) {
    let pairs = row.iter().zip(means).zip(columns);
    match norm {
        Norm::L1 => pairs.for_each(|((value, mean), column)| *column += ((value - mean) * scale).abs()),
        Norm::Rms => pairs.for_each(|((value, mean), column)| {
            let difference = (value - mean) * scale;
            *column += difference * difference;
        }),
    }
}

impl Source for Grid<'_> {
    fn rank(&self) -> Rank {
        self.rank
    }

    fn log2_res(&self) -> u32 {
        self.log2_res
    }

    fn root(&self) -> Slot {
        if self.log2_res == 0 { Slot::leaf(self.values[0]) } else { Slot::link(0) }
    }

    fn children(&self, node: u32) -> [Slot; 16] {
        let mut children = [Slot::leaf(0.0); 16];
        let below = self.nodes_below(node);
        if below.is_empty() {
            let half = self.rank.n_children() / 2;
            for (k, [a, b]) in self.cells(self.place(node).1).enumerate() {
                (children[k], children[k | half]) = (Slot::leaf(a), Slot::leaf(b));
            }
        } else {
            children.iter_mut().zip(below).for_each(|(child, k)| *child = Slot::link(k));
        }
        children
    }

    fn nodes_below(&self, node: u32) -> Range<u32> {
        let level = self.level(node);
        if level + 1 == self.log2_res {
            return 0..0;
        }
        let n_children = self.rank.n_children() as u32;
        let first = self.first[level as usize + 1] + (node - self.first[level as usize]) * n_children;
        first..first + n_children
    }

    fn whole(&self) -> Whole {
        self.whole
    }

    fn measures(&self, norm: Norm, scale: f64) -> Measures {
        let d = self.rank.dimensions() as u32;
        let n_nodes = (0..self.log2_res).map(|l| 1usize << (d * l)).sum();
        let n_above = self.log2_res.checked_sub(1).map_or(0, |l| self.first[l as usize] as usize);
        let mut measures = Measures::new(vec![self.rank.n_children() as u8; n_above], n_nodes);
        if self.log2_res > 0 {
            vectorised(|| self.finest(norm, scale, &mut measures));
            self.means(&mut measures);
            vectorised(|| self.errors(norm, scale, &mut measures));
        }
        measures
    }

    fn lost(&self, reduced: &Arena) -> [f64; 2] {
        if self.log2_res == 0 {
            return [0.0; 2];
        }
        let mut sums = [0.0; 2];
        let leaves = self.leaves_of(reduced, &mut sums);
        vectorised(|| self.add_lost(&leaves, &mut sums));
        sums
    }

    fn totals(&self) -> Vec<f64> {
        self.totals.clone()
    }

    fn totals_below(&self, node: u32, level: u32, totals: &mut Vec<f64>) {
        let (shift, area) = (self.log2_res - level, leaf_area(self.log2_res));
        let (d, side, n) = (self.rank.dimensions(), 1usize << shift, self.side());
        let (_, cell) = self.place(node);
        totals.clear();
        if shift == 1 {
            // Most nodes.
            totals.resize(1 << (d - 2), 0.0);
            for (k, [a, b]) in self.cells(cell).enumerate() {
                totals[k & ((1 << (d - 2)) - 1)] += area * (f64::from(a) + f64::from(b));
            }
            return;
        }
        let exitant = [cell[d - 2] << shift, cell[d - 1] << shift];
        let rows = if d == 4 { side } else { 1 };
        for y in 0..rows {
            for x in 0..side {
                let x = (cell[0] << shift) + x;
                let plane = if d == 4 { x * n + (cell[1] << shift) + y } else { x };
                let row = |k: usize| &self.values[(plane * n + exitant[0] + k) * n + exitant[1]..][..side];
                let sum: f64 = (0..side).map(|k| row(k).iter().map(|&v| f64::from(v)).sum::<f64>()).sum();
                totals.push(area * sum);
            }
        }
    }
}
