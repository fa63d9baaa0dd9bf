//! Klems matrices: fixed angle bases, as WINDOW and the three-phase method use them.

mod basis;
mod matrix;

pub use basis::{Basis, MAX_PATCHES, Ring};
pub use matrix::{Matrix, MatrixLobe};
