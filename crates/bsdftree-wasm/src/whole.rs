//! Exports about whole components, and about a second file beside the one that is open. As those of `lib.rs`; answers are those of [`mosaic`],
//! [`statistics`] and [`beside`].
//!
//! Components count as in [`Part::ALL`].

use bsdftree::binary::{self, Packing};
use bsdftree::file;
use bsdftree::xml::Strictness;
use bsdftree::{Band, Part, Scattering};
use serde_json::json;

use crate::beside::Comparison;
use crate::mosaic::{Layout, Quantity, Window};
use crate::{Beside, Instance, beside, counted, mosaic, statistics, summary, told, with};

fn found(instance: &Instance, band: usize, part: usize) -> Option<(&Band, Part, &Scattering)> {
    let (band, &part) = (instance.bsdf.bands.get(band)?, Part::ALL.get(part)?);
    Some((band, part, &band.component(part)?.luminance))
}

/// See [`mosaic::mosaic`]. Components count as in [`Part::ALL`]; `depth`: whether that is asked instead of values.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_mosaic(
    band: usize,
    part: usize,
    depth: u32,
    log2_tiles: u32,
    log2_exitant: u32,
    x: u32,
    y: u32,
    width: u32,
    height: u32,
) -> usize {
    counted(band, |_, instance| {
        let Some((_, _, function)) = found(instance, band, part) else { return Vec::new() };
        let quantity = if depth != 0 { Quantity::Depth } else { Quantity::Value };
        let layout = Layout::new(function, log2_tiles);
        mosaic::mosaic(function, quantity, layout, log2_exitant, Window { x, y, width, height })
    })
}

/// How a mosaic lies, as text. See [`summary::layout`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_mosaic_layout(band: usize, part: usize, log2_tiles: u32) -> usize {
    told(|instance| {
        let (_, _, function) = found(instance, band, part)?;
        Some(summary::layout(function, log2_tiles).to_string())
    })
}

/// What is at a place of a mosaic, counted in tiles from the top left, as text: the pair of directions, and its cell.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_mosaic_at(band: usize, part: usize, log2_tiles: u32, x: f64, y: f64) -> usize {
    told(|instance| {
        let (band, part, function) = found(instance, band, part)?;
        let [incident, exitant] = Layout::new(function, log2_tiles).directions_at(part, [x, y]);
        let cell = instance.cell(band, incident, exitant);
        Some(json!({ "incident": incident, "exitant": exitant, "cell": cell }).to_string())
    })
}

/// Where a pair of directions lies in a mosaic: column and row of tiles from the top left, with what is behind the point.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_mosaic_place(
    band: usize,
    part: usize,
    log2_tiles: u32,
    ix: f64,
    iy: f64,
    iz: f64,
    ox: f64,
    oy: f64,
    oz: f64,
) -> usize {
    counted(band, |_, instance| {
        let Some((_, _, function)) = found(instance, band, part) else { return Vec::new() };
        let place = Layout::new(function, log2_tiles).place_of([ix, iy, iz], [ox, oy, oz]);
        place.map(|c| c as f32).to_vec()
    })
}

/// How a component is divided, as text. See [`statistics::statistics`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_statistics(band: usize, part: usize) -> usize {
    told(|instance| {
        let (_, _, function) = found(instance, band, part)?;
        Some(statistics::statistics(function).to_string())
    })
}

/// What is open as a raw `.bsdft`, to be handed to another instance; its bytes are where [`crate::bsdftree_pixels`] says.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_image() -> usize {
    with(|instance| {
        instance.pixels.clear();
        match binary::write(&instance.bsdf, Packing::Raw, &mut instance.pixels) {
            Ok(()) => instance.pixels.len(),
            Err(_) => 0,
        }
    })
}

/// Forgets what bytes were asked for last, which may be many.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_forget() {
    with(|instance| instance.pixels = Vec::new());
}

/// Reads the file whose `n` bytes were written where [`crate::bsdftree_reserve`] said, to be held against the one that is open. The text says whether it has
/// the standard errors of that, `{"are_errors": …}`, or `{"error": …}`. `only_errors`: what it is not is left as it was.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_open_beside(n: usize, only_errors: u32) -> usize {
    with(|instance| {
        let input = std::mem::take(&mut instance.input);
        let bytes = bytemuck::cast_slice::<u64, u8>(&input);
        let told = match file::read_bytes(&bytes[..n.min(bytes.len())], Strictness::Repair) {
            Err(error) => summary::refused(&error),
            Ok((bsdf, _)) => {
                let are_errors = beside::are_errors_of(&bsdf, &instance.bsdf);
                if are_errors || only_errors == 0 {
                    instance.beside = Some(Beside { bsdf, are_errors, comparison: Comparison::default() });
                }
                json!({ "are_errors": are_errors })
            }
        };
        instance.text = told.to_string();
        instance.text.len()
    })
}

/// How far the file beside is from the open one, as text; empty if it has no such band. Counted in steps: `{"done": …}` until all is, then `{"rows": …}`; see
/// [`beside::Comparison`]. All steps are of one band.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_differences(band: usize, n_points: u32) -> usize {
    with(|instance| {
        let bsdf = &instance.bsdf;
        let found = instance.beside.as_mut().and_then(|beside| {
            let band = bsdf.bands.get(band)?;
            let other = beside.bsdf.band(&band.name)?;
            let done = beside.comparison.proceed(band, other, n_points);
            Some(match done < 1.0 {
                true => json!({ "done": done }),
                false => json!({ "rows": beside.comparison.differences(band, other) }),
            })
        });
        instance.text = found.map(|found| found.to_string()).unwrap_or_default();
        instance.text.len()
    })
}

/// How well components are known, as text; empty if what is beside are no standard errors. See [`beside::errors_by_flux`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_errors_by_flux(band: usize) -> usize {
    told(|instance| {
        let band = instance.bsdf.bands.get(band)?;
        Some(beside::errors_by_flux(band, instance.errors_of(band)?).to_string())
    })
}
