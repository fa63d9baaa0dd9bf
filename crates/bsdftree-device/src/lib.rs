//! Device geometry and materials in.

pub mod device;
pub mod material;
pub mod shape;

pub use device::{Device, NamedMaterial, Surface};
