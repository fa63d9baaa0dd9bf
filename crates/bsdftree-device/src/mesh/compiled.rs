//! The parts that Radiance's binary files share: header, numbers, voxels, scene.
//!
//! In: bytes. Out: numbers and statements, or what is wrong at which byte. All lengths are checked against what is there.
//! Source: files written by `obj2mesh` and `oconv` (2025), taken apart: numbers are big-endian; a real is a mantissa of 4
//! bytes and an exponent of 1; an object is a type's number, its modifier's number, its name, its string and its real
//! arguments. Objects know their modifiers by number; here by name, as long as no other has come to have the name.

use std::collections::{HashMap, HashSet};

use crate::error::DeviceError;
use crate::rad::{Content, Primitive, Statement, is_surface};

/// Where it is read, and how far.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    file: &'a str,
    /// Bytes of an object's number.
    number_size: usize,
}

/// Voxels in voxels, at most.
const DEEPEST: u32 = 64;

const ADVICE: &str = "the file is cut short or damaged: make it again";

impl<'a> Reader<'a> {
    /// Begins after the header of a file of a format, whose version is told by `magic` and the size of numbers.
    pub fn open(bytes: &'a [u8], file: &'a str, format: &str, magic: i64) -> Result<Reader<'a>, DeviceError> {
        let mut reader = Reader { bytes, at: 0, file, number_size: 0 };
        let head = bytes.windows(2).take(1 << 20).position(|pair| pair == b"\n\n");
        let text = head.map_or("", |end| std::str::from_utf8(&bytes[..end]).unwrap_or(""));
        let format_line = format!("FORMAT={format}");
        if !text.starts_with("#?") || !text.lines().any(|line| line.trim() == format_line) {
            let found = text.lines().find(|line| line.starts_with("FORMAT=")).unwrap_or("no such header");
            let expected = format!("a header with '{format_line}'");
            return Err(reader.wrong_at(0, &expected, found));
        }
        reader.at = head.map_or(0, |end| end + 2);
        let version = reader.integer(2, "the version")?;
        match version - magic {
            size @ (2 | 4 | 8) => reader.number_size = size as usize,
            _ => {
                return Err(reader.wrong_at(
                    reader.at - 2,
                    &format!("version {} of {format}", magic + 4),
                    &version.to_string(),
                ));
            }
        }
        Ok(reader)
    }

    pub fn offset(&self) -> usize {
        self.at
    }

    fn take(&mut self, n: usize, what: &str) -> Result<&'a [u8], DeviceError> {
        match self.bytes.get(self.at..).and_then(|rest| rest.get(..n)) {
            Some(taken) => {
                self.at += n;
                Ok(taken)
            }
            None => Err(self.wrong_at(self.at, what, "the end of the file")),
        }
    }

    /// A signed integer of at most 8 bytes.
    pub fn integer(&mut self, size: usize, what: &str) -> Result<i64, DeviceError> {
        let bytes = self.take(size, what)?;
        let unsigned = bytes.iter().fold(0u64, |value, &byte| value << 8 | u64::from(byte));
        let unused = 64 - 8 * size as u32;
        Ok((unsigned << unused) as i64 >> unused)
    }

    pub fn unsigned(&mut self, size: usize, what: &str) -> Result<u64, DeviceError> {
        Ok(self.take(size, what)?.iter().fold(0u64, |value, &byte| value << 8 | u64::from(byte)))
    }

    /// A count of things of which each takes some bytes; so no count exceeds the file.
    pub fn count(&mut self, size: usize, each: usize, what: &str) -> Result<usize, DeviceError> {
        let at = self.at;
        let count = self.integer(size, what)?;
        match usize::try_from(count) {
            Ok(count) if count.saturating_mul(each) <= self.bytes.len() - self.at => Ok(count),
            _ => Err(self.wrong_at(at, &format!("{what} that fits the file"), &count.to_string())),
        }
    }

    pub fn number(&mut self, what: &str) -> Result<i64, DeviceError> {
        self.integer(self.number_size, what)
    }

    pub fn real(&mut self, what: &str) -> Result<f64, DeviceError> {
        let mantissa = self.integer(4, what)?;
        let exponent = self.integer(1, what)?;
        if mantissa == 0 {
            return Ok(0.0);
        }
        let half = if mantissa > 0 { 0.5 } else { -0.5 };
        Ok((mantissa as f64 + half) / f64::from(i32::MAX) * (exponent as f64).exp2())
    }

    pub fn string(&mut self, what: &str) -> Result<String, DeviceError> {
        let rest = &self.bytes[self.at..];
        let Some(length) = rest.iter().position(|&byte| byte == 0) else {
            return Err(self.wrong_at(self.at, what, "the end of the file"));
        };
        self.at += length + 1;
        Ok(String::from_utf8_lossy(&rest[..length]).into_owned())
    }

    /// Corner and size of the cube around everything, which are written as text.
    pub fn cube(&mut self) -> Result<([f64; 3], f64), DeviceError> {
        let mut numbers = [0.0; 4];
        for number in &mut numbers {
            let at = self.at;
            let text = self.string("the cube's bounds")?;
            *number = crate::rad::real(&text).ok_or_else(|| self.wrong_at(at, "a number", &text))?;
        }
        let [x, y, z, size] = numbers;
        Ok(([x, y, z], size))
    }

    /// Passes over the voxels.
    pub fn skip_voxels(&mut self) -> Result<(), DeviceError> {
        // Voxels that are still to come on each level.
        let mut waiting = vec![1u32];
        while let Some(left) = waiting.last_mut() {
            if *left == 0 {
                waiting.pop();
                continue;
            }
            *left -= 1;
            let at = self.at;
            match self.unsigned(1, "a voxel")? {
                0 => {}
                1 => {
                    let count = self.count(self.number_size, self.number_size, "a number of objects")?;
                    self.take(count * self.number_size, "objects")?;
                }
                2 if waiting.len() < DEEPEST as usize => waiting.push(8),
                2 => return Err(self.wrong_at(at, "voxels nested less deeply", "more than 64 levels")),
                kind => return Err(self.wrong_at(at, "a voxel (0, 1 or 2)", &kind.to_string())),
            }
        }
        Ok(())
    }

    /// The objects of a scene, and the names by which each is known now.
    pub fn scene(&mut self) -> Result<Objects, DeviceError> {
        let mut kinds = Vec::new();
        loop {
            match self.string("a type of object")? {
                kind if kind.is_empty() => break,
                kind => kinds.push(kind),
            }
        }
        let mut objects = Objects { raw: Vec::new(), renamed: HashSet::new() };
        // The last modifier of each name.
        let mut latest: HashMap<String, usize> = HashMap::new();
        loop {
            let at = self.at;
            let kind = match self.integer(1, "an object")? {
                -1 => return Ok(objects),
                kind => usize::try_from(kind).ok().and_then(|k| kinds.get(k)).cloned(),
            };
            let kind =
                kind.ok_or_else(|| self.wrong_at(at, "one of the types of objects", "another number"))?;
            let modifier = self.number("a modifier")?;
            let modifier = match usize::try_from(modifier) {
                _ if modifier == -1 => None,
                Ok(k) if k < objects.raw.len() => Some(k),
                _ => {
                    return Err(self.wrong_at(
                        at,
                        "the number of an object before it",
                        &modifier.to_string(),
                    ));
                }
            };
            let name = self.string("a name")?;
            let n_strings = self.count(2, 1, "a number of strings")?;
            let strings = (0..n_strings).map(|_| self.string("a string")).collect::<Result<_, _>>()?;
            let n_reals = self.count(2, 5, "a number of reals")?;
            let reals = (0..n_reals).map(|_| self.real("a real")).collect::<Result<_, _>>()?;
            if let Some(k) = modifier
                && latest.get(&objects.raw[k].name) != Some(&k)
            {
                objects.renamed.insert(k);
            }
            if !is_surface(&kind) {
                latest.insert(name.clone(), objects.raw.len());
            }
            objects.raw.push(Raw { at, kind, modifier, name, strings, reals });
        }
    }

    pub fn wrong_at(&self, offset: usize, expected: &str, found: &str) -> DeviceError {
        DeviceError::Binary {
            file: self.file.to_owned(),
            offset: offset as u64,
            expected: expected.to_owned(),
            found: found.to_owned(),
            advice: ADVICE,
        }
    }
}

struct Raw {
    at: usize,
    kind: String,
    modifier: Option<usize>,
    name: String,
    strings: Vec<String>,
    reals: Vec<f64>,
}

/// The objects of a compiled scene.
pub(super) struct Objects {
    raw: Vec<Raw>,
    /// Those whose name another has taken before their last use.
    renamed: HashSet<usize>,
}

impl Objects {
    pub fn len(&self) -> usize {
        self.raw.len()
    }

    /// The name of an object.
    pub fn name(&self, k: usize) -> String {
        let name = &self.raw[k].name;
        if self.renamed.contains(&k) { format!("{name}#{k}") } else { name.clone() }
    }

    /// As statements, each on the line of its number from 1.
    pub fn statements(&self, reader: &Reader) -> Result<Vec<Statement>, DeviceError> {
        let statement = |(k, raw): (usize, &Raw)| {
            let modifier = raw.modifier.map(|k| self.name(k));
            let line = k as u32 + 1;
            let name = self.name(k);
            if raw.kind == "alias" {
                let reference = raw.strings.first().cloned();
                return Ok(match (modifier, reference) {
                    (Some(modifier), None) => {
                        // An alias of nothing else is its modifier.
                        Statement {
                            line,
                            content: Content::Alias {
                                modifier: "inherit".to_owned(),
                                name,
                                reference: modifier,
                            },
                        }
                    }
                    (modifier, Some(reference)) => {
                        let modifier = modifier.unwrap_or_else(|| "void".to_owned());
                        Statement { line, content: Content::Alias { modifier, name, reference } }
                    }
                    (None, None) => {
                        return Err(reader.wrong_at(raw.at, "what an alias stands for", "nothing"));
                    }
                });
            }
            let modifier = modifier.unwrap_or_else(|| "void".to_owned());
            let primitive =
                Primitive::of(modifier, raw.kind.clone(), name, raw.strings.clone(), raw.reals.clone());
            let primitive =
                primitive.ok_or_else(|| reader.wrong_at(raw.at, "a type of Radiance", &raw.kind))?;
            Ok(Statement { line, content: Content::Primitive(primitive) })
        };
        self.raw.iter().enumerate().map(statement).collect()
    }
}
