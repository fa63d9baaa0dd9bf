//! Spectra of a scene file: `spectrum`, `specfile`, `specfunc`, `specdata`, `specpict`.
//!
//! In: a primitive and where it stands. Out: a [`Modifier`], or the [`Problem`] a surface using it runs into. Source: Radiance's
//! reference manual ("Patterns").

use std::rc::Rc;

use super::field::{FieldReader, Layout};
use super::library::Standing;
use super::modifier::Described;
use super::problem::Problem;
use super::statement::Primitive;
use crate::error::DeviceError;
use crate::field::{Spectral, SpectralField, SpectralSource};
use crate::material::Modifier;

/// Whether the arguments of a type begin with functions, as those of all other patterns do.
pub(super) fn has_functions(kind: &str) -> bool {
    !matches!(kind, "spectrum" | "specfile")
}

/// An error if the numbers of arguments do not fit the type, but for those that a layout says.
pub(super) fn check_counts(p: &Primitive, standing: &Standing) -> Result<(), DeviceError> {
    let (right, expected) = match &*p.kind {
        "spectrum" => (
            p.strings.is_empty() && p.reals.len() >= 5,
            "no string and at least 5 real arguments (nmA nmB s1 s2 s3 …)",
        ),
        "specfile" => {
            (p.strings.len() == 1 && p.reals.is_empty(), "1 string argument (datafile) and no real ones")
        }
        "specfunc" => (p.reals.len() >= 2, "at least 2 real arguments (nmA nmB)"),
        _ => (true, ""),
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

/// The modifier of a spectrum whose counts are right.
pub(super) fn describe(reader: &mut FieldReader, layout: Layout) -> Described<Modifier> {
    match &*reader.p.kind {
        "spectrum" => spectrum(reader),
        "specfile" => specfile(reader),
        _ => field(reader, layout).map(|(field, notice)| (Modifier::SpectralField(field), notice)),
    }
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

/// What depends on the place.
fn field(reader: &mut FieldReader, layout: Layout) -> Described<SpectralField> {
    let functions = reader.functions(layout)?;
    let n_parameters = if reader.p.kind == "specfunc" { 1 } else { 2 };
    let function = reader.call(&functions, &reader.p.strings[0], n_parameters)?;
    let first = layout.file() + 1;
    let (source, used) = match &*reader.p.kind {
        "specfunc" => {
            let [a, b] = [reader.p.reals[0], reader.p.reals[1]];
            if a == b {
                return Err(wrong_range(reader, &format!("{a} twice")));
            }
            (SpectralSource::Function { function, range_nm: [a.min(b), a.max(b)] }, first)
        }
        "specdata" => {
            let data = reader.library.data(&reader.p.strings[1], reader.standing)?;
            let n = data.dimensions().len() - 1;
            if n == 0 {
                let expected = format!(
                    "a data file of two or more dimensions, the last one of wavelengths in nm, for {}",
                    reader.name()
                );
                let found = "1 dimension; specfile takes that";
                return Err(Rc::new(Problem::value(reader.standing.at, expected, found)));
            }
            let coordinates = reader.formulas(&functions, first, n)?;
            (SpectralSource::Data { function, data, coordinates }, first + n)
        }
        _ => {
            let picture = reader.library.spectral_picture(&reader.p.strings[1], reader.standing)?;
            let coordinates = reader.formulas(&functions, first, 2)?;
            (SpectralSource::Picture { function, picture, coordinates }, first + 2)
        }
    };
    let (space, notice) = reader.space(&functions, used)?;
    Ok((SpectralField { space, source }, notice))
}

fn wrong_range(reader: &FieldReader, found: &str) -> Rc<Problem> {
    let expected = format!("different wavelengths in {}", reader.name());
    Rc::new(Problem::value(reader.standing.at, expected, found))
}
