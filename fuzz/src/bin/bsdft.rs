//! Binary BSDF files, their checksums made right: read or refused; and what opens unverified answers everything.
#![no_main]

use std::io::Write;

use bsdftree::binary::{Packing, open, read, write};
use bsdftree::check::{Tolerance, check};
use bsdftree::{Bsdf, Lobes};
use libfuzzer_sys::fuzz_target;

/// As an attacker would.
fn forged(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if bytes.len() < 64 {
        return bytes;
    }
    let length = u64::from_le_bytes(bytes[16..24].try_into().expect("eight bytes"));
    let n = bytes.len() as u64;
    bytes[32..40].copy_from_slice(&n.to_le_bytes());
    if let Some(head) = bytes.get(64..64usize.saturating_add(length as usize)) {
        let crc = crc32fast::hash(head).to_le_bytes();
        bytes[40..44].copy_from_slice(&crc);
    }
    let crc = crc32fast::hash(&bytes[..44]).to_le_bytes();
    bytes[44..48].copy_from_slice(&crc);
    bytes
}

fn ask(bsdf: &Bsdf) {
    let directions = [[0.0, 0.0, 1.0], [0.6, 0.0, -0.8], [-0.48, 0.64, 0.6], [f64::NAN; 3], [0.1, -0.9, 0.4]];
    for band in &bsdf.bands {
        for incident in directions {
            for exitant in directions {
                let single = band.eval(incident, exitant);
                let mut many = [0.0];
                band.eval_many(&[incident], &[exitant], &mut many);
                assert_eq!(single.to_bits(), many[0].to_bits());
                band.eval_xyz(incident, exitant);
                band.projected_solid_angle(incident, exitant);
            }
        }
        // What walks through a tree needs memory by its depth: no more than of trees that are not too fine.
        if bsdf.bands.iter().flat_map(|band| band.components()).all(|(_, c)| c.functions().all(|f| match f {
            bsdftree::Scattering::Tree(tree) => tree.arena().log2_res() < 8,
            bsdftree::Scattering::Matrix(matrix) => matrix.values().len() < 100_000,
        })) {
            for incident in directions {
                band.hemispherical(incident, Lobes::All);
                band.sample(incident, 0.3, None, Lobes::All);
                band.projected_solid_angle_range(incident, Lobes::All);
            }
        }
    }
}

fuzz_target!(|bytes: &[u8]| {
    let bytes = forged(bytes);
    if let Ok(bsdf) = read(&bytes) {
        bsdf.verify().expect("what was read is verified");
        ask(&bsdf);
        let mut again = Vec::new();
        write(&bsdf, Packing::Raw, &mut again).expect("a sound one is written");
        let bsdf = read(&again).expect("own file");
        let mut third = Vec::new();
        write(&bsdf, Packing::Raw, &mut third).expect("a sound one is written");
        assert!(again == third);
    }
    let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
    file.write_all(&bytes).expect("room for it");
    if let Ok(bsdf) = open(file.path()) {
        ask(&bsdf);
        let report = check(&bsdf, Tolerance::default());
        assert!(bsdf.verify().is_ok() || report.all().next().is_some());
    }
});
