//! Helmholtz reciprocity as information: f(i, o) and the same pair travelled the other way are two estimates of one number.
//!
//! In the cells of a rank-4 tree the pair (i, o) travelled the other way is (1−o, 1−i), whose cell numbers are the complements
//! of o's and i's. Reflections are averaged with themselves, the two transmissions with each other. The mean of two
//! independent estimates has a quarter of the sum of their variances.

use crate::scatter::Spectrum;
use crate::tally::{Exit, Row};

/// The mean of a component and of another travelled the other way; of itself, for reflections, it is symmetric.
pub fn averaged<S: Spectrum>(rows: &[Row<S>], other: &[Row<S>], n_samples: u64) -> Vec<Row<S>> {
    rows.iter().zip(&transposed(other)).map(|(a, b)| merged(a, b, n_samples as f64)).collect()
}

/// The rows for light travelling the other way. The number of rows is a power of 4.
fn transposed<S: Spectrum>(rows: &[Row<S>]) -> Vec<Row<S>> {
    let mask = rows.len() - 1;
    let mut turned = vec![Row::new(); rows.len()];
    // Rows from last to first, so that the turned rows come out sorted.
    for (i, row) in rows.iter().enumerate().rev() {
        for exit in row {
            turned[!(exit.cell as usize) & mask].push(Exit { cell: (!i & mask) as u32, ..*exit });
        }
    }
    turned
}

fn merged<S: Spectrum>(a: &[Exit<S>], b: &[Exit<S>], n: f64) -> Row<S> {
    let (mut a, mut b) = (a.iter().peekable(), b.iter().peekable());
    let mut row = Row::new();
    loop {
        let cell = match (a.peek(), b.peek()) {
            (None, None) => return row,
            (Some(x), None) => x.cell,
            (None, Some(y)) => y.cell,
            (Some(x), Some(y)) => x.cell.min(y.cell),
        };
        let pair = [a.next_if(|e| e.cell == cell), b.next_if(|e| e.cell == cell)];
        let exits = || pair.iter().flatten();
        let sum = exits().fold(S::BLACK, |s, e| s + e.sum) * 0.5;
        // q such that (q − t²)/n is the variance of the mean, where q and t are sums over n paths divided by n.
        let variances: f64 = exits().map(|e| (e.squares - e.sum.luminance().powi(2) / n).max(0.0)).sum();
        row.push(Exit { cell, sum, squares: 0.25 * variances + sum.luminance().powi(2) / n });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exit(cell: u32, sum: f64) -> Exit<f64> {
        Exit { cell, sum, squares: sum }
    }

    #[test]
    fn averaging_keeps_flux_and_makes_rows_symmetric() {
        let rows = vec![vec![exit(0, 3.0), exit(2, 1.0)], vec![], vec![exit(3, 2.0)], vec![exit(1, 4.0)]];
        let mean = averaged(&rows, &rows, 100);
        let total = |rows: &[Row<f64>]| rows.iter().flatten().map(|e| e.sum).sum::<f64>();
        assert_eq!(total(&mean), total(&rows));
        assert_eq!(transposed(&mean), mean);
        // (0, 2) is travelled the other way as (1, 3).
        assert!(mean[0].contains(&Exit { cell: 2, sum: 0.5, squares: 0.25 * (1.0 - 0.01) + 0.0025 }));
        assert_eq!(mean[1].iter().find(|e| e.cell == 3).unwrap().sum, 0.5);
    }
}
