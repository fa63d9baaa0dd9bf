//! Colours that no light has, moved towards white until light can have them.

use crate::bsdf::{Component, Scattering};
use crate::color::{uv_from_xyz, xyz_from_yuv};
use crate::convert::combined;
use crate::klems::Matrix;
use crate::locus::possible;

/// A component of possible colours; `None` if it has no colour, or its trees are too large together.
pub(super) fn clipped(component: &Component) -> Option<Component> {
    let chroma = component.chroma.as_ref()?;
    let luminance = component.luminance.clone();
    let chroma = match (&component.luminance, chroma) {
        (Scattering::Tree(_), [Scattering::Tree(u), Scattering::Tree(v)]) => {
            let made = |k: usize| combined([u, v, v], &move |[u, v, _]: [f64; 3]| possible([u, v])[k]);
            [made(0).ok()?.into(), made(1).ok()?.into()]
        }
        (Scattering::Matrix(y), [Scattering::Matrix(x), Scattering::Matrix(z)]) => {
            let xyz = |k: usize| [x, y, z].map(|matrix| f64::from(matrix.values()[k]));
            let clipped = |k: usize| {
                let (xyz, uv) = (xyz(k), uv_from_xyz(xyz(k)));
                let to = possible(uv);
                if to == uv { xyz } else { xyz_from_yuv(xyz[1], to) }
            };
            let made = |channel: usize| {
                let values = (0..y.values().len()).map(|k| clipped(k)[channel].max(0.0) as f32).collect();
                let made = Matrix::new(y.incident().clone(), y.exitant().clone(), values);
                Scattering::from(made.expect("as many finite values, not negative"))
            };
            [made(0), made(2)]
        }
        _ => return None,
    };
    Some(Component { luminance, chroma: Some(chroma) })
}
