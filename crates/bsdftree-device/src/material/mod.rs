//! What a surface is made of, as Radiance's reference manual defines it.
//!
//! These are descriptions only; how a ray scatters from them is `bsdftree_generate::scatter`.
//! Colours are linear RGB in Radiance's primaries, each in [0, 1] unless said otherwise.

mod antimatter;
mod ashikhmin;
mod bsdf;
mod function;
mod modifier;
mod orientation;
mod prism;
mod wgmd;

use std::sync::Arc;

use glam::DVec3;

use crate::field::Field;

pub use antimatter::Antimatter;
pub use ashikhmin::Ashikhmin;
pub use bsdf::{BsdfFile, Measured};
pub use function::{BrtdFunction, FunctionGloss};
pub use modifier::Modifier;
pub use orientation::Orientation;
pub use prism::{Prism, Redirection};
pub use wgmd::{PartModifiers, Wgmd};

/// A material, with the parameters of Radiance's reference manual.
///
/// Its debug form tells all that matters to light and nothing else: numbers exactly, files by a digest of their content, no places
/// and no names; devices are told apart by it.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// `void`: the surface is not there; rays pass through.
    Void,
    /// Reflects nothing and transmits nothing: `glow`, `light` (emitters do not scatter).
    Black,
    /// `plastic`, `metal`, `trans`, `plastic2`, `metal2`, `trans2`.
    Gloss(Gloss),
    /// `glass`: a thin pane, both interfaces in one surface.
    Glass {
        /// Transmissivity (not transmittance) of one passage at normal incidence.
        transmissivity: DVec3,
        /// Index of refraction; Radiance's default is 1.52.
        index: f64,
    },
    /// `dielectric` and `interface`: a boundary between two media.
    Dielectric {
        /// The medium behind the surface (on the side the normal points away from).
        inside: Medium,
        /// The medium in front of the surface; a vacuum for `dielectric`.
        outside: Medium,
    },
    /// `mirror`: reflects by `reflectance` from its front; its back is black.
    Mirror {
        /// Reflectance, without Fresnel.
        reflectance: DVec3,
    },
    /// `plastic2`, `metal2`, `trans2` whose orientation varies.
    Oriented {
        /// The material; its own orientation is not used.
        gloss: Gloss,
        /// The direction u that `roughness[0]` belongs to.
        orientation: Arc<Field<3>>,
    },
    /// `plasfunc`, `metfunc`, `transfunc`, `plasdata`, `metdata`, `transdata`.
    Function(Arc<FunctionGloss>),
    /// `BRTDfunc`.
    Brtd(Arc<BrtdFunction>),
    /// `BSDF`, `aBSDF`.
    Measured(Arc<Measured>),
    /// `ashik2`.
    Ashikhmin(Ashikhmin),
    /// `WGMDfunc`.
    Wgmd(Arc<Wgmd>),
    /// `prism1`, `prism2`.
    Prism(Arc<Prism>),
    /// `antimatter`; never inside another material.
    Antimatter(Antimatter),
    /// `mixfunc`, `mixdata`, `mixpict` of materials.
    Mixture {
        /// How much of the foreground, in [0, 1] once it is limited to that.
        amount: Arc<Field<1>>,
        /// What there is with this amount; [`Material::Void`] where nothing is.
        foreground: Box<Material>,
        /// What there is else.
        background: Box<Material>,
    },
    /// A material, or a mixture of materials, with patterns and textures before it.
    Modified {
        /// All of them, in any order.
        modifiers: Arc<[Modifier]>,
        /// What they modify.
        material: Box<Material>,
        /// The scene's unit \[m\]: a pattern on a medium is a factor on its transmittance of one such length.
        unit: f64,
    },
}

impl Material {
    /// Whether it is the same all over a surface, and made of numbers alone.
    pub fn is_constant(&self) -> bool {
        matches!(
            self,
            Material::Void
                | Material::Black
                | Material::Gloss(_)
                | Material::Glass { .. }
                | Material::Dielectric { .. }
                | Material::Mirror { .. }
        )
    }

    /// The same in another band of light, as far as files say what it is there; `None` if they do not.
    pub fn of_band(&self, name: &str) -> Option<Material> {
        match self {
            Material::Measured(measured) => {
                let file = measured.file.of_band(name)?;
                Some(Material::Measured(Arc::new(Measured { file, ..Measured::clone(measured) })))
            }
            Material::Modified { modifiers, material, unit } => {
                let material = Box::new(material.of_band(name)?);
                Some(Material::Modified { modifiers: modifiers.clone(), material, unit: *unit })
            }
            Material::Mixture { amount, foreground, background } => {
                let sides = [foreground, background].map(|side| side.of_band(name));
                sides.iter().any(Option::is_some).then(|| {
                    let [a, b] = sides;
                    Material::Mixture {
                        amount: amount.clone(),
                        foreground: a.map_or_else(|| foreground.clone(), Box::new),
                        background: b.map_or_else(|| background.clone(), Box::new),
                    }
                })
            }
            _ => None,
        }
    }

    /// The same in a device that is turned by a rotation.
    pub fn turned(&self, turn: &dyn Fn(DVec3) -> DVec3) -> Material {
        let boxed = |material: &Material| Box::new(material.turned(turn));
        match self {
            Material::Gloss(gloss) => {
                Material::Gloss(Gloss { orientation: gloss.orientation.map(turn), ..*gloss })
            }
            Material::Oriented { gloss, orientation } => {
                Material::Oriented { gloss: *gloss, orientation: Arc::new(orientation.turned(turn)) }
            }
            Material::Function(function) => {
                let lobe = function.lobe.turned(turn);
                Material::Function(Arc::new(FunctionGloss { lobe, ..FunctionGloss::clone(function) }))
            }
            Material::Brtd(brtd) => {
                let space = Arc::new(brtd.space.turned(turn));
                Material::Brtd(Arc::new(BrtdFunction { space, ..BrtdFunction::clone(brtd) }))
            }
            Material::Measured(measured) => {
                let up = measured.up.turned(turn);
                Material::Measured(Arc::new(Measured { up, ..Measured::clone(measured) }))
            }
            Material::Ashikhmin(ashikhmin) => Material::Ashikhmin(Ashikhmin {
                orientation: ashikhmin.orientation.turned(turn),
                ..ashikhmin.clone()
            }),
            Material::Wgmd(wgmd) => Material::Wgmd(Arc::new(wgmd.turned(turn))),
            Material::Prism(prism) => Material::Prism(Arc::new(prism.turned(turn))),
            Material::Mixture { amount, foreground, background } => Material::Mixture {
                amount: Arc::new(amount.turned(turn)),
                foreground: boxed(foreground),
                background: boxed(background),
            },
            Material::Modified { modifiers, material, unit } => Material::Modified {
                modifiers: modifiers.iter().map(|m| m.turned(turn)).collect(),
                material: boxed(material),
                unit: *unit,
            },
            Material::Void
            | Material::Black
            | Material::Glass { .. }
            | Material::Dielectric { .. }
            | Material::Mirror { .. }
            | Material::Antimatter(_) => self.clone(),
        }
    }
}

/// Whether the specular part is coloured, and whether light goes through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GlossKind {
    /// Specular highlights are white.
    Plastic,
    /// Specular highlights take the material's colour.
    Metal,
    /// As plastic, and translucent.
    Trans,
}

/// The family of `plastic`, `metal` and `trans`, isotropic or anisotropic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    /// Which of the three.
    pub kind: GlossKind,
    /// Red, green, blue.
    pub color: DVec3,
    /// Fraction of specularity.
    pub specular: f64,
    /// RMS slope of the facets along u and v; equal for isotropic materials, 0 for a smooth surface.
    pub roughness: [f64; 2],
    /// The direction u that `roughness[0]` belongs to; `None` for isotropic materials.
    pub orientation: Option<DVec3>,
    /// `trans`: fraction of the non-specular light that is transmitted, else 0.
    pub transmission: f64,
    /// `trans`: fraction of `transmission` that is not diffused, else 0.
    pub transmitted_specular: f64,
}

/// What fills the space on one side of a dielectric boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Transmittance per unit length \[1/m\], after conversion from the scene's unit.
    pub transmittance: DVec3,
    /// Index of refraction.
    pub index: f64,
}

impl Medium {
    /// Empty space: index 1, no absorption.
    pub const VACUUM: Medium = Medium { transmittance: DVec3::ONE, index: 1.0 };
}

/// Transmissivity of a thin pane, as `glass` takes it, from its transmittance at normal incidence.
///
/// The transmittance, which is what is measured, includes all reflections between the two faces:
/// T = (1 − r)² t / (1 − r² t²) with Fresnel's r = ((n − 1)/(n + 1))². At most (1 − r)/(1 + r), where t = 1.
///
/// ```
/// use bsdftree_device::material::transmissivity_from_transmittance;
/// // The reference manual gives about 0.96 for common glass.
/// assert!((transmissivity_from_transmittance(0.88, 1.52) - 0.9584).abs() < 1e-4);
/// ```
pub fn transmissivity_from_transmittance(transmittance: f64, index: f64) -> f64 {
    let r = ((index - 1.0) / (index + 1.0)).powi(2);
    let passed = (1.0 - r).powi(2);
    // The root of r² T t² + (1 − r)² t − T = 0 without cancellation for small r.
    2.0 * transmittance / (passed + (passed * passed + 4.0 * (r * transmittance).powi(2)).sqrt())
}
