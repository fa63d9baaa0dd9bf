//! Wavelengths: where a path knows its light, and what is made of it where it ends.
//!
//! In: spectra of materials. Out: their values at `N` wavelengths, and the weights by which such values make X, Y, Z, sunlight, or light of
//! a band. Invariant: weights of one functional sum up to 1, so that what reflects everything has 1 in every band, and X = Y = Z.
//!
//! Between its wavelengths a path's light is taken to be a cubic, and weights are integrals of tables (CIE, ASTM) times that: how
//! rugged sunlight is does not matter, only how rugged materials are. `grid` says how many wavelengths that takes, as measured.

mod cie;
mod grid;
mod primaries;
mod samples;
mod solar;
mod weights;
#[cfg(test)]
pub(crate) mod tests;

pub use grid::VISIBLE_NM;
pub(crate) use grid::{GROUP, N, N_GROUPS, wavelengths_nm};
pub(crate) use primaries::RED_GREEN;
pub(crate) use samples::{REACH_NM, resampled};
pub(crate) use weights::{Weights, cie_xyz, importance, mean_between, solar_between, value_at};

/// The wavelengths of a path \[nm\].
pub const RANGE_NM: [f64; 2] = [300.0, 2500.0];
