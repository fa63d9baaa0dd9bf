//! `antimatter`. Source: Radiance's reference manual ("Materials").

/// The surface of a volume in which surfaces of some materials are not there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Antimatter {
    /// What an object looks like where the volume cuts it, an index into `Device::materials`; `None` if a cut is not seen.
    pub skin: Option<u32>,
    /// The materials that are not there, indices into `Device::materials`.
    pub hidden: Vec<u32>,
}
