//! Lobes found in one scan.
//!
//! A lobe is what lies above 1.5 times the median of a scan and drains to one maximum: two maxima are one lobe unless the saddle between
//! them is well below both (a watershed with prominence).

use crate::gridded::Gridded;
use crate::lambert::{self, Ray};
use crate::raster::Raster;

/// Two maxima are two lobes if the saddle lies below both by this factor.
const PROMINENCE: f32 = 1.6;

/// Lobes with a smaller share of what lies above the base are left to the base.
const LEAST_SHARE: f64 = 0.01;

/// A pixel of no lobe.
pub(crate) const NONE: u8 = u8::MAX;

/// One lobe of one scan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lobe {
    /// Of its power.
    pub center: Ray,
    pub power: f64,
}

/// Labels of pixels and the lobes that they are of.
pub(crate) fn lobes_of(scan: &Gridded, channel: usize, level: f32, faintest: f64) -> (Vec<u8>, Vec<Lobe>) {
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
    let lobe = |&b: &usize| {
        let [power, sum @ ..] = sums[b];
        let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt().max(1e-30);
        Lobe { center: sum.map(|c| (c / length) as f32), power }
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
