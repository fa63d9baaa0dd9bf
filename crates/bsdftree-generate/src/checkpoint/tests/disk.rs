//! Files that are torn, damaged, or cannot be written.

use std::fs;

use super::*;

/// A job whose files are a few hundred bytes.
fn smallest() -> Options {
    Options { samples: 70, reuse: false, ..tiny(Rank::Three) }
}

#[test]
fn a_tail_torn_at_any_byte_is_counted_again() {
    let options = smallest();
    let whole = directory();
    let (_, expected) = resumed(&options, whole.path());
    let bytes = fs::read(whole.path().join("64-70.blocks")).expect("a round");
    let ends = ends(&bytes);
    assert!(ends.len() == 5 && bytes.len() > 200);
    let torn = copied(whole.path());
    for length in 0..bytes.len() {
        fs::write(torn.path().join("64-70.blocks"), &bytes[..length]).expect("written");
        let (from, result) = resumed(&options, torn.path());
        assert_eq!(result, expected, "torn at byte {length}");
        let n_whole = ends.iter().rposition(|&end| end <= length).expect("0 is an end");
        let from = from.expect("it goes on");
        assert_eq!(from.share, n_whole as f64 / 4.0);
        assert_eq!(from.n_dropped, (length - ends[n_whole]) as u64);
    }
}

#[test]
fn a_bit_flipped_anywhere_is_counted_again() {
    let options = smallest();
    let whole = directory();
    let (_, expected) = resumed(&options, whole.path());
    for name in ["0-64.blocks", "64-70.blocks"] {
        let bytes = fs::read(whole.path().join(name)).expect("a round");
        for at in (0..bytes.len()).step_by(3) {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << (at % 8);
            fs::write(whole.path().join(name), &damaged).expect("written");
            let (from, result) = resumed(&options, whole.path());
            assert_eq!(result, expected, "byte {at} of {name}");
            assert!(from.expect("it goes on").n_dropped > 0);
        }
    }
}

#[test]
fn rounds_do_not_stand_in_for_each_other() {
    let options = smallest();
    let kept = directory();
    let (_, expected) = resumed(&options, kept.path());
    let other = directory();
    resumed(&Options { seed: 9, ..options.clone() }, other.path());
    for from in [kept.path().join("0-64.blocks"), other.path().join("64-70.blocks")] {
        fs::copy(from, kept.path().join("64-70.blocks")).expect("copied");
        assert_eq!(resumed(&options, kept.path()).1, expected);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_and_nothing_is_lost() {
    let options = Options { samples: 300, ..tiny(Rank::Four) };
    let kept = directory();
    let before = Options { samples: 64, ..options.clone() };
    resumed(&before, kept.path());
    let round = kept.path().join("64-128.blocks");
    std::os::unix::fs::symlink("/dev/full", &round).expect("a link");
    let full = Options { checkpoint: Some(kept.path().into()), ..options.clone() };
    let message = run(&full).expect_err("no room").to_string();
    for expected in ["cannot write", "64-128.blocks", "No space left on device", "is kept"] {
        assert!(message.contains(expected), "{message}");
    }
    fs::remove_file(round).expect("removed");
    let (from, result) = resumed(&options, kept.path());
    assert_eq!(from.expect("it goes on").samples, 64);
    assert_eq!(result, direct(&options));
}
