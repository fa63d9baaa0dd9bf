//! Reciprocity of Klems matrices: f(i, o) averaged with f(o, i).

use std::sync::Arc;

use bsdftree::{Band, Basis, Component, Matrix, Part, Scattering, Side};

/// Averages reflections with themselves and the two transmissions with each other, travelled the other way.
pub(crate) fn make_reciprocal(band: &mut Band) -> Result<(), String> {
    for part in [Part::ReflectionFront, Part::ReflectionBack] {
        if let Some(component) = band.component(part).cloned() {
            band.insert(part, averaged(&component, &component)?);
        }
    }
    let [front, back] = [Part::TransmissionFront, Part::TransmissionBack].map(|p| band.component(p).cloned());
    if let (Some(front), Some(back)) = (front, back) {
        band.insert(Part::TransmissionFront, averaged(&front, &back)?);
        band.insert(Part::TransmissionBack, averaged(&back, &front)?);
    }
    Ok(())
}

fn averaged(a: &Component, b: &Component) -> Result<Component, String> {
    let chroma = match (&a.chroma, &b.chroma) {
        (Some([ax, az]), Some([bx, bz])) => Some([mean(ax, bx)?, mean(az, bz)?]),
        _ => None,
    };
    Ok(Component { luminance: mean(&a.luminance, &b.luminance)?, chroma })
}

fn mean(a: &Scattering, b: &Scattering) -> Result<Scattering, String> {
    let (Scattering::Matrix(a), Scattering::Matrix(b)) = (a, b) else {
        return Err("not a Klems matrix".into());
    };
    let basis = a.exitant();
    let n = basis.n_patches();
    let opposite: Vec<usize> = (0..n).map(|k| opposite(basis, k)).collect();
    let mut values = a.values().to_vec();
    for i in 0..n {
        for o in 0..n {
            // Incident patches are numbered by −incident: light to o arrives, travelled back, from the patch opposite o.
            values[i * n + o] = 0.5 * (a.values()[i * n + o] + b.values()[opposite[o] * n + opposite[i]]);
        }
    }
    Matrix::new(Arc::clone(basis), Arc::clone(basis), values).map(Scattering::from)
}

/// The patch that holds the middle of a patch turned by 180° about the normal.
fn opposite(basis: &Basis, patch: usize) -> usize {
    let [x, y] = basis.disk_point(patch, 0.5, 0.5);
    let turned = if basis.rings()[0].n_phi == 1 && patch == 0 { [0.0, 0.0] } else { [-x, -y] };
    basis.patch(Side::Front.direction_from_disk(turned))
}
