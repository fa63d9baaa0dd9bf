//! `sides 1`: surfaces that are not there when seen from behind.
//!
//! In: a material. Out: that material in front and nothing behind, or whether a material is that. Source: MGF's entity `sides`; mgf2rad
//! since 2025, which makes the same mixture (before, it ignored the entity).

use std::sync::Arc;

use glam::DAffine3;

use crate::cal::Context;
use crate::error::Place;
use crate::field::{Field, File, Formulas, Origin, Source, Space};
use crate::material::Material;

/// 1 where the ray comes from the front.
const IN_FRONT: &str = "if(Rdot,1,0)";

/// The material in front, nothing behind.
pub(super) fn front_only(material: Material, name: &str, at: &Place) -> Material {
    let origin = Origin { kind: "sides".into(), name: name.into(), at: at.clone() };
    let file = File { path: ".".into(), digest: 0 };
    let space = Space::new(origin, file, Arc::from([]), DAffine3::IDENTITY, 1.0, 1.0);
    let expressions =
        Context::rayinit().compile_all([IN_FRONT], at).expect("our own formula of standard names");
    let formulas = Formulas { texts: vec![IN_FRONT.into()], expressions };
    let amount = Arc::new(Field { space: Arc::new(space), source: Source::Formulas(formulas) });
    Material::Mixture { amount, foreground: Box::new(material), background: Box::new(Material::Void) }
}

/// The material in front if there is nothing behind.
pub(super) fn of_front_only(material: &Material) -> Option<&Material> {
    let Material::Mixture { amount, foreground, background } = material else { return None };
    let Source::Formulas(formulas) = &amount.source else { return None };
    let in_front = formulas.texts.iter().all(|text| &**text == IN_FRONT) && amount.space.file.digest == 0;
    (in_front && **background == Material::Void).then_some(foreground)
}
