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

use bsdftree::color::rgb_from_xyz;
use bsdftree::{Band, Component, Direction, Rank, Scattering, Side};
use bsdftree_device::material::Measured;
use glam::DVec3;

use super::faults::Watch;
use super::frame::{cosine_direction, renormalized, tangents};
use super::shading::{Facing, Shade, Shading, ray_state};
use super::through::Search;
use super::{Meeting, Scatter, Spectrum};
use crate::random::Random;

/// The largest number below 1.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// A BSDF from a file, ready to scatter.
#[derive(Clone, Debug)]
pub(super) struct PreparedBsdf<S> {
    material: Arc<Measured>,
    watch: Watch,
    /// Added diffuse reflectance of the front, of the back, transmittance.
    diffuse: [S; 3],
    /// How the straight peak of light from the front, and from the back, is looked for.
    through: Option<[Option<Search>; 2]>,
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
            lambertian: [Side::Front, Side::Back].map(lambertian),
            isotropic: band.components().all(|(_, component)| is_isotropic(component)),
        }
    }

    fn band(&self) -> &Band {
        self.material.file.band()
    }
}

impl<S: Spectrum> Shading<S> for PreparedBsdf<S> {
    /// One way on, taken with a probability proportional to its luminance.
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>> {
        let facing = Facing::new(meeting, shade);
        let normal = if meeting.is_front() { facing.normal } else { -facing.normal };
        let up = self.watch.checked(self.material.up.at(|| ray_state(meeting)))?;
        let axes = match Axes::new(normal, up) {
            Some(axes) => axes,
            None if self.isotropic => Axes::any(normal),
            None => return None,
        };
        let incident = axes.local(-meeting.incoming);
        let from = Side::of(incident);
        let exits = [from, from.opposite()].map(|side| {
            let (component, reversed) = self.band().answering(from, side)?;
            Some(Exit { side, component, reversed })
        });
        let lobes = [0, 1].map(|k: usize| {
            exits[k].as_ref().map(|exit| exit.component.luminance.lobe(incident, exit.reversed))
        });
        let totals = [0, 1].map(|k: usize| lobes[k].as_ref().map_or(0.0, |lobe| lobe.total()));
        let diffuse = [self.diffuse[usize::from(from == Side::Back)], self.diffuse[2]];
        let shares = [totals[0], totals[1], diffuse[0].luminance(), diffuse[1].luminance()];
        let total: f64 = shares.iter().sum();
        let mut place = random.next_open() * total;
        // Rounding may lead past the last share, but not to one that is nothing.
        let last = shares.iter().rposition(|&share| share > 0.0)?;
        let way = (0..last).find(|&k| {
            let taken = place < shares[k];
            place -= if taken { 0.0 } else { shares[k] };
            taken
        });
        let way = way.unwrap_or(last);
        let (exitant, weight) = if way >= 2 {
            let outward = if way == 2 { facing.normal } else { -facing.normal };
            let weight = diffuse[way - 2] * shade.color * (total / shares[way]);
            (cosine_direction(outward, random), weight)
        } else {
            let (exit, lobe) = exits[way].as_ref().zip(lobes[way].as_ref())?;
            let inside = (place / shares[way]).min(BELOW_ONE);
            let (disk, value) = lobe.sample(inside, Some(random.next_open()))?;
            let exitant = exit.side.direction_from_disk(disk);
            let weight = self.tint(exit, incident, exitant) * total;
            if way == 0 {
                (axes.device(exitant), weight * self.reflected(from, value, shade))
            } else if self.is_through(exit, incident, exitant, random) {
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
    fn reflected(&self, from: Side, value: f64, shade: &Shade<S>) -> S {
        if shade.color == S::WHITE || value <= 0.0 {
            return S::WHITE;
        }
        let lambertian = (self.lambertian[usize::from(from == Side::Back)] / value).min(1.0);
        shade.color * lambertian + S::WHITE * (1.0 - lambertian)
    }

    /// Whether light transmitted to `exitant` is light of the peak, blurred.
    #[inline]
    fn is_through(&self, exit: &Exit, incident: Direction, exitant: Direction, random: &mut Random) -> bool {
        let Some(search) =
            self.through.as_ref().and_then(|both| both[usize::from(exit.side == Side::Front)].as_ref())
        else {
            return false;
        };
        if !search.reaches(incident, exitant) {
            return false;
        }
        let transmission = &exit.component.luminance;
        let cell = transmission.cell(incident, exitant, exit.reversed);
        let kept = search.lambertian / cell.value.max(f64::MIN_POSITIVE);
        random.next_open() >= kept
            && search.peak(transmission, incident, exit.reversed).is_some_and(|peak| peak.holds(&cell))
    }

    /// The colour of light, of luminance 1.
    #[inline]
    fn tint(&self, exit: &Exit, incident: Direction, exitant: Direction) -> S {
        if exit.component.chroma.is_none() || S::CHANNELS == 1 {
            return S::WHITE;
        }
        let xyz = exit.component.eval_xyz(incident, exitant, exit.reversed);
        if xyz[1] > 0.0 { S::from_rgb(of_unit_luminance(xyz)) } else { S::WHITE }
    }
}

fn is_isotropic(component: &Component) -> bool {
    matches!(&component.luminance, Scattering::Tree(tree) if tree.rank() == Rank::Three)
}

/// RGB of the colour of X, Y, Z at luminance 1, mixed with white until nothing is negative.
fn of_unit_luminance(xyz: [f64; 3]) -> DVec3 {
    let rgb = DVec3::from_array(rgb_from_xyz(xyz)) / xyz[1];
    let least = rgb.min_element();
    if least >= 0.0 { rgb } else { ((rgb - 1.0) / (1.0 - least) + 1.0).max(DVec3::ZERO) }
}
