//! A ray at a surface: all that what it does there may depend on.
//!
//! Lengths are in metres, places and directions in the device's own coordinates, the same as of hits. A constant material needs
//! the two directions only; patterns, textures and functions need the rest.

use bsdftree_device::mesh::MeshPoint;
use glam::DVec3;

use crate::bvh::{Bvh, Hit, Ray};

/// A ray at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// Unit normal of the front of the surface itself, whichever side was met.
    pub normal: DVec3,
    /// Unit vector along travel. It is what Radiance's functions know as the ray's direction.
    pub incoming: DVec3,
    /// Where \[m\].
    pub position: DVec3,
    /// Length of the ray \[m\].
    pub distance: f64,
    /// Length of the whole path so far, this ray included \[m\].
    pub traveled: f64,
    /// What a mesh knows beside.
    pub local: Local,
}

/// What a mesh knows of a place on it; zero for everything else.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Local {
    /// Texture coordinates (Radiance's Lu, Lv).
    pub uv: [f64; 2],
    /// What is to be added to the unit [`Meeting::normal`] for light to be scattered as by a smooth surface: the interpolated
    /// unit normal less the normal, on the front as that is. Radiance adds the perturbations of textures to it.
    pub perturbation: DVec3,
}

impl Local {
    /// Of a surface that is no mesh.
    pub const NONE: Local = Local { uv: [0.0; 2], perturbation: DVec3::ZERO };

    /// Of a point of a mesh that has this unit normal there.
    fn of(normal: DVec3, point: &MeshPoint) -> Local {
        let perturbation = point.normal.map_or(DVec3::ZERO, |smooth| smooth - normal);
        Local { uv: point.uv, perturbation }
    }
}

impl Meeting {
    /// A meeting at the origin of which nothing but the directions is known: enough for constant materials.
    ///
    /// ```
    /// use bsdftree_generate::scatter::Meeting;
    /// use glam::DVec3;
    /// assert!(Meeting::new(DVec3::Z, DVec3::NEG_Z).is_front());
    /// ```
    #[inline]
    pub fn new(normal: DVec3, incoming: DVec3) -> Meeting {
        Meeting { normal, incoming, position: DVec3::ZERO, distance: 0.0, traveled: 0.0, local: Local::NONE }
    }

    /// Of a ray and what it meets, `before` being the length of the path up to the ray.
    #[inline(always)]
    pub(crate) fn of(bvh: &Bvh, ray: &Ray, hit: &Hit, before: f64) -> Meeting {
        Meeting {
            normal: hit.normal,
            incoming: ray.direction,
            position: hit.position,
            distance: hit.t,
            traveled: before + hit.t,
            local: bvh.mesh_point(hit).map_or(Local::NONE, |point| Local::of(hit.normal, &point)),
        }
    }

    /// The same with a surface whose front is where its back is.
    pub(crate) fn turned_over(self) -> Meeting {
        let local = Local { perturbation: -self.local.perturbation, ..self.local };
        Meeting { normal: -self.normal, local, ..self }
    }

    /// Whether the ray comes from the side the normal points to.
    #[inline]
    pub fn is_front(&self) -> bool {
        super::is_front(self.normal, self.incoming)
    }
}
