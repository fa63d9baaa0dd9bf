//! Collects the surfaces of a scene and the materials they use into a device.
//!
//! In: surface primitives with the definition that their modifier names and their placement. Out: a device in metres
//! whose materials are in the order of their first use, and bounded in size. Warnings are told once.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::definition::{Definition, MadeOf};
use super::optics;
use super::scene::Placement;
use super::shape::{self, Shaped};
use super::statement::Primitive;
use crate::device::{Device, NamedMaterial, Surface};
use crate::error::{DeviceError, Place};
use crate::material::{Antimatter, Material};
use crate::options::Limits;
use crate::shape::Shape;

/// A device that grows.
pub(crate) struct Collection {
    limits: Limits,
    bytes_used: u64,
    n_triangles: u64,
    device: Device,
    /// Index of each material by its name and parameters, so that copies of a definition are one.
    indices: HashMap<String, u32>,
    told: HashSet<String>,
    n_untold: usize,
}

impl Collection {
    pub(crate) fn new(limits: Limits) -> Self {
        Collection {
            limits,
            bytes_used: 0,
            n_triangles: 0,
            device: Device::default(),
            indices: HashMap::new(),
            told: HashSet::new(),
            n_untold: 0,
        }
    }

    pub(crate) fn into_device(mut self) -> Device {
        if self.n_untold > 0 {
            self.device.warnings.push(format!("and {} more warnings", self.n_untold));
        }
        self.device
    }

    /// Adds a surface.
    pub(super) fn surface(
        &mut self,
        p: &Primitive,
        definition: Option<&Definition>,
        placement: &Placement,
        at: &Place,
    ) -> Result<(), DeviceError> {
        if let Some(expected) = shape::expected_reals(&p.kind, p.reals.len()) {
            return Err(DeviceError::Unexpected {
                at: at.clone(),
                expected: format!("{expected} of {} \"{}\"", p.kind, p.name),
                found: p.reals.len().to_string(),
                advice: String::new(),
            });
        }
        let name = format!("{}{}", placement.prefix, p.name);
        self.spend((name.len() + 8 * p.reals.len() + 128) as u64, at)?;
        let shaped = shape::place(p, &placement.transform, placement.invert);
        let Some(shape) = self.kept(&p.kind, &name, shaped, at)? else { return Ok(()) };
        let material = self.material(definition, &name, at)?;
        if let Some(warning) = optics::lost_orientation(&self.device.materials[material as usize], &shape) {
            self.warn(format!("{at}: {} \"{name}\": {warning}", p.kind));
        }
        self.push(Surface { name, shape, material }, at)
    }

    /// A surface's shape, unless it is dropped.
    pub(crate) fn kept(
        &mut self,
        kind: &str,
        name: &str,
        shaped: Shaped,
        at: &Place,
    ) -> Result<Option<Shape>, DeviceError> {
        let shape = match shaped {
            Shaped::Dropped(reason) => {
                self.warn(format!("{at}: {kind} \"{name}\" is dropped: {reason}"));
                return Ok(None);
            }
            Shaped::Shape(shape, notice) => {
                if let Some(notice) = notice {
                    self.warn(format!("{at}: {kind} \"{name}\": {notice}"));
                }
                shape
            }
        };
        let [low, high] = shape.bounds();
        match low.is_finite() && high.is_finite() {
            true => Ok(Some(shape)),
            false => Err(overflow(&format!("{kind} \"{name}\""), at)),
        }
    }

    /// Adds a surface as it is.
    pub(crate) fn push(&mut self, surface: Surface, at: &Place) -> Result<(), DeviceError> {
        if self.device.surfaces.len() as u64 >= self.limits.surfaces {
            return Err(too_large(at, "surfaces", self.limits.surfaces));
        }
        self.device.surfaces.push(surface);
        Ok(())
    }

    /// Counts the triangles of a mesh.
    pub(super) fn count_triangles(&mut self, n: u64, at: &Place) -> Result<(), DeviceError> {
        self.n_triangles = self.n_triangles.saturating_add(n);
        if self.n_triangles > self.limits.surfaces {
            return Err(too_large(at, "triangles of meshes", self.limits.surfaces));
        }
        Ok(())
    }

    /// Index of the material of a definition in the device, which it enters on its first use.
    pub(super) fn material(
        &mut self,
        definition: Option<&Definition>,
        user: &str,
        at: &Place,
    ) -> Result<u32, DeviceError> {
        let Some(definition) = definition else { return Ok(self.index_of("void", &Material::Void)) };
        if let Some(index) = definition.index.get() {
            return Ok(index);
        }
        let material = match definition.made_of().map_err(|problem| problem.raise(user, at))? {
            MadeOf::Material(material) => material,
            MadeOf::Antimatter(hiding) => {
                let mut index = |definition: &Rc<Definition>| self.material(Some(definition), user, at);
                let skin = hiding.skin.as_ref().map(&mut index).transpose()?;
                let hidden = hiding.hidden.iter().map(index).collect::<Result<_, _>>()?;
                Material::Antimatter(Antimatter { skin, hidden })
            }
        };
        let index = self.index_of(&definition.name, &material);
        definition.index.set(Some(index));
        for notice in &definition.notices {
            self.warn(notice.clone());
        }
        Ok(index)
    }

    /// Index of a material in the device, which it enters if it is new.
    pub(crate) fn index_of(&mut self, name: &str, material: &Material) -> u32 {
        let materials = &mut self.device.materials;
        // The debug form of an f64 is exact.
        *self.indices.entry(format!("{name} {material:?}")).or_insert_with(|| {
            materials.push(NamedMaterial { name: name.to_owned(), material: material.clone() });
            materials.len() as u32 - 1
        })
    }

    /// Tells the user something, once.
    pub(crate) fn warn(&mut self, warning: String) {
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

    /// Counts memory that a statement or a copy takes.
    pub(crate) fn spend(&mut self, bytes: u64, at: &Place) -> Result<(), DeviceError> {
        self.bytes_used += bytes;
        if self.bytes_used > self.limits.bytes {
            return Err(too_large(at, "bytes after all copies are made", self.limits.bytes));
        }
        Ok(())
    }
}

pub(crate) fn too_large(at: &Place, what: &'static str, limit: u64) -> DeviceError {
    DeviceError::TooLarge { at: at.clone(), what, limit }
}

pub(crate) fn overflow(what: &str, at: &Place) -> DeviceError {
    DeviceError::Unexpected {
        at: at.clone(),
        expected: "lengths within the range of numbers".to_owned(),
        found: format!("an overflow in {what}"),
        advice: "check the unit, -s, -t and the counts of -i and -a".to_owned(),
    }
}
