//! Walks through a scene and builds the device.
//!
//! In: parsed sources. Out: surfaces and the materials they use, in metres. Includes are walked in place, with the
//! transformation, name prefix, modifier and inversion of all `xform` commands around them; the innermost applies
//! first. Files that name each other in a circle are an error, and what a scene may expand to is bounded.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::command;
use super::definition::{Definition, Definitions};
use super::files::{Files, Source};
use super::shape::{self, Shaped};
use super::statement::{Content, Primitive, quoted};
use super::transform::Transform;
use super::types::Class;
use super::xform::Copy;
use super::xform::Xform;
use crate::device::{Device, NamedMaterial, Surface};
use crate::error::{DeviceError, Place};
use crate::material::Material;

/// Bounds on what a scene may expand to.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    pub surfaces: u64,
    /// Memory for all statements that are walked, copies counted each time \[bytes\].
    pub bytes: u64,
    /// Files inside each other.
    pub depth: usize,
    /// Warnings that are kept.
    pub warnings: usize,
}

impl Limits {
    pub(super) const DEFAULT: Limits =
        Limits { surfaces: 10_000_000, bytes: 8 << 30, depth: 64, warnings: 100 };
}

/// The state of a walk.
pub(super) struct Scene {
    files: Files,
    limits: Limits,
    bytes_used: u64,
    /// Files being walked, outermost first.
    chain: Vec<PathBuf>,
    definitions: Definitions,
    device: Device,
    /// Index of each material by its name and parameters, so that copies of a definition are one.
    indices: HashMap<String, u32>,
    told: HashSet<String>,
    n_untold: usize,
}

/// What the commands around a statement do to it.
#[derive(Clone)]
pub(super) struct Placement {
    transform: Transform,
    prefix: String,
    modifier: Option<Rc<str>>,
    invert: bool,
}

impl Placement {
    /// Only changes the unit of length.
    pub(super) fn scaled(meters: f64) -> Self {
        let transform = Transform::scaling(meters);
        Placement { transform, prefix: String::new(), modifier: None, invert: false }
    }

    /// The placement of what is inside a copy of an `xform` that itself is placed by `self`.
    fn of_copy(&self, xform: &Xform, copy: &Copy) -> Self {
        Placement {
            transform: copy.transform.then(&self.transform),
            prefix: format!("{}{}", self.prefix, copy.prefix),
            modifier: self.modifier.clone().or_else(|| xform.modifier.as_deref().map(Rc::from)),
            invert: self.invert != xform.invert,
        }
    }
}

impl Scene {
    pub(super) fn new(files: Files, limits: Limits) -> Self {
        Scene {
            files,
            limits,
            bytes_used: 0,
            chain: Vec::new(),
            definitions: Definitions::default(),
            device: Device::default(),
            indices: HashMap::new(),
            told: HashSet::new(),
            n_untold: 0,
        }
    }

    pub(super) fn into_device(mut self) -> Device {
        if self.n_untold > 0 {
            self.device.warnings.push(format!("and {} more warnings", self.n_untold));
        }
        self.device
    }

    /// Walks a file. Its commands run in `directory`, or in the file's own directory if that is `None`.
    pub(super) fn file(
        &mut self,
        path: &Path,
        directory: Option<&Path>,
        placement: &Placement,
        named_at: Option<&Place>,
    ) -> Result<(), DeviceError> {
        let (canonical, source) = self.files.open(path, named_at)?;
        if let Some(at) = named_at {
            self.check_chain(&canonical, at)?;
        }
        self.chain.push(canonical);
        self.source(&source, directory.unwrap_or(&source.directory), placement)?;
        self.chain.pop();
        Ok(())
    }

    fn check_chain(&self, file: &PathBuf, at: &Place) -> Result<(), DeviceError> {
        if let Some(first) = self.chain.iter().position(|other| other == file) {
            let circle = self.chain[first..].iter().chain([file]);
            return Err(DeviceError::Cycle {
                at: at.clone(),
                chain: circle.map(|p| p.display().to_string()).collect(),
            });
        }
        if self.chain.len() >= self.limits.depth {
            return Err(self.too_large(at, "files inside each other", self.limits.depth as u64));
        }
        Ok(())
    }

    /// Walks all statements of a source.
    pub(super) fn source(
        &mut self,
        source: &Source,
        directory: &Path,
        placement: &Placement,
    ) -> Result<(), DeviceError> {
        for statement in &source.statements {
            let at = Place { file: source.name.clone(), line: statement.line };
            self.spend(64, &at)?;
            match &statement.content {
                Content::Alias { modifier, name, reference } => {
                    self.definitions.alias(modifier, name, reference, &at)?;
                }
                Content::Command(command) => {
                    let programs = command::pipe(command, &at)?;
                    self.pipe(&programs, directory, placement, &at)?;
                }
                Content::Primitive(p) => match p.class {
                    Class::Surface => self.surface(p, &at, placement)?,
                    Class::UnsupportedSurface => return Err(unsupported_surface(p, &at)),
                    Class::Material | Class::UnsupportedModifier(_) => {
                        self.definitions.define(p, &at, &placement.transform)?;
                    }
                },
            }
        }
        Ok(())
    }

    /// Walks what a pipe makes; its last program is the outermost.
    fn pipe(
        &mut self,
        programs: &[Vec<String>],
        directory: &Path,
        placement: &Placement,
        at: &Place,
    ) -> Result<(), DeviceError> {
        let Some((last, inner)) = programs.split_last() else { return Ok(()) };
        for xform in command::understand(last, directory, &self.files, at)? {
            if xform.files.is_empty() == inner.is_empty() {
                let (expected, found) = match xform.files.first() {
                    Some(file) => ("no file after '| xform', which transforms the pipe", quoted(file)),
                    None => ("a file for the command to read", "none".to_owned()),
                };
                let expected = expected.to_owned();
                return Err(DeviceError::Unexpected {
                    at: at.clone(),
                    expected,
                    found,
                    advice: String::new(),
                });
            }
            let n_copies = xform.n_copies().unwrap_or(u64::MAX);
            for k in 0..n_copies {
                self.spend(64, at)?;
                let copy = xform.copy(k);
                let inside = placement.of_copy(&xform, &copy);
                if !inside.transform.is_finite() {
                    return Err(DeviceError::Unexpected {
                        at: at.clone(),
                        expected: "a transformation within the range of numbers".to_owned(),
                        found: "an overflow".to_owned(),
                        advice: "check -s, -t and the counts of -i and -a".to_owned(),
                    });
                }
                match inner {
                    [] => self.files_of(&xform, directory, &inside, at)?,
                    _ => self.pipe(inner, directory, &inside, at)?,
                }
            }
        }
        Ok(())
    }

    fn files_of(
        &mut self,
        xform: &Xform,
        directory: &Path,
        placement: &Placement,
        at: &Place,
    ) -> Result<(), DeviceError> {
        let run_in = if xform.in_file_directory { None } else { Some(directory) };
        for name in &xform.files {
            let path = self.files.find(name, directory, at)?;
            self.file(&path, run_in, placement, Some(at))?;
        }
        Ok(())
    }

    fn surface(&mut self, p: &Primitive, at: &Place, placement: &Placement) -> Result<(), DeviceError> {
        if let Some(expected) = shape::expected_reals(&p.kind, p.reals.len()) {
            return Err(DeviceError::Unexpected {
                at: at.clone(),
                expected: format!("{expected} of {} \"{}\"", p.kind, p.name),
                found: p.reals.len().to_string(),
                advice: String::new(),
            });
        }
        let modifier = placement.modifier.as_deref().unwrap_or(&p.modifier);
        let definition = self.definitions.find(modifier, at)?;
        let name = format!("{}{}", placement.prefix, p.name);
        self.spend((name.len() + 8 * p.reals.len() + 128) as u64, at)?;
        let shape = match shape::place(p, &placement.transform, placement.invert) {
            Shaped::Dropped(reason) => {
                self.warn(format!("{at}: {} \"{name}\" is dropped: {reason}", p.kind));
                return Ok(());
            }
            Shaped::Shape(shape, notice) => {
                if let Some(notice) = notice {
                    self.warn(format!("{at}: {} \"{name}\": {notice}", p.kind));
                }
                shape
            }
        };
        let [low, high] = shape.bounds();
        if !(low.is_finite() && high.is_finite()) {
            return Err(DeviceError::Unexpected {
                at: at.clone(),
                expected: "coordinates within the range of numbers".to_owned(),
                found: format!("an overflow in {} \"{name}\"", p.kind),
                advice: "check the unit and the transformations".to_owned(),
            });
        }
        let material = self.material(definition, &name, at)?;
        if self.device.surfaces.len() as u64 >= self.limits.surfaces {
            return Err(self.too_large(at, "surfaces", self.limits.surfaces));
        }
        self.device.surfaces.push(Surface { name, shape, material });
        Ok(())
    }

    /// Index of the material of a definition in the device, which it enters on its first use.
    fn material(
        &mut self,
        definition: Option<Rc<Definition>>,
        user: &str,
        at: &Place,
    ) -> Result<u32, DeviceError> {
        let Some(definition) = definition else { return Ok(self.index_of("void", &Material::Void)) };
        if let Some(index) = definition.index.get() {
            return Ok(index);
        }
        let material = definition.effective.as_ref().map_err(|problem| problem.raise(user, at))?;
        let index = self.index_of(&definition.name, material);
        definition.index.set(Some(index));
        if let Some(notice) = &definition.notice {
            self.warn(notice.clone());
        }
        Ok(index)
    }

    fn index_of(&mut self, name: &str, material: &Material) -> u32 {
        let materials = &mut self.device.materials;
        // The debug form of an f64 is exact.
        *self.indices.entry(format!("{name} {material:?}")).or_insert_with(|| {
            materials.push(NamedMaterial { name: name.to_owned(), material: material.clone() });
            materials.len() as u32 - 1
        })
    }

    fn warn(&mut self, warning: String) {
        if self.told.contains(&warning) {
            return;
        }
        if self.device.warnings.len() >= self.limits.warnings {
            self.n_untold += 1;
            return;
        }
        self.told.insert(warning.clone());
        self.device.warnings.push(warning);
    }

    fn spend(&mut self, bytes: u64, at: &Place) -> Result<(), DeviceError> {
        self.bytes_used += bytes;
        if self.bytes_used > self.limits.bytes {
            return Err(self.too_large(at, "bytes after all copies are made", self.limits.bytes));
        }
        Ok(())
    }

    fn too_large(&self, at: &Place, what: &'static str, limit: u64) -> DeviceError {
        DeviceError::TooLarge { at: at.clone(), what, limit }
    }
}

fn unsupported_surface(p: &Primitive, at: &Place) -> DeviceError {
    let advice = match &*p.kind {
        "source" => "a device has no distant light: remove it",
        "instance" => "include the scene that the octree was made from by '!xform'",
        _ => "give its triangles as polygons",
    };
    DeviceError::Unsupported {
        at: at.clone(),
        what: format!("surface type '{}' (\"{}\")", p.kind, p.name),
        advice: advice.to_owned(),
    }
}
