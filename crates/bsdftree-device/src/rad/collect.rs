//! Collects the surfaces of a scene and the materials they use into a device.
//!
//! In: surface primitives with the definition that their modifier names and their placement. Out: a device in metres
//! whose materials are in the order of their first use, and bounded in size. Warnings are told once.

use std::collections::{HashMap, HashSet};

use super::definition::Definition;
use super::scene::Placement;
use super::shape::{self, Shaped};
use super::statement::Primitive;
use crate::device::{Device, NamedMaterial, Surface};
use crate::error::{DeviceError, Place};
use crate::material::Material;
use crate::options::Limits;

/// A device that grows.
pub(super) struct Collection {
    limits: Limits,
    bytes_used: u64,
    device: Device,
    /// Index of each material by its name and parameters, so that copies of a definition are one.
    indices: HashMap<String, u32>,
    told: HashSet<String>,
    n_untold: usize,
}

impl Collection {
    pub(super) fn new(limits: Limits) -> Self {
        Collection {
            limits,
            bytes_used: 0,
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
            return Err(overflow(&format!("{} \"{name}\"", p.kind), at));
        }
        let material = self.material(definition, &name, at)?;
        if self.device.surfaces.len() as u64 >= self.limits.surfaces {
            return Err(too_large(at, "surfaces", self.limits.surfaces));
        }
        self.device.surfaces.push(Surface { name, shape, material });
        Ok(())
    }

    /// Index of the material of a definition in the device, which it enters on its first use.
    fn material(
        &mut self,
        definition: Option<&Definition>,
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

    /// Counts memory that a statement or a copy takes.
    pub(super) fn spend(&mut self, bytes: u64, at: &Place) -> Result<(), DeviceError> {
        self.bytes_used += bytes;
        if self.bytes_used > self.limits.bytes {
            return Err(too_large(at, "bytes after all copies are made", self.limits.bytes));
        }
        Ok(())
    }
}

pub(super) fn too_large(at: &Place, what: &'static str, limit: u64) -> DeviceError {
    DeviceError::TooLarge { at: at.clone(), what, limit }
}

pub(super) fn overflow(what: &str, at: &Place) -> DeviceError {
    DeviceError::Unexpected {
        at: at.clone(),
        expected: "lengths within the range of numbers".to_owned(),
        found: format!("an overflow in {what}"),
        advice: "check the unit, -s, -t and the counts of -i and -a".to_owned(),
    }
}
