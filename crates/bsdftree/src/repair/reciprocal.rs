//! Components and their reverses: made the same, or one from the other.
//!
//! Rank 4 and matrices reverse exactly, by permutation. The reverse of an isotropic tree is none: cells agree in both polar angles,
//! but not in azimuth, so it is sampled at 16 points in each cell of a uniform grid, then merged.

use crate::bsdf::{Band, Component, Part, Scattering};
use crate::check::can_be_symmetric;
use crate::convert::{channels, combined, from_channels};
use crate::direction::{Direction, Side};
use crate::klems::Matrix;
use crate::square::disk_from_square;
use crate::tree::{Rank, Tree};

/// Finest resolution at which isotropic trees are reversed.
const MAX_ISOTROPIC_LOG2: u32 = 7;

/// The function for light that travels the other way; `None` of an isotropic tree.
pub(super) fn reversed(function: &Scattering) -> Option<Scattering> {
    match function {
        Scattering::Tree(tree) if tree.rank() == Rank::Three => None,
        Scattering::Tree(tree) => Some(tree.reversed_copy().into()),
        Scattering::Matrix(matrix) => Some(matrix.reversed().into()),
    }
}

/// Puts the means of a component and its reverse, which for transmissions is the other one, in place of both.
pub(super) fn symmetrize(band: &mut Band, part: Part) -> bool {
    let reverse = if part.is_reflection() { part } else { Part::TransmissionBack };
    if !can_be_symmetric(band, part) {
        return false;
    }
    let [a, b] = [part, reverse].map(|part| band.component(part));
    let Some([forward, backward]) = a.zip(b).and_then(|(a, b)| {
        let forward = paired(a, b, &mean_with_reverse)?;
        // Its reverse, exactly: not another mean of the two, which would differ in the last bit.
        let backward = if part == reverse { forward.clone() } else { paired(b, a, &mean_with_reverse)? };
        Some([forward, backward])
    }) else {
        return false;
    };
    band.insert(reverse, backward);
    band.insert(part, forward);
    true
}

/// Makes an absent transmission from the other one.
pub(super) fn add_reverse(band: &mut Band, part: Part) -> bool {
    let Some((other, true)) = band.answering(part.incident_side(), part.exitant_side()) else { return false };
    let made = paired(other, other, &|f, _| match f {
        Scattering::Tree(tree) if tree.rank() == Rank::Three => {
            Some(isotropic(tree, &|i, o| f.eval(i, o, true)))
        }
        _ => reversed(f),
    });
    made.map(|component| band.insert(part, component)).is_some()
}

/// A component of two, function by function: Y, or X, Y and Z.
fn paired(
    a: &Component,
    b: &Component,
    f: &dyn Fn(&Scattering, &Scattering) -> Option<Scattering>,
) -> Option<Component> {
    match (channels(a).ok()?, channels(b).ok()?) {
        (Some([ax, ay, az]), Some([bx, by, bz])) => {
            from_channels([f(&ax, &bx)?, f(&ay, &by)?, f(&az, &bz)?]).ok()
        }
        _ => Some(Component::grey(f(&a.luminance, &b.luminance)?)),
    }
}

fn mean_with_reverse(f: &Scattering, other: &Scattering) -> Option<Scattering> {
    match (f, reversed(other)) {
        (Scattering::Matrix(a), Some(Scattering::Matrix(b))) => {
            let means = a.values().iter().zip(b.values());
            let values = means.map(|(&a, &b)| (0.5 * (f64::from(a) + f64::from(b))) as f32).collect();
            Some(Matrix::new(a.incident().clone(), a.exitant().clone(), values).ok()?.into())
        }
        (Scattering::Tree(a), Some(Scattering::Tree(b))) => {
            combined([a, &b, &b], &|[a, b, _]| 0.5 * (a + b)).ok().map(Scattering::from)
        }
        (Scattering::Tree(tree), None) => {
            // Isotropic surfaces are mirrored in the plane of incidence; a peak in it is in two cells then.
            let mean = |i: Direction, o: Direction| {
                let mirrored = [o[0], -o[1], o[2]];
                let all = [f.eval(i, o, false), f.eval(i, mirrored, false)];
                let back = [other.eval(i, o, true), other.eval(i, mirrored, true)];
                0.25 * (all[0] + all[1] + back[0] + back[1])
            };
            Some(isotropic(tree, &mean))
        }
        _ => None,
    }
}

/// An isotropic tree of a function; incident directions lie in the plane y = 0, to the left.
fn isotropic(like: &Tree, f: &dyn Fn(Direction, Direction) -> f64) -> Scattering {
    const N: usize = 4;
    let log2 = like.arena().log2_res().clamp(1, MAX_ISOTROPIC_LOG2);
    let n = 1usize << log2;
    let mut values = vec![0.0f32; n * n * n];
    for (cell, value) in values[..n * n * n / 2].iter_mut().enumerate() {
        let corner = [cell >> (2 * log2), cell >> log2 & (n - 1), cell & (n - 1)];
        let mut sum = 0.0;
        for k in 0..N * N {
            // Each sixteenth of each axis once.
            let inside = [(k * 7 + 3) % (N * N), k, (k % N) * N + k / N];
            let at =
                |axis: usize| (corner[axis] as f64 + (inside[axis] as f64 + 0.5) / (N * N) as f64) / n as f64;
            let incident = Side::Front.direction_from_disk([-(1.0 - 2.0 * at(0)), 0.0]);
            sum += f(incident, Side::Front.direction_from_disk(disk_from_square([at(1), at(2)])));
        }
        *value = (sum / (N * N) as f64) as f32;
    }
    Tree::from_grid(Rank::Three, &values).expect("means of values that are right").into()
}
