//! Lobes of neighbouring scans that are alike → tracks.

use crate::lambert::{self, Ray};
use crate::lobes::Lobe;

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

/// Those of the given spots that are one lobe; no track has two of one scan.
pub(crate) fn linked(incidents: &[Ray], spots: &[Spot], among: &[usize]) -> Vec<Vec<usize>> {
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
