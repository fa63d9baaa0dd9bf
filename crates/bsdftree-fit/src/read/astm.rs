//! Tables of ASTM E1392 (E2387), as Cornell's measurements and the programs that read them have them.
//!
//! In: lines `KEY value`, of which `VARS` is the last and names the columns: angles `theta_i,phi_i,theta_r,phi_r` in any order and with any
//! ending that says so (`theta_s`), of which isotropic files may lack an azimuth, and the channels; after it rows of numbers, separated by commas or white space. Out: a
//! scan for each incident direction. Channels are one value, `R,G,B` (as X, Y, Z with equal-energy white), `X,Y,Z`, or wavelengths
//! (`550nm`), of which X, Y, Z are made. Angles are in radians, unless one is larger than 2π or `ANGLE_UNITS degrees` says otherwise.
//! `NUM_POINTS` must be right if it is there; `SAMPLE`, `MANUFACTURER` and `WAVELENGTH` \[nm, or μm if below 100\] are taken over.
//!
//! The standard itself is withdrawn and not free: this is what libbsdf's and ALTA's readers and Cornell's files agree on. Both directions are taken to
//! point away from the sample; [`super::plausible`] looks whether peaks lie where that says.

use std::collections::HashMap;
use std::f64::consts::TAU;

use bsdftree::color::xyz_from_rgb;

use crate::measurement::{Measurement, Scan};

use super::error::ReadError;
use super::spectrum;
use super::text::{self, decoded, direction, lines};

/// What the columns after the angles are.
enum Channels {
    One,
    Rgb,
    Xyz,
    /// X, Y and Z of each.
    Spectrum(Vec<[f64; 3]>),
}

#[derive(Default)]
struct Header {
    n_points: Option<(usize, usize)>,
    is_degrees: Option<bool>,
    name: Option<String>,
    manufacturer: Option<String>,
    wavelength_nm: Option<f64>,
}

/// Key in capitals and the rest of a line.
fn keyword(line: &str) -> (String, &str) {
    let end = line.find(|c: char| c.is_whitespace() || c == '=' || c == ':').unwrap_or(line.len());
    (line[..end].to_ascii_uppercase(), line[end..].trim_start_matches([' ', '\t', '=', ':']).trim())
}

/// Whether there is a line of VARS among the first.
pub(super) fn recognizes(text: &str) -> bool {
    let header = lines(text).take(200).map(|(_, line)| keyword(line));
    header.into_iter().any(|(key, rest)| key == "VARS" && rest.to_ascii_lowercase().contains("theta"))
}

/// Reads a file.
///
/// # Errors
/// If there is no VARS, rows are not as it says, or they are not as many as NUM_POINTS.
pub(super) fn read(bytes: &[u8]) -> Result<Measurement, ReadError> {
    let text = decoded(bytes);
    let mut body = lines(&text).filter(|(_, line)| !line.is_empty());
    let mut header = Header::default();
    let (line, names) = loop {
        let Some((line, text)) = body.next() else {
            return Err(ReadError::file(
                "no line VARS",
                "VARS theta_i,phi_i,theta_r,phi_r and channels, before the rows",
            ));
        };
        match keyword(text) {
            (key, names) if key == "VARS" => break (line, names),
            (key, rest) => header.take(line, &key, rest)?,
        }
    };
    let names = columns_of(names);
    let Layout { angles, columns, channels } = layout(line, &names)?;
    let mut rows: Vec<(usize, Vec<f64>)> = Vec::new();
    for (line, text) in body {
        let row = text::numbers(line, text, "a row of numbers")?;
        if row.len() != names.len() {
            let found = format!("{} numbers", row.len());
            return Err(ReadError::line(line, found, format!("{}, as VARS has names", names.len())));
        }
        rows.push((line, row));
    }
    if let Some((line, n)) = header.n_points.filter(|&(_, n)| n != rows.len()) {
        return Err(ReadError::line(
            line,
            format!("NUM_POINTS {n}, but {} rows", rows.len()),
            "the number of rows",
        ));
    }
    let largest =
        rows.iter().flat_map(|(_, row)| angles.map(|k| k.map_or(0.0, |k| row[k].abs()))).fold(0.0, f64::max);
    let is_degrees = header.is_degrees.unwrap_or(largest > TAU + 1e-3);
    let unit = if is_degrees { 1.0 } else { 1f64.to_degrees() };
    let mut scans: Vec<Scan> = Vec::new();
    let mut by_incident: HashMap<[u64; 3], usize> = HashMap::new();
    for (line, row) in &rows {
        let [theta_i, phi_i, theta_r, phi_r] = angles.map(|k| k.map_or(0.0, |k| row[k] * unit));
        let incident = direction(*line, theta_i, phi_i)?;
        let k = *by_incident.entry(incident.map(f64::to_bits)).or_insert_with(|| {
            scans.push(Scan { incident, ..Scan::default() });
            scans.len() - 1
        });
        scans[k].exitant.push(direction(*line, theta_r, phi_r)?);
        let values: Vec<f64> = columns.iter().map(|&column| row[column]).collect();
        scans[k].values.extend(channels.values(&values));
    }
    let mut notes = vec![format!("angles are taken as {}", if is_degrees { "degrees" } else { "radians" })];
    for (angle, whose) in [(angles[1], "the light"), (angles[3], "the exitant directions")] {
        if angle.is_none() {
            notes.push(format!("there is no azimuth of {whose}: it is taken as 0"));
        }
    }
    Ok(Measurement {
        n_channels: if matches!(channels, Channels::One) { 1 } else { 3 },
        scans,
        name: header.name,
        manufacturer: header.manufacturer,
        wavelength_nm: header.wavelength_nm,
        notes,
        ..Measurement::default()
    })
}

impl Header {
    fn take(&mut self, line: usize, key: &str, rest: &str) -> Result<(), ReadError> {
        let text = || Some(rest.trim_matches('"').to_owned()).filter(|text| !text.is_empty());
        match key {
            "NUM_POINTS" => {
                let n = rest
                    .parse()
                    .map_err(|_| ReadError::line(line, format!("{rest:?}"), "a number of points"))?;
                self.n_points = Some((line, n));
            }
            "ANGLE_UNITS" => {
                self.is_degrees = match rest.to_ascii_lowercase().get(..3) {
                    Some("deg") => Some(true),
                    Some("rad") => Some(false),
                    _ => return Err(ReadError::line(line, format!("{rest:?}"), "degrees or radians")),
                }
            }
            "SAMPLE" | "SAMPLE_NAME" | "TITLE" | "NAME" => self.name = self.name.take().or_else(text),
            "MANUFACTURER" => self.manufacturer = text(),
            "WAVELENGTH" => {
                let word =
                    text::words(rest).next().unwrap_or("").trim_end_matches(|c: char| c.is_alphabetic());
                let number = text::number(line, word, "a wavelength")?;
                self.wavelength_nm = Some(if number < 100.0 { 1000.0 * number } else { number });
            }
            _ => {}
        }
        Ok(())
    }
}

/// Names of columns. Between commas they may have spaces and, in brackets, commas, as `Integrated [300,700]`.
fn columns_of(names: &str) -> Vec<&str> {
    if !names.contains([',', ';']) {
        return text::words(names).collect();
    }
    let mut depth = 0;
    let is_end = |c: char| {
        depth += i32::from(matches!(c, '[' | '(')) - i32::from(matches!(c, ']' | ')'));
        depth <= 0 && matches!(c, ',' | ';')
    };
    names.split(is_end).map(str::trim).filter(|name| !name.is_empty()).collect()
}

/// Where what is.
struct Layout {
    /// Columns of θ and φ of the light and of the exitant directions. Isotropic files may lack an azimuth.
    angles: [Option<usize>; 4],
    /// Columns of the channels.
    columns: Vec<usize>,
    channels: Channels,
}

fn layout(line: usize, names: &[&str]) -> Result<Layout, ReadError> {
    let expected =
        "angles theta_i,phi_i,theta_r,phi_r and one channel, R,G,B, X,Y,Z or wavelengths such as 550nm";
    let wrong = || ReadError::line(line, format!("VARS {}", names.join(",")), expected);
    let find = |angle: &str, ends: &[&str]| {
        names.iter().position(|name| {
            let name = name.to_ascii_lowercase();
            name.strip_prefix(angle).is_some_and(|end| ends.contains(&end.trim_start_matches('_')))
        })
    };
    let (into, out) = (["i", "in", "incident"], ["r", "s", "o", "out", "scatter", "reflected"]);
    let angles = [find("theta", &into), find("phi", &into), find("theta", &out), find("phi", &out)];
    let is_angle = |k: &usize| {
        let name = names[*k].to_ascii_lowercase();
        angles.contains(&Some(*k)) || name.starts_with("theta") || name.starts_with("phi")
    };
    let columns: Vec<usize> = (0..names.len()).filter(|k| !is_angle(k)).collect();
    let n_angles = angles.iter().flatten().count();
    if angles[0].is_none()
        || angles[2].is_none()
        || columns.is_empty()
        || columns.len() + n_angles != names.len()
    {
        return Err(wrong());
    }
    let names: Vec<String> = columns.iter().map(|&k| names[k].to_ascii_uppercase()).collect();
    let wavelengths: Option<Vec<f32>> = names
        .iter()
        .map(|name| name.strip_suffix("NM")?.parse().ok().filter(|nm: &f32| nm.is_finite()))
        .collect();
    let channels = match names.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["X", "Y", "Z"] => Channels::Xyz,
        ["R" | "RED", "G" | "GREEN", "B" | "BLUE"] => Channels::Rgb,
        [_] => Channels::One,
        _ => Channels::Spectrum(spectrum::weights(&wavelengths.ok_or_else(wrong)?)),
    };
    Ok(Layout { angles, columns, channels })
}

impl Channels {
    fn values(&self, row: &[f64]) -> Vec<f64> {
        match self {
            Channels::One | Channels::Xyz => row.to_vec(),
            Channels::Rgb => xyz_from_rgb([row[0], row[1], row[2]]).to_vec(),
            Channels::Spectrum(weights) => {
                let sum = |c: usize| row.iter().zip(weights).map(|(value, xyz)| value * xyz[c]).sum();
                (0..3).map(sum).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_radians_and_degrees() {
        let rad = "TITLE red paint\nNUM_POINTS 2\nVARS theta_i,phi_i,theta_r,phi_r,bsdf\n\
            0.5235987755982988,0,0.17453292519943295,3.141592653589793,0.25\n0.5235987755982988,0,0,0,0.5\n";
        let deg = "TITLE red paint\nVARS=phi_r theta_r phi_i theta_i f\n180 10 0 30 .25\n0 0 0 30 .5\n";
        assert!(recognizes(rad) && recognizes(deg));
        let [rad, deg] = [rad, deg].map(|text| read(text.as_bytes()).unwrap());
        assert_eq!((rad.scans.len(), rad.name.as_deref()), (1, Some("red paint")));
        assert_eq!(rad.scans[0].values, deg.scans[0].values);
        for (a, b) in rad.scans[0].exitant.iter().zip(&deg.scans[0].exitant) {
            assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-12));
        }
        assert!((rad.scans[0].exitant[0][0] + 10f64.to_radians().sin()).abs() < 1e-12);
    }

    #[test]
    fn columns_are_found_by_their_names() {
        // Three angles, as isotropic files of several laboratories have them, and names with spaces and commas.
        for (names, row) in [
            ("theta_i,theta_s,phi_s,Integrated [300,700]", ".5,.2,3,.25"),
            ("theta_i, phi_i, theta_s, Integrated 300 nm to 700 nm", ".5,0,.2,.25"),
            ("theta_i,theta_s,phi_s,f,", ".5,.2,3,.25,"),
        ] {
            let read = read(format!("VARS {names}\n{row}\n").as_bytes()).unwrap();
            assert_eq!(read.scans[0].values, [0.25], "{names}");
            assert!((read.scans[0].exitant[0][2] - 0.2f64.cos()).abs() < 1e-12);
            assert!(read.notes[1].contains("no azimuth of"), "{:?}", read.notes);
        }
        let read = read(b"VARS theta_i,phi_i,theta_s,465nm,525nm,630nm\n.5,0,.2,.3,.3,.3\n").unwrap();
        assert!(read.scans[0].values.iter().all(|v| (v - 0.3).abs() < 1e-3));
    }

    #[test]
    fn grey_is_grey_in_every_kind_of_channels() {
        for names in ["R,G,B", "X,Y,Z", "450nm,550nm,650nm"] {
            let text = format!("VARS theta_i,phi_i,theta_r,phi_r,{names}\n0.1,0,0.2,0,.3,.3,.3\n");
            let read = read(text.as_bytes()).unwrap();
            assert!(
                read.scans[0].values.iter().all(|v| (v - 0.3).abs() < 1e-3),
                "{names}: {:?}",
                read.scans[0].values
            );
        }
    }

    #[test]
    fn faults_are_told_by_line() {
        let head = "WAVELENGTH 0.6328\nVARS theta_i,phi_i,theta_r,phi_r,f\n";
        let good = read(format!("{head}0,0,0,0,1\n").as_bytes()).unwrap();
        assert!((good.wavelength_nm.unwrap() - 632.8).abs() < 1e-9);
        for (text, said) in [
            (format!("{head}0,0,0,1\n"), "line 3: found 4 numbers; expected 5"),
            (format!("{head}0,0,0,0,inf\n"), "line 3: found \"inf\""),
            (format!("{head}400,0,0,0,1\n"), "line 3: found a polar angle of 400°"),
            (format!("NUM_POINTS 7\n{head}0,0,0,0,1\n"), "line 1: found NUM_POINTS 7, but 1 rows"),
            ("NUM_POINTS x\n".into(), "line 1: found \"x\""),
            ("VARS theta_i,f\n".into(), "line 1: found VARS theta_i,f"),
            ("VARS theta_i,phi_i,theta_r,phi_r,a,b\n".into(), "line 1: found VARS"),
            (
                "VARS theta_i,phi_i,theta_x,phi_x,f\n".into(),
                "line 1: found VARS theta_i,phi_i,theta_x,phi_x,f",
            ),
            ("VARS theta_i,phi_i,theta_r\n".into(), "line 1: found VARS"),
            ("KEY value\n".into(), "no line VARS"),
        ] {
            let message = read(text.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(said), "{message} for {said}");
        }
    }
}
