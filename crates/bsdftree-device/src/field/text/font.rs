//! Font files: polygons of letters.
//!
//! In: text with, for each letter, its code (1 to 255), its number of vertices and their coordinates, whole numbers from
//! 0 to 255, y upwards; `#` begins a comment. Out: [`Font`]. A letter without vertices is a space. Where a polygon
//! covers a place an even number of times there is a hole. Source: Radiance's reference manual ("Font files").

use std::fmt;
use std::sync::Arc;

use crate::error::{DeviceError, Place};
use crate::field::File;

/// Most vertices of a letter, as in Radiance.
const MOST_VERTICES: usize = 32_000;
/// The middle of a letter, from which its extents are counted.
const MIDDLE: u8 = 128;

/// Letters by their codes.
#[derive(Clone)]
pub struct Font {
    /// Where it comes from.
    pub file: File,
    letters: Vec<Option<Letter>>,
    /// Mean width of letters that have one, in units of which a square has 255.
    pub(super) mean_width: i64,
}

/// A polygon, its last vertex joined to the first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Letter {
    vertices: Vec<[u8; 2]>,
    /// Least and greatest x, with the middle among them.
    pub x: [u8; 2],
    y: [u8; 2],
}

impl Font {
    /// Reads the text of a font file.
    ///
    /// # Errors
    /// [`DeviceError::Unexpected`] with the line, if it is not of the format.
    pub fn parse(text: &str, file: File) -> Result<Font, DeviceError> {
        let mut numbers = Numbers { words: words(text).peekable(), line: 1, path: file.path.clone() };
        let mut letters = vec![None; 256];
        while numbers.words.peek().is_some() {
            let code = numbers.next("the code of a letter, 1 to 255", 1..=255)?;
            if letters[code].is_some() {
                return Err(numbers.wrong("a code once", format!("{code} again")));
            }
            let n = numbers.next("how many vertices a letter has, up to 32000", 0..=MOST_VERTICES)?;
            let mut letter = Letter { vertices: Vec::new(), x: [MIDDLE; 2], y: [MIDDLE; 2] };
            for _ in 0..n {
                let mut vertex = [0; 2];
                for (coordinate, extent) in vertex.iter_mut().zip([&mut letter.x, &mut letter.y]) {
                    *coordinate = numbers.next("a coordinate of a vertex, 0 to 255", 0..=255)? as u8;
                    *extent = [extent[0].min(*coordinate), extent[1].max(*coordinate)];
                }
                letter.vertices.push(vertex);
            }
            letters[code] = Some(letter);
        }
        let extent = |[least, most]: [u8; 2]| i64::from(most) - i64::from(least);
        let widths: Vec<i64> = letters
            .iter()
            .flatten()
            .filter(|letter| extent(letter.x) > 0 && extent(letter.y) > 0)
            .map(|letter| extent(letter.x))
            .collect();
        let mean_width = widths.iter().sum::<i64>() / widths.len().max(1) as i64;
        Ok(Font { file, letters, mean_width })
    }

    pub(super) fn letter(&self, code: u8) -> Option<&Letter> {
        self.letters[usize::from(code)].as_ref()
    }
}

impl Letter {
    pub fn is_space(&self) -> bool {
        self.vertices.is_empty()
    }

    /// Whether a place is on it; x and y from the lower left corner of a square of 255.
    pub fn covers(&self, x: f64, y: f64) -> bool {
        let within = |at: f64, [least, most]: [u8; 2]| (f64::from(least)..f64::from(most)).contains(&at);
        if !within(x, self.x) || !within(y, self.y) {
            return false;
        }
        let ends = self.vertices.iter().zip(self.vertices.iter().cycle().skip(1));
        // How many sides lie to the right of the place, at its height.
        let crossed = ends.filter(|(a, b)| {
            let [[ax, ay], [bx, by]] = [a, b].map(|v| v.map(f64::from));
            (ay > y) != (by > y) && ax + (y - ay) / (by - ay) * (bx - ax) > x
        });
        crossed.count() % 2 == 1
    }
}

impl PartialEq for Font {
    fn eq(&self, other: &Font) -> bool {
        self.letters == other.letters
    }
}

impl fmt::Debug for Font {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Font({:016x})", self.file.digest)
    }
}

/// Words with their lines, without comments.
fn words(text: &str) -> impl Iterator<Item = (u32, &str)> {
    let lines = (1_u32..).zip(text.lines());
    lines.flat_map(|(line, text)| {
        let text = text.split_once('#').map_or(text, |(before, _)| before);
        text.split_ascii_whitespace().map(move |word| (line, word))
    })
}

struct Numbers<'a, I: Iterator<Item = (u32, &'a str)>> {
    words: std::iter::Peekable<I>,
    line: u32,
    path: Arc<str>,
}

impl<'a, I: Iterator<Item = (u32, &'a str)>> Numbers<'a, I> {
    fn next(&mut self, what: &str, range: std::ops::RangeInclusive<usize>) -> Result<usize, DeviceError> {
        let Some((line, word)) = self.words.next() else {
            return Err(self.wrong(what, "the end of the file".to_owned()));
        };
        self.line = line;
        match word.parse() {
            Ok(n) if range.contains(&n) => Ok(n),
            _ => Err(self.wrong(what, format!("'{}'", word.chars().take(40).collect::<String>()))),
        }
    }

    fn wrong(&self, expected: &str, found: String) -> DeviceError {
        DeviceError::Unexpected {
            at: Place { file: self.path.clone(), line: self.line },
            expected: expected.to_owned(),
            found,
            advice: "correct the font file: code n x0 y0 x1 y1 …".to_owned(),
        }
    }
}
