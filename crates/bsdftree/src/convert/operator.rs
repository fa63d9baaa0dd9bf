//! Light through layers as matrices of flux, rows incident, columns exitant: products, and all that goes to and fro between two layers.
//!
//! An index means the same direction of travel everywhere: what leaves one layer through a cell arrives at the next in the incident cell
//! of that number. Source: J. H. Klems, ASHRAE Transactions 100, 1994. The inverse is the product (I + A)(I + A²)(I + A⁴)…, which
//! needs products only.

use super::ConvertError;
use crate::bsdf::Part;

/// A square matrix, row-major.
#[derive(Clone)]
pub(super) struct Operator {
    /// Rows, columns.
    pub n: usize,
    /// Row-major; a row is an incident cell.
    pub values: Vec<f64>,
}

/// A layer or stack: what happens to light from the outside (front) and from the room (back).
#[derive(Clone)]
pub(super) struct Layer {
    /// By [`Part`] as a number.
    pub parts: [Operator; 4],
}

/// What arrives between two layers or stacks, all that goes to and fro counted.
pub(super) struct Between {
    /// From the outside, on the way to the room: T1f (I − R2f R1b)⁻¹.
    pub inward: Operator,
    /// From the room, on the way to the outside: T2b (I − R1b R2f)⁻¹.
    pub outward: Operator,
}

impl Layer {
    /// The operator of a part.
    pub fn part(&self, part: Part) -> &Operator {
        &self.parts[part as usize]
    }

    /// What there is between this layer or stack and one behind it, towards the room.
    pub fn between(&self, behind: &Layer) -> Result<Between, ConvertError> {
        let (r1b, r2f) = (self.part(Part::ReflectionBack), behind.part(Part::ReflectionFront));
        Ok(Between {
            inward: self.part(Part::TransmissionFront).times(&r2f.times(r1b).resolvent()?),
            outward: behind.part(Part::TransmissionBack).times(&r1b.times(r2f).resolvent()?),
        })
    }

    /// This layer or stack with another behind it, towards the room.
    pub fn followed_by(&self, behind: &Layer) -> Result<Layer, ConvertError> {
        let Between { inward, outward } = self.between(behind)?;
        let (r1b, r2f) = (self.part(Part::ReflectionBack), behind.part(Part::ReflectionFront));
        let (t1b, t2f) = (self.part(Part::TransmissionBack), behind.part(Part::TransmissionFront));
        let mut made = self.clone();
        made.parts[Part::ReflectionFront as usize].add(&inward.times(r2f).times(t1b));
        made.parts[Part::ReflectionBack as usize] = behind.part(Part::ReflectionBack).clone();
        made.parts[Part::ReflectionBack as usize].add(&outward.times(r1b).times(t2f));
        made.parts[Part::TransmissionFront as usize] = inward.times(t2f);
        made.parts[Part::TransmissionBack as usize] = outward.times(t1b);
        Ok(made)
    }
}

impl Operator {
    /// The product.
    pub fn times(&self, other: &Operator) -> Operator {
        let n = self.n;
        let mut values = vec![0.0; n * n];
        let stride = n as isize;
        // SAFETY: all three are n × n, row-major, and `values` is none of the others.
        unsafe {
            matrixmultiply::dgemm(
                n,
                n,
                n,
                1.0,
                self.values.as_ptr(),
                stride,
                1,
                other.values.as_ptr(),
                stride,
                1,
                0.0,
                values.as_mut_ptr(),
                stride,
                1,
            );
        }
        Operator { n, values }
    }

    /// Adds another.
    pub fn add(&mut self, other: &Operator) {
        self.values.iter_mut().zip(&other.values).for_each(|(a, b)| *a += b);
    }

    /// What of the light of each row there is in all.
    pub fn totals(&self) -> Vec<f64> {
        self.values.chunks_exact(self.n).map(|row| row.iter().sum()).collect()
    }

    /// The product with a column.
    pub fn apply(&self, column: &[f64]) -> Vec<f64> {
        let row_times = |row: &[f64]| row.iter().zip(column).map(|(a, b)| a * b).sum();
        self.values.chunks_exact(self.n).map(row_times).collect()
    }

    /// (I − self)⁻¹.
    fn resolvent(self) -> Result<Operator, ConvertError> {
        /// Light that is left when 2^24 reflections have been followed is not going to leave.
        const MAX_DOUBLINGS: usize = 24;
        let n = self.n;
        let mut sum = Operator { n, values: vec![0.0; n * n] };
        (0..n).for_each(|k| sum.values[k * n + k] = 1.0);
        let mut power = self;
        for _ in 0..MAX_DOUBLINGS {
            // sum ← sum + sum·power
            let more = sum.times(&power);
            sum.add(&more);
            let left = power.values.chunks_exact(n).map(|row| row.iter().sum::<f64>()).fold(0.0, f64::max);
            if left < 1e-12 {
                return Ok(sum);
            }
            if !left.is_finite() {
                break;
            }
            power = power.times(&power);
        }
        Err(ConvertError::Trapped)
    }
}
