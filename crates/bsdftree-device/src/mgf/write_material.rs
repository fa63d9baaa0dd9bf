//! Materials as MGF says them.
//!
//! In: a material in metres. Out: MGF's entities for it, in a unit of length, and what they do not say. Source: rad2mgf of Radiance 6.1,
//! observed. Deviations: chromaticities and reflectances have all their digits (there: six), a pane reflects what a pane of that
//! transmissivity reflects, and nothing is dropped without being listed.

use std::fmt::{self, Write};
use std::sync::Arc;

use bsdftree::Lobes;
use glam::DVec3;

use super::formula;
use super::material::{ONE_SIDED_THICKNESS, chromaticity, fresnel, pane_reflectance};
use super::sides::of_front_only;
use crate::material::{Gloss, GlossKind, Material, Medium, Modifier, Wgmd};

/// Writes the entities after `m name =`; what is lost.
pub(super) fn write_material(
    to: &mut String,
    material: &Material,
    meters: f64,
) -> Result<Vec<&'static str>, fmt::Error> {
    let mut lost = Vec::new();
    match material {
        Material::Void => writeln!(to, "\tts 1 0")?,
        Material::Black => writeln!(to, "\trd 0")?,
        Material::Gloss(gloss) => write_gloss(to, gloss, &mut lost)?,
        Material::Glass { transmissivity, index } => write_glass(to, *transmissivity, *index)?,
        Material::Dielectric { inside, outside } => {
            if *outside != Medium::VACUUM {
                lost.push("the medium in front of the surface");
            }
            if inside.index == outside.index {
                lost.push("that it absorbs on the way through: it does not refract");
            }
            write_dielectric(to, inside, outside, meters)?;
        }
        Material::Mirror { reflectance } => {
            lost.push("that its back is black, and that it reflects no more at grazing incidence");
            specular(to, "rs", *reflectance, 0.0)?;
        }
        Material::Oriented { gloss, .. } => write_gloss(to, gloss, &mut lost)?,
        Material::Function(function) => {
            lost.push("that it is specular by a function: it is diffuse");
            let part = |fraction: f64| function.color * fraction;
            Parts { rd: part(1.0 - function.transmission), td: part(function.transmission), ..Parts::NONE }
                .write(to)?;
        }
        Material::Brtd(brtd) => {
            lost.push("that it is specular by a function: it is diffuse");
            let (rd, td) = (brtd.diffuse_reflection[0], brtd.diffuse_transmission);
            Parts { rd, td, ..Parts::NONE }.write(to)?;
        }
        Material::Measured(measured) => {
            lost.push("that it scatters as a BSDF file says: it is diffuse");
            let total = |lobes| DVec3::splat(measured.file.band().hemispherical([0.0, 0.0, 1.0], lobes));
            Parts { rd: total(Lobes::Reflection), td: total(Lobes::Transmission), ..Parts::NONE }
                .write(to)?;
        }
        Material::Ashikhmin(ashikhmin) => {
            lost.push("that its highlight has another form");
            // The slope whose distribution is as wide.
            let [u, v] = ashikhmin.power.map(|n| (2.0 / (n + 2.0)).sqrt());
            let rs = (ashikhmin.specular, 0.5 * (u + v));
            Parts { rd: ashikhmin.diffuse, rs, ..Parts::NONE }.write(to)?;
        }
        Material::Wgmd(wgmd) => {
            let parts = Parts::of_wgmd(wgmd, &mut lost);
            parts.write(to)?;
        }
        Material::Prism(_) => {
            lost.push("that it sends light elsewhere: it is not there");
            writeln!(to, "\tts 1 0")?;
        }
        Material::Antimatter(_) => {
            lost.push("that it cuts other surfaces: it is not there");
            writeln!(to, "\tts 1 0")?;
        }
        Material::Mixture { foreground, .. } => {
            if let Some(front @ (Material::Gloss(_) | Material::Black | Material::Wgmd(_))) =
                of_front_only(material)
            {
                writeln!(to, "\tsides 1")?;
                return write_material(to, front, meters);
            }
            lost.push("that it is mixed with another material");
            lost.extend(write_material(to, foreground, meters)?);
        }
        Material::Modified { material, .. } => {
            lost.push("its patterns and textures");
            lost.extend(write_material(to, material, meters)?);
        }
    }
    Ok(lost)
}

fn write_gloss(to: &mut String, gloss: &Gloss, lost: &mut Vec<&'static str>) -> fmt::Result {
    let [u, v] = gloss.roughness;
    if u != v {
        lost.push("that its roughness differs along two directions: it has their mean");
    }
    let rough = 0.5 * (u + v);
    let (specular, trans, through) = (gloss.specular, gloss.transmission, gloss.transmitted_specular);
    let luminance = write_color(to, gloss.color)?;
    let inner = luminance * (1.0 - specular);
    if gloss.kind == GlossKind::Trans {
        writeln!(to, "\ttd {:?}", inner * trans * (1.0 - through))?;
        writeln!(to, "\tts {:?} {rough:?}", inner * trans * through)?;
    }
    writeln!(to, "\trd {:?}", inner * (1.0 - trans))?;
    match gloss.kind {
        GlossKind::Metal => writeln!(to, "\trs {:?} {rough:?}", luminance * specular),
        GlossKind::Plastic | GlossKind::Trans => writeln!(to, "\tc\n\trs {specular:?} {rough:?}"),
    }
}

fn write_glass(to: &mut String, transmissivity: DVec3, index: f64) -> fmt::Result {
    let r = fresnel(index);
    let through = |t: f64| (1.0 - r).powi(2) * t / (1.0 - (r * t).powi(2));
    writeln!(to, "\tir {index:?} 0")?;
    specular(to, "rs", transmissivity.map(|t| pane_reflectance(r, t)), 0.0)?;
    specular(to, "ts", transmissivity.map(through), 0.0)
}

fn write_dielectric(to: &mut String, inside: &Medium, outside: &Medium, meters: f64) -> fmt::Result {
    let index = inside.index / outside.index;
    let r = fresnel(index);
    writeln!(to, "\tir {index:?} 0\n\tsides 1")?;
    specular(to, "rs", DVec3::splat(r), 0.0)?;
    let through = inside.transmittance.map(|t| t.powf(ONE_SIDED_THICKNESS * meters));
    specular(to, "ts", through * (1.0 - r), 0.0)
}

/// What MGF says of a surface, each part with its colour; the specular ones with their roughness.
#[derive(Clone, Copy)]
struct Parts {
    rd: DVec3,
    td: DVec3,
    rs: (DVec3, f64),
    ts: (DVec3, f64),
}

impl Parts {
    const NONE: Parts =
        Parts { rd: DVec3::ZERO, td: DVec3::ZERO, rs: (DVec3::ZERO, 0.0), ts: (DVec3::ZERO, 0.0) };

    /// All of it if it is made of numbers.
    fn of_wgmd(wgmd: &Wgmd, lost: &mut Vec<&'static str>) -> Parts {
        let [front, back] = wgmd.diffuse_reflection;
        if front != back {
            lost.push("that its back differs");
        }
        let mut parts = Parts { rd: front, td: wgmd.diffuse_transmission, ..Parts::NONE };
        let specular = |field, modifiers: &Option<Arc<[Modifier]>>| {
            let [fraction, u, v] = formula::numbers(field)?;
            let color = match modifiers.as_deref().unwrap_or_default() {
                [] => DVec3::ONE,
                [Modifier::Color(color)] => DVec3::from_array(formula::numbers(color)?),
                _ => return None,
            };
            (u == v).then_some((color * fraction, u))
        };
        let [of_reflection, of_transmission, of_diffuse] = &wgmd.modifiers;
        let specular =
            [specular(&wgmd.reflection, of_reflection), specular(&wgmd.transmission, of_transmission)];
        match (specular, of_diffuse.as_deref().unwrap_or_default()) {
            ([Some(rs), Some(ts)], []) => (parts.rs, parts.ts) = (rs, ts),
            _ => lost.push("that it is specular by functions, or has patterns: it is diffuse"),
        }
        parts
    }

    /// Less of all if it were more than there is.
    fn write(&self, to: &mut String) -> fmt::Result {
        let all = [self.rd, self.td, self.rs.0, self.ts.0];
        let sum: f64 = all.iter().map(|&part| chromaticity(part).0).sum();
        let [rd, td, rs, ts] = all.map(|part| part / sum.max(1.0));
        diffuse(to, "rd", rd)?;
        diffuse(to, "td", td)?;
        specular(to, "rs", rs, self.rs.1)?;
        specular(to, "ts", ts, self.ts.1)
    }
}

fn diffuse(to: &mut String, keyword: &str, color: DVec3) -> fmt::Result {
    let luminance = write_color(to, color)?;
    writeln!(to, "\t{keyword} {luminance:?}")
}

fn specular(to: &mut String, keyword: &str, color: DVec3, roughness: f64) -> fmt::Result {
    let luminance = write_color(to, color)?;
    writeln!(to, "\t{keyword} {luminance:?} {roughness:?}")
}

/// Makes its chromaticity the current one; its luminance.
fn write_color(to: &mut String, color: DVec3) -> Result<f64, fmt::Error> {
    let (luminance, xy) = chromaticity(color);
    writeln!(to, "\tc")?;
    if let Some([x, y]) = xy {
        writeln!(to, "\t\tcxy {x:?} {y:?}")?;
    }
    Ok(luminance)
}
