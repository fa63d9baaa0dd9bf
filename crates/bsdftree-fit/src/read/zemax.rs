//! Zemax's tabular BSDF, "BSDF Data Interchange" of Radiant Imaging.
//!
//! In: lines of `#` anywhere, then `Source`, `Symmetry`, `SpectralContent`, `ScatterType`, then the counts and values of
//! `SampleRotation`, `AngleOfIncidence`, `ScatterAzimuth` and `ScatterRadial`, then for `Monochrome`, or for `TristimulusX`, `…Y` and
//! `…Z` one after the other, `DataBegin`, for each rotation and each angle of incidence `TIS` and a row of radial values for each
//! azimuth, `DataEnd`. Out: a scan for each rotation and angle of incidence.
//!
//! Radial angles are counted from the mirrored direction (BTDF: from straight on), azimuths about it: 0 is towards the normal, and they
//! grow counter-clockwise as seen by one whom that light meets. A rotation turns the sample counter-clockwise, so that light goes
//! towards azimuth −rotation of the sample.
//!
//! Source: R. Rykowski, "Zemax Tabular BSDF data file format", Zemax; compared with twins in FRED's format.
//! What files of a half-measured sphere say: directions behind the horizon are left out; so are zeros at the end of a row, with which
//! files fill up where nothing was measured; both are noted. Azimuths and rotations that are a whole turn from others are these again.

use bsdftree::Direction;

use crate::measurement::{Measurement, Scan, Symmetry};

use super::error::ReadError;
use super::text::{self, Line, decoded, lines};

/// Most values of a file: as many as its bytes allow are far fewer.
const MAX_VALUES: usize = 1 << 28;

/// Whether its first lines are of this format.
pub(super) fn recognizes(text: &str) -> bool {
    content(text).next().is_some_and(|(_, line)| keyword(line).0 == "source")
        && content(text).take(8).any(|(_, line)| keyword(line).0 == "scattertype")
}

fn content(text: &str) -> impl Iterator<Item = Line<'_>> {
    lines(text).filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

fn keyword(line: &str) -> (String, &str) {
    let end = line.find(char::is_whitespace).unwrap_or(line.len());
    (line[..end].to_ascii_lowercase(), line[end..].trim())
}

/// Lines one after the other, each expected.
struct Reader<'a, I: Iterator<Item = Line<'a>>> {
    lines: I,
    last: usize,
}

impl<'a, I: Iterator<Item = Line<'a>>> Reader<'a, I> {
    fn next(&mut self, expected: &str) -> Result<Line<'a>, ReadError> {
        let end = || ReadError::line(self.last, "the end of the file after this line", expected);
        let line = self.lines.next().ok_or_else(end)?;
        self.last = line.0;
        Ok(line)
    }

    /// The word after a keyword.
    fn setting(&mut self, name: &str) -> Result<Line<'a>, ReadError> {
        let (line, text) = self.next(name)?;
        let (word, rest) = keyword(text);
        match word == name.to_ascii_lowercase() {
            true => Ok((line, rest)),
            false => Err(ReadError::line(line, format!("{text:?}"), name)),
        }
    }

    /// So many numbers, on as many lines as they need.
    fn numbers(&mut self, n: usize, what: &str) -> Result<Vec<f64>, ReadError> {
        let mut all = Vec::new();
        while all.len() < n {
            let (line, text) = self.next(what)?;
            all.extend(text::numbers(line, text, what)?);
            if all.len() > n {
                return Err(ReadError::line(line, format!("{} numbers", all.len()), format!("{n}: {what}")));
            }
        }
        Ok(all)
    }

    /// The angles \[degree\] of an axis.
    fn axis(&mut self, name: &str, limit: f64) -> Result<Vec<f64>, ReadError> {
        let (line, count) = self.setting(name)?;
        let expected = || format!("{name} and a count of 1 to 10000");
        let n = count.parse::<usize>().ok().filter(|n| (1..=10_000).contains(n));
        let n = n.ok_or_else(|| ReadError::line(line, format!("{count:?}"), expected()))?;
        let angles = self.numbers(n, &format!("{n} angles of {name}"))?;
        match angles.iter().find(|angle| angle.abs() > limit) {
            Some(angle) => {
                Err(ReadError::line(self.last, format!("{name} {angle}"), format!("at most {limit} degrees")))
            }
            None => Ok(angles),
        }
    }
}

/// The four axes \[degree\].
struct Axes {
    rotations: Vec<f64>,
    incidences: Vec<f64>,
    azimuths: Vec<f64>,
    radials: Vec<f64>,
}

/// Reads a file.
///
/// # Errors
/// If a line is not as it must be there.
pub(super) fn read(bytes: &[u8]) -> Result<Measurement, ReadError> {
    let text = decoded(bytes);
    let mut reader = Reader { lines: content(&text), last: 0 };
    reader.setting("Source")?;
    let choice = |(line, word): Line<'_>, choices: &[&str]| -> Result<usize, ReadError> {
        let found = choices.iter().position(|choice| choice.eq_ignore_ascii_case(word));
        found.ok_or_else(|| ReadError::line(line, format!("{word:?}"), choices.join(" or ")))
    };
    let symmetry =
        choice(reader.setting("Symmetry")?, &["PlaneSymmetrical", "ASymmetrical", "ASymmetrical4D"])?;
    let is_color = choice(reader.setting("SpectralContent")?, &["Monochrome", "XYZ"])? == 1;
    let is_transmission = choice(reader.setting("ScatterType")?, &["BRDF", "BTDF"])? == 1;
    let axes = Axes {
        rotations: reader.axis("SampleRotation", 720.0)?,
        incidences: reader.axis("AngleOfIncidence", 89.999)?,
        azimuths: reader.axis("ScatterAzimuth", 720.0)?,
        radials: reader.axis("ScatterRadial", 180.0)?,
    };
    let blocks: &[&str] =
        if is_color { &["TristimulusX", "TristimulusY", "TristimulusZ"] } else { &["Monochrome"] };
    let mut channels = Vec::new();
    for block in blocks {
        reader.setting(block)?;
        channels.push(read_block(&mut reader, &axes)?);
    }
    if let Some((line, text)) = reader.lines.next() {
        return Err(ReadError::line(line, format!("{text:?} after DataEnd"), "the end of the file"));
    }
    let mut measurement = Measurement {
        n_channels: channels.len(),
        // One rotation stands for all: the sample looks the same from everywhere.
        symmetry: match symmetry {
            0 if axes.rotations.len() == 1 => Some(Symmetry::Isotropic),
            2 => Some(Symmetry::Anisotropic),
            _ => None,
        },
        ..Measurement::default()
    };
    let n_left_out = add_scans(&mut measurement, &axes, &channels, is_transmission);
    if n_left_out > 0 {
        let note = format!("{n_left_out} zeros at the ends of rows are left out: nothing was measured there");
        measurement.notes.push(note);
    }
    describe(&mut measurement, &text);
    Ok(measurement)
}

/// The values of all four axes, radial angles fastest.
fn read_block<'a>(
    reader: &mut Reader<'a, impl Iterator<Item = Line<'a>>>,
    axes: &Axes,
) -> Result<Vec<f64>, ReadError> {
    let n_rows = axes.azimuths.len();
    let n_values = [&axes.incidences, &axes.azimuths, &axes.radials]
        .iter()
        .try_fold(axes.rotations.len(), |n, axis| n.checked_mul(axis.len()).filter(|&n| n <= MAX_VALUES));
    if n_values.is_none() {
        return Err(ReadError::line(reader.last, "more than 2^28 values announced", "axes that are shorter"));
    }
    reader.setting("DataBegin")?;
    let mut values = Vec::new();
    for _ in 0..axes.rotations.len() * axes.incidences.len() {
        let (line, tis) = reader.setting("TIS")?;
        text::number(line, tis, "the total integrated scatter")?;
        for _ in 0..n_rows {
            let n = axes.radials.len();
            values.extend(reader.numbers(n, &format!("a row of {n} values, one for each ScatterRadial"))?);
        }
    }
    reader.setting("DataEnd")?;
    Ok(values)
}

/// Adds a scan for each rotation and incidence; the number of zeros that were left out.
fn add_scans(
    measurement: &mut Measurement,
    axes: &Axes,
    channels: &[Vec<f64>],
    is_transmission: bool,
) -> usize {
    let (n_azimuths, n_radials) = (axes.azimuths.len(), axes.radials.len());
    let mut n_left_out = 0;
    for (r, &rotation) in axes.rotations.iter().enumerate() {
        if is_repeated(&axes.rotations[..r], rotation) {
            continue;
        }
        for (i, &theta) in axes.incidences.iter().enumerate() {
            let first = (r * axes.incidences.len() + i) * n_azimuths * n_radials;
            let frame = Frame::new(theta, -rotation, is_transmission);
            let source = format!("rotation {rotation}, incidence {theta}");
            let mut scan = Scan { incident: frame.incident, source, ..Scan::default() };
            let mut has_specular = false;
            let has_values =
                channels.iter().any(|c| c[first..first + n_azimuths * n_radials].iter().any(|&v| v != 0.0));
            for (a, &azimuth) in axes.azimuths.iter().enumerate() {
                if is_repeated(&axes.azimuths[..a], azimuth) {
                    continue;
                }
                let row = first + a * n_radials;
                let is_zero = |k: &usize| channels.iter().all(|channel| channel[row + k] == 0.0);
                let n_measured = match has_values {
                    true => (0..n_radials).rev().find(|k| !is_zero(k)).map_or(0, |last| last + 1),
                    false => n_radials,
                };
                for (k, &radial) in axes.radials.iter().enumerate() {
                    let exitant = frame.direction(azimuth, radial);
                    if !frame.is_above(exitant) || (radial == 0.0 && has_specular) {
                        continue;
                    }
                    if k >= n_measured {
                        n_left_out += 1;
                        continue;
                    }
                    has_specular |= radial == 0.0;
                    scan.exitant.push(exitant);
                    scan.values.extend(channels.iter().map(|channel| channel[row + k]));
                }
            }
            measurement.scans.push(scan);
        }
    }
    n_left_out
}

/// Whether an angle is a whole number of turns from one before.
fn is_repeated(before: &[f64], angle: f64) -> bool {
    before.iter().any(|other| ((angle - other) / 360.0).fract() == 0.0)
}

/// The mirrored (or straight) direction and what azimuths are counted from.
struct Frame {
    incident: Direction,
    specular: Direction,
    /// At azimuth 0: from the specular direction towards the normal.
    zero: Direction,
    /// At azimuth 90°.
    quarter: Direction,
}

impl Frame {
    /// For light that goes towards an azimuth.
    fn new(theta_deg: f64, phi_deg: f64, is_transmission: bool) -> Frame {
        let [x, y, z] = text::direction_from_degrees(theta_deg, phi_deg);
        let side = if is_transmission { -1.0 } else { 1.0 };
        let specular = [x, y, side * z];
        let tilted = text::direction_from_degrees(theta_deg - 90.0, phi_deg);
        let zero = [tilted[0], tilted[1], side * tilted[2]];
        Frame { incident: [-x, -y, z], specular, zero, quarter: cross(specular, zero) }
    }

    fn direction(&self, azimuth_deg: f64, radial_deg: f64) -> Direction {
        let [x, y, z] = text::direction_from_degrees(radial_deg, azimuth_deg);
        [0, 1, 2].map(|k| x * self.zero[k] + y * self.quarter[k] + z * self.specular[k])
    }

    /// On the side of the specular direction; rounding may leave what is on the horizon on either.
    fn is_above(&self, direction: Direction) -> bool {
        direction[2] * self.specular[2] > 1e-12
    }
}

fn cross(a: Direction, b: Direction) -> Direction {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// What comments say of sample and light, as ua-loft writes them.
fn describe(measurement: &mut Measurement, text: &str) {
    let comments = lines(text).filter_map(|(_, line)| line.strip_prefix('#')).map(str::trim);
    for comment in comments {
        match comment.split_once(':') {
            Some(("Sample", name)) if !name.trim().is_empty() => {
                measurement.name.get_or_insert_with(|| name.trim().to_owned());
            }
            Some(("Light source", source)) => measurement.wavelength_nm = wavelength_nm(source),
            _ => {}
        }
    }
}

/// The number before the word nm.
fn wavelength_nm(text: &str) -> Option<f64> {
    let words: Vec<&str> = text.split(|c: char| c.is_whitespace() || "(),;".contains(c)).collect();
    let before = words.iter().position(|&word| word == "nm")?.checked_sub(1)?;
    words[before].parse().ok().filter(|nm| (100.0..1e5).contains(nm))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdftree::direction::direction_from_polar;

    fn file(symmetry: &str, content: &str, kind: &str, axes: &str, data: &str) -> String {
        format!(
            "#c\nSource Measured\nSymmetry {symmetry}\nSpectralContent {content}\nScatterType {kind}\n{axes}\n{data}"
        )
    }

    const AXES: &str =
        "SampleRotation 1\n0\nAngleOfIncidence 1\n30\nScatterAzimuth 3\n0 90 180\nScatterRadial 2\n0 20\n";

    fn near(a: Direction, theta_deg: f64, phi_deg: f64) {
        let b = direction_from_polar(theta_deg.to_radians(), phi_deg.to_radians());
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-12), "{a:?} for {theta_deg}, {phi_deg}");
    }

    #[test]
    fn angles_are_counted_from_the_mirrored_direction() {
        let data = "Monochrome\nDataBegin\nTIS 0.1\n1 2\n1 3\n1 4\nDataEnd\n";
        let read = read(file("PlaneSymmetrical", "Monochrome", "BRDF", AXES, data).as_bytes()).unwrap();
        let scan = &read.scans[0];
        near(scan.incident, 30.0, 180.0);
        assert_eq!(scan.values, [1.0, 2.0, 3.0, 4.0]);
        near(scan.exitant[0], 30.0, 0.0);
        near(scan.exitant[1], 10.0, 0.0);
        // Seen against the mirrored ray with the normal's side up, what is left of it: azimuth 0 points up, 90° to the left.
        assert!(scan.exitant[2][1] < 0.0);
        near(scan.exitant[3], 50.0, 0.0);
        assert_eq!(read.symmetry, Some(Symmetry::Isotropic));
    }

    #[test]
    fn transmission_is_counted_from_straight_on() {
        let data = "TristimulusX\nDataBegin\nTIS 0.1\n1 2\n1 3\n1 4\nDataEnd\n\
            TristimulusY\nDataBegin\nTIS 0.1\n5 6\n5 7\n5 8\nDataEnd\nTristimulusZ\nDataBegin\nTIS 0.1\n9 8\n9 8\n9 8\nDataEnd\n";
        let read = read(file("ASymmetrical4D", "XYZ", "BTDF", AXES, data).as_bytes()).unwrap();
        let scan = &read.scans[0];
        near(scan.incident, 30.0, 180.0);
        near(scan.exitant[0], 150.0, 0.0);
        near(scan.exitant[1], 170.0, 0.0);
        assert_eq!((read.n_channels, &scan.values[..6]), (3, &[1.0, 5.0, 9.0, 2.0, 6.0, 8.0][..]));
    }

    #[test]
    fn turns_of_the_sample_turn_the_light_the_other_way() {
        let axes =
            "SampleRotation 3\n0 30 360\nAngleOfIncidence 1\n40\nScatterAzimuth 1\n0\nScatterRadial 1\n0\n";
        let data = "Monochrome\nDataBegin\nTIS 0\n1\nTIS 0\n2\nTIS 0\n1\nDataEnd\n";
        let read = read(file("Asymmetrical4D", "Monochrome", "BRDF", axes, data).as_bytes()).unwrap();
        assert_eq!(read.scans.len(), 2, "360° is 0° again");
        near(read.scans[1].incident, 40.0, 150.0);
        near(read.scans[1].exitant[0], 40.0, 330.0);
    }

    #[test]
    fn zeros_that_fill_up_are_left_out() {
        let axes = "SampleRotation 1\n0\nAngleOfIncidence 1\n60\nScatterAzimuth 2\n0 180\nScatterRadial 4\n0 10 20 40\n";
        let data = "Monochrome\nDataBegin\nTIS 0.1\n4 0 1 0\n4 0 0 0\nDataEnd\n";
        let read = read(file("PlaneSymmetrical", "Monochrome", "BRDF", axes, data).as_bytes()).unwrap();
        // Of azimuth 180°, 60° + 40° is behind the horizon.
        assert_eq!(read.scans[0].values, [4.0, 0.0, 1.0]);
        assert!(read.notes[0].starts_with("3 zeros"), "{:?}", read.notes);
    }

    #[test]
    fn faults_are_told_by_line() {
        let good = "Monochrome\nDataBegin\nTIS 0.1\n1 2\n1 3\n1 4\nDataEnd\n";
        let with = |axes: &str, data: &str| file("PlaneSymmetrical", "Monochrome", "BRDF", axes, data);
        assert!(read(with(AXES, good).as_bytes()).is_ok());
        for (text, said) in [
            (with(AXES, &good.replace("1 3", "1 3 5")), "line 19: found 3 numbers; expected 2"),
            (with(AXES, &good.replace("1 3", "1 x")), "line 19: found \"x\""),
            (with(AXES, &good.replace("TIS 0.1", "1 2")), "line 17: found \"1 2\"; expected TIS"),
            (
                with(AXES, &good.replace("DataEnd\n", "")),
                "the end of the file after this line; expected DataEnd",
            ),
            (
                with(&AXES.replace("Rotation 1", "Rotation 99999999999"), good),
                "expected SampleRotation and a count",
            ),
            (with(&AXES.replace("\n30\n", "\n95\n"), good), "AngleOfIncidence 95"),
            (with(AXES, &format!("{good}7\n")), "after DataEnd"),
            (file("Round", "Monochrome", "BRDF", AXES, good), "line 3: found \"Round\""),
        ] {
            let message = read(text.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(said), "{message} for {said}");
        }
    }
}
