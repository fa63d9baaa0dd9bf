//! Text on a surface: which places are on a letter.
//!
//! In: a font, lines of text, the upper left corner, and the vectors by which one goes a letter to the right and a line
//! down. Out: whether a place, seen along what is perpendicular to both vectors, is on a letter. Letters are bytes, not
//! characters, since fonts have 255 codes. Source: Radiance's reference manual ("Colortext", "Brighttext", "Mixtext").
//! Deviation: lines may have [`Text::MOST_LETTERS`] letters and are refused beyond; Radiance breaks those of files there.

mod font;
mod line;

use std::sync::Arc;

use glam::DVec3;

use super::space::File;
pub use font::Font;
use line::Line;

/// Where the letters come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Words {
    /// Words of the scene, as one line.
    Line(String),
    /// All lines of a file.
    File(File),
}

/// Text on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    /// Polygons of letters.
    pub font: Arc<Font>,
    /// Where the letters come from.
    pub words: Words,
    /// Upper left corner of the first line.
    pub anchor: DVec3,
    /// From a letter to the next.
    pub right: DVec3,
    /// From a line to the next.
    pub down: DVec3,
    /// Between letters, in parts of their squares: 0 or `None` for squares side by side; above 0 letters are spaced by their
    /// widths but aligned, below 0 by their widths alone.
    pub spacing: Option<f64>,
    /// The inverse of `right` and `down`.
    dual: [DVec3; 2],
    lines: Vec<Line>,
}

impl Text {
    /// Most letters of a line.
    pub const MOST_LETTERS: usize = 511;
    /// Units of a letter's square.
    const SQUARE: f64 = 255.0;

    /// Lays out text, of which `bytes` are the lines; `Err` says what was expected and what was found.
    ///
    /// # Errors
    /// Vectors along one line, or of no length; a line that is too long.
    pub fn new(
        font: Arc<Font>,
        words: Words,
        bytes: &[u8],
        [anchor, right, down]: [DVec3; 3],
        spacing: Option<f64>,
    ) -> Result<Text, (String, String)> {
        let normal = down.cross(right);
        let square = normal.length_squared();
        if !(square.is_normal() && normal.is_finite()) {
            let expected = "motion vectors to the right and down that span a plane";
            return Err((expected.to_owned(), format!("{right} and {down}")));
        }
        let dual = [normal.cross(down) / square, right.cross(normal) / square];
        let gap = (spacing.unwrap_or(0.0) * Self::SQUARE).clamp(-32767.0, 32767.0) as i64;
        let bytes = bytes.strip_suffix(b"\n").unwrap_or(bytes);
        let mut lines = Vec::new();
        for (k, codes) in bytes.split(|&byte| byte == b'\n').enumerate() {
            if codes.len() > Self::MOST_LETTERS {
                let expected = format!("at most {} letters in a line of text", Self::MOST_LETTERS);
                return Err((expected, format!("{} in line {}", codes.len(), k + 1)));
            }
            lines.push(Line::new(codes, &font, gap));
        }
        Ok(Text { font, words, anchor, right, down, spacing, dual, lines })
    }

    /// Whether a place is on a letter.
    pub fn covers(&self, position: DVec3) -> bool {
        let [x, y] = self.dual.map(|axis| axis.dot(position - self.anchor));
        if !(x >= 0.0 && y >= 0.0) {
            return false;
        }
        let Some(line) = self.lines.get(y as usize) else { return false };
        let units = match self.spacing {
            Some(spacing) => self.font.mean_width as f64 + Self::SQUARE * spacing.abs(),
            None => Self::SQUARE,
        };
        let (x, height) = (x * units, (1.0 - y.fract()) * Self::SQUARE);
        if x.floor() >= line.width as f64 {
            return false;
        }
        let before = line.starts.iter().map(|&start| x - start as f64).zip(&line.codes);
        before
            .take_while(|(x, _)| *x >= 0.0)
            .filter(|(x, _)| *x < Self::SQUARE)
            .any(|(x, &code)| self.font.letter(code).is_some_and(|letter| letter.covers(x, height)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 'A' is a square with a hole, 'i' a bar, ' ' a space.
    const FONT: &str = "# a font\n65 10  40 0 220 0 220 240 40 240 40 0  100 60 100 180 160 180 160 60 100 60\n\
        105 4 110 0 140 0 140 200 110 200 # i\n32 0\n";

    fn file() -> File {
        File { path: "f.fnt".into(), digest: 0 }
    }

    fn text(lines: &str, spacing: Option<f64>) -> Text {
        let font = Arc::new(Font::parse(FONT, file()).unwrap());
        let vectors = [DVec3::new(1.0, 2.0, 0.0), DVec3::X, DVec3::NEG_Y];
        Text::new(font, Words::Line(lines.to_owned()), lines.as_bytes(), vectors, spacing).unwrap()
    }

    #[test]
    fn letters_lie_right_of_and_below_the_anchor() {
        let t = text("Ai\n i", None);
        // In units of a square: x from the left, y from above; z does not matter.
        let covers = |x: f64, y: f64| t.covers(DVec3::new(1.0 + x, 2.0 - y, 7.0));
        assert!(covers(0.2, 0.5) && !covers(0.5, 0.5) && covers(0.5, 0.9) && !covers(0.1, 0.5));
        assert!(covers(1.5, 0.5) && !covers(1.7, 0.5) && !covers(1.5, 0.1));
        assert!(!covers(0.5, 1.5) && covers(1.5, 1.5) && !covers(1.5, 2.5));
        assert!(!covers(-0.5, 0.5) && !covers(0.2, -0.1));
    }

    #[test]
    fn narrow_letters_move_together() {
        let n_covered = |t: &Text| {
            (0..4000).filter(|k| t.covers(DVec3::new(1.0 + 0.001 * f64::from(*k), 1.5, 0.0))).count()
        };
        let [wide, narrow] = [None, Some(-0.1)].map(|spacing| text("iiii", spacing));
        // Four bars of 30, in squares of 255 and in mean widths and gaps of (180 + 30) / 2 + 25.5.
        assert!(n_covered(&wide).abs_diff(471) < 3 && n_covered(&narrow).abs_diff(920) < 3);
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (font, expected) in [
            ("65 1 0 256", "f.fnt:1: expected a coordinate of a vertex, 0 to 255, found '256'"),
            ("65 0\n65 0", "f.fnt:2: expected a code once, found 65 again"),
            ("65\n2 1 1 3", "found the end of the file"),
            ("0 0", "the code of a letter, 1 to 255, found '0'"),
            ("A 0", "found 'A'"),
        ] {
            let found = Font::parse(font, file()).unwrap_err().to_string();
            assert!(found.contains(expected), "{found}");
        }
        let font = Arc::new(Font::parse(FONT, file()).unwrap());
        let words = Words::Line(String::new());
        let flat = [DVec3::ZERO, DVec3::X, DVec3::NEG_X];
        assert!(
            Text::new(font.clone(), words.clone(), b"", flat, None).unwrap_err().0.contains("span a plane")
        );
        let vectors = [DVec3::ZERO, DVec3::X, DVec3::NEG_Y];
        let (_, found) = Text::new(font, words, &[b'i'; 600], vectors, None).unwrap_err();
        assert_eq!(found, "600 in line 1");
    }
}
