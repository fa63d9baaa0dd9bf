//! Text of a scene file: `brighttext`, `colortext`, `mixtext`.
//!
//! In: a primitive and where it stands. Out: a [`Field`] of two values, one on letters and one beside them; of a mixture 1 and 0.
//! String arguments are, after the sides of a mixture, a font file, and a text file; or any word (commonly `.`) instead of that and
//! words, which are one line. Source: Radiance's reference manual ("Colortext", "Brighttext", "Mixtext").

use std::rc::Rc;
use std::sync::Arc;

use glam::DVec3;

use super::field::FieldReader;
use super::library::Standing;
use super::problem::Problem;
use super::statement::Primitive;
use super::transform::Transform;
use crate::error::DeviceError;
use crate::field::{Field, Source, Text, Words};

/// Whether a type is one of these.
pub(super) fn is_one(kind: &str) -> bool {
    matches!(kind, "brighttext" | "colortext" | "mixtext")
}

/// How many string arguments stand before the font, and how many numbers each of both values has.
fn layout(kind: &str) -> (usize, usize) {
    match kind {
        "brighttext" => (0, 1),
        "colortext" => (0, 3),
        _ => (2, 0),
    }
}

/// An error if the numbers of arguments do not fit the type.
pub(super) fn check_counts(p: &Primitive, standing: &Standing) -> Result<(), DeviceError> {
    let (skipped, n_values) = layout(&p.kind);
    if p.strings.len() >= skipped + 2 && p.reals.len() >= 9 + 2 * n_values {
        return Ok(());
    }
    let sides = if skipped > 0 { "foreground background " } else { "" };
    let values = ["", " foreground background", "", " foreground background, 3 numbers each"][n_values];
    Err(DeviceError::Unexpected {
        at: standing.at.clone(),
        expected: format!(
            "string arguments {sides}fontfile textfile, or {sides}fontfile . word …, and real arguments Ox Oy Oz \
             Rx Ry Rz Dx Dy Dz{values} [spacing] of {} \"{}\"",
            p.kind, p.name
        ),
        found: format!("{} and {}", p.strings.len(), p.reals.len()),
        advice: String::new(),
    })
}

/// What is on letters and beside them.
pub(super) fn field<const N: usize>(reader: &mut FieldReader) -> Result<Field<N>, Rc<Problem>> {
    let (skipped, n_values) = layout(&reader.p.kind);
    let (strings, reals) = (&reader.p.strings[skipped..], &reader.p.reals);
    let font = reader.library.font(&strings[0], reader.standing)?;
    let (words, bytes) = if strings.len() > 2 {
        let line = strings[2..].join(" ");
        (Words::Line(line.clone()), line.into_bytes())
    } else {
        let (file, bytes) = reader.library.text(&strings[1], reader.standing)?;
        (Words::File(file), bytes)
    };
    let vectors = [0, 3, 6].map(|first| DVec3::from_slice(&reals[first..]));
    let spacing = reals.get(9 + 2 * n_values).copied();
    let space = reader.space_of(font.file.clone(), &Transform::IDENTITY)?;
    let text = Text::new(font, words, &bytes, vectors, spacing).map_err(|(expected, found)| {
        Rc::new(Problem::value(reader.standing.at, format!("{expected} of {}", reader.name()), found))
    })?;
    // Of a mixture it is how much there is of the foreground.
    let value = |first: usize, of_mixture: f64| {
        std::array::from_fn(|k| if n_values > 0 { reals[first + k] } else { of_mixture })
    };
    let (foreground, background) = (value(9, 1.0), value(9 + n_values, 0.0));
    Ok(Field { space, source: Source::Text { text: Arc::new(text), foreground, background } })
}
