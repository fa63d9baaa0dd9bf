//! Plain numbers, as nearly all are: without a sign, with few digits and in the middle of their text.
//!
//! Sixteen bytes are taken at once, and the point out of them, so that nothing but the end of a number decides where the next one
//! begins (after D. Lemire, "Number parsing at a gigabyte per second", Software: Practice and Experience 51, 2021, where it is eight).
//! With up to 15 digits and powers up to 10²² the `f64` is correctly rounded (W. Clinger, "How to read floating point
//! numbers accurately", 1990), and so is the `f32` made of it unless it lies exactly between two. Whatever takes more care to read is
//! left to others.

use super::number::{is_brace, is_space};

/// Appends the plain numbers at the beginning of a text, and gives back how long they are with what separates them.
pub(super) fn read(text: &[u8], values: &mut Vec<f32>) -> usize {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("sse4.1") {
        // SAFETY: the processor has SSE4.1, and with it SSSE3.
        return unsafe { sse::read(text, values) };
    }
    numbers(text, values, portable)
}

#[inline(always)]
fn numbers(text: &[u8], values: &mut Vec<f32>, number: impl Fn(&[u8; 16]) -> (u64, usize, usize)) -> usize {
    let mut at = 0;
    loop {
        let Some(rest) = text.get(at..) else { return at };
        let length = match rest {
            // Many are 0.
            [digit @ b'0'..=b'9', b' ', ..] => {
                values.push(f32::from(digit - b'0'));
                1
            }
            _ => {
                let Some((value, length)) =
                    rest.first_chunk().and_then(|bytes| finished(number(bytes), rest))
                else {
                    return at;
                };
                values.push(value);
                length
            }
        };
        at += length;
        // One space is what separates nearly all.
        match text.get(at) {
            Some(b' ') => at += 1,
            _ => return at,
        }
    }
}

/// The number of up to fifteen digits with a point among them or without: its digits, how many they are before the point, and its
/// length. All are meaningless if there are no digits at the beginning; the length is 16 if it is longer.
#[inline(always)]
fn portable(bytes: &[u8; 16]) -> (u64, usize, usize) {
    const LOW_BITS: u128 = u128::from_ne_bytes([1; 16]);
    let values = u128::from_le_bytes(*bytes) ^ (LOW_BITS * 0x30);
    // The top bit of each byte that is no digit, up to one that is not ASCII.
    let others = (values | values.wrapping_add(LOW_BITS * 0x76)) & (LOW_BITS * 0x80);
    let whole = others.trailing_zeros() / 8;
    let has_point = bytes.get(whole as usize) == Some(&b'.');
    let ends = if has_point { others & (others - 1) } else { others };
    let end = ends.trailing_zeros() / 8;
    let n_digits = end - u32::from(has_point);
    // The point taken out, the last digit into the highest byte, zeros below the first.
    let before = (1u128.checked_shl(8 * whole).unwrap_or(0)).wrapping_sub(1);
    let digits = values & before | (values >> (8 * u32::from(has_point))) & !before;
    let digits = digits.checked_shl(128 - 8 * n_digits).unwrap_or(0);
    let mantissa = eight_digits(digits as u64) * 100_000_000 + eight_digits((digits >> 64) as u64);
    (mantissa, whole as usize, end as usize)
}

/// The number of eight digits, each a byte from 0 to 9, the first one in the lowest.
#[inline(always)]
fn eight_digits(values: u64) -> u64 {
    // Pairs, fours, eight.
    let pairs = (values.wrapping_mul(10) + (values >> 8)) & 0x00FF_00FF_00FF_00FF;
    let fours = (pairs.wrapping_mul(100) + (pairs >> 16)) & 0x0000_FFFF_0000_FFFF;
    (fours.wrapping_mul(10_000) + (fours >> 32)) & 0xFFFF_FFFF
}

/// The number that begins with these digits, and its length; `None` if it is not plain.
#[inline(always)]
fn finished((mantissa, whole, end): (u64, usize, usize), text: &[u8]) -> Option<(f32, usize)> {
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
    // There are digits, and after a point too.
    if end == 0 || end > 15 || end == whole + 1 {
        return None;
    }
    let mut power = (whole + 1) as i32 - end as i32;
    power = if end == whole { 0 } else { power };
    let mut length = end;
    let mut follows = *text.get(length)?;
    if follows | 0x20 == b'e' {
        let rest = text.get(length + 1..)?.first_chunk::<5>()?;
        let signed = usize::from(rest[0] == b'-' || rest[0] == b'+');
        let n = rest[signed..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        if n == 0 || n > 3 {
            return None;
        }
        let exponent =
            rest[signed..signed + n].iter().fold(0, |sum, digit| 10 * sum + i32::from(digit - b'0'));
        power += if rest[0] == b'-' { -exponent } else { exponent };
        length += 1 + signed + n;
        follows = *text.get(length)?;
    }
    if !(is_space(follows) || follows == b',' || is_brace(follows)) || power.unsigned_abs() > 22 {
        return None;
    }
    let scale = POWERS[power.unsigned_abs() as usize];
    let value = if power <= 0 { mantissa as f64 / scale } else { mantissa as f64 * scale };
    let is_between = value.to_bits() & 0x1FFF_FFFF == 0x1000_0000;
    let is_normal = (1.2e-38..3.4e38).contains(&value) || mantissa == 0;
    (is_normal && !is_between).then_some((value as f32, length))
}

#[cfg(target_arch = "x86_64")]
mod sse {
    use std::arch::x86_64::*;

    use super::numbers;

    /// Where the digits of a number go, by how many stand before its point and by its length: to the end, zeros before them.
    static TO_THE_END: [[[u8; 16]; 17]; 17] = {
        let mut table = [[[0x80; 16]; 17]; 17];
        let mut whole = 0;
        while whole < 17 {
            let mut end = whole;
            while end < 17 {
                let has_point = end > whole;
                let n = end - has_point as usize;
                let mut k = 0;
                while k < n {
                    table[whole][end][16 - n + k] = (k + (k >= whole) as usize) as u8;
                    k += 1;
                }
                end += 1;
            }
            whole += 1;
        }
        table
    };

    #[target_feature(enable = "sse4.1")]
    pub(super) fn read(text: &[u8], values: &mut Vec<f32>) -> usize {
        numbers(text, values, |bytes| {
            // SAFETY: sixteen bytes are there.
            let bytes_in_vector = unsafe { _mm_loadu_si128(bytes.as_ptr().cast()) };
            let digits = _mm_sub_epi8(bytes_in_vector, _mm_set1_epi8(b'0' as i8));
            let are_digits = _mm_cmpeq_epi8(_mm_min_epu8(digits, _mm_set1_epi8(9)), digits);
            let others = !(_mm_movemask_epi8(are_digits) as u32);
            let whole = others.trailing_zeros() as usize;
            let has_point = bytes.get(whole) == Some(&b'.');
            let end = if has_point { (others & (others - 1)).trailing_zeros() as usize } else { whole };
            // SAFETY: sixteen bytes are in an entry of the table.
            let order = unsafe { _mm_loadu_si128(TO_THE_END[whole & 15][end.min(16)].as_ptr().cast()) };
            let digits = _mm_shuffle_epi8(digits, order);
            // Pairs, fours, eights.
            let pairs = _mm_maddubs_epi16(digits, _mm_set1_epi16(0x010A));
            let fours = _mm_madd_epi16(pairs, _mm_set1_epi32(0x0001_0064));
            let fours = _mm_packus_epi32(fours, fours);
            let eights = _mm_cvtsi128_si64(_mm_madd_epi16(fours, _mm_set1_epi32(0x0001_2710))) as u64;
            ((eights & 0xFFFF_FFFF) * 100_000_000 + (eights >> 32), whole, end)
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn by_portable(text: &[u8]) -> (Vec<u32>, usize) {
        let mut values = Vec::new();
        let length = numbers(text, &mut values, portable);
        (values.into_iter().map(f32::to_bits).collect(), length)
    }

    fn by_either(text: &[u8]) -> (Vec<u32>, usize) {
        let mut values = Vec::new();
        let length = read(text, &mut values);
        (values.into_iter().map(f32::to_bits).collect(), length)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn all_ways_to_read_agree(text in "[0-9.eE+ ,{}x-]{0,60}") {
            prop_assert_eq!(by_portable(text.as_bytes()), by_either(text.as_bytes()));
        }

        #[test]
        fn any_bytes_are_read_alike(text in prop::collection::vec(any::<u8>(), 0..60)) {
            prop_assert_eq!(by_portable(&text), by_either(&text));
        }

        #[test]
        fn what_is_read_is_what_stands_there(values in prop::collection::vec(0u32..0x7F80_0000, 1..20)) {
            let values: Vec<f32> = values.into_iter().map(f32::from_bits).collect();
            let text: String = values.iter().map(|value| format!("{value} ")).collect();
            let (read, length) = by_either(text.as_bytes());
            for (read, value) in read.iter().zip(&values) {
                prop_assert_eq!(*read, value.to_bits());
            }
            prop_assert!(read.len() == values.len() || !text.as_bytes()[length..].is_empty());
        }
    }

    #[test]
    fn plain_numbers_are_read_in_one_go() {
        let text = b"0 1 0.5 32.594933 0.00008937001 1.5e-7 123456789012345 7 .25 } and so on, and so on";
        let (read, length) = by_either(text);
        let expected = [0.0f32, 1.0, 0.5, 32.594933, 0.00008937001, 1.5e-7, 123456789012345.0, 7.0, 0.25];
        assert_eq!(read, expected.map(f32::to_bits));
        assert_eq!(text[length], b'}');
    }
}
