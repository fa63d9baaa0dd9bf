//! Light by incident cell.

use bsdftree::Part;

/// Hemispherical reflectances or transmittances of a component, as counted before anything was merged.
#[derive(Clone, Debug)]
pub struct Totals {
    /// The component.
    pub part: Part,
    /// For each incident cell.
    pub values: Vec<f64>,
    /// Their standard errors: ±2.36 of them is an interval of 95 %.
    pub errors: Vec<f64>,
}
