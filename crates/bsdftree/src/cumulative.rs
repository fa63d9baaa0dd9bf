//! Choosing one of many with given weights by a single number: cumulative sums with a guide table.
//!
//! H. C. Chen and Y. Asau, "On generating random variates from an empirical distribution", AIIE Transactions 6, 1974:
//! the guide says where to begin in the sums, so that on average O(1) of them are compared.

/// The largest number below 1.
pub(crate) const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Weights summed up, in the order in which they were given.
#[derive(Clone, Debug)]
pub(crate) struct Cumulative {
    /// `sums[k]` = weights before the k-th; one more than there are weights, the last one the total.
    sums: Vec<f64>,
    /// `guide[j]` = the last k with `sums[k] ≤ total·j/n`.
    guide: Vec<u32>,
}

impl Cumulative {
    /// Sums weights ≥ 0.
    pub fn new(weights: impl Iterator<Item = f64>) -> Cumulative {
        let mut total = 0.0;
        let mut sums = vec![0.0];
        sums.extend(weights.map(|w| {
            total += w;
            total
        }));
        let n = sums.len() - 1;
        let mut guide = Vec::with_capacity(n);
        let mut k = 0;
        for j in 0..n {
            while k + 1 < n && sums[k + 1] <= total * j as f64 / n as f64 {
                k += 1;
            }
            guide.push(k as u32);
        }
        Cumulative { sums, guide }
    }

    /// Sum of all weights.
    #[inline]
    pub fn total(&self) -> f64 {
        self.sums[self.sums.len() - 1]
    }

    /// The one chosen by `u` in \[0, 1), and what is left of `u` for a choice inside it, in \[0, 1).
    /// `None` if all weights are 0. Never chooses one of weight 0.
    #[inline]
    pub fn find(&self, u: f64) -> Option<(usize, f64)> {
        let n = self.guide.len();
        let total = self.total();
        if total <= 0.0 {
            return None;
        }
        let target = u.clamp(0.0, 1.0) * total;
        let mut k = self.guide[((u * n as f64) as usize).min(n - 1)] as usize;
        // Rounding may put the guide one too far.
        while k > 0 && self.sums[k] > target {
            k -= 1;
        }
        while k + 1 < n && self.sums[k + 1] <= target {
            k += 1;
        }
        while self.sums[k + 1] <= self.sums[k] {
            k -= 1;
        }
        let rest = (target - self.sums[k]) / (self.sums[k + 1] - self.sums[k]);
        Some((k, rest.clamp(0.0, BELOW_ONE)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finds_what_a_linear_search_finds(
            weights in prop::collection::vec(prop_oneof![Just(0.0), 0.0..10.0f64], 1..60),
            u in 0.0..1.0f64,
        ) {
            let c = Cumulative::new(weights.iter().copied());
            let total: f64 = weights.iter().sum();
            match c.find(u) {
                None => prop_assert_eq!(total, 0.0),
                Some((k, rest)) => {
                    let before: f64 = weights[..k].iter().sum();
                    prop_assert!(weights[k] > 0.0);
                    prop_assert!((0.0..1.0).contains(&rest));
                    prop_assert!((before + rest * weights[k] - u * total).abs() < 1e-12 * total.max(1.0));
                }
            }
        }
    }

    #[test]
    fn numbers_at_the_ends_choose_weights_above_zero() {
        let c = Cumulative::new([0.0, 1.0, 0.0, 2.0, 0.0].into_iter());
        assert_eq!(c.find(0.0).unwrap().0, 1);
        assert_eq!(c.find(1.0 - f64::EPSILON).unwrap().0, 3);
    }
}
