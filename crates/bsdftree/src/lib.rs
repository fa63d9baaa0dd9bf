//! Variable-resolution BSDFs.

pub mod direction;
pub mod square;
pub mod hilbert;
mod cumulative;
pub mod tree;
pub mod klems;
pub mod color;
pub mod bsdf;
pub mod query;
pub mod check;
pub mod xml;

pub use bsdf::{Band, Bsdf, Component, Geometry, Header, LengthUnit, Part, Scattering};
pub use direction::{Direction, Side};
pub use klems::{Basis, Matrix};
pub use query::{Lobes, Sample};
pub use tree::{Rank, Tree};
