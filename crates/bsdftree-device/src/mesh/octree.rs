//! Radiance's octrees: the scene of a frozen one, the files of one that is not.
//!
//! In: bytes. Out: statements, or names of scene files. Source: files written by `oconv` (2025), taken apart: after what
//! [`compiled`](super::compiled) has, the names of the scene files, none if it is frozen; how many objects there are; voxels;
//! the objects, if it is frozen.

use super::compiled::Reader;
use crate::error::DeviceError;
use crate::rad::Statement;

/// What an octree is of.
pub(crate) enum Octree {
    /// The scene is in it.
    Frozen(Vec<Statement>),
    /// The scene is in these files.
    Files(Vec<String>),
}

/// Reads an octree.
pub(crate) fn read_octree(bytes: &[u8], file: &str) -> Result<Octree, DeviceError> {
    let mut reader = Reader::open(bytes, file, "Radiance_octree", 283)?;
    reader.cube()?;
    let mut files = Vec::new();
    loop {
        match reader.string("the name of a scene file")? {
            name if name.is_empty() => break,
            name => files.push(name),
        }
    }
    if !files.is_empty() {
        return Ok(Octree::Files(files));
    }
    let expected = reader.number("a number of objects")?;
    reader.skip_voxels()?;
    let at = reader.offset();
    let objects = reader.scene()?;
    if objects.len() as i64 != expected {
        return Err(reader.wrong_at(at, &format!("{expected} objects"), &objects.len().to_string()));
    }
    Ok(Octree::Frozen(objects.statements(&reader)?))
}
