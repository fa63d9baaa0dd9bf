//! Materials of a scene file that are functions: `plasfunc`, `metfunc`, `transfunc`, `BRTDfunc`, `plasdata`, `metdata`,
//! `transdata`.
//!
//! In: a primitive and where it stands. Out: a material, or the [`Problem`] a surface using it runs into. Source: Radiance's
//! reference manual ("Materials"). Deviation: reflectances outside [0, 1] are refused, as of other materials; what the functions
//! give is not limited.

use std::rc::Rc;
use std::sync::Arc;

use glam::DVec3;

use super::field::{FieldReader, Layout};
use super::library::Standing;
use super::modifier::Described;
use super::problem::Problem;
use super::statement::Primitive;
use crate::error::DeviceError;
use crate::material::{BrtdFunction, FunctionGloss, GlossKind, Material};

/// Whether a type is one of these.
pub(super) fn is_one(kind: &str) -> bool {
    matches!(kind, "plasfunc" | "metfunc" | "transfunc" | "BRTDfunc" | "plasdata" | "metdata" | "transdata")
}

fn layout(kind: &str) -> Layout {
    let (n_functions, n_data, expected) = match kind {
        "BRTDfunc" => (9, 0, "rrefl grefl brefl rtrns gtrns btrns rbrtd gbrtd bbrtd funcfile [transform]"),
        _ if kind.ends_with("data") => (1, 1, "func datafile funcfile x0 [x1 …] [transform]"),
        _ => (1, 0, "refl funcfile [transform]"),
    };
    Layout { skipped: 0, n_functions, n_data, picture: false, expected }
}

/// An error if the numbers of arguments do not fit the type.
pub(super) fn check_counts(p: &Primitive, standing: &Standing) -> Result<(), DeviceError> {
    layout(&p.kind).check(p, standing)?;
    let (least, expected) = match &*p.kind {
        "BRTDfunc" => (
            9,
            "9 or more real arguments (diffuse reflection of front and back, diffuse transmission, A10 …)",
        ),
        "transfunc" | "transdata" => {
            (6, "6 or more real arguments (red green blue specularity trans tspec A7 …)")
        }
        _ => (4, "4 or more real arguments (red green blue specularity A5 …)"),
    };
    if p.reals.len() >= least {
        return Ok(());
    }
    Err(DeviceError::Unexpected {
        at: standing.at.clone(),
        expected: format!("{expected} of {} \"{}\"", p.kind, p.name),
        found: p.reals.len().to_string(),
        advice: String::new(),
    })
}

/// The material of a primitive whose counts are right.
pub(super) fn describe(mut reader: FieldReader) -> Described<Material> {
    if reader.p.kind == "BRTDfunc" {
        return brtd(&mut reader);
    }
    let kind = match &*reader.p.kind {
        "plasfunc" | "plasdata" => GlossKind::Plastic,
        "metfunc" | "metdata" => GlossKind::Metal,
        _ => GlossKind::Trans,
    };
    let (lobe, notice) = reader.lobe(layout(&reader.p.kind))?;
    let of_trans = |k, name| if kind == GlossKind::Trans { fraction(&reader, k, name) } else { Ok(0.0) };
    let material = FunctionGloss {
        kind,
        color: color(&reader, 0, "colour")?,
        specular: fraction(&reader, 3, "specularity")?,
        transmission: of_trans(4, "transmission")?,
        transmitted_specular: of_trans(5, "transmitted specularity")?,
        lobe,
    };
    Ok((Material::Function(Arc::new(material)), notice))
}

fn brtd(reader: &mut FieldReader) -> Described<Material> {
    let layout = layout(&reader.p.kind);
    let functions = reader.functions(layout)?;
    let names = &reader.p.strings[6..9];
    let mut lobe = [None, None, None];
    for (lobe, name) in lobe.iter_mut().zip(names) {
        // Radiance takes '0' for no function.
        *lobe = if name == "0" { None } else { Some(reader.call(&functions, name, 4)?) };
    }
    let (space, notice) = reader.space(&functions, layout.file() + 1)?;
    let material = BrtdFunction {
        diffuse_reflection: [
            color(reader, 0, "diffuse reflectance of the front")?,
            color(reader, 3, "diffuse reflectance of the back")?,
        ],
        diffuse_transmission: color(reader, 6, "diffuse transmittance")?,
        space,
        specular: reader.formulas(&functions, 0, 6)?,
        lobe,
    };
    Ok((Material::Brtd(Arc::new(material)), notice))
}

fn color(reader: &FieldReader, k: usize, name: &str) -> Result<DVec3, Rc<Problem>> {
    Ok(DVec3::new(fraction(reader, k, name)?, fraction(reader, k + 1, name)?, fraction(reader, k + 2, name)?))
}

fn fraction(reader: &FieldReader, k: usize, name: &str) -> Result<f64, Rc<Problem>> {
    let value = reader.p.reals[k];
    if (0.0..=1.0).contains(&value) {
        return Ok(value);
    }
    let expected = format!("{name} between 0 and 1 in {}", reader.name());
    Err(Rc::new(Problem::value(reader.standing.at, expected, value.to_string())))
}
