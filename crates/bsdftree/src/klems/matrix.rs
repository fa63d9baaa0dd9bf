//! A BSDF component as a matrix over two angle bases.
//!
//! The incident patch is looked up by −incident.xy, so that a mirror's reflection and light that goes straight through
//! both lie on the diagonal.

use std::sync::{Arc, OnceLock};

use crate::cumulative::Cumulative;
use crate::direction::{Direction, Side};
use crate::hilbert::unfold;
use crate::klems::Basis;
use crate::shared::Shared;

/// A BSDF component over patches. Values are \[1/sr\], without a cosine.
pub struct Matrix {
    incident: Arc<Basis>,
    exitant: Arc<Basis>,
    /// One row of exitant patches per incident patch; those of a file may be any numbers.
    values: Shared<f32>,
    /// The same when they have been looked through; zeros if one is no BSDF's.
    checked: OnceLock<Shared<f32>>,
    /// For each incident patch, its exitant patches; and the other way round.
    cumulative: [OnceLock<Vec<Cumulative>>; 2],
}

impl Matrix {
    /// A matrix of values \[1/sr\], one row of exitant patches per incident patch.
    ///
    /// # Errors
    /// If the number of values is not that of the two bases, or one is negative, NaN or infinite.
    pub fn new(incident: Arc<Basis>, exitant: Arc<Basis>, values: Vec<f32>) -> Result<Matrix, String> {
        let (rows, columns) = (incident.n_patches(), exitant.n_patches());
        if values.len() != rows * columns {
            return Err(format!(
                "{} values; expected {rows} incident × {columns} exitant patches",
                values.len()
            ));
        }
        if let Some(k) = values.iter().position(|&v| !is_legal(v)) {
            let (i, o) = (k / columns, k % columns);
            return Err(format!(
                "value {} at incident patch {i}, exitant patch {o} is not a finite number ≥ 0",
                values[k]
            ));
        }
        let values = Shared::from(values);
        let checked = values.clone().into();
        Ok(Matrix { incident, exitant, values, checked, cumulative: [const { OnceLock::new() }; 2] })
    }

    /// The matrix of a file. Nothing is looked at but how many values there are: `None` if that is not as many as the bases say.
    pub(crate) fn unchecked(
        incident: Arc<Basis>,
        exitant: Arc<Basis>,
        values: Shared<f32>,
    ) -> Option<Matrix> {
        let (checked, cumulative) = (OnceLock::new(), [const { OnceLock::new() }; 2]);
        (values.len() == incident.n_patches() * exitant.n_patches()).then_some(Matrix {
            incident,
            exitant,
            values,
            checked,
            cumulative,
        })
    }

    /// What is wrong with a matrix of a file, and at which byte: a value or the checksum. Nothing is, with others.
    pub fn fault(&self) -> Option<(u64, String)> {
        let offset = self.values.stretch()?.offset() as u64;
        let wrong = self.values.iter().position(|&value| !is_legal(value));
        let wrong = wrong.map(|k| {
            (offset + 4 * k as u64, format!("the value {}, which is not a finite number ≥ 0", self.values[k]))
        });
        wrong.or_else(|| {
            (!self.values.is_as_written()).then(|| (offset, "values other than were written".into()))
        })
    }

    /// The basis of incident directions.
    pub fn incident(&self) -> &Arc<Basis> {
        &self.incident
    }

    /// The basis of exitant directions.
    pub fn exitant(&self) -> &Arc<Basis> {
        &self.exitant
    }

    /// The values \[1/sr\], one row of exitant patches per incident patch; all 0 if the file they come from is damaged
    /// ([`Matrix::fault`]).
    pub fn values(&self) -> &[f32] {
        self.checked.get_or_init(|| match self.values.iter().all(|&value| is_legal(value)) {
            true => self.values.clone(),
            false => vec![0.0; self.values.len()].into(),
        })
    }

    /// Incident and exitant patch of a pair of directions.
    pub fn patches(&self, incident: Direction, exitant: Direction) -> [usize; 2] {
        [self.incident.patch(opposite(incident)), self.exitant.patch(exitant)]
    }

    /// The BSDF \[1/sr\] for light from `incident` to `exitant`; which sides they lie on does not matter here.
    pub fn eval(&self, incident: Direction, exitant: Direction) -> f64 {
        let [i, o] = self.patches(incident, exitant);
        let value = self.values[i * self.exitant.n_patches() + o];
        if is_legal(value) { f64::from(value) } else { 0.0 }
    }

    /// The matrix for light that travels the other way, incident and exitant swapped: a patch's opposite is that of its middle turned by 180°.
    pub fn reversed(&self) -> Matrix {
        let opposites = |basis: &Basis| -> Vec<usize> {
            let middle = |k: usize| Side::Front.direction_from_disk(basis.disk_point(k, 0.5, 0.5));
            (0..basis.n_patches()).map(|k| basis.patch(opposite(middle(k)))).collect()
        };
        let (from, to) = (opposites(&self.incident), opposites(&self.exitant));
        let n = self.exitant.n_patches();
        let values =
            to.iter().flat_map(|&o| from.iter().map(move |&i| (i, o))).map(|(i, o)| self.values[i * n + o]);
        Matrix::new(Arc::clone(&self.exitant), Arc::clone(&self.incident), values.collect())
            .expect("the same values")
    }

    /// The matrix for light from `incident`; reversed as [`Tree::lobe`](crate::tree::Tree::lobe).
    pub fn lobe(&self, incident: Direction, reversed: bool) -> MatrixLobe<'_> {
        let patch =
            if reversed { self.exitant.patch(incident) } else { self.incident.patch(opposite(incident)) };
        MatrixLobe { matrix: self, patch, reversed, cumulative: &self.cumulative(reversed)[patch] }
    }

    /// Projected solid angle \[sr\] of the exitant patch of a pair of directions.
    pub fn projected_solid_angle(&self, exitant: Direction, reversed: bool) -> f64 {
        if reversed {
            self.incident.projected_solid_angle(self.incident.patch(opposite(exitant)))
        } else {
            self.exitant.projected_solid_angle(self.exitant.patch(exitant))
        }
    }

    /// Smallest and largest projected solid angle \[sr\] of an exitant patch.
    pub fn projected_solid_angle_range(&self, reversed: bool) -> [f64; 2] {
        let basis = if reversed { &self.incident } else { &self.exitant };
        (0..basis.n_patches())
            .map(|k| basis.projected_solid_angle(k))
            .fold([f64::INFINITY, 0.0], |[lo, hi], a| [lo.min(a), hi.max(a)])
    }

    /// Smallest value \[1/sr\].
    pub fn minimum(&self) -> f32 {
        self.values().iter().copied().fold(f32::INFINITY, f32::min)
    }

    /// Cumulative sums of each incident patch over the exitant ones, or the other way round.
    fn cumulative(&self, reversed: bool) -> &[Cumulative] {
        let (values, n_exitant) = (self.values(), self.exitant.n_patches());
        self.cumulative[usize::from(reversed)].get_or_init(|| {
            if reversed {
                let areas = areas(&self.incident);
                let weight = |i: usize, o: usize| f64::from(values[i * n_exitant + o]) * areas[i];
                (0..n_exitant).map(|o| Cumulative::new((0..areas.len()).map(|i| weight(i, o)))).collect()
            } else {
                let areas = areas(&self.exitant);
                let row =
                    |row: &[f32]| Cumulative::new(row.iter().zip(&areas).map(|(&f, a)| f64::from(f) * a));
                values.chunks_exact(n_exitant).map(row).collect()
            }
        })
    }
}

/// A matrix for one incident direction.
pub struct MatrixLobe<'a> {
    matrix: &'a Matrix,
    /// Incident patch, or, reversed, the exitant patch that the incident direction lies in.
    patch: usize,
    reversed: bool,
    cumulative: &'a Cumulative,
}

impl MatrixLobe<'_> {
    /// Directional-hemispherical total.
    pub fn total(&self) -> f64 {
        self.cumulative.total()
    }

    /// As [`TreeLobe::sample`](crate::tree::TreeLobe::sample).
    pub fn sample(&self, u: f64, v: Option<f64>) -> Option<([f64; 2], f64)> {
        let (patch, rest) = self.cumulative.find(u)?;
        let [u, v] = unfold(rest, v);
        let matrix = self.matrix;
        let n_exitant = matrix.exitant.n_patches();
        Some(if self.reversed {
            let value = matrix.values()[patch * n_exitant + self.patch];
            (matrix.incident.disk_point(patch, u, v).map(|c| -c), f64::from(value))
        } else {
            let value = matrix.values()[self.patch * n_exitant + patch];
            (matrix.exitant.disk_point(patch, u, v), f64::from(value))
        })
    }
}

fn areas(basis: &Basis) -> Vec<f64> {
    (0..basis.n_patches()).map(|k| basis.projected_solid_angle(k)).collect()
}

/// Whether a BSDF may have it.
fn is_legal(value: f32) -> bool {
    (0.0..f32::INFINITY).contains(&value)
}

/// Turned by 180° about the normal.
fn opposite([x, y, z]: Direction) -> Direction {
    [-x, -y, z]
}

impl Clone for Matrix {
    fn clone(&self) -> Matrix {
        Matrix {
            incident: Arc::clone(&self.incident),
            exitant: Arc::clone(&self.exitant),
            values: self.values.clone(),
            checked: self.checked.clone(),
            cumulative: [const { OnceLock::new() }; 2],
        }
    }
}

impl std::fmt::Debug for Matrix {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Matrix")
            .field("incident", &self.incident.name())
            .field("exitant", &self.exitant.name())
            .finish()
    }
}
