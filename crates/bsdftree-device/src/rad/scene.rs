//! Walks through a scene and builds the device.
//!
//! In: parsed sources. Out: surfaces and definitions in order, for `collect` and `definition`. Includes are walked in place, with the
//! transformation, name prefix, modifier and inversion of all `xform` commands around them; the innermost applies
//! first. Files that name each other in a circle are an error, and what a scene may expand to is bounded.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::collect::{self, Collection};
use super::command;
use super::definition::{Definition, Definitions, Setting};
use super::files::{Files, Source};
use super::library::Standing;
use super::statement::{Content, Primitive, Statement, quoted};
use super::stream::{self, Maker};
use super::transform::Transform;
use super::types::Class;
use super::xform::{Copy, Xform};
use crate::device::Device;
use crate::error::{DeviceError, Place};
use crate::options::ReadOptions;

/// The state of a walk.
pub(super) struct Scene {
    pub(super) options: ReadOptions,
    pub(super) files: Files,
    /// Files being walked, outermost first.
    pub(super) chain: Vec<PathBuf>,
    /// What commands have made, by what they are and where they ran.
    streams: HashMap<PathBuf, Vec<Rc<Source>>>,
    pub(super) definitions: Definitions,
    pub(super) collection: Collection,
}

/// What the commands around a statement do to it.
#[derive(Clone)]
pub(super) struct Placement {
    /// To metres in the device.
    pub transform: Transform,
    /// What stands before the names of surfaces.
    pub prefix: String,
    /// The modifier of all surfaces, if one is imposed.
    pub modifier: Option<Rc<str>>,
    /// Whether surfaces are turned over.
    pub invert: bool,
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
    pub(super) fn new(options: ReadOptions) -> Self {
        Scene {
            files: Files::new(options.search_folders()),
            chain: Vec::new(),
            streams: HashMap::new(),
            definitions: Definitions::default(),
            collection: Collection::new(options.limits),
            options,
        }
    }

    /// What a name stands for after all that was walked.
    pub(super) fn defined(&self, name: &str) -> Option<&Definition> {
        self.definitions.latest(name)
    }

    pub(super) fn into_device(self) -> Device {
        self.collection.into_device()
    }

    /// Walks a file that no scene names.
    pub(super) fn file(&mut self, path: &Path, placement: &Placement) -> Result<(), DeviceError> {
        let file = self.files.open(path, None)?;
        self.include(&file, None, placement)
    }

    /// Walks a file. Its commands run in `directory`, or in the file's own directory if that is `None`.
    pub(super) fn include(
        &mut self,
        (path, source): &(PathBuf, Rc<Source>),
        directory: Option<&Path>,
        placement: &Placement,
    ) -> Result<(), DeviceError> {
        self.chain.push(path.clone());
        self.source(source, directory.unwrap_or(&source.directory), placement)?;
        self.chain.pop();
        Ok(())
    }

    pub(super) fn check_chain(&self, file: &PathBuf, at: &Place) -> Result<(), DeviceError> {
        if let Some(first) = self.chain.iter().position(|other| other == file) {
            let circle = self.chain[first..].iter().chain([file]);
            return Err(DeviceError::Cycle {
                at: at.clone(),
                chain: circle.map(|p| p.display().to_string()).collect(),
            });
        }
        let deepest = self.options.limits.depth;
        if self.chain.len() >= deepest {
            return Err(collect::too_large(at, "files inside each other", deepest as u64));
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
            self.collection.spend(64, &at)?;
            match &statement.content {
                Content::Alias { modifier, name, reference } => {
                    self.definitions.alias(modifier, name, reference, self.options.unit.meters(), &at)?;
                }
                Content::Command(command) => {
                    let programs = command::pipe(command, &self.options.allowed_commands, &at)?;
                    self.pipe(&programs, directory, placement, &at)?;
                }
                Content::Primitive(p) => match p.class {
                    Class::Surface => {
                        let modifier = placement.modifier.as_deref().unwrap_or(&p.modifier);
                        let definition = self.definitions.find(modifier, &at)?;
                        self.collection.surface(p, definition.as_deref(), placement, &at)?;
                    }
                    Class::Reference => self.referenced(p, directory, placement, &at)?,
                    Class::UnsupportedSurface => return Err(unsupported_surface(p, &at)),
                    Class::Material | Class::Modifier | Class::Mixture | Class::UnsupportedMaterial => {
                        let standing = Standing { at: &at, directory, files: &self.files };
                        let (to, unit) = (&placement.transform, self.options.unit.meters());
                        self.definitions.define(p, &Setting { standing: &standing, to, unit })?;
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
        if !matches!(last.first().map(String::as_str), Some("xform" | "cat")) {
            return self.made(programs, directory, placement, at);
        }
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
            let files = self.open_all(&xform, directory, at)?;
            let run_in = if xform.in_file_directory { None } else { Some(directory) };
            for k in 0..xform.n_copies().unwrap_or(u64::MAX) {
                self.collection.spend(256, at)?;
                let inside = placement.of_copy(&xform, &xform.copy(k));
                if !inside.transform.is_finite() {
                    return Err(collect::overflow("a transformation", at));
                }
                for file in &files {
                    self.include(file, run_in, &inside)?;
                }
                self.pipe(inner, directory, &inside, at)?;
            }
        }
        Ok(())
    }

    /// Walks what programs make by themselves.
    fn made(
        &mut self,
        programs: &[Vec<String>],
        directory: &Path,
        placement: &Placement,
        at: &Place,
    ) -> Result<(), DeviceError> {
        let key = stream::key(programs, directory);
        self.check_chain(&key, at)?;
        let sources = match self.streams.get(&key) {
            Some(sources) => sources.clone(),
            None => {
                let options = &self.options;
                let mut maker = Maker { options, files: &mut self.files, directory, at };
                let sources = maker.sources(programs)?;
                let bytes = sources.iter().flat_map(|source| &source.statements).map(Statement::bytes).sum();
                self.collection.spend(bytes, at)?;
                self.streams.insert(key.clone(), sources.clone());
                sources
            }
        };
        self.chain.push(key);
        for source in &sources {
            self.source(source, directory, placement)?;
        }
        self.chain.pop();
        Ok(())
    }

    /// The files of a command, none of which may be one that is being walked.
    fn open_all(
        &mut self,
        xform: &Xform,
        directory: &Path,
        at: &Place,
    ) -> Result<Vec<(PathBuf, Rc<Source>)>, DeviceError> {
        let mut files = Vec::new();
        for name in &xform.files {
            let path = self.files.find(name, directory, at)?;
            let file = self.files.open(&path, Some(at))?;
            self.check_chain(&file.0, at)?;
            files.push(file);
        }
        Ok(files)
    }
}

fn unsupported_surface(p: &Primitive, at: &Place) -> DeviceError {
    let advice = match &*p.kind {
        "source" => "a device has no distant light: remove it",
        _ => "leave it out",
    };
    DeviceError::Unsupported {
        at: at.clone(),
        what: format!("surface type '{}' (\"{}\")", p.kind, p.name),
        advice: advice.to_owned(),
    }
}
