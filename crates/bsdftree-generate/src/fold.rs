//! Even spreads over a device that repeats within its aperture.
//!
//! In: the periods of a device and its aperture. Out: a map of the unit square onto itself that keeps areas. Where n periods lie side by side, the place within
//! a period matters and which period it is hardly does. So the leading 16 bits of a coordinate, in which stratified points are
//! even, tell the place within a period, and the others the period, and then the place more exactly. What is left
//! of the aperture beside whole periods is taken as it is.
//! Invariant: a uniform point becomes a uniform point (periods up to one part in 1000, by the number of bits), so that no estimate is biased
//! whether or not the device has these periods.

use crate::options::Aperture;

/// Parts that the leading bits tell.
const LEADING: f64 = 65_536.0;

/// Where the paths of a cell begin, by even points of the unit square.
#[derive(Clone, Debug)]
pub(crate) struct Fold {
    axes: [Option<Periods>; 2],
}

#[derive(Clone, Copy, Debug)]
struct Periods {
    count: f64,
    /// The part of the aperture that they cover.
    share: f64,
}

impl Fold {
    /// `periods` are those of the device \[m\].
    pub fn new(periods: [Option<f64>; 2], aperture: &Aperture) -> Fold {
        Fold {
            axes: [0, 1].map(|axis| {
                let extent = aperture.max[axis] - aperture.min[axis];
                let period = periods[axis]?;
                // Up to rounding of a period that divides the aperture.
                let count = (extent / period + 1e-6).floor();
                (count >= 2.0).then(|| Periods { count, share: (count * period / extent).min(1.0) })
            }),
        }
    }

    /// The point of the aperture for a point of even numbers.
    #[inline]
    pub fn place(&self, point: [f64; 2]) -> [f64; 2] {
        // Not by `map`, which is not inlined.
        let ([a, b], [u, v]) = (self.axes, point);
        [place(a, u), place(b, v)]
    }
}

#[inline]
fn place(periods: Option<Periods>, u: f64) -> f64 {
    periods.map_or(u, |periods| periods.place(u))
}

impl Periods {
    #[inline]
    fn place(&self, u: f64) -> f64 {
        if u >= self.share {
            return u;
        }
        let leading = u / self.share * LEADING;
        let part = f64::from(leading as u32);
        let rest = (leading - part) * self.count;
        let period = f64::from(rest as u32);
        let within = (part + rest - period) / LEADING;
        ((period + within) / self.count * self.share).min(self.share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_points_are_even_within_a_period() {
        for (count, share) in [(50.0, 1.0), (12.0, 0.96), (2.0, 0.7)] {
            let periods = Periods { count, share };
            let mut phases = [0u32; 16];
            for k in 0..64u32 {
                let u = f64::from(k.reverse_bits()) * 2.0f64.powi(-32);
                let place = periods.place(u);
                assert!((0.0..1.0).contains(&place));
                if u < share {
                    phases[((place / share * count).fract() * 16.0) as usize] += 1;
                }
            }
            let even = 64.0 * share / 16.0;
            assert!(phases.iter().all(|&p| (f64::from(p) - even).abs() <= 1.5), "{count}: {phases:?}");
        }
    }

    #[test]
    fn all_places_are_as_likely() {
        let periods = Periods { count: 50.0, share: 0.99 };
        let n = 1_000_000;
        let mut bins = vec![0.0; 200];
        for k in 0..n {
            bins[(periods.place((f64::from(k) * 0.618_033_988_749_895).fract()) * 200.0) as usize] += 1.0;
        }
        let expected = f64::from(n) / 200.0;
        let chi2: f64 = bins.iter().map(|b: &f64| (b - expected).powi(2) / expected).sum();
        // With 199 degrees of freedom exceeded with probability 1e-6.
        assert!(chi2 < 306.0, "χ² = {chi2}");
    }
}
