//! Writes a BSDF as genBSDF does: the same elements in the same order, so that Radiance and WINDOW's tools take it.
//!
//! Exact: reading the file again gives the same values, structure and header. Deviation: the digits are as many as an `f32`
//! needs, not a fixed number.

use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

use thiserror::Error;

use super::write_values::{write_matrix, write_tree};
use crate::bsdf::{Bsdf, Component, Damage, Header, LengthUnit, Part, Scattering};
use crate::klems::Basis;
use crate::whole_file;

/// A BSDF that cannot be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The file system or the receiver refused.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// Nothing in it.
    #[error("the BSDF has no component; a file needs one, so add one first")]
    Empty,
    /// Trees and matrices, or trees of both ranks.
    #[error("the BSDF has {0} and {1} components; a file holds one kind, so convert one of them first")]
    MixedStructures(&'static str, &'static str),
    /// Two bases of one name.
    #[error("two different angle bases are both named `{0}`; rename one of them")]
    AmbiguousBasis(String),
    /// Infinite: no text for it.
    #[error("{0} has a value that is not finite; correct it first")]
    NotFinite(&'static str),
    /// Values that were damaged in the file they come from.
    #[error("{0}")]
    Damaged(#[from] Damage),
    /// A file, with the reason.
    #[error("{path}: {error}")]
    File {
        /// The file that was to be written.
        path: String,
        /// Why it was not.
        error: Box<WriteError>,
    },
}

/// Order of genBSDF: light from the room first.
const ORDER: [Part; 4] =
    [Part::TransmissionBack, Part::ReflectionBack, Part::TransmissionFront, Part::ReflectionFront];

/// Writes a BSDF.
///
/// # Errors
/// If it has no component, mixes kinds of components, holds an infinite value, or `out` refuses.
pub fn write(bsdf: &Bsdf, out: &mut impl Write) -> Result<(), WriteError> {
    bsdf.verify()?;
    let structure = structure(bsdf)?;
    let bases = bases(bsdf)?;
    let mut out = BufWriter::with_capacity(1 << 16, out);
    writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
    for comment in &bsdf.header.provenance {
        writeln!(out, "<!-- {} -->", comment_text(comment))?;
    }
    out.write_all(
        b"<WindowElement xmlns=\"http://windows.lbl.gov\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
          xsi:schemaLocation=\"http://windows.lbl.gov/BSDF-v1.4.xsd\">\n\
          <WindowElementType>System</WindowElementType>\n<FileType>BSDF</FileType>\n<Optical>\n<Layer>\n",
    )?;
    write_header(&bsdf.header, &mut out)?;
    writeln!(out, "\t<DataDefinition>\n\t\t<IncidentDataStructure>{structure}</IncidentDataStructure>")?;
    for basis in bases {
        write_basis(basis, &mut out)?;
    }
    writeln!(out, "\t</DataDefinition>")?;
    for band in &bsdf.bands {
        for part in ORDER {
            if let Some(component) = band.component(part) {
                write_component(&band.name, part, component, &mut out)?;
            }
        }
    }
    writeln!(out, "</Layer>\n</Optical>\n</WindowElement>")?;
    out.flush()?;
    Ok(())
}

/// Writes a BSDF to a file: whole or not at all. It takes the place of an older one only when it is safely on disk; of a link, of
/// what it leads to. What is not a file, such as `/dev/stdout` or a pipe, is written to directly.
///
/// # Errors
/// As [`write()`], naming the file.
pub fn write_file(bsdf: &Bsdf, path: impl AsRef<Path>) -> Result<(), WriteError> {
    let path = path.as_ref();
    let named = |error| WriteError::File { path: path.display().to_string(), error: Box::new(error) };
    whole_file::write(path, |file| write(bsdf, file)).map_err(named)
}

fn scatterings(bsdf: &Bsdf) -> impl Iterator<Item = &Scattering> {
    let components = bsdf.bands.iter().flat_map(|band| band.components());
    components.flat_map(|(_, component)| component.functions())
}

fn structure(bsdf: &Bsdf) -> Result<&'static str, WriteError> {
    let first = scatterings(bsdf).next().ok_or(WriteError::Empty)?.file_structure();
    for scattering in scatterings(bsdf) {
        let other = scattering.file_structure();
        if other != first {
            return Err(WriteError::MixedStructures(first, other));
        }
        let finite = match scattering {
            // All slots are seen faster than all leaves, but may be more.
            Scattering::Tree(tree) => {
                tree.arena().is_finite() || tree.leaves().all(|leaf| leaf.value.is_finite())
            }
            Scattering::Matrix(_) => true,
        };
        if !finite {
            return Err(WriteError::NotFinite(other));
        }
    }
    Ok(first)
}

/// The bases of all matrices, each once.
fn bases(bsdf: &Bsdf) -> Result<Vec<&Basis>, WriteError> {
    let mut bases: Vec<&Basis> = Vec::new();
    for scattering in scatterings(bsdf) {
        let Scattering::Matrix(matrix) = scattering else { continue };
        for basis in [matrix.incident(), matrix.exitant()].map(Arc::as_ref) {
            match bases.iter().find(|b| b.name().eq_ignore_ascii_case(basis.name())) {
                Some(same) if same.rings() == basis.rings() => {}
                Some(_) => return Err(WriteError::AmbiguousBasis(basis.name().into())),
                None => bases.push(basis),
            }
        }
    }
    Ok(bases)
}

fn write_header(header: &Header, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "\t<Material>\n\t\t<Name>{}</Name>", escaped(&header.name))?;
    writeln!(out, "\t\t<Manufacturer>{}</Manufacturer>", escaped(&header.manufacturer))?;
    if !header.properties.iter().any(|(name, _)| name == "DeviceType") {
        writeln!(out, "\t\t<DeviceType>Other</DeviceType>")?;
    }
    for (name, text) in header.properties.iter().filter(|(name, _)| Header::is_property(name)) {
        writeln!(out, "\t\t<{name}>{}</{name}>", escaped(text))?;
    }
    let unit = header.unit;
    for (name, length) in
        [("Thickness", header.thickness), ("Width", header.width), ("Height", header.height)]
    {
        if let Some(length) = length {
            let number = in_unit(length, unit.meters());
            writeln!(out, "\t\t<{name} unit=\"{}\">{number}</{name}>", capitalized(unit))?;
        }
    }
    writeln!(out, "\t</Material>")?;
    match &header.geometry {
        None => writeln!(out, "\t<Geometry></Geometry>"),
        Some(geometry) => writeln!(
            out,
            "\t<Geometry format=\"MGF\"><MGFblock unit=\"{}\">{}</MGFblock></Geometry>",
            capitalized(geometry.unit),
            escaped(&geometry.mgf)
        ),
    }
}

/// The unit as LBNL's schema spells it; Radiance takes any case.
fn capitalized(unit: LengthUnit) -> String {
    let name = unit.file_name();
    name[..1].to_ascii_uppercase() + &name[1..]
}

/// The shortest number near `length / unit` that gives back the same length in metres.
fn in_unit(length: f64, unit: f64) -> f64 {
    const DIGITS: std::ops::RangeInclusive<usize> = 5..=16;
    let quotient = length / unit;
    let rounded = |digits: usize| format!("{quotient:.digits$e}").parse().unwrap_or(quotient);
    let neighbours = [1, u64::MAX].map(|step| f64::from_bits(quotient.to_bits().wrapping_add(step)));
    let mut candidates = DIGITS.map(rounded).chain([quotient]).chain(neighbours);
    candidates.find(|number| number * unit == length).unwrap_or(quotient)
}

fn write_basis(basis: &Basis, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "\t\t<AngleBasis>\n\t\t\t<AngleBasisName>{}</AngleBasisName>", escaped(basis.name()))?;
    for ring in basis.rings() {
        let [lower, upper] = ring.bounds_deg;
        let theta = if ring.n_phi == 1 && lower == 0.0 { 0.0 } else { (lower + upper) / 2.0 };
        write!(
            out,
            "\t\t\t<AngleBasisBlock>\n\t\t\t\t<Theta>{theta}</Theta>\n\t\t\t\t<nPhis>{}</nPhis>\n\
             \t\t\t\t<ThetaBounds>\n\t\t\t\t\t<LowerTheta>{lower}</LowerTheta>\n\
             \t\t\t\t\t<UpperTheta>{upper}</UpperTheta>\n\t\t\t\t</ThetaBounds>\n\t\t\t</AngleBasisBlock>\n",
            ring.n_phi
        )?;
    }
    writeln!(out, "\t\t</AngleBasis>")
}

fn write_component(band: &str, part: Part, component: &Component, out: &mut impl Write) -> io::Result<()> {
    write_block(band, part, &component.luminance, out)?;
    let Some(chroma) = &component.chroma else { return Ok(()) };
    let names = match component.luminance {
        Scattering::Tree(_) => ["CIE-u", "CIE-v"],
        Scattering::Matrix(_) => ["CIE-X", "CIE-Z"],
    };
    names.iter().zip(chroma).try_for_each(|(name, scattering)| write_block(name, part, scattering, out))
}

fn write_block(
    wavelength: &str,
    part: Part,
    scattering: &Scattering,
    out: &mut impl Write,
) -> io::Result<()> {
    let unit = if wavelength.starts_with(|c: char| c.is_ascii_digit()) { "Nanometer" } else { "Integral" };
    writeln!(out, "\t<WavelengthData>\n\t\t<LayerNumber>System</LayerNumber>")?;
    writeln!(out, "\t\t<Wavelength unit=\"{unit}\">{}</Wavelength>", escaped(wavelength))?;
    let detector = match wavelength {
        "Visible" => Some("Y"),
        "CIE-X" => Some("X"),
        "CIE-Z" => Some("Z"),
        _ => None,
    };
    if let Some(detector) = detector {
        writeln!(out, "\t\t<SourceSpectrum>CIE Illuminant D65 1nm.ssp</SourceSpectrum>")?;
        writeln!(out, "\t\t<DetectorSpectrum>ASTM E308 1931 {detector}.dsp</DetectorSpectrum>")?;
    }
    writeln!(out, "\t\t<WavelengthDataBlock>")?;
    writeln!(out, "\t\t\t<WavelengthDataDirection>{}</WavelengthDataDirection>", part.file_name())?;
    match scattering {
        Scattering::Tree(_) => writeln!(out, "\t\t\t<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>")?,
        Scattering::Matrix(matrix) => {
            let [incident, exitant] = [matrix.incident(), matrix.exitant()].map(|b| escaped(b.name()));
            writeln!(out, "\t\t\t<ColumnAngleBasis>{incident}</ColumnAngleBasis>")?;
            writeln!(out, "\t\t\t<RowAngleBasis>{exitant}</RowAngleBasis>")?;
        }
    }
    // The schema knows no other type, and real files have it for reflection too.
    writeln!(out, "\t\t\t<ScatteringDataType>BTDF</ScatteringDataType>\n\t\t\t<ScatteringData>")?;
    match scattering {
        Scattering::Tree(tree) => write_tree(tree, out)?,
        Scattering::Matrix(matrix) => write_matrix(matrix, out)?,
    }
    writeln!(out, "\t\t\t</ScatteringData>\n\t\t</WavelengthDataBlock>\n\t</WavelengthData>")
}

/// Text with markup escaped; a control character that XML cannot hold becomes a space.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\r' => escaped.push_str("&#13;"),
            c => escaped.push(legal(c)),
        }
    }
    escaped
}

/// A comment holds no two hyphens in a row: a backslash goes between them (and one more where some are already).
fn comment_text(text: &str) -> String {
    let mut comment = String::with_capacity(text.len());
    let mut chars = text.trim().chars().peekable();
    while let Some(c) = chars.next() {
        comment.push(legal(c));
        if c == '-' {
            let mut backslashes = 0;
            while chars.next_if_eq(&'\\').is_some() {
                backslashes += 1;
            }
            comment.extend(std::iter::repeat_n('\\', backslashes));
            if chars.peek() == Some(&'-') {
                comment.push('\\');
            }
        }
    }
    comment
}

fn legal(c: char) -> char {
    let illegal = (c < ' ' && !matches!(c, '\t' | '\n')) || matches!(c, '\u{FFFE}' | '\u{FFFF}');
    if illegal { ' ' } else { c }
}
