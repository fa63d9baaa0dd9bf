//! Units of length of scene files; inside, everything is in metres.

use std::str::FromStr;

use bsdftree::LengthUnit;

use crate::error::DeviceError;

/// The unit that the numbers of a scene file are in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    /// 1 m.
    #[default]
    Meter,
    /// 0.3048 m.
    Foot,
    /// 0.0254 m.
    Inch,
    /// 0.01 m.
    Centimeter,
    /// 0.001 m.
    Millimeter,
}

impl Unit {
    /// Length of the unit \[m\].
    pub fn meters(self) -> f64 {
        match self {
            Unit::Meter => 1.0,
            Unit::Foot => 0.3048,
            Unit::Inch => 0.0254,
            Unit::Centimeter => 0.01,
            Unit::Millimeter => 0.001,
        }
    }
}

impl From<LengthUnit> for Unit {
    fn from(unit: LengthUnit) -> Unit {
        match unit {
            LengthUnit::Meter => Unit::Meter,
            LengthUnit::Foot => Unit::Foot,
            LengthUnit::Inch => Unit::Inch,
            LengthUnit::Centimeter => Unit::Centimeter,
            LengthUnit::Millimeter => Unit::Millimeter,
        }
    }
}

impl FromStr for Unit {
    type Err = DeviceError;

    /// The names of WINDOW 6 XML (`Meter`, `Foot`, `Inch`, `Centimeter`, `Millimeter`) in any case, British
    /// spelling, plural and the symbols m, ft, in, cm, mm.
    fn from_str(text: &str) -> Result<Self, DeviceError> {
        match text.to_ascii_lowercase().as_str() {
            "meter" | "metre" | "meters" | "metres" | "m" => Ok(Unit::Meter),
            "foot" | "feet" | "ft" => Ok(Unit::Foot),
            "inch" | "inches" | "in" => Ok(Unit::Inch),
            "centimeter" | "centimetre" | "centimeters" | "centimetres" | "cm" => Ok(Unit::Centimeter),
            "millimeter" | "millimetre" | "millimeters" | "millimetres" | "mm" => Ok(Unit::Millimeter),
            _ => Err(DeviceError::Unit(text.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_in_any_case() {
        for (text, meters) in
            [("meter", 1.0), ("FOOT", 0.3048), ("Inch", 0.0254), ("centiMeter", 0.01), ("mm", 0.001)]
        {
            assert_eq!(text.parse::<Unit>().unwrap().meters(), meters);
        }
    }

    #[test]
    fn unknown_unit_lists_the_known_ones() {
        assert!("cubit".parse::<Unit>().unwrap_err().to_string().contains("foot, inch"));
    }
}
