//! `BSDF` and `aBSDF`: light scatters as a file says, evaluated and sampled by our own library.
//!
//! The BSDF's own axes are the surface's normal, which stays where it is whichever side light comes from, and the up vector as
//! far as it is normal to that. Incident is where the light comes from. Which component answers for a side, and what stands in for
//! one that the file does not have, is the library's rule ([`Band::answering`]). Beside the BSDF there are diffuse reflectances of
//! both sides and a diffuse transmittance, which add to it.
//!
//! A pattern multiplies all that is diffuse, the Lambertian part of the BSDF too, and what is transmitted, but not what is reflected
//! beyond the Lambertian part. Invariant: without a pattern, the mean weight of what leaves by a cell of the file is its BSDF times its
//! projected solid angle; but the peak of an `aBSDF` goes straight on ([`through`](super::through)).
//!
//! Source: Radiance's reference manual; its BSDF library, by way of ours. Deviations: colours outside of Radiance's primaries
//! are mixed with white until they are inside, at the same luminance; where the up vector is along the normal the surface is black,
//! as in Radiance, but for isotropic files, which need none.

use std::f64::consts::PI;
use std::sync::Arc;

use bsdftree::bsdf::Lobe;
use bsdftree::color::rgb_from_xyz;
use bsdftree::{Component, Direction, Side};
use bsdftree_device::material::Measured;
use glam::DVec3;

use super::choice::choose;
use super::faults::Watch;
use super::frame::{cosine_direction, renormalized, tangents};
use super::reversed::Proposal;
use super::shading::{Facing, Shade, Shading, ray_state};
use super::through::Search;
use super::{Meeting, Scatter, Spectrum};
use crate::random::Random;

/// A BSDF from a file, ready to scatter.
#[derive(Clone, Debug)]
pub(super) struct PreparedBsdf<S> {
    material: Arc<Measured>,
    watch: Watch,
    /// Added diffuse reflectance of the front, of the back, transmittance.
    diffuse: [S; 3],
    /// How the straight peak of light from the front, and from the back, is looked for.
    through: Option<[Option<Search>; 2]>,
    /// What stands in for a transmission of light from the front, and from the back, that is slow to sample.
    proposals: [Option<Proposal>; 2],
    /// Lambertian part \[1/sr\] of the reflection of the front and of the back.
    lambertian: [f64; 2],
    isotropic: bool,
}

/// The BSDF's axes in the device: right, up, normal.
#[derive(Clone, Copy, Debug)]
struct Axes([DVec3; 3]);

/// One of the ways on: a side, and the function that tells how light gets there.
struct Exit<'a> {
    side: Side,
    component: &'a Component,
    reversed: bool,
    incident: Direction,
    source: Source<'a>,
}

/// What directions are drawn from.
enum Source<'a> {
    Lobe(Lobe<'a>),
    Proposal(&'a Proposal),
}

impl Exit<'_> {
    /// The fraction of light that takes it, or about that.
    fn share(&self) -> f64 {
        match &self.source {
            Source::Lobe(lobe) => lobe.total(),
            Source::Proposal(proposal) => proposal.share(self.incident),
        }
    }

    /// A direction, and the fraction of light that it stands for.
    fn sample(&self, u: f64, v: f64) -> Option<(Direction, f64)> {
        match &self.source {
            Source::Lobe(lobe) => {
                let (disk, _) = lobe.sample(u, Some(v))?;
                Some((self.side.direction_from_disk(disk), lobe.total()))
            }
            Source::Proposal(proposal) => proposal.sample(&self.component.luminance, self.incident, [u, v]),
        }
    }

    fn value(&self, exitant: Direction) -> f64 {
        self.component.luminance.eval(self.incident, exitant, self.reversed)
    }

    /// The colour of light, of luminance 1.
    fn tint<S: Spectrum>(&self, exitant: Direction) -> S {
        if self.component.chroma.is_none() || S::CHANNELS == 1 {
            return S::WHITE;
        }
        let xyz = self.component.eval_xyz(self.incident, exitant, self.reversed);
        if xyz[1] > 0.0 { S::from_rgb(of_unit_luminance(xyz)) } else { S::WHITE }
    }
}

impl Axes {
    /// `None` where up is along the normal.
    #[inline]
    fn new(normal: DVec3, up: DVec3) -> Option<Axes> {
        let right = up.cross(normal).try_normalize()?;
        Some(Axes([right, normal.cross(right), normal]))
    }

    fn any(normal: DVec3) -> Axes {
        let [t, b] = tangents(normal);
        Axes([t, b, normal])
    }

    #[inline]
    fn local(&self, v: DVec3) -> Direction {
        self.0.map(|axis| v.dot(axis))
    }

    #[inline]
    fn device(&self, [x, y, z]: Direction) -> DVec3 {
        renormalized(self.0[0] * x + self.0[1] * y + self.0[2] * z)
    }
}

impl<S: Spectrum> PreparedBsdf<S> {
    pub fn new(material: &Arc<Measured>, watch: Watch) -> PreparedBsdf<S> {
        let band = material.file.band();
        let search = |from: Side| {
            let (component, _) = band.answering(from, from.opposite())?;
            Some(Search::new(&component.luminance))
        };
        let lambertian = |side| {
            let reflection = band.answering(side, side);
            reflection.map_or(0.0, |(component, _)| component.luminance.lambertian() / PI)
        };
        PreparedBsdf {
            material: material.clone(),
            watch,
            diffuse: material.diffuse.map(S::from_rgb),
            through: material.through.then(|| [Side::Front, Side::Back].map(search)),
            proposals: [Side::Front, Side::Back].map(|from| {
                let (component, reversed) = band.answering(from, from.opposite())?;
                reversed.then(|| Proposal::new(&component.luminance)).flatten()
            }),
            lambertian: [Side::Front, Side::Back].map(lambertian),
            isotropic: material.file.is_isotropic(),
        }
    }

    fn axes(&self, normal: DVec3, up: DVec3) -> Option<Axes> {
        Axes::new(normal, up).or_else(|| self.isotropic.then(|| Axes::any(normal)))
    }

    fn exit(&self, incident: Direction, side: Side) -> Option<Exit<'_>> {
        let from = Side::of(incident);
        let (component, reversed) = self.material.file.band().answering(from, side)?;
        let proposal = self.proposals[index(from)].as_ref().filter(|_| side != from);
        let source = match proposal {
            Some(proposal) => Source::Proposal(proposal),
            None => Source::Lobe(component.luminance.lobe(incident, reversed)),
        };
        Some(Exit { side, component, reversed, incident, source })
    }
}

impl<S: Spectrum> Shading<S> for PreparedBsdf<S> {
    /// One way on, taken with a probability proportional to its luminance.
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>> {
        let facing = Facing::new(meeting, shade);
        let normal = if meeting.is_front() { facing.normal } else { -facing.normal };
        let up = self.watch.checked(self.material.up.at(|| ray_state(meeting)))?;
        let axes = self.axes(normal, up)?;
        let incident = axes.local(-meeting.incoming);
        let from = Side::of(incident);
        let exits = [from, from.opposite()].map(|side| self.exit(incident, side));
        let diffuse = [self.diffuse[index(from)], self.diffuse[2]];
        let [reflected, transmitted] = exits.each_ref().map(|exit| exit.as_ref().map_or(0.0, Exit::share));
        let shares = [reflected, transmitted, diffuse[0].luminance(), diffuse[1].luminance()];
        let (way, place, total) = choose(shares, random)?;
        let (exitant, weight) = if way >= 2 {
            let outward = if way == 2 { facing.normal } else { -facing.normal };
            (cosine_direction(outward, random), diffuse[way - 2] * shade.color * (total / shares[way]))
        } else {
            let exit = exits[way].as_ref()?;
            let (exitant, weight) = exit.sample(place, random.next_open())?;
            let weight = exit.tint::<S>(exitant) * (weight * total / shares[way]);
            if way == 0 {
                (axes.device(exitant), weight * self.pattern(exit, exitant, shade))
            } else if self.is_through(exit, exitant, random) {
                (meeting.incoming, weight * shade.color)
            } else {
                (axes.device(exitant), weight * shade.color)
            }
        };
        let transmitted = if facing.is_textured() { !facing.is_above(exitant) } else { way % 2 == 1 };
        Some(Scatter { direction: exitant, weight, transmitted })
    }
}

impl<S: Spectrum> PreparedBsdf<S> {
    /// What a pattern does to reflected light: it colours the Lambertian part of it.
    #[inline]
    fn pattern(&self, exit: &Exit, exitant: Direction, shade: &Shade<S>) -> S {
        if shade.color == S::WHITE {
            return S::WHITE;
        }
        let value = exit.value(exitant).max(f64::MIN_POSITIVE);
        let lambertian = (self.lambertian[index(exit.side)] / value).min(1.0);
        shade.color * lambertian + S::WHITE * (1.0 - lambertian)
    }

    /// Whether light transmitted to `exitant` is light of the peak, blurred.
    #[inline]
    fn is_through(&self, exit: &Exit, exitant: Direction, random: &mut Random) -> bool {
        let search = self.through.as_ref().and_then(|both| both[index(exit.side.opposite())].as_ref());
        let Some(search) = search.filter(|search| search.reaches(exit.incident, exitant)) else {
            return false;
        };
        let transmission = &exit.component.luminance;
        let cell = transmission.cell(exit.incident, exitant, exit.reversed);
        let kept = search.lambertian / cell.value.max(f64::MIN_POSITIVE);
        random.next_open() >= kept
            && search.peak(transmission, exit.incident, exit.reversed).is_some_and(|peak| peak.holds(&cell))
    }
}

#[inline]
fn index(side: Side) -> usize {
    usize::from(side == Side::Back)
}

/// RGB of the colour of X, Y, Z at luminance 1, mixed with white until nothing is negative.
fn of_unit_luminance(xyz: [f64; 3]) -> DVec3 {
    let rgb = DVec3::from_array(rgb_from_xyz(xyz)) / xyz[1];
    let least = rgb.min_element();
    if least >= 0.0 { rgb } else { ((rgb - 1.0) / (1.0 - least) + 1.0).max(DVec3::ZERO) }
}
