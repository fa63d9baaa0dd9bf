//! Small BSDFs with one mistake each; larger ones and real files in tests/check.rs.

use super::*;
use crate::bsdf::Component;
use crate::tree::{Rank, Tree};

fn bsdf(part: Part, tree: Tree) -> Bsdf {
    let mut bsdf = Bsdf::default();
    bsdf.band_mut("Visible").insert(part, Component::grey(tree.into()));
    bsdf
}

fn findings(bsdf: &Bsdf) -> Vec<Finding> {
    check(bsdf, Tolerance::default()).bands.remove(0).findings
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
    assert!(found.iter().any(|f| f.severity == Severity::Violation && f.message.contains("not reciprocal")));
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
    let found = check(&bsdf, Tolerance::default()).bands.remove(0);
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
