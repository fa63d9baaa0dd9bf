//! Raw sheets of J&C's scatterometer RT-300S (method `BRDF_LD`).
//!
//! In: workbooks of which each column is a measurement; rows are named in the first column, `Azimuth` A, `Incidence` I, `Receive` R
//! \[degree\] and `RT` count. Out: scans by incidence and rotation of the sample, with standard errors where directions were measured
//! more than once.
//!
//! *Angles.* The light comes from I, it is mirrored to I at azimuth 0; the detector is at the polar angle R, which may be negative, and
//! the azimuth 90° + A. A file named `…stageRotation30…` had its sample turned by 30°, which turns both directions by −30° about it.
//!
//! *Values.* RT is the signal over that of a perfect diffuser that the light meets vertically, so f = RT/(π cos R) [Eq. 4.6 of M. Duque's
//! thesis, University of Arizona, as ua-loft's bsdf-tools use it]. A file with `blank` in its name was measured without a sample. If it has
//! all angles of the others it is subtracted; if not, how large it is goes into the errors. Of a coating's three mounts without their
//! blank, the mean of what comes out and its mirror image differs from what ua-loft published by at most 0.0045 in RT, which is the size of the
//! blank.
//!
//! *Shadow.* Where the detector stands in the light, |A| ≥ 60° and within 10° of where the light comes from, nothing was measured.
//!
//! *Errors.* All measurements of a direction are averaged: repeats in several files, and directions that several angles mean (A = ±90°,
//! R = 0). The variance of n of them is that of the n, moderated as if two more had scattered by the relative scatter that is the median
//! of the scan, so that three numbers that agree by chance are not taken to be exact; divided by n, plus the blank's.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use bsdftree::Direction;

use crate::measurement::{Measurement, Scan};

use super::Input;
use super::error::{Place, ReadError};
use super::text::direction_from_degrees;
use super::workbook::{self, Cell, Sheet};

/// Rows that count, by what their first cell says.
const ROWS: [&str; 4] = ["Azimuth", "Incidence", "Receive", "RT"];
/// Measurements as moderate as the median that are added to those there are.
const MODERATION: f64 = 2.0;

/// One column.
#[derive(Clone, Copy, Debug)]
struct Point {
    azimuth: f64,
    incidence: f64,
    receive: f64,
    rt: f64,
}

/// Angles in thousandths of a degree, to compare.
type Key = [i64; 3];

impl Point {
    fn key(&self) -> Key {
        [self.azimuth, self.incidence, self.receive].map(|angle| (angle * 1e3).round() as i64)
    }

    /// Whether the detector stands in the light.
    fn is_shadow(&self) -> bool {
        let side = if self.azimuth < 0.0 { -1.0 } else { 1.0 };
        self.azimuth.abs() >= 60.0 && (side * self.receive - self.incidence).abs() <= 10.0
    }
}

/// Reads all files of a sample, blanks included.
///
/// # Errors
/// If one is no such workbook, or a cell is no number.
pub(super) fn read_all(inputs: &[Input<'_>]) -> Result<Measurement, ReadError> {
    let mut blank: BTreeMap<Key, f64> = BTreeMap::new();
    let mut files = Vec::new();
    for input in inputs {
        let points = points(&input.bytes).map_err(|error| error.in_file(input.path))?;
        match stem(input.path).to_ascii_lowercase().contains("blank") {
            true => blank.extend(points.iter().map(|point| (point.key(), point.rt))),
            false => files.push((input.path, points)),
        }
    }
    if files.is_empty() {
        return Err(ReadError::file(
            "only blanks (files with \"blank\" in their names)",
            "files of a sample",
        ));
    }
    let mut measurement = Measurement { n_channels: 1, ..Measurement::default() };
    let blank_error = subtract(&mut files, &blank, &mut measurement.notes);
    measurement.scans = scans(&files, blank_error, &mut measurement.notes);
    measurement.notes.push("BRDFs are RT/(π cos R), the mirrored direction is at azimuth 90° + A = 0".into());
    Ok(measurement)
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Subtracts the blank if it has all angles. What is left of it in RT, one standard error.
fn subtract(files: &mut [(&Path, Vec<Point>)], blank: &BTreeMap<Key, f64>, notes: &mut Vec<String>) -> f64 {
    if blank.is_empty() {
        notes.push(
            "there is no blank: the instrument's own signal, some thousandths in RT, is not subtracted"
                .into(),
        );
        return 0.0;
    }
    let rms = (blank.values().map(|rt| rt * rt).sum::<f64>() / blank.len() as f64).sqrt();
    let has_all = files.iter().flat_map(|(_, points)| points).all(|point| blank.contains_key(&point.key()));
    if !has_all {
        notes.push(format!(
            "the blank lacks angles of the sample, so it is not subtracted; its size, {rms:.2e} in RT, goes into the errors"
        ));
        return rms;
    }
    for point in files.iter_mut().flat_map(|(_, points)| points) {
        point.rt -= blank[&point.key()];
    }
    notes.push("the blank is subtracted".into());
    0.0
}

/// What was measured towards one direction.
struct Direct {
    exitant: Direction,
    cosine: f64,
    rts: Vec<f64>,
}

/// Rotation and incidence, in thousandths of a degree.
type Incidence = (i64, i64);

/// Files, and directions by their place.
type Gathered<'a> = (Vec<&'a Path>, BTreeMap<[i64; 3], Direct>);

fn scans(files: &[(&Path, Vec<Point>)], blank_error: f64, notes: &mut Vec<String>) -> Vec<Scan> {
    let mut by_incidence: BTreeMap<Incidence, Gathered<'_>> = BTreeMap::new();
    let mut n_shadows = 0;
    for (path, points) in files {
        let rotation = stage_rotation(&stem(path));
        for point in points {
            if point.is_shadow() {
                n_shadows += 1;
                continue;
            }
            let key = ((rotation * 1e3).round() as i64, point.key()[1]);
            let (paths, directions) = by_incidence.entry(key).or_default();
            if !paths.contains(path) {
                paths.push(path);
            }
            let exitant = direction_from_degrees(point.receive, 90.0 + point.azimuth - rotation);
            let cell = exitant.map(|c| (c * 1e5).round() as i64);
            let cosine = exitant[2];
            directions
                .entry(cell)
                .or_insert_with(|| Direct { exitant, cosine, rts: Vec::new() })
                .rts
                .push(point.rt);
        }
    }
    if n_shadows > 0 {
        notes.push(format!("{n_shadows} values are left out, where the detector stands in the light"));
    }
    let scan = |((rotation, incidence), (paths, directions)): (Incidence, Gathered<'_>)| {
        let directions: Vec<Direct> = directions.into_values().collect();
        let azimuth = 180.0 - rotation as f64 / 1e3;
        let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        Scan {
            incident: direction_from_degrees(incidence as f64 / 1e3, azimuth),
            exitant: directions.iter().map(|d| d.exitant).collect(),
            values: directions.iter().map(|d| mean(&d.rts) / (PI * d.cosine)).collect(),
            errors: errors(&directions, blank_error),
            source: names.join(" + "),
        }
    };
    by_incidence.into_iter().map(scan).collect()
}

/// The number after `stageRotation` in a name \[degree\].
fn stage_rotation(stem: &str) -> f64 {
    const MARK: &str = "stagerotation";
    let lower = stem.to_ascii_lowercase();
    let Some(start) = lower.find(MARK) else { return 0.0 };
    let rest = &lower[start + MARK.len()..];
    let digits = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    rest[..digits].parse().ok().filter(|angle: &f64| *angle <= 360.0).unwrap_or(0.0)
}

fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// Standard errors, or none if fewer than half of the directions were measured twice.
fn errors(directions: &[Direct], blank_error: f64) -> Vec<f64> {
    let scatter = |d: &Direct| {
        let mean = mean(&d.rts);
        d.rts.iter().map(|rt| (rt - mean).powi(2)).sum::<f64>()
    };
    let repeated = directions.iter().filter(|d| d.rts.len() > 1);
    let mut relative: Vec<f64> = repeated
        .map(|d| (scatter(d) / (d.rts.len() - 1) as f64).sqrt() / mean(&d.rts).abs())
        .filter(|ratio| ratio.is_finite())
        .collect();
    if 2 * relative.len() < directions.len() {
        return Vec::new();
    }
    let middle = relative.len() / 2;
    let typical = *relative.select_nth_unstable_by(middle, f64::total_cmp).1;
    let error = |d: &Direct| {
        let n = d.rts.len() as f64;
        let variance = (scatter(d) + MODERATION * (typical * mean(&d.rts)).powi(2)) / (n - 1.0 + MODERATION);
        (variance / n + blank_error.powi(2)).sqrt() / (PI * d.cosine)
    };
    directions.iter().map(error).collect()
}

/// All columns of all sheets.
fn points(bytes: &[u8]) -> Result<Vec<Point>, ReadError> {
    let mut points = Vec::new();
    for sheet in workbook::sheets(bytes)?.iter().filter(|sheet| !sheet.cells.is_empty()) {
        add_sheet(sheet, &mut points)?;
    }
    match points.is_empty() {
        true => Err(ReadError::file("sheets without values", "columns of values of the RT-300S")),
        false => Ok(points),
    }
}

fn add_sheet(sheet: &Sheet, points: &mut Vec<Point>) -> Result<(), ReadError> {
    const N_LABELS: usize = 100;
    let is_named = |row: &usize, name: &str| matches!(sheet.cells.get(&(*row, 0)), Some(Cell::Text(text)) if text.trim() == name);
    let mut rows = [0; 4];
    for (row, name) in rows.iter_mut().zip(ROWS) {
        *row = (0..N_LABELS).find(|row| is_named(row, name)).ok_or_else(|| {
            let found = format!("no row {name:?} in sheet {:?}", sheet.name);
            ReadError::file(
                found,
                "a sheet of the RT-300S, with Azimuth, Incidence, Receive and RT in its first column",
            )
        })?;
    }
    for column in 1..sheet.n_columns {
        let number = |row: usize, limit: f64| -> Result<f64, ReadError> {
            let found = match sheet.cells.get(&(row, column)) {
                Some(Cell::Number(number)) if number.abs() <= limit => return Ok(*number),
                Some(Cell::Number(number)) => number.to_string(),
                Some(Cell::Text(text)) => format!("{text:?}"),
                None => "an empty cell".into(),
            };
            let place = Place::Cell { sheet: sheet.name.clone(), row, column };
            Err(ReadError::new(place, found, format!("a number of at most ±{limit}")))
        };
        if rows.iter().any(|&row| sheet.cells.contains_key(&(row, column))) {
            points.push(Point {
                azimuth: number(rows[0], 360.0)?,
                incidence: number(rows[1], 89.999)?,
                receive: number(rows[2], 89.999)?,
                rt: number(rows[3], 1e9)?,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_is_in_the_name() {
        for (name, angle) in
            [("IMX455_stageRotation30_20250922", 30.0), ("NiTE_on_invar", 0.0), ("stageRotation", 0.0)]
        {
            assert_eq!(stage_rotation(name), angle);
        }
    }

    fn point(azimuth: f64, receive: f64, rt: f64) -> Point {
        Point { azimuth, incidence: 30.0, receive, rt }
    }

    #[test]
    fn one_direction_by_two_angles_is_one_point() {
        let path = Path::new("x.xls");
        let files = [(path, vec![point(-90.0, 30.0, 0.3), point(90.0, -30.0, 0.5), point(0.0, 40.0, 0.1)])];
        let scans = scans(&files, 0.0, &mut Vec::new());
        let scan = &scans[0];
        assert_eq!(scan.exitant.len(), 2);
        let mirrored = [-scan.incident[0], -scan.incident[1], scan.incident[2]];
        let k = scan.exitant.iter().position(|e| (0..3).all(|c| (e[c] - mirrored[c]).abs() < 1e-9)).unwrap();
        assert!((scan.values[k] - 0.4 / (PI * 30f64.to_radians().cos())).abs() < 1e-12);
        // Half of the directions were measured twice, which is enough.
        assert_eq!(scan.errors.len(), 2);
    }

    #[test]
    fn where_the_detector_shades_is_left_out() {
        assert!(point(-90.0, -30.0, 0.0).is_shadow() && point(90.0, 30.0, 0.0).is_shadow());
        assert!(!point(-90.0, 30.0, 0.0).is_shadow() && !point(-50.0, -30.0, 0.0).is_shadow());
        assert!(!point(-60.0, -41.0, 0.0).is_shadow());
    }

    #[test]
    fn errors_follow_the_scatter_of_repeats() {
        let direct = |rts: &[f64]| Direct { exitant: [0.0, 0.0, 1.0], cosine: 1.0, rts: rts.to_vec() };
        let directions = [direct(&[1.0, 1.1, 0.9]), direct(&[2.0, 2.2, 1.8]), direct(&[1.0, 1.0, 1.0])];
        let errors = errors(&directions, 0.0);
        let expected = 0.1 / 3f64.sqrt() / PI;
        assert!((errors[0] - expected).abs() < 1e-9 && (errors[1] - 2.0 * expected).abs() < 1e-9);
        // Three equal numbers are not exact.
        assert!((errors[2] - expected * 0.5f64.sqrt()).abs() < 1e-9);
    }
}
