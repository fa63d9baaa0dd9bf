//! Light that sites send to each other.
//!
//! In: sites, and which of them light reaches. Out: (I − K)⁻¹, where K(s, s′) is the light sent out from s′ because of unit light
//! sent out from s; so that light sent out at first, times the matrix, is all light ever sent out.

use rayon::prelude::*;

use super::deposit::Walker;
use super::walk::{Lobes, walk};
use crate::bvh::Ray;
use crate::random::{N_REPLICATES, Stratified};
use crate::scatter::{Spectrum, lambertian_direction};

/// Keeps the random numbers of walks between sites apart from those of paths of the same seed.
const EXCHANGE: u64 = 0x65_7863_6861;

/// Least part of the light of a site that is taken to be lost at last: light that walks have not seen leave a cavity.
const LEAST_LOSS: f64 = 1e-6;

/// Light sent from site to site, one replicate.
pub(crate) struct Exchange<S> {
    /// The sites that light reaches, in order; rows and columns are these.
    pub active: Vec<usize>,
    rows: Vec<Vec<S>>,
}

impl<S: Spectrum> Exchange<S> {
    /// `walks` walks from each site that is lit, or gets light from one that is.
    pub fn measure(walker: &Walker<S>, lit: &[bool], walks: u64, replicate: usize) -> Exchange<S> {
        let n = walker.sites.len();
        let mut rows: Vec<Option<Vec<S>>> = vec![None; n];
        let mut next: Vec<usize> = (0..n).filter(|&s| lit[s]).collect();
        while !next.is_empty() {
            let found: Vec<Vec<S>> =
                next.par_iter().map(|&site| row(walker, site, walks, replicate)).collect();
            let mut reached = vec![false; n];
            for (&site, row) in next.iter().zip(found) {
                row.iter().zip(&mut reached).for_each(|(k, r)| *r |= *k != S::BLACK);
                rows[site] = Some(row);
            }
            next = (0..n).filter(|&s| reached[s] && rows[s].is_none()).collect();
        }
        let active: Vec<usize> = (0..n).filter(|&s| rows[s].is_some()).collect();
        let rows = active.iter().filter_map(|&s| rows[s].take()).collect();
        Exchange { active, rows }
    }

    /// (I − K)⁻¹ of a channel, row by row.
    pub fn resolvent(&self, channel: usize) -> Vec<f64> {
        let n = self.active.len();
        let mut matrix = vec![0.0; n * n];
        for (i, row) in self.rows.iter().enumerate() {
            let k: Vec<f64> = self.active.iter().map(|&s| row[s].channel(channel)).collect();
            let sum: f64 = k.iter().sum();
            let scale = ((1.0 - LEAST_LOSS) / sum).min(1.0);
            for (j, k) in k.into_iter().enumerate() {
                matrix[i * n + j] = f64::from(u8::from(i == j)) - scale * k;
            }
        }
        invert(&mut matrix, n);
        matrix
    }
}

/// Light sent out again at each site because of unit light sent out from `site`.
fn row<S: Spectrum>(walker: &Walker<S>, site: usize, walks: u64, replicate: usize) -> Vec<S> {
    let sites = walker.sites;
    let medium = sites.medium(site);
    let mut sums = vec![S::BLACK; sites.len()];
    let (seed, stream) = (walker.seed ^ EXCHANGE, site as u64);
    let mut stratified = Stratified::new(seed, stream);
    for k in 0..walks {
        let mut start = stratified.start(seed, stream, k * N_REPLICATES as u64 + replicate as u64);
        let point = sites.point(site, start.origin[0]);
        let direction = lambertian_direction(point.normal, start.incident);
        let ray = Ray { origin: point.position, direction, from: Some(point.part) };
        walk(walker.scene, walker.tile, Lobes::Specular, (ray, medium), &mut start.random, |meeting| {
            for (normal, albedo) in [meeting.facing, -meeting.facing].into_iter().zip(meeting.albedo) {
                if albedo != S::BLACK {
                    let to = sites.find(meeting.hit.position, normal);
                    sums[to] = sums[to] + meeting.arrived * albedo;
                }
            }
        });
    }
    sums.into_iter().map(|sum| sum / walks as f64).collect()
}

/// Inverts I − K in place by Gauss and Jordan; no row of K sums to 1, so that no pivot has to be looked for.
fn invert(matrix: &mut [f64], n: usize) {
    for k in 0..n {
        let inverse = 1.0 / matrix[k * n + k];
        matrix[k * n + k] = 1.0;
        matrix[k * n..(k + 1) * n].iter_mut().for_each(|v| *v *= inverse);
        let pivot: Vec<f64> = matrix[k * n..(k + 1) * n].to_vec();
        matrix.par_chunks_mut(n).enumerate().filter(|(i, _)| *i != k).for_each(|(_, row)| {
            let factor = row[k];
            if factor != 0.0 {
                row[k] = 0.0;
                row.iter_mut().zip(&pivot).for_each(|(v, p)| *v -= factor * p);
            }
        });
    }
}

#[cfg(test)]
impl<S: Spectrum> Exchange<S> {
    /// Light sent out again because of unit light from a site.
    pub fn sent_again(&self, site: usize, channel: usize) -> f64 {
        let row = self.active.iter().position(|&s| s == site).expect("an active site");
        self.rows[row].iter().map(|v| v.channel(channel)).sum()
    }
}
