//! Trees and matrices as bytes: raw, which is how they are in memory, or packed.
//!
//! Raw values of a tree are its slots level by level, filled up with zeros to whole cache lines. Packed, it is a bit for each slot, 1
//! for links, whose order says where they lead, and then its leaves, or what they differ by from predictions. Values of a matrix are
//! the same either way. Packed bytes are compressed with Zstandard.

use std::sync::Arc;

use bytemuck::Zeroable;

use super::error::BinaryError;
use super::head::{Form, Kind};
use super::predict::restore;
use super::zstandard::unpacked;
use super::{FREE_VALUES, MOST_GROWTH};
use crate::klems::{Basis, Matrix};
use crate::shared::{Map, Shared, Stretch};
use crate::tree::arena::{Arena, Line, Rank, Slot};
use crate::tree::{Content, Tree};

/// Slots as in a file.
pub(super) fn raw_slots(slots: &[Slot]) -> Vec<u8> {
    let mut out = Vec::with_capacity((4 * slots.len()).next_multiple_of(size_of::<Line>()));
    out.extend_from_slice(&little_endian(bytemuck::cast_slice(slots)));
    out.resize(out.len().next_multiple_of(size_of::<Line>()), 0);
    out
}

/// A bit for each slot, 1 for links, and a number for each leaf.
pub(super) fn masks_and(leaves: &[u32], slots: &[Slot], rank: Rank) -> Vec<u8> {
    let mut out = Vec::with_capacity(slots.len() / 8 + 4 * leaves.len());
    for children in slots.chunks_exact(rank.n_children()) {
        let mask = children.iter().rev().fold(0u16, |mask, slot| mask << 1 | u16::from(is_link(slot)));
        out.extend_from_slice(&mask.to_le_bytes()[..rank.n_children() / 8]);
    }
    out.extend_from_slice(&little_endian(leaves));
    out
}

/// The bits of all leaves.
pub(super) fn leaves(slots: &[Slot]) -> Vec<u32> {
    slots.iter().filter(|slot| !is_link(slot)).map(|&slot| bytemuck::cast(slot)).collect()
}

fn is_link(slot: &Slot) -> bool {
    matches!(slot.content(), Content::Node(_))
}

/// The values of a matrix.
pub(super) fn raw_matrix(matrix: &Matrix) -> Vec<u8> {
    little_endian(bytemuck::cast_slice(matrix.values())).into_owned()
}

fn little_endian(numbers: &[u32]) -> std::borrow::Cow<'_, [u8]> {
    match cfg!(target_endian = "little") {
        true => bytemuck::cast_slice(numbers).into(),
        false => numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>().into(),
    }
}

/// Bytes as numbers; what is over is left out.
fn numbers(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.as_chunks().0.iter().map(|&number| u32::from_le_bytes(number))
}

/// Where values come from.
pub(super) struct Values<'a> {
    pub bytes: &'a [u8],
    /// Where they are in the file.
    pub offset: usize,
    pub form: Form,
    pub crc: u32,
    /// Not to be looked at, but to be left where they are.
    pub map: Option<&'a Map>,
}

impl Values<'_> {
    /// The tree in raw slots.
    pub(super) fn raw_tree(&self, kind: Kind) -> Result<Tree, BinaryError> {
        let Kind::Tree { rank, log2_res, n_nodes, leaf } = kind else { unreachable!("a tree was asked for") };
        let lines = match self.mapped() {
            Some(lines) => lines,
            None => {
                self.check()?;
                let mut lines = vec![Line::zeroed(); self.bytes.len() / size_of::<Line>()];
                let slots = bytemuck::cast_slice_mut::<Line, u32>(&mut lines);
                slots.iter_mut().zip(numbers(self.bytes)).for_each(|(slot, number)| *slot = number);
                lines.into()
            }
        };
        self.tree(rank, log2_res, n_nodes, leaf, lines)
    }

    /// The matrix in raw values.
    pub(super) fn raw_matrix(&self, [incident, exitant]: [&Arc<Basis>; 2]) -> Result<Matrix, BinaryError> {
        match self.mapped() {
            Some(values) => Matrix::unchecked(Arc::clone(incident), Arc::clone(exitant), values)
                .ok_or_else(|| self.wrong_count(matrix_len([incident, exitant]))),
            None => {
                self.check()?;
                self.matrix([incident, exitant], self.bytes)
            }
        }
    }

    /// The tree in packed bytes.
    pub(super) fn packed_tree(&self, kind: Kind, budget: &mut Budget) -> Result<Tree, BinaryError> {
        let Kind::Tree { rank, log2_res, n_nodes, leaf } = kind else { unreachable!("a tree was asked for") };
        self.check()?;
        let n = rank.n_children();
        let n_masks = n_nodes as usize * n / 8;
        let n_leaves = if n_nodes == 0 { 0 } else { 1 + n_nodes as usize * (n - 1) };
        let dense = self.unpacked(n_masks, n_leaves, budget)?;
        let (masks, leaves) = dense.split_at(n_masks);
        let mut lines = vec![Line::zeroed(); (n_nodes as usize * n).div_ceil(16)];
        let slots = bytemuck::cast_slice_mut::<Line, Slot>(&mut lines);
        let (mut leaves, mut next) = (numbers(leaves), 1);
        let is_predicted = matches!(self.form, Form::Predicted(_));
        for (mask, slots) in masks.iter().zip(slots.as_chunks_mut::<8>().0) {
            for (bit, slot) in slots.iter_mut().enumerate() {
                *slot = if mask >> bit & 1 == 1 {
                    next += 1;
                    Slot::link((next - 1) & (u32::MAX >> 1))
                } else if is_predicted {
                    Slot::leaf(0.0)
                } else {
                    bytemuck::cast(leaves.next().unwrap_or(0))
                };
            }
        }
        if let Form::Predicted(twin) = self.form {
            restore(&mut slots[..n_nodes as usize * n], rank, twin, leaves);
        }
        self.tree(rank, log2_res, n_nodes, leaf, lines.into())
    }

    /// The matrix in packed bytes.
    pub(super) fn packed_matrix(
        &self,
        bases: [&Arc<Basis>; 2],
        budget: &mut Budget,
    ) -> Result<Matrix, BinaryError> {
        self.check()?;
        let values = self.unpacked(0, matrix_len(bases), budget)?;
        self.matrix(bases, &values)
    }

    fn matrix(&self, [incident, exitant]: [&Arc<Basis>; 2], bytes: &[u8]) -> Result<Matrix, BinaryError> {
        let values = numbers(bytes).map(f32::from_bits).collect();
        Matrix::new(Arc::clone(incident), Arc::clone(exitant), values)
            .map_err(|problem| BinaryError::damaged(self.offset, problem, "a matrix of these bases"))
    }

    fn tree(
        &self,
        rank: Rank,
        log2_res: u32,
        n_nodes: u32,
        leaf: f32,
        lines: Shared<Line>,
    ) -> Result<Tree, BinaryError> {
        let is_mapped = lines.stretch().is_some();
        let arena = Arena::unchecked(rank, log2_res, n_nodes, leaf, lines)
            .ok_or_else(|| self.wrong_count(n_nodes as usize * rank.n_children()))?;
        if !is_mapped && let Some((slot, found)) = arena.links_fault() {
            return Err(BinaryError::damaged(self.offset + 4 * slot, found, "a tree level by level"));
        }
        Ok(Tree::new(arena))
    }

    /// The numbers in place, if they may stay there.
    fn mapped<T: bytemuck::Pod>(&self) -> Option<Shared<T>> {
        let range = self.offset..self.offset + self.bytes.len();
        Shared::mapped(Stretch::new(self.map?, range, self.crc)?)
    }

    fn check(&self) -> Result<(), BinaryError> {
        match crc32fast::hash(self.bytes) {
            crc if crc == self.crc => Ok(()),
            crc => {
                let expected = format!("{:08x}", self.crc);
                Err(BinaryError::damaged(
                    self.offset,
                    format!("values with the checksum {crc:08x}"),
                    expected,
                ))
            }
        }
    }

    fn wrong_count(&self, expected: usize) -> BinaryError {
        let found = format!("values of {} bytes", self.bytes.len());
        BinaryError::damaged(self.offset, found, format!("{expected} numbers, as the head says"))
    }

    /// Masks and as many numbers.
    fn unpacked(&self, n_masks: usize, n: usize, budget: &mut Budget) -> Result<Vec<u8>, BinaryError> {
        let length = n_masks + 4 * n;
        budget.spend(length, self.offset)?;
        let mut dense = unpacked(self.bytes, length).map_err(|error| {
            let found = format!("packed values that are none: {error}");
            BinaryError::damaged(self.offset, found, format!("{length} bytes packed by Zstandard"))
        })?;
        if self.form != Form::Packed {
            let planes = dense.split_off(n_masks);
            let byte = |k: usize| planes[k % 4 * n + k / 4];
            dense.extend((0..4 * n).map(byte));
        }
        Ok(dense)
    }
}

fn matrix_len([incident, exitant]: [&Arc<Basis>; 2]) -> usize {
    incident.n_patches() * exitant.n_patches()
}

/// How much memory a file may ask for.
pub(super) struct Budget(usize);

impl Budget {
    /// That of a file of a length.
    pub(super) fn new(file_length: usize) -> Budget {
        let mut budget = Budget(FREE_VALUES);
        budget.earn(file_length);
        budget
    }

    /// More by what so many bytes of a file allow.
    pub(super) fn earn(&mut self, length: usize) {
        self.0 = self.0.saturating_add(length.saturating_mul(MOST_GROWTH));
    }

    /// Less by what is needed at a byte of the file.
    pub(super) fn spend(&mut self, length: usize, offset: usize) -> Result<(), BinaryError> {
        self.0 = self.0.checked_sub(length).ok_or_else(|| {
            let found = format!("values that would take {length} bytes");
            BinaryError::damaged(offset, found, format!("up to {} in a file of this size", self.0))
        })?;
        Ok(())
    }
}

/// Numbers after masks, the lowest bytes of all first, then the next.
pub(super) fn planes(dense: &[u8], n_masks: usize) -> Vec<u8> {
    let (masks, numbers) = dense.split_at(n_masks);
    let mut out = masks.to_vec();
    (0..4).for_each(|plane| out.extend(numbers.iter().skip(plane).step_by(4)));
    out
}
