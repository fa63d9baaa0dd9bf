//! Ray-traces a device into a variable-resolution BSDF.

pub mod random;
pub mod scatter;
pub mod bvh;
