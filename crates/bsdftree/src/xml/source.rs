//! From bytes to text: encoding, byte-order mark, and what stands before the markup.
//!
//! Offsets inside the reader count in this text; `place` turns them into bytes of the file and lines.

use std::borrow::Cow;

use super::error::{Fault, XmlError};
use super::repair::Repairs;

/// UTF-8's byte-order mark.
const MARK: &[u8] = b"\xEF\xBB\xBF";

/// The text of a file.
pub(super) struct Source<'a> {
    text: Cow<'a, str>,
    /// Bytes of the file before the text.
    skipped: usize,
    /// Where the markup begins.
    start: usize,
    /// The first byte that is not UTF-8, in a file that does not declare another encoding.
    undeclared: Option<usize>,
}

impl<'a> Source<'a> {
    /// The text of an XML file.
    pub(super) fn new(bytes: &'a [u8]) -> Result<Source<'a>, XmlError> {
        let mut source = Source::raw(bytes)?;
        let text = source.text.as_bytes();
        let begins = |i: &usize| {
            matches!(text.get(i + 1), Some(b'?' | b'!' | b'_'))
                || text.get(i + 1).is_some_and(u8::is_ascii_alphabetic)
        };
        source.start = memchr::memchr_iter(b'<', text)
            .find(begins)
            .ok_or_else(|| XmlError::new(0, Fault::NotText("no markup")))?;
        Ok(source)
    }

    /// A text that need not be XML.
    pub(super) fn raw(bytes: &'a [u8]) -> Result<Source<'a>, XmlError> {
        let refused = |offset, what| Err(XmlError::new(offset, Fault::NotText(what)));
        if bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF") {
            return refused(0, "UTF-16");
        }
        let skipped = if bytes.starts_with(MARK) { MARK.len() } else { 0 };
        let body = &bytes[skipped..];
        if body.trim_ascii().is_empty() {
            return Err(XmlError::new(0, Fault::Empty));
        }
        if let Some(zero) = memchr::memchr(0, body) {
            let utf16 = zero < 4 && body.len() > 3;
            return refused(zero + skipped, if utf16 { "UTF-16" } else { "a zero byte: binary data" });
        }
        let (text, undeclared) = match std::str::from_utf8(body) {
            Ok(text) => (Cow::Borrowed(text), None),
            Err(error) => {
                let latin1: String = body.iter().map(|&byte| char::from(byte)).collect();
                let valid =
                    body[..error.valid_up_to()].iter().map(|byte| 1 + usize::from(*byte >= 0x80)).sum();
                (Cow::Owned(latin1), (!declares_latin1(body)).then_some(valid))
            }
        };
        Ok(Source { text, skipped, start: 0, undeclared })
    }

    /// All of it, without a byte-order mark.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Where the markup begins.
    pub(super) fn start(&self) -> usize {
        self.start
    }

    /// Text before the markup, such as genBSDF's `Recover using:` line.
    pub(super) fn leading(&self) -> Option<&str> {
        Some(self.text[..self.start].trim()).filter(|leading| !leading.is_empty())
    }

    /// Reports bytes that are not in the encoding that the file is in.
    pub(super) fn check_encoding(&self, repairs: &mut Repairs) -> Result<(), XmlError> {
        match self.undeclared {
            None => Ok(()),
            Some(offset) => repairs.repair(
                offset,
                "bytes that are not UTF-8, the encoding of a file that declares no other",
                "the file taken as ISO-8859-1",
            ),
        }
    }

    /// Byte of the file and line of an offset in the text.
    pub(super) fn place(&self, offset: usize) -> (u64, u64) {
        self.places(&[offset])[0]
    }

    /// The same for many, in ascending order.
    pub(super) fn places(&self, offsets: &[usize]) -> Vec<(u64, u64)> {
        let text = self.text.as_bytes();
        let (mut from, mut bytes, mut line) = (0, self.skipped, 1);
        let place = |&offset: &usize| {
            let passed = &text[from..offset.clamp(from, text.len())];
            line += memchr::memchr_iter(b'\n', passed).count();
            // Text made from ISO-8859-1 has two bytes where the file has one.
            let is_file_byte = |byte: &&u8| matches!(self.text, Cow::Borrowed(_)) || **byte & 0xC0 != 0x80;
            bytes += passed.iter().filter(is_file_byte).count();
            from += passed.len();
            (bytes as u64, line as u64)
        };
        offsets.iter().map(place).collect()
    }
}

fn declares_latin1(bytes: &[u8]) -> bool {
    const FAR_ENOUGH: usize = 1000;
    let head = bytes[..bytes.len().min(FAR_ENOUGH)].to_ascii_lowercase();
    [&b"8859-1\""[..], b"8859-1'", b"windows-1252", b"latin1"]
        .iter()
        .any(|name| memchr::memmem::find(&head, name).is_some())
}
