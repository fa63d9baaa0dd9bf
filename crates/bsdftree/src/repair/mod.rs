//! Mending what [`check`](crate::check) finds.
//!
//! In: a BSDF, and the kinds of finding to mend. Out: a copy in which each finding of these kinds that names a [`Repair`] was acted upon, and what
//! was done, with a number before and after. Kinds are mended in the order of [`Kind::ALL`], each measured on what those before it left. What has
//! no such finding is left alone, bit by bit. The header's provenance says what was done.

mod colour;
mod energy;
mod reciprocal;
mod values;

use crate::bsdf::{Band, Bsdf, Component, Part, Scattering};
use crate::check::{BandReport, Finding, Kind, Repair, Report, Tolerance, check, mended_lengths, nanometers};
use crate::direction::Side;

/// One thing that was mended.
#[derive(Clone, Debug, PartialEq)]
pub struct Mended {
    /// Its kind.
    pub kind: Kind,
    /// The band, unless it is the header's.
    pub band: Option<String>,
    /// The component, if it is about one.
    pub part: Option<Part>,
    /// What was done.
    pub what: String,
    /// What the numbers are.
    pub measure: &'static str,
    /// It before.
    pub before: f64,
    /// And after.
    pub after: f64,
}

/// A copy with findings of some kinds mended, and what was done.
pub fn repaired(bsdf: &Bsdf, kinds: &[Kind], tolerance: Tolerance) -> (Bsdf, Vec<Mended>) {
    let mut bsdf = bsdf.clone();
    let mut all = Vec::new();
    for kind in Kind::ALL.into_iter().filter(|kind| kinds.contains(kind)) {
        // Taking one side away may show what is wrong with another: no more often than there are components.
        for _ in Part::ALL {
            let report = check(&bsdf, tolerance);
            let mended = mended(&mut bsdf, &report, kind);
            if mended.is_empty() {
                break;
            }
            all.extend(measured(mended, &bsdf, &check(&bsdf, tolerance)));
            if kind != Kind::Sides {
                break;
            }
        }
    }
    bsdf.header.provenance.extend(all.iter().map(comment));
    (bsdf, all)
}

/// What the file says of a repair.
fn comment(mended: &Mended) -> String {
    format!(
        "Repaired by: bsdftree {} ({}{}: {} {:.4}, was {:.4})",
        env!("CARGO_PKG_VERSION"),
        mended.band.as_ref().map_or_else(String::new, |band| format!("{band}, ")),
        mended.what,
        mended.measure,
        mended.after,
        mended.before
    )
}

/// Does what the findings of a kind ask for. `after` is still what was before.
fn mended(bsdf: &mut Bsdf, report: &Report, kind: Kind) -> Vec<(Repair, Mended)> {
    let mut all = Vec::new();
    let entry = |finding: &Finding, repair, band: Option<&Band>, report: Option<&BandReport>, header| {
        let (measure, before) = measure(repair, finding.part, band, report, header);
        let band = band.map(|band| band.name.clone());
        let what = described(repair, finding.part);
        (repair, Mended { kind, band, part: finding.part, what, measure, before, after: before })
    };
    let asked = |findings: &[Finding]| -> Vec<(Finding, Repair)> {
        let of_kind = findings.iter().filter(|finding| finding.kind == kind);
        of_kind.filter_map(|finding| Some((finding.clone(), finding.repair?))).collect()
    };
    for (finding, repair) in asked(&report.findings) {
        all.push(entry(&finding, repair, None, None, longest(bsdf)));
        if let Some([width, height, thickness]) = mended_lengths(&bsdf.header) {
            let header = &mut bsdf.header;
            (header.width, header.height, header.thickness) = (width, height, thickness);
        }
    }
    for (band, report) in bsdf.bands.iter_mut().zip(&report.bands) {
        let mut is_scaled = false;
        for (finding, repair) in asked(&report.findings) {
            // Both sides are scaled at once.
            if repair == Repair::ScaleDown && std::mem::replace(&mut is_scaled, true) {
                continue;
            }
            let entry = entry(&finding, repair, Some(band), Some(report), 0.0);
            if apply(band, repair, finding.part) {
                all.push(entry);
            }
        }
    }
    all
}

/// Mends a band; whether it could.
fn apply(band: &mut Band, repair: Repair, part: Option<Part>) -> bool {
    let replaced = |band: &mut Band, f: &dyn Fn(&Component) -> Option<Component>| {
        let Some(part) = part else { return false };
        let made = band.component(part).and_then(f);
        made.map(|component| band.insert(part, component)).is_some()
    };
    match repair {
        Repair::Scale(factor) => values::scale(band, factor),
        Repair::Divide(factor) => replaced(band, &|component| Some(values::divided(component, factor))),
        Repair::Lengths => false,
        Repair::Wavelength => nanometers(&band.name).map(|name| band.name = name).is_some(),
        Repair::MoveIncident(motion) => {
            replaced(band, &|component| each(component, |f| motion.incident_moved(f)))
        }
        Repair::Move { motion, reverse: false } => {
            replaced(band, &|component| each(component, |f| Some(motion.moved(f))))
        }
        Repair::Move { motion, reverse: true } => {
            replaced(band, &|component| each(component, |f| Some(motion.moved(&reciprocal::reversed(f)?))))
        }
        Repair::SwapReflections => {
            let [front, back] = [Part::ReflectionFront, Part::ReflectionBack];
            let (Some(a), Some(b)) = (band.component(front).cloned(), band.component(back).cloned()) else {
                return false;
            };
            band.insert(front, b);
            band.insert(back, a);
            true
        }
        Repair::Drop => part.is_some_and(|part| band.remove(part).is_some()),
        Repair::FromReverse => part.is_some_and(|part| reciprocal::add_reverse(band, part)),
        Repair::Symmetrize => part.is_some_and(|part| reciprocal::symmetrize(band, part)),
        Repair::ScaleDown => energy::scale_down(band),
        Repair::ClipColour => replaced(band, &colour::clipped),
    }
}

/// A component with every function replaced, colours too: for permutations only.
fn each(component: &Component, f: impl Fn(&Scattering) -> Option<Scattering>) -> Option<Component> {
    let chroma = match &component.chroma {
        None => None,
        Some([a, b]) => Some([f(a)?, f(b)?]),
    };
    Some(Component { luminance: f(&component.luminance)?, chroma })
}

fn described(repair: Repair, part: Option<Part>) -> String {
    let part = part.map_or("", Part::file_name);
    match repair {
        Repair::Scale(factor) => format!("all values times {factor}"),
        Repair::Divide(factor) => format!("{part} divided by {}", factor.name()),
        Repair::Lengths => "lengths taken as millimetres".into(),
        Repair::Wavelength => "wavelength taken as micrometres".into(),
        Repair::MoveIncident(motion) => format!("incident directions of {part} {}", motion.name()),
        Repair::Move { motion, reverse } => {
            let exchanged = if reverse { ", incident and exitant directions exchanged" } else { "" };
            format!("{part} {}{exchanged}", motion.name())
        }
        Repair::SwapReflections => "Reflection Front and Back exchanged".into(),
        Repair::Drop => format!("{part} left out"),
        Repair::FromReverse => format!("{part} made from its reverse"),
        Repair::Symmetrize => format!("{part} averaged with its reverse"),
        Repair::ScaleDown => "pairs of directions scaled down".into(),
        Repair::ClipColour => format!("colours of {part} moved towards white"),
    }
}

/// Fills in what the numbers are now.
fn measured(mended: Vec<(Repair, Mended)>, bsdf: &Bsdf, report: &Report) -> Vec<Mended> {
    mended
        .into_iter()
        .map(|(repair, entry)| {
            let renamed = entry.band.as_ref().map(|name| match repair {
                Repair::Wavelength => nanometers(name).unwrap_or_default(),
                _ => name.clone(),
            });
            let index = renamed.and_then(|name| bsdf.bands.iter().position(|band| band.name == name));
            let (band, report) = (index.map(|k| &bsdf.bands[k]), index.map(|k| &report.bands[k]));
            let (_, after) = measure(repair, entry.part, band, report, longest(bsdf));
            Mended { after, ..entry }
        })
        .collect()
}

fn longest(bsdf: &Bsdf) -> f64 {
    let header = &bsdf.header;
    [header.width, header.height, header.thickness].into_iter().flatten().fold(0.0, f64::max)
}

/// The number that a repair is to change.
fn measure(
    repair: Repair,
    part: Option<Part>,
    band: Option<&Band>,
    report: Option<&BandReport>,
    length: f64,
) -> (&'static str, f64) {
    let (Some(band), Some(report)) = (band, report) else { return ("longest [m]", length) };
    match repair {
        Repair::Lengths => ("longest [m]", length),
        Repair::Wavelength => ("wavelength [nm]", band.name.trim().parse().unwrap_or_default()),
        Repair::Scale(_) | Repair::SwapReflections | Repair::Drop | Repair::ScaleDown => {
            ("largest total", report.energy.iter().map(|e| e.max).fold(0.0, f64::max))
        }
        Repair::FromReverse => ("components", band.components().count() as f64),
        Repair::Divide(_) | Repair::MoveIncident(_) | Repair::Move { .. } | Repair::Symmetrize => {
            let of = |part: Part| if part.is_reflection() { part } else { Part::TransmissionFront };
            let found = report.reciprocity.iter().find(|r| part.is_some_and(|part| of(part) == r.part));
            match (found, repair, part) {
                // Peaks are as reciprocal on the wrong side of the normal as on the right one.
                (None, Repair::MoveIncident(_), Some(part)) => turned_share(band, part),
                (Some(r), Repair::MoveIncident(_), Some(part)) if r.mean < 0.05 => turned_share(band, part),
                _ => ("deviation from reciprocity", found.map_or(0.0, |r| r.mean)),
            }
        }
        Repair::ClipColour => {
            let found = report.gamut.iter().find(|g| Some(g.part) == part);
            ("light of impossible colour", found.map_or(0.0, |g| g.impossible))
        }
    }
}

fn turned_share(band: &Band, part: Part) -> (&'static str, f64) {
    let [along, opposite] = crate::check::peak_light(band, part);
    let all = along + opposite;
    ("share of peaks where light came from", if all > 0.0 { opposite / all } else { 0.0 })
}

/// The side whose incident directions a component's exitant ones would be.
fn side_of_reverse(part: Part) -> Side {
    part.exitant_side()
}

#[cfg(test)]
mod tests;
