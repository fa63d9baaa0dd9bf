//! The device's geometry inside the file that its BSDF is written to.
//!
//! In: a device and the box that stands for it. Out: the header with the geometry as MGF, in the unit of the header, with the middle of
//! the box at x = y = 0; and what the user should know of it. Source: genBSDF, which does the same.

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
) -> Vec<String> {
    let middle = [0, 1].map(|k| 0.5 * (aperture.min[k] + aperture.max[k]));
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
