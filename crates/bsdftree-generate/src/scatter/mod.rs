//! How a ray scatters at a surface.
//!
//! In: a material, a [`Meeting`] of a ray and a surface, random numbers. Out: nothing (absorbed), or
//! one new direction with the factor the path's weight takes. Invariant: the mean of that factor over the random numbers,
//! in any solid angle, is the material's BSDF times cosine over it: unbiased, and never more energy out than in.
//! Directions are unit vectors that point along travel. Transcendental functions are the `libm` crate's, not the platform's:
//! results are the same bits on every machine.
//!
//! Source: Radiance's reference manual for the materials; where a file here deviates, it says so.
//!
//! ```
//! use bsdftree_device::material::Material;
//! use bsdftree_generate::random::Random;
//! use bsdftree_generate::scatter::{Meeting, PreparedMaterial};
//! use glam::DVec3;
//!
//! let mirror = PreparedMaterial::<f64>::new(&Material::Mirror { reflectance: DVec3::splat(0.9) });
//! let scatter = mirror.scatter(&Meeting::new(DVec3::Z, DVec3::NEG_Z), &mut Random::new(0, 0, 0)).unwrap();
//! assert_eq!(scatter.direction, DVec3::Z);
//! assert!((scatter.weight - 0.9).abs() < 1e-12);
//! ```

mod ashikhmin;
mod bsdf;
mod choice;
mod dielectric;
mod diffuse;
mod facets;
mod faults;
mod frame;
mod fresnel;
mod function;
mod glass;
mod gloss;
mod meeting;
mod modified;
mod prism;
mod reversed;
mod shading;
mod spectral;
mod spectrum;
#[cfg(test)]
mod radiance_tests;
#[cfg(test)]
mod test_support;
#[cfg(test)]
mod tests;
mod textured;
mod through;
mod wgmd;

use std::sync::Arc;

use bsdftree_device::material::{Gloss, Material, Modifier};
use glam::DVec3;

pub use dielectric::attenuation;
pub use diffuse::lambertian_direction;
pub use faults::Faults;
use faults::Watch;
pub use meeting::{Local, Meeting};
use shading::{Shade, Shading};
pub use spectral::Spectral;
pub use spectrum::{Flux, Spectrum, Xyz};

use crate::random::Random;

/// Where a ray goes on from a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter<S> {
    /// Unit vector along travel.
    pub direction: DVec3,
    /// What the path's weight is multiplied by.
    pub weight: S,
    /// Whether the ray is now on the other side of the surface.
    pub transmitted: bool,
}

impl<S> Scatter<S> {
    #[inline]
    fn reflected(direction: DVec3, weight: S) -> Self {
        Scatter { direction, weight, transmitted: false }
    }

    #[inline]
    fn transmitted(direction: DVec3, weight: S) -> Self {
        Scatter { direction, weight, transmitted: true }
    }
}

/// A material with all that does not depend on the ray worked out; `S` is what the path carries.
#[derive(Clone, Debug)]
pub struct PreparedMaterial<S>(Prepared<S>);

#[derive(Clone, Debug)]
enum Prepared<S> {
    Void,
    Black,
    Gloss(gloss::PreparedGloss<S>),
    Glass(glass::Pane),
    Dielectric(dielectric::Interface),
    Mirror(S),
    /// Everything that is not constant, or not one of the above.
    Other(Arc<dyn Shading<S>>),
}

impl<S: Spectrum> PreparedMaterial<S> {
    /// Prepares `material`, whose parameters are legal (the reader's business). What its functions fail at is not told: see
    /// [`prepare`](Self::prepare).
    pub fn new(material: &Material) -> Self {
        Self::prepare(material, "", &Arc::default())
    }

    /// Prepares the material of this name, which tells what goes wrong to `faults`.
    pub fn prepare(material: &Material, name: &str, faults: &Arc<Faults>) -> Self {
        Self::watched(material, &Watch::new(name, faults))
    }

    fn watched(material: &Material, watch: &Watch) -> Self {
        let watch = || watch.clone();
        let inner = |material: &Material| Self::watched(material, &watch());
        PreparedMaterial(match material {
            Material::Void => Prepared::Void,
            Material::Black => Prepared::Black,
            Material::Gloss(gloss) => Prepared::Gloss(gloss::PreparedGloss::new(gloss)),
            Material::Glass { transmissivity, index } => {
                Prepared::Glass(glass::Pane::new(*transmissivity, *index))
            }
            Material::Dielectric { inside, outside } => {
                Prepared::Dielectric(dielectric::Interface { inside: *inside, outside: *outside })
            }
            Material::Mirror { reflectance } => Prepared::Mirror(S::from_rgb(*reflectance)),
            Material::Oriented { gloss, orientation } => {
                Prepared::Other(Arc::new(modified::Oriented::new(gloss, orientation, &watch())))
            }
            Material::Function(function) => {
                let function = function.clone();
                Prepared::Other(Arc::new(function::FunctionShading { function, watch: watch() }))
            }
            Material::Brtd(function) => {
                let function = function.clone();
                Prepared::Other(Arc::new(function::BrtdShading { function, watch: watch() }))
            }
            Material::Measured(measured) => {
                Prepared::Other(Arc::new(bsdf::PreparedBsdf::new(measured, watch())))
            }
            Material::Ashikhmin(material) => {
                Prepared::Other(Arc::new(ashikhmin::PreparedAshikhmin::new(material, watch())))
            }
            Material::Wgmd(wgmd) => Prepared::Other(Arc::new(wgmd::PreparedWgmd::new(wgmd, watch()))),
            Material::Prism(prism) => {
                Prepared::Other(Arc::new(prism::PreparedPrism { prism: prism.clone(), watch: watch() }))
            }
            // What it does to a path is told by the path itself; for a ray alone it is not there.
            Material::Antimatter(_) => Prepared::Void,
            Material::Mixture { amount, foreground, background } => {
                let (amount, sides) = (amount.clone(), [inner(foreground), inner(background)]);
                Prepared::Other(Arc::new(modified::Mixture { amount, sides, watch: watch() }))
            }
            Material::Modified { modifiers, material, unit } => {
                let (tint, modifiers) = modified::Tint::of(modifiers);
                let (material, unit) = (inner(material), *unit);
                if let Some(plain) = material.tinted(tint.color).filter(|_| modifiers.is_empty()) {
                    watch().see_albedo(plain.albedo());
                    return plain;
                }
                let watch = watch();
                Prepared::Other(Arc::new(modified::Modified { modifiers, tint, material, unit, watch }))
            }
        })
    }

    /// The same with its colours multiplied, if it stays a constant material.
    fn tinted(&self, color: S) -> Option<Self> {
        Some(PreparedMaterial(match &self.0 {
            Prepared::Gloss(gloss) => Prepared::Gloss(gloss.tinted(color)),
            Prepared::Mirror(reflectance) => Prepared::Mirror(*reflectance * color),
            Prepared::Void => Prepared::Void,
            Prepared::Black => Prepared::Black,
            Prepared::Glass(_) | Prepared::Dielectric(_) | Prepared::Other(_) => return None,
        }))
    }

    /// The light that leaves at most, of a glossy material or a mirror.
    fn albedo(&self) -> f64 {
        match &self.0 {
            Prepared::Gloss(gloss) => gloss.lobes.iter().map(|lobe| lobe.luminance).sum(),
            Prepared::Mirror(reflectance) => reflectance.luminance(),
            _ => 0.0,
        }
    }

    /// Whether it is one of the constant materials, for which [`scatter_plain`](Self::scatter_plain) is enough.
    pub(crate) fn is_plain(&self) -> bool {
        !matches!(self.0, Prepared::Other(_))
    }

    /// Scatters a ray that meets a surface, from either side. `None` if it is absorbed. One lobe is taken at random, by
    /// luminous weight.
    #[inline]
    pub fn scatter(&self, meeting: &Meeting, random: &mut Random) -> Option<Scatter<S>> {
        if self.is_plain() && meeting.local.perturbation == DVec3::ZERO {
            return self.scatter_plain(meeting.normal, meeting.incoming, random);
        }
        self.scatter_shaded(meeting, &Shade::of(meeting), random)
    }

    /// [`scatter`](Self::scatter) of a plain material at a surface that is no smooth mesh.
    #[inline(always)]
    pub(crate) fn scatter_plain(
        &self,
        normal: DVec3,
        incoming: DVec3,
        random: &mut Random,
    ) -> Option<Scatter<S>> {
        match &self.0 {
            Prepared::Gloss(gloss) => gloss.scatter(normal, incoming, random),
            Prepared::Glass(pane) => pane.scatter(normal, incoming, random),
            Prepared::Dielectric(interface) => Some(interface.scatter(normal, incoming, random)),
            Prepared::Mirror(reflectance) => (is_front(normal, incoming) && reflectance.luminance() > 0.0)
                .then(|| {
                    Scatter::reflected(frame::mirrored(incoming, normal, -incoming.dot(normal)), *reflectance)
                }),
            Prepared::Void => Some(Scatter::transmitted(incoming, S::WHITE)),
            Prepared::Black => None,
            Prepared::Other(_) => unreachable!("it is not plain"),
        }
    }

    /// Transmittance \[1/m\] of the medium on one side of the surface, or `None` if the surface bounds no media.
    ///
    /// A tracer multiplies by [`attenuation`] over each segment. As in Radiance, the medium is that on the side of the
    /// surface a segment starts from or ends at; between surfaces that bound no media, it stays what it was.
    #[inline]
    pub fn medium(&self, meeting: &Meeting, front: bool) -> Option<DVec3> {
        match &self.0 {
            Prepared::Other(shading) => shading.medium(meeting, &Shade::of(meeting), front),
            _ => self.medium_plain(front),
        }
    }

    /// [`medium`](Self::medium) of a plain material.
    #[inline(always)]
    pub(crate) fn medium_plain(&self, front: bool) -> Option<DVec3> {
        match &self.0 {
            Prepared::Dielectric(interface) => Some(interface.medium(front).transmittance),
            _ => None,
        }
    }
}

/// BSDF of a glossy material without cosine \[1/sr\], for unit vectors `incident` and `exitant` that point away from the
/// surface. Light that is mirrored or goes straight on is not part of it.
pub fn evaluate<S: Spectrum>(gloss: &Gloss, incident: DVec3, exitant: DVec3, normal: DVec3) -> S {
    gloss::PreparedGloss::new(gloss).evaluate(incident, exitant, normal)
}

/// Whether `material` treats red, green and blue alike, so that a grey path loses nothing.
pub fn is_neutral(material: &Material) -> bool {
    use spectrum::is_grey;
    match material {
        Material::Void | Material::Black => true,
        Material::Gloss(gloss) => is_grey(gloss.color),
        Material::Glass { transmissivity, .. } => is_grey(*transmissivity),
        Material::Dielectric { inside, outside } => {
            is_grey(inside.transmittance) && is_grey(outside.transmittance)
        }
        Material::Mirror { reflectance } => is_grey(*reflectance),
        Material::Oriented { gloss, .. } => is_grey(gloss.color),
        Material::Function(function) => is_grey(function.color),
        Material::Brtd(function) => function.is_neutral(),
        Material::Measured(measured) => {
            !measured.file.has_color() && measured.diffuse.iter().all(|&color| is_grey(color))
        }
        Material::Ashikhmin(ashikhmin) => is_grey(ashikhmin.diffuse) && is_grey(ashikhmin.specular),
        Material::Wgmd(wgmd) => wgmd.is_neutral(),
        Material::Prism(_) | Material::Antimatter(_) => true,
        Material::Mixture { foreground, background, .. } => is_neutral(foreground) && is_neutral(background),
        Material::Modified { modifiers, material, .. } => {
            modifiers.iter().all(Modifier::is_neutral) && is_neutral(material)
        }
    }
}

/// The wavelengths \[nm\] at which spectra say what `material` is; `None` where none does, so that RGB will do.
pub fn spectral_range_nm(material: &Material) -> Option<[f64; 2]> {
    fn of_modifier(modifier: &Modifier) -> Option<[f64; 2]> {
        match modifier {
            Modifier::Spectrum(spectral) => Some(spectral.range_nm()),
            Modifier::SpectralField(field) => Some(field.range_nm()),
            Modifier::Mixture { foreground, background, .. } => {
                foreground.iter().chain(background).filter_map(of_modifier).reduce(common)
            }
            Modifier::Brightness(_) | Modifier::Color(_) | Modifier::Texture(_) => None,
        }
    }
    let common_of = |a: &Material, b: &Material| {
        [spectral_range_nm(a), spectral_range_nm(b)].into_iter().flatten().reduce(common)
    };
    match material {
        Material::Modified { modifiers, material, .. } => {
            modifiers.iter().filter_map(of_modifier).chain(spectral_range_nm(material)).reduce(common)
        }
        Material::Mixture { foreground, background, .. } => common_of(foreground, background),
        _ => None,
    }
}

fn common(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].min(b[1])]
}

/// Whether light travels through `material` the other way with the same strength.
///
/// Not so: smooth surfaces whose diffuse part loses what Fresnel's law mirrors, which depends on the incident angle alone, and
/// rough transmission. Of whatever has functions or data it is not known, and so denied.
pub fn is_reciprocal(material: &Material) -> bool {
    match material {
        Material::Gloss(gloss) => gloss::PreparedGloss::<f64>::new(gloss).is_reciprocal(),
        Material::Void
        | Material::Black
        | Material::Glass { .. }
        | Material::Dielectric { .. }
        | Material::Mirror { .. }
        | Material::Antimatter(_) => true,
        Material::Modified { modifiers, material, .. } => {
            modifiers.iter().all(|m| matches!(m, Modifier::Spectrum(_))) && is_reciprocal(material)
        }
        _ => false,
    }
}

/// Whether the ray comes from the side the normal points to.
#[inline]
fn is_front(normal: DVec3, incoming: DVec3) -> bool {
    incoming.dot(normal) < 0.0
}

/// The normal turned to the side the ray comes from, and the ray's cosine to it, in [0, 1].
#[inline]
fn facing(normal: DVec3, incoming: DVec3) -> (DVec3, f64) {
    let cosine = -incoming.dot(normal);
    // A factor, not a branch, which would be guessed wrong at every other surface.
    let side = if cosine > 0.0 { 1.0 } else { -1.0 };
    (normal * side, cosine.abs().min(1.0))
}
