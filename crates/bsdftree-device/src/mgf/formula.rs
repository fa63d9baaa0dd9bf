//! Formulas that materials need, of the standard names alone.
//!
//! In: formulas in words. Out: a field of them, as one that a scene file holds without a function file; and back, numbers of a field that
//! is made of numbers.

use std::sync::Arc;

use glam::DAffine3;

use crate::cal::Context;
use crate::error::Place;
use crate::field::{Field, File, Formulas, Origin, Source, Space};
use crate::rad::real;

/// A field of formulas that are known to be right, with the real arguments of the primitive that it would stand in.
pub(super) fn field<const N: usize>(
    formulas: [&str; N],
    arguments: &[f64],
    kind: &str,
    name: &str,
    at: &Place,
) -> Field<N> {
    let origin = Origin { kind: kind.into(), name: name.into(), at: at.clone() };
    let file = File { path: ".".into(), digest: 0 };
    let space = Space::new(origin, file, arguments.into(), DAffine3::IDENTITY, 1.0, 1.0);
    let expressions = Context::rayinit().compile_all(formulas, at).expect("our own formulas");
    let formulas = Formulas { texts: formulas.map(Arc::from).to_vec(), expressions };
    Field { space: Arc::new(space), source: Source::Formulas(formulas) }
}

/// A field that is the same everywhere.
pub(super) fn constant<const N: usize>(
    numbers: [f64; N],
    arguments: &[f64],
    kind: &str,
    name: &str,
    at: &Place,
) -> Field<N> {
    let words = numbers.map(|x| format!("{x:?}"));
    field(words.each_ref().map(String::as_str), arguments, kind, name, at)
}

/// The words of a field of formulas of the standard names alone.
pub(super) fn words<const N: usize>(field: &Field<N>) -> Option<[&str; N]> {
    match &field.source {
        Source::Formulas(formulas) if field.space.file.digest == 0 => {
            formulas.texts.iter().map(|text| &**text).collect::<Vec<_>>().try_into().ok()
        }
        _ => None,
    }
}

/// The numbers of a field that is made of numbers.
pub(super) fn numbers<const N: usize>(field: &Field<N>) -> Option<[f64; N]> {
    let Source::Formulas(formulas) = &field.source else { return None };
    let numbers: Option<Vec<f64>> = formulas.texts.iter().map(|text| real(text)).collect();
    numbers?.try_into().ok()
}
