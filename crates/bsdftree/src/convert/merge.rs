//! One BSDF of the bands and components of several.
//!
//! In: BSDFs. Out: one that has everything they have, and what does not fit together. A file holds one kind of data, so all functions
//! must be trees of one rank, or matrices over the same bases.

use super::ConvertError;
use crate::bsdf::Bsdf;

/// Sizes that differ by less are equal.
const SIZE_TOLERANCE: f64 = 0.01;

/// All that is in several BSDFs, with the header of the first; and remarks on what should be looked at.
///
/// # Errors
/// If two have the same component of the same band, or functions are of different kinds.
pub fn merge(parts: &[&Bsdf]) -> Result<(Bsdf, Vec<String>), ConvertError> {
    let [first, ..] = parts else { return Err(ConvertError::NoLayers) };
    let mut made = Bsdf { header: first.header.clone(), bands: Vec::new() };
    let mut remarks = Vec::new();
    let mut kind = None;
    for (k, bsdf) in parts.iter().enumerate() {
        let place = format!("BSDF {} ({:?})", k + 1, bsdf.header.name);
        for (what, ours, theirs) in [
            ("width", made.header.width, bsdf.header.width),
            ("height", made.header.height, bsdf.header.height),
            ("thickness", made.header.thickness, bsdf.header.thickness),
        ] {
            if let (Some(a), Some(b)) = (ours, theirs)
                && (a - b).abs() > SIZE_TOLERANCE * a.abs().max(b.abs())
            {
                remarks.push(format!("{place} has a {what} of {b} m, the first one {a} m"));
            }
        }
        for band in &bsdf.bands {
            for (part, component) in band.components() {
                let kind = *kind.get_or_insert(&component.luminance);
                if !kind.has_domain_of(&component.luminance) {
                    return Err(ConvertError::Kinds {
                        place,
                        part: part.key(),
                        found: describe(&component.luminance),
                        expected: describe(kind),
                    });
                }
                if made.band_mut(&band.name).insert(part, component.clone()).is_some() {
                    return Err(ConvertError::Twice { place, part: part.key(), band: band.name.clone() });
                }
            }
        }
    }
    Ok((made, remarks))
}

fn describe(function: &crate::Scattering) -> String {
    match function {
        crate::Scattering::Tree(tree) => format!("a tree of rank {}", tree.rank().dimensions()),
        crate::Scattering::Matrix(matrix) => {
            format!("a matrix {} x {}", matrix.incident().name(), matrix.exitant().name())
        }
    }
}
