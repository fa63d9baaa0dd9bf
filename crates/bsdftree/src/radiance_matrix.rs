//! Radiance's matrix files, as rmtxop, rcomb and dctimestep read and write them.
//!
//! In: bytes. Out: rows, columns and components with all values; or the other way round. The header is lines of text, `#?RADIANCE` first,
//! an empty one last: NROWS, NCOLS, NCOMP (3 if absent), FORMAT (ascii, float or double), BigEndian. Values follow row by row, the
//! components of an element side by side. Radiance's pictures (FORMAT=32-bit_rle_…) are matrices to it as well, but not here.

use std::io::{self, Write};
use std::path::Path;

use thiserror::Error;

use crate::whole_file;

/// Most values that are read: 2^31.
const MAX_VALUES: usize = 1 << 31;

/// A matrix of elements with one or more components.
#[derive(Clone, Debug, PartialEq)]
pub struct RadianceMatrix {
    /// Number of rows.
    pub n_rows: usize,
    /// Number of columns.
    pub n_columns: usize,
    /// Components of an element: 1, or 3 for red, green and blue.
    pub n_components: usize,
    /// Row by row, the components of an element side by side.
    pub values: Vec<f64>,
}

/// How values are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text.
    Ascii,
    /// 32 bits, of this machine's byte order.
    Float,
    /// 64 bits.
    Double,
}

/// What is wrong with a file.
#[derive(Debug, Error, PartialEq)]
pub enum MatrixFileError {
    /// Not one of Radiance's files.
    #[error("the file begins with {0:?}; expected #?RADIANCE")]
    NoHeader(String),
    /// A header that does not end.
    #[error("the header has no empty line at its end")]
    EndlessHeader,
    /// A line of the header.
    #[error("line {line} of the header is {text:?}; expected {expected}")]
    Line {
        /// From 1.
        line: usize,
        /// What stands there.
        text: String,
        /// What should.
        expected: &'static str,
    },
    /// A line that the header lacks.
    #[error("the header has no {0}")]
    Missing(&'static str),
    /// Too few or many values.
    #[error("{found} values after the header; expected {expected}: rows × columns × components")]
    Count {
        /// Values found, 0 if they are more than there may be.
        found: usize,
        /// Values expected.
        expected: usize,
    },
    /// A word that is no number.
    #[error("value {index} is {text:?}; expected a number")]
    Number {
        /// From 0.
        index: usize,
        /// What stands there.
        text: String,
    },
}

#[derive(Default)]
struct Header {
    rows: Option<usize>,
    columns: Option<usize>,
    components: Option<usize>,
    format: Option<Format>,
    is_big_endian: bool,
}

impl RadianceMatrix {
    /// Reads a file.
    ///
    /// # Errors
    /// If it is none, or values are missing or too many.
    pub fn read(bytes: &[u8]) -> Result<RadianceMatrix, MatrixFileError> {
        let (header, body) = read_header(bytes)?;
        let n_rows = header.rows.ok_or(MatrixFileError::Missing("NROWS"))?;
        let n_columns = header.columns.ok_or(MatrixFileError::Missing("NCOLS"))?;
        let n_components = header.components.unwrap_or(3);
        let format = header.format.ok_or(MatrixFileError::Missing("FORMAT"))?;
        let expected = n_rows.checked_mul(n_columns).and_then(|n| n.checked_mul(n_components));
        let expected = expected
            .filter(|&n| n <= MAX_VALUES)
            .ok_or(MatrixFileError::Count { found: 0, expected: MAX_VALUES })?;
        let big = header.is_big_endian;
        let values: Vec<f64> = match format {
            Format::Ascii => ascii(body)?,
            Format::Float => {
                let (words, rest) = body.as_chunks::<4>();
                let value = |w: &[u8; 4]| {
                    f64::from(if big { f32::from_be_bytes(*w) } else { f32::from_le_bytes(*w) })
                };
                whole(words.iter().map(value), rest)
            }
            Format::Double => {
                let (words, rest) = body.as_chunks::<8>();
                let value = |w: &[u8; 8]| if big { f64::from_be_bytes(*w) } else { f64::from_le_bytes(*w) };
                whole(words.iter().map(value), rest)
            }
        };
        match values.len() == expected {
            true => Ok(RadianceMatrix { n_rows, n_columns, n_components, values }),
            false => Err(MatrixFileError::Count { found: values.len(), expected }),
        }
    }

    /// Writes a file, which takes the place of an older one when it is complete.
    ///
    /// # Errors
    /// If it cannot be written.
    ///
    /// # Panics
    /// As [`RadianceMatrix::write`].
    pub fn write_file(&self, path: &Path, format: Format) -> io::Result<()> {
        let bytes = self.write(format);
        whole_file::write(path, |file| file.write_all(&bytes))
    }

    /// The bytes of a file.
    ///
    /// # Panics
    /// If there are not as many values as rows × columns × components.
    pub fn write(&self, format: Format) -> Vec<u8> {
        assert_eq!(self.values.len(), self.n_rows * self.n_columns * self.n_components);
        let (name, order) = match format {
            Format::Ascii => ("ascii", ""),
            Format::Float => ("float", "BigEndian=0\n"),
            Format::Double => ("double", "BigEndian=0\n"),
        };
        let mut bytes = format!(
            "#?RADIANCE\nbsdftree {}\nNCOMP={}\nNROWS={}\nNCOLS={}\n{order}FORMAT={name}\n\n",
            env!("CARGO_PKG_VERSION"),
            self.n_components,
            self.n_rows,
            self.n_columns
        )
        .into_bytes();
        match format {
            Format::Ascii => {
                for row in self.values.chunks((self.n_columns * self.n_components).max(1)) {
                    for (k, value) in row.iter().enumerate() {
                        let between = if k == 0 {
                            ""
                        } else if k % self.n_components == 0 {
                            "\t"
                        } else {
                            " "
                        };
                        bytes.extend_from_slice(format!("{between}{value}").as_bytes());
                    }
                    bytes.push(b'\n');
                }
            }
            Format::Float => self.values.iter().for_each(|&v| bytes.extend((v as f32).to_le_bytes())),
            Format::Double => self.values.iter().for_each(|v| bytes.extend(v.to_le_bytes())),
        }
        bytes
    }
}

/// Values, and one more that is not a number if bytes are left.
fn whole(values: impl Iterator<Item = f64>, rest: &[u8]) -> Vec<f64> {
    values.chain((!rest.is_empty()).then_some(f64::NAN)).collect()
}

fn ascii(body: &[u8]) -> Result<Vec<f64>, MatrixFileError> {
    let separates = |b: &u8| b.is_ascii_whitespace() || *b == b',';
    let words = body.split(separates).filter(|word| !word.is_empty());
    let number = |(index, word): (usize, &[u8])| {
        fast_float2::parse(word).map_err(|_| {
            let text = String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned();
            MatrixFileError::Number { index, text }
        })
    };
    words.enumerate().map(number).collect()
}

fn read_header(bytes: &[u8]) -> Result<(Header, &[u8]), MatrixFileError> {
    let mut header = Header::default();
    let mut rest = bytes;
    for line in 1.. {
        let Some(end) = memchr::memchr(b'\n', rest) else { return Err(MatrixFileError::EndlessHeader) };
        let text = String::from_utf8_lossy(&rest[..end.min(200)]).trim_end().to_owned();
        rest = &rest[end + 1..];
        if line == 1 && !text.starts_with("#?") {
            return Err(MatrixFileError::NoHeader(text.chars().take(20).collect()));
        }
        if text.is_empty() {
            return Ok((header, rest));
        }
        let Some((name, value)) = text.split_once('=') else { continue };
        let wrong = |expected| MatrixFileError::Line { line, text: text.clone(), expected };
        let count = || {
            value.trim().parse::<usize>().ok().filter(|&n| n > 0).ok_or_else(|| wrong("a count of 1 or more"))
        };
        match name {
            "NROWS" => header.rows = Some(count()?),
            "NCOLS" => header.columns = Some(count()?),
            "NCOMP" => header.components = Some(count()?),
            "BigEndian" => header.is_big_endian = value.trim() == "1",
            "FORMAT" => {
                header.format = Some(match value.trim() {
                    "ascii" => Format::Ascii,
                    "float" => Format::Float,
                    "double" => Format::Double,
                    _ => return Err(wrong("FORMAT=ascii, float or double (rmtxop -fd converts)")),
                });
            }
            _ => {}
        }
    }
    unreachable!("lines are endless")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix() -> RadianceMatrix {
        let values = (0..24).map(|k| f64::from(k) * 0.37 - 1.0).collect();
        RadianceMatrix { n_rows: 2, n_columns: 4, n_components: 3, values }
    }

    #[test]
    fn what_is_written_is_read() {
        for format in [Format::Ascii, Format::Double, Format::Float] {
            let read = RadianceMatrix::read(&matrix().write(format)).unwrap();
            assert_eq!((read.n_rows, read.n_columns, read.n_components), (2, 4, 3));
            for (a, b) in read.values.iter().zip(matrix().values) {
                assert!((a - b).abs() < if format == Format::Float { 1e-6 } else { 1e-300 });
            }
        }
    }

    #[test]
    fn faulty_files_are_refused() {
        let file = |header: &str, body: &str| RadianceMatrix::read(format!("{header}\n\n{body}").as_bytes());
        let good = "#?RADIANCE\nNROWS=1\nNCOLS=2\nNCOMP=1\nFORMAT=ascii";
        assert!(file(good, "1 2\n").is_ok());
        for (header, body, said) in [
            (good, "1 2 3", "3 values"),
            (good, "1", "1 values"),
            (good, "1 x", "value 1 is \"x\""),
            ("NROWS=1", "1", "expected #?RADIANCE"),
            ("#?RADIANCE\nNROWS=1\nFORMAT=ascii", "1", "no NCOLS"),
            ("#?RADIANCE\nNROWS=0", "1", "line 2"),
            ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe", "", "expected FORMAT="),
            ("#?RADIANCE\nNROWS=9999999999\nNCOLS=9999999999\nFORMAT=float", "", "expected"),
            ("#?RADIANCE\nNROWS=1\nNCOLS=1\nNCOMP=1\nFORMAT=float", "12345", "2 values"),
        ] {
            let message = file(header, body).unwrap_err().to_string();
            assert!(message.contains(said), "{message}");
        }
        assert_eq!(RadianceMatrix::read(b"#?RADIANCE\nNROWS=1"), Err(MatrixFileError::EndlessHeader));
    }
}
