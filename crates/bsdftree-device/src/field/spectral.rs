//! Spectra of patterns: how a colour depends on the wavelength.
//!
//! In: `spectrum` (samples at even wavelengths), `specfile` (a data file of one dimension); and, as they depend on the place,
//! `specfunc` (a function of the wavelength), `specdata` (a data file whose last dimension is the wavelength) and `specpict` (a
//! picture of spectra). Out: [`Spectral`], wavelengths and values, which multiply what a material reflects and transmits.
//! Source: Radiance's reference manual ("Patterns"). Deviation: wavelengths that a data file lists are taken as listed.

use std::sync::Arc;

use glam::DVec3;

use super::data::DataArray;
use super::formula::{Call, Formulas};
use super::hyperspectral::SpectralPicture;
use super::space::{File, RayState, Seen, Space};
use super::{FieldError, FieldProblem};

/// A factor that depends on the wavelength.
///
/// Each value is the mean over an interval around its wavelength that reaches half-way to its neighbours, and at the ends as far
/// out as in. Nothing is known outside: Radiance takes it for 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectral {
    /// Ascending \[nm\]; at least two.
    pub wavelengths_nm: Vec<f64>,
    /// One for each wavelength.
    pub values: Vec<f64>,
    /// The file they were in, if they were in one.
    pub file: Option<File>,
}

impl Spectral {
    /// From wavelengths in either order, with as many values; `None` if they are not two or more in steady order.
    pub fn new(mut wavelengths_nm: Vec<f64>, mut values: Vec<f64>) -> Option<Spectral> {
        if wavelengths_nm.first() > wavelengths_nm.last() {
            wavelengths_nm.reverse();
            values.reverse();
        }
        let ascending = wavelengths_nm.windows(2).all(|pair| pair[0] < pair[1]);
        let right = ascending && wavelengths_nm.len() >= 2 && values.len() == wavelengths_nm.len();
        right.then_some(Spectral { wavelengths_nm, values, file: None })
    }

    /// The ends of the interval that value `k` stands for \[nm\].
    pub fn interval_nm(&self, k: usize) -> [f64; 2] {
        let w = &self.wavelengths_nm;
        let n = w.len();
        let middle = |a: usize, b: usize| 0.5 * (w[a] + w[b]);
        [
            if k == 0 { w[0] - 0.5 * (w[1] - w[0]) } else { middle(k - 1, k) },
            if k == n - 1 { w[k] + 0.5 * (w[k] - w[k - 1]) } else { middle(k, k + 1) },
        ]
    }

    /// The ends of all that it says something of \[nm\].
    pub fn range_nm(&self) -> [f64; 2] {
        [self.interval_nm(0)[0], self.interval_nm(self.values.len() - 1)[1]]
    }
}

/// A spectrum that depends on the place.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralField {
    /// Coordinates and arguments.
    pub space: Arc<Space>,
    /// Where its values come from.
    pub source: SpectralSource,
}

/// Where the values of a [`SpectralField`] come from.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectralSource {
    /// `specfunc`: a function of the wavelength.
    Function {
        /// Called with a wavelength \[nm\].
        function: Call,
        /// Where it is defined, the shorter one first \[nm\].
        range_nm: [f64; 2],
    },
    /// `specdata`: data of which the last dimension is the wavelength.
    Data {
        /// Called with a value and its wavelength \[nm\].
        function: Call,
        /// Of one dimension more than there are coordinates.
        data: Arc<DataArray>,
        /// Of the other dimensions.
        coordinates: Formulas,
    },
    /// `specpict`: a picture of spectra.
    Picture {
        /// Called with a value and its wavelength \[nm\].
        function: Call,
        /// The picture.
        picture: Arc<SpectralPicture>,
        /// u and v.
        coordinates: Formulas,
    },
}

impl SpectralField {
    /// Samples of a function, one each 5 nm of the visible range.
    const SAMPLES: usize = 80;

    /// The same in a device that is turned by a rotation.
    pub fn turned(&self, turn: impl Fn(DVec3) -> DVec3) -> SpectralField {
        SpectralField { space: Arc::new(self.space.turned(turn)), source: self.source.clone() }
    }

    /// The wavelengths that it says something of, the shorter one first \[nm\].
    pub fn range_nm(&self) -> [f64; 2] {
        match &self.source {
            SpectralSource::Function { range_nm, .. } => *range_nm,
            SpectralSource::Data { data, .. } => reach(last_of(data)),
            SpectralSource::Picture { picture, .. } => reach(picture.wavelengths_nm.clone()),
        }
    }

    /// The spectrum for a ray at a surface.
    ///
    /// # Errors
    /// A function that fails, or whose value is not finite.
    pub fn at(&self, ray: &RayState) -> Result<Spectral, FieldError> {
        self.spectrum(&Seen { ray, space: &self.space }).map_err(|reason| self.space.error(reason))
    }

    fn spectrum(&self, seen: &Seen) -> Result<Spectral, FieldProblem> {
        let (wavelengths, values) = match &self.source {
            SpectralSource::Function { function, range_nm: [short, long] } => {
                let step = (long - short) / Self::SAMPLES as f64;
                let wavelengths: Vec<f64> =
                    (0..Self::SAMPLES).map(|k| short + (k as f64 + 0.5) * step).collect();
                let values = wavelengths.iter().map(|&nm| function.call(&[nm], seen));
                let values = values.collect::<Result<Vec<_>, _>>()?;
                (wavelengths, values)
            }
            SpectralSource::Data { function, data, coordinates } => {
                let mut point = [0.0; DataArray::MOST_DIMENSIONS];
                let point = &mut point[..coordinates.len()];
                coordinates.evaluate(seen, point)?;
                let wavelengths = last_of(data);
                let values = called(function, &data.along_last(point), &wavelengths, seen)?;
                (wavelengths, values)
            }
            SpectralSource::Picture { function, picture, coordinates } => {
                let mut at = [0.0; 2];
                coordinates.evaluate(seen, &mut at)?;
                let found = picture.values(at[0], at[1]);
                let values = called(function, &found, &picture.wavelengths_nm, seen)?;
                (picture.wavelengths_nm.clone(), values)
            }
        };
        Ok(Spectral::new(wavelengths, values).expect("wavelengths in steady order"))
    }
}

/// What a function makes of values and their wavelengths.
fn called(function: &Call, values: &[f64], nm: &[f64], seen: &Seen) -> Result<Vec<f64>, FieldProblem> {
    values.iter().zip(nm).map(|(&value, &nm)| function.call(&[value, nm], seen)).collect()
}

/// The last dimension.
fn last_of(data: &DataArray) -> Vec<f64> {
    let last = data.dimensions().last().expect("dimensions");
    (0..last.n()).map(|k| last.abscissa(k)).collect()
}

/// The ends of the first and the last interval.
fn reach(wavelengths_nm: Vec<f64>) -> [f64; 2] {
    let values = vec![0.0; wavelengths_nm.len()];
    Spectral::new(wavelengths_nm, values).expect("wavelengths in steady order").range_nm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stand_for_intervals_that_meet_half_way() {
        let s = Spectral::new(vec![500.0, 440.0, 410.0, 400.0], vec![4.0, 3.0, 2.0, 1.0]).unwrap();
        assert_eq!(s.values, [1.0, 2.0, 3.0, 4.0]);
        let intervals: Vec<_> = (0..4).map(|k| s.interval_nm(k)).collect();
        assert_eq!(intervals, [[395.0, 405.0], [405.0, 425.0], [425.0, 470.0], [470.0, 530.0]]);
        assert_eq!(s.range_nm(), [395.0, 530.0]);
    }

    #[test]
    fn disorder_is_refused() {
        assert_eq!(Spectral::new(vec![400.0], vec![1.0]), None);
        assert_eq!(Spectral::new(vec![400.0, 410.0, 405.0, 420.0], vec![1.0; 4]), None);
        assert_eq!(Spectral::new(vec![400.0, 410.0], vec![1.0; 3]), None);
    }
}
