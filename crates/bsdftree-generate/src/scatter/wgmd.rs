//! `WGMDfunc`: Gaussian facets that mirror light, and a spread of light that goes through, beside diffuse parts.
//!
//! Four lobes, of which a ray takes one: diffuse reflection of the side it comes from, diffuse transmission, reflection by
//! facets, transmission spread by roughness; each with modifiers of its own. Patterns multiply the lobe they are for, textures turn
//! its normal. Where one of the roughnesses is nothing, the lobe is a mirror, or goes straight on; a mirror of s ≥ 1.8 %
//! gets Fresnel's approximation F: it mirrors s + (1−s)F, and the other lobes keep 1−F of theirs. Functions see the surface as it is,
//! but the normal after textures, and the cosine to it, as if the ray had come from the front.
//!
//! Sources: Radiance's `WGMDfunc` as `rtrace` has it, observed; lobes as in [`facets`](super::facets), and the same deviations. Others:
//! a coefficient below 0 counts as 0; all formulas are worked out, also roughnesses that nothing has; under a texture the weight of a
//! rough reflection goes by cosines to the perturbed normal, as its lobe does (`rtrace` takes those to the surface's).

use std::sync::Arc;

use bsdftree_device::field::{Field, RayState};
use bsdftree_device::material::{Modifier, Wgmd};
use glam::DVec3;

use super::choice::choose;
use super::facets::Facets;
use super::faults::Watch;
use super::frame::cosine_direction;
use super::fresnel;
use super::modified::apply;
use super::shading::{Facing, Shade, Shading, ray_state};
use super::{Meeting, Scatter, Spectrum};
use crate::random::Random;

/// Least roughness that counts, as in Radiance.
const LEAST: f64 = 1e-6;

const DIFFUSE_REFLECTION: usize = 0;
const DIFFUSE_TRANSMISSION: usize = 1;
const REFLECTION: usize = 2;
const TRANSMISSION: usize = 3;

/// A `WGMDfunc` ready to scatter.
#[derive(Clone, Debug)]
pub(super) struct PreparedWgmd<S> {
    material: Arc<Wgmd>,
    /// Diffuse reflection of the front, of the back, transmission.
    diffuse: [S; 3],
    watch: Watch,
}

/// A lobe at a meeting.
#[derive(Clone, Copy, Debug)]
struct Lobe<S> {
    color: S,
    facing: Facing,
    /// Roughness along u and v; `None` where it is a mirror, goes straight on, or is diffuse.
    roughness: Option<[f64; 2]>,
}

impl<S: Spectrum> PreparedWgmd<S> {
    pub fn new(material: &Arc<Wgmd>, watch: Watch) -> Self {
        let [front, back] = material.diffuse_reflection;
        let diffuse = [front, back, material.diffuse_transmission].map(S::from_rgb);
        PreparedWgmd { material: material.clone(), diffuse, watch }
    }

    /// What the modifiers of a part make of the meeting; `own` is what those of the material do.
    fn shade(&self, modifiers: Option<&[Modifier]>, meeting: &Meeting, own: &Shade<S>) -> Option<Shade<S>> {
        let Some(modifiers) = modifiers else { return Some(*own) };
        let mut shade = Shade { unit: own.unit, ..Shade::of(meeting) };
        self.watch.checked(apply(modifiers, &ray_state(meeting), &mut shade))?;
        Some(shade.clamped())
    }

    /// As functions see the meeting.
    fn state(meeting: &Meeting, facing: &Facing) -> RayState {
        RayState { perturbed_normal: facing.normal, perturbed_cosine: facing.cosine, ..ray_state(meeting) }
    }

    fn diffuse(&self, color: S, meeting: &Meeting, shade: &Shade<S>) -> Lobe<S> {
        Lobe { color: color * shade.color, facing: Facing::new(meeting, shade), roughness: None }
    }

    fn specular(&self, field: &Field<3>, meeting: &Meeting, shade: &Shade<S>) -> Option<Lobe<S>> {
        let facing = Facing::new(meeting, shade);
        let [coefficient, u, v] = self.watch.checked(field.at(&Self::state(meeting, &facing)))?;
        let roughness = (u > LEAST && v > LEAST).then_some([u, v]);
        Some(Lobe { color: shade.color * coefficient.max(0.0), facing, roughness })
    }

    /// All lobes; `None` once a function has failed.
    fn lobes(&self, meeting: &Meeting, shade: &Shade<S>) -> Option<[Lobe<S>; 4]> {
        let [front, back, through] = self.diffuse;
        let own = if meeting.is_front() { front } else { back };
        let [r, t, d] = self.material.modifiers.each_ref().map(|m| m.as_deref());
        let mut lobes = [
            self.diffuse(own, meeting, shade),
            self.diffuse(through, meeting, &self.shade(d, meeting, shade)?),
            self.specular(&self.material.reflection, meeting, &self.shade(r, meeting, shade)?)?,
            self.specular(&self.material.transmission, meeting, &self.shade(t, meeting, shade)?)?,
        ];
        let mirror = &mut lobes[REFLECTION];
        if mirror.roughness.is_none() && mirror.color.luminance() >= fresnel::LEAST_SPECULAR {
            let fresnel = fresnel::approximation(mirror.facing.cosine);
            mirror.color = mirror.color * (1.0 - fresnel) + S::WHITE * fresnel;
            for k in [DIFFUSE_REFLECTION, DIFFUSE_TRANSMISSION, TRANSMISSION] {
                lobes[k].color = lobes[k].color * (1.0 - fresnel);
            }
        }
        Some(lobes)
    }

    /// The facets of a lobe; functions of the direction u see the normal of the diffuse reflection.
    fn facets(&self, roughness: [f64; 2], meeting: &Meeting, diffuse: &Facing) -> Option<Facets> {
        let u = self.watch.checked(self.material.orientation.vector(&Self::state(meeting, diffuse)))?;
        Some(Facets { roughness, orientation: Some(u.normalize_or_zero()) })
    }
}

/// Straight on, less what a texture adds to the unit normal of the front, but never back.
fn through(meeting: &Meeting, facing: &Facing) -> DVec3 {
    let added = facing.normal - facing.surface;
    let added = if meeting.is_front() { added } else { -added };
    match (meeting.incoming - added).try_normalize() {
        Some(direction) if facing.is_textured() && !facing.is_above(direction) => direction,
        _ => meeting.incoming,
    }
}

impl<S: Spectrum> Shading<S> for PreparedWgmd<S> {
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>> {
        let lobes = self.lobes(meeting, shade)?;
        let shares = lobes.map(|lobe| lobe.color.luminance());
        let total: f64 = shares.iter().sum();
        self.watch.see_albedo(total);
        let (chosen, _, _) = choose(shares, random)?;
        let Lobe { color, facing, roughness } = lobes[chosen];
        let weight = color * (total / shares[chosen]);
        let incoming = meeting.incoming;
        let facets = match roughness {
            Some(roughness) => Some(self.facets(roughness, meeting, &lobes[DIFFUSE_REFLECTION].facing)?),
            None => None,
        };
        let (direction, weight): (DVec3, S) = match (chosen, facets) {
            (DIFFUSE_REFLECTION, _) => (cosine_direction(facing.normal, random), weight),
            (DIFFUSE_TRANSMISSION, _) => (cosine_direction(-facing.normal, random), weight),
            (REFLECTION, None) => (facing.mirrored_above(incoming), weight),
            (REFLECTION, Some(facets)) => {
                let (direction, factor) = facets.glance(facing.normal, incoming, facing.cosine, random)?;
                (direction, weight * factor)
            }
            (_, None) => (through(meeting, &facing), weight),
            (_, Some(facets)) => (facets.spread(facing.normal, through(meeting, &facing), random)?, weight),
        };
        // A specular lobe that pierces the surface is lost.
        let is_above = facing.is_above(direction);
        let is_lost = (chosen == REFLECTION && !is_above) || (chosen == TRANSMISSION && is_above);
        (!is_lost).then(|| facing.scatter(direction, weight))
    }
}
