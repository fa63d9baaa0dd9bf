//! Characters of a function file: white space and nested `{comments}` skipped, lines counted.
//!
//! As in Radiance, a name or a number ends at white space or at a comment; elsewhere both may stand anywhere.

use super::error::{CalError, CalProblem};
use crate::error::Place;
use std::sync::Arc;

/// Longest name, as in Radiance.
pub(super) const MAX_NAME: usize = 127;

/// A position in a text.
pub(super) struct Scanner<'a> {
    text: &'a str,
    at: usize,
    line: u32,
    file: Arc<str>,
}

impl<'a> Scanner<'a> {
    /// At the first character that counts; `place` is where the text begins.
    pub(super) fn new(text: &'a str, place: &Place) -> Result<Self, CalError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut scanner = Scanner { text, at: 0, line: place.line, file: place.file.clone() };
        scanner.skip()?;
        Ok(scanner)
    }

    /// The current line.
    pub(super) fn line(&self) -> u32 {
        self.line
    }

    /// The file that errors name.
    pub(super) fn file(&self) -> &Arc<str> {
        &self.file
    }

    /// The current place.
    pub(super) fn place(&self) -> Place {
        Place { file: self.file.clone(), line: self.line }
    }

    /// The next character that counts, `None` at the end.
    pub(super) fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    /// Steps over the character that [`Scanner::peek`] shows.
    pub(super) fn advance(&mut self) -> Result<(), CalError> {
        self.at += 1;
        self.skip()
    }

    /// Steps over `byte` if it is next.
    pub(super) fn take(&mut self, byte: u8) -> Result<bool, CalError> {
        let is_next = self.peek() == Some(byte);
        if is_next {
            self.advance()?;
        }
        Ok(is_next)
    }

    /// Whether a name begins here.
    pub(super) fn at_name(&self) -> bool {
        self.peek().is_some_and(|b| b.is_ascii_alphabetic() || b == b'`')
    }

    /// The name that begins here.
    pub(super) fn name(&mut self) -> Result<&'a str, CalError> {
        let name = self.run(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'.' | b'`'));
        if name.len() > MAX_NAME {
            return Err(self.too_large("characters in a name", MAX_NAME, "shorten the name"));
        }
        self.at += name.len();
        self.skip()?;
        Ok(name)
    }

    /// The decimal digits that begin here; may be none.
    pub(super) fn digits(&mut self) -> Result<&'a str, CalError> {
        let digits = self.run(|b| b.is_ascii_digit());
        self.at += digits.len();
        self.skip()?;
        Ok(digits)
    }

    /// The number that begins here with a digit or a point.
    pub(super) fn number(&mut self) -> Result<f64, CalError> {
        let start = self.at;
        let whole = self.digit_run();
        let fraction = if self.peek() == Some(b'.') {
            self.at += 1;
            self.digit_run()
        } else {
            0
        };
        if whole + fraction == 0 {
            return Err(self.unexpected("a digit after the decimal point", "write 0 for zero"));
        }
        if matches!(self.peek(), Some(b'e' | b'E')) {
            self.at += 1;
            if matches!(self.peek(), Some(b'+' | b'-')) {
                self.at += 1;
            }
            if self.digit_run() == 0 {
                return Err(self.unexpected("digits of an exponent", "write them, or leave out the e"));
            }
        }
        let digits = &self.text[start..self.at];
        let value: f64 = digits.parse().unwrap_or(f64::INFINITY);
        if !value.is_finite() {
            return Err(self.error(CalProblem::Unexpected {
                expected: "a number below 1.8e308".into(),
                found: shortened(digits),
                advice: "write a smaller number".into(),
            }));
        }
        self.skip()?;
        Ok(value)
    }

    /// The error that something else was expected here.
    pub(super) fn unexpected(&self, expected: impl Into<String>, advice: impl Into<String>) -> CalError {
        self.error(CalProblem::Unexpected {
            expected: expected.into(),
            found: self.found(),
            advice: advice.into(),
        })
    }

    /// The error that a limit was passed here.
    pub(super) fn too_large(&self, what: &'static str, limit: usize, advice: &'static str) -> CalError {
        self.error(CalProblem::TooLarge { what, limit, advice })
    }

    /// This problem here.
    pub(super) fn error(&self, problem: CalProblem) -> CalError {
        CalError::new(&self.place(), problem)
    }

    /// What stands here, in words: the rest of the word, at most 40 characters of it.
    fn found(&self) -> String {
        // A number may have been left in the middle of its characters, all of one byte.
        let rest = self.text.get(self.at..).unwrap_or("");
        let Some(first) = rest.chars().next() else { return "the end of the text".into() };
        let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '`');
        let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len()).max(first.len_utf8());
        shortened(&rest[..end])
    }

    fn run(&self, belongs: impl Fn(u8) -> bool) -> &'a str {
        let rest = &self.text[self.at..];
        &rest[..rest.bytes().position(|b| !belongs(b)).unwrap_or(rest.len())]
    }

    fn digit_run(&mut self) -> usize {
        let n = self.run(|b| b.is_ascii_digit()).len();
        self.at += n;
        n
    }

    fn skip(&mut self) -> Result<(), CalError> {
        while let Some(byte) = self.peek() {
            match byte {
                b'\n' => self.line += 1,
                b' ' | b'\t' | b'\r' | 0x0b | 0x0c => {}
                b'{' => {
                    self.skip_comment()?;
                    continue;
                }
                _ => break,
            }
            self.at += 1;
        }
        Ok(())
    }

    fn skip_comment(&mut self) -> Result<(), CalError> {
        let opened = self.place();
        let mut depth = 0usize;
        while let Some(byte) = self.peek() {
            self.at += 1;
            match byte {
                b'\n' => self.line += 1,
                b'{' => depth += 1,
                b'}' => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return Ok(());
            }
        }
        Err(CalError::new(
            &opened,
            CalProblem::Unexpected {
                expected: "'}' that ends this comment".into(),
                found: "the end of the text".into(),
                advice: "comments nest: close each '{' by its '}'".into(),
            },
        ))
    }
}

fn shortened(text: &str) -> String {
    let mut shown: String = text.chars().take(40).collect();
    if shown.len() < text.len() {
        shown.push('…');
    }
    format!("'{}'", shown.escape_debug())
}
