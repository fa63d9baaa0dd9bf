//! Numbers and what separates them, inside the values of a tree or a matrix.
//!
//! Straight to `f32`: what overflows it is an error, as are NaN and infinity; what underflows it is 0. Numbers are separated
//! by white space, one comma, or both.

use super::error::{Fault, XmlError, excerpt};
use super::plain;
use super::repair::Repairs;

/// A place in the text of the values.
pub(super) struct Cursor<'a> {
    text: &'a [u8],
    at: usize,
    /// Where the text stands in the file.
    base: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(text: &'a [u8], base: usize) -> Cursor<'a> {
        Cursor { text, at: 0, base }
    }

    /// Place in the file.
    pub(super) fn offset(&self) -> usize {
        self.base + self.at
    }

    /// The next byte, white space skipped.
    #[inline]
    pub(super) fn peek(&mut self) -> Option<u8> {
        loop {
            let byte = *self.text.get(self.at)?;
            if !is_space(byte) {
                return Some(byte);
            }
            self.at += 1;
        }
    }

    /// Skips the byte just seen.
    #[inline]
    pub(super) fn skip(&mut self) {
        self.at += 1;
    }

    /// Skips white space and at most one comma.
    #[inline]
    pub(super) fn separator(&mut self) {
        if self.peek() == Some(b',') {
            self.skip();
        }
    }

    /// What comes next, for a message.
    pub(super) fn found(&mut self) -> String {
        match self.peek() {
            None => "the end of the data".into(),
            Some(_) => format!("`{}`", excerpt(self.token())),
        }
    }

    fn token(&self) -> &'a [u8] {
        let rest = &self.text[self.at..];
        let end = rest.iter().position(|&b| is_space(b) || b == b',' || is_brace(b)).unwrap_or(rest.len());
        &rest[..end.max(1).min(rest.len())]
    }

    /// Appends the numbers here up to one that takes more care to read, or to something else; separators are skipped.
    pub(super) fn plain_numbers(&mut self, values: &mut Vec<f32>) {
        loop {
            let before = values.len();
            self.at += plain::read(&self.text[self.at..], values);
            if values.len() == before {
                return;
            }
            self.separator();
            self.peek();
        }
    }

    /// The number here, whatever it takes to read it, and its separator skipped.
    pub(super) fn number(&mut self, negatives: &mut Negatives) -> Result<f32, XmlError> {
        let parsed = fast_float2::parse_partial::<f32, _>(&self.text[self.at..]);
        let (value, length) = parsed.map_err(|_| self.bad_number("it is not one"))?;
        let ends = |&next: &u8| is_space(next) || next == b',' || is_brace(next);
        if !self.text.get(self.at + length).is_none_or(ends) {
            return Err(self.bad_number("something follows the digits"));
        }
        if !value.is_finite() {
            let digits = self.token().iter().any(u8::is_ascii_digit);
            return Err(self.bad_number(if digits {
                "it is over the largest value, 3.4e38"
            } else {
                "a BSDF is finite"
            }));
        }
        let value = if value < 0.0 { negatives.add(self.offset()) } else { value };
        self.at += length;
        self.separator();
        // Negative zero becomes zero.
        Ok(value + 0.0)
    }

    fn bad_number(&self, problem: &'static str) -> XmlError {
        XmlError::new(self.offset(), Fault::BadNumber { found: excerpt(self.token()), problem })
    }
}

/// Negative values met so far.
#[derive(Default)]
pub(super) struct Negatives {
    count: usize,
    first: usize,
}

impl Negatives {
    #[cold]
    fn add(&mut self, offset: usize) -> f32 {
        if self.count == 0 {
            self.first = offset;
        }
        self.count += 1;
        0.0
    }

    /// Reports them, if there are any. Radiance, too, reads them as 0.
    pub(super) fn reported(&self, repairs: &mut Repairs) -> Result<(), XmlError> {
        match self.count {
            0 => Ok(()),
            1 => repairs.repair(self.first, "1 negative value", "it taken as 0"),
            n => repairs.repair(self.first, format!("{n} negative values from here on"), "them taken as 0"),
        }
    }
}

#[inline(always)]
pub(super) fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | 0x0B | 0x0C)
}

#[inline(always)]
pub(super) fn is_brace(byte: u8) -> bool {
    matches!(byte, b'{' | b'}')
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// What the cursor reads, and where it stands then; nothing if it refuses.
    fn read(text: &str) -> Option<(u32, usize)> {
        let mut cursor = Cursor::new(text.as_bytes(), 0);
        let value = cursor.number(&mut Negatives::default()).ok()?;
        Some((value.to_bits(), cursor.at))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn plain_numbers_are_read_as_carefully_as_others(
            bits in 0u32..0x7F80_0000, digits in 0usize..12, style in 0..4, end in 0usize..4,
        ) {
            let value = f32::from_bits(bits);
            let text = match style {
                0 => format!("{value}"),
                1 => format!("{value:e}"),
                2 => format!("{value:.digits$e}"),
                _ => format!("{:.digits$}", value % 1e6),
            };
            let after = [" ", "}", ",  ", "\n"][end];
            let padded = format!("{text}{after}1 2 3 4 5 6 7 8 9 10 11 12");
            let careful = text.parse::<f32>().unwrap();
            let read = read(&padded);
            if careful.is_finite() {
                prop_assert_eq!(read.map(|(bits, _)| bits), Some(careful.to_bits()), "{}", text);
            } else {
                prop_assert_eq!(read, None);
            }
        }
    }

    #[test]
    fn a_tie_of_two_steps_of_rounding_is_read_right() {
        // 1 + 2⁻²⁴ lies between two f32; a little more must round up.
        for text in ["1.00000005960464", "1.0000000596046448", "1.00000005960465"] {
            let read = read(&format!("{text}{}", " 0".repeat(20))).unwrap().0;
            assert_eq!(read, text.parse::<f32>().unwrap().to_bits(), "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in [
            "", ".", "e5", "1e", "1e+", "1..2", "1.2.3", "12x", "0x10", "1e5.5", "nan", "inf", "1e39", "--1",
            "1_0",
        ] {
            assert_eq!(read(&format!("{text}{}", " 0".repeat(20))), None, "{text:?}");
        }
    }
}
