//! Counting paths: for one incident cell, the weight that leaves through each exitant cell.

use crate::scatter::Spectrum;

/// What left through one exitant cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exit<S> {
    /// Exitant cell.
    pub cell: u32,
    /// Sum of weights.
    pub sum: S,
    /// Sum of squared luminous weights.
    pub squares: f64,
}

/// Exits of one incident cell, in the order of their cells; cells that nothing left through are absent.
pub type Row<S> = Vec<Exit<S>>;

/// A dense histogram that is emptied into a [`Row`] and used again.
pub struct Tally<S> {
    sums: Vec<S>,
    squares: Vec<f64>,
    touched: Vec<u32>,
}

impl<S: Spectrum> Tally<S> {
    /// An empty histogram.
    pub fn new(n_exitant: usize) -> Tally<S> {
        Tally { sums: vec![S::BLACK; n_exitant], squares: vec![0.0; n_exitant], touched: Vec::new() }
    }

    /// Adds one path.
    #[inline]
    pub fn add(&mut self, cell: u32, weight: S) {
        let luminance = weight.luminance();
        let k = cell as usize;
        if self.squares[k] == 0.0 {
            self.touched.push(cell);
        }
        self.sums[k] = self.sums[k] + weight;
        // A weight so small that its square vanishes would be counted as touched twice.
        self.squares[k] += (luminance * luminance).max(f64::MIN_POSITIVE);
    }

    /// What was added since the last call.
    pub fn drain(&mut self) -> Row<S> {
        self.touched.sort_unstable();
        let row = self
            .touched
            .iter()
            .map(|&cell| {
                let k = cell as usize;
                let sum = std::mem::replace(&mut self.sums[k], S::BLACK);
                Exit { cell, sum, squares: std::mem::take(&mut self.squares[k]) }
            })
            .collect();
        self.touched.clear();
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_sorted_sums_and_the_tally_is_empty_afterwards() {
        let mut tally = Tally::<f64>::new(10);
        for (cell, weight) in [(7, 0.5), (2, 1.0), (7, 0.25)] {
            tally.add(cell, weight);
        }
        let exit = |cell, sum, squares| Exit { cell, sum, squares };
        assert_eq!(tally.drain(), [exit(2, 1.0, 1.0), exit(7, 0.75, 0.3125)]);
        assert_eq!(tally.drain(), []);
    }
}
