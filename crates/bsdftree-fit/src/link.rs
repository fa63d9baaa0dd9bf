//! Which lobes of scans are one: lobes of all scans → groups, each of which becomes a track.
//!
//! Lobes that one map of `bsdftree::peaks` describes are one; of the others, those of neighbouring scans that deviate alike from where
//! light goes straight or is mirrored, and have about the same power; and groups are joined if one foresees where the other is.

use std::collections::BTreeMap;

use bsdftree::Part;
use bsdftree::peaks::map_of;

use crate::lambert::{self, Ray};
use crate::lobes::Lobe;
use crate::path::on_side;
use crate::progress::{Progress, Stopped};
use crate::tracks::{EDGE, Track};

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

impl Spot {
    /// Lobes of all scans.
    pub fn all(incidents: &[Ray], lobes: &[Vec<Lobe>]) -> Vec<Spot> {
        let of_scan = |(scan, lobes): (usize, &Vec<Lobe>)| -> Vec<Spot> {
            let [mx, my] = lambert::point(incidents[scan]).map(f64::from);
            let spot = |(number, &lobe): (usize, &Lobe)| {
                let [x, y] = lambert::point(lobe.center).map(f64::from);
                Spot { scan, number, lobe, deviation: [x + mx, y + my] }
            };
            lobes.iter().enumerate().map(spot).collect()
        };
        lobes.iter().enumerate().flat_map(of_scan).collect()
    }
}

/// Numbers of spots that are one lobe, for each lobe.
pub(crate) fn followed(
    incidents: &[Ray],
    spots: &[Spot],
    line: bool,
    part: Part,
    progress: &Progress,
) -> Result<Vec<Vec<usize>>, Stopped> {
    let mut free: Vec<usize> = (0..spots.len()).collect();
    let mut tracks = if line { Vec::new() } else { mapped(incidents, spots, &mut free, part) };
    tracks.extend(linked(incidents, spots, &free));
    if line { Ok(tracks) } else { joined(incidents, spots, tracks, part, progress) }
}

/// Tracks that maps describe, as long as there are any; their lobes are free no more.
fn mapped(incidents: &[Ray], spots: &[Spot], free: &mut Vec<usize>, part: Part) -> Vec<Vec<usize>> {
    let least = incidents.len().div_ceil(RARITY).max(FEWEST);
    let directions = |s: usize| {
        let spot = &spots[s];
        (on_side(incidents[spot.scan], part.incident_side()), on_side(spot.lobe.center, part.exitant_side()))
    };
    let mut tracks = Vec::new();
    loop {
        let peaks: Vec<_> = free.iter().map(|&s| directions(s)).collect();
        let Some(map) = map_of(&peaks, EDGE, least) else { return tracks };
        let apart = |s: usize| {
            let (incident, exitant) = directions(s);
            let there = map.exitant(incident, part.exitant_side());
            there.map_or(f64::INFINITY, |[x, y, _]| (x - exitant[0]).hypot(y - exitant[1]) / EDGE)
        };
        let mut track = nearest(spots, free, apart);
        if track.len() < least {
            return tracks;
        }
        track.extend(claimed(incidents, spots, &track, free, part));
        free.retain(|s| !track.contains(s));
        tracks.push(track);
    }
}

/// Free lobes of other scans that are where a track foresees them: maps need not be exact.
fn claimed(incidents: &[Ray], spots: &[Spot], track: &[usize], free: &[usize], part: Part) -> Vec<usize> {
    let group: Vec<Spot> = track.iter().map(|&s| spots[s]).collect();
    let track = Track::beside(incidents, spots, &group, false, part);
    nearest(spots, free, |s| match track.has(spots[s].scan) {
        true => f64::INFINITY,
        false => track.surprise(incidents, &spots[s]),
    })
}

/// Of each scan the lobe that is least apart, if that is less than 1.
fn nearest(spots: &[Spot], among: &[usize], apart: impl Fn(usize) -> f64) -> Vec<usize> {
    let mut nearest: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
    for (apart, s) in among.iter().map(|&s| (apart(s), s)).filter(|n| n.0 < 1.0) {
        let best = nearest.entry(spots[s].scan).or_insert((apart, s));
        if apart < best.0 {
            *best = (apart, s);
        }
    }
    nearest.into_values().map(|n| n.1).collect()
}

/// Tracks of which one foresees where all lobes of the other are, made one.
fn joined(
    incidents: &[Ray],
    spots: &[Spot],
    mut tracks: Vec<Vec<usize>>,
    part: Part,
    progress: &Progress,
) -> Result<Vec<Vec<usize>>, Stopped> {
    /// A track of fewer scans foresees nothing.
    const FEWEST: usize = 4;
    tracks.sort_by_key(|track| std::cmp::Reverse(track.len()));
    let mut first = 0;
    while first < tracks.len() && tracks[first].len() >= FEWEST {
        progress.go_on()?;
        let group: Vec<Spot> = tracks[first].iter().map(|&s| spots[s]).collect();
        let track = Track::beside(incidents, spots, &group, false, part);
        let foreseen = |&s: &usize| !track.has(spots[s].scan) && track.surprise(incidents, &spots[s]) < 1.0;
        match (first + 1..tracks.len()).find(|&other| tracks[other].iter().all(foreseen)) {
            Some(other) => {
                let more = tracks.swap_remove(other);
                tracks[first].extend(more);
            }
            None => first += 1,
        }
    }
    Ok(tracks)
}

/// Those of the given spots that are one lobe; no track has two of one scan.
fn linked(incidents: &[Ray], spots: &[Spot], among: &[usize]) -> Vec<Vec<usize>> {
    let mut track: Vec<usize> = (0..spots.len()).collect();
    let mut members: Vec<Vec<usize>> = track.iter().map(|&s| vec![s]).collect();
    for (_, one, other) in pairs(incidents, spots, among) {
        let (a, b) = (track[one], track[other]);
        let share_a_scan =
            || members[a].iter().any(|&s| members[b].iter().any(|&o| spots[o].scan == spots[s].scan));
        if a == b || share_a_scan() {
            continue;
        }
        for s in std::mem::take(&mut members[b]) {
            track[s] = a;
            members[a].push(s);
        }
    }
    among.iter().map(|&s| std::mem::take(&mut members[s])).filter(|track| !track.is_empty()).collect()
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
