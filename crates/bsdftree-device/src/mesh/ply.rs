//! PLY, text or binary of either byte order, by the crate `ply-rs-bw`, element by element; but for the elements of text, of
//! which it refuses numbers such as `.5` and `1.`.
//!
//! In: bytes. Out: a [`MeshFile`] of one part. Taken are the places, normals (`nx` …) and texture coordinates (`s t`, `u v` or
//! `texture_u texture_v`) of vertices, and the corners of faces (`vertex_indices` or `vertex_index`).

use std::io::Cursor;

use glam::{DVec3, Vec2};
use ply_rs_bw::parser::{Parser, Reader as PlyReader};
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType};

use super::MeshFile;
use super::parts::{Builder, Corner, Made};
use crate::error::DeviceError;
use crate::options::Limits;
use crate::rad::{quoted, real, too_large};

pub(super) fn read(bytes: &[u8], file: &str, limits: &Limits) -> Result<MeshFile, DeviceError> {
    let parser = Parser::<Record>::new();
    let mut reader = PlyReader::new(Cursor::new(bytes));
    let mut builder = Builder::new(file, limits);
    let header = parser.read_header(&mut reader).map_err(|e| DeviceError::Unexpected {
        at: builder.place(e.line().unwrap_or(1) as u32),
        expected: "the header of a PLY file".to_owned(),
        found: one_line(&e),
        advice: "export the model again".to_owned(),
    })?;
    let line = reader.line() as u32;
    let mut source = Source { parser, cursor: reader.into_inner(), line, encoding: header.encoding };
    let mut has = Known::default();
    for (name, element) in &header.elements {
        // One without properties takes no room in the file.
        if element.properties.is_empty() {
            continue;
        }
        match name.as_str() {
            "vertex" => {
                has = Known::of(element);
                for number in 0..element.count {
                    let record = source.element(element, number, &builder)?;
                    vertex(&mut builder, &record, &has, &source)?;
                }
            }
            "face" => {
                let part = builder.part(Made::Unsaid, source.line);
                for number in 0..element.count {
                    let record = source.element(element, number, &builder)?;
                    face(&mut builder, part, record, &has, &source)?;
                }
            }
            _ => {
                for number in 0..element.count {
                    source.element(element, number, &builder)?;
                }
            }
        }
    }
    let mut warnings = Vec::new();
    if header.elements.keys().any(|name| name.as_str() == "tristrips") {
        warnings.push(format!("{file}: triangle strips are left out: export the model with faces"));
    }
    Ok(builder.finish(warnings))
}

/// What vertices have beside their places.
#[derive(Clone, Copy, Default)]
struct Known {
    normals: bool,
    uvs: bool,
}

impl Known {
    fn of(element: &ElementDef) -> Known {
        let has = |names: &[&str]| names.iter().all(|name| element.properties.contains_key(*name));
        let uvs = has(&["s", "t"]) || has(&["u", "v"]) || has(&["texture_u", "texture_v"]);
        Known { normals: has(&["nx", "ny", "nz"]), uvs }
    }
}

fn vertex(builder: &mut Builder, record: &Record, has: &Known, source: &Source) -> Result<(), DeviceError> {
    let [x, y, z, nx, ny, nz, u, v] = record.numbers;
    let position = DVec3::new(x, y, z);
    if !position.is_finite() {
        return Err(source.wrong(builder, "finite coordinates", &format!("{x} {y} {z}")));
    }
    if builder.positions.len() == u32::MAX as usize {
        return Err(too_large(&builder.place(source.line), "vertices", u32::MAX as u64));
    }
    builder.positions.push(position);
    if has.normals {
        builder.normals.push(DVec3::new(nx, ny, nz).normalize_or_zero().as_vec3());
    }
    if has.uvs {
        builder.uvs.push(Vec2::new(u as f32, v as f32));
    }
    Ok(())
}

fn face(
    builder: &mut Builder,
    part: usize,
    record: Record,
    has: &Known,
    source: &Source,
) -> Result<(), DeviceError> {
    let count = builder.positions.len();
    let corner = |&index: &i64| -> Result<Corner, DeviceError> {
        let Some(k) = u32::try_from(index).ok().filter(|&k| (k as usize) < count) else {
            let expected = format!("an index of one of the {count} vertices before");
            return Err(source.wrong(builder, &expected, &index.to_string()));
        };
        Ok((k, has.uvs.then_some(k), has.normals.then_some(k)))
    };
    let corners = record.corners.iter().map(corner).collect::<Result<Vec<Corner>, _>>()?;
    if corners.len() < 3 {
        return Err(source.wrong(builder, "a face of at least 3 corners", &corners.len().to_string()));
    }
    builder.polygon(part, &corners, source.line)
}

/// The file after its header.
struct Source<'a> {
    parser: Parser<Record>,
    cursor: Cursor<&'a [u8]>,
    line: u32,
    encoding: Encoding,
}

impl Source<'_> {
    fn element(
        &mut self,
        element: &ElementDef,
        number: usize,
        builder: &Builder,
    ) -> Result<Record, DeviceError> {
        let read = match self.encoding {
            Encoding::Ascii => {
                let line = self.text_line();
                return text_element(&line, element).map_err(|found| {
                    let expected = format!("element {} of {} '{}'", number + 1, element.count, element.name);
                    self.wrong(builder, &expected, &found)
                });
            }
            Encoding::BinaryBigEndian => self.parser.read_big_endian_element(&mut self.cursor, element),
            Encoding::BinaryLittleEndian => self.parser.read_little_endian_element(&mut self.cursor, element),
        };
        read.map_err(|e| {
            let expected = format!("element {} of {} '{}'", number + 1, element.count, element.name);
            self.wrong(builder, &expected, &one_line(&e))
        })
    }

    /// The next line that is not empty; an empty one at the end.
    fn text_line(&mut self) -> String {
        let bytes = *self.cursor.get_ref();
        loop {
            let start = (self.cursor.position() as usize).min(bytes.len());
            let rest = &bytes[start..];
            let length = rest.iter().position(|&byte| byte == b'\n').map_or(rest.len(), |k| k + 1);
            self.cursor.set_position((start + length) as u64);
            self.line += 1;
            let line = String::from_utf8_lossy(&rest[..length]).trim().to_owned();
            if !line.is_empty() || length == 0 {
                return line;
            }
        }
    }

    fn wrong(&self, builder: &Builder, expected: &str, found: &str) -> DeviceError {
        let at = builder.place(self.line.saturating_sub(1));
        let (expected, found) = (expected.to_owned(), found.to_owned());
        match self.encoding {
            Encoding::Ascii => {
                DeviceError::Unexpected { at, expected, found, advice: "export the model again".to_owned() }
            }
            _ => DeviceError::Binary {
                file: at.file.to_string(),
                offset: self.cursor.position(),
                expected,
                found,
                advice: "the file is cut short or damaged: export the model again",
            },
        }
    }
}

/// An element of a line of text; what is found instead if there is none.
fn text_element(line: &str, element: &ElementDef) -> Result<Record, String> {
    let mut words = line.split_ascii_whitespace();
    let mut number = |name: &str| match words.next() {
        Some(word) => real(word).ok_or_else(|| format!("{} as '{name}'", quoted(word))),
        None => Err(format!("no '{name}'")),
    };
    let mut record = Record::new();
    for (name, property) in &element.properties {
        let value = match property.data_type {
            PropertyType::Scalar(_) => Property::Double(number(name)?),
            PropertyType::List(..) => {
                let count = number(name)?;
                // Each takes a word.
                let count =
                    if count >= 0.0 && count <= line.len() as f64 { count as usize } else { line.len() };
                let integer = |_| {
                    let value = number(name)?;
                    let whole = value as i32;
                    if f64::from(whole) == value { Ok(whole) } else { Err(format!("{value} in '{name}'")) }
                };
                Property::ListInt((0..count).map(integer).collect::<Result<_, _>>()?)
            }
        };
        record.set_property(name, value);
    }
    Ok(record)
}

fn one_line(error: &impl std::fmt::Display) -> String {
    let text = error.to_string().replace(['\n', '\t'], " ");
    match text.char_indices().nth(200) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// An element: a vertex or a face.
struct Record {
    /// x, y, z, nx, ny, nz, u, v.
    numbers: [f64; 8],
    corners: Vec<i64>,
}

impl PropertyAccess for Record {
    fn new() -> Self {
        Record { numbers: [0.0; 8], corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let index = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            "nx" => 3,
            "ny" => 4,
            "nz" => 5,
            "s" | "u" | "texture_u" => 6,
            "t" | "v" | "texture_v" => 7,
            "vertex_indices" | "vertex_index" => {
                return match integers(property) {
                    Some(corners) => {
                        self.corners = corners;
                        PropertyAccessResult::Set
                    }
                    None => PropertyAccessResult::UnsupportedType,
                };
            }
            _ => return PropertyAccessResult::Ignored,
        };
        match number(&property) {
            Some(number) => {
                self.numbers[index] = number;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}

fn number(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(x) => x.into(),
        Property::UChar(x) => x.into(),
        Property::Short(x) => x.into(),
        Property::UShort(x) => x.into(),
        Property::Int(x) => x.into(),
        Property::UInt(x) => x.into(),
        Property::Float(x) => x.into(),
        Property::Double(x) => x,
        _ => return None,
    })
}

fn integers(property: Property) -> Option<Vec<i64>> {
    Some(match property {
        Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
        Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
        _ => return None,
    })
}
