//! Tables with named columns (CSV), one row for each pair of directions.
//!
//! In: text with commas, semicolons or tabs, with or without a header, and what its columns are: `theta_i=INC,phi_i=2,…,value=BSDF`,
//! by name or by number from 1. Out: a scan for each incident direction.
//!
//! Columns: `theta_i`, `phi_i` (0 if absent), `theta_o`, `phi_o` (0 if absent), or the vectors `x_i y_i z_i`, `x_o y_o z_o`, all away from
//! the sample; `value`, or `X`, `Y` and `Z`; `error`, or `error_X`, `error_Y` and `error_Z`. Settings beside them: `angles=deg|rad`,
//! `values=bsdf|dsf` (a DSF has the cosine of the exitant direction in it), `percent=yes` (values are hundredths). A header whose names
//! are these needs no list.

use std::collections::HashMap;

use bsdftree::Direction;
use bsdftree::direction::normalized;

use crate::measurement::{Measurement, Scan};

use super::error::ReadError;
use super::text::{self, decoded};

/// Names of columns.
const NAMES: [&str; 18] = [
    "theta_i", "phi_i", "theta_o", "phi_o", "x_i", "y_i", "z_i", "x_o", "y_o", "z_o", "value", "X", "Y", "Z",
    "error", "error_X", "error_Y", "error_Z",
];

/// What people say of the columns.
#[derive(Clone, Debug, Default)]
struct Request {
    /// Names or numbers in the file, by ours.
    columns: HashMap<&'static str, String>,
    is_rad: bool,
    is_dsf: bool,
    is_percent: bool,
}

/// Where columns are, from 0.
struct Layout {
    incident: Vector,
    exitant: Vector,
    values: Vec<usize>,
    errors: Vec<usize>,
}

enum Vector {
    Polar { theta: usize, phi: Option<usize> },
    Cartesian([usize; 3]),
}

/// Whether the first line names columns as we do.
pub(super) fn recognizes(text: &str) -> bool {
    let first =
        text::lines(text).map(|(_, line)| line).find(|line| !line.is_empty() && !line.starts_with('#'));
    let names: Vec<&str> =
        first.into_iter().flat_map(|line| line.split([',', ';', '\t'])).map(str::trim).collect();
    let has = |name: &str| names.contains(&name);
    (has("theta_i") || has("x_i")) && (has("theta_o") || has("x_o")) && (has("value") || has("Y"))
}

/// Reads a file. `columns` as in the head of this module; `None` if its header is in our words.
///
/// # Errors
/// If columns are missing, or a field is no number.
pub(super) fn read(bytes: &[u8], columns: Option<&str>) -> Result<Measurement, ReadError> {
    let request = columns.map_or_else(|| Ok(Request::default()), Request::parse)?;
    let text = decoded(bytes);
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter(&text))
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .has_headers(false)
        .flexible(true)
        .from_reader(text.as_bytes());
    let mut layout = None;
    let mut scans: Vec<Scan> = Vec::new();
    let mut by_incident: HashMap<[u64; 3], usize> = HashMap::new();
    let (mut n_channels, mut width) = (1, 0);
    for record in reader.records() {
        let record =
            record.map_err(|error| ReadError::file(error.to_string(), "a table with separated columns"))?;
        let line = record.position().map_or(0, |position| position.line() as usize);
        if record.iter().all(str::is_empty) {
            continue;
        }
        let layout = match &layout {
            Some(layout) => layout,
            None => {
                let (found, is_header) =
                    Layout::find(&record, &request).map_err(|why| ReadError::line(line, why, EXPECTED))?;
                (n_channels, width) = (found.values.len(), record.len());
                layout = Some(found);
                if is_header {
                    continue;
                }
                layout.as_ref().expect("just found")
            }
        };
        if record.len() != width {
            let found = format!("{} columns", record.len());
            return Err(ReadError::line(line, found, format!("{width}, as in the first line")));
        }
        let number = |column: usize| {
            text::number(line, &record[column], &format!("a number in column {}", column + 1))
        };
        let incident = layout.incident.direction(line, &request, &number)?;
        let exitant = layout.exitant.direction(line, &request, &number)?;
        let k = *by_incident.entry(incident.map(f64::to_bits)).or_insert_with(|| {
            scans.push(Scan { incident, ..Scan::default() });
            scans.len() - 1
        });
        let scan = &mut scans[k];
        let factor = request.factor(exitant);
        scan.exitant.push(exitant);
        for &column in &layout.values {
            scan.values.push(number(column)? * factor);
        }
        for &column in &layout.errors {
            let error = number(column)? * factor;
            if error < 0.0 {
                return Err(ReadError::line(line, format!("an error of {error}"), "0 or more"));
            }
            scan.errors.push(error);
        }
    }
    Ok(Measurement { n_channels, scans, ..Measurement::default() })
}

const EXPECTED: &str = "columns theta_i, theta_o and value (and phi_i, phi_o, error; or x_i …, X Y Z); \
    say which they are: columns=theta_i=NAME,phi_i=NAME,theta_o=NAME,phi_o=NAME,value=NAME, names or numbers from 1";

/// What separates columns in the first line that has any.
fn delimiter(text: &str) -> u8 {
    let line =
        text::lines(text).map(|(_, line)| line).find(|line| !line.is_empty() && !line.starts_with('#'));
    let line = line.unwrap_or("");
    [b'\t', b';', b','].into_iter().find(|&mark| line.as_bytes().contains(&mark)).unwrap_or(b' ')
}

impl Request {
    fn parse(text: &str) -> Result<Request, ReadError> {
        let mut request = Request::default();
        let wrong = |word: &str| ReadError::file(format!("{word:?} in the list of columns"), EXPECTED);
        for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
            let (name, column) = word.split_once('=').ok_or_else(|| wrong(word))?;
            match (name.trim(), column.trim()) {
                ("angles", "deg") | ("values", "bsdf") | ("percent", "no") => {}
                ("angles", "rad") => request.is_rad = true,
                ("values", "dsf") => request.is_dsf = true,
                ("percent", "yes") => request.is_percent = true,
                (name, column) => {
                    let name = NAMES.into_iter().find(|&known| known == name).ok_or_else(|| wrong(word))?;
                    request.columns.insert(name, column.to_owned());
                }
            }
        }
        Ok(request)
    }

    /// What makes a BSDF of a value.
    fn factor(&self, exitant: Direction) -> f64 {
        let percent = if self.is_percent { 0.01 } else { 1.0 };
        // What lies on the horizon is left out later.
        if self.is_dsf && exitant[2] != 0.0 { percent / exitant[2].abs() } else { percent }
    }
}

impl Layout {
    /// From the first line and what was asked for; whether that line is a header.
    fn find(first: &csv::StringRecord, request: &Request) -> Result<(Layout, bool), String> {
        let is_header = first.iter().any(|field| fast_float2::parse::<f64, _>(field).is_err());
        let column = |name: &'static str| -> Result<Option<usize>, String> {
            let (wanted, is_asked) = match request.columns.get(name) {
                Some(wanted) => (wanted.as_str(), true),
                None => (name, false),
            };
            let found = first.iter().position(|field| is_header && field == wanted);
            // Numbers are names too, where a header has them.
            let number = wanted.parse::<usize>().ok().filter(|k| is_asked && (1..=first.len()).contains(k));
            match found.or(number.map(|k| k - 1)) {
                None if is_asked => Err(format!("no column {wanted:?} among {}", fields(first))),
                found => Ok(found),
            }
        };
        let missing = |what: &str| format!("no column {what} among {}", fields(first));
        let all = |names: [&'static str; 3]| -> Result<Option<[usize; 3]>, String> {
            let found = [column(names[0])?, column(names[1])?, column(names[2])?];
            Ok(if let [Some(a), Some(b), Some(c)] = found { Some([a, b, c]) } else { None })
        };
        let vector = |theta, phi, xyz: [&'static str; 3]| -> Result<Vector, String> {
            match (column(theta)?, all(xyz)?) {
                (Some(theta), _) => Ok(Vector::Polar { theta, phi: column(phi)? }),
                (None, Some(columns)) => Ok(Vector::Cartesian(columns)),
                (None, None) => Err(missing(theta)),
            }
        };
        let numbers = |one, three: [&'static str; 3]| -> Result<Vec<usize>, String> {
            Ok(match (column(one)?, all(three)?) {
                (Some(one), _) => vec![one],
                (None, three) => three.map(Vec::from).unwrap_or_default(),
            })
        };
        let layout = Layout {
            incident: vector("theta_i", "phi_i", ["x_i", "y_i", "z_i"])?,
            exitant: vector("theta_o", "phi_o", ["x_o", "y_o", "z_o"])?,
            values: numbers("value", ["X", "Y", "Z"])?,
            errors: numbers("error", ["error_X", "error_Y", "error_Z"])?,
        };
        if layout.values.is_empty() {
            return Err(missing("value"));
        }
        if !layout.errors.is_empty() && layout.errors.len() != layout.values.len() {
            return Err(format!("{} values and {} errors", layout.values.len(), layout.errors.len()));
        }
        Ok((layout, is_header))
    }
}

fn fields(record: &csv::StringRecord) -> String {
    record.iter().map(|field| format!("{field:?}")).collect::<Vec<_>>().join(", ")
}

impl Vector {
    fn direction(
        &self,
        line: usize,
        request: &Request,
        number: &impl Fn(usize) -> Result<f64, ReadError>,
    ) -> Result<Direction, ReadError> {
        match *self {
            Vector::Polar { theta, phi } => {
                let degree = if request.is_rad { 1f64.to_degrees() } else { 1.0 };
                let phi = phi.map_or(Ok(0.0), number)?;
                text::direction(line, number(theta)? * degree, phi * degree)
            }
            Vector::Cartesian([x, y, z]) => {
                let v = [number(x)?, number(y)?, number(z)?];
                normalized(v)
                    .ok_or_else(|| ReadError::line(line, format!("{v:?}"), "a vector that has a direction"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name_and_number() {
        let by_name = "# a comment\nphi_o;theta_i;theta_o;value;error\n90;30;10;0.5;0.1\n0;30;20;0.25;0.1\n0;40;20;0.25;.2\n";
        let by_number = "90,30,10,0.5,0.1\n0,30,20,0.25,0.1\n0,40,20,0.25,.2\n";
        let named = read(by_name.as_bytes(), None).unwrap();
        let numbered =
            read(by_number.as_bytes(), Some("theta_i=2,theta_o=3,phi_o=1,value=4,error=5")).unwrap();
        assert_eq!(named, numbered);
        assert!(recognizes(by_name) && !recognizes(by_number));
        assert_eq!(named.scans.len(), 2);
        assert_eq!(
            (&named.scans[0].values[..], &named.scans[0].errors[..]),
            (&[0.5, 0.25][..], &[0.1, 0.1][..])
        );
    }

    #[test]
    fn units_are_asked_for() {
        let text = "ti\tto\tX\tY\tZ\n0\t1.0471975511965976\t1\t2\t3\n";
        let columns = "theta_i=ti,theta_o=to,angles=rad,values=dsf,percent=yes";
        let read = read(text.as_bytes(), Some(columns)).unwrap();
        assert_eq!(read.n_channels, 3);
        assert!(read.scans[0].values.iter().zip([0.02, 0.04, 0.06]).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn vectors_need_not_be_of_unit_length() {
        let read = read(b"x_i,y_i,z_i,x_o,y_o,z_o,value\n0,0,2,3,0,-4,1\n", None).unwrap();
        assert_eq!((read.scans[0].incident, read.scans[0].exitant[0]), ([0.0, 0.0, 1.0], [0.6, 0.0, -0.8]));
    }

    #[test]
    fn faults_are_told_by_line() {
        let head = "theta_i,theta_o,value\n";
        for (text, columns, said) in [
            (format!("{head}1,2\n"), None, "line 2: found 2 columns; expected 3"),
            (format!("{head}1,2,3\n1,x,3\n"), None, "line 3: found \"x\"; expected a number in column 2"),
            (format!("{head}1,200,3\n"), None, "line 2: found a polar angle of 200°"),
            ("a,b,c\n1,2,3\n".into(), None, "line 1: found no column theta_i among \"a\", \"b\", \"c\""),
            ("1,2,3\n".into(), Some("theta_i=1,theta_o=2"), "no column value"),
            ("1,2,3\n".into(), Some("theta_i=1,theta_o=2,value=4"), "no column \"4\""),
            ("1,2,3\n".into(), Some("theta_i=1,theta_o=2,height=3"), "\"height=3\" in the list"),
            ("x_i,y_i,z_i,theta_o,value\n0,0,0,1,1\n".into(), None, "a vector that has a direction"),
            ("theta_i,theta_o,value,error\n0,0,1,-1\n".into(), None, "line 2: found an error of -1"),
        ] {
            let message = read(text.as_bytes(), columns).unwrap_err().to_string();
            assert!(message.contains(said), "{message} for {said}");
        }
    }
}
