//! A device: surfaces with their materials, in metres, front (the room) towards +Z.

use glam::DVec3;

use crate::material::Material;
use crate::shape::Shape;

/// One surface of a device.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Identifier in the scene, for messages.
    pub name: String,
    /// Its geometry.
    pub shape: Shape,
    /// Index into [`Device::materials`].
    pub material: u32,
}

/// A material with its identifier.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedMaterial {
    /// Identifier in the scene.
    pub name: String,
    /// Its parameters.
    pub material: Material,
}

/// Geometry and materials of something that scatters light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Device {
    /// What there is to hit.
    pub surfaces: Vec<Surface>,
    /// What it is made of.
    pub materials: Vec<NamedMaterial>,
    /// Smallest and largest x, y, z of one period in the middle of a periodic device \[m\]. Everything inside it looks as it
    /// would if the device went on for ever.
    pub tile: Option<[DVec3; 2]>,
    /// Things the reader did that the user should know, e.g. an emitter taken as black.
    pub warnings: Vec<String>,
}

impl Device {
    /// The same device in another band of light, as far as BSDF files say what it is there; `None` if none of them does.
    pub fn of_band(&self, name: &str) -> Option<Device> {
        let others: Vec<_> = self.materials.iter().map(|named| named.material.of_band(name)).collect();
        others.iter().any(Option::is_some).then(|| {
            let mut device = self.clone();
            for (named, other) in device.materials.iter_mut().zip(others) {
                named.material = other.unwrap_or_else(|| named.material.clone());
            }
            device
        })
    }

    /// Corners of the bounding box of all surfaces \[m\], or `None` for an empty device.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        self.surfaces.iter().map(|s| s.shape.bounds()).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }
}
