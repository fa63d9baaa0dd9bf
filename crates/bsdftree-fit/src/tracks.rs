//! Lobes followed from scan to scan, and brought to incident directions between scans.
//!
//! A **track** is a lobe in all scans that have it ([`crate::link`] says which are one). Between scans the place, the power and the shape
//! of a track are interpolated, each track for itself, so that two lobes that move differently, as those of a prismatic film do, do not blur. Where the way of the light is known ([`Path`]), places are interpolated
//! beside it, powers in units of what surfaces let through, and a lobe ends where light is reflected totally.

use std::collections::BTreeMap;

use bsdftree::Part;
use rayon::prelude::*;

use crate::gridded::Gridded;
use crate::incidence::{Blend, Incidence, Line, Plane, Weights, lambert_radius};
use crate::lambert::{self, Ray};
use crate::link::{Group, Spot, Spots, followed};
use crate::lobes::{Lobe, NONE, lobes_of};
use crate::path::{CLEAR, Path, cosines};
use crate::progress::{Progress, Stopped};
use crate::raster::Raster;

/// Lobes with less power than this part of the mean total are noise.
const FAINT: f64 = 5e-3;

/// Lobes are known to this distance in the disk when maps are sought.
pub(crate) const EDGE: f64 = 0.05;

/// Nearest scans: those with the largest weights, which come first.
const N_NEAREST: usize = 3;

/// How much stronger than in any scan a lobe can be between them.
const STRONGEST: f64 = 1.2;

/// A lobe over all scans that have it.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    members: Vec<Member>,
    /// Scans in which the path says it is, and nothing is.
    absent: Vec<usize>,
    path: Path,
    /// Of members.
    places: Incidence,
    /// Of members and where it is absent.
    powers: Incidence,
}

/// The lobe in one scan.
#[derive(Clone, Copy, Debug)]
struct Member {
    scan: usize,
    center: Ray,
    power: f64,
    /// From where the path goes, in direction cosines.
    beside: [f64; 2],
    /// Power in units of what surfaces let through.
    strength: f64,
}

/// The lobes of all scans.
#[derive(Clone, Debug)]
pub(crate) struct Tracks {
    pub tracks: Vec<Track>,
    /// For each scan the number of the track that a pixel belongs to.
    pub labels: Vec<Vec<u8>>,
}

/// A track at one incident direction.
pub(crate) struct Followed {
    pub power: f64,
    pub center: Ray,
    /// Scans with their weights, and the centre there.
    pub scans: Vec<(usize, f64, Ray)>,
}

impl Tracks {
    /// Finds them; `None` if no scan has more than one lobe, since then nothing is gained by following them.
    pub fn new(
        scans: &[Gridded],
        channel: usize,
        line: bool,
        part: Part,
        levels: &[f32],
        progress: &Progress,
    ) -> Result<Option<Tracks>, Stopped> {
        let mean = scans.iter().map(|scan| scan.totals[channel]).sum::<f64>() / scans.len() as f64;
        let found = scans.par_iter().zip(levels).map(|(scan, &level)| {
            progress.go_on()?;
            Ok(lobes_of(scan, channel, level, FAINT * mean))
        });
        let found = found.collect::<Result<Vec<(Vec<u8>, Vec<Lobe>)>, _>>()?;
        if found.iter().all(|(_, lobes)| lobes.len() < 2) {
            return Ok(None);
        }
        let (mut labels, lobes): (Vec<_>, Vec<_>) = found.into_iter().unzip();
        let incidents: Vec<Ray> = scans.iter().map(|s| s.incident).collect();
        let spots = Spots::new(&incidents, &lobes, line, part);
        let mut groups = followed(&spots, progress)?;
        // The strongest tracks; others stay in the base.
        let strength = |group: &Group| group.spots.iter().map(|&s| spots.all[s].lobe.power).sum::<f64>();
        groups.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
        groups.truncate(usize::from(NONE));
        let mut track_of: BTreeMap<(usize, usize), u8> = BTreeMap::new();
        for (t, group) in groups.iter().enumerate() {
            track_of.extend(group.spots.iter().map(|&s| ((spots.all[s].scan, spots.all[s].number), t as u8)));
        }
        for (scan, labels) in labels.iter_mut().enumerate() {
            for label in labels.iter_mut().filter(|label| **label != NONE) {
                *label = track_of.get(&(scan, usize::from(*label))).copied().unwrap_or(NONE);
            }
        }
        let track = |group: &mut Group| {
            progress.go_on()?;
            Ok(Track::new(&spots, group, &labels))
        };
        let tracks = groups.par_iter_mut().map(track).collect::<Result<_, _>>()?;
        Ok(Some(Tracks { tracks, labels }))
    }

    /// All tracks that have power at an incident direction; `weights` are those of all scans.
    pub fn at(
        &self,
        scans: &[Ray],
        groups: &[usize],
        line: bool,
        incident: Ray,
        weights: &Weights,
        without: Option<usize>,
    ) -> Vec<(u8, Followed)> {
        let follow = |(number, track): (usize, &Track)| {
            let is_kept = |scan: &usize| without.is_none_or(|group| groups[*scan] != group);
            let of = |numbers: Vec<usize>| incidence_of(scans, numbers.into_iter().filter(is_kept), line);
            let (places, powers) = match without {
                None => (track.places.weights(incident).0, track.powers.weights(incident).0),
                Some(_) => {
                    let members: Vec<usize> = track.members.iter().map(|m| m.scan).collect();
                    let all = members.iter().chain(&track.absent).copied().collect();
                    (of(members)?.weights(incident).0, of(all)?.weights(incident).0)
                }
            };
            let place = track.place(incident, &places)?;
            let [x, y] = place;
            if x * x + y * y >= 1.0 {
                return None;
            }
            let power = match track.path.is_known() {
                true => track.strength(&powers) * track.path.transmittance(incident, place),
                false => track.power(weights),
            };
            let center = [x, y, (1.0 - x * x - y * y).sqrt()].map(|c| c as f32);
            let scans =
                places.iter().map(|&(k, w)| (k, w, track.member(k).expect("a member").center)).collect();
            (power > 0.0).then_some((number as u8, Followed { power, center, scans }))
        };
        self.tracks.iter().enumerate().filter_map(follow).collect()
    }

    /// The power of all lobes in a scan.
    pub fn power_in(&self, scan: usize) -> f64 {
        self.tracks.iter().map(|track| track.power_in(scan)).sum()
    }
}

impl Track {
    fn new(spots: &Spots<'_>, group: &mut Group, labels: &[Vec<u8>]) -> Track {
        let incidents = spots.incidents;
        let mut track = group.track(spots);
        if track.path.is_known() {
            let is_absent = |&k: &usize| {
                let dark = |[x, y]: [f64; 2]| {
                    let z = 1.0 - x * x - y * y;
                    let n = labels[k].len().isqrt();
                    let point = lambert::point([x, y, z.max(0.0).sqrt()].map(|c| c as f32));
                    x.hypot(y) < CLEAR && labels[k][Raster::pixel(n, point)] == NONE
                };
                let weights = track.places.weights(incidents[k]).0;
                track.member(k).is_none() && track.place(incidents[k], &weights).is_some_and(dark)
            };
            track.absent = (0..incidents.len()).filter(is_absent).collect();
            let all = track.members.iter().map(|m| m.scan).chain(track.absent.iter().copied());
            track.powers = incidence_of(incidents, all, spots.line).expect("a track has members");
        }
        track
    }

    /// From its lobes, one of a scan, in the order of scans, and the way of its light.
    pub fn along(path: Path, group: &[&Spot], incidents: &[Ray], line: bool) -> Track {
        let member = |&spot: &&Spot| {
            let (incident, center) = (incidents[spot.scan], spot.lobe.center);
            let ([x, y], [u, v]) =
                (cosines(center), path.place(incident).expect("its map sends light there"));
            let strength = path.unattenuated(spot.lobe.power, incident, center);
            Member { scan: spot.scan, center, power: spot.lobe.power, beside: [x - u, y - v], strength }
        };
        let members: Vec<Member> = group.iter().map(member).collect();
        let places =
            incidence_of(incidents, members.iter().map(|m| m.scan), line).expect("a track has members");
        Track { powers: places.clone(), absent: Vec::new(), members, path, places }
    }

    /// Whether a scan has it.
    pub fn has(&self, scan: usize) -> bool {
        self.member(scan).is_some()
    }

    fn member(&self, scan: usize) -> Option<&Member> {
        self.members.binary_search_by_key(&scan, |m| m.scan).ok().map(|k| &self.members[k])
    }

    /// Its power in a scan; 0 if it is not there.
    pub fn power_in(&self, scan: usize) -> f64 {
        self.member(scan).map_or(0.0, |m| m.power)
    }

    /// Where it is, in direction cosines; beyond the unit circle nothing leaves.
    fn place(&self, incident: Ray, weights: &Weights) -> Option<[f64; 2]> {
        let mut place = self.path.place(incident)?;
        for &(k, w) in weights {
            let beside = self.member(k).map_or([0.0; 2], |m| m.beside);
            (0..2).for_each(|d| place[d] += w * beside[d]);
        }
        Some(place)
    }

    /// Its power, interpolated over all scans; hardly more than the nearest have.
    fn power(&self, weights: &Weights) -> f64 {
        let near = weights.iter().take(N_NEAREST).map(|&(k, _)| self.power_in(k)).fold(0.0, f64::max);
        weights.iter().map(|&(k, w)| w * self.power_in(k)).sum::<f64>().min(1.1 * near)
    }

    /// How far from where it is foreseen a lobe is, in units of what can be foreseen so far from its scans.
    pub fn surprise(&self, incidents: &[Ray], spot: &Spot) -> f64 {
        let incident = incidents[spot.scan];
        if !self.path.lets_through(spot.lobe.power, incident) {
            return f64::INFINITY;
        }
        let gap = |m: &Member| lambert::distance(incident, incidents[m.scan]);
        let near = self.members.iter().map(gap).fold(f64::MAX, f64::min);
        let reach = if self.path.is_known() { 0.2 } else { 0.5 };
        let [x, y] = cosines(spot.lobe.center);
        let apart = |[u, v]: [f64; 2]| (u - x).hypot(v - y) / (EDGE + reach * near);
        self.place(incident, &self.places.weights(incident).0).map_or(f64::INFINITY, apart)
    }

    fn strength(&self, weights: &Weights) -> f64 {
        let strongest = self.members.iter().map(|m| m.strength).fold(0.0, f64::max);
        let here: f64 = weights.iter().map(|&(k, w)| w * self.member(k).map_or(0.0, |m| m.strength)).sum();
        here.clamp(0.0, if self.path.is_way() { strongest.min(1.0) } else { STRONGEST * strongest })
    }
}

fn incidence_of(incidents: &[Ray], numbers: impl Iterator<Item = usize>, line: bool) -> Option<Incidence> {
    let numbers: Vec<usize> = numbers.collect();
    if numbers.is_empty() {
        return None;
    }
    Some(if line {
        let radii: Vec<f64> = numbers.iter().map(|&k| lambert_radius(incidents[k])).collect();
        // A lobe need not be even in θ.
        Incidence::Line(Line::new(&radii, &numbers, Blend::Linear))
    } else {
        let points: Vec<[f64; 2]> =
            numbers.iter().map(|&k| lambert::point(incidents[k]).map(f64::from)).collect();
        Incidence::Plane(Plane::new(&points, &numbers, Blend::Spline))
    })
}
