//! What the viewer prints of a BSDF, as JSON: what is in the file, peaks, single cells, refusals.
//!
//! In: what the core has. Out: JSON values; numbers in full precision. Units are those of the core: 1/sr, sr, m.

use bsdftree::file::FileError;
use bsdftree::peaks::{PeakOptions, peaks as peaks_of};
use bsdftree::xml::{Repair, Severity};
use bsdftree::{Band, Bsdf, Component, Direction, Part, Scattering, Side};
use serde_json::{Value, json};

use crate::beside::says_errors;
use crate::mosaic::{Layout, finest};

/// A file that was refused.
pub fn refused(error: &FileError) -> Value {
    json!({ "error": error.to_string() })
}

/// What is in a file, and what was noted or repaired when it was read.
pub fn summary(bsdf: &Bsdf, repairs: &[Repair]) -> Value {
    let header = &bsdf.header;
    let bands: Vec<Value> = bsdf.bands.iter().map(band).collect();
    let notes: Vec<Value> = repairs
        .iter()
        .map(|repair| json!({ "repaired": repair.severity == Severity::Repair, "what": repair.to_string() }))
        .collect();
    json!({
        "name": header.name,
        "manufacturer": header.manufacturer,
        "size": [header.width, header.height, header.thickness],
        "has_geometry": header.geometry.is_some(),
        "provenance": header.provenance,
        "has_errors": says_errors(bsdf),
        "bands": bands,
        "notes": notes,
    })
}

fn band(band: &Band) -> Value {
    let components: Vec<Value> =
        band.components().map(|(part, component)| described(part, component)).collect();
    json!({ "name": band.name, "components": components })
}

fn described(part: Part, component: &Component) -> Value {
    let function = &component.luminance;
    let form = match function {
        Scattering::Tree(tree) => json!({
            "rank": tree.rank().dimensions(),
            "log2_res": tree.arena().log2_res(),
            "n_leaves": tree.arena().n_leaves(),
            "leaves_of_level": leaves_of_level(tree),
        }),
        Scattering::Matrix(matrix) => json!({
            "incident_basis": matrix.incident().name(),
            "exitant_basis": matrix.exitant().name(),
            "n_incident": matrix.incident().n_patches(),
            "n_exitant": matrix.exitant().n_patches(),
        }),
    };
    json!({
        "part": part.key(),
        "incident_front": part.incident_side() == Side::Front,
        "exitant_front": part.exitant_side() == Side::Front,
        "structure": function.file_structure(),
        "form": form,
        "n_values": function.n_values(),
        "n_bytes": function.n_bytes(),
        "maximum": maximum(function),
        "lambertian": function.lambertian(),
        "is_coloured": component.chroma.is_some(),
    })
}

/// How many leaves there are of each edge, the whole tree first.
fn leaves_of_level(tree: &bsdftree::Tree) -> Vec<usize> {
    let mut counts = vec![0; tree.arena().log2_res() as usize + 1];
    tree.leaves().for_each(|leaf| counts[leaf.level as usize] += 1);
    counts
}

/// Largest value \[1/sr\].
fn maximum(function: &Scattering) -> f32 {
    match function {
        Scattering::Tree(tree) => tree.leaves().map(|leaf| leaf.value).fold(0.0, f32::max),
        Scattering::Matrix(matrix) => matrix.values().iter().copied().fold(0.0, f32::max),
    }
}

/// The specular peaks of a band by family, the strongest of each component first.
pub fn peaks(band: &Band) -> Value {
    let families = peaks_of(band, PeakOptions::default());
    let families = families.iter().map(|family| {
        json!({
            "part": family.part.key(),
            "map": family.map.name(),
            "mean_strength": family.mean_strength(),
            "n_peaks": family.peaks.len(),
            "n_directions": family.n_directions,
        })
    });
    families.collect()
}

/// The cell that a pair of directions lies in, or `null` where there is no component and the BSDF is black.
pub fn cell(band: &Band, incident: Direction, exitant: Direction) -> Value {
    let Some((component, reversed)) = band.answering(Side::of(incident), Side::of(exitant)) else {
        return Value::Null;
    };
    let cell = component.luminance.cell(incident, exitant, reversed);
    json!({
        "value": band.eval(incident, exitant),
        "xyz": band.eval_xyz(incident, exitant),
        "projected_solid_angle": cell.projected_solid_angle,
        // Beyond what numbers of JavaScript hold.
        "key": cell.key.to_string(),
        "reversed": reversed,
    })
}

/// How the mosaic of a function lies: tiles, and how fine tiles and their pixels can be.
pub fn layout(function: &Scattering, log2_tiles: u32) -> Value {
    let layout = Layout::new(function, log2_tiles);
    let [finest_tiles, finest_exitant] = finest(function);
    json!({
        "columns": layout.columns,
        "rows": layout.rows,
        "finest_log2_tiles": finest_tiles,
        "finest_log2_exitant": finest_exitant,
    })
}
