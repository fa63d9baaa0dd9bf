//! Devices built in, from a text such as `blinds:depth=0.05,angle=30`.
//!
//! In: the name of a family and values of its parameters. Out: a [`Device`]. All lie in z ≤ 0 with the room towards
//! +Z and up +Y, centred on the Z axis, and cover width × height; periodic ones hold whole periods.

mod blinds;
mod builder;
mod family;
mod mirror;
mod perforated;
mod prism;
mod sawtooth;

#[cfg(test)]
mod tests;

pub use family::{Domain, Family, Parameter};

use family::Values;

use crate::device::Device;
use crate::error::DeviceError;

/// All families of parametric devices, with what help needs to show.
///
/// ```
/// for family in bsdftree_device::parametric::families() {
///     println!("{}: {}\n{}", family.name, family.summary, family.drawing);
///     for p in family.parameters {
///         println!("  {} = {} [{}]  {}  ({})", p.name, p.default_text(), p.unit, p.meaning, p.range_text());
///     }
/// }
/// ```
pub fn families() -> &'static [Family] {
    const FAMILIES: &[Family] =
        &[blinds::FAMILY, sawtooth::FAMILY, prism::FAMILY, perforated::FAMILY, mirror::FAMILY];
    FAMILIES
}

impl Device {
    /// Makes a parametric device from a text: a family, and after a colon its parameters where they differ from
    /// their defaults; see [`families`].
    ///
    /// # Errors
    /// [`DeviceError::Spec`] for unknown families and parameters (with the list of the known ones), values outside
    /// their range, and values that do not fit together.
    ///
    /// ```
    /// use bsdftree_device::Device;
    /// let device = Device::from_spec("blinds:depth=0.05,spacing=0.04,angle=30")?;
    /// assert!(device.bounds().unwrap()[1].z <= 0.0);
    /// # Ok::<(), bsdftree_device::DeviceError>(())
    /// ```
    pub fn from_spec(spec: &str) -> Result<Device, DeviceError> {
        let (name, parameters) = spec.split_once(':').unwrap_or((spec, ""));
        let name = name.trim();
        let error = |reason| DeviceError::Spec { spec: spec.to_owned(), reason };
        let Some(family) = families().iter().find(|family| family.name == name) else {
            let names: Vec<&str> = families().iter().map(|family| family.name).collect();
            return Err(error(format!("there is no family '{name}'; the families are {}", names.join(", "))));
        };
        let values = Values::parse(family.parameters, parameters).map_err(error)?;
        (family.build)(&values).map_err(error)
    }
}
