//! Energy: no incident direction may scatter more than it brings, reflected and transmitted together.

use super::{Finding, Kind, Repair, Severity, from, polar};
use crate::bsdf::{Band, Scattering};
use crate::direction::{Direction, Side};
use crate::klems::Basis;
use crate::query::Lobes;
use crate::square::disk_from_square;
use crate::tree::Rank;

/// Finest resolution at which incident directions of trees are looked at.
const MAX_LOG2: u32 = 8;

/// Scattered light from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// The side that light comes from.
    pub side: Side,
    /// Mean over incident directions by projected solid angle: reflected, transmitted.
    pub mean: [f64; 2],
    /// Largest total.
    pub max: f64,
    /// Reflected and transmitted there.
    pub max_parts: [f64; 2],
    /// The incident direction of the largest total.
    pub at: Direction,
    /// Share of incident directions, by projected solid angle, whose total is over 1.
    pub over: f64,
}

/// Incident directions on a side, one in each cell of the data up to 256 × 256, with their share of projected solid angle.
pub(crate) fn incident_directions(band: &Band, side: Side) -> Vec<(Direction, f64)> {
    let (mut log2_res, mut is_isotropic) = (4, false);
    for (_, component) in band.components() {
        match &component.luminance {
            Scattering::Matrix(matrix) => return patch_directions(matrix.incident(), side),
            Scattering::Tree(tree) => {
                is_isotropic |= tree.rank() == Rank::Three;
                log2_res = log2_res.max(tree.arena().log2_res().min(MAX_LOG2));
            }
        }
    }
    if is_isotropic {
        return ring_directions(log2_res, side);
    }
    let n = 1 << log2_res;
    let center = |k: usize| (k as f64 + 0.5) / n as f64;
    (0..n * n)
        .map(|k| {
            let disk = disk_from_square([center(k / n), center(k % n)]);
            (side.direction_from_disk(disk), 1.0 / (n * n) as f64)
        })
        .collect()
}

/// One in each ring of an isotropic tree: its cells lie in the half below ½.
fn ring_directions(log2_res: u32, side: Side) -> Vec<(Direction, f64)> {
    let n = 1 << (log2_res - 1);
    let radius = |k: f64| k / f64::from(n);
    (0..n)
        .map(|k| {
            let [lower, middle, upper] = [0.0, 0.5, 1.0].map(|part| radius(f64::from(k) + part));
            (side.direction_from_disk([-middle, 0.0]), upper * upper - lower * lower)
        })
        .collect()
}

fn patch_directions(basis: &Basis, side: Side) -> Vec<(Direction, f64)> {
    (0..basis.n_patches())
        .map(|k| {
            let [x, y] = basis.disk_point(k, 0.5, 0.5);
            (side.direction_from_disk([-x, -y]), basis.projected_solid_angle(k) / std::f64::consts::PI)
        })
        .collect()
}

/// What a band scatters of light from a side; `None` if it knows nothing of that.
pub(crate) fn energy(band: &Band, side: Side) -> Option<Energy> {
    band.answering(side, side).or_else(|| band.answering(side, side.opposite()))?;
    let (directions, shares): (Vec<_>, Vec<_>) = incident_directions(band, side).into_iter().unzip();
    let totals = [Lobes::Reflection, Lobes::Transmission].map(|lobes| {
        let mut totals = vec![0.0; directions.len()];
        for (_, function, reversed) in band.exits(directions[0], lobes) {
            function.hemispherical_many(&directions, reversed, &mut totals);
        }
        totals
    });
    let at = [0.0, 0.0, side.sign()];
    let mut energy = Energy { side, mean: [0.0; 2], max: 0.0, max_parts: [0.0; 2], at, over: 0.0 };
    for (k, (direction, share)) in directions.into_iter().zip(shares).enumerate() {
        let parts = [totals[0][k], totals[1][k]];
        energy.mean = [0, 1].map(|k| energy.mean[k] + share * parts[k]);
        let total = parts[0] + parts[1];
        if total > 1.0 {
            energy.over += share;
        }
        if total > energy.max {
            (energy.max, energy.max_parts, energy.at) = (total, parts, direction);
        }
    }
    Some(energy)
}

pub(super) fn findings(energies: &[Energy], tolerance: f64) -> Vec<Finding> {
    let too_much = energies.iter().filter(|e| e.max > 1.0 + tolerance);
    too_much
        .map(|e| {
            let alone = match e.max_parts.map(|part| part > 1.0 + tolerance) {
                [true, _] => ", the reflected part alone over 100 %",
                [_, true] => ", the transmitted part alone over 100 %",
                _ => "",
            };
            let message = format!(
                "light from {} at {} scatters to {:.1} % of itself ({:.1} % reflected, {:.1} % transmitted{alone}); expected at most \
                 100 %; {:.1} % of incident directions exceed it",
                from(e.side),
                polar(e.at),
                100.0 * e.max,
                100.0 * e.max_parts[0],
                100.0 * e.max_parts[1],
                100.0 * e.over,
            );
            Finding::new(
                Kind::Energy,
                Severity::Violation,
                message,
                "generate it with more samples, or scale these directions down",
            )
            .at(e.at)
            .by(e.max - 1.0)
            .mended_by(Repair::ScaleDown)
        })
        .collect()
}
