//! From counted paths to trees or matrices, their standard errors, and how far they are from the truth.

use std::sync::Arc;

use bsdftree::{Basis, Bsdf, Component, Matrix, Part, Scattering, Side};

use crate::errors::{MEAN_ABSOLUTE, STUDENT_95, Uncertainty, standard_error, uncertainty};
use crate::generate::GenerateError;
use crate::guard::{LEAST_TOTAL, guarded};
use crate::layout::Layout;
use crate::options::Options;
use crate::reciprocity::averaged;
use crate::reduce::Reducer;
use crate::scatter::Spectrum;
use crate::tally::{Exit, Row};

/// Counted paths of one side: reflected and transmitted rows, one for each incident cell.
pub(crate) struct Counted<S> {
    pub side: Side,
    pub rows: [Vec<Row<S>>; 2],
}

/// What follows from counted paths.
pub(crate) struct Estimated {
    pub bsdf: Bsdf,
    /// Standard errors, in the same form.
    pub errors: Bsdf,
    /// See [`Report::error`](crate::Report::error).
    pub error: f64,
    /// See [`Report::direction_error`](crate::Report::direction_error).
    pub direction_error: f64,
}

/// How counted paths are made a BSDF.
pub(crate) struct Estimator<'a, S> {
    pub options: &'a Options,
    pub reciprocity: bool,
    /// From sums to CIE X, Y, Z, where colour is asked for.
    pub xyz: Option<fn(S) -> [f64; 3]>,
    /// Paths per incident cell.
    pub n: f64,
}

/// Rows of one component.
struct Rows<'a, S> {
    /// As counted.
    plain: &'a [Row<S>],
    /// Averaged with what travelled the other way.
    averaged: Option<Vec<Row<S>>>,
    /// Whether that are the same rows.
    symmetric: bool,
}

impl<S> Rows<'_, S> {
    fn best(&self) -> &[Row<S>] {
        self.averaged.as_deref().unwrap_or(self.plain)
    }
}

/// One component and what is wrong with it.
struct Estimate {
    component: Component,
    errors: Component,
    /// Σ of the expected |error|, and of the BSDF.
    absolute: f64,
    total: f64,
    direction_error: f64,
}

impl<S: Spectrum> Estimator<'_, S> {
    /// All components of the sides that were counted.
    pub fn estimated(&self, counted: &[Counted<S>], mut bsdf: Bsdf) -> Result<Estimated, GenerateError> {
        let mut errors = bsdf.clone();
        let (mut absolute, mut total, mut direction_error) = (0.0, 0.0, 0.0f64);
        for Counted { side, rows: [reflected, transmitted] } in counted {
            let totals = [reflected, transmitted].map(|rows| self.totals(rows));
            let headroom: Vec<f64> = totals[0].iter().zip(&totals[1]).map(|(a, b)| 1.0 - a - b).collect();
            for (toward, totals) in [*side, side.opposite()].into_iter().zip(&totals) {
                let part = Part::between(*side, toward);
                let rows = self.rows(counted, part);
                let estimate = match &self.options.layout {
                    Layout::Tree { .. } => self.trees(&rows, totals, &headroom)?,
                    Layout::Klems(basis) => self.matrices(&rows, totals, basis)?,
                };
                bsdf.band_mut("Visible").insert(part, estimate.component);
                errors.band_mut("Visible").insert(part, estimate.errors);
                absolute += estimate.absolute;
                total += estimate.total;
                direction_error = direction_error.max(estimate.direction_error);
            }
        }
        let error = if total > 0.0 { absolute / total } else { 0.0 };
        Ok(Estimated { bsdf, errors, error, direction_error })
    }

    /// The light that left from each incident cell.
    fn totals(&self, rows: &[Row<S>]) -> Vec<f64> {
        rows.iter().map(|row| row.iter().map(|exit| exit.sum.luminance()).sum::<f64>() / self.n).collect()
    }

    fn rows<'c>(&self, counted: &'c [Counted<S>], part: Part) -> Rows<'c, S> {
        let k = usize::from(!part.is_reflection());
        let of = |side| counted.iter().find(|c| c.side == side).map(|c| c.rows[k].as_slice());
        let side = part.incident_side();
        let plain = of(side).expect("the side of the part was counted");
        // Light that was reflected goes back from the same side, light that was transmitted from the other one.
        let other = of(if part.is_reflection() { side } else { side.opposite() });
        let averaged = other
            .filter(|_| self.reciprocity)
            .map(|other| averaged(&self.options.layout, plain, other, self.n));
        Rows { plain, symmetric: averaged.is_some() && part.is_reflection(), averaged }
    }

    fn trees(&self, rows: &Rows<'_, S>, totals: &[f64], headroom: &[f64]) -> Result<Estimate, GenerateError> {
        let Layout::Tree { rank, log2_res } = self.options.layout else { unreachable!("not a tree") };
        let reducer = Reducer {
            rank,
            log2_res,
            rows: rows.best(),
            n: self.n,
            omega: self.options.layout.exitant_area(0),
            symmetric: rows.symmetric,
            pruned: self.options.pruned,
            xyz: self.xyz,
        };
        let kept = reducer.cheapest();
        let (kept, deviations) = match self.options.pruned {
            true => guarded(&reducer, kept, totals, headroom, self.options.direction_tolerance),
            false => (kept, vec![0.0; totals.len()]),
        };
        let Uncertainty { errors, absolute, total } = uncertainty(&reducer, &kept);
        let trees = kept.trees(rank, self.xyz.is_some())?;
        let chroma = trees.chroma.map(|trees| trees.map(Scattering::from));
        Ok(Estimate {
            component: Component { luminance: trees.luminance.into(), chroma },
            errors: Component { luminance: errors.trees(rank, false)?.luminance.into(), chroma: None },
            absolute,
            total,
            direction_error: self.direction_error(rows.plain, totals, &deviations),
        })
    }

    fn matrices(
        &self,
        rows: &Rows<'_, S>,
        totals: &[f64],
        basis: &Arc<Basis>,
    ) -> Result<Estimate, GenerateError> {
        let areas: Vec<f64> = (0..basis.n_patches()).map(|k| basis.projected_solid_angle(k)).collect();
        let matrix = |value: &dyn Fn(&Exit<S>) -> f64| {
            let mut values = vec![0.0f32; areas.len() * areas.len()];
            for (row, exits) in values.chunks_exact_mut(areas.len()).zip(rows.best()) {
                for exit in exits {
                    row[exit.cell as usize] = (value(exit) / areas[exit.cell as usize]) as f32;
                }
            }
            Matrix::new(Arc::clone(basis), Arc::clone(basis), values).map_err(GenerateError::Matrix)
        };
        let luminance = matrix(&|exit| exit.sum.luminance() / self.n)?;
        let errors = matrix(&|exit| standard_error([exit], self.n))?;
        let chroma = match self.xyz {
            None => None,
            Some(xyz) => {
                let channel = |k: usize| matrix(&|exit| xyz(exit.sum)[k] / self.n).map(Scattering::from);
                Some([channel(0)?, channel(2)?])
            }
        };
        // Both directions weigh by their projected solid angles.
        let sum = |matrix: &Matrix| -> f64 {
            let rows = matrix.values().chunks_exact(areas.len()).zip(&areas);
            rows.map(|(row, i)| i * row.iter().zip(&areas).map(|(v, o)| o * f64::from(*v)).sum::<f64>()).sum()
        };
        Ok(Estimate {
            absolute: MEAN_ABSOLUTE * sum(&errors),
            total: sum(&luminance),
            direction_error: self.direction_error(rows.plain, totals, &vec![0.0; totals.len()]),
            component: Component { luminance: luminance.into(), chroma },
            errors: Component { luminance: errors.into(), chroma: None },
        })
    }

    /// The largest error of an incident cell's total: the tree's deviation from what was counted, or the noise of that.
    fn direction_error(&self, rows: &[Row<S>], totals: &[f64], deviations: &[f64]) -> f64 {
        let noises = rows.iter().map(|row| STUDENT_95 * standard_error(row, self.n));
        let errors = noises.zip(deviations).map(|(noise, deviation)| deviation.abs().max(noise));
        errors.zip(totals).map(|(error, total)| error / total.max(LEAST_TOTAL)).fold(0.0, f64::max)
    }
}
