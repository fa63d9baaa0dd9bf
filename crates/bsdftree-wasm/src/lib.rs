//! The core for browsers, without generated glue: plain exports of numbers and places in memory.
//!
//! An instance holds **one** BSDF. Two files are two instances, so nothing is looked up by a handle, and closing a file gives all of
//! its memory back. In: what the caller writes where [`bsdftree_reserve`] says. Out: a length, and that many characters or numbers where
//! [`bsdftree_text`], [`bsdftree_numbers`] or [`bsdftree_pixels`] says, until the next call. Places are good until the next call, since
//! memory may grow. No logic of its own: answers are those of the other modules; exports about whole
//! components and about a second file beside the one that is open are in `whole.rs`.
//!
//! Bands count as in the file. What cannot be answered, because nothing is open or there is no such band, is an answer of length 0.

pub mod beside;
pub mod lobe;
pub mod mosaic;
pub mod statistics;
pub mod summary;
pub mod view;
mod whole;

use std::cell::RefCell;

use bsdftree::file;
use bsdftree::xml::Strictness;
use bsdftree::{Band, Bsdf, Direction, Side};

use crate::view::Tone;

/// What an instance holds.
#[derive(Default)]
struct Instance {
    bsdf: Bsdf,
    /// A second one, to be held against it: standard errors, or another state of the device.
    beside: Option<Beside>,
    /// From the caller, eight bytes each, so that directions are aligned.
    input: Vec<u64>,
    text: String,
    numbers: Vec<f32>,
    pixels: Vec<u8>,
}

struct Beside {
    bsdf: Bsdf,
    /// Whether its values are the standard errors of the other's.
    are_errors: bool,
    /// How far it is, as far as that was counted.
    comparison: beside::Comparison,
}

impl Instance {
    /// The standard errors of a band.
    fn errors_of(&self, band: &Band) -> Option<&Band> {
        self.beside.as_ref().filter(|beside| beside.are_errors)?.bsdf.band(&band.name)
    }

    /// A cell, with its standard error where that is known.
    fn cell(&self, band: &Band, incident: Direction, exitant: Direction) -> serde_json::Value {
        let mut cell = summary::cell(band, incident, exitant);
        let error = self.errors_of(band).and_then(|errors| beside::standard_error(errors, incident, exitant));
        if let (Some(cell), Some(error)) = (cell.as_object_mut(), error) {
            cell.insert("standard_error".into(), error.into());
        }
        cell
    }
}

thread_local! {
    static INSTANCE: RefCell<Instance> = RefCell::default();
}

fn with<R>(act: impl FnOnce(&mut Instance) -> R) -> R {
    INSTANCE.with_borrow_mut(act)
}

/// Keeps a text for the caller; its length in bytes of UTF-8.
fn told(text: impl FnOnce(&Instance) -> Option<String>) -> usize {
    with(|instance| {
        instance.text = text(instance).unwrap_or_default();
        instance.text.len()
    })
}

/// Keeps numbers for the caller; how many.
fn counted(band: usize, numbers: impl FnOnce(&Band, &Instance) -> Vec<f32>) -> usize {
    with(|instance| {
        let found = instance.bsdf.bands.get(band);
        instance.numbers = found.map(|band| numbers(band, instance)).unwrap_or_default();
        instance.numbers.len()
    })
}

/// Keeps bytes for the caller; how many.
fn painted(band: usize, pixels: impl FnOnce(&Band) -> Vec<u8>) -> usize {
    with(|instance| {
        instance.pixels = instance.bsdf.bands.get(band).map(pixels).unwrap_or_default();
        instance.pixels.len()
    })
}

fn side(front: u32) -> Side {
    if front != 0 { Side::Front } else { Side::Back }
}

/// Where the caller may write `n` bytes, aligned to 8.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_reserve(n: usize) -> *mut u8 {
    with(|instance| {
        instance.input = vec![0; n.div_ceil(8)];
        instance.input.as_mut_ptr().cast()
    })
}

/// Where the last text is.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_text() -> *const u8 {
    with(|instance| instance.text.as_ptr())
}

/// Where the last numbers are.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_numbers() -> *const f32 {
    with(|instance| instance.numbers.as_ptr())
}

/// Where the last pixels or marks are.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_pixels() -> *const u8 {
    with(|instance| instance.pixels.as_ptr())
}

/// Reads the file whose `n` bytes were written where [`bsdftree_reserve`] said. The text is its summary, or `{"error": …}`, and then nothing is
/// open. `repair`: whether to read what can be read of a damaged file, and list what was done.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_open(n: usize, repair: u32) -> usize {
    with(|instance| {
        instance.bsdf = Bsdf::default();
        let input = std::mem::take(&mut instance.input);
        let bytes = bytemuck::cast_slice::<u64, u8>(&input);
        let strictness = if repair != 0 { Strictness::Repair } else { Strictness::Strict };
        instance.text = match file::read_bytes(&bytes[..n.min(bytes.len())], strictness) {
            Ok((bsdf, repairs)) => {
                (instance.bsdf, instance.beside) = (bsdf, None);
                summary::summary(&instance.bsdf, &repairs).to_string()
            }
            Err(error) => summary::refused(&error).to_string(),
        };
        instance.text.len()
    })
}

/// The specular peaks of a band, as text.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_peaks(band: usize) -> usize {
    told(|instance| Some(summary::peaks(instance.bsdf.bands.get(band)?).to_string()))
}

/// The cell of a pair of directions, as text: its value in full precision.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_cell(band: usize, ix: f64, iy: f64, iz: f64, ox: f64, oy: f64, oz: f64) -> usize {
    told(|instance| {
        let band = instance.bsdf.bands.get(band)?;
        Some(instance.cell(band, [ix, iy, iz], [ox, oy, oz]).to_string())
    })
}

/// Values \[1/sr\] for the `n` exitant directions, three f64 each, that were written where [`bsdftree_reserve`] said.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_eval(band: usize, ix: f64, iy: f64, iz: f64, n: usize) -> usize {
    counted(band, |band, instance| {
        let directions = bytemuck::cast_slice::<u64, f64>(&instance.input);
        let (exitant, _) = directions.as_chunks::<3>();
        view::values(band, [ix, iy, iz], &exitant[..n.min(exitant.len())])
    })
}

/// See [`view::hemisphere`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_hemisphere(band: usize, ix: f64, iy: f64, iz: f64, front: u32, n: usize) -> usize {
    counted(band, |band, _| view::hemisphere(band, [ix, iy, iz], side(front), n))
}

/// See [`view::colours`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_colours(
    band: usize,
    ix: f64,
    iy: f64,
    iz: f64,
    front: u32,
    n: usize,
    white: f64,
    decades: f64,
) -> usize {
    painted(band, |band| view::colours(band, [ix, iy, iz], side(front), n, Tone { white, decades }))
}

/// The directions of the net of a hemisphere, three numbers each; see [`lobe::knots`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_knots(front: u32, n: usize) -> usize {
    with(|instance| {
        let knots = lobe::knots(side(front), n);
        instance.numbers = knots.into_iter().flatten().map(|c| c as f32).collect();
        instance.numbers.len()
    })
}

/// See [`lobe::lobe`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_lobe(
    band: usize,
    ix: f64,
    iy: f64,
    iz: f64,
    front: u32,
    n: usize,
    per_knot: usize,
) -> usize {
    counted(band, |band, _| lobe::lobe(band, [ix, iy, iz], side(front), n, per_knot))
}

/// See [`lobe::lobe_colours`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_lobe_colours(
    band: usize,
    ix: f64,
    iy: f64,
    iz: f64,
    front: u32,
    n: usize,
    white: f64,
    decades: f64,
) -> usize {
    painted(band, |band| lobe::lobe_colours(band, [ix, iy, iz], side(front), n, Tone { white, decades }))
}

/// See [`view::edges`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_edges(band: usize, ix: f64, iy: f64, iz: f64, front: u32, n: usize) -> usize {
    painted(band, |band| view::edges(band, [ix, iy, iz], side(front), n))
}

/// See [`view::slice`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_slice(band: usize, ix: f64, iy: f64, iz: f64, front: u32, n: usize) -> usize {
    counted(band, |band, _| view::slice(band, [ix, iy, iz], side(front), n))
}

/// See [`view::totals`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_totals(band: usize, front: u32, phi: f64, n: usize) -> usize {
    counted(band, |band, _| view::totals(band, side(front), phi, n))
}

/// See [`view::depths`].
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_depths(band: usize, ix: f64, iy: f64, iz: f64, front: u32, n: usize) -> usize {
    counted(band, |band, _| view::depths(band, [ix, iy, iz], side(front), n))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(bytes: &[u8]) -> serde_json::Value {
        bsdftree_reserve(bytes.len());
        with(|instance| {
            bytemuck::cast_slice_mut::<u64, u8>(&mut instance.input)[..bytes.len()].copy_from_slice(bytes);
        });
        let length = bsdftree_open(bytes.len(), 0);
        with(|instance| {
            assert_eq!(instance.text.len(), length);
            serde_json::from_str(&instance.text).unwrap()
        })
    }

    #[test]
    fn what_is_no_bsdf_leaves_nothing_open() {
        let refused = open(b"<html/>");
        assert!(refused["error"].as_str().unwrap().contains("html"), "{refused}");
        assert_eq!(bsdftree_hemisphere(0, 0.0, 0.0, 1.0, 1, 8), 0);
        assert_eq!(bsdftree_peaks(0), 0);
    }

    #[test]
    fn an_opened_file_answers_as_the_core() {
        let Some(path) = bsdftree_testing::real_file("radiance/sawtooth.xml") else { return };
        let bytes = std::fs::read(path).unwrap();
        let summary = open(&bytes);
        let (bsdf, _) = file::read_bytes(&bytes, Strictness::Strict).unwrap();
        assert_eq!(summary["bands"][0]["name"], bsdf.bands[0].name.as_str());
        let (part, _) = bsdf.bands[0].components().next().unwrap();
        let incident = [0.48, 0.6, 0.64 * part.incident_side().sign()];
        let exitant = [-0.6, 0.48, 0.64 * part.exitant_side().sign()];
        let [ix, iy, iz] = incident;
        let [ox, oy, oz] = exitant;
        bsdftree_cell(0, ix, iy, iz, ox, oy, oz);
        let cell: serde_json::Value = with(|instance| serde_json::from_str(&instance.text).unwrap());
        assert_eq!(cell["value"].as_f64().unwrap(), bsdf.bands[0].eval(incident, exitant));
        bsdftree_reserve(24);
        with(|instance| instance.input = bytemuck::cast_slice(&exitant).to_vec());
        assert_eq!(bsdftree_eval(0, ix, iy, iz, 1), 1);
        with(|instance| assert_eq!(instance.numbers, [bsdf.bands[0].eval(incident, exitant) as f32]));
    }
}
