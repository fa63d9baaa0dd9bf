//! Scattered BSDF measurements → a variable-resolution BSDF.
//!
//! What enters: files of goniophotometers ([`read`]), one scan of exitant directions for each incident direction. What leaves: a
//! [`Measurement`], and fitted to it a [`Model`] of each part.

pub mod measurement;
mod progress;
mod coverage;
mod lambert;
mod raster;
mod residual;
mod gridded;
mod in_plane;
mod prepare;
mod images;
pub mod summary;
pub mod read;
pub mod write;
mod incidence;
mod frame;
mod lobes;
mod link;
mod ways;
mod path;
mod tracks;
mod blend;
mod choose;
mod symmetry;
mod uncertainty;
mod scales;
mod forward;
mod swapped;
mod reciprocity;
mod model;
mod cells;
mod averaged;
mod tree;
mod fit;

pub use blend::Recipe;
pub use choose::Score;
pub use fit::{Fit, FitError, Options};
pub use frame::Frame;
pub use incidence::Blend;
pub use measurement::{Measurement, Scan, Symmetry};
pub use model::Model;
pub use progress::{Progress, Stopped};
pub use reciprocity::Reciprocity;
pub use symmetry::SymmetryFound;
