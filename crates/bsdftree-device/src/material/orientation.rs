//! A direction that orients a material: the same everywhere, or a function of the place.

use std::sync::Arc;

use glam::DVec3;

use crate::field::{Field, FieldError, RayState};

/// The direction u of anisotropic roughness, or the up direction of a BSDF, in the device's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Orientation {
    /// The same everywhere.
    Constant(DVec3),
    /// Depends on the ray and the place.
    Varying(Arc<Field<3>>),
}

impl Orientation {
    /// The direction for a ray, of any length.
    ///
    /// # Errors
    /// A function that fails, or whose value is not finite.
    #[inline]
    pub fn at(&self, ray: impl FnOnce() -> RayState) -> Result<DVec3, FieldError> {
        match self {
            Orientation::Constant(direction) => Ok(*direction),
            Orientation::Varying(field) => field.vector(&ray()),
        }
    }

    /// The same in a device that is turned by a rotation.
    pub fn turned(&self, turn: impl Fn(DVec3) -> DVec3) -> Orientation {
        match self {
            Orientation::Constant(direction) => Orientation::Constant(turn(*direction)),
            Orientation::Varying(field) => Orientation::Varying(Arc::new(field.turned(turn))),
        }
    }
}
