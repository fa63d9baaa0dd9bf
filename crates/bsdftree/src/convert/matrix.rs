//! Trees and matrices onto the patches of an angle basis.
//!
//! A value of the result is the mean of the function over incident and exitant patch, by projected solid angle: what evenly diffuse
//! light from the one patch sends into the other. So the directional-hemispherical total of a patch is the mean of the
//! function's totals over it, and no light is lost. Source: what Radiance's bsdf2klems estimates from samples.

use std::sync::Arc;

use super::isotropic::Isotropic;
use super::overlap::Overlap;
use crate::bsdf::Scattering;
use crate::klems::{Basis, Matrix};
use crate::tree::{Rank, Tree};

/// A function over the patches of a basis; a matrix that has this basis is itself.
pub(super) fn matrix(function: &Scattering, basis: &Arc<Basis>) -> Arc<Matrix> {
    let values = match function {
        Scattering::Matrix(matrix) if has_basis(matrix, basis) => return Arc::clone(matrix),
        Scattering::Matrix(matrix) => from_matrix(matrix, basis),
        Scattering::Tree(tree) => match tree.rank() {
            Rank::Four => from_rank4(tree, basis),
            Rank::Three => Isotropic::of_tree(tree, basis).matrix(basis),
        },
    };
    let values = values.into_iter().map(|v| v as f32).collect();
    let matrix = Matrix::new(Arc::clone(basis), Arc::clone(basis), values);
    Arc::new(matrix.expect("means of numbers that are finite and not negative"))
}

fn has_basis(matrix: &Matrix, basis: &Arc<Basis>) -> bool {
    matrix.incident().rings() == basis.rings() && matrix.exitant().rings() == basis.rings()
}

fn from_rank4(tree: &Tree, basis: &Basis) -> Vec<f64> {
    let overlap = Overlap::new(basis, tree.arena().log2_res());
    let n = basis.n_patches();
    let mut sums = vec![0.0; n * n];
    for leaf in tree.leaves().filter(|leaf| leaf.value > 0.0) {
        let [a, b, c, d] = leaf.cell;
        let (incident, p) = overlap.row(leaf.level, [a, b]);
        let (exitant, q) = overlap.row(leaf.level, [c, d]);
        let light = f64::from(leaf.value) * p * q;
        for &(i, area) in incident {
            let row = &mut sums[i as usize * n..][..n];
            exitant.iter().for_each(|&(o, other)| row[o as usize] += light * area * other);
        }
    }
    let areas = overlap.areas();
    for (i, row) in sums.chunks_exact_mut(n).enumerate() {
        row.iter_mut().zip(areas).for_each(|(sum, area)| *sum /= areas[i] * area);
    }
    sums
}

fn from_matrix(matrix: &Matrix, basis: &Basis) -> Vec<f64> {
    let [incident, exitant] = [matrix.incident(), matrix.exitant()].map(|old| fractions(basis, old, 0.0));
    resampled(matrix, &incident, &exitant)
}

/// The matrix over new patches, each a mixture of old ones.
pub(super) fn resampled(
    matrix: &Matrix,
    incident: &[Vec<(usize, f64)>],
    exitant: &[Vec<(usize, f64)>],
) -> Vec<f64> {
    let n_old = matrix.exitant().n_patches();
    let mut values = Vec::with_capacity(incident.len() * exitant.len());
    let mut row = vec![0.0; n_old];
    for mixture in incident {
        row.fill(0.0);
        for &(i, share) in mixture {
            let old = &matrix.values()[i * n_old..][..n_old];
            row.iter_mut().zip(old).for_each(|(sum, &v)| *sum += share * f64::from(v));
        }
        values.extend(exitant.iter().map(|m| m.iter().map(|&(o, share)| share * row[o]).sum::<f64>()));
    }
    values
}

/// For each patch of `new`, the patches of `old` that it shares area with when those are turned counter-clockwise by an azimuth
/// \[rad\], as fractions of its own area.
pub(super) fn fractions(new: &Basis, old: &Basis, turn: f64) -> Vec<Vec<(usize, f64)>> {
    (0..new.n_patches())
        .map(|patch| {
            let [lower, upper] = new.radii(new.ring_of(patch)).map(|r| r * r);
            let azimuths = new.azimuths(patch).map(|phi| phi - turn);
            let mut found = Vec::new();
            for ring in 0..old.rings().len() {
                let [from, to] = old.radii(ring).map(|r| r * r);
                let radial = (upper.min(to) - lower.max(from)) / (upper - lower);
                if radial <= 1e-12 {
                    continue;
                }
                for other in old.patches_of(ring) {
                    let share = radial * shared_azimuth(azimuths, old.azimuths(other));
                    if share > 1e-12 {
                        found.push((other, share));
                    }
                }
            }
            found
        })
        .collect()
}

/// What fraction of one range of azimuths lies in another.
fn shared_azimuth([from, to]: [f64; 2], [a, b]: [f64; 2]) -> f64 {
    use std::f64::consts::TAU;
    let shared = |shift: f64| ((to + shift).min(b) - (from + shift).max(a)).max(0.0);
    let first = ((a - to) / TAU).floor() as i64;
    let last = ((b - from) / TAU).ceil() as i64;
    (first..=last).map(|k| shared(k as f64 * TAU)).sum::<f64>() / (to - from)
}
