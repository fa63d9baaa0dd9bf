//! Finding the map that most peaks follow.
//!
//! In: [`Pair`]s of incident and exitant directions. Out: the [`Map`] with the most followers. A pair follows a map
//! if its exitant direction lies within one exitant cell's edge of the mapped one: data in cells cannot say more.
//!
//! Guesses from single pairs are refined on their followers (after M. Fischler, R. Bolles, "Random sample consensus",
//! CACM 24(6), 1981; here every so many pairs are tried in turn and nothing is random). A normal is the weighted mean
//! of the [`bend`]s of the pairs, which lie along it; a shift is a mean; an index of refraction is scanned.

use crate::direction::{Direction, Side, normalized};
use crate::peaks::map::{Map, optical};

/// Pairs that guesses are made from.
const MAX_GUESSES: usize = 32;
/// Indices of refraction to begin with: plastics and glasses.
const INDICES: [f64; 4] = [1.4, 1.5, 1.6, 1.7];
/// Bounds of the index: water to sapphire.
const INDEX_RANGE: [f64; 2] = [1.3, 1.8];
/// Largest root mean square distance of followers, in cell edges. Peaks strewn over the disk of one edge have 0.71,
/// those along a curve that the map merely touches 0.58; the right maps of generated devices had 0 to 0.31.
const FITTING: f64 = 0.33;
/// The same for isotropic data, where a peak lies between two cells of which genBSDF fills one.
const FITTING_ISOTROPIC: f64 = 0.75;
/// As near as peaks get to the right map.
const EXACT: f64 = 0.1;
/// Most peaks between one and two edges off, as a part of the followers. Many are there if a map is but the tangent
/// of the right one.
const MISSED: f64 = 0.4;

/// Fits compared in the end.
const FINALISTS: usize = 8;

/// A peak's directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub incident: Direction,
    pub exitant: Direction,
    /// Edge of the exitant cell in the disk.
    pub edge: f64,
    /// Its strength: of light that only part of an incident cell sends on, one knows badly where it came from.
    pub weight: f64,
}

impl Pair {
    /// Distance in the disk, in cell edges, from where a map sends the light; infinite if it does not.
    pub fn distance(&self, map: &Map) -> f64 {
        map.exitant(self.incident, Side::of(self.exitant)).map_or(f64::INFINITY, |mapped| {
            (mapped[0] - self.exitant[0]).hypot(mapped[1] - self.exitant[1]) / self.edge
        })
    }

    /// Angle \[degree\] from where a map sends the light; NaN if it does not.
    pub fn angle_deg(&self, map: &Map) -> f64 {
        map.exitant(self.incident, Side::of(self.exitant)).map_or(f64::NAN, |mapped| {
            let chord = (0..3).map(|k| (mapped[k] - self.exitant[k]).powi(2)).sum::<f64>().sqrt();
            2.0 * (0.5 * chord).min(1.0).asin().to_degrees()
        })
    }
}

/// Root mean square; NaN of nothing.
pub(super) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0u32), |(sum, n), value| (sum + value * value, n + 1));
    (sum / f64::from(n)).sqrt()
}

/// The map that most pairs follow closely, at least `least`; a `fixed` one rather than one that hardly more follow
/// hardly more closely.
pub(super) fn best_map(pairs: &[Pair], fixed: &[Map], fitted: bool, least: usize) -> Option<Map> {
    let limit = if fitted { FITTING } else { FITTING_ISOTROPIC };
    let fixed = fixed.iter().filter_map(|&map| Fit::new(map, pairs, least, limit)).max_by_key(|fit| fit.n);
    if !fitted || fixed.as_ref().is_some_and(|fixed| fixed.n == pairs.len() && fixed.apart < EXACT) {
        return fixed.map(|fit| fit.map);
    }
    match (fixed, best_fit(pairs, least)) {
        // A prism of few degrees is not straight through if twice as close.
        (Some(a), Some(b)) if b.n > a.n + a.n / 20 || (b.n + b.n / 20 > a.n && b.apart < 0.5 * a.apart) => {
            Some(b.map)
        }
        (Some(a), _) => Some(a.map),
        (None, b) => Some(b?.map),
    }
}

/// The facet, prism or shift that most pairs follow closely.
fn best_fit(pairs: &[Pair], least: usize) -> Option<Fit> {
    let step = pairs.len().div_ceil(MAX_GUESSES).max(1);
    let guesses = pairs.iter().step_by(step).flat_map(|&pair| through(pair));
    // A guess from one pair is off by up to half a cell each way, and twice that where it is reflected.
    let refined = guesses.filter_map(|guess| {
        let near = followers(pairs, &guess, 1.5);
        if near.len() < least { None } else { fit(&guess, &near) }
    });
    let n_followers = |map: &Map| pairs.iter().filter(|p| p.distance(map) <= 1.0).count();
    let mut fits: Vec<(usize, Map)> = refined.map(|map| (n_followers(&map), map)).collect();
    fits.retain(|&(n, _)| n >= least);
    fits.sort_by_key(|&(n, _)| std::cmp::Reverse(n));
    fits.into_iter()
        .filter_map(|(_, map)| Fit::new(polished(map, pairs), pairs, least, FITTING))
        .take(FINALISTS)
        .reduce(
            |best, next| if next.n + next.n / 20 >= best.n && next.apart < best.apart { next } else { best },
        )
}

/// Maps that send the light of a pair where it goes.
pub(super) fn through(pair: Pair) -> impl Iterator<Item = Map> {
    kinds(Side::of(pair.incident) == Side::of(pair.exitant)).filter_map(move |kind| fit(&kind, &[pair]))
}

/// A map that peaks follow.
struct Fit {
    map: Map,
    n: usize,
    /// Root mean square distance of its followers.
    apart: f64,
}

impl Fit {
    /// If enough follow it, closely, and few nearly do; and if its index is not merely the last one tried.
    fn new(map: Map, pairs: &[Pair], least: usize, limit: f64) -> Option<Fit> {
        let following = followers(pairs, &map, 1.0);
        let n = following.len();
        let apart = rms(following.iter().map(|p| p.distance(&map)));
        let missed = followers(pairs, &map, 2.0).len() - n;
        let inside = match map {
            Map::Prism { index, .. } | Map::InnerFacet { index, .. } => !INDEX_RANGE.contains(&index),
            _ => true,
        };
        let close = apart <= limit && missed as f64 <= MISSED * n as f64;
        (n >= least.max(1) && close && inside).then_some(Fit { map, n, apart })
    }
}

/// What a fit may be, with indices of refraction to begin with.
fn kinds(reflection: bool) -> impl Iterator<Item = Map> {
    let normal = [0.0; 3];
    let refracting = INDICES.into_iter().flat_map(move |index| {
        if reflection {
            vec![Map::InnerFacet { normal, index }]
        } else {
            [true, false].map(|flat_first| Map::Prism { normal, index, flat_first }).to_vec()
        }
    });
    [Map::Facet { normal }, Map::Groove { axis: normal }, Map::Shift { cosines: [0.0; 2] }]
        .into_iter()
        .chain(refracting)
}

/// The pairs within so many cell edges of a map.
fn followers(pairs: &[Pair], map: &Map, edges: f64) -> Vec<Pair> {
    pairs.iter().filter(|pair| pair.distance(map) <= edges).copied().collect()
}

/// The map of the same kind, and the same index, that fits pairs best.
fn fit(kind: &Map, pairs: &[Pair]) -> Option<Map> {
    let normal = || mean_normal(kind, pairs);
    Some(match *kind {
        Map::Facet { .. } => Map::Facet { normal: normal()? },
        Map::Groove { .. } => Map::Groove { axis: normal()? },
        Map::Prism { index, flat_first, .. } => Map::Prism { normal: normal()?, index, flat_first },
        Map::InnerFacet { index, .. } => Map::InnerFacet { normal: normal()?, index },
        Map::Shift { .. } => {
            let weight: f64 = pairs.iter().map(|p| p.weight).sum();
            let mean = |k: usize| {
                pairs.iter().map(|p| p.weight * (p.exitant[k] + p.incident[k])).sum::<f64>() / weight
            };
            Map::Shift { cosines: [mean(0), mean(1)] }
        }
        fixed => fixed,
    })
}

/// The vector along the normal of the facet that sent a pair's light on: the change of the optical vector there. Or
/// along the axis of a groove: the change from going back.
fn bend(kind: &Map, pair: &Pair) -> Direction {
    let travel = pair.incident.map(|c| -c);
    let before = |index| optical([travel[0], travel[1]], index, travel[2].signum());
    let after = |index| optical([pair.exitant[0], pair.exitant[1]], index, pair.exitant[2].signum());
    let (from, to) = match *kind {
        Map::Prism { index, flat_first: true, .. } => (before(index), pair.exitant),
        Map::Prism { index, .. } => (travel, after(index)),
        Map::InnerFacet { index, .. } => (before(index), after(index)),
        Map::Groove { .. } => (pair.incident, pair.exitant),
        _ => (travel, pair.exitant),
    };
    std::array::from_fn(|k| to[k] - from[k])
}

/// Mean of the bends, each up to its sign, by length (a short one is known badly), strength and the cosines of both
/// directions: towards the horizon a cell says little of the third coordinate.
fn mean_normal(kind: &Map, pairs: &[Pair]) -> Option<Direction> {
    let weighted = |pair: &Pair| {
        let weight = pair.weight * (pair.incident[2] * pair.exitant[2]).abs();
        bend(kind, pair).map(|c| c * weight)
    };
    let length = |v: Direction| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let longest = pairs.iter().map(weighted).max_by(|a, b| length(*a).total_cmp(&length(*b)))?;
    let mut total = [0.0; 3];
    for vector in pairs.iter().map(weighted) {
        let same_way = (0..3).map(|k| vector[k] * longest[k]).sum::<f64>();
        (0..3).for_each(|k| total[k] += vector[k].copysign(vector[k] * same_way));
    }
    let normal = normalized(total)?;
    let upright = if normal[2] < 0.0 { -1.0 } else { 1.0 };
    Some(normal.map(|c| c * upright))
}

/// The map refined on its followers until they are no closer, with the index of refraction that brings them closest.
fn polished(map: Map, pairs: &[Pair]) -> Map {
    let mut best = map;
    let mut closest = f64::INFINITY;
    for _ in 0..4 {
        let near = followers(pairs, &best, 1.0);
        let (next, apart) = scanned(best, &near);
        if apart >= 0.99 * closest {
            break;
        }
        (best, closest) = (next, apart);
    }
    best
}

/// The map of the same kind that is closest to these pairs, and how close.
fn scanned(map: Map, pairs: &[Pair]) -> (Map, f64) {
    let apart = |map: &Map| {
        let squares = pairs.iter().map(|p| [p.weight * p.distance(map).min(2.0).powi(2), p.weight]);
        let [sum, weight] = squares.fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        (sum / weight).sqrt()
    };
    let mut best = (map, apart(&map));
    for step in [0.04, 0.01, 0.0025] {
        let start = best.0;
        for k in -4..=4 {
            let mut kind = start;
            if let Map::Prism { index, .. } | Map::InnerFacet { index, .. } = &mut kind {
                *index = (*index + f64::from(k) * step).clamp(INDEX_RANGE[0], INDEX_RANGE[1]);
            } else if k != 0 {
                continue;
            }
            let Some(trial) = fit(&kind, pairs) else { continue };
            let trial = (trial, apart(&trial));
            if trial.1 < best.1 {
                best = trial;
            }
        }
    }
    best
}
