//! Pattern, texture and mixture primitives of a scene file.
//!
//! In: a primitive and where it stands. Out: a [`Modifier`], or the amount of a mixture, whose sides are names of other
//! definitions. Source: Radiance's reference manual ("Patterns", "Textures", "Mixtures").

use std::rc::Rc;

use super::field::{FieldReader, Layout};
use super::library::Standing;
use super::problem::Problem;
use super::statement::Primitive;
use crate::error::DeviceError;
use crate::field::{Field, Spectral, SpectralFunction};
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
        "brightdata" => DATA,
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
    let (right, expected) = match &*p.kind {
        "spectrum" => (
            p.strings.is_empty() && p.reals.len() >= 5,
            "no string and at least 5 real arguments (nmA nmB s1 s2 s3 …)",
        ),
        "specfile" => {
            (p.strings.len() == 1 && p.reals.is_empty(), "1 string argument (datafile) and no real ones")
        }
        "specfunc" if p.reals.len() < 2 => (false, "at least 2 real arguments (nmA nmB)"),
        _ => return layout(&p.kind).check(p, standing),
    };
    if right {
        return Ok(());
    }
    Err(DeviceError::Unexpected {
        at: standing.at.clone(),
        expected: format!("{expected} of {} \"{}\"", p.kind, p.name),
        found: format!("{} and {}", p.strings.len(), p.reals.len()),
        advice: String::new(),
    })
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
        "specfunc" => specfunc(&mut reader, layout),
        "spectrum" => spectrum(&reader),
        _ => specfile(&mut reader),
    }
}

/// How much a mixture has of its foreground.
pub(super) fn amount(mut reader: FieldReader) -> Described<Field<1>> {
    reader.field(layout(&reader.p.kind))
}

fn specfunc(reader: &mut FieldReader, layout: Layout) -> Described<Modifier> {
    let functions = reader.functions(layout)?;
    let function = reader.call(&functions, &reader.p.strings[0], 1)?;
    let (space, notice) = reader.space(&functions, layout.file() + 1)?;
    let [a, b] = [reader.p.reals[0], reader.p.reals[1]];
    if a == b {
        return Err(wrong_range(reader, &format!("{a} twice")));
    }
    let range_nm = [a.min(b), a.max(b)];
    Ok((Modifier::SpectralFunction(SpectralFunction { space, function, range_nm }), notice))
}

fn spectrum(reader: &FieldReader) -> Described<Modifier> {
    let [a, b, values @ ..] = &reader.p.reals[..] else { unreachable!("counts are right") };
    let step = (b - a) / (values.len() - 1) as f64;
    let wavelengths = (0..values.len()).map(|k| a + k as f64 * step).collect();
    match Spectral::new(wavelengths, values.to_vec()) {
        Some(spectral) => Ok((Modifier::Spectrum(spectral), None)),
        None => Err(wrong_range(reader, &format!("{a} twice"))),
    }
}

fn specfile(reader: &mut FieldReader) -> Described<Modifier> {
    let data = reader.library.data(&reader.p.strings[0], reader.standing)?;
    let [dimension] = data.dimensions() else {
        let expected = format!("a data file of one dimension, wavelengths in nm, for {}", reader.name());
        let found = format!("{} dimensions", data.dimensions().len());
        return Err(Rc::new(Problem::value(reader.standing.at, expected, found)));
    };
    let wavelengths = (0..dimension.n()).map(|k| dimension.abscissa(k)).collect();
    match Spectral::new(wavelengths, data.values().to_vec()) {
        Some(spectral) => {
            Ok((Modifier::Spectrum(Spectral { file: Some(data.file.clone()), ..spectral }), None))
        }
        None => Err(wrong_range(reader, "others")),
    }
}

fn wrong_range(reader: &FieldReader, found: &str) -> Rc<Problem> {
    let expected = format!("different wavelengths in {}", reader.name());
    Rc::new(Problem::value(reader.standing.at, expected, found))
}
