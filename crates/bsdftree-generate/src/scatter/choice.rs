//! Taking one of several lobes by one random number.

use crate::random::Random;

/// The largest number below 1.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// The lobe that a random number falls to among shares of the light, the place in its share in [0, 1), and the sum of all. `None` if
/// there is no light.
#[inline]
pub(super) fn choose(shares: [f64; 4], random: &mut Random) -> Option<(usize, f64, f64)> {
    let total: f64 = shares.iter().sum();
    // Rounding may lead past the last share, but not to one that is nothing.
    let last = shares.iter().rposition(|&share| share > 0.0)?;
    let mut place = random.next_open() * total;
    let mut way = 0;
    while way < last && place >= shares[way] {
        place -= shares[way];
        way += 1;
    }
    Some((way, (place / shares[way]).min(BELOW_ONE), total))
}
