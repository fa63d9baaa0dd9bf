//! The container "tensor_file" of EPFL's RGL: named arrays of any shape.
//!
//! In: bytes: `tensor_file` and a zero, version 1.0, a count; for each field the length of its name and the name, its number of axes, the
//! type, the place of its numbers, and its shape; all little-endian. Out: fields of 32-bit floats and of bytes; others are left out.
//! Arrays are only taken if they lie in the file, so memory is bounded by it.

use std::collections::HashMap;

use super::error::ReadError;

const MAGIC: &[u8] = b"tensor_file\0";
const UINT8: u8 = 1;
const FLOAT32: u8 = 10;

/// An array.
#[derive(Debug)]
pub(super) struct Field {
    pub(super) shape: Vec<usize>,
    pub(super) values: Values,
    /// Where it lies.
    pub(super) byte: usize,
}

#[derive(Debug)]
pub(super) enum Values {
    Floats(Vec<f32>),
    Bytes(Vec<u8>),
}

/// All fields.
#[derive(Debug)]
pub(super) struct TensorFile {
    fields: HashMap<String, Field>,
}

/// Whether it begins so.
pub(super) fn recognizes(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], ReadError> {
        let end = || {
            ReadError::byte(self.at, "the end of the file", format!("{n} bytes more: the file is cut off"))
        };
        let taken = self.bytes.get(self.at..self.at.saturating_add(n)).ok_or_else(end)?;
        self.at += n;
        Ok(taken)
    }

    /// An unsigned integer of up to 8 bytes.
    fn number(&mut self, n_bytes: usize) -> Result<usize, ReadError> {
        let at = self.at;
        let number = self.take(n_bytes)?.iter().rev().fold(0u64, |sum, &byte| sum << 8 | u64::from(byte));
        usize::try_from(number).map_err(|_| ReadError::byte(at, number.to_string(), "a smaller number"))
    }
}

impl TensorFile {
    /// Reads a file.
    ///
    /// # Errors
    /// If it is none, or cut off.
    pub(super) fn read(bytes: &[u8]) -> Result<TensorFile, ReadError> {
        if !recognizes(bytes) {
            return Err(ReadError::byte(0, "other bytes", "tensor_file"));
        }
        let mut cursor = Cursor { bytes, at: MAGIC.len() };
        let version = cursor.take(2)?;
        if version != [1, 0] {
            return Err(ReadError::byte(MAGIC.len(), format!("version {version:?}"), "version 1.0"));
        }
        let mut fields = HashMap::new();
        for _ in 0..cursor.number(4)? {
            let n_name = cursor.number(2)?;
            let name = String::from_utf8_lossy(cursor.take(n_name)?).into_owned();
            let n_axes = cursor.number(2)?;
            let kind = cursor.take(1)?[0];
            let byte = cursor.number(8)?;
            let shape: Vec<usize> = (0..n_axes).map(|_| cursor.number(8)).collect::<Result<_, _>>()?;
            if let Some(field) = field(bytes, &name, kind, byte, shape)? {
                fields.insert(name, field);
            }
        }
        Ok(TensorFile { fields })
    }

    /// The floats of a field with so many axes.
    ///
    /// # Errors
    /// If it is absent or of another kind.
    pub(super) fn floats(&self, name: &str, n_axes: usize) -> Result<(&[usize], &[f32]), ReadError> {
        let expected = || format!("a field {name:?} of 32-bit floats with {n_axes} axes");
        let field = self.fields.get(name).ok_or_else(|| ReadError::file(self.names(), expected()))?;
        let values = match &field.values {
            Values::Floats(values) if field.shape.len() == n_axes => values,
            _ => return Err(ReadError::byte(field.byte, format!("shape {:?}", field.shape), expected())),
        };
        if let Some(k) = values.iter().position(|value| !value.is_finite()) {
            return Err(ReadError::byte(
                field.byte + 4 * k,
                values[k].to_string(),
                format!("finite numbers in {name:?}"),
            ));
        }
        Ok((&field.shape, values))
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.fields.contains_key(name)
    }

    /// Whether the first byte of a field is not 0; `None` if there is no such field.
    pub(super) fn flag(&self, name: &str) -> Option<bool> {
        match &self.fields.get(name)?.values {
            Values::Bytes(bytes) => bytes.first().map(|&byte| byte != 0),
            Values::Floats(_) => None,
        }
    }

    /// A field of bytes as text.
    pub(super) fn text(&self, name: &str) -> Option<String> {
        match &self.fields.get(name)?.values {
            Values::Bytes(bytes) => {
                Some(String::from_utf8_lossy(bytes).trim_matches(['\0', ' ', '\n']).to_owned())
            }
            Values::Floats(_) => None,
        }
    }

    fn names(&self) -> String {
        let mut names: Vec<&str> = self.fields.keys().map(String::as_str).collect();
        names.sort_unstable();
        format!("the fields {}", names.join(", "))
    }
}

fn field(
    bytes: &[u8],
    name: &str,
    kind: u8,
    byte: usize,
    shape: Vec<usize>,
) -> Result<Option<Field>, ReadError> {
    let size = match kind {
        UINT8 => 1,
        FLOAT32 => 4,
        _ => return Ok(None),
    };
    let length = shape.iter().try_fold(size, |n: usize, &along| n.checked_mul(along));
    let data = length.and_then(|length| bytes.get(byte..byte.checked_add(length)?));
    let data = data.ok_or_else(|| {
        let found = format!("{name:?} with shape {shape:?} at byte {byte} of {}", bytes.len());
        ReadError::byte(
            byte.min(bytes.len()),
            found,
            "a field that lies in the file: it is cut off or damaged",
        )
    })?;
    let values = match kind {
        UINT8 => Values::Bytes(data.to_vec()),
        _ => Values::Floats(data.as_chunks::<4>().0.iter().map(|&word| f32::from_le_bytes(word)).collect()),
    };
    Ok(Some(Field { shape, values, byte }))
}
