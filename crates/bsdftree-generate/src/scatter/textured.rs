//! Constant materials with the patterns and textures around them: as without, but for colours and the normal.
//!
//! Source: Radiance's reference manual ("Materials", "Textures"). A pattern multiplies what has the material's colour: of
//! plastic and trans all but the highlight, of metal all but Fresnel's part, of glass what goes through, of a mirror all,
//! of media what a unit of length lets through. A texture moves the normal; what is reflected by that below the surface is
//! lost if diffuse or rough, and mirrored by the surface itself if smooth; what goes straight through trans and glass is bent.
//! Deviation: textures bend light through glass also after a diffuse reflection.

use glam::DVec3;

use super::frame::{cosine_direction, renormalized};
use super::fresnel::Boundary;
use super::gloss::{DIFFUSE_REFLECTION, DIFFUSE_TRANSMISSION, PreparedGloss, SPECULAR_TRANSMISSION};
use super::shading::{Facing, Shade};
use super::{Meeting, Prepared, PreparedMaterial, Scatter, Spectrum, dielectric, glass};
use crate::random::Random;

impl<S: Spectrum> PreparedMaterial<S> {
    /// Scatters a ray by the material as modifiers have changed it.
    pub(super) fn scatter_shaded(
        &self,
        meeting: &Meeting,
        shade: &Shade<S>,
        random: &mut Random,
    ) -> Option<Scatter<S>> {
        let incoming = meeting.incoming;
        let facing = || Facing::new(meeting, shade);
        match &self.0 {
            Prepared::Other(shading) => shading.scatter(meeting, shade, random),
            Prepared::Void => Some(Scatter::transmitted(incoming, S::WHITE)),
            Prepared::Black => None,
            Prepared::Gloss(gloss) => gloss.tinted(shade.color).scatter_facing(&facing(), incoming, random),
            Prepared::Glass(pane) => pane.scatter_facing(&facing(), shade.color, incoming, random),
            Prepared::Dielectric(interface) => {
                Some(interface.scatter_facing(&facing(), meeting.is_front(), incoming, random))
            }
            Prepared::Mirror(reflectance) => {
                let weight = *reflectance * shade.color;
                (meeting.is_front() && weight.luminance() > 0.0)
                    .then(|| Scatter::reflected(facing().mirrored_above(incoming), weight))
            }
        }
    }

    /// The medium on one side of the surface as patterns have changed it.
    pub(super) fn medium_shaded(&self, meeting: &Meeting, shade: &Shade<S>, front: bool) -> Option<DVec3> {
        match &self.0 {
            Prepared::Other(shading) => shading.medium(meeting, shade, front),
            Prepared::Dielectric(interface) => {
                let factor = shade.rgb.map(|f| libm::pow(f, 1.0 / shade.unit));
                Some((interface.medium(front).transmittance * factor).min(DVec3::ONE))
            }
            _ => None,
        }
    }
}

impl<S: Spectrum> PreparedGloss<S> {
    /// As [`scatter`](Self::scatter), with the normal of a texture.
    pub fn scatter_facing(
        &self,
        facing: &Facing,
        incoming: DVec3,
        random: &mut Random,
    ) -> Option<Scatter<S>> {
        let (lobe, weight) = self.lobe(facing.cosine, random)?;
        match lobe {
            DIFFUSE_REFLECTION => {
                let direction = cosine_direction(facing.normal, random);
                facing.is_above(direction).then(|| Scatter::reflected(direction, weight))
            }
            DIFFUSE_TRANSMISSION => {
                let direction = cosine_direction(-facing.normal, random);
                (!facing.is_above(direction)).then(|| Scatter::transmitted(direction, weight))
            }
            SPECULAR_TRANSMISSION => {
                let direction = facing.through(incoming);
                if self.smooth {
                    return Some(Scatter::transmitted(direction, weight));
                }
                let direction = self.facets.spread(facing.normal, direction, random)?;
                (!facing.is_above(direction)).then(|| Scatter::transmitted(direction, weight))
            }
            _ if self.smooth => Some(Scatter::reflected(facing.mirrored_above(incoming), weight)),
            _ => {
                let (exitant, factor) = self.facets.glance(facing.normal, incoming, facing.cosine, random)?;
                facing.is_above(exitant).then(|| Scatter::reflected(exitant, weight * factor))
            }
        }
    }
}

impl glass::Pane {
    fn scatter_facing<S: Spectrum>(
        &self,
        facing: &Facing,
        color: S,
        incoming: DVec3,
        random: &mut Random,
    ) -> Option<Scatter<S>> {
        let [reflectance, transmittance] = self.reflectance_transmittance(facing.cosine).map(S::from_rgb);
        let transmittance = transmittance * color;
        let [reflected, transmitted] = [reflectance.luminance(), transmittance.luminance()];
        let total = reflected + transmitted;
        if random.next_open() * total < reflected {
            return Some(facing.scatter(facing.mirrored(incoming), reflectance * (total / reflected)));
        }
        let bent = incoming + facing.perturbation * (2.0 * (1.0 - self.index));
        let direction =
            if facing.is_textured() { bent.try_normalize().unwrap_or(incoming) } else { incoming };
        (transmitted > 0.0).then(|| facing.scatter(direction, transmittance * (total / transmitted)))
    }
}

impl dielectric::Interface {
    fn scatter_facing<S: Spectrum>(
        &self,
        facing: &Facing,
        front: bool,
        incoming: DVec3,
        random: &mut Random,
    ) -> Scatter<S> {
        let ratio = self.medium(front).index / self.medium(!front).index;
        match Boundary::new(facing.cosine, ratio) {
            Some(boundary) if random.next_open() >= boundary.unpolarized() => {
                let bend = ratio * facing.cosine - boundary.cosine;
                let refracted = incoming * ratio + facing.normal * bend;
                if facing.is_above(refracted) {
                    // It would come back: without the texture.
                    let plain =
                        (incoming * ratio + facing.surface * bend).try_normalize().unwrap_or(incoming);
                    let through = if facing.is_above(plain) { incoming } else { plain };
                    return Scatter::transmitted(through, S::WHITE);
                }
                Scatter::transmitted(renormalized(refracted), S::WHITE)
            }
            _ => Scatter::reflected(facing.mirrored_above(incoming), S::WHITE),
        }
    }
}
