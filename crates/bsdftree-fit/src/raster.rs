//! Numbers over the disk of a hemisphere at evenly spaced pixels, looked up bilinearly.

use crate::lambert;

/// Half the edge of the square that pixels cover: a margin beyond the horizon for what is moved across it.
pub(crate) const EXTENT: f32 = 1.125;

/// One number for each pixel, row by row.
#[derive(Clone, Debug)]
pub(crate) struct Raster {
    n: usize,
    values: Vec<f32>,
}

impl Raster {
    pub fn new(n: usize, values: Vec<f32>) -> Raster {
        assert_eq!(values.len(), n * n);
        Raster { n, values }
    }

    /// Point of the disk in the middle of a pixel.
    pub fn center(n: usize, column: usize, row: usize) -> [f32; 2] {
        let step = 2.0 * EXTENT / n as f32;
        [(column as f32 + 0.5) * step - EXTENT, (row as f32 + 0.5) * step - EXTENT]
    }

    /// Direction of every pixel.
    pub fn directions(n: usize) -> impl Iterator<Item = lambert::Ray> {
        (0..n * n).map(move |k| lambert::direction(Raster::center(n, k % n, k / n)))
    }

    pub fn n(&self) -> usize {
        self.n
    }

    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// A number for each pixel made of its direction and its value.
    pub fn map(&self, mut f: impl FnMut(lambert::Ray, f32) -> f32) -> Raster {
        let values = Raster::directions(self.n).zip(&self.values).map(|(d, &v)| f(d, v)).collect();
        Raster { n: self.n, values }
    }

    /// Number of the pixel that a point lies in, or of the nearest.
    #[inline(always)]
    pub fn pixel(n: usize, [x, y]: [f32; 2]) -> usize {
        let at = |c: f32| (((c + EXTENT) * (n as f32 / (2.0 * EXTENT))).max(0.0) as usize).min(n - 1);
        at(y) * n + at(x)
    }

    /// Bilinear between pixels, the outermost ones beyond.
    #[inline(always)]
    pub fn at(&self, [x, y]: [f32; 2]) -> f32 {
        let n = self.n;
        let scale = n as f32 / (2.0 * EXTENT);
        let limit = n as f32 - 1.000_1;
        let u = ((x + EXTENT) * scale - 0.5).max(0.0).min(limit);
        let v = ((y + EXTENT) * scale - 0.5).max(0.0).min(limit);
        let (i, j) = (u as usize, v as usize);
        let (s, t) = (u - i as f32, v - j as f32);
        let rows = &self.values[j * n + i..j * n + i + n + 2];
        let lower = rows[0] + s * (rows[1] - rows[0]);
        let upper = rows[n] + s * (rows[n + 1] - rows[n]);
        lower + t * (upper - lower)
    }
}
