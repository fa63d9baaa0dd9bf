//! What tests of several crates need: real files of other people, and Radiance's programs as the oracle.
//!
//! Both may be absent; then a test is skipped, and a line says so.

pub mod radiance;

use std::path::PathBuf;

/// Real BSDF files that are whole and say something of the visible band.
pub const READABLE: [&str; 18] = [
    "bsdfxmlparser/2011-SA1.XML",
    "frads/blinds30.xml",
    "frads/ec60.xml",
    "ignis/simple_klems_through_trans.xml",
    "ignis/simple_tensor_d2_refl.xml",
    "ignis/simple_tensor_d2_t3_trans.xml",
    "ignis/simple_tensor_d3_t3_refl.xml",
    "ignis/simple_tensor_front_refl.xml",
    "ignis/simple_tensor_refl.xml",
    "ignis/simple_tensor_trans.xml",
    "mermet/E_Screen_3pct_White.xml",
    "pyradiance/blinds.xml",
    "pyradiance/blindsT3.xml",
    "pyradiance/clear.xml",
    "pyradiance/t3.xml",
    "pyradiance/ven45.xml",
    "radiance/sawtooth.xml",
    "radiance/testBSDF.xml",
];

/// The folder of real files: `BSDFTREE_DATA`, or `shared/data` beside the repository.
pub fn real_folder() -> PathBuf {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"));
    std::env::var_os("BSDFTREE_DATA").map_or_else(beside, PathBuf::from)
}

/// A real file, or `None` with a visible line.
pub fn real_file(name: &str) -> Option<PathBuf> {
    let path = real_folder().join(name);
    if !path.is_file() {
        eprintln!("SKIPPED: {} is not there; set BSDFTREE_DATA to the folder of real files", path.display());
        return None;
    }
    Some(path)
}
