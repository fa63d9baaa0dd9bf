//! Which mistake of directions explains that data is not reciprocal, or that its peaks lie where light came from.
//!
//! A component that is right has f(i, o) = f(o, i). Each known mistake makes another relation hold instead: incident directions with the
//! wrong sign, or azimuths that count the other way, f(Mi, o) in place of f(i, o); a transmission seen from its own side, f(Mi, Mo); rows
//! and columns exchanged, which is f(o, i) turned by 180°; or one transmission's values written as the other's.
//! Each is tried; it is told where it explains at least two thirds of the deviation. What a symmetric device does
//! not tell apart is named together.

use super::pairs::{Pair, difference, draw, mean};
use super::{BandReport, Finding, Kind, Motion, Repair, Severity, incident_directions};
use crate::bsdf::{Band, Part, Scattering};
use crate::convert::relative_l1;

/// Deviations from reciprocity below this need no explanation.
const RECIPROCAL: f64 = 0.05;
/// What a mistake may leave of the deviation that it explains.
const EXPLAINED: f64 = 1.0 / 3.0;
/// What the two reflections of a device may differ by that has the same two sides \[relative L1\].
const SAME: f64 = 0.02;

/// A mistake, and the deviation from reciprocity without it.
struct Mistake {
    motion: Motion,
    /// Whether incident and exitant directions were exchanged.
    exchanged: bool,
    deviation: f64,
}

impl Mistake {
    fn described(&self, part: Part) -> String {
        match (part.is_reflection(), self.exchanged, self.motion) {
            (true, ..) => format!("its incident directions are {}", self.motion.name()),
            (_, true, Motion::Stay) => "it has the values of Transmission Front".into(),
            (_, true, Motion::HalfTurn) => "its rows and columns are exchanged".into(),
            (_, true, motion) => {
                format!("its rows and columns are exchanged, and it is {} besides", motion.name())
            }
            (_, false, motion) => format!("it is {}", motion.name()),
        }
    }
}

pub(super) fn findings(band: &Band, report: &BandReport) -> Vec<Finding> {
    let mut found: Vec<Finding> = Vec::new();
    for r in report.reciprocity.iter().filter(|r| r.mean > RECIPROCAL) {
        let Some((base, mistakes)) = explanations(band, r.part) else { continue };
        let best = &mistakes[0];
        // Of reflections that tell so, light comes from elsewhere in transmissions too.
        let by_reflection = found.iter().find_map(|f| match f.repair {
            Some(Repair::MoveIncident(motion)) => Some(motion),
            _ => None,
        });
        let shared = by_reflection
            .filter(|&motion| mistakes.iter().any(|mistake| !mistake.exchanged && mistake.motion == motion));
        let told: Vec<_> = match (r.part.is_reflection(), shared) {
            (true, _) => vec![(r.part, Repair::MoveIncident(best.motion))],
            (false, Some(motion)) => [Part::TransmissionFront, Part::TransmissionBack]
                .map(|part| (part, Repair::MoveIncident(motion)))
                .to_vec(),
            (false, None) => {
                let repair = Repair::Move { motion: best.motion.inverse(), reverse: best.exchanged };
                vec![(Part::TransmissionBack, repair)]
            }
        };
        for (part, repair) in told {
            let described: Vec<_> = match shared {
                Some(motion) => vec![format!("its incident directions are {}", motion.name())],
                None => mistakes.iter().map(|mistake| mistake.described(r.part)).collect(),
            };
            let message = format!(
                "{} is reciprocal to {:.1} % instead of {:.1} % if {}",
                part.file_name(),
                100.0 * best.deviation,
                100.0 * base,
                described.join(", or "),
            );
            let message = if described.len() > 1 {
                message + ": the device is too symmetric to tell which"
            } else {
                message
            };
            let advice = "see how directions were counted; the first explanation is what --fix undoes";
            let finding = Finding::new(Kind::Orientation, Severity::Warning, message, advice);
            found.push(finding.of(part).by(base).mended_by(repair));
        }
    }
    let peaks = turned_peaks(band);
    found.extend(peaks.into_iter().filter(|f| !found_already(&found, f)).collect::<Vec<_>>());
    found
}

fn found_already(found: &[Finding], finding: &Finding) -> bool {
    found.iter().any(|f| f.part == finding.part)
}

/// The deviation from reciprocity as it is, and mistakes that explain it, all that do so equally well, simplest first.
fn explanations(band: &Band, part: Part) -> Option<(f64, Vec<Mistake>)> {
    let forward = &band.component(part)?.luminance;
    let reverse = if part.is_reflection() { part } else { Part::TransmissionBack };
    let backward = &band.component(reverse)?.luminance;
    let pairs = draw(forward, part);
    let deviation = |motion: Motion, exchanged: bool| {
        mean(&pairs, |Pair { incident, exitant, value, .. }| {
            difference(*value, backward.eval(motion.of(*incident), motion.of(*exitant), !exchanged))
        })
    };
    let base = deviation(Motion::Stay, false);
    let mut tried: Vec<(Motion, bool)> = Vec::new();
    // Between two equal sides, one transmission has the values of the other by right.
    if !part.is_reflection() && !has_equal_sides(band) {
        tried.extend([Motion::HalfTurn, Motion::Stay, Motion::MirrorX, Motion::MirrorY].map(|m| (m, true)));
    }
    let quarter = |m: &Motion| matches!(m, Motion::QuarterTurn | Motion::QuarterBack);
    tried.extend(Motion::ALL.iter().filter(|m| !(part.is_reflection() && quarter(m))).map(|&m| (m, false)));
    let mut mistakes: Vec<_> = tried
        .into_iter()
        .map(|(motion, exchanged)| Mistake { motion, exchanged, deviation: deviation(motion, exchanged) })
        .collect();
    let best = mistakes.iter().map(|m| m.deviation).fold(f64::INFINITY, f64::min);
    mistakes.retain(|m| m.deviation < 1.5 * best + 0.01);
    (base > RECIPROCAL && best < EXPLAINED * base).then_some((base, mistakes))
}

fn has_equal_sides(band: &Band) -> bool {
    let [front, back] = [Part::ReflectionFront, Part::ReflectionBack].map(|part| band.component(part));
    matches!((front, back), (Some(a), Some(b)) if relative_l1(&a.luminance, &b.luminance) < SAME)
}

/// Components whose peaks lie 180° from where light goes straight on or is mirrored.
fn turned_peaks(band: &Band) -> Vec<Finding> {
    let turned: Vec<_> = band
        .components()
        .filter(|(part, component)| peaks_are_turned(band, *part, &component.luminance))
        .map(|(part, _)| part)
        .collect();
    // No device sends all light back through itself; retroreflectors there are.
    let is_mistake = turned.iter().any(|part| !part.is_reflection());
    turned
        .into_iter()
        .map(|part| {
            let message = format!(
                "the peaks of {} lie where light came from, not where it would go straight on or be mirrored: either a \
                 retroreflector, or incident directions are stored with the wrong sign",
                part.file_name()
            );
            let advice = "see how incident directions were counted";
            let finding = Finding::new(Kind::Orientation, Severity::Warning, message, advice).of(part).by(1.0);
            if is_mistake { finding.mended_by(Repair::MoveIncident(Motion::HalfTurn)) } else { finding }
        })
        .collect()
}

/// Light of a component per solid angle that goes straight on or is mirrored, and that goes back to where it came from.
pub(crate) fn peak_light(band: &Band, part: Part) -> [f64; 2] {
    let Some(component) = band.component(part) else { return [0.0; 2] };
    peak_values(band, part, &component.luminance).map(|(light, _)| light)
}

/// Along the diagonal, and 180° about the normal from it: light, and what it would be if it were spread evenly.
fn peak_values(band: &Band, part: Part, function: &Scattering) -> [(f64, f64); 2] {
    [Motion::HalfTurn, Motion::Stay].map(|motion| {
        incident_directions(band, part.incident_side())
            .into_iter()
            // Near the normal both are the same cell.
            .filter(|(incident, _)| incident[0].hypot(incident[1]) >= 0.3)
            .fold((0.0, 0.0), |(light, typical), (incident, share)| {
                let value = function.eval(incident, motion.of(incident), false);
                let mean = function.hemispherical(incident, false) / std::f64::consts::PI;
                (light + share * value, typical + share * mean)
            })
    })
}

fn peaks_are_turned(band: &Band, part: Part, function: &Scattering) -> bool {
    let [(along, _), (opposite, typical)] = peak_values(band, part, function);
    opposite > 10.0 * along && opposite > 10.0 * typical
}
