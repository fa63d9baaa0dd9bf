//! Modifiers by name: materials, aliases, and modifiers that no surface may use yet.
//!
//! In: primitives and aliases in order. Out: for a modifier's name at this point of the scene, its material. The
//! latest definition wins, and what was defined with an earlier one keeps it, as in Radiance. A material under a
//! modifier that is not handled is a problem only when a surface uses it; so libraries of materials may be read.

use std::cell::Cell;
use std::collections::HashMap;
use std::rc::Rc;

use super::material;
use super::problem::Problem;
use super::statement::{Primitive, quoted};
use super::transform::Transform;
use super::types::{self, Class};
use crate::error::{DeviceError, Place};
use crate::material::Material;

/// A definition that surfaces and other modifiers refer to.
pub(super) struct Definition {
    pub name: String,
    /// The material by itself.
    own: Result<Material, Rc<Problem>>,
    /// The material with its modifiers.
    pub effective: Result<Material, Rc<Problem>>,
    /// To be told when a surface uses it.
    pub notice: Option<String>,
    /// Its index in the device, once a surface has used it.
    pub index: Cell<Option<u32>>,
}

/// All definitions in force.
#[derive(Default)]
pub(super) struct Definitions {
    latest: HashMap<String, Rc<Definition>>,
}

impl Definitions {
    /// The definition that a modifier names now; `None` for `void`.
    pub(super) fn find(&self, modifier: &str, at: &Place) -> Result<Option<Rc<Definition>>, DeviceError> {
        match modifier {
            "void" => Ok(None),
            _ => self.find_named("modifier", modifier, at).map(Some),
        }
    }

    fn find_named(&self, kind: &'static str, name: &str, at: &Place) -> Result<Rc<Definition>, DeviceError> {
        let found = self.latest.get(name).cloned();
        found.ok_or_else(|| DeviceError::Undefined { at: at.clone(), kind, name: name.to_owned() })
    }

    /// Defines a material or another modifier.
    pub(super) fn define(&mut self, p: &Primitive, at: &Place, to: &Transform) -> Result<(), DeviceError> {
        let modifier = self.find(&p.modifier, at)?;
        let (own, notice) = match self.own(p, at, to)? {
            Ok((material, notice)) => (Ok(material), notice),
            Err(problem) => (Err(problem), None),
        };
        let notice = notice.map(|notice| format!("{at}: {} \"{}\": {notice}", p.kind, p.name));
        self.insert(&p.name, own, modifier, notice, at);
        Ok(())
    }

    fn own(
        &self,
        p: &Primitive,
        at: &Place,
        to: &Transform,
    ) -> Result<Result<material::Described, Rc<Problem>>, DeviceError> {
        if let Class::UnsupportedModifier(kind) = p.class {
            let what = match kind {
                "material" => format!("material type '{}' (modifier \"{}\")", p.kind, p.name),
                _ => format!("{kind} '{}' (modifier \"{}\")", p.kind, p.name),
            };
            return Ok(Err(Rc::new(Problem::unsupported(at, what, types::advice(kind)))));
        }
        material::check_counts(p, at)?;
        if p.kind == "illum" {
            return self.illum(p, at);
        }
        Ok(material::describe(p, at, to).map_err(Rc::new))
    }

    /// `illum` is its alternate material, or not there.
    fn illum(
        &self,
        p: &Primitive,
        at: &Place,
    ) -> Result<Result<material::Described, Rc<Problem>>, DeviceError> {
        let emits = p.reals.iter().any(|&x| x != 0.0);
        let alternate = match p.strings.first().map(String::as_str) {
            None | Some("void") => Ok(Material::Void),
            Some(name) => self.find_named("alternate material", name, at)?.effective.clone(),
        };
        let notice = || "its light is left out: it is its alternate material".to_owned();
        Ok(alternate.map(|material| (material, emits.then(notice))))
    }

    /// Defines `name` as `reference` under another modifier; under the same one if that is `inherit`.
    pub(super) fn alias(
        &mut self,
        modifier: &str,
        name: &str,
        reference: &str,
        at: &Place,
    ) -> Result<(), DeviceError> {
        let original = self.find_named("reference of alias", reference, at)?;
        let (own, notice) = (original.own.clone(), original.notice.clone());
        if modifier == "inherit" {
            let effective = original.effective.clone();
            let definition =
                Definition { name: name.to_owned(), own, effective, notice, index: Cell::new(None) };
            self.latest.insert(name.to_owned(), Rc::new(definition));
        } else {
            let modifier = self.find(modifier, at)?;
            self.insert(name, own, modifier, notice, at);
        }
        Ok(())
    }

    fn insert(
        &mut self,
        name: &str,
        own: Result<Material, Rc<Problem>>,
        modifier: Option<Rc<Definition>>,
        notice: Option<String>,
        at: &Place,
    ) {
        let effective = match (&own, modifier) {
            (Err(problem), _) => Err(problem.clone()),
            (Ok(_), None) => own.clone(),
            (Ok(_), Some(modifier)) => Err(match &modifier.effective {
                Err(problem) => problem.clone(),
                Ok(_) => Rc::new(Problem::value(
                    at,
                    format!("'void' or a pattern as the modifier of material \"{name}\""),
                    format!("the material {}", quoted(&modifier.name)),
                )),
            }),
        };
        let definition = Definition { name: name.to_owned(), own, effective, notice, index: Cell::new(None) };
        self.latest.insert(name.to_owned(), Rc::new(definition));
    }
}
