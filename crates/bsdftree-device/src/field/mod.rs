//! What varies over a surface: numbers that functions, data files and pictures give at a place.
//!
//! In: what a ray knows of its meeting with a surface ([`RayState`], in the device's coordinates). Out: one number or three
//! ([`Field`]), a spectrum ([`SpectralField`]), or which modifier failed and why ([`FieldError`]). Patterns, textures, mixtures and materials of
//! Radiance are made of fields.
//!
//! Functions see their own coordinates ([`Space`]): those of the scene file that names them, with its unit, moved by the
//! transformation after the function file and by every `xform` around it; as in Radiance.
//! Source: Radiance's reference manual, and its `rcalc` for what functions can do ([`cal`](crate::cal)).

mod data;
mod formula;
mod hyperspectral;
mod lobe;
mod picture;
mod raster;
mod space;
mod spectral;
mod text;

pub use data::{DataArray, Dimension};
pub use formula::{Call, Formulas};
pub use hyperspectral::SpectralPicture;
pub use lobe::LobeFunction;
pub use picture::Picture;
pub use space::{File, Origin, RayState, Space};
pub use spectral::{Spectral, SpectralField, SpectralSource};
pub use text::{Font, Text, Words};

use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use crate::cal::CalError;
use space::Seen;

/// A field that could not be worked out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{origin}: {reason}")]
pub struct FieldError {
    /// The modifier.
    pub origin: Origin,
    /// What is wrong.
    pub reason: FieldProblem,
}

/// What is wrong with a value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FieldProblem {
    /// In a function, with its file and line.
    #[error("{0}")]
    Function(#[from] CalError),
    /// A division by 0, a root of a negative number and the like.
    #[error(
        "'{formula}' has no finite value at {:?} m: make the functions of {file} defined everywhere, e.g. by if() or Sqrt()",
        .position.to_array()
    )]
    NoValue {
        /// In the words of the modifier.
        formula: Arc<str>,
        /// Where the functions are.
        file: Arc<str>,
        /// Where on the device \[m\].
        position: DVec3,
    },
}

/// Where the `N` numbers of a field come from: 1 for brightness and mixtures, 3 for colours and textures.
#[derive(Clone, Debug, PartialEq)]
pub enum Source<const N: usize> {
    /// `brightfunc`, `colorfunc`, `texfunc`, `mixfunc`.
    Formulas(Formulas),
    /// `brightdata`, `colordata`, `texdata`, `mixdata`: a function of what data are at the coordinates.
    Data {
        /// What is made of the values.
        functions: [Call; N],
        /// One array for each number.
        data: [Arc<DataArray>; N],
        /// As many as the arrays have dimensions.
        coordinates: Formulas,
    },
    /// `colorpict`, `mixpict`: functions of the red, green and blue of a picture at u, v.
    Picture {
        /// What is made of the colour.
        functions: [Call; N],
        /// The picture.
        picture: Arc<Picture>,
        /// u along the picture's width, v along its height; the shorter of both is 1 long.
        coordinates: Formulas,
    },
    /// `brighttext`, `colortext`, `mixtext`: one thing on letters, another beside them.
    Text {
        /// Where the letters are.
        text: Arc<Text>,
        /// On them.
        foreground: [f64; N],
        /// Beside them.
        background: [f64; N],
    },
}

/// `N` numbers that vary over a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Field<const N: usize> {
    /// Coordinates and arguments of the functions.
    pub space: Arc<Space>,
    /// Where the numbers come from.
    pub source: Source<N>,
}

impl<const N: usize> Field<N> {
    /// The numbers for a ray at a surface, all finite.
    ///
    /// # Errors
    /// A function that fails, or whose value is not finite.
    pub fn at(&self, ray: &RayState) -> Result<[f64; N], FieldError> {
        self.values(&Seen { ray, space: &self.space }).map_err(|reason| self.space.error(reason))
    }

    fn values(&self, seen: &Seen) -> Result<[f64; N], FieldProblem> {
        let mut values = [0.0; N];
        match &self.source {
            Source::Formulas(formulas) => formulas.evaluate(seen, &mut values)?,
            Source::Data { functions, data, coordinates } => {
                let mut point = [0.0; DataArray::MOST_DIMENSIONS];
                let point = &mut point[..coordinates.len()];
                coordinates.evaluate(seen, point)?;
                let found: [f64; N] = std::array::from_fn(|k| data[k].value(point));
                for (k, (value, call)) in values.iter_mut().zip(functions).enumerate() {
                    *value = call.of(&found, k, seen)?;
                }
            }
            Source::Picture { functions, picture, coordinates } => {
                let mut at = [0.0; 2];
                coordinates.evaluate(seen, &mut at)?;
                let found = picture.value(at[0], at[1]);
                for (k, (value, call)) in values.iter_mut().zip(functions).enumerate() {
                    *value = call.of(&found, k, seen)?;
                }
            }
            Source::Text { text, foreground, background } => {
                values = if text.covers(seen.position()) { *foreground } else { *background };
            }
        }
        Ok(values)
    }

    /// The same for a device that is turned: `turn` is a rotation, or a mirror.
    pub fn turned(&self, turn: impl Fn(DVec3) -> DVec3) -> Field<N> {
        Field { space: Arc::new(self.space.turned(turn)), source: self.source.clone() }
    }
}

impl Field<3> {
    /// A vector that is given in the function's coordinates, in the device's, of the length it has there: for perturbations of
    /// unit normals, and for directions.
    ///
    /// # Errors
    /// As [`Field::at`].
    pub fn vector(&self, ray: &RayState) -> Result<DVec3, FieldError> {
        Ok(self.space.direction(DVec3::from_array(self.at(ray)?)))
    }
}

/// A digest of some content: equal for equal bytes, and for others with a probability of 2⁻⁶⁴.
///
/// Source: Fowler, Noll and Vo's hash, FNV-1a, finished by a multiplication that mixes high bits.
pub fn digest(bytes: &[u8]) -> u64 {
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    (hash ^ (hash >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} \"{}\"", self.at, self.kind, self.name)
    }
}
