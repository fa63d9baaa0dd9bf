//! Bands whose materials are given apart.
//!
//! In: a device, and for some bands the same device with the materials that it has there. Out: one BSDF with all bands. Each such band is a
//! generation of its own, with the same random numbers: what is the same in two bands comes out the same. So has a band that a BSDF file
//! of the device has values for; its other materials are there what they are else.

use std::borrow::Cow;
use std::time::Instant;

use bsdftree_device::Device;

use crate::bands::Band;
use crate::generate::{GenerateError, Generated, Report, generate};
use crate::options::Options;
use crate::progress::Progress;

/// Generates the bands that the options name from the device, and each of `own` from a device of its own, whose colours are reflectances and
/// transmittances in that band. A band of the options that is also in `own` is the one in `own`.
///
/// A time budget is for all together. Checkpoints of bands in `own` are directories in that of the device. The report's samples and its reason to
/// stop are those of the band that is known least.
///
/// # Errors
/// As [`generate`].
pub fn generate_bands(
    device: &Device,
    own: &[(Band, Device)],
    options: &Options,
    progress: &Progress,
) -> Result<Generated, GenerateError> {
    let begin = Instant::now();
    for (k, (band, _)) in own.iter().enumerate() {
        if own[..k].iter().any(|(other, _)| is_same(other, band)) {
            return Err(GenerateError::Option(format!("two devices for the band {}; give one", band.name())));
        }
    }
    let of_band = |band: &Band, device: &Device| device.of_band(band.name());
    let mut own: Vec<(Band, Cow<Device>)> = own
        .iter()
        .map(|(band, device)| (band.clone(), of_band(band, device).map_or(Cow::Borrowed(device), Cow::Owned)))
        .collect();
    let mut shared = Options { bands: Vec::new(), ..options.clone() };
    for band in &options.bands {
        if own.iter().any(|(other, _)| is_same(other, band)) {
            continue;
        }
        match of_band(band, device).filter(|_| !band.is_visible()) {
            Some(device) => own.push((band.clone(), Cow::Owned(device))),
            None => shared.bands.push(band.clone()),
        }
    }
    let mut runs: Vec<(&Device, Options)> = Vec::new();
    if !shared.bands.is_empty() {
        runs.push((device, shared));
    }
    runs.extend(own.iter().map(|(band, device)| (&**device, of_own(band, options))));
    let n_runs = runs.len() as u32;
    let mut all: Option<Generated> = None;
    for (k, (device, mut options)) in (0..).zip(runs) {
        if let Some(budget) = &mut options.time_budget {
            *budget = budget.saturating_sub(begin.elapsed()) / (n_runs - k);
        }
        let made = generate(device, &options, progress)?;
        all = Some(match all {
            None => made,
            Some(before) => joined(before, made),
        });
    }
    all.ok_or_else(|| GenerateError::Option("no bands; expected one or more".into()))
}

fn is_same(a: &Band, b: &Band) -> bool {
    a.name().eq_ignore_ascii_case(b.name())
}

/// The options for a band with a device of its own.
fn of_own(band: &Band, options: &Options) -> Options {
    let legal = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let directory: String = "band-".chars().chain(band.name().chars().map(legal)).collect();
    Options {
        bands: vec![band.clone()],
        own_band: true,
        color: options.color && band.is_visible(),
        checkpoint: options.checkpoint.as_ref().map(|all| all.join(directory)),
        ..options.clone()
    }
}

fn joined(all: Generated, more: Generated) -> Generated {
    let Generated { mut bsdf, mut errors, report: before } = all;
    bsdf.bands.extend(more.bsdf.bands);
    errors.bands.extend(more.errors.bands);
    let bands = [&before.bands[..], &more.report.bands].concat();
    let totals = before.totals.clone();
    let new: Vec<_> = more.report.warnings.iter().filter(|w| !before.warnings.contains(w)).cloned().collect();
    let warnings = [&before.warnings[..], &new].concat();
    let (best, worst) = match before.error < more.report.error {
        true => (before, more.report),
        false => (more.report, before),
    };
    let report = Report {
        paths: worst.paths + best.paths,
        direction_error: worst.direction_error.max(best.direction_error),
        totals,
        bands,
        lost: worst.lost + best.lost,
        tracing: worst.tracing + best.tracing,
        reducing: worst.reducing + best.reducing,
        warnings,
        ..worst
    };
    Generated { bsdf, errors, report }
}
