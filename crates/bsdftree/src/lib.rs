//! Variable-resolution BSDFs.

pub mod bsdf;
pub mod color;
mod cumulative;
pub mod direction;
pub mod hilbert;
pub mod klems;
pub mod square;
pub mod tree;

pub use bsdf::{Band, Bsdf, Component, Geometry, Header, LengthUnit, Part, Scattering};
pub use direction::{Direction, Side};
pub use klems::{Basis, Matrix};
pub use tree::{Rank, Tree};
