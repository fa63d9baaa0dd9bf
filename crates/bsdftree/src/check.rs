//! Whether a BSDF obeys physics and says what its maker meant: energy, reciprocity, missing sides, orientation.
//!
//! Energy: no incident direction may scatter more than it brings. Reciprocity: pairs of directions are drawn from the BSDF
//! itself, so that the mean difference |a − b|/(a + b) between f(i, o) = a and f(o, i) = b is weighted by flux; Radiance's
//! checkBSDF compares unweighted. Orientation: light that a device lets straight through, or mirrors, lies on
//! the diagonal of its data; if it lies 180° about the normal from there, the incident directions were stored with the wrong sign.

use crate::bsdf::{Band, Bsdf, Part, Scattering};
use crate::direction::{Direction, Side};
use crate::klems::Basis;
use crate::query::Lobes;
use crate::square::disk_from_square;
use crate::tree::Rank;

/// What is tolerated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Most scattered light over 1.
    pub energy: f64,
    /// Largest flux-weighted mean of |a − b|/(a + b).
    pub reciprocity: f64,
}

impl Default for Tolerance {
    fn default() -> Tolerance {
        Tolerance { energy: 0.01, reciprocity: 0.25 }
    }
}

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Breaks a law of physics beyond tolerance.
    Violation,
    /// May not be what was meant.
    Warning,
}

/// Something the user should know.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// How bad.
    pub severity: Severity,
    /// What, where, how much, and what to do.
    pub message: String,
}

/// Scattered light from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// The side that light comes from.
    pub side: Side,
    /// Mean over incident directions by projected solid angle: reflected, transmitted.
    pub mean: [f64; 2],
    /// Largest total.
    pub max: f64,
    /// The incident direction of the largest total.
    pub at: Direction,
}

/// Reciprocity of one kind of scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reciprocity {
    /// The component, or, for transmission, both against each other.
    pub part: Part,
    /// Flux-weighted mean of |a − b|/(a + b), in \[0, 1\].
    pub mean: f64,
    /// Largest among the pairs drawn.
    pub max: f64,
}

/// Results for one band.
#[derive(Clone, Debug, PartialEq)]
pub struct BandCheck {
    /// Its name.
    pub band: String,
    /// One for each side that something is known of.
    pub energy: Vec<Energy>,
    /// One for each reflection, and one for transmission if both are there.
    pub reciprocity: Vec<Reciprocity>,
    /// What is wrong.
    pub findings: Vec<Finding>,
}

/// Checks all bands.
pub fn check(bsdf: &Bsdf, tolerance: Tolerance) -> Vec<BandCheck> {
    bsdf.bands.iter().map(|band| check_band(band, tolerance)).collect()
}

fn check_band(band: &Band, tolerance: Tolerance) -> BandCheck {
    if let Err(damage) = band.verify() {
        let findings = vec![violation(damage.to_string())];
        return BandCheck { band: band.name.clone(), energy: Vec::new(), reciprocity: Vec::new(), findings };
    }
    let mut findings = Vec::new();
    let energy: Vec<_> =
        [Side::Front, Side::Back].into_iter().filter_map(|side| energy(band, side)).collect();
    for e in &energy {
        if e.max > 1.0 + tolerance.energy {
            let [theta, phi] = polar_deg(e.at);
            findings.push(violation(format!(
                "light from {} at θ = {theta:.1}°, φ = {phi:.1}° scatters to {:.1} % of itself; expected at most 100 %",
                from(e.side),
                100.0 * e.max
            )));
        }
    }
    let reciprocity: Vec<_> = Part::ALL.into_iter().filter_map(|part| reciprocity(band, part)).collect();
    for r in &reciprocity {
        if r.mean > tolerance.reciprocity {
            findings.push(violation(format!(
                "{} is not reciprocal: swapping incident and exitant directions changes it by {:.0} % on average (limit {:.0} %)",
                if r.part.is_reflection() { r.part.file_name() } else { "Transmission" },
                100.0 * r.mean,
                100.0 * tolerance.reciprocity
            )));
        }
    }
    findings.extend(missing(band));
    findings.extend(Part::ALL.into_iter().filter_map(|part| orientation(band, part)));
    BandCheck { band: band.name.clone(), energy, reciprocity, findings }
}

fn violation(message: String) -> Finding {
    Finding { severity: Severity::Violation, message }
}

fn warning(message: String) -> Finding {
    Finding { severity: Severity::Warning, message }
}

fn from(side: Side) -> &'static str {
    match side {
        Side::Front => "the room (front, +Z)",
        Side::Back => "outside (back, −Z)",
    }
}

/// Polar angle from the nearer normal and azimuth \[degree\].
fn polar_deg([x, y, z]: Direction) -> [f64; 2] {
    [x.hypot(y).atan2(z.abs()).to_degrees(), y.atan2(x).to_degrees().rem_euclid(360.0)]
}

/// Incident directions on a side, one in each cell of the data up to 64 × 64, with their share of projected solid angle.
fn incident_directions(band: &Band, side: Side) -> Vec<(Direction, f64)> {
    let scattering = band.components().map(|(_, c)| &c.luminance);
    let mut log2_res = 4;
    for scattering in scattering {
        match scattering {
            Scattering::Matrix(matrix) => return patch_directions(matrix.incident(), side),
            Scattering::Tree(tree) => log2_res = log2_res.max(tree.arena().log2_res().min(6)),
        }
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

fn patch_directions(basis: &Basis, side: Side) -> Vec<(Direction, f64)> {
    (0..basis.n_patches())
        .map(|k| {
            let [x, y] = basis.disk_point(k, 0.5, 0.5);
            (side.direction_from_disk([-x, -y]), basis.projected_solid_angle(k) / std::f64::consts::PI)
        })
        .collect()
}

fn energy(band: &Band, side: Side) -> Option<Energy> {
    band.answering(side, side).or_else(|| band.answering(side, side.opposite()))?;
    let mut energy = Energy { side, mean: [0.0; 2], max: 0.0, at: [0.0, 0.0, side.sign()] };
    for (direction, share) in incident_directions(band, side) {
        let parts =
            [Lobes::Reflection, Lobes::Transmission].map(|lobes| band.hemispherical(direction, lobes));
        energy.mean = [0, 1].map(|k| energy.mean[k] + share * parts[k]);
        if parts[0] + parts[1] > energy.max {
            (energy.max, energy.at) = (parts[0] + parts[1], direction);
        }
    }
    Some(energy)
}

/// Compares a component with its reverse; transmission only once, and only if both are there.
fn reciprocity(band: &Band, part: Part) -> Option<Reciprocity> {
    let forward = &band.component(part)?.luminance;
    let backward = match part {
        Part::TransmissionBack => return None,
        Part::TransmissionFront => &band.component(Part::TransmissionBack)?.luminance,
        Part::ReflectionFront | Part::ReflectionBack => forward,
    };
    // Points of the R₃ sequence: incident square and one number to sample with.
    const N: usize = 4096;
    const STEP: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_938_2];
    let (mut sum, mut max, mut weight) = (0.0, 0.0f64, 0.0);
    for k in 0..N {
        let [s, t, u] = STEP.map(|step| (0.5 + step * k as f64).fract());
        let incident = part.incident_side().direction_from_disk(disk_from_square([s, t]));
        let lobe = forward.lobe(incident, false);
        let Some((disk, a)) = lobe.sample(u, None) else { continue };
        let exitant = part.exitant_side().direction_from_disk(disk);
        let difference = |exitant| {
            let b = backward.eval(incident, exitant, true);
            (a - b).abs() / (a + b)
        };
        let isotropic = matches!(backward, Scattering::Tree(tree) if tree.rank() == Rank::Three);
        let difference = match isotropic {
            true => difference(exitant).min(difference(mirrored(exitant, incident))),
            false => difference(exitant),
        };
        let flux = lobe.total();
        sum += flux * difference;
        weight += flux;
        max = max.max(difference);
    }
    (weight > 0.0).then(|| Reciprocity { part, mean: sum / weight, max })
}

/// The direction on the other side of the plane of incidence. A peak in that plane lies between two cells of an isotropic tree, and
/// genBSDF puts it into one of them: its data is reciprocal only up to this reflection.
fn mirrored([x, y, z]: Direction, incident: Direction) -> Direction {
    let r2 = incident[0].powi(2) + incident[1].powi(2);
    if r2 == 0.0 {
        return [x, y, z];
    }
    let along = (x * incident[0] + y * incident[1]) / r2;
    [2.0 * along * incident[0] - x, 2.0 * along * incident[1] - y, z]
}

fn missing(band: &Band) -> Vec<Finding> {
    let has = |part| band.component(part).is_some();
    let mut findings = Vec::new();
    if !Part::ALL.into_iter().any(has) {
        findings.push(violation("no component at all: everything is black".into()));
    }
    let transmits = has(Part::TransmissionFront) || has(Part::TransmissionBack);
    for part in [Part::ReflectionFront, Part::ReflectionBack] {
        if transmits && !has(part) {
            findings.push(warning(format!(
                "no {}: light from {} is not reflected; generate it, or accept that it is black",
                part.file_name(),
                from(part.incident_side())
            )));
        }
    }
    let parts = [Part::TransmissionFront, Part::TransmissionBack];
    for (absent, present) in [(parts[0], parts[1]), (parts[1], parts[0])] {
        let is_rank_3 =
            |part| band.component(part).is_some_and(|c| c.luminance.file_structure() == "TensorTree3");
        if !has(absent) && is_rank_3(present) {
            findings.push(warning(format!(
                "no {}: it is taken from {} reversed, which Radiance evaluates but does not sample for isotropic trees",
                absent.file_name(),
                present.file_name()
            )));
        }
    }
    findings
}

/// Compares the flux along the diagonal with that 180° about the normal from it.
fn orientation(band: &Band, part: Part) -> Option<Finding> {
    let scattering = &band.component(part)?.luminance;
    let (mut along, mut opposite, mut typical) = (0.0, 0.0, 0.0);
    for (incident, share) in incident_directions(band, part.incident_side()) {
        let [x, y, z] = incident;
        // Near the normal both are the same cell.
        if x.hypot(y) < 0.3 {
            continue;
        }
        let value = |x: f64, y: f64| share * scattering.eval(incident, [x, y, z], false);
        along += value(-x, -y);
        opposite += value(x, y);
        typical += share * scattering.hemispherical(incident, false) / std::f64::consts::PI;
    }
    (opposite > 10.0 * along && opposite > 10.0 * typical).then(|| {
        warning(format!(
            "the peaks of {} lie where light came from, not where it would go straight on or be mirrored: either a \
             retroreflector, or incident directions are stored with the wrong sign",
            part.file_name()
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Component;
    use crate::tree::Tree;

    fn bsdf(part: Part, tree: Tree) -> Bsdf {
        let mut bsdf = Bsdf::default();
        bsdf.band_mut("Visible").insert(part, Component::grey(tree.into()));
        bsdf
    }

    fn findings(bsdf: &Bsdf) -> Vec<Finding> {
        check(bsdf, Tolerance::default()).remove(0).findings
    }

    fn grid(value: impl Fn([usize; 4]) -> f32) -> Tree {
        let cells = (0..4096).map(|k| value([k >> 9, k >> 6 & 7, k >> 3 & 7, k & 7]));
        Tree::from_grid(Rank::Four, &cells.collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_lawful_diffuser_has_no_findings() {
        assert_eq!(findings(&bsdf(Part::ReflectionBack, Tree::uniform(Rank::Four, 0.3))), []);
    }

    #[test]
    fn too_much_energy_is_a_violation_with_its_direction() {
        let found = findings(&bsdf(Part::ReflectionBack, Tree::uniform(Rank::Four, 0.4)));
        assert_eq!(found[0].severity, Severity::Violation);
        assert!(found[0].message.contains("125.7 %"), "{}", found[0].message);
    }

    #[test]
    fn one_way_scattering_is_a_violation() {
        let one_way = grid(|[a, b, ..]| if a * b > 9 { 0.3 } else { 0.01 });
        let found = findings(&bsdf(Part::ReflectionBack, one_way));
        assert!(
            found.iter().any(|f| f.severity == Severity::Violation && f.message.contains("not reciprocal"))
        );
    }

    #[test]
    fn isotropic_data_is_compared_up_to_reflection_in_the_plane_of_incidence() {
        // The straight peak in the upper of the two cells beside the plane only, as genBSDF writes it.
        let values: Vec<f32> = (0..512)
            .map(|k| if k >> 6 < 4 && k >> 3 & 7 == 7 - (k >> 6) && k & 7 == 4 { 9.0 } else { 0.0 })
            .collect();
        let mut bsdf = Bsdf::default();
        for part in [Part::TransmissionFront, Part::TransmissionBack] {
            let tree = Tree::from_grid(Rank::Three, &values).unwrap();
            bsdf.band_mut("Visible").insert(part, Component::grey(tree.into()));
        }
        let found = check(&bsdf, Tolerance::default()).remove(0);
        assert!(found.reciprocity[0].mean < 0.1, "{:?}", found.reciprocity);
    }

    #[test]
    fn peaks_turned_by_180_degrees_are_a_warning() {
        let peak = 15.0;
        let straight = grid(|[a, b, c, d]| if (a, b) == (c, d) { peak } else { 0.0 });
        let turned = grid(|[a, b, c, d]| if (a, b) == (7 - c, 7 - d) { peak } else { 0.0 });
        let warned = |tree| {
            findings(&bsdf(Part::TransmissionFront, tree)).iter().any(|f| f.message.contains("wrong sign"))
        };
        assert!(!warned(straight));
        assert!(warned(turned));
    }

    #[test]
    fn missing_sides_are_warnings() {
        let found = findings(&bsdf(Part::TransmissionBack, Tree::uniform(Rank::Three, 0.2)));
        let messages: Vec<_> = found.iter().map(|f| f.message.as_str()).collect();
        assert!(messages.iter().any(|m| m.starts_with("no Reflection Front")), "{messages:?}");
        assert!(messages.iter().any(|m| m.starts_with("no Transmission Front")), "{messages:?}");
        assert!(found.iter().all(|f| f.severity == Severity::Warning));
    }
}
