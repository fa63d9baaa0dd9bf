//! Colours from entities.
//!
//! In: `cxy`, `cct`, `cspec`, `cmix` and the colours that have names. Out: a [`Color`], or what is wrong with the arguments.

use super::color::Color;
use super::context::Contexts;
use super::entity::Entity;
use crate::error::DeviceError;
use crate::rad::quoted;

/// The colour that `cxy`, `cct`, `cspec` or `cmix` makes.
pub(super) fn color(entity: &Entity<'_>, named: &Contexts<Color>) -> Result<Color, DeviceError> {
    let color = match entity.keyword {
        "cxy" => {
            entity.count(2..=2, "x and y")?;
            Color::of_xy(entity.number(0, "a number")?, entity.number(1, "a number")?)
        }
        "cct" => {
            entity.count(1..=1, "a temperature")?;
            Color::of_black_body(entity.number_within(0, 1000.0.., "at least 1000 K")?)
        }
        "cspec" => {
            entity.count(4.., "first and last wavelength in nm and at least two values")?;
            let first = entity.number(0, "a wavelength")?;
            let last = entity.number(1, "a wavelength")?;
            if last <= first {
                let found = format!("{first} to {last}");
                return Err(entity.unexpected("a last wavelength above the first", found, ""));
            }
            let values: Result<Vec<f64>, _> =
                (2..entity.arguments.len()).map(|k| entity.number(k, "a number")).collect();
            Color::of_spectrum([first, last], &values?)
        }
        _ => {
            entity.count(4.., "weight and name of at least two colours")?;
            if entity.arguments.len() % 2 == 1 {
                return Err(entity.unexpected("a name for each weight", "a weight alone".to_owned(), ""));
            }
            let part = |k: usize| {
                let weight = entity.number_within(2 * k, 0.0.., "a weight of at least 0")?;
                Ok((weight, *named.get(entity.arguments[2 * k + 1], &entity.at)?))
            };
            let parts: Result<Vec<_>, DeviceError> = (0..entity.arguments.len() / 2).map(part).collect();
            Color::mixed(&parts?)
        }
    };
    let expected = match entity.keyword {
        "cxy" => "x ≥ 0, y > 0 and x + y ≤ 1",
        "cmix" => "a weight above 0",
        _ => "light between 380 and 780 nm",
    };
    color.ok_or_else(|| entity.unexpected(expected, quoted(&entity.arguments.join(" ")), ""))
}
