//! Which lobes of scans are one: lobes of all scans → groups, each of which becomes a track.
//!
//! Lobes that one map of `bsdftree::peaks` describes are one; of the others, those of neighbouring scans that deviate alike from where
//! light goes straight or is mirrored, and have about the same power; and groups are joined if one foresees where the other is.

use std::collections::BTreeMap;

use bsdftree::Part;
use bsdftree::direction::Direction;
use bsdftree::peaks::{Map, map_of};

use crate::lambert::{self, Ray};
use crate::lobes::Lobe;
use crate::path::{Path, Seen, on_side};
use crate::progress::{Progress, Stopped};
use crate::tracks::{EDGE, Track};
use crate::ways::{Film, Way};

/// One in so many scans has a lobe that a map is sought for, and at least [`FEWEST`].
const RARITY: usize = 5;
const FEWEST: usize = 6;

/// Neighbours of a scan among which its lobes are looked for.
const N_NEIGHBOURS: usize = 8;

/// A lobe and where it was found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    pub scan: usize,
    /// Among the lobes of the scan.
    pub number: usize,
    pub lobe: Lobe,
    /// From the mirror direction \[disk\].
    deviation: [f64; 2],
}

/// The lobes of all scans.
pub(crate) struct Spots<'a> {
    pub incidents: &'a [Ray],
    pub all: Vec<Spot>,
    /// Whether the sample is isotropic.
    pub line: bool,
    part: Part,
    /// Centres of the lobes of each scan.
    centers: Vec<Vec<Ray>>,
}

/// Lobes that are one, in one scan at most each.
pub(crate) struct Group {
    /// Their numbers.
    pub spots: Vec<usize>,
    /// The way of their light, as far as it was looked for.
    path: Option<Path>,
}

impl<'a> Spots<'a> {
    /// From the lobes of each scan.
    pub fn new(incidents: &'a [Ray], lobes: &[Vec<Lobe>], line: bool, part: Part) -> Spots<'a> {
        let of_scan = |(scan, lobes): (usize, &Vec<Lobe>)| -> Vec<Spot> {
            let [mx, my] = lambert::point(incidents[scan]).map(f64::from);
            let spot = |(number, &lobe): (usize, &Lobe)| {
                let [x, y] = lambert::point(lobe.center).map(f64::from);
                Spot { scan, number, lobe, deviation: [x + mx, y + my] }
            };
            lobes.iter().enumerate().map(spot).collect()
        };
        let all = lobes.iter().enumerate().flat_map(of_scan).collect();
        let centers = lobes.iter().map(|lobes| lobes.iter().map(|lobe| lobe.center).collect()).collect();
        Spots { incidents, all, line, part, centers }
    }

    /// The direction that light comes from, and the one of the lobe.
    fn directions(&self, s: usize) -> (Direction, Direction) {
        let spot = &self.all[s];
        let incident = on_side(self.incidents[spot.scan], self.part.incident_side());
        (incident, on_side(spot.lobe.center, self.part.exitant_side()))
    }

    /// The best path of some lobes.
    fn path(&self, of: &[&Spot]) -> Path {
        if self.line {
            return Path::straight(self.part);
        }
        let members: Vec<_> = of.iter().map(|spot| (spot.scan, spot.lobe.center, spot.lobe.power)).collect();
        Path::new(self.part, &Seen { incidents: self.incidents, members: &members, others: &self.centers })
    }
}

impl Group {
    fn new(spots: Vec<usize>) -> Group {
        Group { spots, path: None }
    }

    /// With other lobes of the same light; where that goes has to be looked for again.
    fn extend(&mut self, more: Vec<usize>) {
        if !more.is_empty() {
            self.spots.extend(more);
            self.path = self.path.filter(Path::is_way);
        }
    }

    fn path(&mut self, spots: &Spots<'_>) -> Path {
        *self.path.get_or_insert_with(|| spots.path(&members_of(&self.spots, spots)))
    }

    /// The lobes brought to all incident directions.
    pub fn track(&mut self, spots: &Spots<'_>) -> Track {
        Track::along(self.path(spots), &members_of(&self.spots, spots), spots.incidents, spots.line)
    }
}

fn members_of<'a>(numbers: &[usize], spots: &'a Spots<'_>) -> Vec<&'a Spot> {
    let mut members: Vec<&Spot> = numbers.iter().map(|&s| &spots.all[s]).collect();
    members.sort_by_key(|spot| spot.scan);
    members
}

/// Lobes of all scans, those that are one together.
pub(crate) fn followed(spots: &Spots<'_>, progress: &Progress) -> Result<Vec<Group>, Stopped> {
    let mut free: Vec<usize> = (0..spots.all.len()).collect();
    if spots.line {
        return Ok(linked(spots, &free));
    }
    let mut groups = mapped(spots, &mut free);
    through_film(spots, &mut groups, &mut free);
    groups.extend(linked(spots, &free));
    joined(spots, groups, progress)
}

/// Groups that maps describe, as long as there are any; their lobes are free no more.
fn mapped(spots: &Spots<'_>, free: &mut Vec<usize>) -> Vec<Group> {
    let least = spots.incidents.len().div_ceil(RARITY).max(FEWEST);
    let mut groups = Vec::new();
    loop {
        let peaks: Vec<_> = free.iter().map(|&s| spots.directions(s)).collect();
        let Some(map) = map_of(&peaks, EDGE, least) else { return groups };
        let apart = |s: usize| {
            let (incident, exitant) = spots.directions(s);
            let there = map.exitant(incident, spots.part.exitant_side());
            there.map_or(f64::INFINITY, |[x, y, _]| (x - exitant[0]).hypot(y - exitant[1]) / EDGE)
        };
        let mut group = Group::new(nearest(spots, free, apart));
        if group.spots.len() < least {
            return groups;
        }
        let more = claimed(spots, &mut group, free);
        group.extend(more);
        free.retain(|s| !group.spots.contains(s));
        groups.push(group);
    }
}

/// If two groups go through facets of a film, others are looked for that go ways through the same film.
fn through_film(spots: &Spots<'_>, groups: &mut Vec<Group>, free: &mut Vec<usize>) {
    /// Fewest lobes that say that light goes a way.
    const FEWEST: usize = 3;
    let maps: Vec<Option<Map>> = groups.iter_mut().map(|group| group.path(spots).map()).collect();
    let mut pairs = (0..maps.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    let Some(film) = pairs.find_map(|(a, b)| Film::of(spots.part, maps[a]?, maps[b]?)) else { return };
    let is_prism = |group: &Group| matches!(group.path.and_then(|path| path.map()), Some(Map::Prism { .. }));
    for group in groups.extract_if(.., |group| !is_prism(group)) {
        free.extend(group.spots);
    }
    free.sort_unstable();
    let near: Vec<Vec<(Way, f64)>> = (0..spots.all.len()).map(|s| nearby(spots, &film, s)).collect();
    loop {
        let mut ways: Vec<(Way, Vec<(usize, f64)>)> = Vec::new();
        for (s, &(way, worth)) in free.iter().flat_map(|&s| near[s].iter().map(move |n| (s, n))) {
            match ways.iter_mut().find(|(other, _)| other.is_same(&way)) {
                Some((_, lobes)) => lobes.push((s, worth)),
                None => ways.push((way, vec![(s, worth)])),
            }
        }
        ways.retain(|(_, lobes)| lobes.len() >= FEWEST);
        let worth = |lobes: &[(usize, f64)]| lobes.iter().map(|lobe| lobe.1).sum::<f64>();
        let best = ways.into_iter().max_by(|(_, a), (_, b)| worth(a).total_cmp(&worth(b)));
        let Some((way, worths)) = best else { return };
        let worths: BTreeMap<usize, f64> = worths.into_iter().collect();
        let among: Vec<usize> = worths.keys().copied().collect();
        let lobes = nearest(spots, &among, |s| 1.0 - worths[&s]);
        free.retain(|s| !lobes.contains(s));
        groups.push(Group { spots: lobes, path: Some(Path::along(spots.part, way)) });
    }
}

/// Ways whose light goes where a lobe is, and what that is worth: its power, less where it is not met.
fn nearby(spots: &Spots<'_>, film: &Film, s: usize) -> Vec<(Way, f64)> {
    /// Errors of two facets add up.
    const NEAR: f64 = 2.0 * EDGE;
    let (incident, [x, y, _]) = spots.directions(s);
    let Spot { scan, lobe, .. } = spots.all[s];
    let worth = |(way, [u, v], _): (Way, [f64; 2], f64)| {
        let apart = (u - x).hypot(v - y) / NEAR;
        let can = Path::along(spots.part, way).lets_through(lobe.power, spots.incidents[scan]);
        (apart < 1.0 && can).then_some((way, lobe.power * (1.0 - apart * apart)))
    };
    film.ways(incident).into_iter().filter_map(worth).collect()
}

/// Free lobes of other scans that are where a track foresees them: maps need not be exact.
fn claimed(spots: &Spots<'_>, group: &mut Group, free: &[usize]) -> Vec<usize> {
    let track = group.track(spots);
    nearest(spots, free, |s| match track.has(spots.all[s].scan) {
        true => f64::INFINITY,
        false => track.surprise(spots.incidents, &spots.all[s]),
    })
}

/// Of each scan the lobe that is least apart, if that is less than 1.
fn nearest(spots: &Spots<'_>, among: &[usize], apart: impl Fn(usize) -> f64) -> Vec<usize> {
    let mut nearest: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
    for (apart, s) in among.iter().map(|&s| (apart(s), s)).filter(|n| n.0 < 1.0) {
        let best = nearest.entry(spots.all[s].scan).or_insert((apart, s));
        if apart < best.0 {
            *best = (apart, s);
        }
    }
    nearest.into_values().map(|n| n.1).collect()
}

/// Groups of which one foresees where all lobes of the other are, made one.
fn joined(spots: &Spots<'_>, mut groups: Vec<Group>, progress: &Progress) -> Result<Vec<Group>, Stopped> {
    /// A group of fewer scans foresees nothing.
    const FEWEST: usize = 4;
    groups.sort_by_key(|group| std::cmp::Reverse(group.spots.len()));
    let mut first = 0;
    while first < groups.len() && groups[first].spots.len() >= FEWEST {
        progress.go_on()?;
        let track = groups[first].track(spots);
        let foreseen = |&s: &usize| {
            !track.has(spots.all[s].scan) && track.surprise(spots.incidents, &spots.all[s]) < 1.0
        };
        match (first + 1..groups.len()).find(|&other| groups[other].spots.iter().all(foreseen)) {
            Some(other) => {
                let more = groups.swap_remove(other).spots;
                groups[first].extend(more);
            }
            None => first += 1,
        }
    }
    Ok(groups)
}

/// Those of the given spots that are one lobe; no track has two of one scan.
fn linked(spots: &Spots<'_>, among: &[usize]) -> Vec<Group> {
    let mut track: Vec<usize> = (0..spots.all.len()).collect();
    let mut members: Vec<Vec<usize>> = track.iter().map(|&s| vec![s]).collect();
    for (_, one, other) in pairs(spots.incidents, &spots.all, among) {
        let (a, b) = (track[one], track[other]);
        let share_a_scan =
            || members[a].iter().any(|&s| members[b].iter().any(|&o| spots.all[o].scan == spots.all[s].scan));
        if a == b || share_a_scan() {
            continue;
        }
        for s in std::mem::take(&mut members[b]) {
            track[s] = a;
            members[a].push(s);
        }
    }
    let groups = among.iter().map(|&s| std::mem::take(&mut members[s])).filter(|group| !group.is_empty());
    groups.map(Group::new).collect()
}

/// How badly two spots match, and which they are; best first.
fn pairs(incidents: &[Ray], spots: &[Spot], among: &[usize]) -> Vec<(f64, usize, usize)> {
    let mut near = vec![Vec::new(); incidents.len()];
    for (k, near) in near.iter_mut().enumerate() {
        let mut others: Vec<(f64, usize)> = (0..incidents.len())
            .filter(|&l| l != k)
            .map(|l| (lambert::distance(incidents[k], incidents[l]), l))
            .collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0));
        others.truncate(N_NEIGHBOURS);
        *near = others;
    }
    let mut pairs = Vec::new();
    for &s in among {
        let one = &spots[s];
        for &(apart, scan) in &near[one.scan] {
            for &o in among.iter().filter(|&&o| spots[o].scan == scan) {
                let other = &spots[o];
                let [dx, dy] = [0, 1].map(|d| one.deviation[d] - other.deviation[d]);
                let moved = dx.hypot(dy);
                let ratio = (one.lobe.power / other.lobe.power).ln().abs();
                if moved < 0.06 + 0.6 * apart && ratio < 1.6 {
                    pairs.push((moved / (0.06 + apart) + 0.2 * ratio, s, o));
                }
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    pairs
}
