//! MGF's materials to Radiance's.
//!
//! In: a [`Finish`]. Out: the [`Material`] that mgf2rad chooses for it, and what the user should know. Source: mgf2rad of
//! Radiance 6.1, observed. Emitters are black. Deviations, each where mgf2rad loses something that is said:
//! * `glass` gets the transmissivity whose transmittance at normal incidence is `ts` (mgf2rad takes `ts` + `rs`, which is up to 0.02
//!   too much), `dielectric` what leaves `ts` after one Fresnel reflection.
//! * What has a refractive index, is smooth, not diffuse, and reflects as glass of that index would, is glass, however dark.
//! * All that is transmitted is kept (mgf2rad drops `td` + `ts` of up to 0.01), and `trans` without diffuse reflection is as bright as said.
//! * White highlights over a coloured diffuse part make a `plastic`, however strong, and highlights of the same colour a `metal`,
//!   however weak; mgf2rad goes by their strength.
//! * Tinted highlights of what transmits keep their colour.
//! * `ts 1 0` alone is nothing at all, as rad2mgf means it; what neither reflects nor transmits is black.

use std::sync::Arc;

use bsdftree::color::xyz_from_rgb;
use glam::DVec3;

use super::color::{Color, towards_grey};
use super::finish::{Diffuse, Finish, Specular};
use super::formula;
use super::sides;
use crate::error::Place;
use crate::field::Field;
use crate::material::{
    Gloss, GlossKind, Material, Medium, Modifier, Wgmd, transmissivity_from_transmittance,
};

/// Radiance's material, and what to tell.
#[derive(Clone, Debug)]
pub(super) struct Described {
    pub material: Material,
    pub notices: Vec<&'static str>,
}

/// The thickness that a one-sided transmittance is of \[units of the file\].
pub(super) const ONE_SIDED_THICKNESS: f64 = 0.005;

const PALER: &str = "it is paler: its colour is too saturated to be so bright";
const CLEAR: &str = "it is clear: it cannot transmit more, because of what its surfaces reflect";

/// The material of a name in metres, from a file whose unit of length is so long; the sum of what it reflects and transmits if that is
/// more than 1.
pub(super) fn describe(finish: &Finish, name: &str, meters: f64) -> Result<Described, f64> {
    let Finish { rd, td, rs, ts, .. } = *finish;
    let sum = rd.amount + td.amount + rs.amount + ts.amount;
    // Numbers are decimal; mgf2rad adds up those it rounded to single precision.
    if sum > 1.0 + 1e-6 {
        return Err(sum);
    }
    let mut describer = Describer { finish, name, notices: Vec::new() };
    if finish.ed > 0.0 {
        describer.notices.push("its light is left out");
    }
    let material = if finish.ed > 0.1 {
        Material::Black
    } else if sum == 0.0 {
        describer.sided(Material::Black)
    } else if is_nothing(finish) {
        Material::Void
    } else if let Some(transmittance) = describer.is_clear().then(|| ts.color.rgb(ts.amount)) {
        if finish.one_sided { describer.solid(transmittance, meters) } else { describer.pane(transmittance) }
    } else if is_of_parts(finish) {
        let parts = describer.parts();
        describer.sided(parts)
    } else if td.amount + ts.amount > 0.0 {
        let trans = describer.trans();
        describer.sided(trans)
    } else {
        let opaque = if is_plastic(rd, rs) { describer.plastic() } else { describer.metal() };
        describer.sided(opaque)
    };
    Ok(Described { material, notices: describer.notices })
}

fn is_nothing(finish: &Finish) -> bool {
    finish.ts == (Specular { amount: 1.0, ..Specular::default() }) && finish.index <= LEAST_INDEX
}

/// Less is taken for no index.
const LEAST_INDEX: f64 = 1.1;

/// Reflectance of a boundary at normal incidence.
pub(super) fn fresnel(index: f64) -> f64 {
    ((index - 1.0) / (index + 1.0)).powi(2)
}

/// Reflectance at normal incidence of a pane of this transmissivity whose faces reflect `r`: r + (1−r)² r t² / (1 − r² t²).
pub(super) fn pane_reflectance(r: f64, t: f64) -> f64 {
    r + (1.0 - r).powi(2) * r * t * t / (1.0 - (r * t).powi(2))
}

/// Plastic says exactly what has white highlights, metal what has highlights of its own colour; else, and if both do, it goes by their
/// strength.
fn is_plastic(rd: Diffuse, rs: Specular) -> bool {
    let white = rs.color == Color::NEUTRAL;
    let own = rd.amount == 0.0 || rd.color.is_same(rs.color);
    if white != own {
        return white;
    }
    rs.amount < 0.1 && (rs.amount < 0.1 * rd.amount || rs.color.is_grey())
}

/// Whether its parts are too different for the simple materials: in roughness, or in colour.
fn is_of_parts(finish: &Finish) -> bool {
    let Finish { rd, td, rs, ts, .. } = *finish;
    let clash = |a: (f64, Color), b: (f64, Color)| a.0 > 0.01 && b.0 > 0.01 && !a.1.is_like(b.1);
    let [rd_, td_, ts_] = [(rd.amount, rd.color), (td.amount, td.color), (ts.amount, ts.color)];
    let rough = rs.amount > 0.02 && ts.amount > 0.02 && (rs.roughness - ts.roughness).abs() > 0.02;
    let tinted = !rs.color.is_grey();
    let beside = rs.amount > 0.05 && rd.amount > 0.05 && tinted && !rs.color.is_like(rd.color);
    let over = rs.amount > 0.01 && td.amount + ts.amount > 0.01 && tinted;
    rough || beside || over || clash(ts_, td_) || clash(td_, rd_) || clash(rd_, ts_)
}

struct Describer<'a> {
    finish: &'a Finish,
    name: &'a str,
    notices: Vec<&'static str>,
}

impl Describer<'_> {
    /// Whether it is a smooth boundary of something that refracts.
    fn is_clear(&self) -> bool {
        const SMOOTH: f64 = 0.01;
        const NOT_DIFFUSE: f64 = 0.01;
        let Finish { rd, td, rs, ts, index, .. } = *self.finish;
        let plain = index != 1.0
            && ts.amount > 0.0
            && rd.amount <= NOT_DIFFUSE
            && td.amount <= NOT_DIFFUSE
            && rs.roughness <= SMOOTH
            && ts.roughness <= SMOOTH;
        let mgf2rad = index > LEAST_INDEX && ts.amount > 0.25 && rs.amount <= 0.125;
        plain && (mgf2rad || self.reflects_as_glass())
    }

    /// Whether `rs` is what a boundary, or a pane that transmits `ts`, reflects.
    fn reflects_as_glass(&self) -> bool {
        const ROUNDED: f64 = 0.01;
        let Finish { rs, ts, index, .. } = *self.finish;
        let r = fresnel(index);
        let near = |least: f64, most: f64| (least - ROUNDED..=most + ROUNDED).contains(&rs.amount);
        if self.finish.one_sided {
            return near(r, r);
        }
        let transmissivity = ts.color.rgb(ts.amount).map(|t| transmissivity_from_transmittance(t, index));
        let luminance = |of: &dyn Fn(f64) -> f64| xyz_from_rgb(transmissivity.map(of).to_array())[1];
        // rad2mgf forgets a square, so panes that absorb reflect more there.
        let rad2mgf = |t: f64| r * (1.0 + (1.0 - 2.0 * r) * t) / (1.0 - (r * t).powi(2));
        near(luminance(&|t| pane_reflectance(r, t)), luminance(&rad2mgf))
    }

    /// As many sides as it has; those of a clear solid are what bounds it.
    fn sided(&self, material: Material) -> Material {
        if self.finish.one_sided { sides::front_only(material, self.name, &self.place()) } else { material }
    }

    fn pane(&mut self, transmittance: DVec3) -> Material {
        let index = self.finish.index;
        let transmissivity = transmittance.map(|t| transmissivity_from_transmittance(t, index));
        self.note_diffuse();
        Material::Glass { transmissivity: self.at_most_clear(transmissivity), index }
    }

    fn solid(&mut self, transmittance: DVec3, meters: f64) -> Material {
        let index = self.finish.index;
        let through = self.at_most_clear(transmittance / (1.0 - fresnel(index)));
        self.note_diffuse();
        let transmittance = through.map(|t| t.powf(1.0 / (ONE_SIDED_THICKNESS * meters)));
        Material::Dielectric { inside: Medium { transmittance, index }, outside: Medium::VACUUM }
    }

    fn at_most_clear(&mut self, transmittance: DVec3) -> DVec3 {
        // Of numbers that were written with three digits.
        if transmittance.max_element() > 1.0 + 5e-3 {
            self.notices.push(CLEAR);
        }
        transmittance.min(DVec3::ONE)
    }

    fn note_diffuse(&mut self) {
        if self.finish.rd.amount + self.finish.td.amount > 0.0 {
            self.notices.push("its diffuse part is left out: it is clear");
        }
    }

    fn trans(&mut self) -> Material {
        let Finish { rd, td, rs, ts, .. } = *self.finish;
        let inner = rd.amount + td.amount + ts.amount;
        let color = rd.color.rgb(rd.amount) + td.color.rgb(td.amount) + ts.color.rgb(ts.amount);
        let both = rs.amount + ts.amount;
        let roughness = match both > 0.0 {
            true => (rs.amount * rs.roughness + ts.amount * ts.roughness) / both,
            false => 0.0,
        };
        let through = td.amount + ts.amount;
        Material::Gloss(Gloss {
            kind: GlossKind::Trans,
            // Rounding may leave nothing beside the highlight.
            color: self.within(color / inner.max(1.0 - rs.amount)),
            specular: rs.amount,
            roughness: [roughness; 2],
            orientation: None,
            transmission: through / inner,
            transmitted_specular: ts.amount / through,
        })
    }

    /// `WGMDfunc`: each part by itself.
    fn parts(&mut self) -> Material {
        let Finish { rd, td, rs, ts, .. } = *self.finish;
        let [rd, td] = [rd, td].map(|part| self.within(part.color.rgb(part.amount)));
        let reals = [rd, rd, td].map(|color| color.to_array()).concat();
        let (reflection, of_reflection) = self.specular(rs, &reals);
        let (transmission, of_transmission) = self.specular(ts, &reals);
        Material::Wgmd(Arc::new(Wgmd {
            diffuse_reflection: [rd; 2],
            diffuse_transmission: td,
            reflection,
            transmission,
            orientation: self.constant([0.0, 0.0, 1.0], &reals),
            modifiers: [Some(of_reflection), Some(of_transmission), Some(Arc::from([]))],
        }))
    }

    /// Fraction and roughness, and the pattern that colours them.
    fn specular(&mut self, part: Specular, reals: &[f64]) -> (Field<3>, Arc<[Modifier]>) {
        let color = self.within(part.color.rgb(part.amount));
        let (fraction, pattern) = match part.color == Color::NEUTRAL {
            true => (part.amount, Vec::new()),
            false => (1.0, vec![Modifier::Color(self.constant(color.to_array(), &[]))]),
        };
        (self.constant([fraction, part.roughness, part.roughness], reals), pattern.into())
    }

    fn constant(&self, numbers: [f64; 3], reals: &[f64]) -> Field<3> {
        formula::constant(numbers, reals, "material", self.name, &self.place())
    }

    fn place(&self) -> Place {
        self.finish.at.clone().unwrap_or_else(|| Place { file: "".into(), line: 0 })
    }

    fn plastic(&mut self) -> Material {
        let Finish { rd, rs, .. } = *self.finish;
        let color = match rd.amount > 0.0 {
            true => rd.color.rgb(rd.amount / rd.amount.max(1.0 - rs.amount)),
            false => DVec3::ZERO,
        };
        self.reflector(GlossKind::Plastic, color, rs.amount)
    }

    fn metal(&mut self) -> Material {
        let Finish { rd, rs, .. } = *self.finish;
        let all = rs.amount + rd.amount;
        let color = match rd.color.is_same(rs.color) {
            true => rs.color.rgb(all),
            false => rs.color.rgb(rs.amount) + rd.color.rgb(rd.amount),
        };
        self.reflector(GlossKind::Metal, color, rs.amount / all)
    }

    fn reflector(&mut self, kind: GlossKind, color: DVec3, specular: f64) -> Material {
        Material::Gloss(Gloss {
            kind,
            color: self.within(color),
            specular,
            roughness: [self.finish.rs.roughness; 2],
            orientation: None,
            transmission: 0.0,
            transmitted_specular: 0.0,
        })
    }

    /// The colour, paler if it would reflect more of a primary than there is.
    fn within(&mut self, color: DVec3) -> DVec3 {
        const ROUNDED: f64 = 1e-6;
        if color.max_element() > 1.0 + ROUNDED {
            self.notices.push(PALER);
        }
        let luminance = xyz_from_rgb(color.to_array())[1].min(1.0);
        towards_grey(color, luminance, 0.0..=1.0)
    }
}

/// The colour as MGF says it: its luminance, and its chromaticity unless it is grey.
pub(super) fn chromaticity(rgb: DVec3) -> (f64, Option<[f64; 2]>) {
    if rgb.x == rgb.y && rgb.y == rgb.z {
        return (rgb.x, None);
    }
    let [x, y, z] = xyz_from_rgb(rgb.to_array());
    (y, Some([x / (x + y + z), y / (x + y + z)]))
}
