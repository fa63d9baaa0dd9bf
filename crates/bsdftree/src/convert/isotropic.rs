//! Functions of polar angles and relative azimuth: what rank-3 trees hold, and what patches know of it.
//!
//! In: a rank-3 tree, or a matrix. Out: the other. Between them is the mean of the function over rings of incident and of exitant
//! directions and narrow bins of relative azimuth. Overlaps with rings and cells are exact; how relative azimuths spread when
//! both directions are anywhere in their patches (a trapezoid) is integrated exactly over each bin, the function taken as
//! constant in it. That is the only approximation, and keeps all light, since the trapezoids of all exitant patches add up to 1.

use std::f64::consts::TAU;

use super::grow::{Branch, Grower, squared_radii};
use super::overlap::Overlap;
use crate::klems::{Basis, MAX_PATCHES, Matrix, Ring};
use crate::tree::{Rank, Tree, TreeError, child_cell};

/// Bins of relative azimuth: all borders of patches of the known bases and their subdivisions are borders or middles of bins.
const N_BINS: u32 = 960;

/// Means over incident ring, exitant ring and bin of relative azimuth.
pub(super) struct Isotropic {
    /// A bin j is centred on j/N of a turn. Patches of this basis are (exitant ring, bin).
    polar: Basis,
    /// Squared radii of the incident rings.
    incident: Vec<[f64; 2]>,
    n_bins: usize,
    /// Incident ring slowest.
    means: Vec<f64>,
}

impl Isotropic {
    fn new(incident: &Basis, exitant: &Basis) -> Isotropic {
        let n_rings = exitant.rings().len() as u32;
        let n_bins = N_BINS.min(MAX_PATCHES as u32 / n_rings);
        let rings: Vec<Ring> = (0..exitant.rings().len())
            .map(|ring| Ring {
                bounds_deg: exitant.radii(ring).map(|r| r.asin().to_degrees()),
                n_phi: n_bins,
            })
            .collect();
        let polar = Basis::new("polar", rings).expect("rings of a basis, few enough");
        let incident: Vec<_> =
            (0..incident.rings().len()).map(|ring| incident.radii(ring).map(|r| r * r)).collect();
        let means = vec![0.0; incident.len() * polar.n_patches()];
        Isotropic { polar, incident, n_bins: n_bins as usize, means }
    }

    /// Of a rank-3 tree.
    pub fn of_tree(tree: &Tree, basis: &Basis) -> Isotropic {
        let mut it = Isotropic::new(basis, basis);
        let overlap = Overlap::new(&it.polar, tree.arena().log2_res());
        let n = it.polar.n_patches();
        for leaf in tree.leaves().filter(|leaf| leaf.value > 0.0) {
            let [lower, upper] = squared_radii(leaf.level, leaf.cell[0]);
            let (shares, factor) = overlap.row(leaf.level, [leaf.cell[1], leaf.cell[2]]);
            for (ring, &[inner, outer]) in it.incident.iter().enumerate() {
                let radial = (outer.min(upper) - inner.max(lower)) / (outer - inner);
                if radial > 0.0 {
                    let light = f64::from(leaf.value) * radial * factor;
                    let row = &mut it.means[ring * n..][..n];
                    shares.iter().for_each(|&(bin, area)| row[bin as usize] += light * area);
                }
            }
        }
        for row in it.means.chunks_exact_mut(n) {
            row.iter_mut().zip(overlap.areas()).for_each(|(sum, area)| *sum /= area);
        }
        it
    }

    /// Of a matrix, averaged over all turns about the normal.
    pub fn of_matrix(matrix: &Matrix) -> Isotropic {
        let (incident, exitant) = (matrix.incident(), matrix.exitant());
        let mut it = Isotropic::new(incident, exitant);
        let n_exitant = exitant.n_patches();
        for i in 0..incident.n_patches() {
            let ring = incident.ring_of(i);
            for o in 0..n_exitant {
                let value = f64::from(matrix.values()[i * n_exitant + o]);
                if value > 0.0 {
                    let across = exitant.ring_of(o);
                    let pairs = f64::from(incident.rings()[ring].n_phi * exitant.rings()[across].n_phi);
                    let first = (ring * exitant.rings().len() + across) * it.n_bins;
                    let bins = &mut it.means[first..first + it.n_bins];
                    let light = value * bins.len() as f64 / pairs;
                    each_bin(bins.len(), incident.azimuths(i), exitant.azimuths(o), |bin, part| {
                        bins[bin] += light * part;
                    });
                }
            }
        }
        it
    }

    /// Values over incident and exitant patches of the basis whose rings these are.
    pub fn matrix(&self, basis: &Basis) -> Vec<f64> {
        let n = basis.n_patches();
        let mut values = vec![0.0; n * n];
        for (k, value) in values.iter_mut().enumerate() {
            let (i, o) = (k / n, k % n);
            let first = (basis.ring_of(i) * basis.rings().len() + basis.ring_of(o)) * self.n_bins;
            let bins = &self.means[first..first + self.n_bins];
            each_bin(bins.len(), basis.azimuths(i), basis.azimuths(o), |bin, part| {
                *value += bins[bin] * part
            });
        }
        values
    }

    /// A tree of 2^log2_res cells per axis.
    pub fn tree(&self, log2_res: u32, tolerance: f64) -> Result<Tree, TreeError> {
        let overlap = Overlap::new(&self.polar, log2_res);
        let n = self.polar.n_patches();
        let light: f64 = self
            .incident
            .iter()
            .zip(self.means.chunks_exact(n))
            .map(|([inner, outer], row)| (outer - inner) * dot(row, overlap.areas()))
            .sum();
        let mut growth = Growth {
            it: self,
            overlap: &overlap,
            log2_res,
            grower: Grower::new(Rank::Three, tolerance, light),
        };
        let root = growth.grow(0, [0; 3])?;
        Ok(growth.grower.finish(root))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Tells `f` of each bin of relative azimuth, and how likely it is for directions anywhere in two ranges of azimuths.
fn each_bin(n_bins: usize, incident: [f64; 2], exitant: [f64; 2], mut f: impl FnMut(usize, f64)) {
    let width = |[a, b]: [f64; 2]| b - a;
    let middle = |[a, b]: [f64; 2]| 0.5 * (a + b);
    let (wide, narrow) = (width(incident).max(width(exitant)), width(incident).min(width(exitant)));
    if wide > TAU - 1e-9 {
        (0..n_bins).for_each(|bin| f(bin, 1.0 / n_bins as f64));
        return;
    }
    let centre = middle(exitant) - middle(incident);
    // Where the trapezoid begins to rise, and is full.
    let (foot, top) = (0.5 * (wide + narrow), 0.5 * (wide - narrow));
    // The part of it below x.
    let below = |x: f64| {
        let tail = |d: f64| d * d / (2.0 * wide * narrow);
        if x <= -foot {
            0.0
        } else if x < -top {
            tail(x + foot)
        } else if x <= top {
            0.5 + x / wide
        } else if x < foot {
            1.0 - tail(foot - x)
        } else {
            1.0
        }
    };
    let bin_width = TAU / n_bins as f64;
    let first = ((centre - foot) / bin_width - 0.5).floor() as i64;
    let last = ((centre + foot) / bin_width + 0.5).ceil() as i64;
    for bin in first..=last {
        let x = bin as f64 * bin_width - centre;
        let part = below(x + 0.5 * bin_width) - below(x - 0.5 * bin_width);
        if part > 0.0 {
            f(bin.rem_euclid(n_bins as i64) as usize, part);
        }
    }
}

/// A tree being grown from means.
struct Growth<'a> {
    it: &'a Isotropic,
    overlap: &'a Overlap,
    log2_res: u32,
    grower: Grower,
}

impl Growth<'_> {
    fn grow(&mut self, level: u32, cell: [u32; 3]) -> Result<Branch, TreeError> {
        let radii = squared_radii(level, cell[0]);
        if radii[1] <= 0.0 {
            return Ok(self.grower.unread());
        }
        let shared = |[inner, outer]: [f64; 2]| outer.min(radii[1]) - inner.max(radii[0]);
        let n = self.it.polar.n_patches();
        let rows: Vec<(f64, &[f64])> = self
            .it
            .incident
            .iter()
            .zip(self.it.means.chunks_exact(n))
            .filter_map(|(&ring, row)| {
                (shared(ring) > 1e-14).then_some((shared(ring) / (radii[1] - radii[0]), row))
            })
            .collect();
        let (shares, factor) = self.overlap.row(level, [cell[1], cell[2]]);
        let whole = factor * 4f64.powi(level as i32);
        let mean: f64 = rows
            .iter()
            .map(|(weight, row)| {
                weight * shares.iter().map(|&(bin, area)| row[bin as usize] * area).sum::<f64>()
            })
            .sum::<f64>()
            * whole;
        let mut values = rows.iter().flat_map(|(_, row)| shares.iter().map(|&(bin, _)| row[bin as usize]));
        let first = values.next();
        // A layer at level 0 is half of it unread.
        if level > 0 && (level == self.log2_res || values.all(|v| Some(v) == first)) {
            return Ok(self.grower.leaf(mean, level, cell[0]));
        }
        let mut children = [self.grower.unread(); 8];
        for (k, child) in children.iter_mut().enumerate() {
            *child = self.grow(level + 1, child_cell(cell, k))?;
        }
        self.grower.join(&children)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_azimuths_add_up_over_all_patches() {
        let basis = Basis::full();
        for incident in [0, 3, 30, 100, 140] {
            for ring in 0..basis.rings().len() {
                let mut bins = vec![0.0; 960];
                for exitant in basis.patches_of(ring) {
                    let mut sum = 0.0;
                    each_bin(960, basis.azimuths(incident), basis.azimuths(exitant), |bin, part| {
                        bins[bin] += part;
                        sum += part;
                    });
                    assert!((sum - 1.0).abs() < 1e-12);
                }
                let even = basis.patches_of(ring).len() as f64 / 960.0;
                assert!(bins.iter().all(|b| (b - even).abs() < 1e-12));
            }
        }
        assert_eq!(squared_radii(1, 1)[1], 0.0);
    }
}
