//! Blocks as bytes.
//!
//! In: a block. Out: its bytes, from which it comes back with the same bits. Little-endian; lengths and distances between cells in
//! 7 bits a byte, replicates and sites that have nothing left out: a third of the memory they take.

use crate::counts::{Block, Shape, View};
use crate::diffuse::Laid;
use crate::random::N_REPLICATES;
use crate::scatter::Flux;
use crate::tally::{Exit, Row};

// A byte says which replicates have something.
const _: () = assert!(N_REPLICATES == 8);

/// Appends a block.
pub(super) fn encode<S: Flux>(block: &View<'_, S>, to: &mut Vec<u8>) {
    to.extend(block.lost.to_le_bytes());
    to.extend(block.seconds.to_le_bytes());
    for row in block.rows.iter().chain(&block.diffused).flatten().copied().flatten() {
        encode_row(row, to);
    }
    for laid in block.laid.iter().flatten() {
        encode_sparse(&laid.sent, to);
        encode_sparse(&laid.arrived, to);
    }
}

/// The block that bytes are, or `None` if they are none of this shape.
pub(super) fn decode<S: Flux>(bytes: &[u8], shape: &Shape) -> Option<Block<S>> {
    let mut from = Bytes(bytes);
    let mut block = Block::nothing();
    block.lost = u64::from_le_bytes(from.take()?);
    block.seconds = f64::from_le_bytes(from.take()?);
    for (rows, n) in [(&mut block.rows, shape.n_rows), (&mut block.diffused, shape.n_diffused)] {
        for _ in 0..shape.n_bands {
            let mut some = || (0..n).map(|_| from.row(shape.n_exitant)).collect::<Option<_>>();
            rows.push([some()?, some()?]);
        }
    }
    if let Some(n) = shape.n_laid {
        let mut laid = || Some(Laid { sent: from.sparse(n)?, arrived: from.sparse(n)? });
        block.laid = Some([laid()?, laid()?]);
    }
    from.0.is_empty().then_some(block)
}

fn encode_row<S: Flux>(row: &Row<S>, to: &mut Vec<u8>) {
    encode_number(row.len() as u64, to);
    let mut next = 0;
    for exit in row {
        encode_number(u64::from(exit.cell - next), to);
        next = exit.cell + 1;
        to.extend(exit.squares.to_le_bytes());
        (0..S::CHANNELS).for_each(|k| to.extend(exit.sum.channel(k).to_le_bytes()));
        let has = |r: &usize| exit.replicates[*r].to_bits() != 0;
        to.push((0..N_REPLICATES).filter(has).map(|r| 1 << r).sum());
        (0..N_REPLICATES).filter(has).for_each(|r| to.extend(exit.replicates[r].to_le_bytes()));
    }
}

/// Runs of zeros and of other numbers in turn.
fn encode_sparse(numbers: &[f32], to: &mut Vec<u8>) {
    let mut left = numbers;
    while !left.is_empty() {
        let n_zeros = left.iter().take_while(|x| x.to_bits() == 0).count();
        let n_others = left[n_zeros..].iter().take_while(|x| x.to_bits() != 0).count();
        let (run, rest) = left[n_zeros..].split_at(n_others);
        encode_number(n_zeros as u64, to);
        encode_number(n_others as u64, to);
        run.iter().for_each(|x| to.extend(x.to_le_bytes()));
        left = rest;
    }
}

fn encode_number(mut number: u64, to: &mut Vec<u8>) {
    while number >= 0x80 {
        to.push(number as u8 | 0x80);
        number >>= 7;
    }
    to.push(number as u8);
}

/// What is left to read. Nothing is allocated that the bytes do not fill.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*bytes)
    }

    fn number(&mut self) -> Option<usize> {
        let mut number = 0u64;
        for shift in (0..63).step_by(7) {
            let [byte] = self.take()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return usize::try_from(number).ok();
            }
        }
        None
    }

    fn row<S: Flux>(&mut self, n_exitant: usize) -> Option<Row<S>> {
        let n = self.number()?;
        let mut row = Row::with_capacity(n.min(self.0.len() / 14));
        let mut next = 0usize;
        for _ in 0..n {
            let cell = next.checked_add(self.number()?).filter(|&cell| cell < n_exitant)?;
            next = cell + 1;
            let mut exit = Exit::none(cell as u32);
            exit.squares = f32::from_le_bytes(self.take()?);
            let mut sum = [0.0; 3];
            for channel in &mut sum[..S::CHANNELS] {
                *channel = f64::from_le_bytes(self.take()?);
            }
            exit.sum = S::from_channels(|k| sum[k]);
            let [has] = self.take()?;
            for r in (0..N_REPLICATES).filter(|r| has >> r & 1 == 1) {
                exit.replicates[r] = f32::from_le_bytes(self.take()?);
            }
            row.push(exit);
        }
        Some(row)
    }

    fn sparse(&mut self, n: usize) -> Option<Vec<f32>> {
        let mut numbers = Vec::with_capacity(n);
        while numbers.len() < n {
            let n_zeros = self.number()?.min(n + 1);
            let n_others = self.number()?.min(n + 1);
            if n_zeros + n_others == 0 || numbers.len() + n_zeros + n_others > n {
                return None;
            }
            numbers.resize(numbers.len() + n_zeros, 0.0);
            for _ in 0..n_others {
                numbers.push(f32::from_le_bytes(self.take()?));
            }
        }
        Some(numbers)
    }
}
