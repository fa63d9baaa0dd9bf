//! The device's geometry inside the file that its BSDF is written to.
//!
//! In: a device and the box that stands for it. Out: the header with the geometry as MGF, in the unit of the header, with the middle of
//! the box at x = y = 0; and what the user should know of it. Source: genBSDF, which does the same.
//! Of a device that repeats, the box is one period; width and height become those of all that is drawn, since whoever places the geometry
//! places a rectangle of that size with it.

use bsdftree::{Header, LengthUnit};
use bsdftree_device::Device;

use crate::options::Aperture;

/// Longest text that is put into a file \[byte\]: half a million facets.
const LONGEST: usize = 64 << 20;

/// See the module's head.
pub(crate) fn put(
    header: &mut Header,
    device: &Device,
    unit: LengthUnit,
    aperture: &Aperture,
    is_tiled: bool,
) -> Vec<String> {
    let (mut min, mut max) = (aperture.min, aperture.max);
    if let (true, Some([least, most])) = (is_tiled, device.bounds().map(|b| b.map(|p| p.to_array()))) {
        for k in 0..2 {
            // A drawing of one period may be smaller than the period: slats are flat, or far apart.
            if most[k] - least[k] > max[k] - min[k] {
                (min[k], max[k]) = (least[k], most[k]);
            }
        }
        (header.width, header.height) = (Some(max[0] - min[0]), Some(max[1] - min[1]));
    }
    let middle = [0, 1].map(|k| 0.5 * (min[k] + max[k]));
    let (geometry, losses) = device.to_bsdf_geometry(unit, middle);
    if geometry.mgf.len() > LONGEST {
        let megabytes = geometry.mgf.len() >> 20;
        return vec![format!(
            "the geometry is left out of the file: as MGF it takes {megabytes} MiB, and at most {} are put there",
            LONGEST >> 20
        )];
    }
    header.geometry = Some(geometry);
    losses.into_iter().map(|lost| format!("the geometry in the file does not say all: {lost}")).collect()
}
