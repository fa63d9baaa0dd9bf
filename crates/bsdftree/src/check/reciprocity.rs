//! Reciprocity: f(i, o) = f(o, i) for reflections, and between the two transmissions.

use super::pairs::{Pair, difference, draw};
use super::{Finding, Kind, Repair, Severity, name, polar};
use crate::bsdf::{Band, Component, Part, Scattering};
use crate::direction::Direction;
use crate::tree::Rank;

/// Reciprocity of one kind of scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reciprocity {
    /// The component, or, for transmission, both against each other.
    pub part: Part,
    /// Flux-weighted mean of |a − b|/(a + b), in \[0, 1\].
    pub mean: f64,
    /// Largest among the pairs drawn.
    pub max: f64,
    /// Incident and exitant direction of the largest.
    pub at: [Direction; 2],
}

/// Compares a component with its reverse; transmission only once, and only if both are there.
pub(crate) fn reciprocity(band: &Band, part: Part) -> Option<Reciprocity> {
    let forward = &band.component(part)?.luminance;
    // What flows either way is drawn, so that light which only one of them has is seen.
    let drawn = match part {
        Part::TransmissionBack => return None,
        Part::TransmissionFront => {
            let other = Part::TransmissionBack;
            let backward = &band.component(other)?.luminance;
            vec![(backward, draw(forward, part)), (forward, draw(backward, other))]
        }
        Part::ReflectionFront | Part::ReflectionBack => vec![(forward, draw(forward, part))],
    };
    let mut result = Reciprocity { part, mean: 0.0, max: 0.0, at: [[0.0, 0.0, 1.0]; 2] };
    let mut flux = 0.0;
    for (backward, pairs) in &drawn {
        for pair in pairs {
            let difference = difference(pair.value, reversed_value(pair, backward));
            result.mean += pair.flux * difference;
            flux += pair.flux;
            if difference > result.max {
                (result.max, result.at) = (difference, [pair.incident, pair.exitant]);
            }
        }
    }
    result.mean /= flux;
    (flux > 0.0).then_some(result)
}

/// The value of the swapped pair. A peak in the plane of incidence lies between two cells of an isotropic tree, and genBSDF puts it
/// into one of them: its data is reciprocal only up to reflection in that plane, so there it is the nearer of two.
pub(super) fn reversed_value(pair: &Pair, backward: &Scattering) -> f64 {
    let to = |exitant| backward.eval(pair.incident, exitant, true);
    let value = to(pair.exitant);
    match backward {
        Scattering::Tree(tree) if tree.rank() == Rank::Three => {
            let other = to(mirrored(pair.exitant, pair.incident));
            if difference(pair.value, other) < difference(pair.value, value) { other } else { value }
        }
        _ => value,
    }
}

/// The direction on the other side of the plane of incidence.
fn mirrored([x, y, z]: Direction, incident: Direction) -> Direction {
    let r2 = incident[0].powi(2) + incident[1].powi(2);
    if r2 == 0.0 {
        return [x, y, z];
    }
    let along = (x * incident[0] + y * incident[1]) / r2;
    [2.0 * along * incident[0] - x, 2.0 * along * incident[1] - y, z]
}

/// Whether a component and its reverse have values for the same cells.
pub(crate) fn can_be_symmetric(band: &Band, part: Part) -> bool {
    let reverse = if part.is_reflection() { part } else { Part::TransmissionBack };
    let [a, b] = [part, reverse].map(|part| band.component(part));
    let (Some(a), Some(b)) = (a, b) else { return false };
    let is_colored = |component: &Component| component.chroma.is_some();
    let agree = match (&a.luminance, &b.luminance) {
        (Scattering::Matrix(a), Scattering::Matrix(b)) => {
            a.incident().rings() == b.exitant().rings() && a.exitant().rings() == b.incident().rings()
        }
        (Scattering::Tree(a), Scattering::Tree(b)) => a.rank() == b.rank(),
        _ => false,
    };
    agree && is_colored(a) == is_colored(b)
}

pub(super) fn findings(band: &Band, results: &[Reciprocity], tolerance: f64) -> Vec<Finding> {
    let wrong = results.iter().filter(|r| r.mean > tolerance);
    wrong
        .map(|r| {
            let message = format!(
                "{} is not reciprocal: swapping incident and exitant directions changes it by {:.0} % on average (limit {:.0} %), by \
                 {:.0} % from {} to {}",
                name(r.part),
                100.0 * r.mean,
                100.0 * tolerance,
                100.0 * r.max,
                polar(r.at[0]),
                polar(r.at[1]),
            );
            let advice = "see whether another finding explains it; noise shows so too: generate with more samples";
            let finding = Finding::new(Kind::Reciprocity, Severity::Violation, message, advice);
            let finding = finding.of(r.part).at(r.at).by(r.mean);
            if can_be_symmetric(band, r.part) { finding.mended_by(Repair::Symmetrize) } else { finding }
        })
        .collect()
}
