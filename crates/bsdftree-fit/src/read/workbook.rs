//! Numbers and texts of Excel 97 workbooks (`.xls`), as instruments export them.
//!
//! In: bytes of a compound file with a stream `Workbook` of BIFF8 records. Out: sheets as sparse tables of cells. Memory is bounded by
//! the file's size, whatever rows and columns it names. Formulas, dates and formats are left out; a text that goes over the end of its
//! record is, too, with all texts after it.
//!
//! Source: Microsoft, "[MS-XLS]: Excel Binary File Format Structure", records NUMBER, RK, MULRK, LABELSST, LABEL, SST, BOUNDSHEET.
//! Deviation: none of the crates for workbooks that were tried survives damaged files (panics; memory by the largest cell named).

use std::collections::HashMap;
use std::io::{Cursor, Read};

use super::error::ReadError;

/// What a cell holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    Text(String),
}

/// A sheet.
#[derive(Debug, Default)]
pub(super) struct Sheet {
    pub(super) name: String,
    /// By row and column, from 0. Empty cells are absent.
    pub(super) cells: HashMap<(usize, usize), Cell>,
    /// One more than the last column.
    pub(super) n_columns: usize,
}

/// Whether a file may be a workbook.
pub(super) fn recognizes(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1")
}

/// All sheets.
///
/// # Errors
/// If the file is no compound file or has no workbook in it.
pub(super) fn sheets(bytes: &[u8]) -> Result<Vec<Sheet>, ReadError> {
    let unreadable = |why: String| {
        ReadError::file(format!("no workbook ({why})"), "a sound .xls file of Excel 97 or later")
    };
    let mut file =
        cfb::CompoundFile::open(Cursor::new(bytes)).map_err(|error| unreadable(error.to_string()))?;
    let mut stream = Vec::new();
    file.open_stream("/Workbook")
        .and_then(|opened| opened.take(bytes.len() as u64).read_to_end(&mut stream))
        .map_err(|error| unreadable(error.to_string()))?;
    Ok(sheets_of_stream(&stream))
}

const BOF: u16 = 0x809;
const EOF: u16 = 0x0A;
const BOUNDSHEET: u16 = 0x85;
const SST: u16 = 0xFC;
const NUMBER: u16 = 0x203;
const LABEL: u16 = 0x204;
const RK: u16 = 0x27E;
const MULRK: u16 = 0xBD;
const LABELSST: u16 = 0xFD;

fn sheets_of_stream(stream: &[u8]) -> Vec<Sheet> {
    let mut names = Vec::new();
    let mut texts = Vec::new();
    let mut sheets: Vec<Sheet> = Vec::new();
    // The first part of the stream is about the workbook, each further one about a sheet.
    let mut is_in_sheet = false;
    let mut n_parts = 0;
    let mut rest = stream;
    while let Some((kind, data, after)) = record(rest) {
        rest = after;
        match kind {
            BOF => {
                is_in_sheet = n_parts > 0;
                if is_in_sheet {
                    let name = names.get(n_parts - 1).cloned().unwrap_or_else(|| format!("sheet {n_parts}"));
                    sheets.push(Sheet { name, ..Sheet::default() });
                }
                n_parts += 1;
            }
            EOF => is_in_sheet = false,
            BOUNDSHEET => names.extend(sheet_name(data)),
            SST => texts = shared_texts(data),
            _ => {
                if let (true, Some(sheet)) = (is_in_sheet, sheets.last_mut()) {
                    sheet.add(kind, data, &texts);
                }
            }
        }
    }
    sheets
}

/// Kind and data of the first record, and what follows it.
fn record(bytes: &[u8]) -> Option<(u16, &[u8], &[u8])> {
    let (kind, length) = (u16_at(bytes, 0)?, usize::from(u16_at(bytes, 2)?));
    let data = bytes.get(4..4 + length)?;
    Some((kind, data, &bytes[4 + length..]))
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn sheet_name(data: &[u8]) -> Option<String> {
    let n = usize::from(*data.get(6)?);
    Some(characters(data.get(8..)?, n, data.get(7)? & 1 == 1)?.0)
}

/// So many characters, of one byte or of two, and the bytes that they take.
fn characters(bytes: &[u8], n: usize, is_wide: bool) -> Option<(String, usize)> {
    if !is_wide {
        return Some((bytes.get(..n)?.iter().map(|&byte| char::from(byte)).collect(), n));
    }
    let units: Vec<u16> =
        bytes.get(..2 * n)?.as_chunks::<2>().0.iter().map(|&pair| u16::from_le_bytes(pair)).collect();
    Some((String::from_utf16_lossy(&units), 2 * n))
}

/// A text with its length and flags before it, and the bytes that it takes.
fn text(bytes: &[u8]) -> Option<(String, usize)> {
    let n = usize::from(u16_at(bytes, 0)?);
    let flags = *bytes.get(2)?;
    let (mut head, mut tail) = (3, 0);
    if flags & 8 != 0 {
        tail += 4 * usize::from(u16_at(bytes, head)?);
        head += 2;
    }
    if flags & 4 != 0 {
        tail += u32_at(bytes, head)? as usize;
        head += 4;
    }
    let (text, taken) = characters(bytes.get(head..)?, n, flags & 1 == 1)?;
    Some((text, head + taken + tail))
}

fn shared_texts(data: &[u8]) -> Vec<String> {
    let mut rest = data.get(8..).unwrap_or_default();
    std::iter::from_fn(|| {
        let (found, taken) = text(rest)?;
        rest = rest.get(taken..)?;
        Some(found)
    })
    .collect()
}

/// A number packed into 30 bits, and whether it is an integer, in hundredths.
fn unpacked(rk: u32) -> f64 {
    let number = match rk & 2 != 0 {
        true => f64::from(rk.cast_signed() >> 2),
        false => f64::from_bits(u64::from(rk & !3) << 32),
    };
    if rk & 1 != 0 { number / 100.0 } else { number }
}

impl Sheet {
    /// The cells of a record, if it has any.
    fn add(&mut self, kind: u16, data: &[u8], texts: &[String]) -> Option<()> {
        let (row, column) = (usize::from(u16_at(data, 0)?), usize::from(u16_at(data, 2)?));
        match kind {
            NUMBER => {
                let bits = data.get(6..14)?.try_into().ok()?;
                self.put(row, column, Cell::Number(f64::from_le_bytes(bits)));
            }
            RK => self.put(row, column, Cell::Number(unpacked(u32_at(data, 6)?))),
            MULRK => {
                let n = data.len().checked_sub(6)? / 6;
                for k in 0..n {
                    self.put(row, column + k, Cell::Number(unpacked(u32_at(data, 6 + 6 * k)?)));
                }
            }
            LABELSST => {
                let text = texts.get(u32_at(data, 6)? as usize)?;
                self.put(row, column, Cell::Text(text.clone()));
            }
            LABEL => self.put(row, column, Cell::Text(text(data.get(6..)?)?.0)),
            _ => {}
        }
        Some(())
    }

    fn put(&mut self, row: usize, column: usize, cell: Cell) {
        self.n_columns = self.n_columns.max(column + 1);
        self.cells.insert((row, column), cell);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes_of(kind: u16, data: &[u8]) -> Vec<u8> {
        [&kind.to_le_bytes()[..], &(data.len() as u16).to_le_bytes(), data].concat()
    }

    #[test]
    fn packed_numbers_are_unpacked() {
        let float = |number: f64, flags: u32| (number.to_bits() >> 32) as u32 & !3 | flags;
        let rks = [
            (float(1.5, 0), 1.5),
            (float(150.0, 1), 1.5),
            (7 << 2 | 2, 7.0),
            ((-7i32 << 2) as u32 | 3, -0.07),
        ];
        for (rk, number) in rks {
            assert_eq!(unpacked(rk), number);
        }
    }

    #[test]
    fn cells_are_where_records_put_them() {
        let text = |text: &str| [&(text.len() as u16).to_le_bytes()[..], &[0], text.as_bytes()].concat();
        let cell = |row: u8, column: u8, data: &[u8]| [&[row, 0, column, 0, 0, 0], data].concat();
        let two = [[0; 2].as_slice(), &(14u32 << 1 | 2).to_le_bytes()].concat();
        let stream = [
            bytes_of(BOF, &[]),
            bytes_of(BOUNDSHEET, &[0, 0, 0, 0, 0, 0, 2, 0, b'S', b'1']),
            bytes_of(SST, &[&[0; 8][..], &text("a"), &text("RT")].concat()),
            bytes_of(EOF, &[]),
            bytes_of(BOF, &[]),
            bytes_of(LABELSST, &cell(3, 0, &[1, 0, 0, 0])),
            bytes_of(NUMBER, &cell(3, 1, &0.25f64.to_le_bytes())),
            bytes_of(MULRK, &[&[4, 0, 2, 0][..], &two, &two, &[3, 0]].concat()),
            bytes_of(EOF, &[]),
        ]
        .concat();
        let sheets = sheets_of_stream(&stream);
        assert_eq!((sheets.len(), sheets[0].name.as_str(), sheets[0].n_columns), (1, "S1", 4));
        let cells = &sheets[0].cells;
        assert_eq!((&cells[&(3, 0)], &cells[&(3, 1)]), (&Cell::Text("RT".into()), &Cell::Number(0.25)));
        assert_eq!((&cells[&(4, 2)], &cells[&(4, 3)]), (&Cell::Number(7.0), &Cell::Number(7.0)));
    }
}
