//! The way that the light of one lobe goes through facets and prisms.
//!
//! In: where a lobe is for several incident directions, and its power there. Out: where a [`Map`] of `bsdftree::peaks` sends its light, and
//! how much its surfaces let through, if there is a map that helps: beside the map, centres and powers are interpolated as splines, and the
//! map is taken with which the least light of left-out scans is put in the wrong place, if that is far less than without. So a map need not
//! be exact, and a lobe that no map describes is shifted with the incident direction.
//!
//! Places are direction cosines: surfaces keep those along them (Snell), and beyond the unit circle light is reflected totally.

use bsdftree::Part;
use bsdftree::direction::{Direction, Side, normalized};
use bsdftree::peaks::{Map, maps_through};

use crate::incidence::{Blend, Plane, Weights};
use crate::lambert::{self, Ray};
use crate::ways::Way;

/// Fewest scans that say what a map is.
const FEWEST: usize = 6;

/// With a map less than this part of the light is misplaced that is misplaced without.
const HELPS: f64 = 0.8;

/// A centre so far off misplaces all light of a lobe \[direction cosines\]; and at most so many times it counts.
const RADIUS: f64 = 0.1;
const MOST: f64 = 2.0;

/// A part of the distance of centres from a map counts as error, since a map that is far off may help by chance.
const DOUBT: f64 = 0.1;

/// A lobe is looked for where it leaves within this radius, in direction cosines.
pub(crate) const CLEAR: f64 = 0.98;

/// Scans that guesses are made from.
const N_GUESSED: usize = 16;

/// Guesses that are made better.
const N_POLISHED: usize = 4;

/// A transmittance below this says nothing of the power of a lobe.
const LEAST_TRANSMITTANCE: f64 = 0.05;

/// Where a lobe's light goes, but for what is interpolated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
    part: Part,
    known: Option<Known>,
}

/// What sends light to a place.
#[derive(Clone, Copy, Debug)]
enum Known {
    Map(Map),
    Way(Way),
}

/// One lobe in all scans.
pub(crate) struct Seen<'a> {
    /// Of all scans.
    pub incidents: &'a [Ray],
    /// Centre and power in those that have it, by scan.
    pub members: &'a [(usize, Ray, f64)],
    /// Centres of the lobes of each scan, this one and others.
    pub others: &'a [Vec<Ray>],
}

impl Path {
    /// The best of all maps.
    pub fn new(part: Part, seen: &Seen<'_>) -> Path {
        let straight = Path::straight(part);
        if seen.members.len() < FEWEST {
            return straight;
        }
        let Some(judge) = Judge::new(seen) else { return straight };
        let Some(without) = judge.misplaced(&straight) else { return straight };
        let step = seen.members.len().div_ceil(N_GUESSED);
        let maps = seen.members.iter().step_by(step).flat_map(|&(k, o, _)| {
            maps_through(on_side(seen.incidents[k], part.incident_side()), on_side(o, part.exitant_side()))
        });
        let mut guesses: Vec<(f64, Path)> = maps
            .map(|map| Path { part, known: Some(Known::Map(map)) })
            .filter_map(|path| Some((judge.misplaced(&path)?, path)))
            .collect();
        guesses.sort_by(|a, b| a.0.total_cmp(&b.0));
        guesses.truncate(N_POLISHED);
        let polish = |guess| polished(guess, |path| judge.misplaced(path));
        let best = guesses.into_iter().map(polish).min_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((error, path)) if error < HELPS * without => path,
            _ => straight,
        }
    }

    /// None that is known: lobes are shifted.
    pub fn straight(part: Part) -> Path {
        Path { part, known: None }
    }

    /// A way through a film that is known by other lobes.
    pub fn along(part: Part, way: Way) -> Path {
        Path { part, known: Some(Known::Way(way)) }
    }

    /// The map, if it is one.
    pub fn map(&self) -> Option<Map> {
        match self.known {
            Some(Known::Map(map)) => Some(map),
            _ => None,
        }
    }

    /// Direction cosines of where light from `incident` (upper hemisphere) goes; `None` if it goes nowhere.
    pub fn place(&self, incident: Ray) -> Option<[f64; 2]> {
        let from = on_side(incident, self.part.incident_side());
        match self.known {
            None => Some([-f64::from(incident[0]), -f64::from(incident[1])]),
            Some(Known::Map(map)) => map.cosines(from, self.part.exitant_side()),
            Some(Known::Way(way)) => way.to(from).map(|(place, _)| place),
        }
    }

    /// The fraction of light that surfaces let through on the way to a place.
    pub fn transmittance(&self, incident: Ray, place: [f64; 2]) -> f64 {
        let from = on_side(incident, self.part.incident_side());
        match self.known {
            None => 1.0,
            Some(Known::Map(map)) => map.transmittance(from, place),
            Some(Known::Way(way)) => way.to(from).map_or(0.0, |(_, power)| power),
        }
    }

    /// The power of a lobe in units of what surfaces let through.
    pub fn unattenuated(&self, power: f64, incident: Ray, center: Ray) -> f64 {
        power / self.transmittance(incident, cosines(center)).max(LEAST_TRANSMITTANCE)
    }

    /// Whether a lobe of light from a direction can have this power: on a way through a film, no more than faces let through.
    pub fn lets_through(&self, power: f64, incident: Ray) -> bool {
        /// Light of near directions is let through better, and is seen too.
        const BLURRED: f64 = 1.1;
        match self.known {
            Some(Known::Way(way)) => {
                let there = way.to(on_side(incident, self.part.incident_side()));
                there.is_some_and(|(_, most)| power < BLURRED * most)
            }
            _ => true,
        }
    }

    /// Whether it is one through a film that is known by other lobes.
    pub fn is_way(&self) -> bool {
        matches!(self.known, Some(Known::Way(_)))
    }

    /// Whether it is known where a lobe ends.
    pub fn is_known(&self) -> bool {
        self.known.is_some()
    }
}

/// Tells how much of a lobe's light a path misplaces in scans that are left out.
struct Judge<'a> {
    seen: &'a Seen<'a>,
    plane: Plane,
    /// Scans without it, and what its scans weigh there (by number of member).
    elsewhere: Vec<(usize, Weights)>,
    /// Power that splines over all scans misplace.
    without: f64,
}

impl Judge<'_> {
    fn new<'a>(seen: &'a Seen<'a>) -> Option<Judge<'a>> {
        let point = |k: usize| lambert::point(seen.incidents[k]).map(f64::from);
        let plane = |scans: &[usize]| {
            let points: Vec<[f64; 2]> = scans.iter().map(|&k| point(k)).collect();
            Plane::new(&points, &(0..scans.len()).collect::<Vec<_>>(), Blend::Spline)
        };
        let own: Vec<usize> = seen.members.iter().map(|m| m.0).collect();
        let all: Vec<usize> = (0..seen.incidents.len()).collect();
        let power = |&k: &usize| own.binary_search(&k).map_or(0.0, |j| seen.members[j].2);
        let powers: Vec<f64> = all.iter().map(power).collect();
        let without = plane(&all).surprises(&powers)?.iter().map(|e| e.abs()).sum();
        let plane = plane(&own);
        let elsewhere = all.iter().filter(|k| own.binary_search(k).is_err());
        let elsewhere = elsewhere.map(|&k| (k, plane.weights(point(k)).0)).collect();
        Some(Judge { seen, plane, elsewhere, without })
    }

    /// Light at wrong places, in units of all; `None` if light goes nowhere.
    fn misplaced(&self, path: &Path) -> Option<f64> {
        let Seen { incidents, members, others } = *self.seen;
        let mut beside = [Vec::with_capacity(members.len()), Vec::with_capacity(members.len())];
        for &(k, center, _) in members {
            let (place, center) = (path.place(incidents[k])?, cosines(center));
            (0..2).for_each(|d| beside[d].push(center[d] - place[d]));
        }
        let [x, y] = [self.plane.surprises(&beside[0])?, self.plane.surprises(&beside[1])?];
        let off = |j: usize| {
            let doubt = if path.is_known() { DOUBT * beside[0][j].hypot(beside[1][j]) } else { 0.0 };
            ((x[j].hypot(y[j]) + doubt) / RADIUS).min(MOST)
        };
        let mut error: f64 = members.iter().enumerate().map(|(j, m)| m.2 * off(j)).sum();
        if path.is_known() {
            let strength =
                |&(k, center, power): &(usize, Ray, f64)| path.unattenuated(power, incidents[k], center);
            let strengths: Vec<f64> = members.iter().map(strength).collect();
            let wrong = self.plane.surprises(&strengths)?;
            error +=
                members.iter().zip(&strengths).zip(wrong).map(|((m, s), e)| (e * m.2 / s).abs()).sum::<f64>();
            for (k, weights) in &self.elsewhere {
                let Some(mut place) = path.place(incidents[*k]) else { continue };
                (0..2).for_each(|d| place[d] += weights.iter().map(|&(j, w)| w * beside[d][j]).sum::<f64>());
                let near = |&o: &Ray| (cosines(o)[0] - place[0]).hypot(cosines(o)[1] - place[1]) < RADIUS;
                if place[0].hypot(place[1]) < CLEAR && !others[*k].iter().any(near) {
                    let strength: f64 = weights.iter().map(|&(j, w)| w * strengths[j]).sum();
                    error += strength.abs() * path.transmittance(incidents[*k], place);
                }
            }
        } else {
            error += self.without;
        }
        Some(error / members.iter().map(|m| m.2).sum::<f64>())
    }
}

pub(crate) fn cosines(direction: Ray) -> [f64; 2] {
    [f64::from(direction[0]), f64::from(direction[1])]
}

pub(crate) fn on_side([x, y, z]: Ray, side: Side) -> Direction {
    let d = [f64::from(x), f64::from(y), f64::from(z) * side.sign()];
    normalized(d).unwrap_or(d)
}

/// The map with its normal tilted and its index changed until nothing is better.
fn polished(mut best: (f64, Path), missed: impl Fn(&Path) -> Option<f64>) -> (f64, Path) {
    let mut step = 0.04;
    while step > 1e-3 {
        let near = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let near = near.into_iter().flat_map(|d| [d.map(|c| c * step), d.map(|c| -c * step)]);
        let tried = near.filter_map(|by| {
            let path = Path { known: Some(Known::Map(changed(best.1.map()?, by)?)), ..best.1 };
            Some((missed(&path)?, path))
        });
        match tried.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some(better) if better.0 < best.0 => best = better,
            _ => step *= 0.5,
        }
    }
    best
}

/// A map with x and y of its normal and its index changed by so much.
fn changed(map: Map, [dx, dy, dn]: [f64; 3]) -> Option<Map> {
    /// Of water and of sapphire.
    const INDICES: std::ops::Range<f64> = 1.3..1.8;
    let tilted = |[x, y, z]: Direction| normalized([x + dx, y + dy, z]);
    let bounded = |index: f64| INDICES.contains(&(index + dn)).then_some(index + dn);
    Some(match map {
        Map::Facet { normal } => Map::Facet { normal: tilted(normal)? },
        Map::Groove { axis } => Map::Groove { axis: tilted(axis)? },
        Map::Prism { normal, index, flat_first } => {
            Map::Prism { normal: tilted(normal)?, index: bounded(index)?, flat_first }
        }
        Map::InnerFacet { normal, index } => {
            Map::InnerFacet { normal: tilted(normal)?, index: bounded(index)? }
        }
        fixed => fixed,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lobe that a prism sends, in 25 scans; where it is reflected totally, or fainter than 0.02, it is not seen.
    fn seen_of(map: Map) -> (Vec<Ray>, Vec<(usize, Ray, f64)>) {
        let ring = |radius: f32, n: usize| {
            (0..n).map(move |k| {
                let phi = (k as f32 + 0.5 * radius) * std::f32::consts::TAU / n as f32;
                lambert::direction([radius * phi.cos(), radius * phi.sin()])
            })
        };
        let incidents: Vec<Ray> =
            ring(0.0, 1).chain(ring(0.3, 6)).chain(ring(0.55, 8)).chain(ring(0.8, 10)).collect();
        let part = Part::TransmissionBack;
        let path = Path { part, known: Some(Known::Map(map)) };
        let member = |(k, &incident): (usize, &Ray)| {
            let [x, y] = path.place(incident).filter(|[x, y]| x.hypot(*y) < 0.99)?;
            let power = 0.7 * path.transmittance(incident, [x, y]);
            let center = [x, y, (1.0 - x * x - y * y).sqrt()].map(|c| c as f32);
            (power > 0.02).then_some((k, center, power))
        };
        let members = incidents.iter().enumerate().filter_map(member).collect();
        (incidents, members)
    }

    fn found(incidents: &[Ray], members: &[(usize, Ray, f64)]) -> Path {
        let mut others = vec![Vec::new(); incidents.len()];
        members.iter().for_each(|m| others[m.0].push(m.1));
        Path::new(Part::TransmissionBack, &Seen { incidents, members, others: &others })
    }

    #[test]
    fn a_prism_is_known_by_its_lobe() {
        let normal = normalized([0.0, -0.5, 0.866]).unwrap();
        let (incidents, members) = seen_of(Map::Prism { normal, index: 1.49, flat_first: false });
        let Some(Map::Prism { normal: [x, y, _], index, flat_first: false }) =
            found(&incidents, &members).map()
        else {
            panic!("no prism");
        };
        assert!(x.abs() < 0.02 && (y + 0.5).abs() < 0.02 && (index - 1.49).abs() < 0.03, "{x} {y} {index}");
    }

    #[test]
    fn a_lobe_that_wanders_has_no_map() {
        let (incidents, mut members) = seen_of(Map::Straight);
        for (n, (_, center, power)) in members.iter_mut().enumerate() {
            let by = 0.3 * (7.0 * n as f32).sin();
            *center = lambert::direction([0.5 * by, 0.4 * (by + 0.1 * n as f32).cos()]);
            *power = 0.3;
        }
        assert!(!found(&incidents, &members).is_known());
    }
}
