//! Material primitives of a scene file to [`Material`]s.
//!
//! In: a primitive and the transformation to metres, which turns the orientation of anisotropic materials and changes
//! transmittances per unit length. Out: a material with an optional notice, or the [`Problem`] that a surface using
//! it runs into. Source: Radiance reference manual, "Materials". Deviations: reflectances outside [0, 1] are refused;
//! emitters are black; dispersion (Hartmann's constant) is left out, with a notice.

use std::ops::RangeInclusive;
use std::sync::Arc;

use glam::DVec3;

use super::field::{FieldReader, Layout};
use super::modifier::Described;
use super::problem::Problem;
use super::shape::unit;
use super::statement::{Primitive, quoted, real};
use super::transform::{self, Transform};
use crate::error::{DeviceError, Place};
use crate::material::{Gloss, GlossKind, Material, Medium};

/// The string arguments of anisotropic materials.
const ORIENTATION: Layout = Layout {
    skipped: 0,
    n_functions: 3,
    n_data: 0,
    picture: false,
    expected: "ux uy uz funcfile [transform]",
};

/// The real arguments of a material type: how many, and what they are.
fn expected_reals(kind: &str) -> (RangeInclusive<usize>, &'static str) {
    match kind {
        "plastic" | "metal" => (5..=5, "5 real arguments (red green blue specularity roughness)"),
        "plastic2" | "metal2" => {
            (6..=6, "6 real arguments (red green blue specularity uroughness vroughness)")
        }
        "trans" => (7..=7, "7 real arguments (red green blue specularity roughness trans tspec)"),
        "trans2" => {
            (8..=8, "8 real arguments (red green blue specularity uroughness vroughness trans tspec)")
        }
        "glass" => (3..=4, "3 or 4 real arguments (red green blue [index])"),
        "dielectric" => (5..=5, "5 real arguments (red green blue index hartmann)"),
        "interface" => (8..=8, "8 real arguments (red green blue index, inside and outside)"),
        "glow" => (4..=4, "4 real arguments (red green blue maxrad)"),
        "spotlight" => (7..=7, "7 real arguments (red green blue angle xdir ydir zdir)"),
        _ => (3..=3, "3 real arguments (red green blue)"),
    }
}

/// The string arguments of a material type.
fn expected_strings(kind: &str) -> (RangeInclusive<usize>, &'static str) {
    match kind {
        "plastic2" | "metal2" | "trans2" => {
            (4..=usize::MAX, "string arguments ux uy uz funcfile [transform]")
        }
        "mirror" | "illum" => (0..=1, "at most 1 string argument (the alternate material)"),
        _ => (0..=0, "no string arguments"),
    }
}

/// An error if the numbers of arguments do not fit the type.
pub(super) fn check_counts(p: &Primitive, at: &Place) -> Result<(), DeviceError> {
    let (reals, strings) = (expected_reals(&p.kind), expected_strings(&p.kind));
    for ((range, expected), n) in [(reals, p.reals.len()), (strings, p.strings.len())] {
        if !range.contains(&n) {
            return Err(DeviceError::Unexpected {
                at: at.clone(),
                expected: format!("{expected} of {} \"{}\"", p.kind, p.name),
                found: n.to_string(),
                advice: String::new(),
            });
        }
    }
    Ok(())
}

/// The material of a primitive whose counts are right. `illum` is its light only: black.
pub(super) fn describe(mut fields: FieldReader) -> Described<Material> {
    let (p, to) = (fields.p, fields.to);
    if p.kind.ends_with('2') && !has_constant_orientation(p) {
        let gloss = Reader { p, at: fields.standing.at }.gloss(None)?;
        let (orientation, notice) = fields.field(ORIENTATION)?;
        return Ok((Material::Oriented { gloss, orientation: Arc::new(orientation) }, notice));
    }
    Ok(constant(&Reader { p, at: fields.standing.at }, to)?)
}

/// Whether `ux uy uz` are numbers, which no function file is needed for.
fn has_constant_orientation(p: &Primitive) -> bool {
    p.strings[..3].iter().all(|word| real(word).is_some())
}

fn constant(reader: &Reader, to: &Transform) -> Result<(Material, Option<String>), Problem> {
    let p = reader.p;
    match &*p.kind {
        "plastic" | "metal" | "trans" | "plastic2" | "metal2" | "trans2" => {
            Ok((Material::Gloss(reader.gloss(Some(to))?), None))
        }
        "glass" => {
            let index = if p.reals.len() == 4 { reader.index(3)? } else { 1.52 };
            Ok((Material::Glass { transmissivity: reader.color(0, "transmissivity")?, index }, None))
        }
        "dielectric" => {
            let notice =
                (p.reals[4] != 0.0).then(|| "the Hartmann constant is left out: no dispersion".to_owned());
            let inside = reader.medium(0, to)?;
            Ok((Material::Dielectric { inside, outside: Medium::VACUUM }, notice))
        }
        "interface" => {
            let (inside, outside) = (reader.medium(0, to)?, reader.medium(4, to)?);
            Ok((Material::Dielectric { inside, outside }, None))
        }
        "mirror" => {
            let notice = p.strings.first().map(|alternate| {
                format!("its alternate material {} is left out: it stays a mirror", quoted(alternate))
            });
            Ok((Material::Mirror { reflectance: reader.color(0, "reflectance")? }, notice))
        }
        _ => {
            let emits = p.reals[..3].iter().any(|&x| x != 0.0);
            Ok((Material::Black, emits.then(|| "its light is left out: it is black".to_owned())))
        }
    }
}

struct Reader<'a> {
    p: &'a Primitive,
    at: &'a Place,
}

impl Reader<'_> {
    /// Without a transformation the orientation is left open.
    fn gloss(&self, to: Option<&Transform>) -> Result<Gloss, Problem> {
        let anisotropic = self.p.kind.ends_with('2');
        let v_roughness = if anisotropic { 5 } else { 4 };
        let trans = self.p.kind.starts_with("trans");
        let kind = match &*self.p.kind {
            "plastic" | "plastic2" => GlossKind::Plastic,
            "metal" | "metal2" => GlossKind::Metal,
            _ => GlossKind::Trans,
        };
        let of_trans = |k, name| if trans { self.fraction(k, name) } else { Ok(0.0) };
        Ok(Gloss {
            kind,
            color: self.color(0, "colour")?,
            specular: self.fraction(3, "specularity")?,
            roughness: [self.roughness(4)?, self.roughness(v_roughness)?],
            orientation: to.filter(|_| anisotropic).map(|to| self.orientation(to)).transpose()?,
            transmission: of_trans(v_roughness + 1, "transmission")?,
            transmitted_specular: of_trans(v_roughness + 2, "transmitted specularity")?,
        })
    }

    /// The unit vector u of `ux uy uz funcfile transform`.
    fn orientation(&self, to: &Transform) -> Result<DVec3, Problem> {
        let strings = &self.p.strings;
        let mut u = DVec3::ZERO;
        for k in 0..3 {
            u[k] = real(&strings[k]).unwrap_or_default();
        }
        let own = transform::single(strings.get(4..).unwrap_or_default())
            .map_err(|wrong| self.value(&wrong.expected, &wrong.found))?;
        unit(own.then(to).vector(u))
            .ok_or_else(|| self.value("a direction ux uy uz", "a vector of no length"))
    }

    fn medium(&self, k: usize, to: &Transform) -> Result<Medium, Problem> {
        let transmittance = self.color(k, "transmittance per unit length")?;
        let index = self.index(k + 3)?;
        // What one unit of length lets through, 1/scale units let through at this power.
        let per_meter = if to.scale == 1.0 { transmittance } else { transmittance.powf(to.scale.recip()) };
        Ok(Medium { transmittance: per_meter, index })
    }

    fn color(&self, k: usize, name: &str) -> Result<DVec3, Problem> {
        Ok(DVec3::new(self.fraction(k, name)?, self.fraction(k + 1, name)?, self.fraction(k + 2, name)?))
    }

    fn fraction(&self, k: usize, name: &str) -> Result<f64, Problem> {
        self.within(k, (0.0..=1.0).contains(&self.p.reals[k]), &format!("{name} between 0 and 1"))
    }

    fn roughness(&self, k: usize) -> Result<f64, Problem> {
        self.within(k, self.p.reals[k] >= 0.0, "roughness of at least 0")
    }

    fn index(&self, k: usize) -> Result<f64, Problem> {
        self.within(k, self.p.reals[k] > 0.0, "index of refraction above 0")
    }

    fn within(&self, k: usize, right: bool, expected: &str) -> Result<f64, Problem> {
        let value = self.p.reals[k];
        if right { Ok(value) } else { Err(self.value(expected, &value.to_string())) }
    }

    fn value(&self, expected: &str, found: &str) -> Problem {
        Problem::value(self.at, format!("{expected} in {}", self.name()), found)
    }

    fn name(&self) -> String {
        format!("{} \"{}\"", self.p.kind, self.p.name)
    }
}
