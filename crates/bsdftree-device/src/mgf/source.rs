//! MGF texts, cut into lines.
//!
//! In: a text or file. Out: a [`Source`], whose [`Line`]s each hold one entity: what has no words and what begins with
//! `#` is left out. A line that ends with a backslash goes on in the next one, comments too. Words are cut when a line is
//! walked, so that a text takes little more memory than itself.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::{DeviceError, Place};
use crate::rad;

/// A text, and where its includes are looked for.
pub(super) struct Source {
    /// For messages.
    pub name: Arc<str>,
    /// Includes are relative to it; `None` where nothing may be included.
    pub directory: Option<PathBuf>,
    text: String,
    pub lines: Vec<Line>,
}

/// Where an entity stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// Counted from 1.
    number: u32,
    start: usize,
    end: usize,
}

impl Source {
    pub(super) fn of(text: &str, name: &str, directory: Option<PathBuf>) -> Self {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text).replace("\r\n", "\n");
        Source { name: name.into(), directory, lines: lines(&text), text }
    }

    /// The text of a file.
    pub(super) fn open(path: &Path, named_at: Option<&Place>) -> Result<Self, DeviceError> {
        let directory = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Source::of(&rad::read_text(path, named_at)?, &path.display().to_string(), Some(directory)))
    }

    pub(super) fn place(&self, line: Line) -> Place {
        Place { file: self.name.clone(), line: line.number }
    }

    /// The words of a line; the first is the entity's keyword.
    pub(super) fn words(&self, line: Line) -> Vec<&str> {
        words(&self.text[line.start..line.end]).collect()
    }
}

/// As C's `isspace`.
fn is_white(c: char) -> bool {
    matches!(c, ' ' | '\t'..='\r')
}

fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split("\\\n").flat_map(|part| part.split(is_white)).filter(|word| !word.is_empty())
}

fn lines(text: &str) -> Vec<Line> {
    let mut lines = Vec::new();
    let (mut start, mut number) = (0, 1);
    let mut end = 0;
    for (index, piece) in text.split_inclusive('\n').enumerate() {
        end += piece.len();
        if piece.ends_with("\\\n") && end < text.len() {
            continue;
        }
        let first = words(&text[start..end]).next();
        if first.is_some_and(|word| !word.starts_with('#')) {
            lines.push(Line { number, start, end });
        }
        // Lines are counted as far as errors can name them.
        (start, number) = (end, u32::try_from(index + 2).unwrap_or(u32::MAX));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(text: &str) -> Vec<(u32, Vec<String>)> {
        let source = Source::of(text, "t", None);
        let words = |line| source.words(line).into_iter().map(str::to_owned).collect();
        source.lines.iter().map(|&line| (line.number, words(line))).collect()
    }

    #[test]
    fn backslashes_continue_lines_and_comments() {
        let text = "# a \\\n b c\n\n f a \\\n  b\\\r\nc\nsph \\x 1 \\";
        let expected = vec![
            (4, ["f", "a", "b", "c"].map(str::to_owned).to_vec()),
            (7, ["sph", "\\x", "1", "\\"].map(str::to_owned).to_vec()),
        ];
        assert_eq!(cut(text), expected);
    }

    #[test]
    fn the_last_line_needs_no_end() {
        assert_eq!(cut("o\no x"), vec![(1, vec!["o".to_owned()]), (2, vec!["o".to_owned(), "x".to_owned()])]);
        assert_eq!(cut("f a\\\n"), vec![(1, vec!["f".to_owned(), "a".to_owned()])]);
        assert!(cut("").is_empty() && cut(" \n\t\r\n#").is_empty());
    }
}
