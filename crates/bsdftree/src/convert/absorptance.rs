//! What each layer of a stack absorbs, with all light that goes to and fro.
//!
//! In: the BSDFs of layers from the outside to the room, as for [`stack`](super::stack()). Out: of light from each incident cell of either side, the
//! fraction that is left in each layer. With what the whole stack transmits and reflects they sum to 1. A layer absorbs what it neither
//! transmits nor reflects of the light that arrives at its two faces; that is found by parting the stack before the layer and behind it.

use super::operator::{Layer, Operator};
use super::{ConvertError, StackDomain};
use crate::bsdf::{Bsdf, Part};

/// What a layer absorbs, of light from each incident cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Absorptance {
    /// Of light from the outside.
    pub front: Vec<f64>,
    /// Of light from the room.
    pub back: Vec<f64>,
}

/// What each layer absorbs in the stack, of the luminance channel of a band. Where a file has more light than came, less than 0.
///
/// # Errors
/// If there is no layer, one lacks the band, or as for [`stack`](super::stack()).
pub fn layer_absorptances(
    layers: &[&Bsdf],
    band: &str,
    domain: &StackDomain,
) -> Result<Vec<Absorptance>, ConvertError> {
    domain.check()?;
    let areas = domain.areas();
    let mut alone: Vec<Layer> = Vec::new();
    for layer in layers {
        let band = layer.band(band).ok_or(ConvertError::NoCommonBand)?;
        alone.extend(domain.layer(band, false, &areas)?);
    }
    if alone.is_empty() {
        return Err(ConvertError::NoLayers);
    }
    let last = alone.len() - 1;
    // `inner[k]`: layer k with all behind it; `outer`: all before layer k; `with`: that and layer k.
    let mut inner = vec![alone[last].clone()];
    for layer in alone[..last].iter().rev() {
        inner.push(layer.followed_by(&inner[inner.len() - 1])?);
    }
    inner.reverse();
    let mut outer: Option<Layer> = None;
    let mut found = Vec::new();
    for (k, layer) in alone.iter().enumerate() {
        let with = match &outer {
            Some(outer) => outer.followed_by(layer)?,
            None => layer.clone(),
        };
        let behind = inner.get(k + 1);
        let before_it = outer.as_ref().map(|outer| outer.between(&inner[k])).transpose()?;
        let behind_it = behind.map(|behind| with.between(behind)).transpose()?;
        let [at_front, at_back] = absorbed_alone(layer);
        let arriving = |light: Option<&Operator>, absorbed: &[f64]| match light {
            Some(light) => light.apply(absorbed),
            None => absorbed.to_vec(),
        };
        let mut front = arriving(before_it.as_ref().map(|gap| &gap.inward), &at_front);
        if let (Some(gap), Some(behind)) = (&behind_it, behind) {
            add(&mut front, &gap.inward.apply(&behind.part(Part::ReflectionFront).apply(&at_back)));
        }
        let mut back = arriving(behind_it.as_ref().map(|gap| &gap.outward), &at_back);
        if let (Some(gap), Some(outer)) = (&before_it, &outer) {
            add(&mut back, &gap.outward.apply(&outer.part(Part::ReflectionBack).apply(&at_front)));
        }
        found.push(Absorptance { front, back });
        outer = Some(with);
    }
    Ok(found)
}

/// What a layer absorbs of light that arrives at its front and at its back.
fn absorbed_alone(layer: &Layer) -> [Vec<f64>; 2] {
    let left = |transmission: Part, reflection: Part| {
        let totals = [transmission, reflection].map(|part| layer.part(part).totals());
        totals[0].iter().zip(&totals[1]).map(|(t, r)| 1.0 - t - r).collect()
    };
    [left(Part::TransmissionFront, Part::ReflectionFront), left(Part::TransmissionBack, Part::ReflectionBack)]
}

fn add(sum: &mut [f64], more: &[f64]) {
    sum.iter_mut().zip(more).for_each(|(a, b)| *a += b);
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::klems::{Basis, Matrix};
    use crate::{Band, Component};

    /// Even scattering over all patches, so that totals are those of a chain of grey plates.
    fn plate(basis: &Arc<Basis>, [tf, tb, rf, rb]: [f64; 4]) -> Bsdf {
        let mut band = Band::new("Solar");
        let n = basis.n_patches() * basis.n_patches();
        let parts = [
            (Part::TransmissionFront, tf),
            (Part::TransmissionBack, tb),
            (Part::ReflectionFront, rf),
            (Part::ReflectionBack, rb),
        ];
        for (part, total) in parts {
            let values = vec![(total / std::f64::consts::PI) as f32; n];
            let matrix = Matrix::new(Arc::clone(basis), Arc::clone(basis), values).unwrap();
            band.insert(part, Component::grey(matrix.into()));
        }
        Bsdf { bands: vec![band], ..Bsdf::default() }
    }

    #[test]
    fn absorptances_are_those_of_grey_plates() {
        let basis = Arc::new(Basis::quarter());
        let domain = StackDomain::Klems(Arc::clone(&basis));
        let (a, b) = ([0.5, 0.4, 0.3, 0.2], [0.6, 0.7, 0.1, 0.25]);
        let plates = [a, b].map(|plate_of| plate(&basis, plate_of));
        let found = layer_absorptances(&plates.each_ref(), "Solar", &domain).unwrap();
        // One gap: 1/(1 − R1b R2f) of what enters it.
        let gap = 1.0 / (1.0 - 0.2 * 0.1);
        let expected = [
            (1.0 - 0.5 - 0.3 + 0.5 * gap * 0.1 * (1.0 - 0.4 - 0.2), 0.7 * gap * (1.0 - 0.4 - 0.2)),
            (0.5 * gap * (1.0 - 0.6 - 0.1), 1.0 - 0.7 - 0.25 + 0.7 * gap * 0.2 * (1.0 - 0.6 - 0.1)),
        ];
        for (found, (front, back)) in found.iter().zip(expected) {
            assert!(found.front.iter().all(|v| (v - front).abs() < 1e-6), "{front} {found:?}");
            assert!(found.back.iter().all(|v| (v - back).abs() < 1e-6), "{back} {found:?}");
        }
    }

    #[test]
    fn all_light_is_transmitted_reflected_or_absorbed() {
        let basis = Arc::new(Basis::quarter());
        let domain = StackDomain::Klems(Arc::clone(&basis));
        let plates =
            [[0.5, 0.4, 0.3, 0.2], [0.6, 0.7, 0.1, 0.25], [0.1, 0.3, 0.8, 0.6], [0.9, 0.2, 0.0, 0.7]]
                .map(|plate_of| plate(&basis, plate_of));
        let layers = plates.each_ref();
        let whole = super::super::stack(&layers, &domain).unwrap();
        let [at_front, at_back] =
            absorbed_alone(&domain.layer(whole.band("Solar").unwrap(), false, &domain.areas()).unwrap()[0]);
        let found = layer_absorptances(&layers, "Solar", &domain).unwrap();
        let sum = |side: fn(&Absorptance) -> &Vec<f64>| -> f64 { found.iter().map(|a| side(a)[7]).sum() };
        assert!((sum(|a| &a.front) - at_front[7]).abs() < 1e-6);
        assert!((sum(|a| &a.back) - at_back[7]).abs() < 1e-6);
    }
}
