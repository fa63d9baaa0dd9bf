//! Layers one behind the other, as glazing with a shade, with all light that goes to and fro between them.
//!
//! In: the BSDFs of layers from the outside to the room. Out: that of the stack, all four components. For two layers 1 (outside) and 2,
//! with K = f·Λ (rows incident, columns exitant, Λ the projected solid angle of the exitant cell), light of a direction taken
//! as row vectors of flux:
//!
//! Tf = T1f S T2f, Rf = R1f + T1f S R2f T1b, Tb = T2b S′ T1b, Rb = R2b + T2b S′ R1b T2f, S = (I − R2f R1b)⁻¹, S′ = (I − R1b R2f)⁻¹.
//!
//! Source: J. H. Klems, "A new method for predicting the solar heat gain of complex fenestration systems", ASHRAE Transactions 100, 1994.
//!
//! Assumed as there: light leaves a cell evenly over all of it, so a peak widens by up to a cell at each layer; layers are wide beside
//! their distance. Colour is followed as Radiance's red, green and blue.

use std::sync::Arc;

use super::grow::Grower;
use super::matrix::matrix;
use super::operator::{Layer, Operator};
use super::rows::from_rows;
use super::{ConvertError, xyz};
use crate::bsdf::{Band, Bsdf, Component, Part, Scattering};
use crate::color::{rgb_from_xyz, xyz_from_rgb};
use crate::klems::{Basis, Matrix};
use crate::tree::{Rank, Tree};

/// Finest trees that are stacked: matrices of 4096 × 4096.
pub const MAX_STACK_LOG2_RES: u32 = 6;

/// Over what cells layers are stacked.
#[derive(Clone, Debug)]
pub enum StackDomain {
    /// The patches of a basis.
    Klems(Arc<Basis>),
    /// The cells of rank-4 trees of 2^log2_res per axis, at most [`MAX_STACK_LOG2_RES`]; `tolerance` as in
    /// [`TreeOptions`](super::TreeOptions).
    Tree {
        /// 2^log2_res cells per axis.
        log2_res: u32,
        /// Relative L1 error that joining cells may add.
        tolerance: f64,
    },
}

/// The BSDF of layers, the first one outside, the last one towards the room. Bands that all of them have.
///
/// # Errors
/// If there is no layer or no common band, a tree cannot be had over the domain, or layers reflect all light between them.
pub fn stack(layers: &[&Bsdf], domain: &StackDomain) -> Result<Bsdf, ConvertError> {
    let [first, others @ ..] = layers else { return Err(ConvertError::NoLayers) };
    domain.check()?;
    let mut made = Bsdf::default();
    let names: Vec<_> = layers.iter().map(|layer| layer.header.name.as_str()).collect();
    made.header.name = names.join(" + ");
    made.header.unit = first.header.unit;
    made.header.thickness = layers.iter().map(|layer| layer.header.thickness).sum();
    (made.header.width, made.header.height) = (first.header.width, first.header.height);
    for band in &first.bands {
        let bands: Option<Vec<&Band>> =
            std::iter::once(Some(band)).chain(others.iter().map(|layer| layer.band(&band.name))).collect();
        if let Some(bands) = bands {
            made.bands.push(stacked_band(&bands, domain)?);
        }
    }
    if made.bands.is_empty() { Err(ConvertError::NoCommonBand) } else { Ok(made) }
}

fn stacked_band(bands: &[&Band], domain: &StackDomain) -> Result<Band, ConvertError> {
    let is_coloured = bands.iter().any(|band| band.components().any(|(_, c)| c.chroma.is_some()));
    let areas = domain.areas();
    let mut channels: Vec<Layer> = Vec::new();
    for (k, band) in bands.iter().enumerate() {
        let layer = domain.layer(band, is_coloured, &areas)?;
        channels = match k {
            0 => layer,
            _ => channels.iter().zip(&layer).map(|(a, b)| a.followed_by(b)).collect::<Result<_, _>>()?,
        };
    }
    let mut made = Band::new(&bands[0].name);
    for part in Part::ALL {
        let operators: Vec<&Operator> = channels.iter().map(|layer| &layer.parts[part as usize]).collect();
        if operators.iter().all(|operator| operator.values.iter().all(|&v| v == 0.0)) {
            continue;
        }
        let component = match operators[..] {
            [r, g, b] => {
                let mut xyz = [r.clone(), g.clone(), b.clone()];
                for k in 0..r.values.len() {
                    let mixed = xyz_from_rgb([r.values[k], g.values[k], b.values[k]]);
                    xyz.iter_mut().zip(mixed).for_each(|(operator, v)| operator.values[k] = v);
                }
                let [x, y, z] = xyz.map(|operator| domain.function(&operator, &areas));
                xyz::from_channels([x?, y?, z?])?
            }
            _ => Component::grey(domain.function(operators[0], &areas)?),
        };
        made.insert(part, component);
    }
    Ok(made)
}

impl StackDomain {
    /// An error if layers are not stacked over it.
    pub(super) fn check(&self) -> Result<(), ConvertError> {
        match *self {
            StackDomain::Tree { log2_res, .. } if !(1..=MAX_STACK_LOG2_RES).contains(&log2_res) => {
                Err(ConvertError::StackResolution(log2_res))
            }
            StackDomain::Tree { tolerance, .. } if !(0.0..1.0).contains(&tolerance) => {
                Err(ConvertError::Tolerance(tolerance))
            }
            _ => Ok(()),
        }
    }

    /// Projected solid angles of all cells \[sr\].
    pub(super) fn areas(&self) -> Vec<f64> {
        match self {
            StackDomain::Klems(basis) => {
                (0..basis.n_patches()).map(|k| basis.projected_solid_angle(k)).collect()
            }
            StackDomain::Tree { log2_res, .. } => {
                let n = 1usize << (2 * log2_res);
                vec![std::f64::consts::PI / n as f64; n]
            }
        }
    }

    /// The four operators of a band: one set, or with colour one for each of red, green and blue.
    pub(super) fn layer(
        &self,
        band: &Band,
        is_coloured: bool,
        areas: &[f64],
    ) -> Result<Vec<Layer>, ConvertError> {
        let n = areas.len();
        let black = || Layer { parts: std::array::from_fn(|_| Operator { n, values: vec![0.0; n * n] }) };
        let mut layers = if is_coloured { vec![black(), black(), black()] } else { vec![black()] };
        for part in Part::ALL {
            let Some((component, reversed)) = band.answering(part.incident_side(), part.exitant_side())
            else {
                continue;
            };
            let functions = match (is_coloured, xyz::channels(component)?) {
                (false, _) => vec![component.luminance.clone()],
                (true, Some(xyz)) => xyz.into(),
                (true, None) => vec![component.luminance.clone(); 3],
            };
            let mut values = Vec::new();
            for function in &functions {
                values.push(self.values(function, reversed)?);
            }
            for k in 0..n * n {
                let light: Vec<f64> = match values[..] {
                    [ref x, ref y, ref z] => {
                        rgb_from_xyz([x[k], y[k], z[k]].map(f64::from)).map(|v| v.max(0.0)).into()
                    }
                    _ => vec![f64::from(values[0][k])],
                };
                for (layer, light) in layers.iter_mut().zip(light) {
                    layer.parts[part as usize].values[k] = light * areas[k % n];
                }
            }
        }
        Ok(layers)
    }

    /// Values over incident and exitant cells.
    fn values(&self, function: &Scattering, reversed: bool) -> Result<Vec<f32>, ConvertError> {
        match self {
            StackDomain::Klems(basis) => {
                let made = matrix(function, basis);
                Ok(if reversed { made.reversed().values().to_vec() } else { made.values().to_vec() })
            }
            StackDomain::Tree { log2_res, .. } => {
                let tree: Tree = super::tree::tree(function, Rank::Four, *log2_res, 0.0)?;
                let mut values = tree.to_grid(*log2_res);
                if reversed {
                    // f(i, o) → f(1 − o, 1 − i).
                    let n = 1usize << (2 * log2_res);
                    values = (0..n * n).map(|k| values[(n - 1 - k % n) * n + (n - 1 - k / n)]).collect();
                }
                Ok(values)
            }
        }
    }

    /// An operator as a function of directions.
    fn function(&self, operator: &Operator, areas: &[f64]) -> Result<Scattering, ConvertError> {
        let n = operator.n;
        let value = |k: usize| (operator.values[k] / areas[k % n]).max(0.0);
        match self {
            StackDomain::Klems(basis) => {
                let values = (0..n * n).map(|k| value(k) as f32).collect();
                let matrix = Matrix::new(Arc::clone(basis), Arc::clone(basis), values);
                matrix.map(Scattering::from).map_err(ConvertError::Values)
            }
            &StackDomain::Tree { log2_res, tolerance } => {
                let mean = (0..n * n).map(value).sum::<f64>() / (n * n) as f64;
                let mut grower = Grower::new(Rank::Four, tolerance, mean);
                let root = from_rows(log2_res, &mut grower, &mut |[x, y]| {
                    let row = ((x as usize) << log2_res | y as usize) * n;
                    (row..row + n).map(value).collect()
                })?;
                Ok(grower.finish(root).into())
            }
        }
    }
}

/// What layers are stacked over if nothing else is asked for: trees of rank 4 over the cells of the finest one, up to 2^5; otherwise over
/// the first angle basis there is, or Klems Full.
pub fn default_domain(layers: &[&Bsdf]) -> StackDomain {
    let functions = || {
        layers
            .iter()
            .flat_map(|l| &l.bands)
            .flat_map(Band::components)
            .map(|(_, component)| &component.luminance)
    };
    let all_rank_4 = functions().all(|f| matches!(f, Scattering::Tree(tree) if tree.rank() == Rank::Four));
    if all_rank_4 {
        let depth = |f: &Scattering| match f {
            Scattering::Tree(tree) => tree.arena().log2_res(),
            Scattering::Matrix(_) => 0,
        };
        return StackDomain::Tree {
            log2_res: functions().map(depth).max().unwrap_or(1).clamp(1, 5),
            tolerance: 0.0,
        };
    }
    let basis = functions().find_map(|f| match f {
        Scattering::Matrix(matrix) => Some(Arc::clone(matrix.incident())),
        Scattering::Tree(_) => None,
    });
    StackDomain::Klems(basis.unwrap_or_else(|| Arc::new(Basis::full())))
}
