//! How far a fitted value may be off: a standard error for any pair of directions.
//!
//! * **Between incident directions**: |f̂ − f| of scans predicted from the others, relative to f̂, as 68 % quantiles (by flux) over how much the
//!   blended scans differ there. Leaving a scan out doubles the distance to the next, so this errs on the safe side.
//! * **Between exitant directions**: the same of points predicted from their neighbours within a scan, by value.
//! * **Noise**: errors that came with the measurement, blended with the squares of the weights.
//! * **Outside** what was measured nothing is known: the error rises with the distance to it.

use rayon::prelude::*;

use crate::blend::Layers;
use crate::choose;
use crate::gridded::Gridded;
use crate::progress::{Progress, Stopped};
use crate::residual::{Blended, Residual};
use crate::swapped::Swap;

/// Relative error for each unit of distance on the disk outside the measured incident directions: 0.1 is 8° near the normal.
const PER_DISTANCE: f64 = 3.0;

/// Relative error where no exitant direction was measured nearby.
const UNCOVERED: f64 = 0.5;

/// How far two scans of equal weight are apart from both.
const HALFWAY: f64 = 0.5;

/// Bins of a table.
const N_BINS: usize = 10;

/// Share of errors below one standard error.
const ONE_SIGMA: f64 = 0.683;

/// Relative error by a quantity: middles of bins and quantiles.
#[derive(Clone, Debug, Default)]
struct Table {
    at: Vec<f64>,
    error: Vec<f64>,
}

impl Table {
    /// Of (quantity, relative error, flux).
    fn new(mut samples: Vec<(f64, f64, f64)>) -> Table {
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all: f64 = samples.iter().map(|s| s.2).sum();
        let mut table = Table::default();
        let (mut bin, mut flux) = (Vec::new(), 0.0);
        let n_bins = N_BINS.min(samples.len() / 20).max(1);
        for sample in samples {
            flux += sample.2;
            bin.push(sample);
            if flux >= all / n_bins as f64 {
                table.close(&mut bin);
                flux = 0.0;
            }
        }
        table.close(&mut bin);
        table
    }

    fn close(&mut self, bin: &mut Vec<(f64, f64, f64)>) {
        if bin.is_empty() {
            return;
        }
        let flux: f64 = bin.iter().map(|s| s.2).sum();
        self.at.push(bin.iter().map(|s| s.0 * s.2).sum::<f64>() / flux.max(1e-30));
        bin.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut below = 0.0;
        let quantile = bin.iter().find(|s| {
            below += s.2;
            below >= ONE_SIGMA * flux
        });
        self.error.push(quantile.or(bin.last()).expect("not empty").1);
        bin.clear();
    }

    fn value(&self, x: f64) -> f64 {
        let k = self.at.partition_point(|&at| at < x);
        match (k.checked_sub(1), self.at.get(k)) {
            (_, None) => self.error.last().copied().unwrap_or(0.0),
            (None, _) => self.error[0],
            (Some(j), Some(_)) => {
                let t = (x - self.at[j]) / (self.at[k] - self.at[j]).max(1e-30);
                self.error[j] + t * (self.error[k] - self.error[j])
            }
        }
    }
}

/// What is known of errors of a part.
#[derive(Clone, Debug)]
pub(crate) struct Uncertainty {
    /// By the spread of logarithms; empty if no scan could be left out.
    between: Option<Table>,
    /// By value.
    within: Table,
    /// Below this values are as uncertain as this one \[1/sr\].
    floor: f64,
}

impl Uncertainty {
    pub fn new(
        scans: &[Gridded],
        layers: &Layers,
        line: bool,
        swap: Option<&Swap<'_>>,
        progress: &Progress,
    ) -> Result<Uncertainty, Stopped> {
        let channel = scans[0].main();
        let mean =
            scans.iter().map(|s| s.totals[channel]).sum::<f64>() / scans.len() as f64 / std::f64::consts::PI;
        let floor = 0.02 * mean;
        let relative = |r: &Residual| {
            let value = f64::from(r.predicted.value);
            let error = f64::from((r.predicted.value - r.measured).abs()) / value.max(floor);
            (error, value.max(floor) * f64::from(r.weight))
        };
        let sample = |by: f32, r: &Residual| {
            let (error, flux) = relative(r);
            (f64::from(by), error, flux)
        };
        let left_out = choose::left_out(scans, line).into_par_iter().map(|k| {
            progress.go_on()?;
            Ok(choose::residuals(scans, layers, line, swap, k))
        });
        let between = left_out.collect::<Result<Vec<_>, _>>()?;
        let between: Vec<_> = between.iter().flatten().map(|r| sample(r.predicted.spread, r)).collect();
        let step = scans.len().div_ceil(24);
        let held_out = scans.par_iter().step_by(step).map(|scan| {
            progress.go_on()?;
            Ok(scan.held_out())
        });
        let within = held_out.collect::<Result<Vec<_>, _>>()?;
        let within = within.iter().flatten().map(|r| sample(r.predicted.value, r));
        let within = Table::new(within.collect());
        let between = (!between.is_empty()).then(|| Table::new(between));
        Ok(Uncertainty { between, within, floor })
    }

    /// Of a blended value, `apart` from scans ([`crate::blend::Slice::apart`]), `outside` the measured incident directions, `covered` by measured exitant directions or not, with noise of its own.
    pub fn error(&self, blended: Blended, apart: f64, outside: f64, covered: f32, noise: f64) -> f64 {
        let value = f64::from(blended.value);
        let scale = value.max(self.floor);
        let between = match &self.between {
            Some(table) => table.value(f64::from(blended.spread)),
            None => f64::from(blended.spread).min(1.0),
        };
        // At a scan nothing is interpolated; halfway to the next, everything.
        let between = between * (apart / HALFWAY).min(1.0).sqrt();
        let within = self.within.value(value);
        let uncovered = UNCOVERED * f64::from(1.0 - covered);
        let relative2 =
            between.powi(2) + within.powi(2) + uncovered.powi(2) + (PER_DISTANCE * outside).powi(2);
        (relative2 * scale * scale + noise * noise).sqrt()
    }
}
