//! Materials with patterns and textures before them, mixtures, and orientations that vary.
//!
//! In: modifiers of the device. Out: a [`Shade`] for each meeting, given to the material behind. Source: Radiance's
//! reference manual ("Textures", "Patterns", "Mixtures"). A mixture takes one of its two sides at random, the foreground with
//! the probability of its amount, so that each counts by its share. Deviations: a mixture that bounds a medium does so with
//! its dielectric side, whichever is taken; a pattern below 0 counts as 0.

use std::sync::Arc;

use bsdftree_device::field::{Field, FieldError, RayState, Spectral};
use bsdftree_device::material::{Gloss, Modifier};
use glam::DVec3;

use super::faults::Watch;
use super::gloss::PreparedGloss;
use super::shading::{Facing, Shade, Shading, ray_state};
use super::{Meeting, PreparedMaterial, Scatter, Spectrum};
use crate::random::Random;
use crate::scatter;

/// Radiance leaves out a side of a mixture that has less than this.
const LEAST_AMOUNT: f64 = 1e-6;

/// A material and what is before it.
#[derive(Clone, Debug)]
pub(super) struct Modified<S> {
    /// All that vary.
    pub modifiers: Arc<[Modifier]>,
    /// What the others do together.
    pub tint: Tint<S>,
    pub material: PreparedMaterial<S>,
    /// The scene's unit \[m\].
    pub unit: f64,
    pub watch: Watch,
}

impl<S: Spectrum> Modified<S> {
    fn shade(&self, meeting: &Meeting, shade: &Shade<S>) -> Option<Shade<S>> {
        let (color, rgb) = (shade.color * self.tint.color, shade.rgb * self.tint.rgb);
        let mut shade = Shade { unit: self.unit, color, rgb, ..*shade };
        self.watch.checked(apply(&self.modifiers, &ray_state(meeting), &mut shade))?;
        Some(shade.clamped())
    }
}

impl<S: Spectrum> Shading<S> for Modified<S> {
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>> {
        let shade = self.shade(meeting, shade)?;
        let scatter = self.material.scatter_shaded(meeting, &shade, random)?;
        self.watch.see_albedo(scatter.weight.luminance());
        Some(scatter)
    }

    fn medium(&self, meeting: &Meeting, shade: &Shade<S>, front: bool) -> Option<DVec3> {
        // Most materials bound no medium.
        self.material.medium_shaded(meeting, shade, front)?;
        let shade = self.shade(meeting, shade)?;
        self.material.medium_shaded(meeting, &shade, front)
    }
}

/// What patterns do that are the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tint<S> {
    pub color: S,
    pub rgb: DVec3,
}

impl<S: Spectrum> Tint<S> {
    /// That of all modifiers that are the same everywhere, and the others.
    pub fn of(modifiers: &Arc<[Modifier]>) -> (Tint<S>, Arc<[Modifier]>) {
        let mut tint = Tint { color: S::WHITE, rgb: DVec3::ONE };
        let is_constant = |modifier: &Modifier| matches!(modifier, Modifier::Spectrum(_));
        if !modifiers.iter().any(is_constant) {
            return (tint, modifiers.clone());
        }
        for modifier in modifiers.iter() {
            if let Modifier::Spectrum(spectral) = modifier {
                let spectral = of_spectral(spectral);
                tint.color = tint.color * S::from_spectral(spectral).clamped();
                tint.rgb *= DVec3::from_spectral(spectral);
            }
        }
        (tint, modifiers.iter().filter(|modifier| !is_constant(modifier)).cloned().collect())
    }
}

/// Lets modifiers act on a shade.
pub(super) fn apply<S: Spectrum>(
    modifiers: &[Modifier],
    ray: &RayState,
    shade: &mut Shade<S>,
) -> Result<(), FieldError> {
    let tint = |shade: &mut Shade<S>, color: S, rgb: DVec3| {
        shade.color = shade.color * color;
        shade.rgb *= rgb;
    };
    for modifier in modifiers {
        match modifier {
            Modifier::Brightness(field) => {
                let [factor] = field.at(ray)?;
                tint(shade, S::WHITE * factor, DVec3::splat(factor));
            }
            Modifier::Color(field) => {
                let rgb = DVec3::from_array(field.at(ray)?);
                tint(shade, S::from_rgb(rgb), rgb);
            }
            Modifier::Spectrum(spectral) => {
                let spectral = of_spectral(spectral);
                tint(shade, S::from_spectral(spectral), DVec3::from_spectral(spectral));
            }
            Modifier::SpectralField(field) => {
                let spectral = of_spectral(&field.at(ray)?);
                tint(shade, S::from_spectral(spectral), DVec3::from_spectral(spectral));
            }
            Modifier::Texture(field) => shade.perturbation += field.vector(ray)?,
            Modifier::Mixture { amount, foreground, background } => {
                let amount = amount.at(ray)?[0].clamp(0.0, 1.0);
                let mut sides = [*shade; 2];
                if amount > LEAST_AMOUNT {
                    apply(foreground, ray, &mut sides[0])?;
                }
                if amount < 1.0 - LEAST_AMOUNT {
                    apply(background, ray, &mut sides[1])?;
                }
                let [a, b] = sides;
                shade.color = a.color * amount + b.color * (1.0 - amount);
                shade.rgb = a.rgb * amount + b.rgb * (1.0 - amount);
                shade.perturbation = a.perturbation * amount + b.perturbation * (1.0 - amount);
            }
        }
    }
    Ok(())
}

fn of_spectral(spectral: &Spectral) -> scatter::Spectral {
    scatter::Spectral::from_samples(&spectral.wavelengths_nm, &spectral.values)
}

/// One material or another.
#[derive(Clone, Debug)]
pub(super) struct Mixture<S> {
    pub amount: Arc<Field<1>>,
    /// Foreground and background.
    pub sides: [PreparedMaterial<S>; 2],
    pub watch: Watch,
}

impl<S: Spectrum> Shading<S> for Mixture<S> {
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>> {
        let [amount] = self.watch.checked(self.amount.at(&ray_state(meeting)))?;
        let [foreground, background] = &self.sides;
        let side = if random.next_open() < amount { foreground } else { background };
        side.scatter_shaded(meeting, shade, random)
    }

    fn medium(&self, meeting: &Meeting, shade: &Shade<S>, front: bool) -> Option<DVec3> {
        let [foreground, background] = self.sides.each_ref();
        let medium = |side: &PreparedMaterial<S>| side.medium_shaded(meeting, shade, front);
        medium(foreground).or_else(|| medium(background))
    }
}

/// An anisotropic material whose orientation varies.
#[derive(Clone, Debug)]
pub(super) struct Oriented<S> {
    gloss: PreparedGloss<S>,
    orientation: Arc<Field<3>>,
    watch: Watch,
}

impl<S: Spectrum> Oriented<S> {
    pub fn new(gloss: &Gloss, orientation: &Arc<Field<3>>, watch: &Watch) -> Self {
        let watch = watch.clone();
        Oriented { gloss: PreparedGloss::new(gloss), orientation: orientation.clone(), watch }
    }
}

impl<S: Spectrum> Shading<S> for Oriented<S> {
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>> {
        let u = self.watch.checked(self.orientation.vector(&ray_state(meeting)))?;
        let mut gloss = self.gloss.tinted(shade.color);
        gloss.facets.orientation = Some(u.normalize_or_zero());
        gloss.scatter_facing(&Facing::new(meeting, shade), meeting.incoming, random)
    }
}
