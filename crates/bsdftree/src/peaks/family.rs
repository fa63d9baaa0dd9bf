//! Peaks of many incident directions, grouped into families that one map describes.
//!
//! In: the peaks of each incident cell and which cells touch. Out: [`Family`]s. As long as there is a map that enough
//! peaks follow, the one that most follow takes them. What is left is linked where touching incident cells send peaks
//! nearby ([`links`]), and becomes tables. Few directions make no family, nor do weak peaks make a table: noise
//! stands out in single cells, but not alike in many, and where it is dense it links by chance.

use std::collections::{BTreeMap, BTreeSet};

use crate::peaks::fit::{Pair, best_map};
use crate::peaks::map::Map;

/// A family holds at least one in so many of the incident directions.
const RARITY: usize = 32;
/// Least mean strength of a table, as a multiple of the least strength of a peak. Noise of 100 paths per incident
/// cell, each 1 % of the light but shared among pairs of directions, linked up to tables of 0.6 %, three times the
/// default of 0.2 %.
const OVER_LEAST: f64 = 5.0;

/// A peak of one incident cell, as far as grouping needs to know it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    /// Which incident cell.
    pub direction: usize,
    pub pair: Pair,
}

/// Peaks that one map describes, by their numbers; at most one of each incident direction, except in tables.
#[derive(Clone, Debug)]
pub(super) struct Family {
    pub map: Map,
    pub members: Vec<usize>,
}

/// Groups peaks of at least `min_strength`. `fixed` are the maps that need no fit; `fitted` says whether others make
/// sense (not where azimuth is lost).
pub(super) fn families(
    members: &[Member],
    neighbours: &[Vec<u32>],
    fixed: &[Map],
    fitted: bool,
    min_strength: f64,
) -> Vec<Family> {
    let least = neighbours.len().div_ceil(RARITY);
    let mut rest: Vec<usize> = (0..members.len()).collect();
    let mut families = Vec::new();
    loop {
        let pairs: Vec<Pair> = rest.iter().map(|&k| members[k].pair).collect();
        let Some(map) = best_map(&pairs, fixed, fitted, least) else { break };
        let following = strongest_followers(members, &rest, &map);
        if following.len() < least {
            break;
        }
        rest.retain(|k| following.binary_search(k).is_err());
        families.push(Family { map, members: following });
    }
    // Two directions cannot show that they are no accident.
    let tables = linked(members, &rest, neighbours).into_iter().filter(|group| {
        let strength = group.iter().map(|&k| members[k].pair.weight).sum::<f64>() / group.len() as f64;
        let directions: BTreeSet<usize> = group.iter().map(|&k| members[k].direction).collect();
        directions.len() >= least.max(3) && strength >= OVER_LEAST * min_strength
    });
    families.extend(tables.map(|members| Family { map: Map::Table, members }));
    families
}

/// The strongest peak of each direction that follows a map.
fn strongest_followers(members: &[Member], among: &[usize], map: &Map) -> Vec<usize> {
    let mut strongest = BTreeMap::new();
    for &k in among.iter().filter(|&&k| members[k].pair.distance(map) <= 1.0) {
        let best = strongest.entry(members[k].direction).or_insert(k);
        if members[k].pair.weight > members[*best].pair.weight {
            *best = k;
        }
    }
    let mut following: Vec<usize> = strongest.into_values().collect();
    following.sort_unstable();
    following
}

/// Groups of peaks linked over touching incident cells.
fn linked(members: &[Member], among: &[usize], neighbours: &[Vec<u32>]) -> Vec<Vec<usize>> {
    let mut of_direction = vec![Vec::new(); neighbours.len()];
    among.iter().for_each(|&k| of_direction[members[k].direction].push(k));
    let mut seen = vec![false; members.len()];
    let mut groups = Vec::new();
    for &first in among {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let mut group = vec![first];
        let mut next = 0;
        while next < group.len() {
            let k = group[next];
            for &direction in &neighbours[members[k].direction] {
                for &j in &of_direction[direction as usize] {
                    if !seen[j] && links(&members[k].pair, &members[j].pair) {
                        seen[j] = true;
                        group.push(j);
                    }
                }
            }
            next += 1;
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// Whether two peaks may be one that moves with its light. Reflections keep the distance of two directions, shifts
/// keep it in the disk: so one of the two must be kept, up to half as much again and a cell.
fn links(a: &Pair, b: &Pair) -> bool {
    let distance =
        |n: usize, a: [f64; 3], b: [f64; 3]| (0..n).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    [2, 3].into_iter().any(|n| {
        distance(n, a.exitant, b.exitant) <= 1.5 * distance(n, a.incident, b.incident) + a.edge.max(b.edge)
    })
}
