//! A band by name.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use crate::spectra::{RANGE_NM, VISIBLE_NM, Weights, cie_xyz, mean_between, solar_between, value_at};

/// Names that the file has for other things.
const RESERVED: [&str; 5] = ["CIE-X", "CIE-Y", "CIE-Z", "CIE-u", "CIE-v"];

/// Longest name.
const MAX_NAME: usize = 40;

/// A band of light that a BSDF has values of its own for.
///
/// ```
/// use bsdftree_generate::Band;
/// let bands: Result<Vec<Band>, _> = "visible,Solar,550,PAR:400-700".split(',').map(str::parse).collect();
/// let names: Vec<_> = bands?.iter().map(|band| band.name().to_owned()).collect();
/// assert_eq!(names, ["Visible", "Solar", "550", "PAR"]);
/// assert!("FIR".parse::<Band>().unwrap_err().to_string().contains("Visible, Solar, NIR, UV"));
/// # Ok::<(), bsdftree_generate::BandError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    name: String,
    light: Light,
}

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Light {
    /// Y of equal-energy light.
    Visible,
    /// Sunlight between two wavelengths \[nm\].
    Solar([f64; 2]),
    /// The mean between two wavelengths \[nm\].
    Mean([f64; 2]),
    /// One wavelength \[nm\].
    At(f64),
    /// Whatever the materials are given for.
    Own,
}

/// A band that is not understood.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BandError {
    /// No band of this name is known.
    #[error(
        "band {0:?}; expected Visible, Solar, NIR, UV, a wavelength in nm such as 550, or a name with wavelengths such as PAR:400-700"
    )]
    Unknown(String),
    /// Wavelengths that nothing is known of.
    #[error("band {0:?}: wavelengths must rise, and lie between 300 and 2500 nm")]
    Range(String),
    /// A name that no file can have.
    #[error(
        "band name {0:?}; expected 1 to 40 visible characters, none of CIE-X, CIE-Y, CIE-Z, CIE-u, CIE-v"
    )]
    Name(String),
}

impl Band {
    /// `Visible`.
    pub fn visible() -> Band {
        Band { name: "Visible".into(), light: Light::Visible }
    }

    /// A band of any name, whose values are what the materials say. If they have spectra, it must be a name that
    /// [`Band::from_str`] knows.
    ///
    /// # Errors
    /// If a file cannot have that name.
    pub fn named(name: &str) -> Result<Band, BandError> {
        match name.parse() {
            Err(BandError::Unknown(_)) => Ok(Band { name: checked(name)?.to_owned(), light: Light::Own }),
            known => known,
        }
    }

    /// As in the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it is what the eye sees, which may have colour.
    pub fn is_visible(&self) -> bool {
        self.light == Light::Visible
    }

    /// Its wavelengths \[nm\].
    pub(crate) fn range_nm(&self) -> [f64; 2] {
        match self.light {
            Light::Visible | Light::Own => VISIBLE_NM,
            Light::Solar(range) | Light::Mean(range) => range,
            Light::At(nm) => [nm, nm],
        }
    }

    /// Weights of wavelengths, or `None` for a band that is not known by wavelengths.
    pub(crate) fn weights(&self) -> Option<Weights> {
        Some(match self.light {
            Light::Visible => cie_xyz()[1],
            Light::Solar(range) => solar_between(range),
            Light::Mean(range) => mean_between(range),
            Light::At(nm) => value_at(nm),
            Light::Own => return None,
        })
    }
}

impl fmt::Display for Band {
    /// What [`Band::from_str`] takes.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.light {
            Light::Mean([from, to]) => write!(f, "{}:{from}-{to}", self.name),
            _ => f.write_str(&self.name),
        }
    }
}

impl FromStr for Band {
    type Err = BandError;

    fn from_str(text: &str) -> Result<Band, BandError> {
        let text = text.trim();
        let known = [
            ("Visible", Light::Visible),
            ("Solar", Light::Solar(RANGE_NM)),
            ("NIR", Light::Solar([VISIBLE_NM[1], RANGE_NM[1]])),
            ("UV", Light::Solar([RANGE_NM[0], VISIBLE_NM[0]])),
        ];
        if let Some((name, light)) = known.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text)) {
            return Ok(Band { name: name.into(), light });
        }
        let unknown = || BandError::Unknown(text.into());
        let out_of_range = || BandError::Range(text.into());
        let within = |nm: f64| (RANGE_NM[0]..=RANGE_NM[1]).contains(&nm);
        if let Ok(nm) = text.parse::<f64>() {
            let light = within(nm).then_some(Light::At(nm)).ok_or_else(out_of_range)?;
            return Ok(Band { name: text.into(), light });
        }
        let (name, range) = text.split_once(':').ok_or_else(unknown)?;
        let (from, to) = range.split_once('-').ok_or_else(unknown)?;
        let [from, to] = [from, to].map(|nm| nm.trim().parse::<f64>().map_err(|_| unknown()));
        let range = [from?, to?];
        if !(within(range[0]) && within(range[1]) && range[0] < range[1]) {
            return Err(out_of_range());
        }
        let name = checked(name)?;
        if known.iter().any(|(known, _)| known.eq_ignore_ascii_case(name)) {
            return Err(BandError::Name(name.into()));
        }
        Ok(Band { name: name.into(), light: Light::Mean(range) })
    }
}

fn checked(name: &str) -> Result<&str, BandError> {
    let name = name.trim();
    let legal = !name.is_empty()
        && name.chars().count() <= MAX_NAME
        && name.chars().all(|c| !c.is_control())
        && !RESERVED.iter().any(|reserved| reserved.eq_ignore_ascii_case(name));
    if legal { Ok(name) } else { Err(BandError::Name(name.into())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_1_in_every_band() {
        for name in
            ["Visible", "Solar", "NIR", "UV", "550", "783.5", "2500", "300", "PAR:400-700", "x:1000-1000.2"]
        {
            let weights = name.parse::<Band>().unwrap().weights().unwrap();
            let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
            assert!((sum - 1.0).abs() < 1e-6 && weights.iter().all(|&w| w > -0.15), "{name}: {sum}");
        }
    }

    #[test]
    fn what_is_no_band_is_refused() {
        for (text, expected) in [
            ("", "expected Visible"),
            ("infrared", "expected Visible"),
            ("299.9", "between 300 and 2500"),
            ("NaN", "between 300 and 2500"),
            ("PAR:700-400", "must rise"),
            ("PAR:400-", "expected Visible"),
            ("CIE-X:400-500", "none of CIE-X"),
            ("solar:400-500", "band name"),
            (":400-500", "1 to 40"),
        ] {
            let error = text.parse::<Band>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
        assert!(Band::named("FIR").unwrap().weights().is_none());
        assert!(Band::named("CIE-u").is_err());
    }
}
