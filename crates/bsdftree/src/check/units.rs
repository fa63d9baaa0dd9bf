//! Numbers that are not values in 1/sr: percentages, values times the exitant cosine, or times the exitant solid angle.
//!
//! A factor of the exitant direction alone breaks reciprocity, so it is told by what mends it: dividing by it must take away two thirds of
//! the deviation. Solid angles of the patches of Klems's bases differ so little that totals must agree besides: what is called a
//! BSDF then scatters less than a patch's share, and its plain sums are what totals should be. Where nothing can be compared with its
//! reverse, or all light lies on the diagonal, a factor cannot be told.

use super::pairs::{Pair, difference, draw, mean};
use super::reciprocity::reversed_value;
use super::{BandReport, Finding, Kind, Repair, Severity};
use crate::bsdf::{Band, Part, Scattering};
use crate::direction::Direction;
use crate::klems::{Basis, Matrix};
use crate::square::disk_from_square;
use crate::tree::Position;

/// What values were multiplied by: a function of the exitant direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Factor {
    /// cos θ.
    Cosine,
    /// The projected solid angle of the patch \[sr\].
    ProjectedSolidAngle,
    /// The solid angle of the patch \[sr\].
    SolidAngle,
}

impl Factor {
    /// What it is, as in “values times …”.
    pub fn name(self) -> &'static str {
        match self {
            Factor::Cosine => "the cosine of the exitant angle",
            Factor::ProjectedSolidAngle => "the projected solid angle of the exitant patch",
            Factor::SolidAngle => "the solid angle of the exitant patch",
        }
    }

    /// For a patch.
    pub(crate) fn of_patch(self, basis: &Basis, patch: usize) -> f64 {
        let ring = basis.ring_of(patch);
        let [lower, upper] = basis.rings()[ring].bounds_deg.map(f64::to_radians);
        match self {
            // WINDOW's angle of the first ring is that of its one patch, the normal.
            Factor::Cosine if ring == 0 && basis.rings()[0].n_phi == 1 => 1.0,
            Factor::Cosine => (0.5 * (lower + upper)).cos(),
            Factor::ProjectedSolidAngle => basis.projected_solid_angle(patch),
            Factor::SolidAngle => {
                std::f64::consts::TAU * (lower.cos() - upper.cos()) / f64::from(basis.rings()[ring].n_phi)
            }
        }
    }

    /// For a pair of directions that a function scatters from and to; `None` if its kind of data knows no such factor.
    fn at(self, function: &Scattering, incident: Direction, exitant: Direction) -> Option<f64> {
        match (function, self) {
            (Scattering::Matrix(m), _) => Some(self.of_patch(m.exitant(), m.exitant().patch(exitant))),
            (Scattering::Tree(tree), Factor::Cosine) => {
                let position = Position::new(tree.rank(), incident, exitant);
                let (_, level) = tree.leaf_at(position);
                let cell = position.corner(level).map(|c| c as u32);
                let first = tree.rank().dimensions() - 2;
                Some(mean_cosine(level, [cell[first], cell[first + 1]]))
            }
            (Scattering::Tree(_), _) => None,
        }
    }
}

pub(super) fn findings(band: &Band, report: &BandReport) -> Vec<Finding> {
    let mut found: Vec<_> = percent(report).into_iter().collect();
    let factor = [Factor::Cosine, Factor::ProjectedSolidAngle, Factor::SolidAngle]
        .into_iter()
        .filter_map(|factor| Some((factor, explained(band, factor)?)))
        .min_by(|a, b| a.1[1].total_cmp(&b.1[1]));
    if let Some((factor, [before, after])) = factor {
        for (part, _) in band.components() {
            let message = format!(
                "{} is as if its values were multiplied by {}: without it, the band is reciprocal to {:.1} % instead of {:.1} %",
                part.file_name(),
                factor.name(),
                100.0 * after,
                100.0 * before
            );
            let advice = "write values in 1/sr, without cosine and solid angle";
            let finding = Finding::new(Kind::Units, Severity::Warning, message, advice);
            found.push(finding.of(part).by(before).mended_by(Repair::Divide(factor)));
        }
    }
    found
}

/// Totals that obey energy as percentages, and are far from doing so as they are.
fn percent(report: &BandReport) -> Option<Finding> {
    let most = report.energy.iter().map(|e| e.max).fold(0.0, f64::max);
    (5.0..=101.0).contains(&most).then(|| {
        let message = format!(
            "a direction scatters {most:.1} times its light: as if values were percentages, which would make it {most:.1} %"
        );
        let advice = "write values in 1/sr";
        Finding::new(Kind::Units, Severity::Warning, message, advice).by(most).mended_by(Repair::Scale(0.01))
    })
}

/// The deviations from reciprocity with and without a factor, if it explains them in every component that can be compared.
fn explained(band: &Band, factor: Factor) -> Option<[f64; 2]> {
    let needs = match factor {
        Factor::Cosine => 0.05,
        // Solid angles differ by a fifth at most between patches.
        _ if band.components().all(|(_, c)| sums_are_totals(&c.luminance)) => 0.005,
        _ => return None,
    };
    let (mut sums, mut n) = ([0.0; 2], 0.0);
    for part in [Part::ReflectionFront, Part::ReflectionBack, Part::TransmissionFront] {
        let reverse = if part.is_reflection() { part } else { Part::TransmissionBack };
        let (Some(a), Some(b)) = (band.component(part), band.component(reverse)) else { continue };
        let (forward, backward) = (&a.luminance, &b.luminance);
        let pairs = draw(forward, part);
        if pairs.is_empty() {
            continue;
        }
        let deviation = |factor: &dyn Fn(&Scattering, Direction, Direction) -> f64| {
            mean(&pairs, |pair: &Pair| {
                let [i, o] = [pair.incident, pair.exitant];
                let value = pair.value / factor(forward, i, o);
                difference(value, reversed_value(pair, backward) / factor(backward, o, i))
            })
        };
        factor.at(forward, pairs[0].incident, pairs[0].exitant)?;
        let before = deviation(&|_, _, _| 1.0);
        let after = deviation(&|function, i, o| factor.at(function, i, o).unwrap_or(1.0));
        if after > 0.5 * before + 0.001 {
            return None;
        }
        sums = [sums[0] + before, sums[1] + after];
        n += 1.0;
    }
    let [before, after] = sums.map(|sum| sum / n);
    // False of no component, too.
    (before > needs && after < before / 3.0).then_some([before, after])
}

/// Whether plain sums over exitant patches are what totals may be, for each incident one, and totals are next to nothing.
fn sums_are_totals(function: &Scattering) -> bool {
    let Scattering::Matrix(matrix) = function else { return false };
    let sums = plain_sums(matrix);
    let largest = sums.iter().copied().fold(0.0, f64::max);
    let [_, angle] = matrix.projected_solid_angle_range(false);
    let basis = matrix.exitant();
    let total = |row: &[f32]| -> f64 {
        row.iter().enumerate().map(|(k, &f)| f64::from(f) * basis.projected_solid_angle(k)).sum()
    };
    let most = matrix.values().chunks_exact(basis.n_patches()).map(total).fold(0.0, f64::max);
    largest <= 1.05 && most <= angle
}

fn plain_sums(matrix: &Matrix) -> Vec<f64> {
    let rows = matrix.values().chunks_exact(matrix.exitant().n_patches());
    rows.map(|row| row.iter().map(|&f| f64::from(f)).sum()).collect()
}

/// The mean cosine over a cell of the exitant square.
pub(crate) fn mean_cosine(level: u32, cell: [u32; 2]) -> f64 {
    const N: u32 = 4;
    let edge = 0.5f64.powi(level as i32);
    let at = |c: u32, k: u32| (f64::from(c) + (f64::from(k) + 0.5) / f64::from(N)) * edge;
    let cosine = |k: u32| {
        let [x, y] = disk_from_square([at(cell[0], k / N), at(cell[1], k % N)]);
        (1.0 - x * x - y * y).max(0.0).sqrt()
    };
    (0..N * N).map(cosine).sum::<f64>() / f64::from(N * N)
}
