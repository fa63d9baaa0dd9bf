//! Interrupted generations end with the bits of others.

use std::fs;
use std::time::Duration;

use super::*;
use crate::Stop;

/// Every state that a kill can leave, but for torn blocks: so many blocks of the first round, or all and so many of the second.
#[test]
fn goes_on_after_any_block_with_the_same_bits() {
    let plain = Options { reuse: false, ..tiny(Rank::Four) };
    for (options, step) in [(tiny(Rank::Four), 7), (plain, 1), (tiny(Rank::Three), 1)] {
        let expected = direct(&options);
        let whole = directory();
        assert_eq!(resumed(&options, whole.path()).1, expected);
        let files = ["0-64.blocks", "64-100.blocks"];
        let rounds = files.map(|name| fs::read(whole.path().join(name)).expect("a round"));
        for (round, bytes) in rounds.iter().enumerate() {
            for (n, &end) in ends(bytes).iter().enumerate().step_by(step) {
                let killed = copied(whole.path());
                fs::write(killed.path().join(files[round]), &bytes[..end]).expect("written");
                if round == 0 {
                    fs::remove_file(killed.path().join(files[1])).expect("removed");
                }
                let (from, result) = resumed(&options, killed.path());
                assert_eq!(result, expected, "after block {n} of round {round}");
                if n > 0 && end < bytes.len() {
                    let share = n as f64 / (ends(bytes).len() - 1) as f64;
                    let [samples, round_end] = [[0, 64], [64, 100]][round];
                    assert_eq!(from, Some(Resumed { samples, round_end, share, n_dropped: 0 }));
                }
            }
        }
    }
}

#[test]
fn blocks_in_any_order_have_the_same_bits() {
    let options = tiny(Rank::Four);
    let whole = directory();
    let (_, expected) = resumed(&options, whole.path());
    for name in ["0-64.blocks", "64-100.blocks"] {
        let bytes = fs::read(whole.path().join(name)).expect("a round");
        let ends = ends(&bytes);
        let mut blocks: Vec<&[u8]> = ends.windows(2).map(|w| &bytes[w[0]..w[1]]).collect();
        blocks.reverse();
        blocks.rotate_left(5);
        fs::write(whole.path().join(name), blocks.concat()).expect("written");
    }
    let (from, result) = resumed(&options, whole.path());
    assert_eq!(from.map(|from| from.samples), Some(100), "nothing is counted again");
    assert_eq!(result, expected);
}

#[test]
fn what_was_cancelled_goes_on_with_any_number_of_threads() {
    let options = Options { samples: 2000, ..tiny(Rank::Four) };
    let expected = direct(&options);
    let kept = directory();
    let mut n_cancelled = 0;
    for k in 0.. {
        let options =
            Options { checkpoint: Some(kept.path().into()), threads: Some(1 + k % 3), ..options.clone() };
        let progress = Progress::default();
        let outcome = std::thread::scope(|scope| {
            let generation = scope.spawn(|| generate(&blinds(), &options, &progress));
            // Each time a little further.
            while !generation.is_finished() && progress.paths().0 < 12_000 * (k as u64 + 1) {
                std::thread::yield_now();
            }
            progress.cancel();
            generation.join().expect("no panic")
        });
        match outcome {
            Err(GenerateError::Cancelled) => n_cancelled += 1,
            outcome => {
                assert_eq!(bits(&outcome.expect("a generation")), expected);
                break;
            }
        }
    }
    assert!(n_cancelled > 0);
}

#[test]
fn more_samples_have_the_bits_of_as_many_at_once_and_so_have_fewer() {
    let kept = directory();
    for samples in [10, 100, 64, 300, 100] {
        let options = Options { samples, ..tiny(Rank::Four) };
        assert_eq!(resumed(&options, kept.path()).1, direct(&options), "{samples} samples");
    }
}

#[test]
fn options_that_change_no_count_may_change() {
    let kept = directory();
    let first = tiny(Rank::Four);
    resumed(&first, kept.path());
    let other = Options {
        pruned: false,
        detail: Some(0.5),
        direction_tolerance: 0.5,
        reciprocity: Some(false),
        unit: bsdftree::bsdf::LengthUnit::Inch,
        threads: Some(1),
        ..first
    };
    let (from, result) = resumed(&other, kept.path());
    assert_eq!(from.map(|from| from.samples), Some(100), "nothing is counted again");
    assert_eq!(result, direct(&other));
}

#[test]
fn a_tolerance_is_reached_after_as_many_rounds() {
    let options = Options {
        tolerance: Some(0.1),
        direction_tolerance: 0.1,
        samples: 1 << 14,
        reuse: false,
        pruned: false,
        ..tiny(Rank::Four)
    };
    let expected = run(&options).expect("a generation");
    let samples = expected.report.samples;
    assert!(samples > 128, "{samples} are too few to resume");
    assert_eq!(expected.report.stop, Stop::Tolerance);
    let kept = directory();
    let fewer = Options { samples: 128, tolerance: None, ..options.clone() };
    resumed(&fewer, kept.path());
    assert_eq!(resumed(&options, kept.path()).1, bits(&expected));
    assert_eq!(resumed(&options, kept.path()).1, bits(&expected));
}

#[test]
fn a_round_that_time_cut_short_is_not_cut_shorter() {
    let kept = directory();
    let cut = tiny(Rank::Four);
    let (_, expected) = resumed(&cut, kept.path());
    let path = kept.path().join("64-100.blocks");
    let bytes = fs::read(&path).expect("a round");
    fs::write(&path, &bytes[..ends(&bytes)[3]]).expect("written");
    let budget = Options { time_budget: Some(Duration::ZERO), samples: 5000, ..cut };
    assert_eq!(resumed(&budget, kept.path()).1, expected);
}

#[test]
fn rounds_become_one_file_with_the_same_bits() {
    let kept = directory();
    let options = Options { samples: 5000, ..tiny(Rank::Three) };
    assert_eq!(resumed(&options, kept.path()).1, direct(&options));
    let names = names(kept.path());
    let base = names.iter().find(|n| n.starts_with("0-")).expect("a file of all rounds");
    assert!(base != "0-64.blocks" && names.len() < 8, "{names:?}");
    // As after a kill before the rounds were removed, or before the file had its name.
    for left in ["0-64.blocks", "64-128.blocks", "0-4096.blocks.new"] {
        fs::write(kept.path().join(left), b"what is left").expect("written");
    }
    let more = Options { samples: 9000, ..options };
    assert_eq!(resumed(&more, kept.path()).1, direct(&more));
    let fewer = Options { samples: 100, checkpoint: Some(kept.path().into()), ..more };
    let message = run(&fewer).expect_err("more is there").to_string();
    assert!(message.contains("more than the 100 asked for"), "{message}");
    // What is damaged for good is not counted in another way.
    let base = super::names(kept.path()).into_iter().find(|n| n.starts_with("0-")).expect("a base");
    let mut bytes = fs::read(kept.path().join(&base)).expect("a base");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(kept.path().join(&base), bytes).expect("written");
    let again = Options { samples: 9000, ..fewer };
    let message = run(&again).expect_err("damaged").to_string();
    assert!(message.contains(&base) && message.contains("delete it"), "{message}");
    fs::remove_file(kept.path().join(&base)).expect("removed");
    assert_eq!(resumed(&again, kept.path()).1, direct(&again));
}
