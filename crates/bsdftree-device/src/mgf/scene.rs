//! Walks through MGF texts and builds the device.
//!
//! In: sources in order; contexts go on from one to the next, as in mgf2rad. Out: surfaces, their materials in the order of their first
//! use. A line is walked as often as there are copies of it, and what that may take is bounded. Unknown entities are told and
//! left out, as MGF asks. Deviations from mgf2rad: an included file must end the transformations it begins, and only those
//! (there mgf2rad runs for ever); files that include each other in a circle are refused.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::DVec3;

use super::color::Color;
use super::context::Contexts;
use super::entity::{Entity, unexpected};
use super::finish::Finish;
use super::frame::Frames;
use super::geometry;
use super::material;
use super::palette;
use super::piece::{Piece, Vertex};
use super::place::placed;
use super::source::Source;
use crate::device::{Device, Surface};
use crate::error::{DeviceError, Place};
use crate::options::ReadOptions;
use crate::rad::{Collection, Transform, quoted, too_large};

/// The state of a walk.
pub(super) struct Scene {
    options: ReadOptions,
    collection: Collection,
    colors: Contexts<Color>,
    finishes: Contexts<Finish>,
    vertices: Contexts<Vertex>,
    frames: Frames,
    /// Files read so far.
    read: HashMap<PathBuf, Rc<Source>>,
    /// Files being walked, outermost first.
    chain: Vec<PathBuf>,
    /// How many surfaces of each kind there were.
    counts: HashMap<&'static str, u64>,
    /// Keywords that were told.
    unknown: HashSet<Box<str>>,
}

impl Scene {
    pub(super) fn new(options: ReadOptions) -> Self {
        let limits = options.limits;
        Scene {
            collection: Collection::new(limits),
            colors: Contexts::new("colour"),
            finishes: Contexts::new("material"),
            vertices: Contexts::new("vertex"),
            frames: Frames::new(Transform::scaling(options.unit.meters()), limits.depth, limits.surfaces),
            read: HashMap::new(),
            chain: Vec::new(),
            counts: HashMap::new(),
            unknown: HashSet::new(),
            options,
        }
    }

    pub(super) fn into_device(self) -> Device {
        self.collection.into_device()
    }

    /// Walks a file that no text names.
    pub(super) fn file(&mut self, path: &Path) -> Result<(), DeviceError> {
        let (path, source) = self.open(path, None)?;
        self.chain.push(path);
        self.top(&source)?;
        self.chain.pop();
        Ok(())
    }

    /// Walks a text that is not included by another.
    pub(super) fn top(&mut self, source: &Source) -> Result<(), DeviceError> {
        let depth = self.frames.depth();
        self.source(source)?;
        if let Some(at) = self.frames.left_open(depth) {
            self.collection.warn(format!("{at}: 'xf' is not ended: arrays have one copy only"));
        }
        Ok(())
    }

    fn open(&mut self, path: &Path, named_at: Option<&Place>) -> Result<(PathBuf, Rc<Source>), DeviceError> {
        let canonical = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let source = match self.read.get(&canonical) {
            Some(source) => source.clone(),
            None => Rc::new(Source::open(path, named_at)?),
        };
        self.read.insert(canonical.clone(), source.clone());
        Ok((canonical, source))
    }

    fn source(&mut self, source: &Source) -> Result<(), DeviceError> {
        let depth = self.frames.depth();
        let mut next = 0;
        while let Some(&line) = source.lines.get(next) {
            next += 1;
            let (words, at) = (source.words(line), source.place(line));
            self.collection.spend(64 + 16 * words.len() as u64, &at)?;
            let entity = Entity { keyword: words[0], arguments: &words[1..], at };
            match entity.keyword {
                "xf" if entity.arguments.is_empty() => {
                    if self.frames.depth() == depth {
                        let expected = "'xf' with a transformation before 'xf' that ends it";
                        return Err(entity.unexpected(expected, "none in this file".to_owned(), ""));
                    }
                    next = self.frames.close(&entity.at)?.unwrap_or(next);
                }
                "xf" => self.frames.open(entity.arguments, next, &entity.at)?,
                "i" => self.include(&entity, source)?,
                _ => self.entity(&entity)?,
            }
        }
        Ok(())
    }

    /// `i file [transformation]`.
    fn include(&mut self, entity: &Entity<'_>, from: &Source) -> Result<(), DeviceError> {
        entity.count(1.., "a file")?;
        let (name, words) = (entity.arguments[0], &entity.arguments[1..]);
        let Some(directory) = &from.directory else {
            return Err(DeviceError::Unsupported {
                at: entity.at.clone(),
                what: format!("including {}", quoted(name)),
                advice: "the geometry inside a BSDF file names no other files: put the text itself there"
                    .to_owned(),
            });
        };
        let (path, source) = self.open(&directory.join(name), Some(&entity.at))?;
        self.check_chain(&path, &entity.at)?;
        self.chain.push(path);
        let depth = self.frames.depth();
        if words.is_empty() {
            self.included(&source, depth)?;
        } else {
            self.frames.open(words, 0, &entity.at)?;
            loop {
                self.collection.spend(256, &entity.at)?;
                self.included(&source, depth + 1)?;
                if self.frames.close(&entity.at)?.is_none() {
                    break;
                }
            }
        }
        self.chain.pop();
        Ok(())
    }

    fn included(&mut self, source: &Source, depth: usize) -> Result<(), DeviceError> {
        self.source(source)?;
        match self.frames.left_open(depth) {
            Some(at) => {
                let found = "the end of the file".to_owned();
                Err(unexpected(at, "'xf' that ends this one in the same file", found, ""))
            }
            None => Ok(()),
        }
    }

    fn check_chain(&self, file: &PathBuf, at: &Place) -> Result<(), DeviceError> {
        if let Some(first) = self.chain.iter().position(|other| other == file) {
            let circle = self.chain[first..].iter().chain([file]);
            return Err(DeviceError::Cycle {
                at: at.clone(),
                chain: circle.map(|p| p.display().to_string()).collect(),
            });
        }
        if self.chain.len() >= self.options.limits.depth {
            return Err(too_large(at, "files inside each other", self.options.limits.depth as u64));
        }
        Ok(())
    }

    fn entity(&mut self, entity: &Entity<'_>) -> Result<(), DeviceError> {
        let color = *self.colors.current();
        match entity.keyword {
            "o" => self.frames.object(entity),
            "c" => self.colors.enter(entity).map(|_| ()),
            "cxy" | "cspec" | "cct" | "cmix" => {
                *self.colors.current_mut() = palette::color(entity, &self.colors)?;
                Ok(())
            }
            "m" => {
                if self.finishes.enter(entity)? {
                    self.finishes.current_mut().changed(&entity.at);
                }
                Ok(())
            }
            "v" => self.vertices.enter(entity).map(|_| ()),
            "p" => {
                self.vertices.current_mut().point = DVec3::from_array(entity.triple("x, y, z")?);
                Ok(())
            }
            "n" => {
                let normal = DVec3::from_array(entity.triple("x, y, z of a normal")?);
                self.vertices.current_mut().normal = normal.normalize_or_zero();
                Ok(())
            }
            "f" | "fh" | "sph" | "cyl" | "cone" | "ring" | "torus" | "prism" => self.surface(entity),
            "ies" => Err(DeviceError::Unsupported {
                at: entity.at.clone(),
                what: "the luminaire of 'ies'".to_owned(),
                advice: "a device is lit from outside only: remove the line".to_owned(),
            }),
            _ => {
                if !self.finishes.current_mut().set(entity, color)? {
                    self.unknown(entity);
                }
                Ok(())
            }
        }
    }

    /// Tells of the first of a kind.
    fn unknown(&mut self, entity: &Entity<'_>) {
        if self.unknown.contains(entity.keyword) {
            return;
        }
        if self.unknown.len() <= self.options.limits.warnings {
            self.unknown.insert(entity.keyword.into());
        }
        let keyword = quoted(entity.keyword);
        self.collection
            .warn(format!("{}: unknown entity {keyword} is left out wherever it stands", entity.at));
    }

    fn surface(&mut self, entity: &Entity<'_>) -> Result<(), DeviceError> {
        let (kind, pieces) = geometry::pieces(entity, &self.vertices)?;
        if pieces.is_empty() {
            self.collection.warn(format!("{}: a face with holes is dropped: it has no area", entity.at));
        }
        for piece in pieces {
            self.place(kind, piece, &entity.at)?;
        }
        Ok(())
    }

    /// Adds a piece to the device.
    fn place(&mut self, kind: &'static str, piece: Piece, at: &Place) -> Result<(), DeviceError> {
        let kind = if matches!(piece, Piece::Smooth(..)) { "t" } else { kind };
        let count = self.counts.entry(kind).or_default();
        *count += 1;
        let name = format!("{}{kind}{count}", self.frames.prefix());
        let (what, size, shaped) = placed(piece, self.frames.transform());
        self.collection.spend((name.len() + size + 128) as u64, at)?;
        let Some(shape) = self.collection.kept(what, &name, shaped, at)? else { return Ok(()) };
        let material = self.material(&name, at)?;
        self.collection.push(Surface { name, shape, material }, at)
    }

    /// Index of the current material in the device.
    fn material(&mut self, user: &str, at: &Place) -> Result<u32, DeviceError> {
        if let Some(index) = self.finishes.current().used_as {
            return Ok(index);
        }
        let finish = self.finishes.current();
        let name = self.finishes.name().unwrap_or("mat").to_owned();
        let defined_at = finish.at.clone().unwrap_or_else(|| at.clone());
        let described = material::describe(finish, &name, self.options.unit.meters()).map_err(|sum| {
            let expected = format!("rd + td + rs + ts of at most 1 in material \"{name}\"");
            unexpected(
                &defined_at,
                &expected,
                sum.to_string(),
                &format!("correct it (\"{user}\" uses it at {at})"),
            )
        })?;
        for notice in described.notices {
            self.collection.warn(format!("{defined_at}: material \"{name}\": {notice}"));
        }
        let index = self.collection.index_of(&name, &described.material);
        self.finishes.current_mut().used_as = Some(index);
        Ok(index)
    }
}
