//! From counted paths to trees or matrices of a band, their standard errors, and how far they are from the truth.

use std::f64::consts::PI;
use std::sync::Arc;

use bsdftree::{Band, Basis, Component, Matrix, Part, Scattering, Side};
use rayon::prelude::*;

use crate::bands::Detector;
use crate::correction::{corrected, of_totals};
use crate::diffuse::Model;
use crate::errors::{MEAN_ABSOLUTE, STUDENT_95, Uncertainty, standard_error, uncertainty};
use crate::generate::GenerateError;
use crate::guard::{LEAST_TOTAL, guarded};
use crate::layout::Layout;
use crate::options::Options;
use crate::pyramid::Pyramid;
use crate::reciprocity::averaged;
use crate::reduce::{LAMBDA, Reducer};
use crate::scatter::Flux;
use crate::tally::{Exit, Row};
use crate::totals::Totals;

/// So many exits can be reduced while what leaves would be as nodes is remembered: some hundred bytes for each.
const REMEMBERED: usize = 1 << 20;

/// Counted paths of one side: reflected and transmitted rows, one for each incident cell.
pub(crate) struct Counted<S> {
    pub side: Side,
    pub rows: [Vec<Row<S>>; 2],
    /// Full paths of light that is diffused; where there is a model of it, it is not in `rows`.
    pub diffused: [Vec<Row<S>>; 2],
}

/// What follows from counted paths.
pub(crate) struct Estimated {
    pub band: Band,
    /// Standard errors, in the same form.
    pub errors: Band,
    /// See [`BandReport::error`](crate::BandReport::error).
    pub error: f64,
    /// See [`BandReport::direction_error`](crate::BandReport::direction_error).
    pub direction_error: f64,
    pub totals: Vec<Totals>,
}

/// How counted paths are made a BSDF.
pub(crate) struct Estimator<'a, S> {
    pub options: &'a Options,
    /// The band's name.
    pub band: &'a str,
    /// Of light that is diffused.
    pub model: Option<&'a dyn Fn(Part) -> Pyramid>,
    /// Full paths of it per incident cell.
    pub n_diffused: f64,
    pub reciprocity: bool,
    /// From sums to CIE X, Y, Z, where colour is asked for.
    pub xyz: Option<fn(S) -> [f64; 3]>,
    /// Paths per incident cell.
    pub n: f64,
}

/// Rows of one component, and the model of what is not in them.
struct Rows<'a, S> {
    diffused: &'a [Row<S>],
    model: Option<Pyramid>,
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

impl<S: Flux> Estimator<'_, S> {
    /// All components of the sides that were counted.
    pub fn estimated(&self, counted: &[Counted<S>]) -> Result<Estimated, GenerateError> {
        let [mut band, mut errors] = [(); 2].map(|()| Band::new(self.band));
        let (mut absolute, mut total, mut direction_error) = (0.0, 0.0, 0.0f64);
        let mut all_totals = Vec::new();
        for Counted { side, .. } in counted {
            let parts = [*side, side.opposite()].map(|toward| Part::between(*side, toward));
            let rows = parts.map(|part| self.rows(counted, part));
            let mut totals = [0, 1].map(|k| self.totals(parts[k], &rows[k]));
            let mean =
                totals.iter().flat_map(|t| &t.values).sum::<f64>() / (PI * totals[0].values.len() as f64);
            let headroom: Vec<f64> =
                totals[0].values.iter().zip(&totals[1].values).map(|(a, b)| 1.0 - a - b).collect();
            for ((part, rows), totals) in parts.into_iter().zip(rows).zip(&mut totals) {
                let estimate = match &self.options.layout {
                    Layout::Tree { .. } => self.trees(&rows, totals, &headroom, mean)?,
                    Layout::Klems(basis) => self.matrices(&rows, totals, basis)?,
                };
                band.insert(part, estimate.component);
                errors.insert(part, estimate.errors);
                absolute += estimate.absolute;
                total += estimate.total;
                direction_error = direction_error.max(estimate.direction_error);
            }
            all_totals.extend(totals);
        }
        let error = if total > 0.0 { absolute / total } else { 0.0 };
        Ok(Estimated { band, errors, error, direction_error, totals: all_totals })
    }

    /// The light that leaves from each incident cell.
    fn totals(&self, part: Part, rows: &Rows<'_, S>) -> Totals {
        let model = |i: usize| rows.model.as_ref().map(|m| (m, (i * m.n_cells() / rows.plain.len()) as u32));
        let value = |(i, row): (usize, &Row<S>)| {
            let counted = row.iter().map(|exit| exit.sum.luminance()).sum::<f64>() / self.n;
            counted + model(i).map_or(0.0, |(model, i)| PI * model.row(0, i, 0))
        };
        let error = |(i, row): (usize, &Row<S>)| {
            standard_error(row, self.n)
                .hypot(model(i).map_or(0.0, |(model, i)| PI * model.row_variance(i).sqrt()))
        };
        Totals {
            part,
            values: rows.plain.iter().enumerate().map(value).collect(),
            errors: rows.plain.iter().enumerate().map(error).collect(),
        }
    }

    fn rows<'c>(&self, counted: &'c [Counted<S>], part: Part) -> Rows<'c, S> {
        let k = usize::from(!part.is_reflection());
        let of = |side| counted.iter().find(|c| c.side == side).map(|c| c.rows[k].as_slice());
        let side = part.incident_side();
        let plain = of(side).expect("the side of the part was counted");
        // Light that was reflected goes back from the same side, light that was transmitted from the other one.
        let averaged = match (self.reciprocity, part.is_reflection(), of(side.opposite())) {
            (false, _, _) | (_, false, None) => None,
            (true, true, _) => Some(averaged(&self.options.layout, plain, None, self.n)),
            (true, false, other) => Some(averaged(&self.options.layout, plain, other, self.n)),
        };
        let diffused = counted.iter().find(|c| c.side == side).map_or(&[][..], |c| c.diffused[k].as_slice());
        let model = self.model.map(|model| model(part));
        Rows { plain, diffused, model, symmetric: averaged.is_some() && part.is_reflection(), averaged }
    }

    /// What a leaf costs, where `mean` is that of the BSDF \[1/sr\]: a difference of `detail` times the mean is kept from a size of one
    /// cell of a 2⁵ tree on.
    fn price(&self, mean: f64, log2_res: u32) -> f64 {
        LAMBDA * (self.options.detail() * mean).powi(2) * 16f64.powi(log2_res as i32 - 5)
    }

    fn trees(
        &self,
        rows: &Rows<'_, S>,
        totals: &mut Totals,
        headroom: &[f64],
        mean: f64,
    ) -> Result<Estimate, GenerateError> {
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
            price: self.price(mean, log2_res),
            model: rows.model.as_ref(),
            residual: false,
            remembers: rows.best().iter().map(Row::len).sum::<usize>() <= REMEMBERED,
        };
        let kept = reducer.cheapest();
        let (kept, deviations) = match self.options.pruned {
            true => guarded(&reducer, kept, totals, headroom, self.options.direction_tolerance),
            false => (kept, vec![0.0; totals.values.len()]),
        };
        let Uncertainty { mut errors, mut absolute, total } = uncertainty(&reducer, &kept);
        let mut kept = kept;
        if let Some(model) = &rows.model {
            let reducer = Reducer {
                rows: rows.diffused,
                n: self.n_diffused,
                symmetric: false,
                pruned: true,
                residual: true,
                remembers: false,
                price: 0.0,
                ..reducer
            };
            let residual = reducer.cheapest();
            let uncertain = uncertainty(&reducer, &residual);
            absolute = absolute.hypot(uncertain.absolute);
            [kept, errors] = corrected(&kept, &errors, &residual, &uncertain, model);
            let [more, noise] = of_totals(&reducer, &residual, &uncertain);
            totals.values.iter_mut().zip(more).for_each(|(total, more)| *total += more);
            totals.errors.iter_mut().zip(noise).for_each(|(error, noise)| *error = error.hypot(noise));
        }
        let trees = kept.trees(rank, self.xyz.is_some())?;
        let chroma = trees.chroma.map(|trees| trees.map(Scattering::from));
        Ok(Estimate {
            component: Component { luminance: trees.luminance.into(), chroma },
            errors: Component { luminance: errors.trees(rank, false)?.luminance.into(), chroma: None },
            absolute,
            total,
            direction_error: direction_error(totals, &deviations),
        })
    }

    fn matrices(
        &self,
        rows: &Rows<'_, S>,
        totals: &Totals,
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
            direction_error: direction_error(totals, &vec![0.0; totals.values.len()]),
            component: Component { luminance: luminance.into(), chroma },
            errors: Component { luminance: errors.into(), chroma: None },
        })
    }
}

/// The largest error of an incident cell's total: the tree's deviation from what was counted, or the noise of that.
fn direction_error(totals: &Totals, deviations: &[f64]) -> f64 {
    let errors = totals.errors.iter().zip(deviations).map(|(noise, off)| off.abs().max(STUDENT_95 * noise));
    errors.zip(&totals.values).map(|(error, total)| error / total.max(LEAST_TOTAL)).fold(0.0, f64::max)
}

/// The model of a part at all levels, of what a detector counts in a band.
pub(crate) fn pyramid<D: Detector>(
    model: &Model<D::Light>,
    part: Part,
    detector: &D,
    band: usize,
    color: bool,
) -> Pyramid {
    let n_channels = if color { D::Flux::CHANNELS } else { 1 };
    let share = |from: usize, to: usize| match color {
        true => detector.of_channel(from, band).channel(to),
        false => detector.of_channel(from, band).luminance(),
    };
    let n_cells = 1usize << (2 * model.log2());
    let mut channels: Vec<_> =
        (0..n_channels).map(|_| [(); 2].map(|()| vec![0.0f32; n_cells * n_cells])).collect();
    for from in 0..D::Light::CHANNELS {
        let shares: Vec<f32> = (0..n_channels).map(|to| share(from, to) as f32).collect();
        if shares.iter().all(|&share| share == 0.0) {
            continue;
        }
        let found = model.estimates(part, from).expect("walks from both sides");
        for (channel, &share) in channels.iter_mut().zip(&shares).filter(|(_, share)| **share != 0.0) {
            for (sums, found) in channel.iter_mut().zip(&found) {
                sums.par_iter_mut().zip(found).for_each(|(sum, new)| *sum += share * new);
            }
        }
    }
    let unit = |k: usize| D::Flux::from_channels(|c| f64::from(u8::from(c == k))).luminance();
    let luminances = if color { (0..n_channels).map(unit).collect() } else { vec![1.0] };
    Pyramid::new(model.log2(), channels, luminances)
}
