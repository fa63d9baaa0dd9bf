//! Matrices from a list of numbers.

use std::sync::Arc;

use super::error::{Fault, XmlError};
use super::number::{Cursor, Negatives};
use crate::klems::{Basis, Matrix};

/// Which direction a line of the text belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// A line for each exitant patch, a column for each incident one.
    Columns,
    /// A line for each incident patch.
    Rows,
}

/// All numbers of a text that stands at `base` in the file.
pub(super) fn numbers(text: &[u8], base: usize, negatives: &mut Negatives) -> Result<Vec<f32>, XmlError> {
    let mut cursor = Cursor::new(text, base);
    let mut values = Vec::new();
    while cursor.peek().is_some() {
        cursor.plain_numbers(&mut values);
        if cursor.peek().is_none() {
            break;
        }
        values.push(cursor.number(negatives)?);
    }
    Ok(values)
}

/// The matrix of values over the one pair of bases that has as many: each name may stand for several.
pub(super) fn matrix(
    values: Vec<f32>,
    [incident, exitant]: [&[Arc<Basis>]; 2],
    layout: Layout,
    offset: usize,
) -> Result<Matrix, XmlError> {
    let pairs = || incident.iter().flat_map(|i| exitant.iter().map(move |o| (i, o)));
    let size = |i: &Arc<Basis>, o: &Arc<Basis>| i.n_patches() * o.n_patches();
    let Some((i, o)) = pairs().find(|(i, o)| size(i, o) == values.len()) else {
        let mut sizes: Vec<usize> = pairs().map(|(i, o)| size(i, o)).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let sizes: Vec<String> = sizes.iter().map(usize::to_string).collect();
        let (i, o) = (incident[0].name(), exitant[0].name());
        let expected = format!("{} for {i} by {o}", sizes.join(" or "));
        return Err(XmlError::new(
            offset,
            Fault::WrongCount { found: format!("{} values in the matrix", values.len()), expected },
        ));
    };
    let values = match layout {
        Layout::Rows => values,
        Layout::Columns => transposed(&values, i.n_patches()),
    };
    Matrix::new(Arc::clone(i), Arc::clone(o), values)
        .map_err(|problem| XmlError::new(offset, Fault::Basis { name: i.name().into(), problem }))
}

/// Lines of `width` values, turned into columns.
pub(super) fn transposed(values: &[f32], width: usize) -> Vec<f32> {
    let height = values.len() / width;
    let mut turned = Vec::with_capacity(values.len());
    for column in 0..width {
        turned.extend((0..height).map(|row| values[row * width + column]));
    }
    turned
}
