//! Numbers and what separates them, inside the values of a tree or a matrix.
//!
//! Straight to `f32`: what overflows it is an error, as are NaN and infinity; what underflows it is 0. Numbers are separated
//! by white space, one comma, or both.

use super::error::{Fault, XmlError, excerpt};
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

    /// The number here, and its separator skipped.
    #[inline]
    pub(super) fn number(&mut self, negatives: &mut Negatives) -> Result<f32, XmlError> {
        if let Some((value, length)) = plain(&self.text[self.at..]) {
            self.at += length;
            self.separator();
            return Ok(value);
        }
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

/// A number without a sign, with few digits and in the middle of its text, as nearly all are, and its length; `None` if it takes more
/// care to read.
///
/// Digits are taken eight at once (D. Lemire, "Number parsing at a gigabyte per second", Software: Practice and Experience
/// 51, 2021). With up to 15 digits and powers up to 10²² the `f64` is correctly rounded (W. Clinger, "How to read floating point
/// numbers accurately", 1990), and so is the `f32` made of it unless it lies exactly between two.
#[inline(always)]
fn plain(text: &[u8]) -> Option<(f32, usize)> {
    const POWERS: [f64; 23] = {
        // Exact: 5²² is below 2⁵³.
        let mut powers = [1.0; 23];
        let mut k = 1;
        while k < 23 {
            powers[k] = powers[k - 1] * 10.0;
            k += 1;
        }
        powers
    };
    let (mut mantissa, mut at) = digits(text, 0)?;
    let whole = at;
    let mut n_digits = whole;
    if *text.get(at)? == b'.' {
        let (fraction, n) = digits(text, at + 1)?;
        if n == 0 {
            return None;
        }
        if n == 8 {
            let (rest, more) = digits(text, at + 9)?;
            mantissa = (mantissa * 100_000_000 + fraction) * TENS[more] + rest;
            n_digits += 8 + more;
            if more == 8 {
                return None;
            }
        } else {
            mantissa = mantissa * TENS[n] + fraction;
            n_digits += n;
        }
        at += 1 + n_digits - whole;
    }
    if whole == 8 || n_digits == 0 || n_digits > 15 {
        return None;
    }
    let mut power = whole as i32 - n_digits as i32;
    let mut end = *text.get(at)?;
    if end | 0x20 == b'e' {
        let sign = *text.get(at + 1)?;
        let signed = usize::from(sign == b'-' || sign == b'+');
        let (exponent, n) = digits(text, at + 1 + signed)?;
        if n == 0 || n > 3 {
            return None;
        }
        power += if sign == b'-' { -(exponent as i32) } else { exponent as i32 };
        at += 1 + signed + n;
        end = *text.get(at)?;
    }
    if !(is_space(end) || end == b',' || is_brace(end)) || power.unsigned_abs() > 22 {
        return None;
    }
    let scale = POWERS[power.unsigned_abs() as usize];
    let value = if power < 0 { mantissa as f64 / scale } else { mantissa as f64 * scale };
    let is_between = value.to_bits() & 0x1FFF_FFFF == 0x1000_0000;
    let is_normal = (1.2e-38..3.4e38).contains(&value) || mantissa == 0;
    (is_normal && !is_between).then_some((value as f32, at))
}

const TENS: [u64; 9] = [1, 10, 100, 1000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// The number of up to eight digits at a place, and how many they are; `None` near the end of the text.
#[inline(always)]
fn digits(text: &[u8], at: usize) -> Option<(u64, usize)> {
    const ONES: u64 = 0x0101_0101_0101_0101;
    let bytes = u64::from_le_bytes(*text.get(at..)?.first_chunk::<8>()?);
    let values = bytes ^ (ONES * 0x30);
    // The top bit of each byte that is no digit.
    let others = (values | values.wrapping_add(ONES * 0x76)) & (ONES * 0x80);
    let n = others.trailing_zeros() as usize / 8;
    if n == 0 {
        return Some((0, 0));
    }
    // The last digit into the highest byte, zeros below the first.
    let values = values << (64 - 8 * n);
    // Pairs, fours, eight.
    let pairs = values.wrapping_mul(10) + (values >> 8);
    let pairs = pairs & 0x00FF_00FF_00FF_00FF;
    let fours = pairs.wrapping_mul(100) + (pairs >> 16);
    let fours = fours & 0x0000_FFFF_0000_FFFF;
    let eight = fours.wrapping_mul(10_000) + (fours >> 32);
    Some((eight & 0xFFFF_FFFF, n))
}

#[inline]
fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | 0x0B | 0x0C)
}

#[inline]
fn is_brace(byte: u8) -> bool {
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
