//! PLY, STL and compiled meshes, told apart by the first byte: read or refused; what is read is sound.
#![no_main]

use bsdftree_device::options::{Limits, MaterialMap};
use bsdftree_device::{Device, ReadOptions, Shape};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let materials = MaterialMap { default: Some("void".to_owned()), ..MaterialMap::default() };
    let limits = Limits { surfaces: 5000, bytes: 1 << 24, ..Limits::DEFAULT };
    let options = ReadOptions { materials, limits, ..ReadOptions::default() };
    let Some((first, bytes)) = bytes.split_first() else { return };
    let name = ["fuzz.ply", "fuzz.stl", "fuzz.rtm"][*first as usize % 3];
    if let Ok(device) = Device::parse_mesh(bytes, name, &options) {
        for surface in &device.surfaces {
            let Shape::Mesh(mesh) = &surface.shape else { panic!("{surface:?}") };
            assert!(mesh.is_sound() && !mesh.triangles.is_empty());
        }
    }
});
