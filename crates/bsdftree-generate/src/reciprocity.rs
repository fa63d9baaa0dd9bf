//! Helmholtz reciprocity as information: f(i, o) and the same pair travelled the other way are two estimates of one number.
//!
//! The pair (i, o) travelled the other way is (1−o, 1−i) in the squares of a rank-4 tree. Reflections are averaged with
//! themselves, the two transmissions with each other. The mean of two independent estimates has a quarter of the sum of
//! their variances.

use rayon::prelude::*;

use crate::layout::Layout;
use crate::scatter::Spectrum;
use crate::tally::{Exit, Row, united};

/// The mean of a component and of another travelled the other way; of itself, for reflections, it is symmetric.
pub fn averaged<S: Spectrum>(layout: &Layout, rows: &[Row<S>], other: &[Row<S>], n: f64) -> Vec<Row<S>> {
    let turned = transposed(layout, other);
    rows.par_iter().zip(&turned).map(|(a, b)| merged(a, b, n)).collect()
}

/// The rows for light travelling the other way.
fn transposed<S: Spectrum>(layout: &Layout, rows: &[Row<S>]) -> Vec<Row<S>> {
    let mut turned = vec![Row::new(); rows.len()];
    // Rows from last to first, so that turned rows of a tree come out sorted.
    for (i, row) in rows.iter().enumerate().rev() {
        let cell = layout.reversed(i);
        for exit in row {
            // What is equal both ways is light per projected solid angle.
            let scale = layout.exitant_area(cell) / layout.exitant_area(exit.cell as usize);
            turned[layout.reversed(exit.cell as usize)].push(exit.scaled(scale, cell as u32));
        }
    }
    turned.par_iter_mut().for_each(|row| row.sort_unstable_by_key(|exit| exit.cell));
    turned
}

fn merged<S: Spectrum>(a: &[Exit<S>], b: &[Exit<S>], n: f64) -> Row<S> {
    united(a, b, |a, b| {
        let exits = || [a, b].into_iter().flatten();
        let mut mean = Exit::none(exits().next().expect("one of them has the cell").cell);
        mean.sum = exits().fold(S::BLACK, |s, e| s + e.sum) * 0.5;
        for exit in exits() {
            for (sum, part) in mean.replicates.iter_mut().zip(exit.replicates) {
                *sum += 0.5 * part;
            }
        }
        // q such that (q − t²)/n is the variance of the mean, where q and t are sums over n paths divided by n.
        let variance = |e: &Exit<S>| (f64::from(e.squares) - e.sum.luminance().powi(2) / n).max(0.0);
        let variances: f64 = exits().map(variance).sum();
        mean.squares = (0.25 * variances + mean.sum.luminance().powi(2) / n) as f32;
        mean
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exit(cell: u32, sum: f64) -> Exit<f64> {
        Exit { sum, squares: sum as f32, ..Exit::none(cell) }
    }

    #[test]
    fn averaging_keeps_flux_and_makes_rows_symmetric() {
        let layout = Layout::Tree { rank: bsdftree::Rank::Four, log2_res: 1 };
        let rows = vec![vec![exit(0, 3.0), exit(2, 1.0)], vec![], vec![exit(3, 2.0)], vec![exit(1, 4.0)]];
        let mean = averaged(&layout, &rows, &rows, 100.0);
        let total = |rows: &[Row<f64>]| rows.iter().flatten().map(|e| e.sum).sum::<f64>();
        assert_eq!(total(&mean), total(&rows));
        assert_eq!(transposed(&layout, &mean), mean);
        // (0, 2) is travelled the other way as (1, 3).
        assert!(mean[0].contains(&Exit { squares: 0.25, ..exit(2, 0.5) }));
        assert_eq!(mean[1].iter().find(|e| e.cell == 3).unwrap().sum, 0.5);
    }
}
