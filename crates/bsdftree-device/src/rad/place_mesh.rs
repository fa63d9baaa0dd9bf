//! Meshes and octrees in a scene, or as devices by themselves.
//!
//! In: a mesh file or an octree and its placement. Out: for a mesh one surface for each of its materials, over shared vertices;
//! for an octree its scene. What they bring along is defined for them alone. Names in a mesh go through the map of the
//! options, then to what is defined in the scene at this point.

use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use super::collect;
use super::definition::Definition;
use super::files::{self, Source};
use super::scene::{Placement, Scene};
use super::statement::{Primitive, quoted};
use super::transform::{self, Transform};
use crate::device::Surface;
use crate::error::{DeviceError, Place};
use crate::mesh::{Format, Made, Mesh, MeshFile, Octree, Part, Vertices, read_octree};
use crate::shape::Shape;

/// Largest mesh or octree \[byte\].
const LARGEST: u64 = 4 << 30;

/// The name of the modifier that is put upon everything inside, for which no file can have another meaning.
const IMPOSED: &str = "\0imposed";

impl Scene {
    /// Adds a mesh that is a device by itself.
    pub(super) fn mesh_file(
        &mut self,
        path: &Path,
        format: Format,
        placement: &Placement,
    ) -> Result<(), DeviceError> {
        let bytes = files::read_bytes(path, LARGEST, None)?;
        self.mesh_bytes(&bytes, path, format, placement)
    }

    /// Adds what is in the file of a mesh.
    pub(super) fn mesh_bytes(
        &mut self,
        bytes: &[u8],
        path: &Path,
        format: Format,
        placement: &Placement,
    ) -> Result<(), DeviceError> {
        let name = path.display().to_string();
        let mesh = format.read(bytes, &name, &self.options.limits)?;
        let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let at = Place { file: name.into(), line: 1 };
        self.mesh(&mesh, None, &stem, beside(path), placement, &at)
    }

    /// Adds an octree that is a device by itself.
    pub(super) fn octree_file(&mut self, path: &Path, placement: &Placement) -> Result<(), DeviceError> {
        let name = path.display().to_string();
        let bytes = files::read_bytes(path, LARGEST, None)?;
        let at = Place { file: name.as_str().into(), line: 1 };
        self.octree(&bytes, path, &name, placement, &at)
    }

    /// Adds a `mesh` or an `instance` of a scene: `modifier mesh name`, file and transformation.
    pub(super) fn referenced(
        &mut self,
        p: &Primitive,
        directory: &Path,
        placement: &Placement,
        at: &Place,
    ) -> Result<(), DeviceError> {
        let Some((file, words)) = p.strings.split_first() else {
            return Err(DeviceError::Unexpected {
                at: at.clone(),
                expected: format!("a file as string argument 1 of {} \"{}\"", p.kind, p.name),
                found: "no string arguments".to_owned(),
                advice: String::new(),
            });
        };
        let moved = transform::single(words).map_err(|wrong| DeviceError::Unexpected {
            at: at.clone(),
            expected: format!("{} for {} \"{}\"", wrong.expected, p.kind, p.name),
            found: wrong.found,
            advice: String::new(),
        })?;
        let modifier = placement.modifier.as_deref().unwrap_or(&p.modifier);
        let imposed = self.definitions.find(modifier, at)?;
        let is_imposed = modifier != "void";
        let path = self.files.find(file, directory, at)?;
        self.check_chain(&path, at)?;
        let bytes = files::read_bytes(&path, LARGEST, Some(at))?;
        let inside = Placement {
            transform: moved.then(&placement.transform),
            prefix: format!("{}{}.", placement.prefix, p.name),
            modifier: is_imposed.then(|| IMPOSED.into()),
            invert: placement.invert,
        };
        if !inside.transform.is_finite() {
            return Err(collect::overflow("a transformation", at));
        }
        let shown = path.display().to_string();
        let aside = self.definitions.set_aside(imposed.clone().map(|definition| (IMPOSED, definition)));
        self.chain.push(path.clone());
        let in_file = |error: DeviceError| match error {
            DeviceError::Binary { .. } => DeviceError::Modifier { at: at.clone(), reason: error.to_string() },
            other => other,
        };
        let result = if p.kind == "mesh" {
            let mesh = Format::Rtm.read(&bytes, &shown, &self.options.limits);
            let name = format!("{}{}", placement.prefix, p.name);
            mesh.and_then(|mesh| {
                let imposed = imposed.as_ref().filter(|_| is_imposed);
                self.mesh(&mesh, imposed, &name, beside(&path), &inside, at)
            })
        } else {
            self.octree(&bytes, &path, &shown, &inside, at)
        };
        self.chain.pop();
        self.definitions.restore(aside);
        result.map_err(in_file)
    }

    fn octree(
        &mut self,
        bytes: &[u8],
        path: &Path,
        shown: &str,
        placement: &Placement,
        at: &Place,
    ) -> Result<(), DeviceError> {
        let directory = beside(path).to_owned();
        match read_octree(bytes, shown)? {
            Octree::Frozen(statements) => {
                // Its own names have no lines; the numbers of its objects stand for them.
                let source = Source { name: format!("{shown}: object").into(), directory, statements };
                self.source(&source, &source.directory.clone(), placement)
            }
            Octree::Files(names) => {
                let named = Place { file: shown.into(), line: 1 };
                for name in &names {
                    let found =
                        self.files.find(name, &directory, &named).map_err(|_| DeviceError::Unsupported {
                            at: at.clone(),
                            what: format!("the octree '{shown}' of {}, which is not there", quoted(name)),
                            advice: "freeze the octree (oconv -f), or put its scene files beside it"
                                .to_owned(),
                        })?;
                    self.check_chain(&found, &named)?;
                    let file = self.files.open(&found, Some(&named))?;
                    self.include(&file, Some(&directory), placement)?;
                }
                Ok(())
            }
        }
    }

    /// Adds the surfaces of a mesh, all of `imposed` if that is given. Files that its materials name are looked for in
    /// `directory`.
    fn mesh(
        &mut self,
        mesh: &MeshFile,
        imposed: Option<&Rc<Definition>>,
        name: &str,
        directory: &Path,
        placement: &Placement,
        at: &Place,
    ) -> Result<(), DeviceError> {
        for warning in &mesh.warnings {
            self.collection.warn(warning.clone());
        }
        let n_triangles: u64 = mesh.parts.iter().map(|part| part.triangles.len() as u64).sum();
        self.collection.spend(64 * mesh.vertices.positions.len() as u64 + 12 * n_triangles, at)?;
        self.collection.count_triangles(n_triangles, at)?;
        if !mesh.materials.is_empty() {
            let (name, statements) = (at.file.clone(), mesh.materials.clone());
            let source = Source { name, directory: directory.to_owned(), statements };
            self.source(&source, directory, placement)?;
        }
        let vertices = Arc::new(placed(&mesh.vertices, placement));
        if !vertices.positions.iter().all(|p| p.is_finite()) {
            return Err(collect::overflow(&format!("mesh \"{name}\""), at));
        }
        let turned = placement.transform.mirrored != placement.invert;
        for part in &mesh.parts {
            let at = Place { file: at.file.clone(), line: at.line.max(part.line) };
            let (surface, definition) = match imposed {
                Some(definition) => (name.to_owned(), Some(definition.clone())),
                None => self.made_of(part, name, &at)?,
            };
            let material = self.collection.material(definition.as_deref(), &surface, &at)?;
            let mut triangles = part.triangles.clone();
            if turned {
                triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
            }
            let shape = Shape::Mesh(Arc::new(Mesh { vertices: vertices.clone(), triangles }));
            self.collection.push(Surface { name: surface, shape, material }, &at)?;
        }
        Ok(())
    }

    /// The name of a part and what it is made of.
    fn made_of(
        &self,
        part: &Part,
        name: &str,
        at: &Place,
    ) -> Result<(String, Option<Rc<Definition>>), DeviceError> {
        let map = &self.options.materials;
        let default = || match &map.default {
            Some(default) => self.definitions.find(default, at),
            None => Err(DeviceError::Unexpected {
                at: at.clone(),
                expected: format!("a material for mesh \"{name}\""),
                found: "no name of one".to_owned(),
                advice: "give a default material, defined in a file of materials".to_owned(),
            }),
        };
        match &part.material {
            Made::Unsaid => Ok((name.to_owned(), default()?)),
            Made::Own(material) => Ok((format!("{name}.{material}"), self.definitions.find(material, at)?)),
            Made::Named(found) => {
                let modifier = map.names.get(found).unwrap_or(found);
                let definition = if self.definitions.knows(modifier) {
                    self.definitions.find(modifier, at)?
                } else if map.default.is_some() {
                    default()?
                } else {
                    return Err(DeviceError::Unexpected {
                        at: at.clone(),
                        expected: format!("a material of mesh \"{name}\" that is defined"),
                        found: quoted(modifier),
                        advice: "define it in a file of materials that is read before, map its name to one that is \
                                 defined, or give a default material"
                            .to_owned(),
                    });
                };
                Ok((format!("{name}.{found}"), definition))
            }
        }
    }
}

/// Where the files lie that a file names.
fn beside(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// The vertices in metres in the device.
fn placed(vertices: &Vertices, placement: &Placement) -> Vertices {
    let Placement { transform, invert, .. } = placement;
    let to: &Transform = transform;
    let side = if *invert { -1.0 } else { 1.0 };
    vertices.moved(|p| to.point(p), |n| to.vector(n) * side)
}
