//! Device geometry and materials in.
//!
//! A [`Device`] is what scatters light: surfaces with their materials, in metres, the front (the room) towards +Z, up
//! towards +Y. It comes from Radiance scene files ([`Device::read_rad`], [`Device::parse_rad`]), from MGF
//! ([`Device::read_mgf`], [`Device::parse_mgf`]) and the geometry inside BSDF files ([`Device::read_bsdf_geometry`]), from a family of
//! parametric devices ([`Device::from_spec`], [`parametric::families`]), or is put together from its public fields;
//! [`Device::to_rad`] writes it as a Radiance scene, [`Device::to_mgf`] as MGF. How light scatters from it is for `bsdftree-generate`.
//!
//! ```
//! use bsdftree_device::{Device, Material, Unit};
//!
//! // A parametric device, by name.
//! let blinds = Device::from_spec("blinds:depth=0.05,spacing=0.04,angle=30,glazing=0.88")?;
//! assert!(matches!(blinds.materials[1].material, Material::Glass { .. }));
//!
//! // The same as a scene that Radiance reads, and back.
//! let scene = blinds.to_rad();
//! let again = Device::parse_rad(&scene, "blinds.rad", ".".as_ref(), Unit::Meter)?;
//! assert_eq!(again.surfaces, blinds.surfaces);
//!
//! // What is wrong is said with its place.
//! let error = Device::parse_rad("void plastic white\n0 0\n5 .8 .8 .8 0", "white.rad", ".".as_ref(), Unit::Meter);
//! let message = error.unwrap_err().to_string();
//! assert!(message.starts_with("white.rad:3: expected real argument 5 of 5 of plastic \"white\""), "{message}");
//! # Ok::<(), bsdftree_device::DeviceError>(())
//! ```
//!
//! Modules in the order in which data flows: [`mod@unit`], [`mod@error`], [`options`], [`cal`], [`field`], [`material`], [`mesh`], [`shape`], [`device`], `rad` (scene
//! files), `mgf`, [`parametric`].

pub mod cal;
pub mod device;
pub mod error;
mod generators;
pub mod field;
pub mod material;
pub mod mesh;
mod mgf;
pub mod options;
pub mod parametric;
mod period;
mod rad;
pub mod shape;
mod triangulate;
pub mod unit;
pub mod up;

pub use device::{Device, NamedMaterial, Surface};
pub use error::{DeviceError, Place};
pub use material::Material;
pub use mgf::Mgf;
pub use options::ReadOptions;
pub use shape::Shape;
pub use unit::Unit;
pub use up::Up;
