//! Which format a file has, by the ending of its name.

use std::path::Path;

use super::MeshFile;
use super::{obj, ply, rtm, stl};
use crate::error::DeviceError;
use crate::options::Limits;

/// A format of triangle meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Wavefront.
    Obj,
    /// Stanford polygons.
    Ply,
    /// Stereolithography.
    Stl,
    /// Radiance's compiled mesh.
    Rtm,
}

impl Format {
    /// By the ending, in any case.
    pub(crate) fn of(path: &Path) -> Option<Format> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "obj" => Some(Format::Obj),
            "ply" => Some(Format::Ply),
            "stl" => Some(Format::Stl),
            "rtm" => Some(Format::Rtm),
            _ => None,
        }
    }

    /// Reads a mesh.
    pub(crate) fn read(self, bytes: &[u8], file: &str, limits: &Limits) -> Result<MeshFile, DeviceError> {
        match self {
            Format::Obj => obj::read(bytes, file, limits),
            Format::Ply => ply::read(bytes, file, limits),
            Format::Stl => stl::read(bytes, file, limits),
            Format::Rtm => rtm::read(bytes, file, limits),
        }
    }
}
