//! Files that are cut off or damaged are refused or read, but never make a reader panic.

use std::path::PathBuf;

use bsdftree_fit::read::{Format, Options, read_files};
use bsdftree_testing::real_file;

/// Numbers that look random, the same in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n as u64) as usize
    }
}

/// Reads damaged copies of a file; how many were refused.
fn refused(name: &str, bytes: &[u8], format: Format, n: usize) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join(name);
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let options = Options { format: Some(format), ..Options::default() };
    let mut n_refused = 0;
    for k in 0..n {
        let mut damaged = bytes.to_vec();
        match k % 3 {
            0 => damaged.truncate(random.below(bytes.len())),
            1 => (0..=random.below(20)).for_each(|_| {
                let at = random.below(bytes.len());
                damaged[at] = random.below(256) as u8;
            }),
            // Of headers, more.
            _ => (0..=random.below(8)).for_each(|_| {
                let at = random.below(bytes.len().min(1500));
                damaged[at] = random.below(256) as u8;
            }),
        }
        std::fs::write(&path, &damaged).unwrap();
        match read_files(std::slice::from_ref(&path), &options) {
            Ok(measurement) => measurement.verify().unwrap(),
            Err(error) => {
                assert!(error.to_string().contains(name), "{error}");
                n_refused += 1;
            }
        }
    }
    n_refused
}

#[test]
fn real_files_that_are_damaged_do_no_harm() {
    for (name, format, n) in [
        ("ua-loft/processed/zemax/AnoBlackEC1onAlum.bsdf", Format::Zemax, 600),
        ("ua-loft/processed/fred/AnoBlackEC1onAlum.txt", Format::Fred, 600),
        ("ua-loft/raw/rt-300s/MagicBlack_v1o0_20250829.xls", Format::Rt300s, 300),
    ] {
        let Some(path) = real_file(name) else { return };
        let bytes = std::fs::read(&path).unwrap();
        let n_refused = refused("damaged", &bytes, format, n);
        assert!(n_refused > n / 4, "{name}: {n_refused} of {n} refused");
    }
}

#[test]
fn tables_that_are_damaged_do_no_harm() {
    let row = |k: usize| format!("0.5,0.{},0.{},{},0.25\n", k % 7, k % 9, k % 5);
    let rows: String = (0..40).map(row).collect();
    let astm = format!("NUM_POINTS 40\nWAVELENGTH 0.55\nVARS theta_i,phi_i,theta_r,phi_r,f\n{rows}");
    let table = format!("theta_i,phi_i,theta_o,phi_o,value\n{rows}");
    let pab_opto =
        format!("#format: theta phi DSF\n#incident_angle 30 0\n{}", "10 20 0.5\n30 40 0.25\n".repeat(20));
    for (text, format) in [(astm, Format::Astm), (table, Format::Table), (pab_opto, Format::PabOpto)] {
        let n_refused = refused("damaged", text.as_bytes(), format, 600);
        assert!(n_refused > 150, "{}: {n_refused} refused", format.name());
    }
}

#[test]
fn garbage_is_refused_whatever_it_is_taken_for() {
    let mut random = Random(42);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("garbage");
    for length in [0, 1, 7, 8, 100, 5000] {
        let bytes: Vec<u8> = (0..length).map(|_| random.below(256) as u8).collect();
        std::fs::write(&path, &bytes).unwrap();
        for format in Format::ALL.map(Some).into_iter().chain([None]) {
            let options = Options { format, ..Options::default() };
            let error = read_files(std::slice::from_ref(&path), &options).unwrap_err();
            assert!(error.to_string().contains("garbage"), "{error}");
        }
    }
}
