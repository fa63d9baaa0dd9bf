//! Radiance scenes, commands and generators in them: read or refused, with bounded time and memory; and what is read can be
//! written and read again.
#![no_main]

use std::path::Path;

use bsdftree_device::options::Limits;
use bsdftree_device::{Device, ReadOptions, Unit};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    // Nothing is found there.
    let nowhere = Path::new("/nonexistent");
    let limits = Limits { surfaces: 2000, bytes: 1 << 22, operations: 20_000, ..Limits::DEFAULT };
    let options = ReadOptions { limits, search: Some(Vec::new()), ..ReadOptions::default() };
    if let Ok(device) = Device::parse_rad(text, "fuzz.rad", nowhere, &options) {
        let scene = device.to_rad();
        let again = Device::parse_rad(&scene, "again.rad", nowhere, Unit::Meter);
        if let Ok(again) = again {
            assert_eq!(again.surfaces.len(), device.surfaces.len());
        }
    }
});
