//! Files of Radiance pictures up to their pixels: header, size, and where each pixel lies.
//!
//! In: the bytes of a picture of any kind. Out: what its header says, and for each pixel in the order of the file its place
//! from the lower left corner. Of a header only lines that begin at the margin count: those of pictures that it was made of are
//! indented. Source: Radiance's file formats ("Picture file format").

use super::data::Dimension;

/// Most bytes that pixels may take.
pub(super) const MOST_BYTES: usize = 1 << 29;

/// Pixels may be so many times as high as wide, or as wide as high.
const MOST_ASPECT: f64 = 1e6;

/// Bytes, and how many of them were read.
pub(super) struct Bytes<'a> {
    pub all: &'a [u8],
    pub at: usize,
}

/// The line after the header, such as `-Y 512 +X 768`.
pub(super) struct Size {
    /// Width and height.
    pub pixels: [usize; 2],
    /// Whether scanlines are rows.
    y_first: bool,
    /// Whether x and y run downwards.
    down: [bool; 2],
}

impl Size {
    pub fn parse(line: &str) -> Result<Size, String> {
        let wrong = || format!("expected its size, such as '-Y 512 +X 768', found '{}'", line.trim());
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let [first, n_first, second, n_second] = words[..] else { return Err(wrong()) };
        let axis = |name: &str| match name {
            "+X" => Some((0, false)),
            "-X" => Some((0, true)),
            "+Y" => Some((1, false)),
            "-Y" => Some((1, true)),
            _ => None,
        };
        let mut size = Size { pixels: [0; 2], y_first: false, down: [false; 2] };
        for (name, n) in [(first, n_first), (second, n_second)] {
            let ((k, down), n) =
                axis(name).zip(n.parse().ok().filter(|&n: &usize| n > 0)).ok_or_else(wrong)?;
            size.pixels[k] = n;
            size.down[k] = down;
        }
        size.y_first = first.ends_with('Y');
        if size.pixels.contains(&0) { Err(wrong()) } else { Ok(size) }
    }

    /// How many lines there are in the file, and how many pixels in each.
    pub fn lines(&self) -> [usize; 2] {
        let [width, height] = self.pixels;
        if self.y_first { [height, width] } else { [width, height] }
    }

    /// The number of pixel `i` of line `k`, counted by rows from the lower left corner.
    pub fn place(&self, k: usize, i: usize) -> usize {
        let [width, height] = self.pixels;
        let [mut x, mut y] = if self.y_first { [i, k] } else { [k, i] };
        if self.down[0] {
            x = width - 1 - x;
        }
        if self.down[1] {
            y = height - 1 - y;
        }
        y * width + x
    }

    /// v and u of the pixels, of which each is `aspect` times as high as wide: the shorter side is 1 long.
    pub fn dimensions(&self, aspect: f64) -> [Dimension; 2] {
        let [width, height] = self.pixels;
        let (w, h) = (width as f64, height as f64 * aspect);
        let shorter = w.min(h);
        let even = |extent: f64, n| Dimension::Even { ends: [0.0, extent / shorter], n };
        [even(h, height), even(w, width)]
    }
}

impl<'a> Bytes<'a> {
    pub fn left(&self) -> usize {
        self.all.len() - self.at
    }

    fn line(&mut self) -> Result<&'a str, String> {
        let rest = &self.all[self.at..];
        let end = rest.iter().position(|&b| b == b'\n').ok_or("it ends within its header")?;
        self.at += end + 1;
        std::str::from_utf8(&rest[..end]).or(Ok(""))
    }

    /// Gives each `NAME=VALUE` of the header to `see`, but for `PIXASPECT`; the height of a pixel over its width.
    pub fn header(&mut self, mut see: impl FnMut(&str, &str) -> Result<(), String>) -> Result<f64, String> {
        if !self.all.starts_with(b"#?") {
            return Err("it is no Radiance picture: expected '#?RADIANCE' at its beginning".to_owned());
        }
        let mut aspect = 1.0;
        loop {
            let line = self.line()?.trim_end();
            if line.is_empty() {
                return Ok(aspect);
            }
            let Some((name, value)) = line.split_once('=') else { continue };
            let value = value.trim();
            if name != "PIXASPECT" {
                see(name, value)?;
                continue;
            }
            aspect *= value.parse::<f64>().unwrap_or(0.0);
            if !(MOST_ASPECT.recip()..=MOST_ASPECT).contains(&aspect) {
                return Err(format!("its PIXASPECT is '{value}'; expected a number above 0"));
            }
        }
    }

    /// The line after the header, of a picture that has two pixels each way at least.
    pub fn size(&mut self) -> Result<Size, String> {
        let size = Size::parse(self.line()?)?;
        let [width, height] = size.pixels;
        if width < 2 || height < 2 {
            return Err(format!(
                "it has {width} × {height} pixels; expected at least 2 × 2 to interpolate between"
            ));
        }
        Ok(size)
    }

    /// What is wrong with a picture that has not as many bytes as its size asks for.
    pub fn too_few(&self, size: &Size) -> String {
        let [width, height] = size.pixels;
        format!("it says it has {width} × {height} pixels, but it has {} bytes for them", self.left())
    }

    pub fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let taken = self.all.get(self.at..self.at + N).ok_or("it ends within its pixels")?;
        self.at += N;
        Ok(taken.try_into().expect("N bytes"))
    }
}
