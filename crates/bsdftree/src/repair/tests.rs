//! Repairs of small BSDFs; of larger ones and real files in tests/check.rs.

use super::*;
use crate::tree::{Rank, Tree};

fn one(part: Part, function: Scattering) -> Bsdf {
    let mut bsdf = Bsdf::default();
    bsdf.band_mut("Visible").insert(part, Component::grey(function));
    bsdf
}

fn fixed(bsdf: &Bsdf) -> (Bsdf, Vec<Mended>) {
    repaired(bsdf, &Kind::ALL, Tolerance::default())
}

#[test]
fn scaling_down_leaves_directions_below_one_alone() {
    // One incident quarter is too bright; light leaves to where no incident direction of the component is.
    let values: Vec<f32> = (0..256)
        .map(|k| match [k >> 6, k >> 4 & 3, k >> 2 & 3, k & 3] {
            [0, 0, 3, 3] => 8.0,
            [0 | 1, _, 2 | 3, _] => 0.1,
            _ => 0.0,
        })
        .collect();
    let bsdf = one(Part::TransmissionFront, Tree::from_grid(Rank::Four, &values).unwrap().into());
    let before = check(&bsdf, Tolerance::default());
    let after = repaired(&bsdf, &[Kind::Energy], Tolerance::default()).0;
    let after = check(&after, Tolerance::default());
    assert!(before.bands[0].energy.iter().any(|e| e.max > 1.5));
    for e in &after.bands[0].energy {
        assert!(e.max < 1.0 + 1e-5, "{e:?}");
    }
    let dark = |report: &Report| report.bands[0].energy.iter().map(|e| e.mean[1]).fold(1.0, f64::min);
    assert!(dark(&after) > 0.5 * dark(&before), "only pairs with a bright end are scaled");
}

#[test]
fn isotropic_totals_are_scaled_below_one() {
    let values: Vec<f32> = (0..4096).map(|k: usize| if k >> 8 < 3 { 0.5 } else { 0.2 }).collect();
    let bsdf = one(Part::ReflectionBack, Tree::from_grid(Rank::Three, &values).unwrap().into());
    let (after, done) = repaired(&bsdf, &[Kind::Energy], Tolerance::default());
    assert_eq!(done.len(), 1);
    assert!(done[0].before > 1.5 && done[0].after < 1.0 + 1e-5, "{done:?}");
    let report = check(&after, Tolerance::default());
    assert!(report.is_ok());
}

#[test]
fn a_missing_isotropic_transmission_is_its_reverse() {
    // Light is bent towards the normal one way, so away from it on the way back.
    let values: Vec<f32> = (0..32768)
        .map(|k: usize| {
            let [a, b, c] = [k >> 10, k >> 5 & 31, k & 31].map(|c| (c as f32 + 0.5) / 32.0);
            if a < 0.5 { (-8.0 * ((b - 1.0 + 0.7 * a).powi(2) + (c - 0.5).powi(2))).exp() } else { 0.0 }
        })
        .collect();
    let bsdf = one(Part::TransmissionBack, Tree::from_grid(Rank::Three, &values).unwrap().into());
    let (after, done) = repaired(&bsdf, &[Kind::Sides], Tolerance::default());
    assert_eq!((done[0].before, done[0].after), (1.0, 2.0), "{done:?}");
    let report = check(&after, Tolerance::default()).bands.remove(0);
    assert!(report.reciprocity[0].mean < 0.02, "{:?}", report.reciprocity);
    let totals: Vec<f64> = report.energy.iter().map(|e| e.mean[1]).collect();
    assert!((totals[0] / totals[1] - 1.0).abs() < 0.01, "{totals:?}");
}

#[test]
fn lengths_in_millimetres_and_wavelengths_in_micrometres_are_mended() {
    let mut bsdf = one(Part::ReflectionBack, Tree::uniform(Rank::Four, 0.2).into());
    bsdf.header.width = Some(1200.0);
    bsdf.header.thickness = Some(0.8);
    bsdf.bands[0].name = "0.55".into();
    let (after, done) = fixed(&bsdf);
    assert_eq!([after.header.width, after.header.thickness], [Some(1.2), Some(0.0008)]);
    assert_eq!(after.bands[0].name, "550");
    assert_eq!(done.len(), 2, "{done:?}");
    assert_eq!(after.header.provenance.len(), 2);
    assert_eq!(fixed(&after).1, []);
}

#[test]
fn a_lawful_bsdf_is_left_alone() {
    let bsdf = one(Part::ReflectionBack, Tree::uniform(Rank::Four, 0.3).into());
    let (after, done) = fixed(&bsdf);
    assert_eq!(done, []);
    assert_eq!(after.header, bsdf.header);
}
