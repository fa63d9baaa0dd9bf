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
    /// Corners of the bounding box of all surfaces \[m\], or `None` for an empty device.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        self.surfaces.iter().map(|s| s.shape.bounds()).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }
}
