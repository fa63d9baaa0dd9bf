//! What the tests share: tiny jobs, directories, and results as bits.

mod bytes;
mod disk;
mod refuse;
mod resume;

use std::fs;
use std::path::Path;

use bsdftree::Rank;
use bsdftree_device::Device;
use tempfile::TempDir;

use crate::{GenerateError, Generated, Layout, Options, Progress, Resumed, generate};

fn directory() -> TempDir {
    tempfile::tempdir().expect("a directory")
}

/// A blind in 2·16 or 2·2 blocks a round, of which there are two.
fn tiny(rank: Rank) -> Options {
    Options { samples: 100, threads: Some(2), ..Options::new(Layout::Tree { rank, log2_res: 2 }) }
}

fn blinds() -> Device {
    Device::from_spec("blinds").expect("a family")
}

fn run(options: &Options) -> Result<Generated, GenerateError> {
    generate(&blinds(), options, &Progress::default())
}

/// Everything that a generation says of the device, to the bit.
fn bits(generated: &Generated) -> String {
    let Generated { bsdf, errors, report } = generated;
    let lost = (report.samples, report.paths, report.lost, report.error.to_bits());
    format!("{lost:?} {:?} {:?}", bsdf.bands, errors.bands)
}

fn direct(options: &Options) -> String {
    bits(&run(&Options { checkpoint: None, ..options.clone() }).expect("a generation"))
}

/// Goes on in a directory; where from, and the result.
fn resumed(options: &Options, directory: &Path) -> (Option<Resumed>, String) {
    let progress = Progress::default();
    let options = Options { checkpoint: Some(directory.into()), ..options.clone() };
    let generated = generate(&blinds(), &options, &progress).expect("a generation");
    (progress.resumed(), bits(&generated))
}

/// A copy of a checkpoint.
fn copied(from: &Path) -> TempDir {
    let to = directory();
    for entry in fs::read_dir(from).expect("a directory") {
        let entry = entry.expect("an entry");
        fs::copy(entry.path(), to.path().join(entry.file_name())).expect("a copy");
    }
    to
}

/// Ends of the whole blocks of a file; 0 first.
fn ends(bytes: &[u8]) -> Vec<usize> {
    let mut ends = vec![0];
    while let Some(head) = bytes[ends[ends.len() - 1]..].first_chunk::<8>() {
        ends.push(ends[ends.len() - 1] + 12 + u64::from_le_bytes(*head) as usize);
    }
    assert_eq!(ends.last(), Some(&bytes.len()));
    ends
}

fn names(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).expect("a directory");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
