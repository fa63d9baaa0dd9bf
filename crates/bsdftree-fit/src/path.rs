//! The way that the light of one lobe goes through facets and prisms.
//!
//! In: where a lobe is for several incident directions. Out: where a [`Map`] of `bsdftree::peaks` sends its light, and how much its
//! surfaces let through, if there is a map that helps: beside the map, centres are interpolated as splines, and the map is taken whose
//! splines predict left-out centres best, if that is far better than without. So a map need not be exact, and a lobe that no map describes
//! is shifted with the incident direction.
//!
//! Places are direction cosines: surfaces keep those along them (Snell), and beyond the unit circle light is reflected totally.

use bsdftree::Part;
use bsdftree::direction::{Direction, Side, normalized};
use bsdftree::peaks::{Map, maps_through};

use crate::incidence::{Blend, Plane};
use crate::lambert::{self, Ray};

/// Fewest scans that say what a map is.
const FEWEST: usize = 6;

/// Left-out centres are off by less than this part of what they are off without a map.
const HELPS: f64 = 0.7;

/// Centres are not further from a map that they follow, on average; and a part of this distance counts as error, since a map that is far
/// off may help by chance.
const FAR: f64 = 0.1;
const DOUBT: f64 = 0.1;

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
    map: Option<Map>,
}

impl Path {
    /// The best of all maps for these incident directions and centres.
    pub fn new(part: Part, incidents: &[Ray], centers: &[Ray]) -> Path {
        let straight = Path::straight(part);
        if incidents.len() < FEWEST {
            return straight;
        }
        let points: Vec<[f64; 2]> = incidents.iter().map(|&i| lambert::point(i).map(f64::from)).collect();
        let numbers: Vec<usize> = (0..points.len()).collect();
        let plane = Plane::new(&points, &numbers, Blend::Spline);
        let missed = |path: &Path| path.missed(&plane, incidents, centers);
        let Some(without) = missed(&straight) else { return straight };
        let step = incidents.len().div_ceil(N_GUESSED);
        let peaks = incidents.iter().zip(centers).step_by(step);
        let maps = peaks.flat_map(|(&i, &o)| {
            maps_through(on_side(i, part.incident_side()), on_side(o, part.exitant_side()))
        });
        let mut guesses: Vec<(f64, Path)> = maps
            .map(|map| Path { part, map: Some(map) })
            .filter_map(|path| Some((missed(&path)?, path)))
            .collect();
        guesses.sort_by(|a, b| a.0.total_cmp(&b.0));
        guesses.truncate(N_POLISHED);
        let best =
            guesses.into_iter().map(|guess| polished(guess, missed)).min_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((error, path)) if error < HELPS * without => path,
            _ => straight,
        }
    }

    /// None that is known: lobes are shifted.
    pub fn straight(part: Part) -> Path {
        Path { part, map: None }
    }

    /// Direction cosines of where light from `incident` (upper hemisphere) goes; `None` if the map sends it nowhere.
    pub fn place(&self, incident: Ray) -> Option<[f64; 2]> {
        match self.map {
            None => Some([-f64::from(incident[0]), -f64::from(incident[1])]),
            Some(map) => map.cosines(on_side(incident, self.part.incident_side()), self.part.exitant_side()),
        }
    }

    /// The fraction of light that surfaces let through on the way to a place.
    pub fn transmittance(&self, incident: Ray, place: [f64; 2]) -> f64 {
        self.map.map_or(1.0, |map| map.transmittance(on_side(incident, self.part.incident_side()), place))
    }

    /// The power of a lobe in units of what surfaces let through.
    pub fn unattenuated(&self, power: f64, incident: Ray, center: Ray) -> f64 {
        power / self.transmittance(incident, cosines(center)).max(LEAST_TRANSMITTANCE)
    }

    /// Whether it is known where a lobe ends.
    pub fn is_known(&self) -> bool {
        self.map.is_some()
    }

    /// Mean distance of centres from what the others foresee; `None` if light goes nowhere.
    fn missed(&self, plane: &Plane, incidents: &[Ray], centers: &[Ray]) -> Option<f64> {
        let mut beside = [Vec::with_capacity(centers.len()), Vec::with_capacity(centers.len())];
        for (&i, &center) in incidents.iter().zip(centers) {
            let (place, center) = (self.place(i)?, cosines(center));
            (0..2).for_each(|d| beside[d].push(center[d] - place[d]));
        }
        let mean =
            |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x.hypot(*y)).sum::<f64>() / x.len() as f64;
        let error = mean(&plane.surprises(&beside[0])?, &plane.surprises(&beside[1])?);
        match self.map {
            None => Some(error),
            Some(_) => {
                let apart = mean(&beside[0], &beside[1]);
                (apart < FAR).then_some(error + DOUBT * apart)
            }
        }
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
            let path = Path { map: Some(changed(best.1.map?, by)?), ..best.1 };
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
