//! The 2-D Hilbert curve, as a state machine and all levels at once.
//!
//! At each level the curve visits the four quadrants of a cell in an order that depends on its state, one of
//! the four symmetries of the square that the curve needs: identity, transposed, anti-transposed, turned by
//! 180°. (D. Hilbert 1891; the tables follow from composing those symmetries.) Neighbours on the curve
//! are neighbours in the square, so stratified numbers become stratified directions.

/// A quadrant is x + 2y with x, y ∈ {0, 1}.
pub type Quadrant = u8;

/// `QUADRANT[state][k]`: the quadrant that is visited k-th.
const QUADRANT: [[Quadrant; 4]; 4] = [[0, 2, 3, 1], [0, 1, 3, 2], [3, 2, 0, 1], [3, 1, 0, 2]];
/// `NEXT[state][k]`: the state inside the quadrant that is visited k-th.
const NEXT: [[u8; 4]; 4] = [[1, 0, 0, 2], [0, 1, 1, 3], [3, 2, 2, 0], [2, 3, 3, 1]];
/// `ORDER[state][quadrant]`: when a quadrant is visited.
const ORDER: [[u8; 4]; 4] = [[0, 3, 1, 2], [0, 1, 3, 2], [2, 3, 1, 0], [2, 1, 3, 0]];

/// Where a walk along the curve is: the symmetry of the curve inside the present cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State(u8);

impl State {
    /// The quadrant visited k-th (k < 4) and the state inside it.
    #[inline]
    pub fn step(self, k: usize) -> (Quadrant, State) {
        (QUADRANT[self.0 as usize][k & 3], State(NEXT[self.0 as usize][k & 3]))
    }
}

/// The Hilbert index of cell (x, y) of a 2^levels × 2^levels grid.
pub fn hilbert_index(x: u32, y: u32, levels: u32) -> u64 {
    let (mut index, mut state) = (0u64, 0usize);
    for level in (0..levels).rev() {
        let quadrant = ((x >> level) & 1 | ((y >> level) & 1) << 1) as usize;
        let k = ORDER[state][quadrant];
        index = index << 2 | u64::from(k);
        state = NEXT[state][k as usize] as usize;
    }
    index
}

/// The cell (x, y) of a 2^levels × 2^levels grid at a Hilbert index, at most 28 levels.
///
/// The four symmetries are made of two, transposing and turning over, each its own inverse, so that those inside a cell are the exclusive
/// or of those that the digits of all coarser levels bring: all levels at once, without a branch or a table. (H. S. Warren, "Hacker's
/// Delight", 2nd edition, 2012, section 16-2, has the curve by such parallel prefixes.)
#[inline(always)]
pub fn cell_from_hilbert(index: u64, levels: u32) -> (u32, u32) {
    let (high, low) = (even_bits(index >> 1), even_bits(index));
    // The first and the last quadrant of a cell are transposed, the last one is turned over too.
    let transposed = of_coarser_levels(!(high ^ low) & ((1 << levels) - 1));
    let turned = of_coarser_levels(high & low);
    let change = (low & transposed) ^ turned;
    (high ^ change, high ^ low ^ change)
}

/// Bits 0, 2, 4 … side by side.
#[inline(always)]
fn even_bits(x: u64) -> u32 {
    let x = x & 0x5555_5555_5555_5555;
    let x = (x | x >> 1) & 0x3333_3333_3333_3333;
    let x = (x | x >> 2) & 0x0F0F_0F0F_0F0F_0F0F;
    let x = (x | x >> 4) & 0x00FF_00FF_00FF_00FF;
    let x = (x | x >> 8) & 0x0000_FFFF_0000_FFFF;
    (x | x >> 16) as u32
}

/// For each bit, the exclusive or of all higher ones.
#[inline(always)]
fn of_coarser_levels(x: u32) -> u32 {
    [1, 2, 4, 8, 16].into_iter().fold(x >> 1, |x, shift| x ^ x >> shift)
}

/// Two numbers in (0, 1) for a choice inside a cell: the two given, or one unfolded along the curve.
/// Both are moved to the middle of their 2⁻²⁴, so that rounding never takes them out of the cell.
pub(crate) fn unfold(u: f64, v: Option<f64>) -> [f64; 2] {
    const LEVELS: u32 = 24;
    let n = f64::from(1u32 << LEVELS);
    let (x, y) = match v {
        Some(v) => ((u * n) as u32, (v * n) as u32),
        None => cell_from_hilbert((u * n * n) as u64, LEVELS),
    };
    [x, y].map(|k| (f64::from(k.min((1 << LEVELS) - 1)) + 0.5) / n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn index_and_cell_are_inverse_and_visit_each_cell_once() {
        let levels = 6;
        let mut seen = vec![false; 1 << (2 * levels)];
        for x in 0..1 << levels {
            for y in 0..1 << levels {
                let index = hilbert_index(x, y, levels);
                assert_eq!(cell_from_hilbert(index, levels), (x, y));
                assert!(!std::mem::replace(&mut seen[index as usize], true));
            }
        }
        assert!(seen.into_iter().all(|s| s));
    }

    #[test]
    fn all_levels_at_once_are_one_after_the_other() {
        for levels in [0, 1, 3, 4, 5, 24, 26, 28] {
            for k in 0..1000u64 {
                let index = k.wrapping_mul(0x9E37_79B9_7F4A_7C15).checked_shr(64 - 2 * levels).unwrap_or(0);
                let (mut x, mut y, mut state) = (0, 0, State::default());
                for level in (0..levels).rev() {
                    let (quadrant, next) = state.step((index >> (2 * level)) as usize & 3);
                    x = x << 1 | u32::from(quadrant & 1);
                    y = y << 1 | u32::from(quadrant >> 1);
                    state = next;
                }
                assert_eq!(cell_from_hilbert(index, levels), (x, y));
            }
        }
    }

    #[test]
    fn steps_on_the_curve_are_steps_to_a_neighbour() {
        let levels = 7;
        for index in 1..1u64 << (2 * levels) {
            let (a, b) = (cell_from_hilbert(index - 1, levels), cell_from_hilbert(index, levels));
            assert_eq!(a.0.abs_diff(b.0) + a.1.abs_diff(b.1), 1);
        }
    }

    #[test]
    fn finer_levels_refine_coarser_ones() {
        for index in 0..1u64 << 10 {
            let fine = cell_from_hilbert(index, 5);
            let coarse = cell_from_hilbert(index >> 2, 4);
            assert_eq!((fine.0 >> 1, fine.1 >> 1), coarse);
        }
    }
}
