//! Pattern, texture and mixture primitives of a scene file.
//!
//! In: a primitive and where it stands. Out: a [`Modifier`], or the amount of a mixture, whose sides are names of other
//! definitions. Source: Radiance's reference manual ("Patterns", "Textures", "Mixtures").

use std::rc::Rc;

use super::field::{FieldReader, Layout};
use super::library::Standing;
use super::problem::Problem;
use super::statement::Primitive;
use super::{spectral, text};
use crate::error::DeviceError;
use crate::field::Field;
use crate::material::Modifier;

/// A modifier or an amount, and what the user should know if it is used.
pub(super) type Described<T> = Result<(T, Option<String>), Rc<Problem>>;

const FORMULA: Layout = Layout {
    skipped: 0,
    n_functions: 1,
    n_data: 0,
    picture: false,
    expected: "formula funcfile [transform]",
};
const DATA: Layout = Layout {
    skipped: 0,
    n_functions: 1,
    n_data: 1,
    picture: false,
    expected: "func datafile funcfile x0 [x1 …] [transform]",
};

/// The string arguments of a pattern, texture or mixture.
fn layout(kind: &str) -> Layout {
    match kind {
        "brightfunc" | "specfunc" => FORMULA,
        "colorfunc" | "texfunc" => {
            Layout { n_functions: 3, expected: "formula formula formula funcfile [transform]", ..FORMULA }
        }
        "brightdata" | "specdata" => DATA,
        "specpict" => Layout { picture: true, expected: "func specfile funcfile u v [transform]", ..DATA },
        "colordata" | "texdata" => Layout {
            n_functions: 3,
            n_data: 3,
            expected: "func func func datafile datafile datafile funcfile x0 [x1 …] [transform]",
            ..DATA
        },
        "colorpict" => Layout {
            n_functions: 3,
            picture: true,
            expected: "func func func picture funcfile u v [transform]",
            ..DATA
        },
        "mixfunc" => {
            Layout { skipped: 2, expected: "foreground background formula funcfile [transform]", ..FORMULA }
        }
        "mixdata" => Layout {
            skipped: 2,
            expected: "foreground background func datafile funcfile x0 [x1 …] [transform]",
            ..DATA
        },
        _ => Layout {
            skipped: 2,
            picture: true,
            expected: "foreground background func picture funcfile u v [transform]",
            ..DATA
        },
    }
}

/// An error if the numbers of arguments do not fit the type.
pub(super) fn check_counts(p: &Primitive, standing: &Standing) -> Result<(), DeviceError> {
    if text::is_one(&p.kind) {
        return text::check_counts(p, standing);
    }
    spectral::check_counts(p, standing)?;
    if spectral::has_functions(&p.kind) { layout(&p.kind).check(p, standing) } else { Ok(()) }
}

/// The modifier of a pattern or texture whose counts are right.
pub(super) fn describe(mut reader: FieldReader) -> Described<Modifier> {
    let layout = layout(&reader.p.kind);
    match &*reader.p.kind {
        "brightfunc" | "brightdata" => {
            reader.field(layout).map(|(field, notice)| (Modifier::Brightness(field), notice))
        }
        "colorfunc" | "colordata" | "colorpict" => {
            reader.field(layout).map(|(field, notice)| (Modifier::Color(field), notice))
        }
        "texfunc" | "texdata" => {
            reader.field(layout).map(|(field, notice)| (Modifier::Texture(field), notice))
        }
        "brighttext" => text::field(&mut reader).map(|field| (Modifier::Brightness(field), None)),
        "colortext" => text::field(&mut reader).map(|field| (Modifier::Color(field), None)),
        _ => spectral::describe(&mut reader, layout),
    }
}

/// How much a mixture has of its foreground.
pub(super) fn amount(mut reader: FieldReader) -> Described<Field<1>> {
    match &*reader.p.kind {
        "mixtext" => text::field(&mut reader).map(|field| (field, None)),
        kind => reader.field(layout(kind)),
    }
}
