//! Radiance pictures of spectra as data: values at even wavelengths over a rectangle.
//!
//! In: the bytes of a picture that `rtrace -co+ -fc` and the like write: as many mantissas in each pixel as the header's `NCOMP`
//! says, and an exponent that they share, without run lengths. Out: the spectrum at u, v, which are as in a [`Picture`](super::Picture).
//! The first and the last of `WAVELENGTH_SPLITS` bound the spectrum; values are for the middles of equal parts of it.
//! Source: Radiance's reference manual ("Specpict") and what its programs write.

use std::fmt;

use super::data::Dimension;
use super::raster::{Bytes, MOST_BYTES};
use super::space::File;
use crate::error::DeviceError;

/// Most values of a pixel.
const MOST_COMPONENTS: usize = 1024;

/// A picture of spectra.
#[derive(Clone)]
pub struct SpectralPicture {
    /// Where it comes from.
    pub file: File,
    /// Of the values, in the picture's order \[nm\].
    pub wavelengths_nm: Vec<f64>,
    /// v and u.
    dimensions: [Dimension; 2],
    /// Rows from the bottom; of each pixel as many mantissas as there are wavelengths, and an exponent.
    bytes: Vec<u8>,
}

impl SpectralPicture {
    /// Reads the bytes of a picture.
    ///
    /// # Errors
    /// [`DeviceError::File`] with what is wrong, if they are no picture of spectra.
    pub fn parse(bytes: &[u8], file: File) -> Result<SpectralPicture, DeviceError> {
        let path = file.path.to_string();
        read(bytes, file).map_err(|reason| DeviceError::File { path: path.into(), named_at: None, reason })
    }

    /// The values at u along the width and v along the height, one for each wavelength.
    pub fn values(&self, u: f64, v: f64) -> Vec<f64> {
        let (row, rows) = self.dimensions[0].weights(v);
        let (column, columns) = self.dimensions[1].weights(u);
        let (width, n) = (self.dimensions[1].n(), self.wavelengths_nm.len());
        let mut sums = vec![0.0; n];
        for (j, of_row) in rows.into_iter().enumerate() {
            for (i, of_column) in columns.into_iter().enumerate() {
                let first = ((row + j) * width + column + i) * (n + 1);
                let (mantissas, exponent) = (&self.bytes[first..first + n], self.bytes[first + n]);
                if exponent == 0 {
                    continue;
                }
                // The middle of what a mantissa stands for.
                let scale = of_row * of_column * 2.0_f64.powi(i32::from(exponent) - 136);
                for (sum, &mantissa) in sums.iter_mut().zip(mantissas) {
                    *sum += scale * (f64::from(mantissa) + 0.5);
                }
            }
        }
        sums
    }
}

impl PartialEq for SpectralPicture {
    fn eq(&self, other: &SpectralPicture) -> bool {
        (&self.wavelengths_nm, &self.dimensions, &self.bytes)
            == (&other.wavelengths_nm, &other.dimensions, &other.bytes)
    }
}

impl fmt::Debug for SpectralPicture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SpectralPicture({:016x})", self.file.digest)
    }
}

fn read(bytes: &[u8], file: File) -> Result<SpectralPicture, String> {
    let mut bytes = Bytes { all: bytes, at: 0 };
    let (mut is_spectral, mut n, mut splits) = (false, 0, None);
    let aspect = bytes.header(|name, value| {
        match name {
            "FORMAT" => is_spectral = value == "Radiance_spectra",
            "NCOMP" => n = value.parse().unwrap_or(0),
            "WAVELENGTH_SPLITS" => splits = wavelengths(value),
            _ => {}
        }
        Ok(())
    })?;
    if !is_spectral {
        return Err("it is no picture of spectra: expected FORMAT=Radiance_spectra in its header".to_owned());
    }
    // With three there would be run lengths, and no wavelengths.
    if !(4..=MOST_COMPONENTS).contains(&n) {
        return Err(format!("expected NCOMP=N in its header, with N from 4 to {MOST_COMPONENTS}"));
    }
    let Some([from, to]) = splits else {
        return Err(
            "expected WAVELENGTH_SPLITS= in its header, with four wavelengths [nm] such as 780 588 480 380"
                .to_owned(),
        );
    };
    let size = bytes.size()?;
    let [width, height] = size.pixels;
    let needed = width.saturating_mul(height).saturating_mul(n + 1);
    if needed > MOST_BYTES || needed > bytes.left() {
        return Err(bytes.too_few(&size));
    }
    let mut turned = vec![0; needed];
    let pixels = bytes.all[bytes.at..][..needed].chunks_exact(n + 1);
    let [_, length] = size.lines();
    for (k, pixel) in pixels.enumerate() {
        let first = size.place(k / length, k % length) * (n + 1);
        turned[first..first + n + 1].copy_from_slice(pixel);
    }
    let step = (to - from) / n as f64;
    let wavelengths_nm = (0..n).map(|k| from + (k as f64 + 0.5) * step).collect();
    Ok(SpectralPicture { file, wavelengths_nm, dimensions: size.dimensions(aspect), bytes: turned })
}

/// The first and the last of four wavelengths.
fn wavelengths(text: &str) -> Option<[f64; 2]> {
    let numbers: Vec<f64> = text.split_ascii_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
    match numbers[..] {
        [from, _, _, to] if from.is_finite() && to.is_finite() && from != to && from.min(to) > 0.0 => {
            Some([from, to])
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str =
        "#?RADIANCE\n\tNCOMP=9\nNCOMP=4\nWAVELENGTH_SPLITS= 800 588 480 400\nFORMAT=Radiance_spectra\n\n";

    fn picture(head: &str, body: &[u8]) -> Result<SpectralPicture, String> {
        let bytes = [head.as_bytes(), body].concat();
        SpectralPicture::parse(&bytes, File { path: "p.spc".into(), digest: 0 }).map_err(|e| e.to_string())
    }

    /// Pixels whose first mantissas are 0, 10, 20, ….
    fn counted(n: u8) -> Vec<u8> {
        (0..n).flat_map(|k| [10 * k, 1, 2, 3, 136]).collect()
    }

    #[test]
    fn spectra_lie_where_the_picture_has_them() {
        let found = picture(&format!("{HEAD}-Y 2 +X 3\n"), &counted(6)).unwrap();
        assert_eq!(found.wavelengths_nm, [750.0, 650.0, 550.0, 450.0]);
        // The first line is the upper one.
        assert_eq!(found.values(0.0, 1.0), [0.5, 1.5, 2.5, 3.5]);
        assert_eq!(found.values(1.5, 0.0), [50.5, 1.5, 2.5, 3.5]);
        assert_eq!(found.values(0.375, 0.5), [20.5, 1.5, 2.5, 3.5]);
    }

    #[test]
    fn what_is_wrong_is_said() {
        let colours = HEAD.replace("Radiance_spectra", "32-bit_rle_rgbe");
        for (head, body, expected) in [
            (format!("{colours}-Y 2 +X 3\n"), 6, "it is no picture of spectra"),
            (HEAD.replace("\nNCOMP=4", "\nNCOMP=3"), 6, "expected NCOMP=N"),
            (HEAD.replace("800 588 480 400", "800 400"), 6, "expected WAVELENGTH_SPLITS="),
            (HEAD.replace("800 588 480 400", "400 588 480 400"), 6, "expected WAVELENGTH_SPLITS="),
            (format!("{HEAD}-Y 2 +X 3\n"), 5, "it has 25 bytes for them"),
            (format!("{HEAD}-Y 9999999999 +X 9999999999\n"), 5, "it has 25 bytes for them"),
        ] {
            let found = picture(&head, &counted(body)).unwrap_err();
            assert!(found.contains(expected), "{found}");
        }
    }
}
