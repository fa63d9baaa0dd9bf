//! Lengths and wavelengths that are a thousand times what they can be: millimetres declared as metres, micrometres as nanometres.

use super::{Finding, Kind, Repair, Severity};
use crate::bsdf::{Band, Header};

/// Devices in windows are thinner than this \[m\].
const MAX_THICKNESS: f64 = 1.0;
/// And smaller than this.
const MAX_EXTENT: f64 = 50.0;

/// Width, height and thickness \[m\], those that cannot be taken as millimetres; `None` if all can be.
pub(crate) fn mended_lengths(header: &Header) -> Option<[Option<f64>; 3]> {
    let [width, height, thickness] = [header.width, header.height, header.thickness];
    let over = |length: Option<f64>, most: f64| length.is_some_and(|l| l > most);
    let too_wide = over(width, MAX_EXTENT) || over(height, MAX_EXTENT);
    let mend = |length: Option<f64>, wrong: bool| if wrong { length.map(|l| l / 1000.0) } else { length };
    // A width of 1200 tells that a thickness of 0.8 beside it is one of 0.8 mm.
    let too_thick = over(thickness, MAX_THICKNESS) || too_wide;
    (too_wide || too_thick)
        .then(|| [mend(width, too_wide), mend(height, too_wide), mend(thickness, too_thick)])
}

/// What is to be said of the lengths.
pub(super) fn lengths(header: &Header) -> Vec<Finding> {
    let Some(mended) = mended_lengths(header) else { return Vec::new() };
    let shown = |lengths: [Option<f64>; 3]| {
        let named = ["width", "height", "thickness"].into_iter().zip(lengths);
        let shown = named.filter_map(|(name, l)| Some(format!("{name} {:.6} m", l?)));
        shown.collect::<Vec<_>>().join(", ")
    };
    let given = [header.width, header.height, header.thickness];
    let message = format!("the header says {}: as if it meant millimetres, {}", shown(given), shown(mended));
    let advice = "give the unit that the lengths are in";
    let largest = given.into_iter().flatten().fold(0.0, f64::max);
    let finding = Finding::new(Kind::Units, Severity::Warning, message, advice);
    vec![finding.by(largest).mended_by(Repair::Lengths)]
}

/// The wavelength in nm of a band that is named by one in µm.
pub(crate) fn nanometers(band: &str) -> Option<String> {
    let micrometers: f64 = band.trim().parse().ok()?;
    (0.1..100.0).contains(&micrometers).then(|| format!("{}", (micrometers * 1e6).round() / 1e3))
}

/// What is to be said of the band's name.
pub(super) fn wavelength(band: &Band) -> Option<Finding> {
    let meant = nanometers(&band.name)?;
    let message =
        format!("a wavelength of {} nm has no light in it: as if it meant µm, {meant} nm", band.name.trim());
    let finding = Finding::new(Kind::Units, Severity::Warning, message, "give wavelengths in nm");
    Some(finding.by(band.name.trim().parse().unwrap_or_default()).mended_by(Repair::Wavelength))
}
