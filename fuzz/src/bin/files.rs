//! Files that modifiers name, told apart by the first byte: data, pictures, pictures of spectra, fonts with text. Read or refused;
//! what is read has a value at any point.
#![no_main]

use std::sync::Arc;

use bsdftree_device::field::{DataArray, File, Font, Picture, SpectralPicture, Text, Words};
use glam::DVec3;
use libfuzzer_sys::fuzz_target;

const AT: [f64; 7] = [0.0, 0.3, 1.0, -5.0, 1e9, f64::INFINITY, f64::NAN];

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let file = File { path: "fuzz".into(), digest: 0 };
    let text = String::from_utf8_lossy(bytes);
    match first % 4 {
        0 => {
            let Ok(data) = DataArray::parse(&text, file) else { return };
            let n = data.dimensions().len();
            for x in AT {
                data.value(&vec![x; n]);
                if n > 1 {
                    let last = data.dimensions()[n - 1].n();
                    assert_eq!(data.along_last(&vec![x; n - 1]).len(), last);
                }
            }
        }
        1 => {
            let Ok(picture) = Picture::parse(bytes, file) else { return };
            AT.iter().for_each(|&u| AT.iter().for_each(|&v| _ = picture.value(u, v)));
        }
        2 => {
            let Ok(picture) = SpectralPicture::parse(bytes, file) else { return };
            for (u, v) in AT.iter().zip(AT.iter().rev()) {
                assert_eq!(picture.values(*u, *v).len(), picture.wavelengths_nm.len());
            }
        }
        _ => {
            // The text after the last empty line.
            let (font, lines) = text.rsplit_once("\n\n").unwrap_or((&text, "A b\nc"));
            let Ok(font) = Font::parse(font, file) else { return };
            let vectors = [DVec3::ZERO, DVec3::X, DVec3::NEG_Y];
            let font = Arc::new(font);
            for spacing in [None, Some(0.0), Some(0.2), Some(-0.2), Some(-3.0), Some(1e300)] {
                let words = Words::Line(String::new());
                let Ok(text) = Text::new(font.clone(), words, lines.as_bytes(), vectors, spacing) else { return };
                AT.iter().for_each(|&x| AT.iter().for_each(|&y| _ = text.covers(DVec3::new(x, -y, 0.0))));
            }
        }
    }
});
