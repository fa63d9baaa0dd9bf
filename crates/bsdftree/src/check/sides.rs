//! Components that are absent, the same as another, in each other's place, or where nobody reads them.

use super::{BandReport, Finding, Kind, Repair, Severity, energy, from};
use crate::bsdf::{Band, Part, Scattering};
use crate::direction::Side;
use crate::tree::{Leaf, Rank};

pub(super) fn findings(band: &Band, report: &BandReport, tolerance: f64) -> Vec<Finding> {
    let mut found = missing(band);
    found.extend(copies(band));
    found.extend(unread(band));
    found.extend(swapped(band, report, tolerance));
    found
}

fn missing(band: &Band) -> Vec<Finding> {
    let has = |part| band.component(part).is_some();
    let finding = |severity, message, advice| Finding::new(Kind::Sides, severity, message, advice);
    let mut found = Vec::new();
    if !Part::ALL.into_iter().any(has) {
        let message = "no component at all: everything is black".into();
        found.push(finding(Severity::Violation, message, "generate or export it again"));
    }
    let transmits = has(Part::TransmissionFront) || has(Part::TransmissionBack);
    for part in [Part::ReflectionFront, Part::ReflectionBack] {
        if transmits && !has(part) {
            let side = from(part.incident_side());
            let message = format!("no {}: light from {side} is not reflected", part.file_name());
            let advice = "generate it, or accept that it is black";
            found.push(finding(Severity::Warning, message, advice).of(part));
        }
    }
    let parts = [Part::TransmissionFront, Part::TransmissionBack];
    for (absent, present) in [(parts[0], parts[1]), (parts[1], parts[0])] {
        let is_rank_3 =
            |part| band.component(part).is_some_and(|c| c.luminance.file_structure() == "TensorTree3");
        if !has(absent) && is_rank_3(present) {
            let message = format!(
                "no {}: it is taken from {} reversed, which Radiance evaluates but does not sample for isotropic trees",
                absent.file_name(),
                present.file_name()
            );
            let advice = "write it into the file too";
            found.push(finding(Severity::Warning, message, advice).of(absent).mended_by(Repair::FromReverse));
        }
    }
    found
}

/// Isotropic trees with light only where none is read: incident angles are in the half below ½ of the first coordinate.
fn unread(band: &Band) -> Vec<Finding> {
    let is_unread = |function: &Scattering| match function {
        Scattering::Tree(tree) if tree.rank() == Rank::Three => {
            let is_read = |leaf: &Leaf| leaf.level == 0 || leaf.cell[0] >> (leaf.level - 1) == 0;
            let mut lit = tree.leaves().filter(|leaf| leaf.value > 0.0).peekable();
            lit.peek().is_some() && !lit.any(|leaf| is_read(&leaf))
        }
        _ => false,
    };
    let parts = band.components().filter(|(_, component)| is_unread(&component.luminance));
    parts
        .map(|(part, _)| {
            let message = format!(
                "{} is black: all its values lie in the half of the isotropic tree that is not read (first coordinate ½ and over)",
                part.file_name()
            );
            let advice = "the first coordinate is ½ − ½ sin θ: 0 for grazing light, nearly ½ for that along the normal";
            Finding::new(Kind::Orientation, Severity::Warning, message, advice).of(part).by(1.0)
        })
        .collect()
}

/// Reflections that are a transmission, value by value.
fn copies(band: &Band) -> Vec<Finding> {
    let mut found = Vec::new();
    for reflection in [Part::ReflectionFront, Part::ReflectionBack] {
        let same = [Part::TransmissionFront, Part::TransmissionBack].into_iter().find(|&transmission| {
            let [a, b] = [reflection, transmission].map(|part| band.component(part));
            matches!((a, b), (Some(a), Some(b)) if is_copy(&a.luminance, &b.luminance))
        });
        if let Some(transmission) = same {
            let message = format!(
                "{} has the very values of {}: one was written in place of the other",
                reflection.file_name(),
                transmission.file_name()
            );
            let advice = "export the reflection again; without it, it is black";
            let finding = Finding::new(Kind::Sides, Severity::Warning, message, advice);
            found.push(finding.of(reflection).by(1.0).mended_by(Repair::Drop));
        }
    }
    found
}

/// Whether all values are equal, and are not all one.
fn is_copy(a: &Scattering, b: &Scattering) -> bool {
    match (a, b) {
        (Scattering::Matrix(a), Scattering::Matrix(b)) => {
            a.values() == b.values() && a.values().iter().any(|v| v != &a.values()[0])
        }
        (Scattering::Tree(a), Scattering::Tree(b)) => {
            a.arena().n_leaves() > 1 && a.rank() == b.rank() && a.leaves().eq(b.leaves())
        }
        _ => false,
    }
}

/// Reflections that obey energy only in each other's place.
fn swapped(band: &Band, report: &BandReport, tolerance: f64) -> Option<Finding> {
    let most = |energies: &[super::Energy]| energies.iter().map(|e| e.max).fold(0.0, f64::max);
    let before = most(&report.energy);
    let [front, back] = [Part::ReflectionFront, Part::ReflectionBack].map(|part| band.component(part));
    if before <= 1.0 + tolerance {
        return None;
    }
    let mut other = band.clone();
    other.insert(Part::ReflectionFront, back?.clone());
    other.insert(Part::ReflectionBack, front?.clone());
    let energies: Vec<_> =
        [Side::Front, Side::Back].into_iter().filter_map(|side| energy(&other, side)).collect();
    let after = most(&energies);
    (after <= 1.0 + tolerance).then(|| {
        let message = format!(
            "if Reflection Front and Reflection Back changed places, no direction would scatter more than {:.1} %; as it is, {:.1} %",
            100.0 * after,
            100.0 * before
        );
        let advice = "WINDOW's front is the outside; exchange them if the maker thought otherwise";
        let finding = Finding::new(Kind::Sides, Severity::Warning, message, advice);
        finding.by(before - 1.0).mended_by(Repair::SwapReflections)
    })
}
