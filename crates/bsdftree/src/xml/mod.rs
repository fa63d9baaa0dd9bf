//! BSDF files: the XML of WINDOW 6, with Radiance's tensor trees.
//!
//! What enters are the bytes of a file from anyone, hostile ones too; what leaves is a [`Bsdf`] and the list of what was
//! repaired, or an error with the place, what was found, what was expected and what to do. Memory stays within a small
//! multiple of the file, whatever the file claims.
//!
//! Strict reading accepts all that Radiance reads without loss: CRLF, byte-order marks, CDATA, comments inside the data,
//! names in any case, several blocks, plain text before the XML declaration. It refuses what Radiance would silently
//! drop or reinterpret; [`Strictness::Repair`] accepts that too and lists it. The order of steps is `source` (bytes to
//! text), `document` (elements), `header`, `basis` and `blocks` (their meaning), `tree_text` and `matrix_text` (values).
//!
//! Sources: LBNL's schema BSDF-v1.7.7.xsd; the files that genBSDF and wrapBSDF write; Radiance's reader, observed.

mod basis;
mod blocks;
mod document;
mod error;
mod header;
mod matrix_text;
mod number;
mod plain;
mod repair;
mod source;
mod tree_text;
mod write;
mod write_values;

use std::path::Path;

pub use error::{Fault, XmlError};
pub use repair::{Repair, Severity, Strictness};
pub use write::{WriteError, write, write_file};

use crate::bsdf::Bsdf;
use crate::tree::{Rank, Tree};
use document::Document;
use number::Negatives;
use repair::Repairs;
use source::Source;

/// The BSDF in the bytes of a file, and what was noted or repaired on the way.
///
/// # Errors
/// If the file is not a BSDF, is damaged, or, read strictly, holds something that would be lost or reinterpreted.
///
/// ```
/// use bsdftree::xml::{Strictness, read, write};
/// use bsdftree::{Bsdf, Component, Part, Rank, Scattering, Tree};
///
/// let mut bsdf = Bsdf::default();
/// let diffuse = Tree::uniform(Rank::Four, 0.25);
/// bsdf.band_mut("Visible").insert(Part::ReflectionBack, Component::grey(diffuse.into()));
/// let mut file = Vec::new();
/// write(&bsdf, &mut file).unwrap();
///
/// let (again, repairs) = read(&file, Strictness::Strict).unwrap();
/// assert!(repairs.is_empty());
/// assert_eq!(again.bands[0].components().count(), 1);
/// ```
pub fn read(bytes: &[u8], strictness: Strictness) -> Result<(Bsdf, Vec<Repair>), XmlError> {
    let source = Source::new(bytes)?;
    let mut repairs = Repairs::new(strictness);
    match bsdf(&source, &mut repairs) {
        Ok(bsdf) => Ok((bsdf, repairs.located(&source))),
        Err(error) => Err(error.located(&source)),
    }
}

/// As [`read`], from a file; errors name it.
///
/// # Errors
/// As [`read`], and if the file cannot be read.
pub fn read_file(path: impl AsRef<Path>, strictness: Strictness) -> Result<(Bsdf, Vec<Repair>), XmlError> {
    let path = path.as_ref();
    read(&read_bytes(path)?, strictness).map_err(|error| error.in_file(path))
}

/// The bytes of a file.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, XmlError> {
    std::fs::read(path).map_err(|error| XmlError::new(0, Fault::Unreadable(error)).in_file(path))
}

/// The tree in a text of nested braces, as inside `ScatteringData` and as `rttree_reduce` prints it. Values \[1/sr\].
///
/// # Errors
/// If the text is not one whole tree of that rank, or a value is negative or not a finite number.
///
/// ```
/// use bsdftree::{Rank, xml::parse_tree};
///
/// // A grid's values count with dimension 0 slowest: here 2 lies where the last coordinate is in its upper half.
/// let tree = parse_tree(b"{ 1 2 3 4 5 6 7 8 }", Rank::Three).unwrap();
/// assert_eq!(tree.to_grid(1), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
/// ```
pub fn parse_tree(text: &[u8], rank: Rank) -> Result<Tree, XmlError> {
    let source = Source::raw(text)?;
    let mut negatives = Negatives::default();
    let mut repairs = Repairs::new(Strictness::Strict);
    tree_text::parse(source.text().as_bytes(), 0, rank, &mut negatives)
        .and_then(|tree| negatives.reported(&mut repairs).map(|()| tree))
        .map_err(|error| error.located(&source))
}

fn bsdf(source: &Source<'_>, repairs: &mut Repairs) -> Result<Bsdf, XmlError> {
    source.check_encoding(repairs)?;
    let document = Document::new(source.text(), source.start(), repairs)?;
    let layer = header::layer(&document, repairs)?;
    let mut provenance: Vec<String> = source.leading().map(str::to_owned).into_iter().collect();
    provenance.extend(document.comments().iter().map(|c| header::provenance(c)));
    let header = header::header(layer, provenance, repairs)?;
    let bands = blocks::bands(layer, repairs)?;
    Ok(Bsdf { header, bands })
}
