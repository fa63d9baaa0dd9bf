//! MGF: whatever it says is read or refused within bounds; what was read is written, and reads again as as many surfaces.
#![no_main]

use std::path::Path;

use bsdftree_device::options::Limits;
use bsdftree_device::{Device, ReadOptions};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let limits = Limits { surfaces: 2_000, bytes: 4 << 20, ..Limits::DEFAULT };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    // There is nothing to include.
    let Ok(device) = Device::parse_mgf(text, "fuzz.mgf", Path::new("/nonexistent"), &options) else { return };
    let scene = device.to_rad();
    assert!(scene.len() >= device.surfaces.len());
    let mgf = device.to_mgf(options.unit);
    let generous = ReadOptions { limits: Limits { surfaces: 100_000, ..Limits::DEFAULT }, ..options };
    let again = Device::parse_mgf(&mgf.text, "again.mgf", Path::new("/nonexistent"), &generous);
    let again = again.unwrap_or_else(|e| panic!("{e}\n{}", mgf.text));
    let triangles_or_one = |d: &Device| -> usize {
        d.surfaces.iter().map(|s| s.shape.triangulate().len().max(1)).sum()
    };
    // Faces of almost no area may be dropped on the way.
    assert!(triangles_or_one(&again) <= triangles_or_one(&device));
});
