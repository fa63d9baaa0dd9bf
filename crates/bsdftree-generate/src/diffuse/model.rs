//! The diffuse part of a BSDF, from light that incident cells of both directions lay down at sites.
//!
//! In: rows of two replicates for the incident cells of one side or both. Out: f of a part for all pairs of cells, twice over,
//! from independent numbers.

use bsdftree::{Part, Side};
use rayon::prelude::*;

use super::deposit::{Row, Walker};
use super::interreflection::Exchange;
use crate::layout::Layout;
use crate::scatter::Spectrum;

/// Incident cells in one product: few enough for a row block to stay in the cache, and to keep all threads busy.
const BLOCK: usize = 64;

/// Rows of all incident cells of a side, for each of two replicates.
pub(crate) type SideRows = [Vec<Row>; 2];

/// Everything known of light that is diffused, one side or both.
pub(crate) struct Model<S> {
    /// log2 of the cells per axis, of trees.
    log2: u32,
    /// Incident cells of a side.
    n_cells: usize,
    n_sites: usize,
    /// For each cell, the one that light to it comes by when sent back.
    reversed: Vec<usize>,
    /// Of the front, of the back.
    rows: [Option<SideRows>; 2],
    exchange: [Exchange<S>; 2],
    /// 𝒜/(π a) of each site.
    share: Vec<f64>,
}

/// Finest log2 of the cells per axis of a model of a tree.
pub(crate) const MAX_LOG2: u32 = 6;

/// The layout whose cells a model of `layout` has: of trees, up to 2⁶ per axis. `None` if there is no model of it.
pub(crate) fn model_layout(layout: &Layout) -> Option<Layout> {
    match layout {
        Layout::Tree { rank: bsdftree::Rank::Three, .. } => None,
        Layout::Tree { rank, log2_res } => {
            Some(Layout::Tree { rank: *rank, log2_res: (*log2_res).min(MAX_LOG2) })
        }
        Layout::Klems(_) => Some(layout.clone()),
    }
}

impl<S: Spectrum> Model<S> {
    /// From rows of the front and of the back, whose cells are those of `layout`. `walks` walks from each site measure
    /// interreflection.
    pub fn new(walker: &Walker<S>, layout: &Layout, rows: [Option<SideRows>; 2], walks: u64) -> Model<S> {
        let n_sites = walker.sites.len();
        let exchange = [0, 1].map(|replicate| {
            let mut lit = vec![false; n_sites];
            for row in rows.iter().flatten().flat_map(|side| &side[replicate]) {
                row.sent.iter().enumerate().for_each(|(k, &v)| lit[k % n_sites] |= v > 0.0);
            }
            Exchange::measure(walker, &lit, walks, replicate)
        });
        let n_cells = layout.n_incident();
        Model {
            log2: n_cells.ilog2() / 2,
            n_cells,
            n_sites,
            reversed: (0..n_cells).map(|cell| layout.reversed(cell)).collect(),
            rows,
            exchange,
            share: (0..n_sites)
                .map(|s| walker.entrance.area() / (std::f64::consts::PI * walker.sites.area(s)))
                .collect(),
        }
    }

    /// log2 of the cells per axis of a tree's model.
    pub fn log2(&self) -> u32 {
        self.log2
    }

    /// f of a part \[1/sr\], incident cell by incident cell, from light sent in one replicate and returned in the other, both ways
    /// about. Their mean is the estimate, a quarter of their squared difference estimates its variance. `None` if a side of
    /// the part has no rows.
    pub fn estimates(&self, part: Part, channel: usize) -> Option<[Vec<f32>; 2]> {
        let side = |side| self.rows[usize::from(side == Side::Back)].as_ref();
        let (from, to) = (side(part.incident_side())?, side(part.exitant_side())?);
        Some([0, 1].map(|replicate| {
            let exchange = &self.exchange[replicate];
            let n = exchange.active.len();
            let returned = self.returned(&to[1 - replicate], exchange, channel);
            let mut product = vec![0.0; self.n_cells * self.n_cells];
            product.par_chunks_mut(BLOCK * self.n_cells).zip(from[replicate].par_chunks(BLOCK)).for_each(
                |(out, rows)| {
                    let mut sent = Vec::with_capacity(rows.len() * n);
                    for row in rows {
                        let row = &row.sent[channel * self.n_sites..];
                        sent.extend(exchange.active.iter().map(|&s| row[s]));
                    }
                    multiply(&sent, &returned, out, n, self.n_cells);
                },
            );
            product
        }))
    }

    /// f of light that each active site sends out (rows), by exitant cell (columns).
    fn returned(&self, rows: &[Row], exchange: &Exchange<S>, channel: usize) -> Vec<f32> {
        let n = exchange.active.len();
        let resolvent: Vec<f32> = exchange.resolvent(channel).into_iter().map(|v| v as f32).collect();
        let mut leaving = Vec::with_capacity(n * self.n_cells);
        for &site in &exchange.active {
            let at = channel * self.n_sites + site;
            let share = self.share[site] as f32;
            leaving.extend(self.reversed.iter().map(|&cell| rows[cell].arrived[at] * share));
        }
        let mut returned = vec![0.0; n * self.n_cells];
        let blocks = returned.par_chunks_mut((BLOCK * self.n_cells).max(1));
        blocks.zip(resolvent.par_chunks((BLOCK * n).max(1))).for_each(|(out, rows)| {
            multiply(rows, &leaving, out, n, self.n_cells);
        });
        returned
    }
}

/// `out` = `a` · `b`, all row by row, with `inner` columns of `a` and `columns` of `b`.
fn multiply(a: &[f32], b: &[f32], out: &mut [f32], inner: usize, columns: usize) {
    let rows = out.len() / columns;
    assert!(a.len() == rows * inner && b.len() == inner * columns && out.len() == rows * columns);
    // SAFETY: the lengths are those of the three matrices, as asserted, and `out` is borrowed alone.
    unsafe {
        matrixmultiply::sgemm(
            rows,
            inner,
            columns,
            1.0,
            a.as_ptr(),
            inner as isize,
            1,
            b.as_ptr(),
            columns as isize,
            1,
            0.0,
            out.as_mut_ptr(),
            columns as isize,
            1,
        );
    }
}

#[cfg(test)]
impl<S: Spectrum> Model<S> {
    /// Of each active site, the light that leaves at once, and that which other sites send out again.
    pub fn closure(&self, channel: usize) -> Vec<(usize, f64, f64)> {
        let exchange = &self.exchange[0];
        let omega = std::f64::consts::PI / self.n_cells as f64;
        let leaves = |s: usize| -> f64 {
            let rows = self.rows.iter().flatten().flat_map(|side| &side[0]);
            rows.map(|row| f64::from(row.arrived[channel * self.n_sites + s])).sum::<f64>()
                * self.share[s]
                * omega
        };
        exchange.active.iter().map(|&s| (s, leaves(s), exchange.sent_again(s, channel))).collect()
    }
}
