//! What is put before a material: patterns, textures, and mixtures of those.
//!
//! As in Radiance all modifiers of a material act together: patterns multiply, perturbations of the normal add up, and a
//! mixture counts each of its two sides by its amount. So their order does not matter.

use glam::DVec3;

use crate::field::{Field, Spectral, SpectralField};

/// A modifier that is not a material.
#[derive(Clone, Debug, PartialEq)]
pub enum Modifier {
    /// `brightfunc`, `brightdata`, `brighttext`: a factor on all colours, ≥ 0 where it makes sense.
    Brightness(Field<1>),
    /// `colorfunc`, `colordata`, `colorpict`, `colortext`: a factor on red, green, blue.
    Color(Field<3>),
    /// `spectrum`, `specfile`: a factor that depends on the wavelength, the same everywhere.
    Spectrum(Spectral),
    /// `specfunc`, `specdata`, `specpict`: a factor that depends on the wavelength and on the place.
    SpectralField(SpectralField),
    /// `texfunc`, `texdata`: what is added to the unit normal of the front, in the function's coordinates
    /// ([`Field::vector`]).
    Texture(Field<3>),
    /// `mixfunc`, `mixdata`, `mixpict`, `mixtext` of modifiers without materials.
    Mixture {
        /// How much of the foreground, in [0, 1] once it is limited to that.
        amount: Field<1>,
        /// Modifiers of the foreground.
        foreground: Vec<Modifier>,
        /// Modifiers of the background.
        background: Vec<Modifier>,
    },
}

impl Modifier {
    /// The same in a device that is turned by a rotation.
    pub fn turned(&self, turn: &dyn Fn(DVec3) -> DVec3) -> Modifier {
        let all = |modifiers: &[Modifier]| modifiers.iter().map(|m| m.turned(turn)).collect();
        match self {
            Modifier::Brightness(field) => Modifier::Brightness(field.turned(turn)),
            Modifier::Color(field) => Modifier::Color(field.turned(turn)),
            Modifier::Spectrum(spectrum) => Modifier::Spectrum(spectrum.clone()),
            Modifier::SpectralField(field) => Modifier::SpectralField(field.turned(turn)),
            Modifier::Texture(field) => Modifier::Texture(field.turned(turn)),
            Modifier::Mixture { amount, foreground, background } => Modifier::Mixture {
                amount: amount.turned(turn),
                foreground: all(foreground),
                background: all(background),
            },
        }
    }

    /// Whether it changes colours only, and brightness alike for all.
    pub fn is_neutral(&self) -> bool {
        match self {
            Modifier::Brightness(_) | Modifier::Texture(_) => true,
            Modifier::Color(_) | Modifier::Spectrum(_) | Modifier::SpectralField(_) => false,
            Modifier::Mixture { foreground, background, .. } => {
                foreground.iter().chain(background).all(Modifier::is_neutral)
            }
        }
    }
}
