//! What a file says of itself: the device, the angle bases, and which values follow.

use std::sync::Arc;

use super::bytes::{Bytes, Number, put_text};
use super::error::BinaryError;
use super::predict::Twin;
use crate::bsdf::{Bsdf, Geometry, Header, LengthUnit, Part, Scattering};
use crate::klems::{Basis, Ring};
use crate::tree::{Content, Rank};

/// Units in the order of their numbers.
const UNITS: [LengthUnit; 5] =
    [LengthUnit::Meter, LengthUnit::Foot, LengthUnit::Inch, LengthUnit::Centimeter, LengthUnit::Millimeter];

/// What a function is made of.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// As many nodes, or a single leaf.
    Tree { rank: Rank, log2_res: u32, n_nodes: u32, leaf: f32 },
    /// Incident and exitant basis.
    Matrix([u32; 2]),
}

/// How the values of a function are in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// As in memory.
    Raw,
    /// Compressed.
    Packed,
    /// Compressed, the lowest bytes of all numbers first, then the next.
    Planes,
    /// The same of what leaves differ by from predictions; since version 2.
    Predicted(Twin),
}

impl Form {
    /// All, at their numbers.
    const ALL: [Form; 7] = [
        Form::Raw,
        Form::Packed,
        Form::Planes,
        Form::Predicted(Twin::None),
        Form::Predicted(Twin::Reciprocal),
        Form::Predicted(Twin::MirrorX),
        Form::Predicted(Twin::MirrorY),
    ];

    /// The form of a number, if values of this kind may have it.
    fn from_number(number: u8, kind: Kind) -> Option<Form> {
        let form = *Form::ALL.get(usize::from(number))?;
        let is_possible = match (form, kind) {
            (Form::Predicted(twin), Kind::Tree { rank, .. }) => Twin::all(rank).contains(&twin),
            (Form::Predicted(_), Kind::Matrix(_)) => false,
            _ => true,
        };
        is_possible.then_some(form)
    }

    fn number(self) -> u8 {
        Form::ALL.iter().position(|&form| form == self).expect("all forms are there") as u8
    }
}

/// Where the values of a function are: those of one follow those of the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    pub form: Form,
    pub length: u64,
    pub crc: u32,
}

/// A function: what it is, and where its values are.
pub(super) type Function = (Kind, Stored);

/// The functions of the four parts, each none, one or three: luminance and chroma.
pub(super) type Parts = [Vec<Function>; 4];

/// All of it.
pub(super) struct Head {
    pub header: Header,
    pub bases: Vec<Arc<Basis>>,
    pub bands: Vec<(String, Parts)>,
}

/// The bases of all matrices, each once.
pub(super) fn bases(bsdf: &Bsdf) -> Vec<Arc<Basis>> {
    let mut bases: Vec<Arc<Basis>> = Vec::new();
    let components = bsdf.bands.iter().flat_map(|band| band.components());
    for function in components.flat_map(|(_, component)| component.functions()) {
        let Scattering::Matrix(matrix) = function else { continue };
        for basis in [matrix.incident(), matrix.exitant()] {
            if !bases.contains(basis) {
                bases.push(Arc::clone(basis));
            }
        }
    }
    bases
}

impl Kind {
    /// That of a function.
    pub(super) fn of(function: &Scattering, bases: &[Arc<Basis>]) -> Kind {
        match function {
            Scattering::Tree(tree) => {
                let (arena, rank) = (tree.arena(), tree.rank());
                let leaf = match arena.root().content() {
                    Content::Leaf(value) => value,
                    Content::Node(_) => 0.0,
                };
                // How many nodes there are is known when they are in order.
                Kind::Tree { rank, log2_res: arena.log2_res(), n_nodes: 0, leaf }
            }
            Scattering::Matrix(matrix) => Kind::Matrix(
                [matrix.incident(), matrix.exitant()]
                    .map(|basis| bases.iter().position(|b| b == basis).expect("all bases are there") as u32),
            ),
        }
    }
}

impl Head {
    /// Its bytes.
    pub(super) fn bytes(&self) -> Result<Vec<u8>, String> {
        let mut out = Vec::new();
        put_header(&self.header, &mut out)?;
        put_count(self.bases.len(), &mut out);
        for basis in &self.bases {
            put_text(basis.name(), &mut out)?;
            put_count(basis.rings().len(), &mut out);
            for ring in basis.rings() {
                ring.bounds_deg.into_iter().for_each(|bound| bound.put(&mut out));
                ring.n_phi.put(&mut out);
            }
        }
        put_count(self.bands.len(), &mut out);
        for (name, parts) in &self.bands {
            put_text(name, &mut out)?;
            for functions in parts {
                (functions.len() as u8).put(&mut out);
                functions.iter().for_each(|function| put_function(function, &mut out));
            }
        }
        Ok(out)
    }

    /// From its bytes.
    pub(super) fn read(bytes: &mut Bytes<'_>) -> Result<Head, BinaryError> {
        let header = take_header(bytes)?;
        let bases = take_all(bytes, "angle bases", take_basis)?;
        let bands = take_all(bytes, "bands", |bytes| {
            let name = bytes.text()?;
            let mut parts = Parts::default();
            for functions in &mut parts {
                let (offset, n) = (bytes.offset(), u8::take(bytes)?);
                if !matches!(n, 0 | 1 | 3) {
                    return Err(BinaryError::damaged(offset, format!("{n} functions"), "0, 1 or 3"));
                }
                for _ in 0..n {
                    functions.push(take_function(bytes, bases.len())?);
                }
            }
            Ok((name, parts))
        })?;
        if bytes.left() > 0 {
            let found = format!("{} more bytes", bytes.left());
            return Err(BinaryError::damaged(bytes.offset(), found, "the end of the head"));
        }
        Ok(Head { header, bases, bands })
    }
}

fn put_count(n: usize, out: &mut Vec<u8>) {
    u32::try_from(n).expect("fewer than texts of 4 GiB hold").put(out);
}

/// As many things as a number says, each of which takes four bytes at least.
fn take_all<T>(
    bytes: &mut Bytes<'_>,
    what: &str,
    mut take: impl FnMut(&mut Bytes<'_>) -> Result<T, BinaryError>,
) -> Result<Vec<T>, BinaryError> {
    let (offset, n) = (bytes.offset(), u32::take(bytes)? as usize);
    if n > bytes.left() / 4 {
        let found = format!("{n} {what}");
        return Err(BinaryError::damaged(offset, found, format!("what {} bytes hold", bytes.left())));
    }
    (0..n).map(|_| take(bytes)).collect()
}

fn put_header(header: &Header, out: &mut Vec<u8>) -> Result<(), String> {
    put_text(&header.name, out)?;
    put_text(&header.manufacturer, out)?;
    put_unit(header.unit, out);
    for length in [header.thickness, header.width, header.height] {
        u8::from(length.is_some()).put(out);
        length.unwrap_or(0.0).put(out);
    }
    put_count(header.properties.len(), out);
    for (name, text) in &header.properties {
        put_text(name, out)?;
        put_text(text, out)?;
    }
    put_count(header.provenance.len(), out);
    header.provenance.iter().try_for_each(|text| put_text(text, out))?;
    u8::from(header.geometry.is_some()).put(out);
    if let Some(geometry) = &header.geometry {
        put_unit(geometry.unit, out);
        put_text(&geometry.mgf, out)?;
    }
    Ok(())
}

fn take_header(bytes: &mut Bytes<'_>) -> Result<Header, BinaryError> {
    let mut header = Header { name: bytes.text()?, manufacturer: bytes.text()?, ..Header::default() };
    header.unit = take_unit(bytes)?;
    for length in [&mut header.thickness, &mut header.width, &mut header.height] {
        let (is_there, offset, value) = (take_flag(bytes)?, bytes.offset(), f64::take(bytes)?);
        if !value.is_finite() {
            return Err(BinaryError::damaged(offset, format!("a length of {value} m"), "a finite number"));
        }
        *length = is_there.then_some(value);
    }
    header.properties = take_all(bytes, "properties", |bytes| {
        let (offset, name) = (bytes.offset(), bytes.text()?);
        if !Header::is_property(&name) {
            let found = format!("a property named {name:?}");
            return Err(BinaryError::damaged(offset, found, "letters, digits, `_`, `-` and `.`"));
        }
        Ok((name, bytes.text()?))
    })?;
    header.provenance = take_all(bytes, "comments", |bytes| bytes.text())?;
    if take_flag(bytes)? {
        header.geometry = Some(Geometry { unit: take_unit(bytes)?, mgf: bytes.text()? });
    }
    Ok(header)
}

fn take_flag(bytes: &mut Bytes<'_>) -> Result<bool, BinaryError> {
    match (bytes.offset(), u8::take(bytes)?) {
        (_, flag @ 0..=1) => Ok(flag == 1),
        (offset, other) => Err(BinaryError::damaged(offset, format!("the number {other}"), "0 or 1")),
    }
}

fn put_unit(unit: LengthUnit, out: &mut Vec<u8>) {
    (UNITS.iter().position(|&u| u == unit).expect("all units are there") as u8).put(out);
}

fn take_unit(bytes: &mut Bytes<'_>) -> Result<LengthUnit, BinaryError> {
    let (offset, unit) = (bytes.offset(), u8::take(bytes)?);
    UNITS
        .get(usize::from(unit))
        .copied()
        .ok_or_else(|| BinaryError::damaged(offset, format!("unit of length {unit}"), "0 to 4"))
}

fn take_basis(bytes: &mut Bytes<'_>) -> Result<Arc<Basis>, BinaryError> {
    let (offset, name) = (bytes.offset(), bytes.text()?);
    let rings = take_all(bytes, "rings", |bytes| {
        Ok(Ring { bounds_deg: [f64::take(bytes)?, f64::take(bytes)?], n_phi: u32::take(bytes)? })
    })?;
    let basis = Basis::new(name, rings).map_err(|problem| {
        BinaryError::damaged(offset, format!("an angle basis: {problem}"), "rings from 0° to 90°")
    })?;
    Ok(Arc::new(basis))
}

fn put_function(&(kind, stored): &Function, out: &mut Vec<u8>) {
    match kind {
        Kind::Tree { rank, log2_res, n_nodes, leaf } => {
            (rank.dimensions() as u8).put(out);
            (log2_res as u8).put(out);
            n_nodes.put(out);
            leaf.put(out);
        }
        Kind::Matrix(bases) => {
            0u8.put(out);
            bases.into_iter().for_each(|basis| basis.put(out));
        }
    }
    stored.form.number().put(out);
    stored.length.put(out);
    stored.crc.put(out);
}

fn take_function(bytes: &mut Bytes<'_>, n_bases: usize) -> Result<Function, BinaryError> {
    let (offset, number) = (bytes.offset(), u8::take(bytes)?);
    let tree = |rank, bytes: &mut Bytes<'_>| -> Result<Kind, BinaryError> {
        let (log2_res, n_nodes) = (u32::from(u8::take(bytes)?), u32::take(bytes)?);
        Ok(Kind::Tree { rank, log2_res, n_nodes, leaf: f32::take(bytes)? })
    };
    let kind = match number {
        3 => tree(Rank::Three, bytes)?,
        4 => tree(Rank::Four, bytes)?,
        0 => Kind::Matrix([u32::take(bytes)?, u32::take(bytes)?]),
        other => {
            let found = format!("values of kind {other}");
            return Err(BinaryError::damaged(offset, found, "0 (matrix), 3 or 4 (rank of a tree)"));
        }
    };
    if let Kind::Matrix(bases) = kind
        && let Some(basis) = bases.into_iter().find(|&basis| basis as usize >= n_bases)
    {
        let found = format!("angle basis {basis}");
        return Err(BinaryError::damaged(offset, found, format!("one of {n_bases}")));
    }
    let (offset, number) = (bytes.offset(), u8::take(bytes)?);
    let form = Form::from_number(number, kind).ok_or_else(|| {
        BinaryError::damaged(offset, format!("values in the form {number}"), "one that they may have")
    })?;
    Ok((kind, Stored { form, length: u64::take(bytes)?, crc: u32::take(bytes)? }))
}

/// Numbers of the parts are their places in [`Part::ALL`].
pub(super) const PARTS: [Part; 4] = Part::ALL;
