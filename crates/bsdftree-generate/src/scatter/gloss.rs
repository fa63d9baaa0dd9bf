//! `plastic`, `metal`, `trans` and their anisotropic forms: up to four lobes, of which a ray takes one.
//!
//! Lobes, for colour c, specularity s, transmission t, its specular part ts, and F the Fresnel approximation
//! ([`fresnel::approximation`], smooth surfaces with s ≥ 1.8 % only, else 0):
//! diffuse reflection c(1−s)(1−t)(1−F), diffuse transmission c(1−s)t(1−ts)(1−F), specular transmission
//! c(1−s)t·ts(1−F), specular reflection s(1−F)+F (metal: cs(1−F)+F). Both sides behave alike.
//!
//! Sources: Radiance's reference manual; G. Ward, "Behavior of materials in Radiance" (2004); rough lobes as in `facets`.
//!
//! Deviations from Radiance: those of `facets`; no lobe is taken as diffuse for being weak (`-st`).

use std::f64::consts::FRAC_1_PI;

use bsdftree_device::material::{Gloss, GlossKind};
use glam::DVec3;

use super::facets::Facets;
use super::frame::{cosine_direction, mirrored};
use super::fresnel;
use super::{Scatter, Spectrum};
use crate::random::Random;

/// Squared roughness up to which Radiance takes a surface for smooth.
const SMOOTH: f64 = 1e-6;

pub(super) const DIFFUSE_REFLECTION: usize = 0;
pub(super) const DIFFUSE_TRANSMISSION: usize = 1;
pub(super) const SPECULAR_TRANSMISSION: usize = 2;
pub(super) const SPECULAR_REFLECTION: usize = 3;

/// A [`Gloss`] with its lobes worked out.
#[derive(Clone, Debug)]
pub(super) struct PreparedGloss<S> {
    pub lobes: [Lobe<S>; 4],
    /// Sum of the lobes' luminances.
    total: f64,
    /// The lobe, if there is but one at all angles.
    only: Option<usize>,
    pub smooth: bool,
    is_metal: bool,
    fresnel: bool,
    pub facets: Facets,
}

/// A lobe without Fresnel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe<S> {
    pub color: S,
    pub luminance: f64,
    /// The colour, scaled to luminance 1.
    pub tint: S,
}

impl<S: Spectrum> Lobe<S> {
    fn new(rgb: DVec3) -> Self {
        Lobe::of(S::from_rgb(rgb))
    }

    fn of(color: S) -> Self {
        let luminance = color.luminance();
        Lobe { color, luminance, tint: if luminance > 0.0 { color / luminance } else { S::BLACK } }
    }
}

impl<S: Spectrum> PreparedGloss<S> {
    pub fn new(gloss: &Gloss) -> Self {
        let diffused = gloss.color * (1.0 - gloss.specular);
        let transmitted = diffused * gloss.transmission;
        let highlight = if gloss.kind == GlossKind::Metal { gloss.color } else { DVec3::ONE };
        let lobes = [
            Lobe::new(diffused * (1.0 - gloss.transmission)),
            Lobe::new(transmitted * (1.0 - gloss.transmitted_specular)),
            Lobe::new(transmitted * gloss.transmitted_specular),
            Lobe::new(highlight * gloss.specular),
        ];
        let smooth = gloss.roughness.iter().all(|alpha| alpha * alpha <= SMOOTH);
        let fresnel = smooth && gloss.specular >= fresnel::LEAST_SPECULAR;
        let mut present = (0..4).filter(|&k| lobes[k].luminance > 0.0);
        let only = present.next().filter(|_| present.next().is_none() && !fresnel);
        PreparedGloss {
            total: lobes.iter().map(|lobe| lobe.luminance).sum(),
            lobes,
            only,
            smooth,
            is_metal: gloss.kind == GlossKind::Metal,
            fresnel,
            facets: Facets {
                roughness: gloss.roughness,
                orientation: gloss.orientation.map(DVec3::normalize_or_zero),
            },
        }
    }

    /// See [`super::is_reciprocal`].
    pub fn is_reciprocal(&self) -> bool {
        let diffuse = self.lobes[DIFFUSE_REFLECTION].luminance + self.lobes[DIFFUSE_TRANSMISSION].luminance;
        !(self.fresnel && diffuse > 0.0)
            && (self.smooth || self.lobes[SPECULAR_TRANSMISSION].luminance == 0.0)
    }

    /// The same with its colour multiplied by another.
    pub fn tinted(&self, color: S) -> Self {
        if color == S::WHITE {
            return self.clone();
        }
        let mut tinted = self.clone();
        for (k, lobe) in tinted.lobes.iter_mut().enumerate() {
            if k != SPECULAR_REFLECTION || self.is_metal {
                *lobe = Lobe::of(lobe.color * color);
            }
        }
        tinted.total = tinted.lobes.iter().map(|lobe| lobe.luminance).sum();
        // A lobe that was alone may be gone, and then nothing is left.
        tinted
    }

    /// One lobe, taken with a probability proportional to its luminance, so that all weights have the same one.
    #[inline]
    pub fn scatter(&self, normal: DVec3, incoming: DVec3, random: &mut Random) -> Option<Scatter<S>> {
        let (facing, cosine) = super::facing(normal, incoming);
        let (lobe, weight) = self.lobe(cosine, random)?;
        match lobe {
            DIFFUSE_REFLECTION => Some(Scatter::reflected(cosine_direction(facing, random), weight)),
            DIFFUSE_TRANSMISSION => Some(Scatter::transmitted(cosine_direction(-facing, random), weight)),
            SPECULAR_TRANSMISSION if self.smooth => Some(Scatter::transmitted(incoming, weight)),
            SPECULAR_TRANSMISSION => {
                Some(Scatter::transmitted(self.facets.spread(facing, incoming, random)?, weight))
            }
            _ if self.smooth => Some(Scatter::reflected(mirrored(incoming, facing, cosine), weight)),
            _ => {
                let (exitant, factor) = self.facets.glance(facing, incoming, cosine, random)?;
                Some(Scatter::reflected(exitant, weight * factor))
            }
        }
    }

    /// A lobe for a ray at this cosine, and the weight of what it scatters.
    #[inline(always)]
    pub fn lobe(&self, cosine: f64, random: &mut Random) -> Option<(usize, S)> {
        let fresnel = self.fresnel_at(cosine);
        let total = self.total * (1.0 - fresnel) + fresnel;
        if total <= 0.0 {
            return None;
        }
        let lobe = self.only.unwrap_or_else(|| self.choose(random.next_open() * total, 1.0 - fresnel));
        if lobe == SPECULAR_REFLECTION && self.smooth {
            let color = self.highlight(fresnel);
            return Some((lobe, color * (total / color.luminance())));
        }
        Some((lobe, self.lobes[lobe].tint * total))
    }

    /// The lobe at `place` ∈ (0, total) of the lobes laid end to end, scaled by `kept` but for the last.
    #[inline]
    fn choose(&self, mut place: f64, kept: f64) -> usize {
        for lobe in [DIFFUSE_REFLECTION, DIFFUSE_TRANSMISSION, SPECULAR_TRANSMISSION] {
            let luminance = self.lobes[lobe].luminance * kept;
            if place < luminance {
                return lobe;
            }
            place -= luminance;
        }
        // Rounding cannot lead here without a specular lobe: `place` is below the total by 1e-10 of it at least.
        SPECULAR_REFLECTION
    }

    #[inline]
    pub fn fresnel_at(&self, cosine: f64) -> f64 {
        if self.fresnel { fresnel::approximation(cosine) } else { 0.0 }
    }

    #[inline]
    pub fn highlight(&self, fresnel: f64) -> S {
        self.lobes[SPECULAR_REFLECTION].color * (1.0 - fresnel) + S::WHITE * fresnel
    }

    /// BSDF without cosine \[1/sr\]; `incident` and `exitant` are unit and point away from the surface. Mirrored and
    /// unscattered light (the specular lobes of a surface smooth along u or v) is not part of it.
    pub fn evaluate(&self, incident: DVec3, exitant: DVec3, normal: DVec3) -> S {
        let (facing, cosine) = super::facing(normal, -incident);
        let exit_cosine = exitant.dot(facing);
        let reflected = exit_cosine > 0.0;
        let (diffuse, specular) = if reflected {
            (DIFFUSE_REFLECTION, SPECULAR_REFLECTION)
        } else {
            (DIFFUSE_TRANSMISSION, SPECULAR_TRANSMISSION)
        };
        let lambertian = self.lobes[diffuse].color * ((1.0 - self.fresnel_at(cosine)) * FRAC_1_PI);
        let alpha = self.facets.roughness;
        if self.smooth || alpha[0] * alpha[1] == 0.0 || cosine == 0.0 || exit_cosine == 0.0 {
            return lambertian;
        }
        let lobe = if reflected {
            self.facets.reflection(incident, exitant, facing)
        } else {
            self.facets.transmission(incident, exitant, facing)
        };
        lambertian + self.lobes[specular].color * lobe
    }
}
