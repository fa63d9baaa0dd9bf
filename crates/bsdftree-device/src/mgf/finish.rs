//! What a surface is made of, in MGF's own terms.
//!
//! In: the entities `rd`, `td`, `ed`, `rs`, `ts`, `ir`, `sides` with the current colour. Out: a [`Finish`]; `material` says what it is
//! in Radiance's terms.

use super::color::Color;
use super::entity::Entity;
use crate::error::{DeviceError, Place};

/// Light that is diffused: how much of it, in which colour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Diffuse {
    pub amount: f64,
    pub color: Color,
}

/// Light that is reflected or transmitted without being diffused.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Specular {
    pub amount: f64,
    pub color: Color,
    /// RMS slope of the facets.
    pub roughness: f64,
}

/// MGF's material.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Finish {
    pub rd: Diffuse,
    pub td: Diffuse,
    pub rs: Specular,
    pub ts: Specular,
    /// Emittance \[lm/m²\].
    pub ed: f64,
    /// Index of refraction, its real part.
    pub index: f64,
    /// `sides 1`: not there when seen from behind, or the boundary of a solid.
    pub one_sided: bool,
    /// Where it was changed last.
    pub at: Option<Place>,
    /// Its index in the device, once a surface has used it as it is.
    pub used_as: Option<u32>,
}

impl Default for Finish {
    fn default() -> Self {
        Finish {
            rd: Diffuse::default(),
            td: Diffuse::default(),
            rs: Specular::default(),
            ts: Specular::default(),
            ed: 0.0,
            index: 1.0,
            one_sided: false,
            at: None,
            used_as: None,
        }
    }
}

impl Finish {
    /// What an entity does to it; `false` if the entity is no matter of materials.
    pub(super) fn set(&mut self, entity: &Entity<'_>, color: Color) -> Result<bool, DeviceError> {
        match entity.keyword {
            "rd" => self.rd = Diffuse { amount: diffuse(entity)?, color },
            "td" => self.td = Diffuse { amount: diffuse(entity)?, color },
            "rs" => self.rs = specular(entity, color)?,
            "ts" => self.ts = specular(entity, color)?,
            "ed" => {
                entity.count(1..=1, "an emittance")?;
                self.ed = entity.number_within(0, 0.0.., "an emittance of at least 0")?;
            }
            "ir" => {
                entity.count(2..=2, "the real and imaginary part of an index of refraction")?;
                self.index = entity.number_within(0, 1e-6.., "an index of refraction above 0")?;
                entity.number(1, "a number")?;
            }
            "sides" => {
                entity.count(1..=1, "1 or 2")?;
                self.one_sided = match entity.arguments[0] {
                    "1" => true,
                    "2" => false,
                    word => return Err(entity.unexpected("1 or 2 sides", crate::rad::quoted(word), "")),
                };
            }
            _ => return Ok(false),
        }
        self.changed(&entity.at);
        Ok(true)
    }

    /// To be called of a new one, too.
    pub(super) fn changed(&mut self, at: &Place) {
        (self.at, self.used_as) = (Some(at.clone()), None);
    }
}

fn diffuse(entity: &Entity<'_>) -> Result<f64, DeviceError> {
    entity.count(1..=1, "one number")?;
    entity.number_within(0, 0.0..=1.0, "a number between 0 and 1")
}

fn specular(entity: &Entity<'_>, color: Color) -> Result<Specular, DeviceError> {
    entity.count(2..=2, "a fraction and a roughness")?;
    let amount = entity.number_within(0, 0.0..=1.0, "a number between 0 and 1")?;
    let roughness = entity.number_within(1, 0.0.., "a roughness of at least 0")?;
    Ok(Specular { amount, color, roughness })
}
