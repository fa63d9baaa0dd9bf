//! `.bsdf` files of EPFL's RGL material database.
//!
//! In: a [tensor file](super::tensor_file) with the fields `theta_i`, `phi_i` \[rad\], `ndf` D, `sigma` σ, `vndf`, and `rgb` or `spectra` with
//! `wavelengths`. Out: a scan for each incident direction of the file, at points around the mirrored direction, as X, Y, Z.
//!
//! Values are stored over the square that equal amounts of visible microfacets fill: f cos θ_o = s(v(u_h)) D(u_h)/(4 σ(u_i)), where u is
//! (√(2θ/π), (φ + π)/2π) of a direction and v maps u_h of the half vector to what the distribution `vndf`, which is bilinear, has
//! accumulated there: along φ over all θ, then along θ. In isotropic files (at most two φ_i) φ is counted from the light's. Only incident
//! directions of the file are looked at, so nothing is interpolated between them. If there is a field `jacobian` that is 0, values are
//! s(v(u_h)) alone. Azimuths of the light that are half of a turn mean that the other half is the same turned by half a turn; a quarter,
//! that it is the same mirrored at both axes.
//!
//! Source: J. Dupuy and W. Jakob, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering", SIGGRAPH Asia 2018.
//! X, Y, Z of spectra are those of [`super::spectrum`].

use std::f64::consts::{PI, TAU};

use bsdftree::Direction;
use bsdftree::color::xyz_from_rgb;
use bsdftree::direction::{direction_from_polar, normalized};

use crate::measurement::{Measurement, Scan, Symmetry};

use super::error::ReadError;
use super::points::around_mirror;
use super::spectrum::weights;
use super::tensor_file::TensorFile;

/// Light from lower than this is left out \[rad\]: 89°.
const LARGEST_THETA: f64 = 1.5533;

/// A table over the unit square, bilinear; the second coordinate is that of rows.
struct Table<'a> {
    n_x: usize,
    n_y: usize,
    values: &'a [f32],
}

impl<'a> Table<'a> {
    /// The last two axes of a field; the slice of that number.
    fn slice(shape: &[usize], values: &'a [f32], number: usize) -> Table<'a> {
        let [.., n_y, n_x] = *shape else { unreachable!("fields are asked for with two axes or more") };
        Table { n_x, n_y, values: &values[number * n_x * n_y..(number + 1) * n_x * n_y] }
    }

    fn at(&self, column: usize, row: usize) -> f64 {
        f64::from(self.values[row * self.n_x + column])
    }

    /// The cell that a point lies in, and where in it.
    fn cell(&self, [x, y]: [f64; 2]) -> ([usize; 2], [f64; 2]) {
        let along = |t: f64, n: usize| {
            let scaled = t.clamp(0.0, 1.0) * (n - 1) as f64;
            let cell = (scaled as usize).min(n.saturating_sub(2));
            (cell, scaled - cell as f64)
        };
        let ((column, a), (row, b)) = (along(x, self.n_x), along(y, self.n_y));
        ([column, row], [a, b])
    }

    fn eval(&self, point: [f64; 2]) -> f64 {
        let ([column, row], [a, b]) = self.cell(point);
        let (right, below) = ((column + 1).min(self.n_x - 1), (row + 1).min(self.n_y - 1));
        let along = |row: usize| self.at(column, row) * (1.0 - a) + self.at(right, row) * a;
        along(row) * (1.0 - b) + along(below) * b
    }
}

/// What a bilinear distribution has accumulated: rows of sums along each row, and sums of rows, both by the trapezoidal rule.
struct Accumulated<'a> {
    density: Table<'a>,
    along: Vec<f64>,
    rows: Vec<f64>,
}

impl<'a> Accumulated<'a> {
    fn new(density: Table<'a>) -> Accumulated<'a> {
        let (n_x, n_y) = (density.n_x, density.n_y);
        let mut along = vec![0.0; n_x * n_y];
        for row in 0..n_y {
            for column in 1..n_x {
                let step = 0.5 * (density.at(column - 1, row) + density.at(column, row));
                along[row * n_x + column] = along[row * n_x + column - 1] + step;
            }
        }
        let mut rows = vec![0.0; n_y];
        for row in 1..n_y {
            rows[row] = rows[row - 1] + 0.5 * (along[row * n_x - 1] + along[(row + 1) * n_x - 1]);
        }
        Accumulated { density, along, rows }
    }

    /// The part of everything that lies in rows before a point, and the part of its row that lies in columns before it.
    fn before(&self, point: [f64; 2]) -> [f64; 2] {
        let ([column, row], [a, b]) = self.density.cell(point);
        let n_x = self.density.n_x;
        let total = self.rows.last().copied().unwrap_or(0.0);
        let mix = |row_value: &dyn Fn(usize) -> f64| (1.0 - b) * row_value(row) + b * row_value(row + 1);
        let [left, right] = [0, 1].map(|k| mix(&|row| self.density.at(column + k, row)));
        let in_row = mix(&|row| self.along[row * n_x + column]) + a * (left + 0.5 * a * (right - left));
        let of_row = mix(&|row| self.along[(row + 1) * n_x - 1]);
        let ends = [row, row + 1].map(|row| self.along[(row + 1) * n_x - 1]);
        let before = self.rows[row] + b * (ends[0] + 0.5 * b * (ends[1] - ends[0]));
        let part = |of: f64, whole: f64| if whole > 0.0 { (of / whole).clamp(0.0, 1.0) } else { 0.0 };
        [part(in_row, of_row), part(before, total)]
    }
}

/// Polar angle and azimuth as coordinates of the square.
fn unit(theta: f64, phi: f64) -> [f64; 2] {
    [(theta * 2.0 / PI).max(0.0).sqrt(), ((phi + PI) / TAU).rem_euclid(1.0)]
}

/// Turns the channels of a file into X, Y and Z.
enum Channels {
    Rgb,
    /// X, Y and Z for each of the file's wavelengths.
    Spectrum(Vec<[f64; 3]>),
}

/// Reads a file.
///
/// # Errors
/// If fields are missing or of shapes that do not fit.
pub(super) fn read(bytes: &[u8]) -> Result<Measurement, ReadError> {
    let file = TensorFile::read(bytes)?;
    let (_, thetas) = file.floats("theta_i", 1)?;
    let (_, phis) = file.floats("phi_i", 1)?;
    let (ndf_shape, ndf) = file.floats("ndf", 2)?;
    let (sigma_shape, sigma) = file.floats("sigma", 2)?;
    let (vndf_shape, vndf) = file.floats("vndf", 4)?;
    let name = if file.has("rgb") { "rgb" } else { "spectra" };
    let (shape, values) = file.floats(name, 5)?;
    let channels = match name {
        "rgb" => Channels::Rgb,
        _ => Channels::Spectrum(weights(file.floats("wavelengths", 1)?.1)),
    };
    let n_channels = match &channels {
        Channels::Rgb => 3,
        Channels::Spectrum(weights) => weights.len(),
    };
    let incident = [phis.len(), thetas.len()];
    let fits = |shape: &[usize]| shape[..2] == incident && shape[shape.len() - 2..].iter().all(|&n| n >= 2);
    let are_tables = [ndf_shape, sigma_shape].iter().all(|shape| shape.iter().all(|&n| n >= 2));
    if !fits(vndf_shape)
        || !fits(shape)
        || shape[2] != n_channels
        || !are_tables
        || thetas.is_empty()
        || phis.is_empty()
    {
        let found =
            format!("ndf {ndf_shape:?}, sigma {sigma_shape:?}, vndf {vndf_shape:?}, {name} {shape:?}");
        let expected = format!(
            "shapes that fit {} phi_i, {} theta_i and {n_channels} channels",
            phis.len(),
            thetas.len()
        );
        return Err(ReadError::file(found, expected));
    }
    let is_isotropic = phis.len() <= 2;
    let has_jacobian = file.flag("jacobian").unwrap_or(true);
    let ndf = Table::slice(ndf_shape, ndf, 0);
    let sigma = Table::slice(sigma_shape, sigma, 0);
    let mut scans = Vec::new();
    // The second azimuth of isotropic files is the first one again, and so is the last of a whole turn.
    let is_turn = phis.len() > 2 && (f64::from(phis[phis.len() - 1] - phis[0]) - TAU).abs() < 1e-3;
    let n_phis = if is_isotropic { 1 } else { phis.len() - usize::from(is_turn) };
    for p in 0..n_phis {
        for (t, &theta) in thetas.iter().enumerate() {
            let (theta, phi) = (f64::from(theta), if is_isotropic { 0.0 } else { f64::from(phis[p]) });
            let is_repeated = p > 0 && theta < 1e-6;
            if !(0.0..LARGEST_THETA).contains(&theta) || is_repeated {
                continue;
            }
            let number = p * thetas.len() + t;
            let slice = Slice {
                theta,
                phi,
                is_isotropic,
                vndf: Accumulated::new(Table::slice(vndf_shape, vndf, number)),
                channels: (0..n_channels)
                    .map(|c| Table::slice(shape, values, number * n_channels + c))
                    .collect(),
                ndf: has_jacobian.then_some(&ndf),
                sigma: sigma.eval(unit(theta, phi)),
            };
            scans.push(slice.scan(&channels));
        }
    }
    let symmetry = if is_isotropic { Symmetry::Isotropic } else { symmetry(phis)? };
    let notes = vec!["values are looked up at points around the mirrored direction".to_owned()];
    Ok(Measurement {
        n_channels: 3,
        scans,
        name: file.text("description").filter(|text| !text.is_empty()),
        symmetry: (symmetry != Symmetry::Anisotropic).then_some(symmetry),
        notes,
        ..Measurement::default()
    })
}

/// The symmetry by which azimuths of the light that are part of a turn make up a whole one.
fn symmetry(phis: &[f32]) -> Result<Symmetry, ReadError> {
    let extent = f64::from(phis[phis.len() - 1] - phis[0]);
    match (TAU / extent).round() {
        1.0 => Ok(Symmetry::Anisotropic),
        2.0 => Ok(Symmetry::HalfTurn),
        4.0 => Ok(Symmetry::Quadrilateral),
        _ => {
            let found = format!("phi_i over {:.1}°", extent.to_degrees());
            Err(ReadError::file(found, "a whole turn, half or a quarter of one"))
        }
    }
}

/// What the file says of one incident direction.
struct Slice<'a> {
    theta: f64,
    phi: f64,
    is_isotropic: bool,
    vndf: Accumulated<'a>,
    channels: Vec<Table<'a>>,
    /// `None` if values have its factor in them.
    ndf: Option<&'a Table<'a>>,
    sigma: f64,
}

impl Slice<'_> {
    fn scan(&self, channels: &Channels) -> Scan {
        let incident = direction_from_polar(self.theta, self.phi);
        let source = format!("incidence {:.2}°, {:.2}°", self.theta.to_degrees(), self.phi.to_degrees());
        let mut scan = Scan { incident, source, ..Scan::default() };
        for exitant in around_mirror(incident) {
            if let Some(xyz) = self.eval(incident, exitant, channels) {
                scan.exitant.push(exitant);
                scan.values.extend(xyz);
            }
        }
        scan
    }

    /// `None` where the file has no microfacets to see.
    fn eval(&self, incident: Direction, exitant: Direction, channels: &Channels) -> Option<[f64; 3]> {
        let half = normalized([0, 1, 2].map(|k| incident[k] + exitant[k]))?;
        let phi = half[1].atan2(half[0]) - if self.is_isotropic { self.phi } else { 0.0 };
        let u = unit(half[2].clamp(-1.0, 1.0).acos(), phi);
        let at = self.vndf.before(u);
        let factor = self.ndf.map_or(1.0, |ndf| ndf.eval(u) / (4.0 * self.sigma)) / exitant[2];
        // Out of gamut, RGB may be negative.
        let value = |table: &Table<'_>| table.eval(at).max(0.0) * factor;
        let xyz = match channels {
            Channels::Rgb => xyz_from_rgb([0, 1, 2].map(|c| value(&self.channels[c]))),
            Channels::Spectrum(weights) => {
                let parts = self
                    .channels
                    .iter()
                    .zip(weights)
                    .map(|(table, xyz)| xyz.map(|weight| weight * value(table)));
                parts.fold([0.0; 3], |sum, part| [0, 1, 2].map(|k| sum[k] + part[k]))
            }
        };
        xyz.iter().all(|v| v.is_finite()).then_some(xyz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field of bytes, not of floats.
    const BYTES: &str = "jacobian";

    /// A file of fields.
    fn file(fields: &[(&str, Vec<usize>, Vec<f32>)]) -> Vec<u8> {
        let head: usize =
            fields.iter().map(|(name, shape, _)| 2 + name.len() + 2 + 1 + 8 + 8 * shape.len()).sum();
        let mut bytes = b"tensor_file\0\x01\0".to_vec();
        bytes.extend((fields.len() as u32).to_le_bytes());
        let mut place = bytes.len() + head;
        for (name, shape, values) in fields {
            bytes.extend((name.len() as u16).to_le_bytes());
            bytes.extend(name.as_bytes());
            bytes.extend((shape.len() as u16).to_le_bytes());
            bytes.push(if *name == BYTES { 1 } else { 10 });
            bytes.extend((place as u64).to_le_bytes());
            shape.iter().for_each(|&n| bytes.extend((n as u64).to_le_bytes()));
            place += if *name == BYTES { 1 } else { 4 } * values.len();
        }
        for (name, _, values) in fields {
            match *name {
                BYTES => bytes.extend(values.iter().map(|&value| value as u8)),
                _ => values.iter().for_each(|value| bytes.extend(value.to_le_bytes())),
            }
        }
        bytes
    }

    const N: usize = 48;

    /// The microfacets' density over θ_h, without shadowing, of GGX with α = 0.3.
    fn ggx(theta: f64) -> f64 {
        let (c2, a2) = (theta.cos().powi(2), 0.09);
        a2 / (PI * (c2 * (a2 - 1.0) + 1.0).powi(2))
    }

    /// Fields of an isotropic sample of which f cos θ_o = g · D/(4 σ), with g a function of θ_h alone and any `vndf`.
    fn fields(
        vndf: impl Fn(f64, f64) -> f64,
        g: impl Fn(f64) -> f64,
    ) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        let thetas = [0.0f32, 0.4, 1.0];
        let along = |k: usize| k as f64 / (N - 1) as f64;
        let theta_of = |u: f64| u * u * PI / 2.0;
        let square = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f32> {
            (0..N * N).map(|k| f(along(k % N), along(k / N)) as f32).collect()
        };
        let density = square(&|x, y| vndf(x, y));
        let table = Accumulated::new(Table { n_x: N, n_y: N, values: &density });
        // g over the square of `before`: where columns are x, since `vndf` is separable in these tests.
        let mut columns: Vec<(f64, f64)> =
            (0..4000).map(|k| f64::from(k) / 3999.0).map(|x| (table.before([x, 0.5])[0], x)).collect();
        columns.sort_by(|a, b| a.0.total_cmp(&b.0));
        let x_of = |t: f64| columns[columns.partition_point(|c| c.0 < t).min(columns.len() - 1)].1;
        let stored = square(&|s, _| g(theta_of(x_of(s))));
        let repeat = |values: &[f32], n: usize| values.repeat(n);
        vec![
            ("theta_i", vec![3], thetas.to_vec()),
            ("phi_i", vec![1], vec![0.0]),
            ("ndf", vec![N, N], square(&|x, _| ggx(theta_of(x)))),
            ("sigma", vec![2, N], (0..2 * N).map(|k| theta_of(along(k % N)).cos() as f32).collect()),
            ("vndf", vec![1, 3, N, N], repeat(&density, 3)),
            ("rgb", vec![1, 3, 3, N, N], repeat(&stored, 9)),
        ]
    }

    #[test]
    fn values_are_those_that_were_stored() {
        // Both distributions are the truth of the same sample: what is stored differs, what comes out must not.
        let g = |theta: f64| 0.5 + 0.4 * (3.0 * theta).cos();
        for vndf in [(|_, _| 1.0) as fn(f64, f64) -> f64, |x, y| (0.2 + x) * (1.5 + (TAU * y).cos())] {
            let read = read(&file(&fields(vndf, g))).unwrap();
            assert_eq!((read.scans.len(), read.symmetry), (3, Some(Symmetry::Isotropic)));
            for scan in &read.scans {
                for (o, xyz) in scan.exitant.iter().zip(scan.values.as_chunks::<3>().0) {
                    let half = normalized([0, 1, 2].map(|k| scan.incident[k] + o[k])).unwrap();
                    let theta = half[2].min(1.0).acos();
                    let expected = g(theta) * ggx(theta) / (4.0 * scan.incident[2] * o[2]);
                    assert!((xyz[1] / expected - 1.0).abs() < 0.05, "{} for {expected} at {theta}", xyz[1]);
                }
            }
        }
    }

    #[test]
    fn values_without_jacobian_have_no_factor() {
        let mut fields = fields(|_, _| 1.0, |_| 0.7);
        fields.push(("jacobian", vec![1], vec![1.0]));
        let with = read(&file(&fields)).unwrap();
        assert_eq!(with, read(&file(&fields[..6])).unwrap());
        fields[6].2[0] = 0.0;
        for scan in &read(&file(&fields)).unwrap().scans {
            for (o, xyz) in scan.exitant.iter().zip(scan.values.as_chunks::<3>().0) {
                assert!((xyz[1] * o[2] / 0.7 - 1.0).abs() < 1e-5, "{} at {o:?}", xyz[1]);
            }
        }
    }

    #[test]
    fn part_of_a_turn_is_a_symmetry() {
        let good = fields(|_, _| 1.0, |_| 1.0);
        let measured = |phis: &[f32]| {
            let mut fields = good.clone();
            fields[1] = ("phi_i", vec![phis.len()], phis.to_vec());
            for (_, shape, values) in fields.iter_mut().skip(4) {
                shape[0] = phis.len();
                *values = values.repeat(phis.len());
            }
            read(&file(&fields))
        };
        let pi = PI as f32;
        for (phis, symmetry) in [
            (vec![-pi, 0.0, pi], None),
            (vec![-pi, -2.0, -1.0, 0.0], Some(Symmetry::HalfTurn)),
            (vec![-pi, -2.3, -pi / 2.0], Some(Symmetry::Quadrilateral)),
        ] {
            assert_eq!(measured(&phis).unwrap().symmetry, symmetry, "{phis:?}");
        }
        let message = measured(&[-pi, -2.0, -1.0]).unwrap_err().to_string();
        assert!(message.contains("phi_i over 122.7°"), "{message}");
    }

    #[test]
    fn accumulated_parts_are_integrals() {
        let values: Vec<f32> = (0..12).map(|k| (1 + k * k % 7) as f32).collect();
        let table = || Table { n_x: 4, n_y: 3, values: &values };
        let accumulated = Accumulated::new(table());
        let point = [0.55, 0.7];
        let n = 400;
        let integral = |x0: f64, y0: f64| {
            let mut sum = 0.0;
            for a in 0..n {
                for b in 0..n {
                    let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
                    sum += table().eval([x0 * at(a), y0 * at(b)]);
                }
            }
            sum * x0 * y0
        };
        let expected = integral(1.0, point[1]) / integral(1.0, 1.0);
        assert!((accumulated.before(point)[1] - expected).abs() < 1e-4);
        let row = |x: f64| {
            (0..n).map(|k| table().eval([x * (f64::from(k) + 0.5) / f64::from(n), point[1]])).sum::<f64>() * x
        };
        assert!((accumulated.before(point)[0] - row(point[0]) / row(1.0)).abs() < 1e-4);
    }

    #[test]
    fn flat_spectra_are_grey() {
        let mut fields = fields(|_, _| 1.0, |_| 1.0);
        let (_, shape, values) = fields.pop().unwrap();
        fields.push(("spectra", vec![1, 3, 4, shape[3], shape[4]], values[..N * N].repeat(12)));
        fields.push(("wavelengths", vec![4], vec![400.0, 500.0, 600.0, 700.0]));
        let read = read(&file(&fields)).unwrap();
        for xyz in read.scans[1].values.as_chunks::<3>().0 {
            assert!((xyz[0] / xyz[1] - 1.0).abs() < 1e-9 && (xyz[2] / xyz[1] - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn damaged_files_do_no_harm() {
        let bytes = file(&fields(|_, _| 1.0, |_| 1.0));
        let mut random = 0x9E37_79B9_7F4A_7C15u64;
        let mut below = |n: usize| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) as usize % n
        };
        let mut n_refused = 0;
        for k in 0..400 {
            let mut damaged = bytes.clone();
            for _ in 0..=k % 5 {
                // The head, where shapes and places are.
                let at = below(350);
                damaged[at] = below(256) as u8;
            }
            n_refused += usize::from(read(&damaged).is_err());
        }
        assert!(n_refused > 200, "{n_refused}");
    }

    #[test]
    fn faulty_files_are_refused() {
        let good = fields(|_, _| 1.0, |_| 1.0);
        let bytes = file(&good);
        for (bytes, said) in [
            (bytes[..40].to_vec(), "cut off"),
            (bytes[..bytes.len() - 4].to_vec(), "\"rgb\" with shape"),
            (file(&good[..5]), "expected a field \"spectra\""),
            (b"tensor_file\0\x02\0".to_vec(), "byte 12: found version [2, 0]"),
        ] {
            let message = read(&bytes).unwrap_err().to_string();
            assert!(message.contains(said), "{message} for {said}");
        }
        let mut huge = bytes.clone();
        // The number of axes of the first field, then its length.
        let at = 18 + 2 + 7 + 2 + 1 + 8;
        huge[at..at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(read(&huge).unwrap_err().to_string().contains("lies in the file"));
        let mut other = fields(|_, _| 1.0, |_| 1.0);
        other[0] = ("theta_i", vec![2], vec![0.0, 0.4]);
        assert!(read(&file(&other)).unwrap_err().to_string().contains("shapes that fit"));
    }
}
