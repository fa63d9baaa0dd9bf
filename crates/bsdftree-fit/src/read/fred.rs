//! FRED's tabulated BSDF text.
//!
//! In: `type bsdf_data`, then `format angles=deg bsdf=value scale=1`, then blocks: a line of two angles for the light, lines of two
//! angles and a value for where it was measured. Out: a scan for each block. `angles` may be `deg` or `rad`, values are multiplied by
//! `scale`, lines of `#`, `!` or `//` are skipped. Polar angles over 90° lie behind the sample.
//!
//! **The azimuth of the light is where it goes**: light of θ, φ is mirrored to θ, φ, so it comes from φ + 180°. That is how the files of
//! ua-loft's bsdf-tools have it, whose twins in Zemax's format and whose peaks agree; the peaks of other files are looked at too, and a
//! note says if they lie on the side that the light comes from.

use crate::measurement::{Measurement, Scan};

use super::error::ReadError;
use super::text::{self, decoded, direction, lines};

/// Whether it begins so.
pub(super) fn recognizes(text: &str) -> bool {
    content(text).next().is_some_and(|(_, line)| is_type(line))
}

fn is_type(line: &str) -> bool {
    line.split_whitespace().map(str::to_ascii_lowercase).eq(["type", "bsdf_data"])
}

fn content(text: &str) -> impl Iterator<Item = (usize, &str)> {
    lines(text)
        .filter(|(_, line)| !line.is_empty() && !["#", "!", "//"].iter().any(|mark| line.starts_with(mark)))
}

/// Factors that make degrees of angles and BSDFs of values.
struct Units {
    degree: f64,
    value: f64,
}

/// Reads a file.
///
/// # Errors
/// If it does not begin as it must, or a line has other than two or three numbers.
pub(super) fn read(bytes: &[u8]) -> Result<Measurement, ReadError> {
    let text = decoded(bytes);
    let mut body = content(&text);
    match body.next() {
        Some((_, line)) if is_type(line) => {}
        Some((line, text)) => return Err(ReadError::line(line, format!("{text:?}"), "type bsdf_data")),
        None => return Err(ReadError::file("no lines", "type bsdf_data")),
    }
    let units = match body.next() {
        Some((line, text)) => units(line, text)?,
        None => return Err(ReadError::file("an end after one line", "format angles=deg bsdf=value scale=1")),
    };
    let mut scans: Vec<Scan> = Vec::new();
    for (line, text) in body {
        let numbers = text::numbers(line, text, "angles and a value")?;
        match (numbers.as_slice(), scans.last_mut()) {
            (&[theta, phi], _) => {
                let incident = direction(line, theta * units.degree, phi * units.degree + 180.0)?;
                scans.push(Scan { incident, source: format!("line {line}"), ..Scan::default() });
            }
            (&[theta, phi, value], Some(scan)) => {
                scan.exitant.push(direction(line, theta * units.degree, phi * units.degree)?);
                scan.values.push(value * units.value);
            }
            (&[_, _, _], None) => {
                return Err(ReadError::line(
                    line,
                    format!("{text:?}"),
                    "first a line of two angles, those of the light",
                ));
            }
            _ => {
                let expected = "two angles of the light, or two angles and a value";
                return Err(ReadError::line(line, format!("{text:?}"), expected));
            }
        }
    }
    let notes =
        vec!["azimuths of the light are taken as where it goes, as FRED's files of ua-loft have them".into()];
    Ok(Measurement { n_channels: 1, scans, notes, ..Measurement::default() })
}

fn units(line: usize, text: &str) -> Result<Units, ReadError> {
    let expected = "format angles=deg bsdf=value scale=1 (or angles=rad, another scale)";
    let wrong = || ReadError::line(line, format!("{text:?}"), expected);
    let mut words = text.split_whitespace();
    if !words.next().is_some_and(|word| word.eq_ignore_ascii_case("format")) {
        return Err(wrong());
    }
    let mut units = Units { degree: 1.0, value: 1.0 };
    for word in words {
        match word.to_ascii_lowercase().split_once('=').ok_or_else(wrong)? {
            ("angles", "deg") | ("bsdf", "value") => {}
            ("angles", "rad") => units.degree = 1f64.to_degrees(),
            ("scale", scale) => units.value = text::number(line, scale, "a scale")?,
            _ => return Err(wrong()),
        }
    }
    Ok(units)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdftree::direction::direction_from_polar;

    #[test]
    fn light_goes_where_its_azimuth_is() {
        let read = read(
            b"type bsdf_data\nformat angles=deg bsdf=value scale=2\n30 40\n30 40 .5\n20 0 .1\n50 0\n0 0 1\n",
        )
        .unwrap();
        assert_eq!(read.scans.len(), 2);
        let scan = &read.scans[0];
        assert_eq!(scan.values, [1.0, 0.2]);
        let from = direction_from_polar(30f64.to_radians(), 220f64.to_radians());
        assert!((0..3).all(|k| (scan.incident[k] - from[k]).abs() < 1e-12));
        let mirrored = [-from[0], -from[1], from[2]];
        assert!((0..3).all(|k| (scan.exitant[0][k] - mirrored[k]).abs() < 1e-12));
    }

    #[test]
    fn faults_are_told_by_line() {
        let head = "type bsdf_data\nformat angles=deg bsdf=value scale=1\n";
        for (text, said) in [
            ("type bsdf\n".to_owned(), "line 1"),
            ("type bsdf_data\n10 0\n".into(), "line 2: found \"10 0\"; expected format"),
            ("type bsdf_data\nformat angles=grad\n".into(), "line 2"),
            (format!("{head}10 0 1\n"), "line 3: found \"10 0 1\"; expected first a line of two angles"),
            (format!("{head}10 0\n10 0 1 2\n"), "line 4"),
            (format!("{head}10 0\n10 0 -inf\n"), "line 4: found \"-inf\""),
        ] {
            let message = read(text.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(said), "{message} for {said}");
        }
    }
}
