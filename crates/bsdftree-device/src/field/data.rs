//! Data files: numbers on a grid of up to five dimensions, interpolated.
//!
//! In: text of Radiance's data format: the number of dimensions; for each its first and last abscissa and how many there
//! are, or `0 0 n` and n abscissas in steady order; then the values, the last dimension fastest. `#` begins a comment.
//! Out: a value at any point. Between abscissas it is linear; outside it goes on linearly for one interval and
//! farther on falls off as one over the distance, as in Radiance (with its step at the upper end, where it is suddenly a
//! third). Source: Radiance's reference manual ("Data files").

use std::fmt;
use std::sync::Arc;

use super::space::File;
use crate::error::{DeviceError, Place};

/// Most values of an array.
const MOST_VALUES: usize = 1 << 27;

/// Numbers on a grid.
#[derive(Clone)]
pub struct DataArray {
    /// Where they come from.
    pub file: File,
    dimensions: Vec<Dimension>,
    values: Vec<f64>,
}

/// The abscissas of one dimension, at least two.
#[derive(Clone, Debug, PartialEq)]
pub enum Dimension {
    /// From the first to the last in equal steps.
    Even {
        /// First and last.
        ends: [f64; 2],
        /// How many.
        n: usize,
    },
    /// In steady order, up or down.
    Listed(Vec<f64>),
}

impl Dimension {
    /// How many abscissas there are.
    pub fn n(&self) -> usize {
        match self {
            Dimension::Even { n, .. } => *n,
            Dimension::Listed(abscissas) => abscissas.len(),
        }
    }

    /// Abscissa `k`.
    pub fn abscissa(&self, k: usize) -> f64 {
        match self {
            Dimension::Even { ends: [first, last], n } => {
                first + (last - first) * (k as f64 / (n - 1) as f64)
            }
            Dimension::Listed(abscissas) => abscissas[k],
        }
    }

    /// The interval to interpolate in, by its lower end, and the weights of its two ends.
    pub(super) fn weights(&self, x: f64) -> (usize, [f64; 2]) {
        let last = self.n() - 2;
        let (i, at) = match self {
            Dimension::Even { ends: [first, end], n } => {
                let at = (x - first) / (end - first) * (*n - 1) as f64;
                // The cast goes to 0 for negative numbers and for those that are none.
                ((at as usize).min(last), at)
            }
            Dimension::Listed(p) => {
                let up = p[1] > p[0];
                let i = p.partition_point(|&a| if up { a <= x } else { a > x }).saturating_sub(1).min(last);
                (i, i as f64 + (x - p[i]) / (p[i + 1] - p[i]))
            }
        };
        let beyond = at - i as f64;
        let weights = if beyond > 2.0 {
            let fall = 1.0 / (1.0 + beyond);
            [-fall, 2.0 * fall]
        } else if beyond < -1.0 {
            let fall = -1.0 / beyond;
            [2.0 * fall, -fall]
        } else {
            [1.0 - beyond, beyond]
        };
        (i, weights)
    }
}

impl DataArray {
    /// Most dimensions, as in Radiance.
    pub const MOST_DIMENSIONS: usize = 5;

    /// Reads the text of a data file.
    ///
    /// # Errors
    /// [`DeviceError::Unexpected`] with the line, if the text is not of the format.
    pub fn parse(text: &str, file: File) -> Result<DataArray, DeviceError> {
        Numbers { rest: text, line: 1, file: &file.path }.array(&file)
    }

    /// The dimensions, the last of which varies fastest.
    pub fn dimensions(&self) -> &[Dimension] {
        &self.dimensions
    }

    /// All values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The value at a point, which has a coordinate for each dimension.
    ///
    /// ```
    /// use bsdftree_device::field::{DataArray, File};
    /// let file = File { path: "ramp.dat".into(), digest: 0 };
    /// let ramp = DataArray::parse("1  0 2 3  # a ramp\n 5 6 8", file)?;
    /// assert_eq!(ramp.value(&[1.5]), 7.0);
    /// assert_eq!(ramp.value(&[3.0]), 10.0); // one interval outside
    /// assert_eq!(ramp.value(&[4.0]), 2.5);  // farther outside it falls off
    /// # Ok::<(), bsdftree_device::DeviceError>(())
    /// ```
    pub fn value(&self, point: &[f64]) -> f64 {
        let mut sum = 0.0;
        corners(&self.dimensions, point, |index, weight| sum += weight * self.values[index]);
        sum
    }

    /// The values along the last of two or more dimensions, at a point that has a coordinate for each of the others.
    pub fn along_last(&self, point: &[f64]) -> Vec<f64> {
        let (last, others) = self.dimensions.split_last().expect("dimensions");
        let mut sums = vec![0.0; last.n()];
        corners(others, point, |index, weight| {
            for (sum, value) in sums.iter_mut().zip(&self.values[index * last.n()..]) {
                *sum += weight * value;
            }
        });
        sums
    }
}

/// Tells all corners of the cell that a point is in, and what they count; those that do not count may hold no number.
fn corners(dimensions: &[Dimension], point: &[f64], mut tell: impl FnMut(usize, f64)) {
    debug_assert_eq!(point.len(), dimensions.len());
    let mut cells = [(0, [0.0; 2]); DataArray::MOST_DIMENSIONS];
    for ((cell, dimension), &x) in cells.iter_mut().zip(dimensions).zip(point) {
        *cell = dimension.weights(x);
    }
    let cells = &cells[..dimensions.len()];
    for corner in 0..1_usize << cells.len() {
        let (mut index, mut weight) = (0, 1.0);
        for (k, (dimension, (i, weights))) in dimensions.iter().zip(cells).enumerate() {
            let upper = corner >> k & 1;
            index = index * dimension.n() + i + upper;
            weight *= weights[upper];
        }
        if weight != 0.0 {
            tell(index, weight);
        }
    }
}

impl PartialEq for DataArray {
    fn eq(&self, other: &DataArray) -> bool {
        (&self.dimensions, &self.values) == (&other.dimensions, &other.values)
    }
}

impl fmt::Debug for DataArray {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DataArray({:016x})", self.file.digest)
    }
}

/// Words of a data file.
struct Numbers<'a> {
    rest: &'a str,
    line: u32,
    file: &'a Arc<str>,
}

impl<'a> Numbers<'a> {
    fn array(mut self, file: &File) -> Result<DataArray, DeviceError> {
        let n_dimensions = self.count("the number of dimensions, 1 to 5", 1..=DataArray::MOST_DIMENSIONS)?;
        let mut dimensions = Vec::new();
        let mut n_values: usize = 1;
        for _ in 0..n_dimensions {
            let ends = [self.number("the first abscissa")?, self.number("the last abscissa")?];
            let n = self.count("the number of abscissas, at least 2", 2..=MOST_VALUES)?;
            n_values = n_values.saturating_mul(n);
            // Each value takes two bytes at least, but for the last.
            if n_values > MOST_VALUES || n_values > self.rest.len() {
                let expected = format!("{n_values} values for these dimensions");
                return Err(self.unexpected(&expected, "the file too short for them".into()));
            }
            dimensions.push(if ends[0] == ends[1] { self.listed(n)? } else { Dimension::Even { ends, n } });
        }
        let mut values = Vec::with_capacity(n_values);
        for k in 1..=n_values {
            values.push(self.number_of(|| format!("value {k} of {n_values}"))?);
        }
        Ok(DataArray { file: file.clone(), dimensions, values })
    }

    fn listed(&mut self, n: usize) -> Result<Dimension, DeviceError> {
        let mut abscissas = Vec::with_capacity(n.min(self.rest.len()));
        for k in 1..=n {
            let x = self.number_of(|| format!("abscissa {k} of {n}"))?;
            if let [.., before] = abscissas[..]
                && (x == before || (x > before) != (abscissas.get(1).unwrap_or(&x) > &abscissas[0]))
            {
                return Err(
                    self.unexpected("abscissas that all go up or all go down", format!("{x} after {before}"))
                );
            }
            abscissas.push(x);
        }
        Ok(Dimension::Listed(abscissas))
    }

    fn count(
        &mut self,
        expected: &str,
        range: std::ops::RangeInclusive<usize>,
    ) -> Result<usize, DeviceError> {
        match self.word() {
            Some(word) => match word.parse() {
                Ok(n) if range.contains(&n) => Ok(n),
                _ => Err(self.unexpected(expected, format!("'{}'", shortened(word)))),
            },
            None => Err(self.unexpected(expected, "the end of the file".into())),
        }
    }

    fn number(&mut self, expected: &str) -> Result<f64, DeviceError> {
        self.number_of(|| expected.to_owned())
    }

    fn number_of(&mut self, expected: impl Fn() -> String) -> Result<f64, DeviceError> {
        match self.word() {
            Some(word) => {
                match word.parse::<f64>() {
                    Ok(x) if x.is_finite() => Ok(x),
                    _ => Err(self
                        .unexpected(&format!("{}, a number", expected()), format!("'{}'", shortened(word)))),
                }
            }
            None => Err(self.unexpected(&expected(), "the end of the file".into())),
        }
    }

    fn word(&mut self) -> Option<&'a str> {
        loop {
            let start = self.rest.find(|c: char| !c.is_ascii_whitespace())?;
            self.line += self.rest[..start].bytes().filter(|&b| b == b'\n').count() as u32;
            self.rest = &self.rest[start..];
            if !self.rest.starts_with('#') {
                break;
            }
            self.rest = &self.rest[self.rest.find('\n').unwrap_or(self.rest.len())..];
        }
        let end = self.rest.find(|c: char| c.is_ascii_whitespace() || c == '#').unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        Some(word)
    }

    fn unexpected(&self, expected: &str, found: String) -> DeviceError {
        DeviceError::Unexpected {
            at: Place { file: self.file.clone(), line: self.line },
            expected: expected.to_owned(),
            found,
            advice: "a data file is the number of dimensions, 'first last count' for each, and the values"
                .into(),
        }
    }
}

fn shortened(word: &str) -> String {
    word.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(text: &str) -> DataArray {
        DataArray::parse(text, File { path: "a.dat".into(), digest: 0 }).unwrap()
    }

    fn error(text: &str) -> String {
        DataArray::parse(text, File { path: "a.dat".into(), digest: 0 }).unwrap_err().to_string()
    }

    #[test]
    fn the_last_dimension_varies_fastest() {
        let a = array("2\n0 1 2\n0 2 3\n0 1 2\n10 11 12");
        assert_eq!([a.value(&[0.0, 2.0]), a.value(&[1.0, 0.0]), a.value(&[0.5, 1.5])], [2.0, 10.0, 6.5]);
    }

    #[test]
    fn three_dimensions_interpolate_a_trilinear_function_exactly() {
        let f = |x: f64, y: f64, z: f64| 1.0 + x - 2.0 * y + 0.5 * z + x * y * z;
        let mut text = "3\n0 2 3\n-1 1 2\n0 0 3 1 2 5\n".to_owned();
        for x in [0.0, 1.0, 2.0] {
            for y in [-1.0, 1.0] {
                for z in [1.0, 2.0, 5.0] {
                    text += &format!("{} ", f(x, y, z));
                }
            }
        }
        let a = array(&text);
        // Inside, and up to one interval outside, where it goes on as it is.
        for p in [[0.3, -0.2, 1.7], [1.9, 0.9, 4.2], [-0.5, 2.5, 6.0]] {
            assert!((a.value(&p) - f(p[0], p[1], p[2])).abs() < 1e-12, "{p:?}");
        }
    }

    #[test]
    fn downward_abscissas_give_the_same_as_upward_ones() {
        let (up, down) = (array("1 0 0 4 0 1 3 7 5 6 7 9"), array("1 0 0 4 7 3 1 0 9 7 6 5"));
        let (even_up, even_down) = (array("1 0 3 4 5 6 7 9"), array("1 3 0 4 9 7 6 5"));
        // Farther out the upper end has a step that the lower end has not.
        for k in -10..40 {
            let x = f64::from(k) * 0.1 + 0.01;
            assert!((up.value(&[x]) - down.value(&[x])).abs() < 1e-12, "{x}");
            assert!((even_up.value(&[x]) - even_down.value(&[x])).abs() < 1e-12, "{x}");
        }
    }

    /// Values that Radiance 6.0's rtrace gives for a brightdata pattern.
    #[test]
    fn outside_the_data_radiance_is_followed() {
        for text in ["1 0 2 3 5 6 8", "1 0 0 3 0 1 2 5 6 8"] {
            let a = array(text);
            for (x, expected) in [
                (-6.0, 0.6666667),
                (-2.0, 2.0),
                (-1.01, 3.960396),
                (-0.99, 4.01),
                (2.99, 9.98),
                (3.01, 3.322259),
                (6.0, 1.666667),
            ] {
                assert!((a.value(&[x]) - expected).abs() < 1e-6, "{text}: {x}");
            }
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, expected) in [
            ("", "a.dat:1: expected the number of dimensions, 1 to 5, found the end of the file"),
            ("6", "a.dat:1: expected the number of dimensions, 1 to 5, found '6'"),
            ("1\n0 1 1\n5", "a.dat:2: expected the number of abscissas, at least 2, found '1'"),
            ("1 # one\n0 1 3\n1 2 x", "a.dat:3: expected value 3 of 3, a number, found 'x'"),
            ("1\n0 1 3\n1 2   ", "a.dat:3: expected value 3 of 3, found the end of the file"),
            (
                "1\n0 0 3 0 2 1\n1 2 3",
                "a.dat:2: expected abscissas that all go up or all go down, found 1 after 2",
            ),
            (
                "1\n0 0 3 0 0 1\n1 2 3",
                "a.dat:2: expected abscissas that all go up or all go down, found 0 after 0",
            ),
            ("2\n0 1 1000000\n0 1 1000000\n1", "a.dat:2: expected 1000000 values"),
            ("1\n0 1 100000000\n1", "a.dat:2: expected 100000000 values"),
        ] {
            let found = error(text);
            assert!(found.starts_with(expected), "{found}");
        }
    }
}
