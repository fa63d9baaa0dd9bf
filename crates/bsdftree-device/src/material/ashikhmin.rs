//! `ashik2`. Source: Radiance's reference manual ("Materials").

use glam::DVec3;

use super::Orientation;

/// The anisotropic reflection of Ashikhmin and Shirley, and a diffuse one.
#[derive(Clone, Debug, PartialEq)]
pub struct Ashikhmin {
    /// Diffuse reflectance.
    pub diffuse: DVec3,
    /// Specular reflectance at normal incidence.
    pub specular: DVec3,
    /// Exponents of the facets' distribution along u and v: the larger, the smoother.
    pub power: [f64; 2],
    /// The direction u.
    pub orientation: Orientation,
}
