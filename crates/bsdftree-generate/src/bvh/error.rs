//! Why a device cannot be traced.

/// A device that cannot be made into a [`Bvh`](super::Bvh).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BvhError {
    /// Nothing can be hit: no surfaces, all void, or all without area.
    #[error(
        "the device has nothing a ray can hit: of {n_surfaces} surfaces all are void or without area; \
         check that the files hold geometry and that its modifiers are materials"
    )]
    NothingToHit {
        /// Number of surfaces in the device.
        n_surfaces: usize,
    },
    /// A shape that breaks a rule of [`Shape`](bsdftree_device::shape::Shape).
    #[error(
        "surface \"{name}\" (number {index}): {what} is {found}, expected {expected}; correct its arguments"
    )]
    BadShape {
        /// Its identifier in the scene.
        name: String,
        /// Its index in the device.
        index: usize,
        /// Which quantity.
        what: &'static str,
        /// What was found.
        found: String,
        /// What would be right.
        expected: &'static str,
    },
    /// A surface refers to a material the device does not have.
    #[error(
        "surface \"{name}\" (number {index}) has material {material}, but the device has {n_materials}; \
             give it one of those"
    )]
    NoSuchMaterial {
        /// Its identifier in the scene.
        name: String,
        /// Its index in the device.
        index: usize,
        /// The index it refers to.
        material: u32,
        /// How many there are.
        n_materials: usize,
    },
    /// More primitives than child references can name.
    #[error(
        "the device has {found} triangles and quadrics, at most {limit} can be traced; split or simplify it"
    )]
    TooMany {
        /// Primitives found.
        found: usize,
        /// The limit.
        limit: usize,
    },
}
