//! Lobes found in each scan and followed from scan to scan.
//!
//! A lobe is what lies above 1.5 times the median of a scan and drains to one maximum: two maxima are one lobe unless the saddle between
//! them is well below both (a watershed with prominence). Lobes of neighbouring scans are one **track** if they deviate alike from where
//! light goes straight or is mirrored, and have about the same power. Between scans the deviation, the power and the shape of a track are
//! interpolated, each track for itself, so that two lobes that move differently, as those of a prismatic film do, do not blur.

use bsdftree::Part;
use bsdftree::direction::{Direction, Side, normalized};
use bsdftree::peaks::{Map, map_of};
use rayon::prelude::*;

use crate::gridded::Gridded;
use crate::incidence::{Blend, Incidence, Line, Plane, Weights, lambert_radius};
use crate::lambert::{self, Ray};
use crate::progress::{Progress, Stopped};
use crate::raster::Raster;

/// Two maxima are two lobes if the saddle lies below both by this factor.
const PROMINENCE: f32 = 1.6;

/// Lobes with a smaller share of what lies above the base are left to the base.
const LEAST_SHARE: f64 = 0.01;

/// Lobes with less power than this part of the mean total are noise.
const FAINT: f64 = 5e-3;

/// Neighbours of a scan among which its lobes are looked for.
const N_NEIGHBOURS: usize = 8;

/// A pixel of no lobe.
pub(crate) const NONE: u8 = u8::MAX;

/// One lobe of one scan.
#[derive(Clone, Debug)]
struct Lobe {
    /// Of the centre of its power, from the mirror direction \[disk\].
    deviation: [f64; 2],
    power: f64,
}

/// A lobe over all scans that have it.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    /// Scans that have it, with deviation and power there.
    members: Vec<Member>,
    incidence: Incidence,
    /// What sends the light there, if one thing does.
    map: Option<Map>,
}

/// A scan, and the deviation and the power of the lobe there.
type Member = (usize, [f64; 2], f64);

/// Lobes are known to this distance in the disk when a map is sought.
const EDGE: f64 = 0.05;

/// The lobes of all scans.
#[derive(Clone, Debug)]
pub(crate) struct Tracks {
    pub tracks: Vec<Track>,
    /// For each scan the number of the track that a pixel belongs to.
    pub labels: Vec<Vec<u8>>,
    part: Part,
}

/// A track at one incident direction.
pub(crate) struct Followed {
    pub power: f64,
    pub center: Ray,
    /// Scans with their weights, and the centre there.
    pub scans: Vec<(usize, f64, Ray)>,
}

fn mirror_point(incident: Ray) -> [f64; 2] {
    let [x, y] = lambert::point(incident);
    [f64::from(-x), f64::from(-y)]
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
        let numbers = linked(scans, &lobes);
        let n_tracks = numbers.iter().flatten().max().map_or(0, |&n| n + 1);
        // The strongest tracks; others stay in the base.
        let mut strength = vec![0.0; n_tracks];
        for (numbers, lobes) in numbers.iter().zip(&lobes) {
            numbers.iter().zip(lobes).for_each(|(&t, lobe)| strength[t] += lobe.power);
        }
        let mut order: Vec<usize> = (0..n_tracks).collect();
        order.sort_by(|&a, &b| strength[b].total_cmp(&strength[a]));
        order.truncate(usize::from(NONE));
        let rank_of = |t: usize| order.iter().position(|&other| other == t);
        for (labels, numbers) in labels.iter_mut().zip(&numbers) {
            let renumbered: Vec<u8> = numbers.iter().map(|&t| rank_of(t).map_or(NONE, |r| r as u8)).collect();
            labels
                .iter_mut()
                .filter(|label| **label != NONE)
                .for_each(|label| *label = renumbered[usize::from(*label)]);
        }
        let incidents: Vec<Ray> = scans.iter().map(|s| s.incident).collect();
        let track = |&t: &usize| {
            let member = |k: usize| {
                let j = numbers[k].iter().position(|&number| number == t)?;
                Some((k, lobes[k][j].deviation, lobes[k][j].power))
            };
            let members: Vec<_> = (0..scans.len()).filter_map(member).collect();
            let incidence = incidence_of(&incidents, &members, line);
            let own: Vec<Ray> = members.iter().map(|m| incidents[m.0]).collect();
            let map = map_of_members(part, &own, &members);
            Track { members, incidence: incidence.expect("a track has members"), map }
        };
        Ok(Some(Tracks { tracks: order.iter().map(track).collect(), labels, part }))
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
            let (own, map) = match without {
                None => (track.incidence.weights(incident).0, track.map),
                Some(group) => {
                    let kept: Vec<Member> =
                        track.members.iter().copied().filter(|m| groups[m.0] != group).collect();
                    let incidents: Vec<Ray> = kept.iter().map(|m| scans[m.0]).collect();
                    let map = track.map.and_then(|_| map_of_members(self.part, &incidents, &kept));
                    (incidence_of(scans, &kept, line)?.weights(incident).0, map)
                }
            };
            let deviation = |k: usize| track.members.iter().find(|m| m.0 == k).expect("a member").1;
            // What the map foresees; where it sends nothing, there is no lobe.
            let foreseen = |i: Ray| match map {
                Some(map) => {
                    let [u, v] = lambert::point(mapped(map, self.part, i)?).map(f64::from);
                    let [x, y] = mirror_point(i);
                    Some([u - x, v - y])
                }
                None => Some([0.0; 2]),
            };
            let here = foreseen(incident)?;
            let power: f64 = match map {
                Some(_) => own.iter().map(|&(k, w)| w * track.power_in(k)).sum(),
                None => weights.iter().map(|&(k, w)| w * track.power_in(k)).sum(),
            };
            if power <= 0.0 {
                return None;
            }
            let place = |i: Ray, [u, v]: [f64; 2]| {
                let [x, y] = mirror_point(i);
                lambert::direction([(x + u) as f32, (y + v) as f32])
            };
            // Beside the map, how far scans are from it.
            let mut center = here;
            for &(k, w) in &own {
                let Some(there) = foreseen(scans[k]) else { continue };
                (0..2).for_each(|d| center[d] += w * (deviation(k)[d] - there[d]));
            }
            let center = place(incident, center);
            let scans = own.iter().map(|&(k, w)| (k, w, place(scans[k], deviation(k)))).collect();
            Some((number as u8, Followed { power, center, scans }))
        };
        self.tracks.iter().enumerate().filter_map(follow).collect()
    }

    /// The power of all lobes in a scan.
    pub fn power_in(&self, scan: usize) -> f64 {
        self.tracks.iter().map(|track| track.power_in(scan)).sum()
    }
}

/// The map that a lobe follows through scans.
fn map_of_members(part: Part, incidents: &[Ray], members: &[Member]) -> Option<Map> {
    let peak = |(&i, member): (&Ray, &Member)| {
        let [x, y] = mirror_point(i);
        let center = lambert::direction([(x + member.1[0]) as f32, (y + member.1[1]) as f32]);
        (on_side(i, part.incident_side()), on_side(center, part.exitant_side()))
    };
    let peaks: Vec<(Direction, Direction)> = incidents.iter().zip(members).map(peak).collect();
    map_of(&peaks, EDGE)
}

fn on_side([x, y, z]: Ray, side: Side) -> Direction {
    let d = [f64::from(x), f64::from(y), f64::from(z) * side.sign()];
    normalized(d).unwrap_or(d)
}

/// Where a map sends light, on the upper hemisphere.
fn mapped(map: Map, part: Part, incident: Ray) -> Option<Ray> {
    map.exitant(on_side(incident, part.incident_side()), part.exitant_side()).map(lambert::upper)
}

impl Track {
    /// Its power in a scan; 0 if it is not there.
    pub fn power_in(&self, scan: usize) -> f64 {
        self.members.iter().find(|m| m.0 == scan).map_or(0.0, |m| m.2)
    }
}

fn incidence_of(incidents: &[Ray], members: &[Member], line: bool) -> Option<Incidence> {
    if members.is_empty() {
        return None;
    }
    let numbers: Vec<usize> = members.iter().map(|m| m.0).collect();
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

/// Labels of pixels and the lobes that they are of.
fn lobes_of(scan: &Gridded, channel: usize, level: f32, faintest: f64) -> (Vec<u8>, Vec<Lobe>) {
    let n = scan.rasters[channel].n();
    let smooth = smoothed(&scan.rasters[channel]);
    let directions: Vec<Ray> = Raster::directions(n).collect();
    let mut order: Vec<u32> = (0..(n * n) as u32)
        .filter(|&k| directions[k as usize][2] > 0.0 && smooth[k as usize] > level)
        .collect();
    order.sort_unstable_by(|&a, &b| smooth[b as usize].total_cmp(&smooth[a as usize]).then(a.cmp(&b)));
    // Pixels from bright to dark; basins that meet are one unless both are well above the place where they meet.
    let mut basin = vec![u32::MAX; n * n];
    let mut parent: Vec<u32> = Vec::new();
    let mut top: Vec<f32> = Vec::new();
    fn root(parent: &mut [u32], mut b: u32) -> u32 {
        while parent[b as usize] != b {
            parent[b as usize] = parent[parent[b as usize] as usize];
            b = parent[b as usize];
        }
        b
    }
    for &k in &order {
        let (x, y) = (k as usize % n, k as usize / n);
        let mut near: Vec<u32> = Vec::with_capacity(8);
        for (dx, dy) in [(-1i32, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1), (-1, 1), (1, -1)] {
            let (u, v) = (x as i32 + dx, y as i32 + dy);
            if u >= 0 && v >= 0 && (u as usize) < n && (v as usize) < n {
                let b = basin[v as usize * n + u as usize];
                if b != u32::MAX {
                    near.push(root(&mut parent, b));
                }
            }
        }
        let here = smooth[k as usize];
        let Some(&highest) = near.iter().max_by(|&&a, &&b| top[a as usize].total_cmp(&top[b as usize]))
        else {
            basin[k as usize] = parent.len() as u32;
            parent.push(parent.len() as u32);
            top.push(here);
            continue;
        };
        basin[k as usize] = highest;
        for b in near.into_iter().filter(|&b| b != highest) {
            if top[b as usize] < PROMINENCE * (here - level) + level {
                parent[b as usize] = highest;
            }
        }
    }
    let n_basins = parent.len();
    let pixel = lambert::SOLID_ANGLE * (2.0 * f64::from(crate::raster::EXTENT) / n as f64).powi(2);
    // Power, and the sum of directions by the square of what lies above the base: where the lobe is brightest, not where the horizon cuts it.
    let mut sums = vec![[0.0f64; 4]; n_basins];
    for &k in &order {
        let b = root(&mut parent, basin[k as usize]) as usize;
        let rest = f64::from((scan.rasters[channel].values()[k as usize] - level).max(0.0));
        let power = rest * f64::from(directions[k as usize][2]) * pixel;
        sums[b][0] += power;
        (0..3).for_each(|d| sums[b][d + 1] += rest * rest * f64::from(directions[k as usize][d]));
    }
    let all: f64 = sums.iter().map(|s| s[0]).sum();
    let mut kept: Vec<usize> =
        (0..n_basins).filter(|&b| sums[b][0] > (LEAST_SHARE * all).max(faintest)).collect();
    kept.sort_by(|&a, &b| sums[b][0].total_cmp(&sums[a][0]));
    kept.truncate(usize::from(NONE));
    let [mx, my] = mirror_point(scan.incident);
    let lobe = |&b: &usize| {
        let [power, sum @ ..] = sums[b];
        let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt().max(1e-30);
        let [x, y] = lambert::point(sum.map(|c| (c / length) as f32)).map(f64::from);
        Lobe { deviation: [x - mx, y - my], power }
    };
    let lobes = kept.iter().map(lobe).collect();
    let mut labels = vec![NONE; n * n];
    for &k in &order {
        let b = root(&mut parent, basin[k as usize]) as usize;
        if let Some(j) = kept.iter().position(|&other| other == b) {
            labels[k as usize] = j as u8;
        }
    }
    (labels, lobes)
}

/// The mean over 3 × 3 pixels.
fn smoothed(raster: &Raster) -> Vec<f32> {
    let n = raster.n();
    let across = |values: &[f32], step: usize, at: &dyn Fn(usize) -> usize| -> Vec<f32> {
        (0..n * n)
            .map(|k| match at(k) {
                0 => (values[k] + values[k + step]) / 2.0,
                x if x == n - 1 => (values[k - step] + values[k]) / 2.0,
                _ => (values[k - step] + values[k] + values[k + step]) / 3.0,
            })
            .collect()
    };
    let rows = across(raster.values(), 1, &|k| k % n);
    across(&rows, n, &|k| k / n)
}

/// The number of the track of each lobe of each scan.
fn linked(scans: &[Gridded], lobes: &[Vec<Lobe>]) -> Vec<Vec<usize>> {
    let points: Vec<[f64; 2]> = scans.iter().map(|s| lambert::point(s.incident).map(f64::from)).collect();
    let gap = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    // How badly two lobes match, and which they are: scan and number there.
    type Match = (f64, (usize, usize), (usize, usize));
    let mut pairs: Vec<Match> = Vec::new();
    for k in 0..scans.len() {
        let mut near: Vec<usize> = (0..scans.len()).filter(|&l| l != k).collect();
        near.sort_by(|&a, &b| gap(points[a], points[k]).total_cmp(&gap(points[b], points[k])));
        for &l in near.iter().take(N_NEIGHBOURS) {
            let apart = gap(points[k], points[l]);
            for (a, one) in lobes[k].iter().enumerate() {
                for (b, other) in lobes[l].iter().enumerate() {
                    let moved = gap(one.deviation, other.deviation);
                    let ratio = (one.power / other.power).ln().abs();
                    if moved < 0.06 + 0.6 * apart && ratio < 1.6 {
                        pairs.push((moved / (0.06 + apart) + 0.2 * ratio, (k, a), (l, b)));
                    }
                }
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let first: Vec<usize> = lobes
        .iter()
        .scan(0, |sum, l| {
            let here = *sum;
            *sum += l.len();
            Some(here)
        })
        .collect();
    let total = lobes.iter().map(Vec::len).sum::<usize>();
    // Which track, and which scans that has: no track has two lobes of one scan.
    let mut track: Vec<usize> = (0..total).collect();
    let mut members: Vec<Vec<(usize, usize)>> =
        lobes.iter().enumerate().flat_map(|(k, l)| (0..l.len()).map(move |j| vec![(k, j)])).collect();
    for (_, one, other) in pairs {
        let (a, b) = (track[first[one.0] + one.1], track[first[other.0] + other.1]);
        if a == b || members[a].iter().any(|m| members[b].iter().any(|o| o.0 == m.0)) {
            continue;
        }
        for (k, j) in std::mem::take(&mut members[b]) {
            track[first[k] + j] = a;
            members[a].push((k, j));
        }
    }
    let mut numbers: Vec<usize> = track.clone();
    numbers.sort_unstable();
    numbers.dedup();
    let number = |t: usize| numbers.binary_search(&t).expect("there");
    lobes
        .iter()
        .enumerate()
        .map(|(k, l)| (0..l.len()).map(|j| number(track[first[k] + j])).collect())
        .collect()
}
