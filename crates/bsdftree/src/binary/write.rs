//! From a BSDF to bytes.

use std::io::{self, Write};
use std::path::Path;

use super::bytes::Number;
use super::error::{BinaryError, BinaryFault};
use super::head::{Form, Head, Kind, PARTS, Parts, Stored, bases};
use super::predict::{Twin, differences};
use super::values::{Budget, leaves, masks_and, planes, raw_matrix, raw_slots};
use super::zstandard::packed;
use super::{ALIGNMENT, FIRST_VERSION, FREE_HEAD, MAGIC, MOST_GROWTH, PREAMBLE, VERSION};
use crate::bsdf::{Bsdf, Scattering};
use crate::tree::{Rank, Slot, level_order};
use crate::whole_file;

/// How values are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Packing {
    /// As they are in memory: opened at once.
    #[default]
    Raw,
    /// Compressed with Zstandard at a level from 1, fast, to 22, small.
    Packed(u8),
}

impl Packing {
    /// What [`Packing::Packed`] is for: the level beyond which files of trees become hardly smaller.
    pub const SMALL: Packing = Packing::Packed(19);
}

/// Writes a BSDF to the last bit. Reading it gives the same values, leaf by leaf, and the same header.
///
/// # Errors
/// If a value was damaged in the file it comes from, or `out` refuses.
///
/// # Panics
/// If the level of packing is not one.
pub fn write(bsdf: &Bsdf, packing: Packing, out: &mut impl Write) -> Result<(), BinaryError> {
    if let Packing::Packed(level) = packing {
        assert!((1..=22).contains(&level), "a level of packing is from 1 to 22, not {level}");
    }
    let unwritable =
        |problem: String| BinaryError { path: None, offset: 0, fault: BinaryFault::Unwritable(problem) };
    bsdf.verify().map_err(|damage| unwritable(damage.to_string()))?;
    let mut sections = Sections { packing, version: FIRST_VERSION, all: Vec::new(), budget: Budget::new(0) };
    let bases = bases(bsdf);
    let mut bands = Vec::with_capacity(bsdf.bands.len());
    for band in &bsdf.bands {
        let mut parts = Parts::default();
        for (part, functions) in PARTS.into_iter().zip(&mut parts) {
            for function in band.component(part).into_iter().flat_map(|component| component.functions()) {
                functions.push(sections.add(function, Kind::of(function, &bases))?);
            }
        }
        bands.push((band.name.clone(), parts));
    }
    let head = Head { header: bsdf.header.clone(), bases, bands }.bytes().map_err(unwritable)?;
    write_parts(&head, packing, &sections, out)?;
    Ok(())
}

/// Writes a BSDF to a file, whole or not at all, as [`xml::write_file`](crate::xml::write_file) does.
///
/// # Errors
/// As [`write()`], naming the file.
///
/// # Panics
/// As [`write()`].
pub fn write_file(bsdf: &Bsdf, packing: Packing, path: impl AsRef<Path>) -> Result<(), BinaryError> {
    let path = path.as_ref();
    whole_file::write(path, |file| write(bsdf, packing, &mut io::BufWriter::new(file)))
        .map_err(|error: BinaryError| error.in_file(path))
}

/// Preamble, head and values, each at its place.
fn write_parts(head: &[u8], packing: Packing, sections: &Sections, out: &mut impl Write) -> io::Result<()> {
    let small = match packing {
        Packing::Raw => None,
        Packing::Packed(level) => Some(packed(head, i32::from(level))?),
    };
    // As readers have it.
    let small = small.filter(|small| head.len() <= small.len() * MOST_GROWTH + FREE_HEAD);
    let stored = small.as_deref().unwrap_or(head);
    let parts = std::iter::once(stored).chain(sections.all.iter().map(Vec::as_slice));
    let length = parts.clone().fold(PREAMBLE, |sum, part| sum + part.len().next_multiple_of(ALIGNMENT));
    let mut preamble = MAGIC.to_vec();
    sections.version.put(&mut preamble);
    u32::from(small.is_some()).put(&mut preamble);
    for length in [stored.len(), head.len(), length] {
        (length as u64).put(&mut preamble);
    }
    crc32fast::hash(stored).put(&mut preamble);
    crc32fast::hash(&preamble).put(&mut preamble);
    const ZEROS: [u8; ALIGNMENT] = [0; ALIGNMENT];
    for part in std::iter::once(preamble.as_slice()).chain(parts) {
        out.write_all(part)?;
        out.write_all(&ZEROS[..part.len().next_multiple_of(ALIGNMENT) - part.len()])?;
    }
    out.flush()
}

/// The values of all functions, as they are in the file.
struct Sections {
    packing: Packing,
    /// The one that they need.
    version: u32,
    all: Vec<Vec<u8>>,
    /// What a reader will allow.
    budget: Budget,
}

impl Sections {
    /// Adds those of a function.
    fn add(&mut self, function: &Scattering, kind: Kind) -> io::Result<(Kind, Stored)> {
        let slots = match function {
            Scattering::Tree(tree) => level_order::slots(tree.arena()),
            Scattering::Matrix(_) => Vec::new(),
        };
        let kind = match kind {
            Kind::Tree { rank, log2_res, leaf, .. } => {
                Kind::Tree { rank, log2_res, leaf, n_nodes: (slots.len() / rank.n_children()) as u32 }
            }
            matrix => matrix,
        };
        let raw = || match function {
            Scattering::Tree(_) => raw_slots(&slots),
            Scattering::Matrix(matrix) => raw_matrix(matrix),
        };
        let small = match (self.packing, function) {
            (Packing::Raw, _) => None,
            (Packing::Packed(level), Scattering::Tree(tree)) => {
                self.granted(packed_tree(&slots, tree.rank(), level)?, 4 * slots.len())
            }
            (Packing::Packed(level), Scattering::Matrix(_)) => {
                let raw = raw();
                self.granted(Small::of(&raw, 0, level)?, raw.len())
            }
        };
        let (form, bytes) = small.unwrap_or_else(|| (Form::Raw, raw()));
        if matches!(form, Form::Predicted(_)) {
            self.version = VERSION;
        }
        let stored = Stored { form, length: bytes.len() as u64, crc: crc32fast::hash(&bytes) };
        self.all.push(bytes);
        Ok((kind, stored))
    }

    /// Packed values; none if they are not smaller than raw ones, or if they grow out of what a reader allows, who takes it for an attack.
    fn granted(&mut self, small: Small, raw: usize) -> Option<(Form, Vec<u8>)> {
        self.budget.earn(small.bytes.len());
        let is_granted = small.bytes.len() < raw && self.budget.spend(small.length, 0).is_ok();
        is_granted.then_some((small.form, small.bytes))
    }
}

/// Packed values.
struct Small {
    form: Form,
    bytes: Vec<u8>,
    /// How many bytes they were.
    length: usize,
}

impl Small {
    /// Masks and numbers, in the better of two ways.
    fn of(dense: &[u8], n_masks: usize, level: u8) -> io::Result<Small> {
        let plain = packed(dense, i32::from(level))?;
        let planes = packed(&planes(dense, n_masks), i32::from(level))?;
        let (form, bytes) =
            if planes.len() < plain.len() { (Form::Planes, planes) } else { (Form::Packed, plain) };
        Ok(Small { form, bytes, length: dense.len() })
    }
}

/// A tree in the best of three ways: its leaves, in bytes or in planes, or what they differ by from predictions.
fn packed_tree(slots: &[Slot], rank: Rank, level: u8) -> io::Result<Small> {
    // A bit for each slot.
    let n_masks = slots.len() / 8;
    let small = Small::of(&masks_and(&leaves(slots), slots, rank), n_masks, level)?;
    let (twin, differences) = best_twin(slots, rank);
    let dense = masks_and(&differences, slots, rank);
    let bytes = packed(&planes(&dense, n_masks), i32::from(level))?;
    match bytes.len() < small.bytes.len() {
        true => Ok(Small { form: Form::Predicted(twin), bytes, length: dense.len() }),
        false => Ok(small),
    }
}

/// The twin by which leaves are expected best, and what they differ by.
fn best_twin(slots: &[Slot], rank: Rank) -> (Twin, Vec<u32>) {
    let n_bits = |differences: &[u32]| {
        differences.iter().map(|d| u64::from(u32::BITS - d.leading_zeros())).sum::<u64>()
    };
    let all = Twin::all(rank).iter().map(|&twin| (twin, differences(slots, rank, twin)));
    all.min_by_key(|(_, differences)| n_bits(differences)).expect("there is the twin that is none")
}
