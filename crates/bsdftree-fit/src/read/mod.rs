//! Files of measurements, one file of code per format.
//!
//! In: paths; out: one [`Measurement`]. What a file is, is seen from its content. Common to all formats and done here: scans of one
//! incident direction become one, points on the horizon, where a BSDF has no side, are left out, and a sample that was measured from
//! the outside is turned about +Y, so that up stays up.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use bsdftree::direction::Side;

use crate::measurement::{Measurement, Scan};

mod error;
mod text;
mod pab_opto;
mod zemax;
mod fred;
mod workbook;
mod rt300s;
mod table;
mod points;
mod spectrum;
mod astm;
mod merl;
mod tensor_file;
mod rgl;
mod plausible;

pub use error::{Fault, Place, ReadError};

/// Largest file that is read \[byte\]: 2 GiB.
const MAX_BYTES: u64 = 1 << 31;
/// Incident directions nearer than this are one: squared chord of 0.005°.
const SAME_DIRECTION: f64 = 7.6e-9;
/// Cells to a unit, of which directions that are one lie in neighbouring ones.
const CELLS: f64 = 5e3;
/// Points whose |cos θ| is smaller lie on the horizon.
const HORIZON: f64 = 1e-6;

/// A format of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// pab-opto's "theta phi value" text, one incident direction a file.
    PabOpto,
    /// Zemax's tabular BSDF.
    Zemax,
    /// FRED's tabulated BSDF.
    Fred,
    /// Raw sheets of the scatterometer RT-300S.
    Rt300s,
    /// Tables of ASTM E1392.
    Astm,
    /// The MERL database's binary reflectances.
    Merl,
    /// The RGL database's tensor files.
    Rgl,
    /// A table with named columns, or columns that are told.
    Table,
}

impl Format {
    /// All of them.
    pub const ALL: [Format; 8] = [
        Format::PabOpto,
        Format::Zemax,
        Format::Fred,
        Format::Rt300s,
        Format::Astm,
        Format::Merl,
        Format::Rgl,
        Format::Table,
    ];

    /// The name by which people choose it: `pab-opto`.
    pub fn name(self) -> &'static str {
        match self {
            Format::PabOpto => "pab-opto",
            Format::Zemax => "zemax",
            Format::Fred => "fred",
            Format::Rt300s => "rt-300s",
            Format::Astm => "astm",
            Format::Merl => "merl",
            Format::Rgl => "rgl",
            Format::Table => "table",
        }
    }

    /// What a file begins with decides.
    fn of(bytes: &[u8]) -> Option<Format> {
        const ENOUGH: usize = 1 << 16;
        let text = text::decoded(&bytes[..bytes.len().min(ENOUGH)]);
        Format::ALL.into_iter().find(|format| match format {
            Format::PabOpto => pab_opto::recognizes(&text),
            Format::Zemax => zemax::recognizes(&text),
            Format::Fred => fred::recognizes(&text),
            Format::Rt300s => workbook::recognizes(bytes),
            Format::Astm => astm::recognizes(&text),
            Format::Merl => merl::recognizes(bytes),
            Format::Rgl => tensor_file::recognizes(bytes),
            Format::Table => table::recognizes(&text),
        })
    }
}

/// How to read.
#[derive(Clone, Debug)]
pub struct Options {
    /// The format; seen from the content if `None`.
    pub format: Option<Format>,
    /// What the columns of a table are, as `theta_i=NAME,theta_o=3,value=NAME`; then the files are tables.
    pub columns: Option<String>,
    /// The side of the device that was the sample's front when it was measured.
    pub side: Side,
    /// What is left out near the horizon.
    pub grazing: Option<Grazing>,
}

/// Which points near the horizon are left out, as pabopto2bsdf's `-g` does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Grazing {
    /// Those nearer to the surface than this \[degree\].
    Below(f64),
    /// Those nearer to the surface than the lowest incident direction.
    LowestIncident,
}

impl Default for Options {
    fn default() -> Options {
        Options { format: None, columns: None, side: Side::Front, grazing: None }
    }
}

/// A file in memory.
struct Input<'a> {
    path: &'a Path,
    bytes: Vec<u8>,
}

/// Reads the files of one sample.
///
/// # Errors
/// If one cannot be read, is none that is known, differs in format or colour from the others, or has no values; or if there is none.
pub fn read_files(paths: &[PathBuf], options: &Options) -> Result<Measurement, ReadError> {
    if paths.is_empty() {
        return Err(ReadError::file("no files", "one or more"));
    }
    let mut inputs = Vec::new();
    let mut format = options.format;
    if options.columns.is_some() && *format.get_or_insert(Format::Table) != Format::Table {
        return Err(ReadError::file(
            "columns for a format that is no table",
            "no columns, or the format \"table\"",
        ));
    }
    let is_given = format.is_some();
    for path in paths {
        let bytes = read_bytes(path).map_err(|error| error.in_file(path))?;
        let found = format.filter(|_| is_given).or_else(|| Format::of(&bytes)).ok_or_else(|| {
            let names = Format::ALL.map(Format::name).join(", ");
            ReadError::file(
                "no format that is known",
                format!("one of {names}; say which, or which columns of a table are what"),
            )
            .in_file(path)
        })?;
        match *format.get_or_insert(found) {
            format if format == found => {}
            format => {
                let expected = format!("{}, as {}", format.name(), paths[0].display());
                return Err(ReadError::file(found.name(), expected).in_file(path));
            }
        }
        inputs.push(Input { path, bytes });
    }
    let measurement = match format.expect("there is a file") {
        Format::PabOpto => each(&inputs, pab_opto::read)?,
        Format::Zemax => each(&inputs, zemax::read)?,
        Format::Fred => each(&inputs, fred::read)?,
        Format::Rt300s => rt300s::read_all(&inputs)?,
        Format::Astm => each(&inputs, astm::read)?,
        Format::Merl => each(&inputs, merl::read)?,
        Format::Rgl => each(&inputs, rgl::read)?,
        Format::Table => each(&inputs, |bytes| table::read(bytes, options.columns.as_deref()))?,
    };
    finished(measurement, options).map_err(|error| match paths {
        [path] => error.in_file(path),
        _ => error,
    })
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > MAX_BYTES {
        true => Err(ReadError::file("more than 2 GiB", "files of measurements, which are smaller")),
        false => Ok(bytes),
    }
}

/// All files read on their own and put together.
fn each(
    inputs: &[Input<'_>],
    read: impl Fn(&[u8]) -> Result<Measurement, ReadError>,
) -> Result<Measurement, ReadError> {
    let mut all = Measurement::default();
    for Input { path, bytes } in inputs {
        let mut one = read(bytes).map_err(|error| error.in_file(path))?;
        for scan in &mut one.scans {
            let file = path.display();
            scan.source =
                if scan.source.is_empty() { file.to_string() } else { format!("{file}: {}", scan.source) };
        }
        append(&mut all, one).map_err(|error| error.in_file(path))?;
    }
    Ok(all)
}

/// Adds the scans of another file of the sample. What the first file says of the sample stands.
fn append(all: &mut Measurement, one: Measurement) -> Result<(), ReadError> {
    if all.n_channels != 0 && all.n_channels != one.n_channels {
        let values = |n| if n == 3 { "three values (X, Y, Z) a point" } else { "one value a point" };
        return Err(ReadError::file(
            values(one.n_channels),
            format!("{}, as in the files before", values(all.n_channels)),
        ));
    }
    all.n_channels = one.n_channels;
    all.scans.extend(one.scans);
    if let (Some(a), Some(b)) = (&all.name, &one.name)
        && a != b
    {
        all.notes.push(format!("files name the sample {a:?} and {b:?}; the first name is kept"));
    }
    all.name = all.name.take().or(one.name);
    all.manufacturer = all.manufacturer.take().or(one.manufacturer);
    all.symmetry = all.symmetry.or(one.symmetry);
    all.wavelength_nm = all.wavelength_nm.or(one.wavelength_nm);
    for note in one.notes {
        if !all.notes.contains(&note) {
            all.notes.push(note);
        }
    }
    Ok(())
}

/// What is done whatever the format.
fn finished(mut measurement: Measurement, options: &Options) -> Result<Measurement, ReadError> {
    let n_left_out = leave_out_horizon(&mut measurement)?;
    if n_left_out > 0 {
        measurement
            .notes
            .push(format!("{n_left_out} points on the horizon are left out: no light leaves there"));
    }
    join_scans(&mut measurement);
    if let Some(grazing) = options.grazing {
        leave_out_grazing(&mut measurement, grazing)?;
    }
    if let Some(empty) = measurement.scans.iter().find(|scan| scan.exitant.is_empty()) {
        return Err(ReadError::file(
            format!("no values in {}", empty.source),
            "values at exitant directions",
        ));
    }
    if measurement.scans.is_empty() {
        return Err(ReadError::file("no values", "values at exitant directions"));
    }
    if options.side == Side::Back {
        measurement.turn_front_to_back();
    }
    let doubts = plausible::doubts(&measurement);
    measurement.notes.extend(doubts);
    Ok(measurement)
}

/// An angle that is too large leaves nothing of a scan, which is an error of its own.
fn leave_out_grazing(measurement: &mut Measurement, grazing: Grazing) -> Result<(), ReadError> {
    let (angle_deg, why) = match grazing {
        Grazing::Below(angle) if (0.0..90.0).contains(&angle) => (angle, ""),
        Grazing::Below(angle) => {
            let found = format!("a grazing angle of {angle}°");
            return Err(ReadError::file(found, "0 to less than 90°, from the surface"));
        }
        Grazing::LowestIncident => (measurement.lowest_incident_deg(), " (the lowest incident direction)"),
    };
    let n = measurement.leave_out_grazing(angle_deg);
    let told_deg = (1e4 * angle_deg).round() / 1e4;
    if let Some(empty) = measurement.scans.iter().find(|scan| scan.exitant.is_empty()) {
        let found = format!("no values farther than {told_deg}° from the surface in {}", empty.source);
        return Err(ReadError::file(found, "a smaller grazing angle"));
    }
    measurement.notes.push(format!("{n} points nearer to the surface than {told_deg}°{why} are left out"));
    Ok(())
}

fn leave_out_horizon(measurement: &mut Measurement) -> Result<usize, ReadError> {
    let n = measurement.n_channels;
    let mut n_left_out = 0;
    for scan in &mut measurement.scans {
        if scan.incident[2].abs() < HORIZON {
            let found = format!("light that comes along the surface in {}", scan.source);
            return Err(ReadError::file(found, "an incident polar angle other than 90°"));
        }
        n_left_out += scan.retain(n, |exitant| exitant[2].abs() >= HORIZON);
    }
    Ok(n_left_out)
}

/// Makes scans of one incident direction one. Errors that only some of them have are dropped.
fn join_scans(measurement: &mut Measurement) {
    let mut joined: Vec<Scan> = Vec::new();
    let mut by_cell: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for scan in measurement.scans.drain(..) {
        let is_same = |other: &Scan| {
            (0..3).map(|k| (other.incident[k] - scan.incident[k]).powi(2)).sum::<f64>() < SAME_DIRECTION
        };
        let cell = scan.incident.map(|c| (c * CELLS).round() as i64);
        let around = (0..27).filter_map(|k| {
            by_cell.get(&[cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1])
        });
        match around.flatten().copied().find(|&k| is_same(&joined[k])) {
            Some(k) => join(&mut joined[k], scan),
            None => {
                by_cell.entry(cell).or_default().push(joined.len());
                joined.push(scan);
            }
        }
    }
    measurement.scans = joined;
}

fn join(one: &mut Scan, other: Scan) {
    let have_errors = [&*one, &other].iter().all(|scan| scan.errors.len() == scan.values.len());
    one.errors.extend(other.errors);
    if !have_errors {
        one.errors.clear();
    }
    one.exitant.extend(other.exitant);
    one.values.extend(other.values);
    // What many files say may be long.
    if one.source != other.source && one.source.len() < 1000 {
        one.source = format!("{} + {}", one.source, other.source);
    }
}
