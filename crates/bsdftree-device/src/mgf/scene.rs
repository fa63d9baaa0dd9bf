//! Walks through MGF texts and builds the device.
//!
//! In: sources in order; contexts go on from one to the next, as in mgf2rad. Out: surfaces, their materials in the order of their first
//! use. A line is walked as often as there are copies of it, and what that may take is bounded. Unknown entities are told and
//! left out, as MGF asks. Deviations from mgf2rad: an included file must end the transformations it begins, and only those
//! (there mgf2rad runs for ever); files that include each other in a circle are refused.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::color::Color;
use super::context::Contexts;
use super::entity::{Entity, unexpected};
use super::finish::Finish;
use super::frame::Frames;
use super::material;
use super::piece::{self, Piece, Vertex};
use super::source::Source;
use crate::device::{Device, Surface};
use crate::error::{DeviceError, Place};
use crate::mesh::{Mesh, Vertices};
use crate::options::ReadOptions;
use crate::rad::shape::{self, Shaped};
use crate::rad::{Collection, Transform, quoted, too_large};
use crate::shape::Shape;

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
            "cxy" | "cspec" | "cct" | "cmix" => self.color(entity),
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

    /// What the current colour becomes.
    fn color(&mut self, entity: &Entity<'_>) -> Result<(), DeviceError> {
        let color = match entity.keyword {
            "cxy" => {
                entity.count(2..=2, "x and y")?;
                Color::of_xy(entity.number(0, "a number")?, entity.number(1, "a number")?)
            }
            "cct" => {
                entity.count(1..=1, "a temperature")?;
                Color::of_black_body(entity.number_within(0, 1000.0.., "at least 1000 K")?)
            }
            "cspec" => {
                entity.count(4.., "first and last wavelength in nm and at least two values")?;
                let first = entity.number(0, "a wavelength")?;
                let last = entity.number(1, "a wavelength")?;
                if last <= first {
                    let found = format!("{first} to {last}");
                    return Err(entity.unexpected("a last wavelength above the first", found, ""));
                }
                let values: Result<Vec<f64>, _> =
                    (2..entity.arguments.len()).map(|k| entity.number(k, "a number")).collect();
                Color::of_spectrum([first, last], &values?)
            }
            _ => {
                entity.count(4.., "weight and name of at least two colours")?;
                if entity.arguments.len() % 2 == 1 {
                    return Err(entity.unexpected("a name for each weight", "a weight alone".to_owned(), ""));
                }
                let part = |k: usize| {
                    let weight = entity.number_within(2 * k, 0.0.., "a weight of at least 0")?;
                    Ok((weight, *self.colors.get(entity.arguments[2 * k + 1], &entity.at)?))
                };
                let parts: Result<Vec<_>, DeviceError> = (0..entity.arguments.len() / 2).map(part).collect();
                Color::mixed(&parts?)
            }
        };
        let expected = match entity.keyword {
            "cxy" => "x ≥ 0, y > 0 and x + y ≤ 1",
            "cmix" => "a weight above 0",
            _ => "light between 380 and 780 nm",
        };
        let color =
            color.ok_or_else(|| entity.unexpected(expected, quoted(&entity.arguments.join(" ")), ""))?;
        *self.colors.current_mut() = color;
        Ok(())
    }

    fn surface(&mut self, entity: &Entity<'_>) -> Result<(), DeviceError> {
        let (kind, pieces) = self.pieces(entity)?;
        if pieces.is_empty() {
            self.collection.warn(format!("{}: a face with holes is dropped: it has no area", entity.at));
        }
        for piece in pieces {
            self.place(kind, piece, &entity.at)?;
        }
        Ok(())
    }

    /// The surfaces of an entity, and what stands for their kind in names.
    fn pieces(&self, entity: &Entity<'_>) -> Result<(&'static str, Vec<Piece>), DeviceError> {
        let vertex = |k: usize| self.vertices.get(entity.arguments[k], &entity.at).copied();
        let all = |words: &[&str]| -> Result<Vec<Vertex>, DeviceError> {
            words.iter().map(|name| self.vertices.get(name, &entity.at).copied()).collect()
        };
        Ok(match entity.keyword {
            "sph" => {
                entity.count(2..=2, "a vertex and a radius")?;
                let piece = Piece::Sphere { center: vertex(0)?.point, radius: entity.number(1, "a radius")? };
                ("s", vec![piece])
            }
            "cyl" => {
                entity.count(3..=3, "a vertex, a radius and a vertex")?;
                let (ends, radius) = ([vertex(0)?.point, vertex(2)?.point], entity.number(1, "a radius")?);
                ("cy", vec![Piece::Cone { ends, radii: [radius; 2] }])
            }
            "cone" => {
                entity.count(4..=4, "a vertex and a radius for each end")?;
                let ends = [vertex(0)?.point, vertex(2)?.point];
                let radii = [entity.number(1, "a radius")?, entity.number(3, "a radius")?];
                if radii[0] * radii[1] < 0.0 || radii == [0.0; 2] {
                    return Err(bad_radii(entity, "two radii of the same sign, not both 0", radii));
                }
                ("c", vec![Piece::Cone { ends, radii }])
            }
            "ring" | "torus" => {
                entity.count(3..=3, "a vertex with a normal and two radii")?;
                let Vertex { point: center, normal } = vertex(0)?;
                if normal == DVec3::ZERO {
                    let found = format!("no normal at vertex {}", quoted(entity.arguments[0]));
                    return Err(entity.unexpected("a vertex with a normal", found, "add 'n' to the vertex"));
                }
                let radii = [entity.number(1, "a radius")?, entity.number(2, "a radius")?];
                match entity.keyword {
                    "ring" if radii[0] >= 0.0 && radii[1] > radii[0] => {
                        ("r", vec![Piece::Ring { center, normal, radii }])
                    }
                    "ring" => return Err(bad_radii(entity, "0 ≤ inner radius < outer radius", radii)),
                    _ => {
                        let pieces = piece::torus(center, normal, radii);
                        let expected = "an outer radius farther from 0 than the inner, on the same side";
                        ("torus", pieces.ok_or_else(|| bad_radii(entity, expected, radii))?)
                    }
                }
            }
            "prism" => {
                entity.count(4.., "at least three vertices and a length")?;
                let (last, names) = (entity.arguments.len() - 1, entity.arguments);
                let length = entity.number(last, "a length")?;
                if length == 0.0 {
                    return Err(entity.unexpected("a length other than 0", quoted(names[last]), ""));
                }
                let pieces = piece::prism(&all(&names[..last])?, length);
                let found = || "vertices on one line".to_owned();
                ("f", pieces.ok_or_else(|| entity.unexpected("a base with an area", found(), ""))?)
            }
            "fh" => ("f", self.face_with_holes(entity)?),
            _ => {
                entity.count(3.., "at least three vertices")?;
                ("f", vec![piece::face(&all(entity.arguments)?)])
            }
        })
    }

    fn face_with_holes(&self, entity: &Entity<'_>) -> Result<Vec<Piece>, DeviceError> {
        let mut loops: Vec<Vec<Vertex>> = vec![Vec::new()];
        for (k, &word) in entity.arguments.iter().enumerate() {
            match loops.last_mut() {
                Some(vertices) if !word.starts_with('-') => {
                    vertices.push(*self.vertices.get(word, &entity.at)?);
                }
                // A last '-' is the end only.
                _ if k + 1 == entity.arguments.len() => {}
                _ => loops.push(Vec::new()),
            }
        }
        if let Some(short) = loops.iter().find(|vertices| vertices.len() < 3) {
            let found = short.len().to_string();
            return Err(entity.unexpected("at least three vertices in the face and in each hole", found, ""));
        }
        let holes: Vec<&[Vertex]> = loops[1..].iter().map(Vec::as_slice).collect();
        if holes.is_empty() {
            Ok(vec![piece::face(&loops[0])])
        } else {
            Ok(piece::face_with_holes(&loops[0], &holes))
        }
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
        let described = material::describe(finish, self.options.unit.meters()).map_err(|sum| {
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

fn bad_radii(entity: &Entity<'_>, expected: &str, [a, b]: [f64; 2]) -> DeviceError {
    entity.unexpected(expected, format!("{a} and {b}"), "")
}

/// A piece in metres: its kind, about how many bytes it takes, its shape.
fn placed(piece: Piece, to: &Transform) -> (&'static str, usize, Shaped) {
    match piece {
        Piece::Polygon(points) => {
            let mut points: Vec<DVec3> = points.into_iter().map(|p| to.point(p)).collect();
            if to.mirrored {
                points.reverse();
            }
            ("face", 24 * points.len(), shape::polygon(points))
        }
        Piece::Smooth(corners, triangles) => ("face", 256, smooth(&corners, triangles, to)),
        Piece::Sphere { center, radius } => {
            ("sphere", 0, shape::sphere(to.point(center), radius * to.scale, false))
        }
        Piece::Cone { ends, radii } => {
            ("cone", 0, shape::cone(ends.map(|p| to.point(p)), radii.map(|r| r * to.scale), false))
        }
        Piece::Ring { center, normal, radii } => {
            ("ring", 0, shape::ring(to.point(center), to.vector(normal), radii.map(|r| r * to.scale)))
        }
    }
}

fn smooth(corners: &[Vertex], triangles: &[[u32; 3]], to: &Transform) -> Shaped {
    let normal = |v: &Vertex| to.vector(v.normal).normalize_or_zero().as_vec3();
    let vertices = Vertices {
        positions: corners.iter().map(|v| to.point(v.point)).collect(),
        normals: corners.iter().map(normal).collect::<Vec<Vec3>>(),
        uvs: Vec::new(),
    };
    let turned = |&[a, b, c]: &[u32; 3]| if to.mirrored { [c, b, a] } else { [a, b, c] };
    let mesh = Mesh { vertices: Arc::new(vertices), triangles: triangles.iter().map(turned).collect() };
    let finite = mesh.vertices.positions.iter().all(|p| p.is_finite());
    let shape = Shape::Mesh(Arc::new(mesh));
    // Overflow is an error of its own.
    if finite && shape.is_degenerate() {
        Shaped::Dropped("it has no area")
    } else {
        Shaped::Shape(shape, None)
    }
}
