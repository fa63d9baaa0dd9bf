//! From bytes to a BSDF.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use super::bytes::{Bytes, Number};
use super::error::BinaryError;
use super::head::{Form, Function, Head, Kind, PARTS};
use super::values::{Budget, Values};
use super::zstandard::unpacked;
use super::{ALIGNMENT, FIRST_VERSION, FREE_HEAD, MAGIC, MOST_GROWTH, PREAMBLE, VERSION};
use crate::bsdf::{Band, Bsdf, Component, Scattering};
use crate::klems::Basis;
use crate::shared::Map;

/// Opens a file: raw values are mapped, and neither read nor verified before they are asked for ([`Bsdf::verify`] does it); packed ones
/// are read and verified.
///
/// # Errors
/// If it cannot be read, is none of this format or version, or damaged where it was looked at.
pub fn open(path: impl AsRef<Path>) -> Result<Bsdf, BinaryError> {
    let path = path.as_ref();
    let opened = || -> Result<Bsdf, BinaryError> {
        let map = Map::new(&File::open(path)?)?;
        // Numbers in a file are as in memory only on machines that count bytes as it does.
        bsdf(map.bytes(), cfg!(target_endian = "little").then_some(&map))
    };
    opened().map_err(|error| error.in_file(path))
}

/// The BSDF in the bytes of a file, all of it verified.
///
/// # Errors
/// If it is none of this format or version, or damaged.
///
/// ```
/// use bsdftree::binary::{Packing, read, write};
/// use bsdftree::{Bsdf, Component, Part, Rank, Tree};
///
/// let mut bsdf = Bsdf::default();
/// let diffuse = Tree::uniform(Rank::Four, 0.25);
/// bsdf.band_mut("Visible").insert(Part::ReflectionBack, Component::grey(diffuse.into()));
/// let mut file = Vec::new();
/// write(&bsdf, Packing::Raw, &mut file).unwrap();
/// assert_eq!(read(&file).unwrap().bands[0].components().count(), 1);
/// ```
pub fn read(bytes: &[u8]) -> Result<Bsdf, BinaryError> {
    bsdf(bytes, None)
}

fn bsdf(bytes: &[u8], map: Option<&Map>) -> Result<Bsdf, BinaryError> {
    let (stored, is_packed, length) = preamble(bytes)?;
    let unpacked_head = match is_packed {
        true => Some(unpacked(stored, length).map_err(|error| {
            let expected = format!("{length} bytes packed by Zstandard");
            BinaryError::damaged(PREAMBLE, format!("a packed head that is none: {error}"), expected)
        })?),
        false => None,
    };
    let head = Head::read(&mut Bytes::new(unpacked_head.as_deref().unwrap_or(stored), PREAMBLE))?;
    let mut sections = Sections {
        bytes,
        map,
        at: (PREAMBLE + stored.len()).next_multiple_of(ALIGNMENT),
        bases: &head.bases,
        budget: Budget::new(bytes.len()),
    };
    let mut bands = Vec::with_capacity(head.bands.len());
    for (name, parts) in head.bands {
        let mut band = Band::new(name);
        for (part, functions) in PARTS.into_iter().zip(parts) {
            if let Some(component) = sections.component(&functions)? {
                band.insert(part, component);
            }
        }
        bands.push(band);
    }
    match bytes.len().checked_sub(sections.at) {
        Some(0) => Ok(Bsdf { header: head.header, bands }),
        _ => {
            let found = format!("a file of {} bytes", bytes.len());
            Err(BinaryError::damaged(bytes.len(), found, format!("{}, as the head says", sections.at)))
        }
    }
}

/// The head as it is in the file, whether it is packed, and its length when it is not.
fn preamble(bytes: &[u8]) -> Result<(&[u8], bool, usize), BinaryError> {
    if !bytes.starts_with(MAGIC) {
        let found = if bytes.is_empty() { "an empty file" } else { "other first bytes" };
        let advice = "check that this is a .bsdft file, and that it was not transferred as text";
        return Err(BinaryError::unexpected(0, found, "BSDFT and three more bytes", advice));
    }
    let mut preamble = Bytes::new(&bytes[MAGIC.len()..], MAGIC.len());
    let version = u32::take(&mut preamble)?;
    if !(FIRST_VERSION..=VERSION).contains(&version) {
        let advice = "read it with the bsdftree that wrote it, or a newer one, and write it as XML";
        let found = format!("version {version}");
        let expected = format!("version {FIRST_VERSION} or {VERSION}");
        return Err(BinaryError::unexpected(MAGIC.len(), found, expected, advice));
    }
    let is_packed = u32::take(&mut preamble)?;
    let (stored, length) = (u64::take(&mut preamble)?, u64::take(&mut preamble)?);
    let file_length = u64::take(&mut preamble)?;
    let head_crc = u32::take(&mut preamble)?;
    let checked = preamble.offset();
    let crc = u32::take(&mut preamble)?;
    if crc != crc32fast::hash(&bytes[..checked]) || is_packed > 1 {
        return Err(BinaryError::damaged(
            0,
            "first bytes other than were written",
            "those of their checksum",
        ));
    }
    if file_length != bytes.len() as u64 {
        let found = format!("a file of {} bytes", bytes.len());
        return Err(BinaryError::damaged(bytes.len(), found, format!("{file_length}")));
    }
    let rest = bytes.get(PREAMBLE..).unwrap_or_default();
    let most = rest.len().min(stored as usize).saturating_mul(MOST_GROWTH).saturating_add(FREE_HEAD);
    match rest.get(..stored as usize) {
        Some(head) if crc32fast::hash(head) != head_crc => {
            Err(BinaryError::damaged(PREAMBLE, "a head other than was written", "that of its checksum"))
        }
        Some(head) if length <= most as u64 => Ok((head, is_packed == 1, length as usize)),
        _ => {
            let found = format!("a head of {stored} bytes, unpacked {length}");
            Err(BinaryError::damaged(PREAMBLE, found, "one that a file of this size holds"))
        }
    }
}

/// The values that follow the head.
struct Sections<'a> {
    bytes: &'a [u8],
    map: Option<&'a Map>,
    /// Where the next ones begin.
    at: usize,
    bases: &'a [Arc<Basis>],
    budget: Budget,
}

impl Sections<'_> {
    fn component(&mut self, functions: &[Function]) -> Result<Option<Component>, BinaryError> {
        let Some((luminance, chroma)) = functions.split_first() else { return Ok(None) };
        let at = self.at;
        let mut component = Component::grey(self.function(luminance)?);
        if let [a, b] = chroma {
            let chroma = [self.function(a)?, self.function(b)?];
            if !chroma.iter().all(|c| c.has_domain_of(&component.luminance)) {
                let found = "colour of another kind than luminance";
                return Err(BinaryError::damaged(at, found, "three functions of one kind"));
            }
            component.chroma = Some(chroma);
        }
        Ok(Some(component))
    }

    fn function(&mut self, (kind, stored): &Function) -> Result<Scattering, BinaryError> {
        let offset = self.at;
        let end = usize::try_from(stored.length).ok().and_then(|length| offset.checked_add(length));
        let Some((end, bytes)) = end.and_then(|end| Some((end, self.bytes.get(offset..end)?))) else {
            let found = format!("values of {} bytes", stored.length);
            let left = self.bytes.len().saturating_sub(offset);
            return Err(BinaryError::damaged(offset, found, format!("at most {left}, to the end")));
        };
        self.at = end.next_multiple_of(ALIGNMENT);
        let values = Values { bytes, offset, form: stored.form, crc: stored.crc, map: self.map };
        let bases =
            |[incident, exitant]: [u32; 2]| [&self.bases[incident as usize], &self.bases[exitant as usize]];
        Ok(match (*kind, stored.form) {
            (Kind::Tree { .. }, Form::Raw) => values.raw_tree(*kind)?.into(),
            (Kind::Tree { .. }, _) => values.packed_tree(*kind, &mut self.budget)?.into(),
            (Kind::Matrix(pair), Form::Raw) => values.raw_matrix(bases(pair))?.into(),
            (Kind::Matrix(pair), _) => values.packed_matrix(bases(pair), &mut self.budget)?.into(),
        })
    }
}
