//! Modifiers by name: materials, patterns, textures, mixtures, aliases.
//!
//! In: primitives and aliases in order. Out: for a modifier's name at this point of the scene, what a surface is made of that has
//! it. The latest definition wins, and what was defined with an earlier one keeps it, as in Radiance. What cannot be
//! used is a problem only when a surface uses it; so libraries of materials may be read.
//!
//! A surface's modifier, that one's modifier, and so on, are a chain. Its first material is what the surface is made of; all
//! patterns and textures of the chain act on it, before it and behind it. A mixture of which a side has a material
//! is one itself, and may have no modifier; a side without material is not there. A chain without material is not there.
//! Deviation: a pattern by an alias that inherits acts once; Radiance lets it act twice.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use super::field::FieldReader;
use super::function_material;
use super::library::{Library, Standing};
use super::material;
use super::modifier::{self, Described};
use super::optics;
use super::problem::Problem;
use super::statement::{Primitive, quoted};
use super::transform::Transform;
use super::types::Class;
use crate::error::{DeviceError, Place};
use crate::field::Field;
use crate::material::{Material, Modifier, PartModifiers};

/// Most modifiers and materials that one may stand for, mixtures in mixtures counted each time.
const MOST_PARTS: usize = 4096;

/// A definition that surfaces and other modifiers refer to.
pub(super) struct Definition {
    pub name: String,
    /// What it is by itself.
    own: Result<Own, Rc<Problem>>,
    /// What it is with its modifiers.
    chain: Result<Chain, Rc<Problem>>,
    /// To be told when a surface uses it.
    pub notices: Vec<String>,
    /// Its index in the device, once a surface has used it.
    pub index: Cell<Option<u32>>,
}

/// A modifier by itself.
#[derive(Clone)]
enum Own {
    Material(Material),
    /// `illum`, whose own modifiers are its light's.
    Alternate(Chain),
    Modifier(Modifier),
    Mixture(Field<1>, [Chain; 2]),
    Antimatter(Rc<Hiding>),
}

/// A modifier with those behind it.
#[derive(Clone)]
enum Chain {
    Material(Material, usize),
    Modifiers(Vec<Modifier>, usize),
    Antimatter(Rc<Hiding>, usize),
}

/// What antimatter hides.
pub(super) struct Hiding {
    /// What shades a cut object; `None` if nothing does.
    pub skin: Option<Rc<Definition>>,
    pub hidden: Vec<Rc<Definition>>,
}

/// What a surface is made of.
pub(super) enum MadeOf {
    Material(Material),
    /// Antimatter, whose [`Material`] names others by their places in the device.
    Antimatter(Rc<Hiding>),
}

impl Chain {
    /// Of `void`.
    const NONE: Chain = Chain::Modifiers(Vec::new(), 0);

    /// How many modifiers and materials it has.
    fn parts(&self) -> usize {
        match self {
            Chain::Material(_, parts) | Chain::Modifiers(_, parts) | Chain::Antimatter(_, parts) => *parts,
        }
    }

    fn into_material(self) -> Material {
        match self {
            Chain::Material(material, _) => material,
            Chain::Modifiers(..) | Chain::Antimatter(..) => Material::Void,
        }
    }
}

impl Definition {
    /// What a surface is made of.
    pub(super) fn made_of(&self) -> Result<MadeOf, Rc<Problem>> {
        self.chain.clone().map(|chain| match chain {
            Chain::Antimatter(hiding, _) => MadeOf::Antimatter(hiding),
            chain => MadeOf::Material(chain.into_material()),
        })
    }
}

/// What definitions depend on.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a> {
    pub standing: &'a Standing<'a>,
    /// From the scene's coordinates to the device's \[m\].
    pub to: &'a Transform,
    /// The scene's unit \[m\].
    pub unit: f64,
}

/// All definitions in force.
#[derive(Default)]
pub(super) struct Definitions {
    latest: HashMap<String, Rc<Definition>>,
    library: Library,
}

/// Definitions that are not in force for the time being.
pub(super) struct Aside(HashMap<String, Rc<Definition>>);

impl Definitions {
    /// The definition that a modifier names now; `None` for `void`.
    pub(super) fn find(&self, modifier: &str, at: &Place) -> Result<Option<Rc<Definition>>, DeviceError> {
        match modifier {
            "void" => Ok(None),
            _ => self.find_named("modifier", modifier, at).map(Some),
        }
    }

    /// Whether [`Definitions::find`] finds something.
    pub(super) fn knows(&self, modifier: &str) -> bool {
        modifier == "void" || self.latest.contains_key(modifier)
    }

    /// Puts all definitions aside for what has its own, which begins with at most this one.
    pub(super) fn set_aside(&mut self, first: Option<(&str, Rc<Definition>)>) -> Aside {
        let first = first.map(|(name, definition)| (name.to_owned(), definition));
        Aside(std::mem::replace(&mut self.latest, first.into_iter().collect()))
    }

    /// Forgets what was defined since, and goes on with what was put aside.
    pub(super) fn restore(&mut self, aside: Aside) {
        self.latest = aside.0;
    }

    fn find_named(&self, kind: &'static str, name: &str, at: &Place) -> Result<Rc<Definition>, DeviceError> {
        let found = self.latest.get(name).cloned();
        found.ok_or_else(|| DeviceError::Undefined { at: at.clone(), kind, name: name.to_owned() })
    }

    /// What a name stands for now.
    pub(super) fn latest(&self, name: &str) -> Option<&Definition> {
        self.latest.get(name).map(Rc::as_ref)
    }

    /// Defines a material or another modifier.
    pub(super) fn define(&mut self, p: &Primitive, setting: &Setting) -> Result<(), DeviceError> {
        let at = setting.standing.at;
        let behind = self.find(&p.modifier, at)?;
        let mut notices = Vec::new();
        let doubts = RefCell::default();
        let own = self.own(p, setting, &doubts, &mut notices)?.map(|(own, notice)| {
            let told = notice.into_iter().chain(doubts.into_inner());
            notices.extend(told.map(|notice| format!("{at}: {} \"{}\": {notice}", p.kind, p.name)));
            own
        });
        self.insert(&p.name, own, behind, notices, setting.unit, at);
        Ok(())
    }

    fn own(
        &mut self,
        p: &Primitive,
        setting: &Setting,
        doubts: &RefCell<Vec<String>>,
        notices: &mut Vec<String>,
    ) -> Result<Described<Own>, DeviceError> {
        let standing = setting.standing;
        if p.class == Class::UnsupportedMaterial {
            let what = format!("material type '{}' (modifier \"{}\")", p.kind, p.name);
            let advice = "a device has no medium that scatters: say what it does by trans, or by a BSDF";
            return Ok(Err(Rc::new(Problem::unsupported(standing.at, what, advice))));
        }
        if p.kind == "illum" {
            material::check_counts(p, standing.at)?;
            return self.illum(p, standing.at);
        }
        let described =
            |own: Described<Material>| own.map(|(material, notice)| (Own::Material(material), notice));
        match p.class {
            Class::Modifier => {
                modifier::check_counts(p, standing)?;
                let modifier = modifier::describe(self.reader(p, setting, doubts));
                Ok(modifier.map(|(modifier, notice)| (Own::Modifier(modifier), notice)))
            }
            Class::Mixture => {
                modifier::check_counts(p, standing)?;
                let sides = [self.side(&p.strings[0], standing.at)?, self.side(&p.strings[1], standing.at)?];
                for side in sides.iter().flatten() {
                    notices.extend(side.notices.iter().cloned());
                }
                let amount = modifier::amount(self.reader(p, setting, doubts));
                let mixture = amount.and_then(|(amount, notice)| {
                    let chain =
                        |side: Option<Rc<Definition>>| side.map_or(Ok(Chain::NONE), |d| d.chain.clone());
                    let [foreground, background] = sides.map(chain);
                    Ok((Own::Mixture(amount, [foreground?, background?]), notice))
                });
                Ok(mixture)
            }
            _ if function_material::is_one(&p.kind) => {
                function_material::check_counts(p, standing)?;
                Ok(described(function_material::describe(self.reader(p, setting, doubts))))
            }
            _ if optics::is_one(&p.kind) => {
                optics::check_counts(p, standing)?;
                let modifiers = self.modifiers_of_parts(p, standing.at)?;
                Ok(described(
                    modifiers.and_then(|m| optics::describe(&mut self.reader(p, setting, doubts), m)),
                ))
            }
            _ if p.kind == "antimatter" => self.antimatter(p, standing.at, notices),
            _ => {
                material::check_counts(p, standing.at)?;
                Ok(described(material::describe(self.reader(p, setting, doubts))))
            }
        }
    }

    fn reader<'a>(
        &'a mut self,
        p: &'a Primitive,
        setting: &Setting<'a>,
        doubts: &'a RefCell<Vec<String>>,
    ) -> FieldReader<'a> {
        let Setting { standing, to, unit } = *setting;
        FieldReader { p, standing, to, unit, library: &mut self.library, doubts }
    }

    /// A side of a mixture; `None` for `void`.
    fn side(&self, name: &str, at: &Place) -> Result<Option<Rc<Definition>>, DeviceError> {
        match name {
            "void" => Ok(None),
            _ => self.find_named("side of a mixture", name, at).map(Some),
        }
    }

    /// The modifiers that a `WGMDfunc` names for its parts; `None` for those of the material itself.
    fn modifiers_of_parts(
        &self,
        p: &Primitive,
        at: &Place,
    ) -> Result<Result<PartModifiers, Rc<Problem>>, DeviceError> {
        let mut parts = PartModifiers::default();
        if p.kind != "WGMDfunc" {
            return Ok(Ok(parts));
        }
        for (part, argument) in parts.iter_mut().zip(optics::WGMD_MODIFIERS) {
            *part = match &*p.strings[argument] {
                "inherit" => None,
                "void" => Some(Arc::default()),
                name => match &self.find_named("modifier of a part", name, at)?.chain {
                    Ok(Chain::Modifiers(modifiers, _)) => Some(modifiers.clone().into()),
                    Ok(_) => {
                        let expected =
                            format!("a pattern or a texture as modifier of a part of \"{}\"", p.name);
                        let found = format!("the material {}", quoted(name));
                        return Ok(Err(Rc::new(Problem::value(at, expected, found))));
                    }
                    Err(problem) => return Ok(Err(problem.clone())),
                },
            };
        }
        Ok(Ok(parts))
    }

    /// Antimatter. As in Radiance, names that are not defined are left out, and the user is told.
    fn antimatter(
        &self,
        p: &Primitive,
        at: &Place,
        notices: &mut Vec<String>,
    ) -> Result<Described<Own>, DeviceError> {
        if p.strings.is_empty() {
            return Err(DeviceError::Unexpected {
                at: at.clone(),
                expected: format!(
                    "1 or more string arguments (the modifiers that antimatter \"{}\" hides)",
                    p.name
                ),
                found: "none".to_owned(),
                advice: String::new(),
            });
        }
        let mut hiding = Hiding { skin: None, hidden: Vec::new() };
        for (k, name) in p.strings.iter().enumerate().filter(|(_, name)| *name != "void") {
            let Some(definition) = self.latest.get(name) else {
                notices.push(format!(
                    "{at}: antimatter \"{}\": {} is not defined before it",
                    p.name,
                    quoted(name)
                ));
                continue;
            };
            if k == 0 {
                hiding.skin = Some(definition.clone());
            }
            if !hiding.hidden.iter().any(|other| Rc::ptr_eq(other, definition)) {
                hiding.hidden.push(definition.clone());
            }
        }
        Ok(Ok((Own::Antimatter(Rc::new(hiding)), None)))
    }

    /// `illum` is its alternate material, or not there.
    fn illum(&self, p: &Primitive, at: &Place) -> Result<Described<Own>, DeviceError> {
        let emits = p.reals.iter().any(|&x| x != 0.0);
        let alternate = match p.strings.first().map(String::as_str) {
            None | Some("void") => Ok(Chain::Material(Material::Void, 1)),
            Some(name) => self.find_named("alternate material", name, at)?.chain.clone(),
        };
        let notice = || "its light is left out: it is its alternate material".to_owned();
        Ok(alternate.map(|chain| (Own::Alternate(chain), emits.then(notice))))
    }

    /// Defines `name` as `reference` under another modifier; under the same one if that is `inherit`.
    pub(super) fn alias(
        &mut self,
        modifier: &str,
        name: &str,
        reference: &str,
        unit: f64,
        at: &Place,
    ) -> Result<(), DeviceError> {
        let original = self.find_named("reference of alias", reference, at)?;
        let (own, notices) = (original.own.clone(), original.notices.clone());
        if modifier == "inherit" {
            let chain = original.chain.clone();
            let index = Cell::new(None);
            let definition = Definition { name: name.to_owned(), own, chain, notices, index };
            self.latest.insert(name.to_owned(), Rc::new(definition));
        } else {
            let behind = self.find(modifier, at)?;
            self.insert(name, own, behind, notices, unit, at);
        }
        Ok(())
    }

    fn insert(
        &mut self,
        name: &str,
        own: Result<Own, Rc<Problem>>,
        behind: Option<Rc<Definition>>,
        mut notices: Vec<String>,
        unit: f64,
        at: &Place,
    ) {
        let chain = own.clone().and_then(|own| linked(name, own, behind.as_deref(), unit, at));
        notices.extend(behind.iter().flat_map(|definition| definition.notices.iter().cloned()));
        let definition = Definition { name: name.to_owned(), own, chain, notices, index: Cell::new(None) };
        self.latest.insert(name.to_owned(), Rc::new(definition));
    }
}

/// A modifier with the one behind it.
fn linked(
    name: &str,
    own: Own,
    behind: Option<&Definition>,
    unit: f64,
    at: &Place,
) -> Result<Chain, Rc<Problem>> {
    let rest = match behind {
        None => Chain::NONE,
        Some(definition) => definition.chain.clone()?,
    };
    let of_sides = match &own {
        Own::Mixture(_, [a, b]) => a.parts() + b.parts(),
        Own::Antimatter(hiding) => {
            hiding.hidden.iter().map(|definition| definition.chain.as_ref().map_or(1, Chain::parts)).sum()
        }
        _ => 0,
    };
    let parts = 1 + rest.parts() + of_sides;
    if parts > MOST_PARTS {
        let expected = format!("at most {MOST_PARTS} modifiers in all of \"{name}\"");
        return Err(Rc::new(Problem::value(at, expected, parts.to_string())));
    }
    let is_material = matches!(rest, Chain::Material(..));
    let misplaced = |what: &str, expected: &str| {
        let kind = if is_material { "material" } else { "modifier" };
        let found =
            behind.map_or_else(String::new, |definition| format!("the {kind} {}", quoted(&definition.name)));
        Rc::new(Problem::value(at, format!("{expected} as the modifier of {what} \"{name}\""), found))
    };
    let before = |modifier: Modifier, rest: Chain| match rest {
        Chain::Modifiers(mut modifiers, _) => {
            modifiers.push(modifier);
            Chain::Modifiers(modifiers, parts)
        }
        Chain::Material(material, _) => Chain::Material(modified(material, vec![modifier], unit), parts),
        // What is on antimatter is not on the objects that it cuts.
        Chain::Antimatter(hiding, _) => Chain::Antimatter(hiding, parts),
    };
    match own {
        // What has no colour has none to modify.
        Own::Material(material @ (Material::Black | Material::Void)) => Ok(Chain::Material(material, 1)),
        Own::Alternate(chain) => Ok(chain),
        Own::Material(material) => match rest {
            Chain::Modifiers(modifiers, _) => Ok(Chain::Material(modified(material, modifiers, unit), parts)),
            _ => Err(misplaced("material", "'void', a pattern or a texture")),
        },
        Own::Antimatter(hiding) => match rest {
            Chain::Modifiers(..) => Ok(Chain::Antimatter(hiding, parts)),
            _ => Err(misplaced("antimatter", "'void', a pattern or a texture")),
        },
        Own::Mixture(_, [Chain::Antimatter(..), _] | [_, Chain::Antimatter(..)]) => {
            let expected = format!("materials other than antimatter in the mixture \"{name}\"");
            Err(Rc::new(Problem::value(at, expected, "antimatter")))
        }
        Own::Modifier(modifier) => Ok(before(modifier, rest)),
        Own::Mixture(amount, [Chain::Modifiers(foreground, _), Chain::Modifiers(background, _)]) => {
            Ok(before(Modifier::Mixture { amount, foreground, background }, rest))
        }
        Own::Mixture(amount, sides) => match behind {
            None => {
                let [foreground, background] = sides.map(|side| Box::new(side.into_material()));
                let amount = Arc::new(amount);
                Ok(Chain::Material(Material::Mixture { amount, foreground, background }, parts))
            }
            Some(_) => Err(misplaced("a mixture of materials,", "'void'")),
        },
    }
}

/// A material with modifiers before those it has.
fn modified(material: Material, mut added: Vec<Modifier>, unit: f64) -> Material {
    match material {
        Material::Black | Material::Void => material,
        material if added.is_empty() => material,
        Material::Modified { modifiers, material, unit } => {
            added.extend(modifiers.iter().cloned());
            Material::Modified { modifiers: added.into(), material, unit }
        }
        material => Material::Modified { modifiers: added.into(), material: Box::new(material), unit },
    }
}
