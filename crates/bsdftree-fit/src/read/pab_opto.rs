//! The "theta phi value" text of pab-opto's Mountain, as Radiance's pabopto2bsdf and pabopto2xyz take and write it.
//!
//! In: one file, lines of `#` first, then an exitant direction and its value per line. Out: a measurement of one scan. Of the header
//! these count, after any white space and in any case: `#sample_name "…"`, `#format: theta phi DSF` (or BSDF, BRDF, BTDF; a DSF has
//! the cosine of the exitant direction in it, which is divided out), `#incident_angle THETA PHI` or `#intheta` and `#inphi`, `#upphi`,
//! `#colorimetry: CIE-Y` or `CIE-XYZ` (three values a line). Angles are in degrees, both directions point away from the sample, θ is
//! counted from its front, over 90° on the back; a negative θ lies on the other side of the normal. `#upphi` is the azimuth of *up*,
//! 0 if absent, so our azimuth is φ + 90° − upphi. `#symmetry` and `#wavelength_nm` are our own, as [`crate::write`] has them.
//!
//! Source: the manual page of pabopto2bsdf, and what the program does.
//! Deviations: an unknown colorimetry, words after the numbers of a line and lines of `#` after them are refused, where pabopto2bsdf
//! ignores the first and stops reading at the others.

use crate::measurement::{Measurement, Scan, Symmetry};

use super::error::ReadError;
use super::text::{self, Line, decoded, direction, lines};

/// What a header says.
#[derive(Default)]
struct Header {
    name: Option<String>,
    is_dsf: Option<bool>,
    theta_deg: Option<f64>,
    phi_deg: Option<f64>,
    up_phi_deg: f64,
    is_color: bool,
    symmetry: Option<Symmetry>,
    wavelength_nm: Option<f64>,
}

/// Whether the first lines are such a header.
pub(super) fn recognizes(text: &str) -> bool {
    let header = lines(text).take_while(|(_, line)| line.is_empty() || line.starts_with('#'));
    header
        .filter_map(|(_, line)| keyword(line))
        .any(|(name, _)| matches!(name.as_str(), "format:" | "incident_angle" | "intheta" | "inphi"))
}

/// Reads a file.
///
/// # Errors
/// If it says no format or no incident direction, has no values, or a line is not as it must be.
pub(super) fn read(bytes: &[u8]) -> Result<Measurement, ReadError> {
    let text = decoded(bytes);
    let mut header = Header::default();
    let mut body = lines(&text).filter(|(_, line)| !line.is_empty()).peekable();
    while let Some((line, text)) = body.next_if(|(_, line)| line.starts_with('#')) {
        header.take(line, text)?;
    }
    let missing =
        |what: &str| ReadError::file(format!("no {what} in the header"), "lines of # before the values");
    let is_dsf = header.is_dsf.ok_or_else(|| missing("\"#format: theta phi BSDF\" (or DSF)"))?;
    let (Some(theta), Some(phi)) = (header.theta_deg, header.phi_deg) else {
        return Err(missing("\"#incident_angle THETA PHI\""));
    };
    let turn_deg = 90.0 - header.up_phi_deg;
    let n_channels = if header.is_color { 3 } else { 1 };
    let mut scan = Scan { incident: text::direction_from_degrees(theta, phi + turn_deg), ..Scan::default() };
    for line in body {
        add_point(&mut scan, line, n_channels, turn_deg, is_dsf)?;
    }
    let name = header.name.take().filter(|name| !name.is_empty());
    let Header { symmetry, wavelength_nm, .. } = header;
    Ok(Measurement { n_channels, scans: vec![scan], name, symmetry, wavelength_nm, ..Measurement::default() })
}

fn add_point(
    scan: &mut Scan,
    (line, text): Line<'_>,
    n_channels: usize,
    turn_deg: f64,
    is_dsf: bool,
) -> Result<(), ReadError> {
    if text.starts_with('#') {
        return Err(ReadError::line(
            line,
            format!("{text:?} after values"),
            "header lines before all values",
        ));
    }
    let expected = if n_channels == 3 { "theta, phi, X, Y and Z" } else { "theta, phi and a value" };
    let numbers = text::numbers(line, text, expected)?;
    let [theta, phi, values @ ..] = numbers.as_slice() else {
        return Err(ReadError::line(line, format!("{text:?}"), expected));
    };
    if values.len() != n_channels {
        let advice = if values.len() == 3 { "; three values need \"#colorimetry: CIE-XYZ\"" } else { "" };
        return Err(ReadError::line(line, format!("{text:?}"), format!("{expected}{advice}")));
    }
    let exitant = direction(line, *theta, phi + turn_deg)?;
    let divisor = if is_dsf { exitant[2].abs() } else { 1.0 };
    // On the horizon there is no BSDF to a DSF; the point is left out later, as all there.
    let divisor = if divisor == 0.0 { 1.0 } else { divisor };
    scan.exitant.push(exitant);
    scan.values.extend(values.iter().map(|value| value / divisor));
    Ok(())
}

/// The keyword of a header line in lower case, and what follows.
fn keyword(line: &str) -> Option<(String, &str)> {
    let line = line.strip_prefix('#')?.trim();
    let end = line.find(char::is_whitespace).unwrap_or(line.len());
    Some((line[..end].to_ascii_lowercase(), line[end..].trim()))
}

impl Header {
    fn take(&mut self, line: usize, text: &str) -> Result<(), ReadError> {
        let Some((name, rest)) = keyword(text) else { return Ok(()) };
        let angle = |word: &str| text::number(line, word, "an angle in degrees");
        let angles = |n: usize| -> Result<Vec<f64>, ReadError> {
            let angles: Vec<f64> = text::words(rest).map(angle).collect::<Result<_, _>>()?;
            match angles.len() == n {
                true => Ok(angles),
                false => Err(ReadError::line(line, format!("{text:?}"), format!("{n} angle(s) in degrees"))),
            }
        };
        match name.as_str() {
            "sample_name" => {
                let quoted = rest.strip_prefix('"').map(|rest| rest.split('"').next().unwrap_or(rest));
                self.name = Some(quoted.unwrap_or(rest).trim().to_owned());
            }
            "format:" => self.is_dsf = Some(is_dsf(line, text, rest)?),
            "colorimetry:" => {
                self.is_color = match rest.to_ascii_uppercase().as_str() {
                    "CIE-Y" => false,
                    "CIE-XYZ" => true,
                    _ => return Err(ReadError::line(line, format!("{text:?}"), "CIE-Y or CIE-XYZ")),
                }
            }
            "symmetry" => self.symmetry = Symmetry::ALL.into_iter().find(|symmetry| symmetry.name() == rest),
            "wavelength_nm" => self.wavelength_nm = Some(text::number(line, rest, "a wavelength in nm")?),
            "upphi" => self.up_phi_deg = angles(1)?[0],
            "intheta" => self.theta_deg = Some(polar(line, angles(1)?[0])?),
            "inphi" => self.phi_deg = Some(angles(1)?[0]),
            "incident_angle" => {
                let angles = angles(2)?;
                (self.theta_deg, self.phi_deg) = (Some(polar(line, angles[0])?), Some(angles[1]));
            }
            _ => {}
        }
        Ok(())
    }
}

fn polar(line: usize, theta_deg: f64) -> Result<f64, ReadError> {
    direction(line, theta_deg, 0.0).map(|_| theta_deg)
}

fn is_dsf(line: usize, text: &str, rest: &str) -> Result<bool, ReadError> {
    let words: Vec<String> = rest.split_whitespace().map(str::to_ascii_lowercase).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["theta", "phi", "dsf"] => Ok(true),
        ["theta", "phi", "bsdf" | "brdf" | "btdf"] => Ok(false),
        _ => Err(ReadError::line(
            line,
            format!("{text:?}"),
            "\"#format: theta phi\" and DSF, BSDF, BRDF or BTDF",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdftree::direction::direction_from_polar;

    fn one(text: &str) -> Measurement {
        read(text.as_bytes()).unwrap()
    }

    fn near(a: [f64; 3], theta_deg: f64, phi_deg: f64) {
        let b = direction_from_polar(theta_deg.to_radians(), phi_deg.to_radians());
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} for {theta_deg}, {phi_deg}");
    }

    #[test]
    fn reads_the_example_of_the_manual_page() {
        let short = "#incident_angle 82.5 180\n#format: theta phi DSF\n84.968 125.790 0.009744\n84.889 125.610 0.007737\n";
        let long = "#format: theta phi DSF\n#incident_angle 82.5 180\n#intheta 82.5\n#inphi 180\n#upphi 0\n\
            #colorimetry: CIE-Y\n84.968 125.790 0.009744\n84.889 125.610 0.007737\n";
        let read = one(short);
        assert_eq!(read, one(long));
        let scan = &read.scans[0];
        near(scan.incident, 82.5, 270.0);
        near(scan.exitant[0], 84.968, 215.79);
        assert!((scan.values[0] - 0.009744 / 84.968f64.to_radians().cos()).abs() < 1e-12);
    }

    #[test]
    fn up_becomes_y() {
        for (up, phi) in [(0.0, 40.0), (90.0, 130.0), (-30.0, 10.0)] {
            let read =
                one(&format!("#format: theta phi BRDF\n#incident_angle 30 {phi}\n#upphi {up}\n10 {phi} 1\n"));
            near(read.scans[0].incident, 30.0, 130.0);
            near(read.scans[0].exitant[0], 10.0, 130.0);
        }
    }

    #[test]
    fn color_has_three_values_a_line() {
        let read = one(
            "#sample_name \"a b\"\n#colorimetry: CIE-XYZ\n#format: theta phi BTDF\n#intheta 0\n#inphi 0\n170 0 .1 .2 .3\n",
        );
        assert_eq!((read.n_channels, read.name.as_deref()), (3, Some("a b")));
        assert_eq!(read.scans[0].values, [0.1, 0.2, 0.3]);
    }

    #[test]
    fn faults_are_told_by_line() {
        let good = "#format: theta phi BRDF\n#incident_angle 30 0\n";
        for (text, said) in [
            (format!("{good}10 0\n"), "line 3: found \"10 0\"; expected theta, phi and a value"),
            (format!("{good}10 0 1 1 1\n"), "CIE-XYZ"),
            (format!("{good}10 0 nan\n"), "line 3: found \"nan\""),
            (format!("{good}\n\n190 0 1\n"), "line 5: found a polar angle of 190°"),
            (format!("{good}10 0 1\n#upphi 0\n"), "line 4: found \"#upphi 0\" after values"),
            (format!("{good}10 0 x\n"), "line 3: found \"x\""),
            ("#format: theta phi\n".into(), "line 1"),
            ("#format: theta phi BRDF\n10 0 1\n".into(), "no \"#incident_angle"),
            ("#incident_angle 30 0\n10 0 1\n".into(), "no \"#format"),
            ("#incident_angle 30\n".into(), "line 1: found \"#incident_angle 30\"; expected 2 angle"),
            ("#incident_angle 200 0\n".into(), "line 1: found a polar angle of 200°"),
            ("#colorimetry: RGB\n".into(), "expected CIE-Y or CIE-XYZ"),
        ] {
            let message = read(text.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(said), "{message} for {said}");
        }
    }
}
