//! Two BSDFs held against each other: how far components are apart, and what one that has standard errors says of the other.
//!
//! In: what is open, and another file beside it. Out: JSON. Distances and totals are those that `bsdftree plot --kind compare` prints in Python; standard
//! errors those of `bsdftree info --errors`: the same trees with a standard error in place of each leaf's value, as `bsdftree fit --errors` writes them.

use bsdftree::convert::L1;
use bsdftree::direction::direction_from_polar;
use bsdftree::{Band, Bsdf, Direction, Lobes, Part, Scattering, Side, Tree};
use serde_json::{Value, json};

use crate::statistics::share;

/// What files of standard errors say of themselves.
const OF_ERRORS: &str = "Standard errors in place of values";

/// Leaves whose relative standard error is over this count as uncertain.
const UNCERTAIN: f64 = 0.25;

/// Polar angles at which totals of single directions are compared \[degree\].
const THETA_DEG: [f64; 18] =
    [0., 5., 10., 15., 20., 25., 30., 35., 40., 45., 50., 55., 60., 65., 70., 75., 80., 85.];

/// Rings of equal projected solid angle that evenly diffuse light comes from.
const N_RINGS: usize = 32;

/// Azimuths, between the symmetry planes of most devices.
const N_PHI: usize = 16;

/// How far components of one band are from those of another, counted in steps, since millions of leaves take seconds.
#[derive(Default)]
pub struct Comparison {
    /// Of the components that both have, as in [`Part::ALL`].
    l1: [L1; 4],
}

impl Comparison {
    /// Adds some points to the sums of distances; the part of all work that is done, 0 to 1.
    pub fn proceed(&mut self, one: &Band, other: &Band, n_points: u32) -> f64 {
        let both = |part: Part| Some((one.component(part)?, other.component(part)?));
        let pairs: Vec<_> = Part::ALL.into_iter().filter_map(|part| Some((part, both(part)?))).collect();
        let undone = pairs.iter().find(|(part, _)| self.l1[*part as usize].done() < 1.0);
        if let Some((part, (a, b))) = undone {
            self.l1[*part as usize].add(&a.luminance, &b.luminance, n_points);
        }
        let done: f64 = pairs.iter().map(|(part, _)| self.l1[*part as usize].done()).sum();
        if pairs.is_empty() { 1.0 } else { done / pairs.len() as f64 }
    }

    /// All that either band scatters, with what has been counted.
    pub fn differences(&self, one: &Band, other: &Band) -> Value {
        let parts = Part::ALL.into_iter().filter(|&part| scatters(one, part) || scatters(other, part));
        parts.map(|part| self.difference(one, other, part)).collect()
    }

    fn difference(&self, one: &Band, other: &Band, part: Part) -> Value {
        let l1 = one.component(part).and(other.component(part)).map(|_| self.l1[part as usize].relative());
        let by_direction = [one, other].map(|band| totals(band, part, &THETA_DEG));
        let apart: Vec<f64> = by_direction[1].iter().zip(&by_direction[0]).map(|(b, a)| b - a).collect();
        let worst = (0..apart.len()).fold(0, |k, j| if apart[j].abs() > apart[k].abs() { j } else { k });
        let squares: f64 = apart.iter().map(|d| d * d).sum();
        let [total_one, total_other] = [one, other].map(|band| diffuse(band, part));
        json!({
            "part": part.key(),
            // From a black one it is infinite: there is no such number in JSON.
            "relative_l1": l1.filter(|l1| l1.is_finite()),
            "totals": [total_one, total_other],
            "rms_total": (squares / apart.len() as f64).sqrt(),
            "worst_total": apart[worst],
            "worst_theta_deg": THETA_DEG[worst / N_PHI],
            "worst_phi_deg": phi_deg(worst % N_PHI),
        })
    }
}

/// Whether there is such a component, if only as the other one reversed.
fn scatters(band: &Band, part: Part) -> bool {
    band.answering(part.incident_side(), part.exitant_side()).is_some()
}

fn phi_deg(k: usize) -> f64 {
    (k as f64 + 0.5) * 360.0 / N_PHI as f64
}

/// Directional-hemispherical totals for light from rings of directions, one ring after the other.
fn totals(band: &Band, part: Part, theta_deg: &[f64]) -> Vec<f64> {
    let lobes = if part.is_reflection() { Lobes::Reflection } else { Lobes::Transmission };
    let incident: Vec<Direction> = theta_deg
        .iter()
        .flat_map(|theta| {
            (0..N_PHI).map(move |k| direction_from_polar(theta.to_radians(), phi_deg(k).to_radians()))
        })
        .map(|[x, y, z]| [x, y, part.incident_side().sign() * z])
        .collect();
    let mut totals = vec![0.0; incident.len()];
    band.hemispherical_many(&incident, lobes, &mut totals);
    totals
}

/// The fraction of evenly diffuse light that is scattered.
fn diffuse(band: &Band, part: Part) -> f64 {
    let ring = |k: usize| ((k as f64 + 0.5) / N_RINGS as f64).sqrt().asin().to_degrees();
    let theta_deg: Vec<f64> = (0..N_RINGS).map(ring).collect();
    let totals = totals(band, part, &theta_deg);
    totals.iter().sum::<f64>() / totals.len() as f64
}

/// Whether a file says that its values are standard errors.
pub fn says_errors(bsdf: &Bsdf) -> bool {
    bsdf.header.provenance.iter().any(|line| line.contains(OF_ERRORS))
}

/// Whether a file has standard errors, and those of this BSDF: its trees are cut into the same leaves.
pub fn are_errors_of(errors: &Bsdf, bsdf: &Bsdf) -> bool {
    let is_same = |band: &Band| {
        let known = errors.band(&band.name);
        band.components().all(|(part, component)| {
            let known =
                known.and_then(|known| trees(&component.luminance, &known.component(part)?.luminance));
            known.is_some_and(|[tree, known]| is_cut_as(tree, known))
        })
    };
    says_errors(errors) && !bsdf.bands.is_empty() && bsdf.bands.iter().all(is_same)
}

fn trees<'a>(one: &'a Scattering, other: &'a Scattering) -> Option<[&'a Tree; 2]> {
    match (one, other) {
        (Scattering::Tree(one), Scattering::Tree(other)) => Some([one, other]),
        _ => None,
    }
}

fn is_cut_as(one: &Tree, other: &Tree) -> bool {
    one.rank() == other.rank()
        && one.arena().n_leaves() == other.arena().n_leaves()
        && one.leaves().zip(other.leaves()).all(|(a, b)| (a.cell, a.level) == (b.cell, b.level))
}

/// How well each component is known, weighted by the light that is scattered if it comes evenly from everywhere: mean relative standard error,
/// and the share of light in leaves where it is over 25 %.
pub fn errors_by_flux(band: &Band, errors: &Band) -> Value {
    let known = band.components().filter_map(|(part, component)| {
        let [tree, errors] = trees(&component.luminance, &errors.component(part)?.luminance)?;
        let (mut flux, mut error, mut uncertain) = (0.0, 0.0, 0.0);
        for (leaf, known) in tree.leaves().zip(errors.leaves()) {
            let (share, value, sigma) = (share(tree, &leaf), f64::from(leaf.value), f64::from(known.value));
            flux += share * value;
            error += share * sigma;
            if sigma > UNCERTAIN * value {
                uncertain += share * value;
            }
        }
        let of_light = |part: f64| if flux > 0.0 { part / flux } else { 0.0 };
        Some(json!({ "part": part.key(), "mean": of_light(error), "uncertain": of_light(uncertain) }))
    });
    known.collect()
}

/// The standard error \[1/sr\] of what a pair of directions meets.
pub fn standard_error(errors: &Band, incident: Direction, exitant: Direction) -> Option<f64> {
    let (component, reversed) = errors.answering(Side::of(incident), Side::of(exitant))?;
    Some(component.luminance.eval(incident, exitant, reversed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdftree::{Component, Rank};

    fn bsdf(rank: Rank, value: impl Fn(usize) -> f32) -> Bsdf {
        let values: Vec<f32> = (0..1 << (2 * rank.dimensions())).map(value).collect();
        let mut bsdf = Bsdf::default();
        let tree = Tree::from_grid(rank, &values).unwrap();
        bsdf.band_mut("Visible").insert(Part::TransmissionBack, Component::grey(tree.into()));
        bsdf
    }

    fn differences(one: &Band, other: &Band) -> Value {
        let mut comparison = Comparison::default();
        while comparison.proceed(one, other, 10_000) < 1.0 {}
        comparison.differences(one, other)
    }

    #[test]
    fn of_itself_nothing_is_apart() {
        for rank in [Rank::Three, Rank::Four] {
            let one = bsdf(rank, |k| (k % 7) as f32 * 0.01);
            let found = differences(&one.bands[0], &one.bands[0]);
            // The transmission that is there, and the same one reversed.
            assert_eq!(found.as_array().unwrap().len(), 2);
            for row in found.as_array().unwrap() {
                assert_eq!(row["worst_total"], 0.0);
                assert_eq!(row["rms_total"], 0.0);
                assert_eq!(row["totals"][0], row["totals"][1]);
            }
            assert!(found[0]["relative_l1"].is_null(), "it is not in the file");
            assert_eq!(found[1]["relative_l1"], 0.0);
        }
    }

    #[test]
    fn a_tenth_more_light_is_a_tenth_apart() {
        let value = |k: usize| 0.01 + (k % 7) as f32 * 0.01;
        let [one, other] = [1.0, 1.1].map(|by| bsdf(Rank::Four, |k| by * value(k)));
        let row = &differences(&one.bands[0], &other.bands[0])[1];
        let number = |value: &Value| value.as_f64().unwrap();
        assert!((number(&row["relative_l1"]) - 0.1).abs() < 1e-5, "{row}");
        assert!((number(&row["totals"][1]) / number(&row["totals"][0]) - 1.1).abs() < 1e-5);
        let incident = direction_from_polar(
            number(&row["worst_theta_deg"]).to_radians(),
            number(&row["worst_phi_deg"]).to_radians(),
        );
        let totals = [one, other].map(|b| b.bands[0].hemispherical(incident, Lobes::Transmission));
        assert_eq!(number(&row["worst_total"]), totals[1] - totals[0]);
        assert!(number(&row["rms_total"]) <= number(&row["worst_total"]).abs());
    }

    #[test]
    fn errors_are_those_of_trees_that_are_cut_alike_and_say_so() {
        let one = bsdf(Rank::Four, |k| 1.0 + k as f32);
        let mut errors = bsdf(Rank::Four, |k| 0.1 * (1.0 + k as f32));
        assert!(!are_errors_of(&errors, &one), "it does not say so");
        errors.header.provenance.push(OF_ERRORS.into());
        assert!(are_errors_of(&errors, &one));
        assert!(!are_errors_of(&errors, &bsdf(Rank::Four, |_| 1.0)), "other leaves");
        assert!(!are_errors_of(&errors, &bsdf(Rank::Three, |k| k as f32)), "another rank");
        let known = &errors_by_flux(&one.bands[0], &errors.bands[0])[0];
        assert!((known["mean"].as_f64().unwrap() - 0.1).abs() < 1e-6, "{known}");
        assert_eq!(known["uncertain"], 0.0);
        let (incident, exitant) = ([0.48, 0.6, 0.64], [-0.6, 0.48, -0.64]);
        let error = standard_error(&errors.bands[0], incident, exitant).unwrap();
        assert!((error / one.bands[0].eval(incident, exitant) - 0.1).abs() < 1e-6);
    }
}
