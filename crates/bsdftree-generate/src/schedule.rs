//! When paths are counted, and when there are enough.
//!
//! Paths of a cell are followed in rounds whose ends are the same for every way to stop: 64 · 2^k, and multiples of 16 384. So a
//! generation that stopped by itself after n paths has the bits of one that was asked for n.

use std::ops::Range;
use std::time::Duration;

/// Paths of the first round.
pub(crate) const FIRST: u64 = 64;
/// Most paths of a round: sums of so many weights are exact enough in 32 bits.
const MOST: u64 = 1 << 14;

/// Why a generation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// All paths that were asked for are done.
    Samples,
    /// The estimated error is as small as asked for.
    Tolerance,
    /// The time is over.
    Time,
    /// More paths could take more memory than allowed.
    Memory,
}

/// The round after `done` paths, of at most `samples` in all.
pub(crate) fn round_after(done: u64, samples: u64) -> Range<u64> {
    let end = match done {
        0 => FIRST,
        _ if done < MOST => 2 * FIRST.max(1 << done.ilog2()),
        _ => (done / MOST + 1) * MOST,
    };
    done..end.min(samples)
}

/// Whether a round that is not cut short can end here.
pub(crate) fn is_whole(end: u64) -> bool {
    end >= FIRST && if end < MOST { end.is_power_of_two() } else { end.is_multiple_of(MOST) }
}

/// How many paths can be done in the time that is left: at least a sixteenth of those done, or it is not worth a round.
pub(crate) fn affordable(done: u64, tracing: Duration, left: Duration) -> Option<u64> {
    let more = (left.as_secs_f64() / (tracing.as_secs_f64() / done as f64).max(1e-12)) as u64;
    (more > done / 16).then(|| done.saturating_add(more))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_double_and_then_go_on_evenly() {
        let mut ends = Vec::new();
        let mut done = 0;
        while done < 50_000 {
            done = round_after(done, 50_000).end;
            ends.push(done);
        }
        assert_eq!(ends, [64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768, 49152, 50_000]);
        assert!(ends[..11].iter().all(|&end| is_whole(end)));
        assert!([10, 63, 65, 1000, 16_385, 24_576, 50_000].iter().all(|&end| !is_whole(end)));
        assert_eq!(round_after(0, 10), 0..10);
        assert_eq!(round_after(64, 100), 64..100);
    }

    #[test]
    fn what_the_time_allows_follows_from_what_it_took() {
        let seconds = Duration::from_secs_f64;
        assert_eq!(affordable(100, seconds(2.0), seconds(4.0)), Some(300));
        assert_eq!(affordable(100, seconds(2.0), seconds(0.1)), None);
    }
}
