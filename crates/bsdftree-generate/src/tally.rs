//! Counting paths: for one incident cell, the weight that leaves through each exitant cell.

use crate::random::N_REPLICATES;
use crate::scatter::Flux;

/// What left through one exitant cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exit<S> {
    /// Exitant cell.
    pub cell: u32,
    /// Sum of squared luminous weights.
    pub squares: f32,
    /// Sum of weights.
    pub sum: S,
    /// Sum of luminous weights of each replicate.
    pub replicates: [f32; N_REPLICATES],
}

/// A path that left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exited<S> {
    /// To the other side than it came from.
    pub transmitted: bool,
    /// By which exitant cell.
    pub cell: u32,
    pub weight: S,
    pub replicate: usize,
}

/// Exits of one incident cell, in the order of their cells; cells that nothing left through are absent.
pub type Row<S> = Vec<Exit<S>>;

impl<S: Flux> Exit<S> {
    /// Nothing.
    pub const fn none(cell: u32) -> Exit<S> {
        Exit { cell, squares: 0.0, sum: S::BLACK, replicates: [0.0; N_REPLICATES] }
    }

    /// As many times as much in another cell.
    pub(crate) fn scaled(&self, factor: f64, cell: u32) -> Exit<S> {
        Exit {
            cell,
            squares: self.squares * (factor * factor) as f32,
            sum: self.sum * factor,
            replicates: self.replicates.map(|sum| sum * factor as f32),
        }
    }

    fn add(&mut self, other: &Exit<S>) {
        self.squares += other.squares;
        self.sum = self.sum + other.sum;
        for (a, b) in self.replicates.iter_mut().zip(other.replicates) {
            *a += b;
        }
    }
}

/// Two rows as one: where both have a cell, the pair makes one exit of it.
pub(crate) fn united<S: Flux>(
    a: &[Exit<S>],
    b: &[Exit<S>],
    pair: impl Fn(Option<&Exit<S>>, Option<&Exit<S>>) -> Exit<S>,
) -> Row<S> {
    let mut row = Row::with_capacity(a.len().max(b.len()));
    let (mut a, mut b) = (a.iter().peekable(), b.iter().peekable());
    loop {
        let cell = match (a.peek(), b.peek()) {
            (None, None) => return row,
            (Some(x), None) => x.cell,
            (None, Some(y)) => y.cell,
            (Some(x), Some(y)) => x.cell.min(y.cell),
        };
        row.push(pair(a.next_if(|e| e.cell == cell), b.next_if(|e| e.cell == cell)));
    }
}

/// The counts of both rows.
pub(crate) fn added<S: Flux>(a: Row<S>, b: Row<S>) -> Row<S> {
    if a.is_empty() {
        return b;
    }
    if b.is_empty() {
        return a;
    }
    united(&a, &b, |x, y| match (x, y) {
        (Some(x), Some(y)) => {
            let mut sum = *x;
            sum.add(y);
            sum
        }
        (x, y) => *x.or(y).expect("one of them has the cell"),
    })
}

/// A dense histogram that is emptied into a [`Row`] and used again.
pub struct Tally<S> {
    exits: Vec<Exit<S>>,
    touched: Vec<u32>,
}

impl<S: Flux> Tally<S> {
    /// An empty histogram.
    pub fn new(n_exitant: usize) -> Tally<S> {
        Tally { exits: (0..n_exitant as u32).map(Exit::none).collect(), touched: Vec::new() }
    }

    /// Adds one path of a replicate.
    #[inline]
    pub fn add(&mut self, cell: u32, weight: S, replicate: usize) {
        let luminance = weight.luminance() as f32;
        let exit = &mut self.exits[cell as usize];
        if exit.squares == 0.0 {
            self.touched.push(cell);
        }
        exit.sum = exit.sum + weight;
        exit.replicates[replicate] += luminance;
        // A weight so small that its square vanishes would be counted as touched twice.
        exit.squares += (luminance * luminance).max(f32::MIN_POSITIVE);
    }

    /// What was added since the last call.
    pub fn drain(&mut self) -> Row<S> {
        self.touched.sort_unstable();
        let exits = &mut self.exits;
        self.touched
            .drain(..)
            .map(|cell| std::mem::replace(&mut exits[cell as usize], Exit::none(cell)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exit(cell: u32, replicate: usize, sum: f32, squares: f32) -> Exit<f64> {
        let mut exit = Exit { sum: f64::from(sum), squares, ..Exit::none(cell) };
        exit.replicates[replicate] = sum;
        exit
    }

    #[test]
    fn rows_are_sorted_sums_and_the_tally_is_empty_afterwards() {
        let mut tally = Tally::<f64>::new(10);
        for (cell, weight) in [(7, 0.5), (2, 1.0), (7, 0.25)] {
            tally.add(cell, weight, 3);
        }
        assert_eq!(tally.drain(), [exit(2, 3, 1.0, 1.0), exit(7, 3, 0.75, 0.3125)]);
        assert_eq!(tally.drain(), []);
    }

    #[test]
    fn added_rows_have_the_counts_of_both() {
        let (a, b) = (vec![exit(2, 0, 1.0, 1.0), exit(7, 1, 0.5, 0.25)], vec![exit(7, 2, 0.25, 0.0625)]);
        let sum = added(a.clone(), b.clone());
        assert_eq!(sum[0], a[0]);
        let mut both = exit(7, 1, 0.5, 0.3125);
        (both.sum, both.replicates[2]) = (0.75, 0.25);
        assert_eq!(sum[1..], [both]);
        assert_eq!(added(b.clone(), Row::new()), b);
    }
}
