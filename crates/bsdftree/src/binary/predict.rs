//! Leaves as what they differ by from a prediction, which packs better than they do.
//!
//! In: the slots of a tree level by level. Out: for each leaf, in order, its bits less those that its predecessors lead to expect, as a
//! number that is small if the difference is; and back, to the bit. A leaf is expected to be
//!
//! 1. what its twin is: the leaf at the place that a symmetry of the device would take it to, if that comes first;
//! 2. else what its siblings say: Σ −(−1)^|S| of the children that lie lower along the dimensions S, over all sets S of those along
//!    which it lies in the upper half (it differs by their mixed difference: 0 where values are a sum of functions of
//!    fewer variables), if all of them are leaves;
//! 3. else what the leaf before it is.
//!
//! Bits of an `f32` that is not negative are an integer that grows with it, so differences of bits are differences of logarithms, about.
//! (Lorenzo prediction: L. Ibarria et al., Out-of-core compression and decompression of large n-dimensional scalar fields, 2003.)

use crate::tree::Content;
use crate::tree::arena::{Rank, Slot};

/// Which leaf is like a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Twin {
    /// None.
    None,
    /// That of the light that goes back, as in reflections of trees of rank 4 that were made reciprocal.
    Reciprocal,
    /// That of the device with left and right swapped; rank 4.
    MirrorX,
    /// That of the device with up and down swapped; at rank 3, that on the other side of the plane of incidence.
    MirrorY,
}

impl Twin {
    /// Those that trees may have.
    pub(super) fn all(rank: Rank) -> &'static [Twin] {
        match rank {
            Rank::Three => &[Twin::None, Twin::MirrorY],
            Rank::Four => &[Twin::None, Twin::Reciprocal, Twin::MirrorX, Twin::MirrorY],
        }
    }

    /// The number of the child where the twin of a child is.
    fn child(self, rank: Rank, child: usize) -> usize {
        match (self, rank) {
            // What comes in goes out, and 1 − d for each coordinate d.
            (Twin::Reciprocal, _) => (!child >> 2 & 3) | (!child & 3) << 2,
            (Twin::MirrorX, _) => child ^ 0b0101,
            (Twin::MirrorY, Rank::Four) => child ^ 0b1010,
            (Twin::MirrorY, Rank::Three) => child ^ 0b100,
            (Twin::None, _) => child,
        }
    }
}

/// The differences of all leaves.
pub(super) fn differences(slots: &[Slot], rank: Rank, twin: Twin) -> Vec<u32> {
    let mut slots = slots.to_vec();
    let mut all = Vec::with_capacity(slots.len());
    for_leaves(&mut slots, rank, twin, |leaf, expected| {
        all.push(folded(bits(leaf).wrapping_sub(expected)));
        leaf
    });
    all
}

/// Sets all leaves of slots whose links are right to what they differ by from predictions.
pub(super) fn restore(
    slots: &mut [Slot],
    rank: Rank,
    twin: Twin,
    mut differences: impl Iterator<Item = u32>,
) {
    for_leaves(slots, rank, twin, |_, expected| {
        bytemuck::cast(expected.wrapping_add(unfolded(differences.next().unwrap_or(0))))
    });
}

/// Replaces each leaf, in order, by what `f` makes of it and of the bits expected of it. Links may lead anywhere.
fn for_leaves(slots: &mut [Slot], rank: Rank, twin: Twin, mut f: impl FnMut(Slot, u32) -> Slot) {
    /// The slot that stands for the root, which has none.
    const ROOT: usize = usize::MAX;
    let n = rank.n_children();
    let twin_child: Vec<usize> = (0..n).map(|child| twin.child(rank, child)).collect();
    // By node: the slot of its twin, a link, or that of the leaf that its twin is a part of.
    let mut twins = vec![ROOT; if twin == Twin::None { 0 } else { slots.len() / n }];
    let mut before = 0;
    for node in 0..slots.len() / n {
        let of_node = twins.get(node).copied();
        let within = of_node.map(|slot| if slot == ROOT { Some(0) } else { link(slots[slot]) });
        for child in 0..n {
            let at = node * n + child;
            let twin_at = match within {
                None => None,
                Some(Some(node)) => Some(node * n + twin_child[child]).filter(|&at| at < slots.len()),
                Some(None) => of_node,
            };
            if let Some(below) = link(slots[at]) {
                if let (Some(twin_at), Some(twins)) = (twin_at, twins.get_mut(below)) {
                    *twins = twin_at;
                }
                continue;
            }
            let like_twin = twin_at.filter(|&twin_at| twin_at < at && link(slots[twin_at]).is_none());
            let expected = match like_twin {
                Some(twin_at) => bits(slots[twin_at]),
                None => by_siblings(&slots[node * n..][..n], child).unwrap_or(before),
            };
            slots[at] = f(slots[at], expected);
            before = bits(slots[at]);
        }
    }
}

/// What the siblings that come before a child say; `None` if it is the first, or one of them is no leaf.
#[inline]
fn by_siblings(children: &[Slot], child: usize) -> Option<u32> {
    let (mut sum, mut part) = (0u32, child);
    while part != 0 {
        // All that lack some of the bits of the child, the last one all.
        let sibling = children[child ^ part];
        if link(sibling).is_some() {
            return None;
        }
        sum = match part.count_ones() % 2 {
            1 => sum.wrapping_add(bits(sibling)),
            _ => sum.wrapping_sub(bits(sibling)),
        };
        part = (part - 1) & child;
    }
    (child != 0).then_some(sum)
}

fn link(slot: Slot) -> Option<usize> {
    match slot.content() {
        Content::Node(node) => Some(node as usize),
        Content::Leaf(_) => None,
    }
}

fn bits(slot: Slot) -> u32 {
    bytemuck::cast(slot)
}

/// 0, −1, 1, −2 … as 0, 1, 2, 3 …
fn folded(difference: u32) -> u32 {
    difference << 1 ^ ((difference as i32) >> 31) as u32
}

fn unfolded(number: u32) -> u32 {
    number >> 1 ^ (number & 1).wrapping_neg()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::{Tree, level_order};

    const N: usize = 8;

    /// f at the centres of 8 cells per axis of rank 4.
    fn slots(f: impl Fn([f64; 4]) -> f64) -> Vec<Slot> {
        let at = |k: usize| (k as f64 + 0.5) / N as f64;
        let values: Vec<f32> = (0..N.pow(4))
            .map(|k| f([at(k / (N * N * N)), at(k / (N * N) % N), at(k / N % N), at(k % N)]) as f32)
            .collect();
        level_order::slots(Tree::from_grid(Rank::Four, &values).unwrap().arena())
    }

    fn restored(slots: &[Slot], twin: Twin) -> Vec<Slot> {
        let mut empty: Vec<Slot> =
            slots.iter().map(|&slot| if link(slot).is_some() { slot } else { Slot::leaf(0.0) }).collect();
        restore(&mut empty, Rank::Four, twin, differences(slots, Rank::Four, twin).into_iter());
        empty
    }

    #[test]
    fn leaves_come_back_to_the_bit_whatever_is_expected() {
        let slots =
            slots(|c| if c[0] < 0.25 { 3.0 } else { 1e-30 + c[1] * c[2] + (40.0 * c[3]).sin().abs() });
        for &twin in Twin::all(Rank::Four) {
            assert!(restored(&slots, twin) == slots, "{twin:?}");
        }
    }

    #[test]
    fn the_second_half_of_what_is_symmetric_is_expected_exactly() {
        let noise = |c: [f64; 4]| (1e4 * (c[0] + 3.0 * c[1] + 7.0 * c[2] + 11.0 * c[3]).sin()).fract().abs();
        type Image = fn([f64; 4]) -> [f64; 4];
        let cases: [(Twin, Image); 3] = [
            (Twin::Reciprocal, |[a, b, c, d]| [1.0 - c, 1.0 - d, 1.0 - a, 1.0 - b]),
            (Twin::MirrorX, |[a, b, c, d]| [1.0 - a, b, 1.0 - c, d]),
            (Twin::MirrorY, |[a, b, c, d]| [a, 1.0 - b, c, 1.0 - d]),
        ];
        for (twin, image) in cases {
            let slots = slots(|c| noise(c) + noise(image(c)));
            let exact = |twin| differences(&slots, Rank::Four, twin).iter().filter(|&&d| d == 0).count();
            // Twins of themselves are none.
            assert!(exact(twin) * 10 > slots.len() * 4, "{twin:?}: {} of {}", exact(twin), slots.len());
            assert!(exact(Twin::None) * 10 < slots.len());
        }
    }

    #[test]
    fn links_that_lead_anywhere_do_no_harm() {
        let mut slots = slots(|c| c[0] + c[1]);
        for wrong in [0, 7, u32::MAX >> 1] {
            (0..slots.len()).step_by(5).for_each(|k| slots[k] = Slot::link(wrong));
            for &twin in Twin::all(Rank::Four) {
                restore(&mut slots.clone(), Rank::Four, twin, std::iter::repeat(u32::MAX - wrong));
            }
        }
    }
}
