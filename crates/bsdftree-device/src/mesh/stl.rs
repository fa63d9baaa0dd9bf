//! STL, text or binary.
//!
//! In: bytes. Out: a [`MeshFile`] of one part. Corners in the same place are one vertex; the normals of facets are left out, as
//! they say nothing that the corners do not. A text may have several solids; their names name what they are made of.
//!
//! Own code: `stl_io` takes binary files that begin with `solid` for text, refuses solids without a name, reads no
//! solid but the first, and does not tell the line of an error.

use std::collections::HashMap;

use glam::DVec3;

use super::MeshFile;
use super::parts::{Builder, Made};
use crate::error::DeviceError;
use crate::options::Limits;
use crate::rad::{quoted, real, too_large};

/// Bytes of a binary file before its facets, and of each facet.
const HEAD: usize = 84;
const FACET: usize = 50;

pub(super) fn read(bytes: &[u8], file: &str, limits: &Limits) -> Result<MeshFile, DeviceError> {
    let builder = Builder::new(file, limits);
    let mut reader = Reader { builder, known: HashMap::new() };
    // Binary files may begin with the word that text begins with, but say how long they are.
    match binary_count(bytes) {
        Some(count) if bytes.len() == HEAD + count * FACET => reader.binary(&bytes[HEAD..])?,
        Some(count) if !is_text(bytes) => {
            return Err(DeviceError::Binary {
                file: file.to_owned(),
                offset: 80,
                expected: format!("as many facets as follow, {}", (bytes.len() - HEAD) / FACET),
                found: count.to_string(),
                advice: "the file is cut short or no STL file",
            });
        }
        _ => reader.text(&String::from_utf8_lossy(bytes))?,
    }
    Ok(reader.builder.finish(Vec::new()))
}

fn binary_count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEAD)?;
    Some(u32::from_le_bytes(count.try_into().ok()?) as usize)
}

fn is_text(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

struct Reader<'a> {
    builder: Builder<'a>,
    /// Vertices by the bits of their coordinates.
    known: HashMap<[u64; 3], u32>,
}

impl Reader<'_> {
    fn binary(&mut self, facets: &[u8]) -> Result<(), DeviceError> {
        let part = self.builder.part(Made::Unsaid, 1);
        for (number, facet) in facets.chunks_exact(FACET).enumerate() {
            let number_at = |k: usize| {
                let bytes = [facet[4 * k], facet[4 * k + 1], facet[4 * k + 2], facet[4 * k + 3]];
                f64::from(f32::from_le_bytes(bytes))
            };
            let corners = [3, 6, 9].map(|k| DVec3::new(number_at(k), number_at(k + 1), number_at(k + 2)));
            if !corners.iter().all(|p| p.is_finite()) {
                return Err(DeviceError::Binary {
                    file: self.builder.place(0).file.to_string(),
                    offset: (HEAD + number * FACET) as u64,
                    expected: "finite coordinates".to_owned(),
                    found: format!("{corners:?}"),
                    advice: "export the model again",
                });
            }
            self.facet(part, corners, 1)?;
        }
        Ok(())
    }

    fn facet(&mut self, part: usize, corners: [DVec3; 3], line: u32) -> Result<(), DeviceError> {
        let positions = &mut self.builder.positions;
        if positions.len() >= (u32::MAX - 3) as usize {
            return Err(too_large(&self.builder.place(line), "vertices", u32::MAX as u64));
        }
        let corners = corners.map(|p| {
            // −0 is 0.
            let key = (p + DVec3::ZERO).to_array().map(f64::to_bits);
            let index = *self.known.entry(key).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            });
            (index, None, None)
        });
        self.builder.polygon(part, &corners, line)
    }

    fn text(&mut self, text: &str) -> Result<(), DeviceError> {
        let mut part = None;
        let mut corners: Option<Vec<DVec3>> = None;
        let mut last = 1;
        for (line, number) in text.lines().zip(1u32..) {
            last = number;
            let mut words = line.split_ascii_whitespace();
            let Some(keyword) = words.next() else { continue };
            match (keyword.to_ascii_lowercase().as_str(), &mut corners) {
                ("solid", None) => {
                    let name = words.next().map_or(Made::Unsaid, |name| Made::Named(name.to_owned()));
                    part = Some(self.builder.part(name, number));
                }
                ("facet", None) if part.is_some() => corners = Some(Vec::with_capacity(3)),
                ("outer" | "endloop", Some(_)) => {}
                ("vertex", Some(corners)) => {
                    let mut coordinate = || words.next().and_then(real);
                    match (coordinate(), coordinate(), coordinate()) {
                        (Some(x), Some(y), Some(z)) => corners.push(DVec3::new(x, y, z)),
                        _ => {
                            return Err(self.unexpected(
                                "vertex and three numbers",
                                &quoted(line.trim()),
                                number,
                            ));
                        }
                    }
                }
                ("endfacet", Some(found)) => {
                    let Ok(triangle) = <[DVec3; 3]>::try_from(&found[..]) else {
                        let found = format!("{} vertices", found.len());
                        return Err(self.unexpected("three vertices before endfacet", &found, number));
                    };
                    if let Some(part) = part {
                        self.facet(part, triangle, number)?;
                    }
                    corners = None;
                }
                ("endsolid", None) => part = None,
                _ => {
                    let expected = if corners.is_some() {
                        "outer loop, vertex, endloop or endfacet"
                    } else if part.is_some() {
                        "facet or endsolid"
                    } else {
                        "solid, as STL text begins"
                    };
                    return Err(self.unexpected(expected, &quoted(line.trim()), number));
                }
            }
        }
        match part {
            Some(_) => Err(self.unexpected("endsolid", "the end of the file", last)),
            None => Ok(()),
        }
    }

    fn unexpected(&self, expected: &str, found: &str, line: u32) -> DeviceError {
        DeviceError::Unexpected {
            at: self.builder.place(line),
            expected: expected.to_owned(),
            found: found.to_owned(),
            advice: "correct the line, or export the model again".to_owned(),
        }
    }
}
