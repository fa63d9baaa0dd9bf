//! Ray-traces a device into a variable-resolution BSDF.

pub mod random;
pub mod scatter;
pub mod bvh;
pub mod path;
pub mod layout;
pub mod tally;
mod reciprocity;
mod reduce;
mod klems;
pub mod progress;
pub mod options;
pub mod generate;

pub use generate::{GenerateError, Report, generate};
pub use layout::Layout;
pub use options::{Aperture, Options, Sides};
pub use progress::Progress;
