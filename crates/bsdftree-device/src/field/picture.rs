//! Radiance pictures as data: red, green and blue over a rectangle.
//!
//! In: the bytes of a picture, RGBE or XYZE, of any orientation, plain or with either kind of run lengths. Out: the colour at u, v,
//! where (0, 0) is the lower left corner's pixel and the shorter side is 1 long; between pixels it is interpolated and outside
//! extrapolated as [`DataArray`](super::DataArray) does. Exposures in the header do not change values, as in Radiance.
//! Source: Radiance's file formats ("Picture file format"), and G. Ward, "Real pixels", Graphics Gems II (1991).
//! Deviation: Radiance takes no XYZE pictures here.

use std::fmt;
use std::sync::Arc;

use bsdftree::color::rgb_from_xyz;

use super::data::Dimension;
use super::raster::{Bytes, MOST_BYTES};
use super::space::File;
use crate::error::DeviceError;

/// Bytes of a mantissa each, and a common exponent.
type Pixel = [u8; 4];

/// A picture.
#[derive(Clone)]
pub struct Picture {
    /// Where it comes from.
    pub file: File,
    is_xyz: bool,
    /// v and u.
    dimensions: [Dimension; 2],
    /// Rows from the bottom.
    pixels: Vec<Pixel>,
}

impl Picture {
    /// Reads the bytes of a picture.
    ///
    /// # Errors
    /// [`DeviceError::File`] with what is wrong and where, if they are no picture.
    pub fn parse(bytes: &[u8], file: File) -> Result<Picture, DeviceError> {
        let path: Arc<str> = file.path.clone();
        read(bytes, file).map_err(|reason| DeviceError::File { path: (*path).into(), named_at: None, reason })
    }

    /// Width and height \[pixel\].
    pub fn size(&self) -> [usize; 2] {
        [self.dimensions[1].n(), self.dimensions[0].n()]
    }

    /// Linear red, green and blue at u along the width and v along the height.
    pub fn value(&self, u: f64, v: f64) -> [f64; 3] {
        let (row, rows) = self.dimensions[0].weights(v);
        let (column, columns) = self.dimensions[1].weights(u);
        let width = self.dimensions[1].n();
        let mut sum = [0.0; 3];
        for (j, of_row) in rows.into_iter().enumerate() {
            for (i, of_column) in columns.into_iter().enumerate() {
                let pixel = self.pixels[(row + j) * width + column + i];
                for (sum, part) in sum.iter_mut().zip(real(pixel)) {
                    *sum += of_row * of_column * part;
                }
            }
        }
        if self.is_xyz { rgb_from_xyz(sum) } else { sum }
    }
}

impl PartialEq for Picture {
    fn eq(&self, other: &Picture) -> bool {
        (self.is_xyz, &self.dimensions, &self.pixels) == (other.is_xyz, &other.dimensions, &other.pixels)
    }
}

impl fmt::Debug for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Picture({:016x})", self.file.digest)
    }
}

/// The middle of what a mantissa stands for, times the power of two.
fn real([a, b, c, exponent]: Pixel) -> [f64; 3] {
    if exponent == 0 {
        return [0.0; 3];
    }
    let power = 2.0_f64.powi(i32::from(exponent) - 136);
    [a, b, c].map(|mantissa| (f64::from(mantissa) + 0.5) * power)
}

fn read(bytes: &[u8], file: File) -> Result<Picture, String> {
    let mut bytes = Bytes { all: bytes, at: 0 };
    let mut is_xyz = false;
    let aspect = bytes.header(|name, value| {
        if name == "FORMAT" {
            is_xyz = match value {
                "32-bit_rle_rgbe" => false,
                "32-bit_rle_xyze" => true,
                "Radiance_spectra" => {
                    return Err(
                        "it is a picture of spectra, for specpict; expected one of colours".to_owned()
                    );
                }
                other => {
                    return Err(format!(
                        "its format is '{other}'; expected 32-bit_rle_rgbe or 32-bit_rle_xyze"
                    ));
                }
            };
        }
        Ok(())
    })?;
    let size = bytes.size()?;
    let ([width, height], [n_lines, length]) = (size.pixels, size.lines());
    // A run of the old kind may stand for many pixels, but not for more lines than there are.
    if width.saturating_mul(height) > MOST_BYTES / size_of::<Pixel>() || n_lines > bytes.left() {
        return Err(bytes.too_few(&size));
    }
    let mut pixels = vec![[0; 4]; width * height];
    let mut line = vec![[0; 4]; length];
    for k in 0..n_lines {
        scanline(&mut bytes, &mut line).map_err(|reason| format!("{reason} at byte {}", bytes.at))?;
        for (i, pixel) in line.iter().enumerate() {
            pixels[size.place(k, i)] = *pixel;
        }
    }
    Ok(Picture { file, is_xyz, dimensions: size.dimensions(aspect), pixels })
}

/// A line of pixels, each component in runs, or else pixels in runs, or plain.
fn scanline(bytes: &mut Bytes, line: &mut [Pixel]) -> Result<(), String> {
    let n = line.len();
    let lead: Pixel = bytes.take()?;
    if lead[0] != 2 || lead[1] != 2 || lead[2] & 0x80 != 0 {
        bytes.at -= 4;
        return pixel_runs(bytes, line);
    }
    let said = usize::from(lead[2]) << 8 | usize::from(lead[3]);
    if said != n {
        return Err(format!("a line says it has {said} pixels; expected {n}"));
    }
    for component in 0..4 {
        let mut i = 0;
        while i < n {
            let [count] = bytes.take()?;
            let (run, count) = (count > 128, usize::from(if count > 128 { count & 127 } else { count }));
            if count == 0 || i + count > n {
                return Err(format!("a run of {count} bytes where {} are missing", n - i));
            }
            let mut value = [0];
            for k in 0..count {
                if !run || k == 0 {
                    value = bytes.take()?;
                }
                line[i + k][component] = value[0];
            }
            i += count;
        }
    }
    Ok(())
}

/// Pixels, of which (1, 1, 1, n) repeats the one before n times; after another such, 256 times as often.
fn pixel_runs(bytes: &mut Bytes, line: &mut [Pixel]) -> Result<(), String> {
    let (mut i, mut shift) = (0, 0);
    while i < line.len() {
        let pixel: Pixel = bytes.take()?;
        if pixel[..3] != [1, 1, 1] || i == 0 {
            line[i] = pixel;
            i += 1;
            shift = 0;
            continue;
        }
        let count = if shift < 32 { usize::from(pixel[3]) << shift } else { 0 };
        let end = i.saturating_add(count).min(line.len());
        let before = line[i - 1];
        line[i..end].fill(before);
        i = end;
        shift += 8;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(head: &str, body: &[u8]) -> Result<Picture, String> {
        let bytes = [head.as_bytes(), body].concat();
        Picture::parse(&bytes, File { path: "p.hdr".into(), digest: 0 }).map_err(|e| e.to_string())
    }

    /// Pixels whose red is 1, 2, 3, … in the order they are written.
    fn counted(n: u8) -> Vec<u8> {
        (1..=n).flat_map(|k| [k, 0, 200, 136]).collect()
    }

    const HEAD: &str = "#?RADIANCE\nEXPOSURE=3\nFORMAT=32-bit_rle_rgbe\n\n";

    #[test]
    fn orientations_put_the_first_pixel_in_its_corner() {
        // Width 3, height 2; the first pixel of the file is at these u and v.
        for (size, u, v) in [
            ("-Y 2 +X 3", 0.0, 1.0),
            ("-Y 2 -X 3", 1.5, 1.0),
            ("+Y 2 +X 3", 0.0, 0.0),
            ("+Y 2 -X 3", 1.5, 0.0),
            ("+X 3 -Y 2", 0.0, 1.0),
            ("-X 3 -Y 2", 1.5, 1.0),
            ("+X 3 +Y 2", 0.0, 0.0),
            ("-X 3 +Y 2", 1.5, 0.0),
        ] {
            let p = picture(&format!("{HEAD}{size}\n"), &counted(6)).unwrap();
            assert_eq!(p.size(), [3, 2]);
            assert_eq!(p.value(u, v)[0], 1.5, "{size}");
            // The last one is in the opposite corner; the second one along the first line.
            assert_eq!(p.value(1.5 - u, 1.0 - v)[0], 6.5, "{size}");
            let [second_u, second_v] =
                if size.contains("Y 2 ") && &size[1..2] == "Y" { [0.75, v] } else { [u, 1.0 - v] };
            assert_eq!(p.value(second_u, second_v)[0], 2.5, "{size}");
        }
    }

    #[test]
    fn the_shorter_side_is_one_long_and_pixels_may_not_be_square() {
        let tall = HEAD.replace("EXPOSURE=3", "PIXASPECT=2");
        let p = picture(&format!("{tall}-Y 2 +X 3\n"), &counted(6)).unwrap();
        assert_eq!(p.dimensions[0], Dimension::Even { ends: [0.0, 4.0 / 3.0], n: 2 });
        assert_eq!(p.dimensions[1], Dimension::Even { ends: [0.0, 1.0], n: 3 });
    }

    #[test]
    fn both_kinds_of_runs_give_the_plain_pixels() {
        let width = 600;
        let plain: Vec<Pixel> =
            (0..2 * width).map(|k| [if k < 590 { 7 } else { k as u8 }, 9, 250, 130]).collect();
        let head = format!("{HEAD}-Y 2 +X {width}\n");
        let flat = picture(&head, plain.as_flattened()).unwrap();
        let mut old = Vec::new();
        for row in plain.chunks(width) {
            let mut i = 0;
            while i < width {
                let n = row[i..].iter().take_while(|p| **p == row[i]).count();
                old.extend(row[i]);
                if n > 1 {
                    old.extend([1, 1, 1, (n - 1) as u8]);
                    if n > 256 {
                        old.extend([1, 1, 1, ((n - 1) >> 8) as u8]);
                    }
                }
                i += n;
            }
        }
        assert!(old.len() < plain.len() * 3);
        assert_eq!(picture(&head, &old).unwrap(), flat);
        let mut new = Vec::new();
        for row in plain.chunks(width) {
            new.extend([2, 2, (width >> 8) as u8, width as u8]);
            for component in 0..4 {
                let mut i = 0;
                while i < width {
                    let n =
                        row[i..].iter().take(127).take_while(|p| p[component] == row[i][component]).count();
                    match n {
                        1 => new.extend([1, row[i][component]]),
                        n => new.extend([128 + n as u8, row[i][component]]),
                    }
                    i += n;
                }
            }
        }
        assert_eq!(picture(&head, &new).unwrap(), flat);
    }

    #[test]
    fn xyz_becomes_radiances_rgb() {
        let xyz = HEAD.replace("rgbe", "xyze");
        let p = picture(&format!("{xyz}-Y 2 +X 2\n"), &[128, 128, 128, 128].repeat(4)).unwrap();
        let [r, g, b] = p.value(0.3, 0.4);
        assert!([r, g, b].iter().all(|c| (c - 128.5 / 256.0).abs() < 1e-3), "{r} {g} {b}");
    }

    #[test]
    fn what_is_wrong_is_said() {
        let size = |size: &str| format!("{HEAD}{size}\n");
        for (head, body, expected) in [
            ("P6 3 2".to_owned(), vec![], "it is no Radiance picture"),
            (
                "#?RADIANCE\nFORMAT=Radiance_spectra\n\n".to_owned(),
                vec![],
                "it is a picture of spectra, for specpict",
            ),
            (HEAD.to_owned(), vec![], "it ends within its header"),
            (size("-Y 2"), vec![], "expected its size, such as '-Y 512 +X 768', found '-Y 2'"),
            (size("-Y 2 +Y 3"), vec![], "expected its size"),
            (size("-Y 1 +X 3"), counted(3), "it has 3 × 1 pixels; expected at least 2 × 2"),
            (size("-Y 99999999 +X 99999999"), counted(3), "it says it has 99999999 × 99999999 pixels"),
            (size("-Y 2 +X 3"), counted(5), "it ends within its pixels at byte"),
            (size("-Y 2 +X 9"), [2, 2, 0, 8].repeat(9), "a line says it has 8 pixels; expected 9"),
            (size("-Y 2 +X 9"), [2, 2, 0, 9, 138, 3].repeat(9), "a run of 10 bytes where 9 are missing"),
        ] {
            let found = picture(&head, &body).unwrap_err();
            assert!(found.contains(expected), "{found}");
        }
    }
}
