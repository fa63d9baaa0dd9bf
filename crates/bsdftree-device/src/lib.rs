//! Device geometry and materials in.

pub mod device;
pub mod error;
pub mod material;
mod rad;
pub mod shape;
mod triangulate;
pub mod unit;

pub use device::{Device, NamedMaterial, Surface};
pub use error::{DeviceError, Place};
pub use material::Material;
pub use shape::Shape;
pub use unit::Unit;
