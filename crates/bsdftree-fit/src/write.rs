//! Measurements as pab-opto's text, which Radiance's pabopto2bsdf takes.
//!
//! In: a [`Measurement`]. Out: files, one for each part of each scan, since pabopto2bsdf takes one part in a run. Angles and values
//! are written to the last bit; azimuths are ours (`#upphi 90`). `#symmetry` and `#wavelength_nm` are for ourselves: Radiance skips them.
//! Errors and notes have no place in the format, and are left out.

use std::fmt::Write;

use bsdftree::direction::Side;
use bsdftree::{Direction, Part};

use crate::measurement::{Measurement, Scan};

/// A file to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextFile {
    /// Its name: part, and angles of the incident direction.
    pub name: String,
    /// What is in it.
    pub text: String,
}

/// All files of a measurement.
pub fn pab_opto(measurement: &Measurement) -> Vec<TextFile> {
    let mut files: Vec<TextFile> = Vec::new();
    for (k, scan) in measurement.scans.iter().enumerate() {
        for part in Part::ALL {
            let points: Vec<usize> =
                (0..scan.exitant.len()).filter(|&o| part == part_of(scan, scan.exitant[o])).collect();
            if points.is_empty() {
                continue;
            }
            let [theta, phi] = degrees(scan.incident);
            let mut name = format!("{}_{theta:.2}_{phi:.2}.txt", part.key());
            if files.iter().any(|file| file.name == name) {
                name = format!("{}_{theta:.2}_{phi:.2}_{k}.txt", part.key());
            }
            files.push(TextFile { name, text: text(measurement, scan, &points) });
        }
    }
    files
}

fn part_of(scan: &Scan, exitant: Direction) -> Part {
    Part::between(Side::of(scan.incident), Side::of(exitant))
}

fn text(measurement: &Measurement, scan: &Scan, points: &[usize]) -> String {
    let mut text = String::new();
    // A line of the header ends at its quote.
    let name = measurement.name.as_deref().unwrap_or("").replace(['"', '\n', '\r'], " ");
    if !name.is_empty() {
        let _ = writeln!(text, "#sample_name \"{name}\"");
    }
    if let Some(symmetry) = measurement.symmetry {
        let _ = writeln!(text, "#symmetry {}", symmetry.name());
    }
    if let Some(nm) = measurement.wavelength_nm {
        let _ = writeln!(text, "#wavelength_nm {nm}");
    }
    let n = measurement.n_channels;
    let [theta, phi] = degrees(scan.incident);
    let colorimetry = if n == 3 { "CIE-XYZ" } else { "CIE-Y" };
    let _ = write!(
        text,
        "#format: theta phi BSDF\n#colorimetry: {colorimetry}\n#upphi 90\n#intheta {theta}\n#inphi {phi}\n"
    );
    for &k in points {
        let [theta, phi] = degrees(scan.exitant[k]);
        let _ = write!(text, "{theta}\t{phi}");
        for value in &scan.values[n * k..n * (k + 1)] {
            let _ = write!(text, "\t{value:?}");
        }
        text.push('\n');
    }
    text
}

/// Polar angle and azimuth in \[0, 360) \[degree\].
pub(crate) fn degrees([x, y, z]: Direction) -> [f64; 2] {
    let phi = y.atan2(x).to_degrees();
    // What is added to a tiny negative angle may come out as 360.
    let phi = if phi < 0.0 { (phi + 360.0) % 360.0 } else { phi };
    [x.hypot(y).atan2(z).to_degrees(), phi]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::{Options, read_files};
    use bsdftree::direction::direction_from_polar;

    #[test]
    fn what_is_written_is_read() {
        let direction = |k: usize| {
            let k = k as f64;
            direction_from_polar((0.37 + 0.71 * k) % 3.1, (2.9 * k) % 6.2)
        };
        let scan = |k: usize| Scan {
            incident: direction(40 * k + 1),
            exitant: (0..40).map(|o| direction(40 * k + o)).collect(),
            values: (0..120).map(|v| (f64::from(v) - 20.0) * 1.7e-7 * 10f64.powi(v % 9)).collect(),
            ..Scan::default()
        };
        let written = Measurement {
            n_channels: 3,
            scans: (0..4).map(scan).collect(),
            name: Some("a sample".into()),
            symmetry: Some(crate::Symmetry::Quadrilateral),
            wavelength_nm: Some(650.25),
            ..Measurement::default()
        };
        let folder = tempfile::tempdir().unwrap();
        let mut paths = Vec::new();
        for file in pab_opto(&written) {
            paths.push(folder.path().join(file.name));
            std::fs::write(paths.last().unwrap(), file.text).unwrap();
        }
        let read = read_files(&paths, &Options::default()).unwrap();
        assert_eq!((read.n_channels, &read.name, read.scans.len()), (3, &written.name, 4));
        assert_eq!((read.symmetry, read.wavelength_nm), (written.symmetry, written.wavelength_nm));
        for (a, b) in read.scans.iter().zip(&written.scans) {
            for (k, o) in b.exitant.iter().enumerate() {
                // The order of points is that of the parts.
                let near = |p: &Direction| (0..3).all(|c| (p[c] - o[c]).abs() < 1e-14);
                let found = a.exitant.iter().position(near).unwrap();
                assert_eq!(a.values[3 * found..3 * found + 3], b.values[3 * k..3 * k + 3]);
            }
        }
    }
}
