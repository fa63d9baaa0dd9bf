//! Helmholtz reciprocity as information: f(i, o) and the same pair travelled the other way are two estimates of one number.
//!
//! The pair (i, o) travelled the other way is (1−o, 1−i) in the squares of a rank-4 tree. Reflections are averaged with
//! themselves, the two transmissions with each other. The mean of two independent estimates has a quarter of the sum of
//! their variances.
//!
//! Totals need care. The total of an incident cell is known well: every path counts, wherever it leaves. What comes the other way
//! are paths that happened to leave by one cell, of Poisson's variance, and averaging would put that in place of the total's.
//! So rows and columns of the mean are scaled, both ends of a pair alike, until totals are again as counted (iterative proportional
//! fitting: W. E. Deming, F. F. Stephan, Ann. Math. Stat. 11, 1940). Where a pair is all there is, as in a mirror, the two totals
//! meet at their geometric mean.

use rayon::prelude::*;

use crate::layout::Layout;
use crate::scatter::Flux;
use crate::tally::{Exit, Row, united};

/// Steps of the fit. Few are left that are off by more than a thousandth.
const FITS: u32 = 12;

/// The mean of a component and of another travelled the other way (of itself, for reflections, where it is symmetric) with the
/// totals of both.
pub fn averaged<S: Flux>(layout: &Layout, rows: &[Row<S>], other: Option<&[Row<S>]>, n: f64) -> Vec<Row<S>> {
    let turned = transposed(layout, other.unwrap_or(rows));
    let mut mean: Vec<_> = rows.par_iter().zip(&turned).map(|(a, b)| merged(a, b, n)).collect();
    fit(layout, &mut mean, &totals(rows), other.map(totals).as_deref());
    mean
}

fn totals<S: Flux>(rows: &[Row<S>]) -> Vec<f64> {
    rows.iter().map(|row| row.iter().map(|exit| exit.sum.luminance()).sum()).collect()
}

/// Scales rows, and columns, so that their totals become those given; of columns, as if travelled the other way. A symmetric
/// component stays so.
fn fit<S: Flux>(layout: &Layout, rows: &mut [Row<S>], of_rows: &[f64], of_columns: Option<&[f64]>) {
    let mut factors = [vec![1.0; rows.len()], vec![1.0; rows.len()]];
    let step = |factors: &mut [f64], sums: &[f64], wanted: &[f64]| {
        for ((factor, sum), wanted) in factors.iter_mut().zip(sums).zip(wanted) {
            if *sum > 0.0 && *wanted > 0.0 {
                *factor *= (wanted / sum).sqrt();
            }
        }
    };
    for _ in 0..FITS {
        let mut sums = [vec![0.0; rows.len()], vec![0.0; rows.len()]];
        for (i, row) in rows.iter().enumerate() {
            for exit in row {
                let (o, t) = (layout.reversed(exit.cell as usize), exit.sum.luminance());
                let t = t * factors[0][i] * factors[1][o];
                sums[0][i] += t;
                let areas = [layout.reversed(i), exit.cell as usize].map(|cell| layout.exitant_area(cell));
                sums[1][o] += t * (areas[0] / areas[1]);
            }
        }
        step(&mut factors[0], &sums[0], of_rows);
        match of_columns {
            Some(of_columns) => step(&mut factors[1], &sums[1], of_columns),
            None => factors[1] = factors[0].clone(),
        }
    }
    for (i, row) in rows.iter_mut().enumerate() {
        for exit in row {
            let factor = factors[0][i] * factors[1][layout.reversed(exit.cell as usize)];
            *exit = exit.scaled(factor, exit.cell);
        }
    }
}

/// The rows for light travelling the other way.
fn transposed<S: Flux>(layout: &Layout, rows: &[Row<S>]) -> Vec<Row<S>> {
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

fn merged<S: Flux>(a: &[Exit<S>], b: &[Exit<S>], n: f64) -> Row<S> {
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
    fn averaging_keeps_totals_and_makes_rows_symmetric() {
        let layout = Layout::Tree { rank: bsdftree::Rank::Four, log2_res: 1 };
        let counts = [[5.0, 1.0, 1.0, 1.0], [1.0, 2.0, 1.0, 9.0], [3.0, 3.0, 3.0, 1.0], [1.0, 1.0, 1.0, 2.0]];
        let rows: Vec<Row<f64>> =
            counts.iter().map(|row| (0..4).map(|o| exit(o, row[o as usize])).collect()).collect();
        let mean = averaged(&layout, &rows, None, 100.0);
        for (i, (is, was)) in totals(&mean).iter().zip(totals(&rows)).enumerate() {
            assert!((is / was - 1.0).abs() < 0.02, "{i}: {is} {was}");
        }
        assert_eq!(transposed(&layout, &mean), mean);
        assert!((totals(&transposed(&layout, &rows))[0] / totals(&rows)[0] - 1.0).abs() > 0.1);
    }

    #[test]
    fn a_pair_alone_meets_in_the_middle() {
        let layout = Layout::Tree { rank: bsdftree::Rank::Four, log2_res: 1 };
        // (0, 2) is travelled the other way as (1, 3).
        let rows = vec![vec![exit(2, 1.0)], vec![exit(3, 4.0)], vec![], vec![]];
        let mean = averaged(&layout, &rows, None, 100.0);
        assert!((mean[0][0].sum - 2.0).abs() < 0.1 && mean[0][0].sum == mean[1][0].sum, "{mean:?}");
    }

    #[test]
    fn patches_of_different_size_exchange_light_per_solid_angle() {
        let layout = Layout::Klems(std::sync::Arc::new(bsdftree::Basis::quarter()));
        let n = layout.n_incident();
        // A diffuser: of the light from each patch, each patch gets its projected solid angle.
        let row = || (0..n).map(|o| exit(o as u32, layout.exitant_area(o))).collect::<Row<f64>>();
        let rows: Vec<_> = (0..n).map(|_| row()).collect();
        let mean = averaged(&layout, &rows, Some(&rows), 100.0);
        for (a, b) in mean.iter().flatten().zip(rows.iter().flatten()) {
            assert!((a.sum / b.sum - 1.0).abs() < 1e-9 && a.cell == b.cell);
        }
    }
}
