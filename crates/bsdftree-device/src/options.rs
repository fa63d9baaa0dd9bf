//! How files are read: the same for all formats.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use crate::unit::Unit;

/// How files are read. Where a number's unit is, what else may be read, what may be run, and how much.
///
/// ```
/// use bsdftree_device::{ReadOptions, Unit};
/// let options = ReadOptions { unit: Unit::Millimeter, ..ReadOptions::default() };
/// assert_eq!(options.unit.meters(), 0.001);
/// assert!(options.allowed_commands.is_empty());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Unit of the lengths in the files.
    pub unit: Unit,
    /// Where files are looked for that are not beside the file that names them; `None`: in the directories of the
    /// environment variable `RAYPATH`.
    pub search: Option<Vec<PathBuf>>,
    /// Programs that a `!` command of a scene may run, by their names as they stand in the scene. Those that
    /// are understood here (`xform`, `genbox` …) need no leave and are never run.
    pub allowed_commands: Vec<String>,
    /// What the surfaces of meshes are made of.
    pub materials: MaterialMap,
    /// How much a file may ask for.
    pub limits: Limits,
}

/// Materials of meshes that name materials, or none.
///
/// A name in a mesh is looked up in `names`; what it stands for, or the name itself, is a modifier that one of the
/// files or an earlier file of the same device defines. Whatever is not defined there is `default`, if that is given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialMap {
    /// Radiance files of materials, read before everything else.
    pub files: Vec<PathBuf>,
    /// Modifiers by the names they have in meshes.
    pub names: BTreeMap<String, String>,
    /// The modifier of what has no name, or a name that is not defined.
    pub default: Option<String>,
}

/// Bounds on what files may expand to, so that a hostile file cannot fill the memory or run for ever.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Surfaces of a device, and triangles of its meshes.
    pub surfaces: u64,
    /// Memory for all statements that are walked, copies counted each time, and for what programs print \[byte\].
    pub bytes: u64,
    /// Files inside each other.
    pub depth: usize,
    /// Warnings that are kept.
    pub warnings: usize,
    /// Operations of all formulas of one command.
    pub operations: u64,
    /// How long one allowed program may run.
    pub command_time: Duration,
}

impl Limits {
    /// 10⁷ surfaces, 8 GiB, 64 files inside each other, 100 warnings, 10⁹ operations (some ten seconds) and a minute for a command.
    pub const DEFAULT: Limits = Limits {
        surfaces: 10_000_000,
        bytes: 8 << 30,
        depth: 64,
        warnings: 100,
        operations: 1_000_000_000,
        command_time: Duration::from_secs(60),
    };
}

impl Default for Limits {
    fn default() -> Self {
        Limits::DEFAULT
    }
}

impl From<Unit> for ReadOptions {
    /// All but the unit as by default.
    fn from(unit: Unit) -> Self {
        ReadOptions { unit, ..ReadOptions::default() }
    }
}

impl From<&ReadOptions> for ReadOptions {
    fn from(options: &ReadOptions) -> Self {
        options.clone()
    }
}

impl ReadOptions {
    /// The directories to look in: [`ReadOptions::search`], or those of `RAYPATH`, or Radiance's default.
    pub fn search_folders(&self) -> Vec<PathBuf> {
        match (&self.search, std::env::var_os("RAYPATH")) {
            (Some(folders), _) => folders.clone(),
            (None, Some(path)) => std::env::split_paths(&path).collect(),
            (None, None) => [".", "/usr/local/lib/ray"].map(PathBuf::from).to_vec(),
        }
    }
}
