//! Lines of text with their numbers, and numbers in them.

use bsdftree::Direction;
use bsdftree::direction::direction_from_polar;

use super::error::ReadError;

/// A line: its number from 1, and its text without white space around it.
pub(super) type Line<'a> = (usize, &'a str);

/// The text of a file: UTF-8, with or without a mark, or else Latin-1, in which old instruments write their degree signs.
pub(super) fn decoded(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// Lines that end as on any system, numbered.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let mut rest = Some(text);
    let ends = std::iter::from_fn(move || {
        let text = rest?;
        let Some(end) = text.find(['\n', '\r']) else { return rest.take() };
        let after = if text[end..].starts_with("\r\n") { end + 2 } else { end + 1 };
        rest = Some(&text[after..]);
        Some(&text[..end])
    });
    ends.enumerate().map(|(k, line)| (k + 1, line.trim()))
}

/// A finite number.
pub(super) fn number(line: usize, word: &str, what: &str) -> Result<f64, ReadError> {
    match fast_float2::parse::<f64, _>(word) {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(ReadError::line(line, format!("{word:?}"), format!("{what}, a finite number"))),
    }
}

/// All words of a line as finite numbers.
pub(super) fn numbers(line: usize, text: &str, what: &str) -> Result<Vec<f64>, ReadError> {
    words(text).map(|word| number(line, word, what)).collect()
}

/// What white space, commas or semicolons separate.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_whitespace() || c == ',' || c == ';').filter(|word| !word.is_empty())
}

/// The direction at angles \[degree\]. A negative polar angle is a positive one on the other side of the normal.
pub(super) fn direction(line: usize, theta_deg: f64, phi_deg: f64) -> Result<Direction, ReadError> {
    match theta_deg.abs() <= 180.0 {
        true => Ok(direction_from_degrees(theta_deg, phi_deg)),
        false => Err(ReadError::line(line, format!("a polar angle of {theta_deg}°"), "-180° to 180°")),
    }
}

/// The direction at angles \[degree\]; at multiples of 90° without the rounding of radians, so that the horizon is the horizon.
pub(crate) fn direction_from_degrees(theta_deg: f64, phi_deg: f64) -> Direction {
    let (sin_theta, cos_theta) = sin_cos_degrees(theta_deg);
    let (sin_phi, cos_phi) = sin_cos_degrees(phi_deg);
    [sin_theta * cos_phi, sin_theta * sin_phi, cos_theta]
}

fn sin_cos_degrees(angle: f64) -> (f64, f64) {
    match angle.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        angle => {
            let [x, _, z] = direction_from_polar(angle.to_radians(), 0.0);
            (x, z)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_all_systems_are_counted_alike() {
        let expected = vec![(1, "a"), (2, "b"), (3, ""), (4, "c")];
        for text in ["a\nb\n\nc", "a\r\n b\r\n\r\nc", "a\rb\r\rc"] {
            assert_eq!(lines(text).collect::<Vec<_>>(), expected);
        }
    }

    #[test]
    fn numbers_that_are_none_are_refused_by_line() {
        for word in ["nan", "inf", "1e999", "x", "1,2"] {
            let message = number(7, word, "a value").unwrap_err().to_string();
            assert!(message.starts_with("line 7: found ") && message.contains(word), "{message}");
        }
    }
}
