//! What a query asks and what it answers. Everything here is f64, in metres, in the device's own coordinates.

use glam::DVec3;

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts \[m\].
    pub origin: DVec3,
    /// Where it goes; unit length.
    pub direction: DVec3,
    /// What it has just left ([`Hit::part`]): if flat, it cannot be hit again, if curved, only at its far side. `None`:
    /// the ray starts in space, and a surface at its very origin counts.
    pub from: Option<u32>,
}

/// The first surface on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin \[m\].
    pub t: f64,
    /// Where \[m\]: on the surface to within the rounding of f64.
    pub position: DVec3,
    /// Unit normal of the surface there, on the surface's front side whichever side was hit.
    pub normal: DVec3,
    /// Whether the ray came from the front.
    pub front: bool,
    /// Index into `Device::surfaces`.
    pub surface: u32,
    /// A number of the surface, or of the triangle if the surface is a mesh, which no other has: for [`Ray::from`].
    pub part: u32,
    /// Index into `Device::materials`.
    pub material: u32,
}
