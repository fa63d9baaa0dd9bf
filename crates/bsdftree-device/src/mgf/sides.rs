//! `sides 1`: surfaces that are not there when seen from behind.
//!
//! In: a material. Out: that material in front and nothing behind, or whether a material is that. Source: MGF's entity `sides`; mgf2rad
//! since 2025, which makes the same mixture (before, it ignored the entity).

use std::sync::Arc;

use super::formula;
use crate::error::Place;
use crate::material::Material;

/// 1 where the ray comes from the front.
const IN_FRONT: &str = "if(Rdot,1,0)";

/// The material in front, nothing behind.
pub(super) fn front_only(material: Material, name: &str, at: &Place) -> Material {
    let amount = Arc::new(formula::field([IN_FRONT], &[], "sides", name, at));
    Material::Mixture { amount, foreground: Box::new(material), background: Box::new(Material::Void) }
}

/// The material in front if there is nothing behind.
pub(super) fn of_front_only(material: &Material) -> Option<&Material> {
    let Material::Mixture { amount, foreground, background } = material else { return None };
    (formula::words(amount) == Some([IN_FRONT]) && **background == Material::Void).then_some(foreground)
}
