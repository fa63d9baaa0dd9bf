//! Wavefront OBJ: `v`, `vt`, `vn`, `f`, `usemtl`, `g`, `o`.
//!
//! In: text. Out: a [`MeshFile`]; what faces are made of is named by `usemtl`, before the first `usemtl` by the group, as
//! for Radiance's `obj2mesh`. Indices may be negative; 0 or nothing for `vt` and `vn` is none. Faces may have any
//! number of corners and be concave. Lines, points, curves and smoothing groups are left out; `mtllib` is, too: its
//! materials say too little of how light scatters.
//!
//! Own code: the crates for OBJ lose names of materials without their `mtl` file (`tobj`), keep f32 only, cut
//! concave faces as if convex, or do not tell the line of an error.

use std::sync::Arc;

use glam::{DVec3, Vec2};

use super::MeshFile;
use super::parts::{Builder, Corner, Made};
use crate::error::DeviceError;
use crate::options::Limits;
use crate::rad::{quoted, real};

/// Statements that are known to say nothing of surfaces or their look.
const SILENT: [&str; 9] = ["mtllib", "s", "l", "p", "lod", "usemap", "bevel", "c_interp", "d_interp"];

pub(super) fn read(bytes: &[u8], file: &str, limits: &Limits) -> Result<MeshFile, DeviceError> {
    let text = String::from_utf8_lossy(bytes);
    let builder = Builder::new(file, limits);
    let mut reader = Reader {
        builder,
        line: 0,
        material: None,
        group: None,
        part: None,
        n_unknown: 0,
        unknown: "".into(),
    };
    for (number, line) in joined_lines(&text) {
        reader.line = number;
        reader.statement(&line)?;
    }
    let mut warnings = Vec::new();
    if reader.n_unknown > 0 {
        let (n, first) = (reader.n_unknown, &reader.unknown);
        warnings.push(format!("{file}: {n} statements are left out, the first is {}", quoted(first)));
    }
    Ok(reader.builder.finish(warnings))
}

/// Lines with their numbers; those that end with a backslash go on.
fn joined_lines(text: &str) -> impl Iterator<Item = (u32, String)> {
    let mut lines = text.lines().zip(1u32..);
    std::iter::from_fn(move || {
        let (first, number) = lines.next()?;
        let mut line = first.to_owned();
        while let Some(begun) = line.strip_suffix('\\') {
            line = begun.to_owned();
            let Some((next, _)) = lines.next() else { break };
            line.push(' ');
            line += next;
        }
        Some((number, line))
    })
}

struct Reader<'a> {
    builder: Builder<'a>,
    line: u32,
    material: Option<Arc<str>>,
    group: Option<Arc<str>>,
    /// The part of this material, once a face has needed it.
    part: Option<usize>,
    n_unknown: u64,
    unknown: String,
}

impl Reader<'_> {
    fn statement(&mut self, line: &str) -> Result<(), DeviceError> {
        let line = line.split('#').next().unwrap_or("");
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword {
            "v" => {
                let [x, y, z] = self.numbers(words, "coordinates of a vertex")?;
                self.builder.positions.push(DVec3::new(x, y, z));
            }
            "vn" => {
                let normal = DVec3::from_array(self.numbers(words, "components of a normal")?);
                let Some(unit) = normal.try_normalize() else {
                    return Err(self.unexpected("a normal with a length", line.trim()));
                };
                self.builder.normals.push(unit.as_vec3());
            }
            "vt" => {
                // Radiance has no third one, and a second may be missing.
                let [u, v] = self.numbers(words.chain(["0"]), "texture coordinates")?;
                self.builder.uvs.push(Vec2::new(u as f32, v as f32));
            }
            "f" | "fo" => self.face(words)?,
            "usemtl" | "g" | "o" => {
                let name: Option<Arc<str>> = words.next().map(Into::into);
                match keyword {
                    "usemtl" => self.material = name,
                    "g" => self.group = name,
                    _ => return Ok(()),
                }
                self.part = None;
            }
            _ if SILENT.contains(&keyword) => {}
            _ => {
                if self.n_unknown == 0 {
                    self.unknown = keyword.to_owned();
                }
                self.n_unknown += 1;
            }
        }
        Ok(())
    }

    fn numbers<'w, const N: usize>(
        &self,
        mut words: impl Iterator<Item = &'w str>,
        what: &str,
    ) -> Result<[f64; N], DeviceError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let word = words.next();
            let expected = || self.unexpected(&format!("{N} {what}"), word.unwrap_or(""));
            *number = word.and_then(real).ok_or_else(expected)?;
        }
        Ok(numbers)
    }

    fn face<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Result<(), DeviceError> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<Corner>, _>>()?;
        if corners.len() < 3 {
            return Err(self.unexpected("a face of at least 3 corners", &corners.len().to_string()));
        }
        let part = match self.part {
            Some(part) => part,
            None => {
                let name = self.material.as_ref().or(self.group.as_ref());
                let material = name.map_or(Made::Unsaid, |name| Made::Named(name.to_string()));
                let part = self.builder.part(material, self.line);
                self.part = Some(part);
                part
            }
        };
        self.builder.polygon(part, &corners, self.line)
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: &str) -> Result<Corner, DeviceError> {
        let mut indices = word.split('/');
        let (v, vt, vn) = (indices.next().unwrap_or(""), indices.next(), indices.next());
        if indices.next().is_some() {
            return Err(self.unexpected("v, v/vt, v//vn or v/vt/vn", word));
        }
        let position = self.index(v, self.builder.positions.len(), "vertices", word)?;
        let Some(position) = position else {
            return Err(self.unexpected("an index of a vertex other than 0", word));
        };
        let optional = |index: Option<&str>, count: usize, what: &str| match index {
            None | Some("") => Ok(None),
            Some(index) => self.index(index, count, what, word),
        };
        Ok((
            position,
            optional(vt, self.builder.uvs.len(), "texture vertices")?,
            optional(vn, self.builder.normals.len(), "normals")?,
        ))
    }

    /// An index from 0; `None` if it is 0 in the file.
    fn index(&self, index: &str, count: usize, what: &str, word: &str) -> Result<Option<u32>, DeviceError> {
        let expected = || self.unexpected(&format!("an index of one of the {count} {what} before"), word);
        let index: i64 = index.parse().map_err(|_| expected())?;
        let from_zero = match index {
            0 => return Ok(None),
            1.. => index - 1,
            _ => count as i64 + index,
        };
        let in_range = usize::try_from(from_zero).ok().filter(|&k| k < count);
        Ok(Some(in_range.and_then(|k| u32::try_from(k).ok()).ok_or_else(expected)?))
    }

    fn unexpected(&self, expected: &str, found: &str) -> DeviceError {
        let found = if found.is_empty() { "the end of the line".to_owned() } else { quoted(found) };
        DeviceError::Unexpected {
            at: self.builder.place(self.line),
            expected: expected.to_owned(),
            found,
            advice: "correct the line, or export the model again".to_owned(),
        }
    }
}
