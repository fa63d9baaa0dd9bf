//! Materials of a scene file with optics of their own: `BSDF`, `aBSDF`, `ashik2`, `WGMDfunc`, `prism1`, `prism2`.
//!
//! In: a primitive and where it stands. Out: a material, or the [`Problem`] a surface using it runs into. Source: Radiance's
//! reference manual ("Materials"). Deviations: a `BSDF` with a thickness, which stands for geometry behind it, is not there,
//! with a notice: rays meet that geometry itself, as those of a camera do in Radiance; diffuse reflectances, and colours of
//! `ashik2`, outside [0, 1] are refused.

use std::rc::Rc;
use std::sync::Arc;

use glam::DVec3;

use super::field::{FieldReader, Layout};
use super::library::Standing;
use super::modifier::Described;
use super::problem::Problem;
use super::statement::{Primitive, quoted, real};
use super::transform;
use crate::device::NamedMaterial;
use crate::error::DeviceError;
use crate::field::{Field, RayState, Source};
use crate::material::{Ashikhmin, Material, Measured, Orientation, PartModifiers, Prism, Redirection, Wgmd};
use crate::shape::Shape;

/// Whether a type is one of these.
pub(super) fn is_one(kind: &str) -> bool {
    matches!(kind, "BSDF" | "aBSDF" | "ashik2" | "WGMDfunc" | "prism1" | "prism2")
}

/// A ray for formulas that ask nothing of it.
const NOWHERE: RayState = RayState {
    direction: DVec3::NEG_Z,
    normal: DVec3::Z,
    position: DVec3::ZERO,
    distance: 0.0,
    traveled: 0.0,
    uv: [0.0; 2],
    perturbed_normal: DVec3::Z,
    perturbed_cosine: 1.0,
    color: DVec3::ONE,
};

/// Which of the arguments of `WGMDfunc` name modifiers: of reflection, transmission, diffuse transmission.
pub(super) const WGMD_MODIFIERS: [usize; 3] = [0, 4, 8];

/// `n` formulas from string argument `first` on, of a type whose function file is argument `file`.
fn formulas_at(first: usize, file: usize, kind: &str) -> Layout {
    let expected = match kind {
        "BSDF" => "thickness bsdffile ux uy uz funcfile [transform]",
        "aBSDF" => "bsdffile ux uy uz funcfile [transform]",
        "ashik2" => "ux uy uz funcfile [transform]",
        "prism1" => "coef dx dy dz funcfile [transform]",
        "prism2" => "coef1 dx1 dy1 dz1 coef2 dx2 dy2 dz2 funcfile [transform]",
        _ => {
            "rs_mod rs rs_urough rs_vrough ts_mod ts ts_urough ts_vrough td_mod ux uy uz funcfile [transform]"
        }
    };
    Layout { skipped: first, n_functions: file - first, n_data: 0, picture: false, expected }
}

/// Which string argument is the function file.
fn file_at(kind: &str) -> usize {
    match kind {
        "BSDF" => 5,
        "aBSDF" | "prism1" => 4,
        "ashik2" => 3,
        "prism2" => 8,
        _ => 12,
    }
}

/// An error if the numbers of arguments do not fit the type.
pub(super) fn check_counts(p: &Primitive, standing: &Standing) -> Result<(), DeviceError> {
    formulas_at(0, file_at(&p.kind), &p.kind).check(p, standing)?;
    let n = p.reals.len();
    let (right, expected) = match &*p.kind {
        "BSDF" | "aBSDF" => (
            n <= 9 && n.is_multiple_of(3),
            "0, 3, 6 or 9 real arguments (diffuse reflectance of the front, of the back, diffuse transmittance)",
        ),
        "ashik2" => (n == 8, "8 real arguments (dred dgreen dblue sred sgreen sblue upower vpower)"),
        "WGMDfunc" => (
            n >= 9,
            "9 or more real arguments (diffuse reflectance of the front, of the back, diffuse transmittance, A10 …)",
        ),
        _ => (true, ""),
    };
    if right {
        return Ok(());
    }
    Err(DeviceError::Unexpected {
        at: standing.at.clone(),
        expected: format!("{expected} of {} \"{}\"", p.kind, p.name),
        found: n.to_string(),
        advice: String::new(),
    })
}

/// The material of a primitive whose counts are right; `modifiers` are those that a `WGMDfunc` names.
pub(super) fn describe(reader: &mut FieldReader, modifiers: PartModifiers) -> Described<Material> {
    match &*reader.p.kind {
        "BSDF" | "aBSDF" => bsdf(reader),
        "ashik2" => ashikhmin(reader),
        "WGMDfunc" => wgmd(reader, modifiers),
        _ => prism(reader),
    }
}

fn bsdf(reader: &mut FieldReader) -> Described<Material> {
    let through = reader.p.kind == "aBSDF";
    let first = usize::from(!through);
    let mut notices = Vec::new();
    if !through {
        let thickness = thickness(reader)?;
        if thickness != 0.0 {
            let notice = format!(
                "its thickness of {thickness} makes it stand for geometry that rays meet themselves, so it is not there: \
                 if that geometry is not in the scene, write 0 for the thickness"
            );
            return Ok((Material::Void, Some(notice)));
        }
    }
    let told = reader.library.bsdf(&reader.p.strings[first], reader.standing)?;
    let (file, of_file) = &*told;
    notices.extend(of_file.iter().cloned());
    let (up, notice) = orientation(reader, first + 1)?;
    notices.extend(notice);
    let mut diffuse = [DVec3::ZERO; 3];
    let names =
        ["diffuse reflectance of the front", "diffuse reflectance of the back", "diffuse transmittance"];
    for (k, diffuse) in diffuse.iter_mut().enumerate().take(reader.p.reals.len() / 3) {
        *diffuse = color(reader, 3 * k, names[k])?;
    }
    let measured = Measured { file: file.clone(), up, diffuse, through };
    Ok((Material::Measured(Arc::new(measured)), (!notices.is_empty()).then(|| notices.join("; "))))
}

/// The thickness, which may be a constant of the function file.
fn thickness(reader: &mut FieldReader) -> Result<f64, Rc<Problem>> {
    if let Some(thickness) = real(&reader.p.strings[0]) {
        return Ok(thickness);
    }
    let (field, _) = reader.field::<1>(formulas_at(0, file_at("BSDF"), "BSDF"))?;
    let is_constant = is_constant(&field);
    let problem = |found: String| {
        let expected = format!("a thickness that is the same everywhere in {}", reader.name());
        Rc::new(Problem::value(reader.standing.at, expected, found))
    };
    if !is_constant {
        return Err(problem(format!("{}, which depends on the ray", quoted(&reader.p.strings[0]))));
    }
    field.at(&NOWHERE).map(|[thickness]| thickness).map_err(|e| problem(e.reason.to_string()))
}

/// Whether a field asks nothing of a ray.
fn is_constant<const N: usize>(field: &Field<N>) -> bool {
    matches!(&field.source, Source::Formulas(formulas) if !formulas.expressions.uses().any_channel())
}

fn ashikhmin(reader: &mut FieldReader) -> Described<Material> {
    let (orientation, notice) = orientation(reader, 0)?;
    let mut power = [0.0; 2];
    for (k, power) in power.iter_mut().enumerate() {
        *power = reader.p.reals[6 + k];
        if *power < 0.0 {
            let expected = format!("a specular power of at least 0 in {}", reader.name());
            return Err(Rc::new(Problem::value(reader.standing.at, expected, power.to_string())));
        }
    }
    let material = Ashikhmin {
        diffuse: color(reader, 0, "diffuse colour")?,
        specular: color(reader, 3, "specular colour")?,
        power,
        orientation,
    };
    Ok((Material::Ashikhmin(material), notice))
}

fn wgmd(reader: &mut FieldReader, modifiers: PartModifiers) -> Described<Material> {
    let file = file_at("WGMDfunc");
    let [reflection, transmission, orientation] = [1, 5, 9].map(|first| formulas_at(first, file, "WGMDfunc"));
    let (reflection, notice) = reader.field(reflection)?;
    let material = Wgmd {
        diffuse_reflection: [
            color(reader, 0, "diffuse reflectance of the front")?,
            color(reader, 3, "diffuse reflectance of the back")?,
        ],
        diffuse_transmission: color(reader, 6, "diffuse transmittance")?,
        reflection,
        transmission: reader.field(transmission)?.0,
        orientation: reader.field(orientation)?.0,
        modifiers,
    };
    Ok((Material::Wgmd(Arc::new(material)), notice))
}

fn prism(reader: &mut FieldReader) -> Described<Material> {
    let kind = &*reader.p.kind;
    let n = if kind == "prism1" { 1 } else { 2 };
    let layouts: Vec<[Layout; 2]> =
        (0..n).map(|k| [4 * k, 4 * k + 1].map(|first| formulas_at(first, file_at(kind), kind))).collect();
    let mut redirections = Vec::new();
    let mut notice = None;
    for [coefficient, direction] in layouts {
        let (coefficient, of_field) = reader.field(coefficient)?;
        redirections.push(Redirection { coefficient, direction: reader.field(direction)?.0 });
        notice = of_field;
    }
    Ok((Material::Prism(Arc::new(Prism { redirections })), notice))
}

/// The direction of the string arguments from `first` on: numbers, or formulas of the function file.
fn orientation(reader: &mut FieldReader, first: usize) -> Described<Orientation> {
    let words = &reader.p.strings[first..first + 3];
    let numbers: Vec<f64> = words.iter().filter_map(|word| real(word)).collect();
    let [x, y, z] = numbers[..] else {
        let layout = formulas_at(first, file_at(&reader.p.kind), &reader.p.kind);
        let (field, notice) = reader.field::<3>(layout)?;
        let orientation = match is_constant(&field).then(|| field.vector(&NOWHERE)) {
            Some(Ok(direction)) => Orientation::Constant(direction),
            // What fails does so again where it is used, and is told there.
            _ => Orientation::Varying(Arc::new(field)),
        };
        return Ok((orientation, notice));
    };
    let own = transform::single(&reader.p.strings[first + 4..]).map_err(|wrong| {
        let expected = format!("{} in {}", wrong.expected, reader.name());
        Rc::new(Problem::value(reader.standing.at, expected, wrong.found))
    })?;
    let direction = own.then(reader.to).vector(DVec3::new(x, y, z));
    if direction.try_normalize().is_none() {
        let expected = format!("a direction ux uy uz in {}", reader.name());
        return Err(Rc::new(Problem::value(reader.standing.at, expected, "a vector of no length")));
    }
    Ok((Orientation::Constant(direction), None))
}

/// What the user should know of a flat surface whose normal is the up direction of its BSDF, so that right and up are not told.
pub(super) fn lost_orientation(named: &NamedMaterial, shape: &Shape) -> Option<String> {
    let mut material = &named.material;
    while let Material::Modified { material: inner, .. } = material {
        material = inner;
    }
    let Material::Measured(measured) = material else { return None };
    let Orientation::Constant(up) = measured.up else { return None };
    let normal = match shape {
        Shape::Polygon(vertices) => {
            vertices.iter().zip(vertices.iter().cycle().skip(1)).map(|(a, b)| a.cross(*b)).sum::<DVec3>()
        }
        Shape::Ring { normal, .. } => *normal,
        _ => return None,
    };
    let is_lost = normal.normalize_or_zero().cross(up.normalize_or_zero()).length() < 1e-9;
    (is_lost && !measured.file.is_isotropic()).then(|| {
        format!("its normal is the up direction of BSDF \"{}\": it is black; give another one", named.name)
    })
}

fn color(reader: &FieldReader, k: usize, name: &str) -> Result<DVec3, Rc<Problem>> {
    let mut color = DVec3::ZERO;
    for channel in 0..3 {
        color[channel] = reader.p.reals[k + channel];
        if !(0.0..=1.0).contains(&color[channel]) {
            let expected = format!("{name} between 0 and 1 in {}", reader.name());
            return Err(Rc::new(Problem::value(reader.standing.at, expected, color[channel].to_string())));
        }
    }
    Ok(color)
}
