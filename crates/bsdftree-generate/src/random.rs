//! Random numbers that are a function of where they are used, not of who used one before.
//!
//! In: a seed, the incident cell, the number of the sample within the cell. Out: uniform numbers in [0, 1).
//! Invariant: equal (seed, cell, sample) give equal numbers on every machine, thread and worker, and different
//! ones never share a block, so results do not depend on how the work was divided.
//!
//! Sources: Philox4x32-10, J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, "Parallel random numbers: as easy
//! as 1, 2, 3", SC '11, doi:10.1145/2063384.2063405. The stratified points: S. Joe, F. Y. Kuo,
//! "Constructing Sobol sequences with better two-dimensional projections", SIAM J. Sci. Comput. 30 (2008); their scrambling:
//! A. B. Owen, "Randomly permuted (t,m,s)-nets and (t,s)-sequences" (1995), by the hash of S. Laine, T. Karras, "Stratified
//! sampling for stochastic transparency", CGF 30 (2011), with the constants of N. Vegdahl (2021).

/// Cells and samples are numbered below this: 48 bits each, which with a 32-bit block number fill the counter.
pub const NUMBER_LIMIT: u64 = 1 << 48;

/// One block of Philox4x32-10: four random words for a counter and a key.
#[inline]
pub fn philox4x32(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    // Multipliers and Weyl increments of the paper, table 2 and section 3.3.
    const MULTIPLIER: [u64; 2] = [0xD251_1F53, 0xCD9E_8D57];
    const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];
    for _ in 0..10 {
        let products = [u64::from(counter[0]) * MULTIPLIER[0], u64::from(counter[2]) * MULTIPLIER[1]];
        counter = [
            (products[1] >> 32) as u32 ^ counter[1] ^ key[0],
            products[1] as u32,
            (products[0] >> 32) as u32 ^ counter[3] ^ key[1],
            products[0] as u32,
        ];
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
    }
    counter
}

/// The middle of one of 2³² equal intervals of (0, 1).
#[inline]
fn open(word: u32) -> f64 {
    (f64::from(word) + 0.5) * 2.0_f64.powi(-32)
}

fn key(seed: u64) -> [u32; 2] {
    [seed as u32, (seed >> 32) as u32]
}

/// The stream of random numbers of one path.
#[derive(Clone, Debug)]
pub struct Random {
    key: [u32; 2],
    /// Block number, sample (low 32 bits), sample and cell (16 high bits of each), cell (low 32 bits).
    counter: [u32; 4],
    block: [u32; 4],
    used: usize,
}

impl Random {
    /// The stream of sample `sample` of incident cell `cell`.
    ///
    /// # Panics
    /// If `cell` or `sample` is not below [`NUMBER_LIMIT`]: streams would coincide.
    #[inline]
    pub fn new(seed: u64, cell: u64, sample: u64) -> Self {
        assert!((cell | sample) < NUMBER_LIMIT, "cell {cell} and sample {sample} must be below 2^48");
        let high = (sample >> 32) as u32 | ((cell >> 32) as u32) << 16;
        Random { key: key(seed), counter: [0, sample as u32, high, cell as u32], block: [0; 4], used: 4 }
    }

    /// 32 random bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        if self.used == 4 {
            self.refill();
        }
        let word = self.block[self.used & 3];
        self.used += 1;
        word
    }

    // Apart from its callers, which there are many of and each would carry a copy.
    #[inline(never)]
    fn refill(&mut self) {
        self.block = philox4x32(self.counter, self.key);
        self.counter[0] += 1;
        self.used = 0;
    }

    /// Uniform in [0, 1), a multiple of 2⁻²⁴. Uses one word.
    #[inline]
    pub fn next_f32(&mut self) -> f32 {
        (self.next_u32() >> 8) as f32 * 2.0_f32.powi(-24)
    }

    /// Uniform in [0, 1), a multiple of 2⁻⁵³. Uses two words.
    #[inline]
    pub fn next_f64(&mut self) -> f64 {
        let (high, low) = (u64::from(self.next_u32() >> 5), u64::from(self.next_u32() >> 6));
        (high << 26 | low) as f64 * 2.0_f64.powi(-53)
    }

    /// Uniform in (0, 1), the middle of one of 2³² intervals: safe for logarithms and divisions. Uses one word.
    #[inline]
    pub fn next_open(&mut self) -> f64 {
        open(self.next_u32())
    }
}

/// Independent scramblings among which the paths of an incident cell are dealt in turn. Their scatter is the error of a mean, which
/// the scatter of the points of one scrambling is not.
pub const N_REPLICATES: usize = 8;

/// The first numbers of each path of an incident cell, spread evenly: incident square (2), origin (2), and the first four
/// random words of the path, which decide its first bounce.
///
/// Paths are dealt in turn to [`N_REPLICATES`] Sobol sequences, each with its own nested uniform (Owen) scrambling. Each point by
/// itself is uniform, so that a mean over any number of points is unbiased; it is best over a power of two in each sequence.
#[derive(Clone, Debug)]
pub struct Stratified {
    /// The first of the words that scramble.
    words: Random,
    /// The scramblings, each drawn when first used.
    scrambles: [Option<[u32; 8]>; N_REPLICATES],
    /// A point of the sequence before scrambling, and its number: neighbours differ by little.
    number: u32,
    point: [u32; 8],
}

/// Where a path starts, as a point of the incident cell's square and one of the aperture, and its random words.
#[derive(Clone, Debug)]
pub struct Start {
    /// In the incident cell, \[0, 1)².
    pub incident: [f64; 2],
    /// In the aperture, \[0, 1)².
    pub origin: [f64; 2],
    /// The path's stream, whose first four words belong to the point.
    pub random: Random,
}

impl Stratified {
    /// The points of incident cell `cell`.
    ///
    /// # Panics
    /// If `cell` is not below [`NUMBER_LIMIT`].
    pub fn new(seed: u64, cell: u64) -> Self {
        // The last blocks of the counter, which no path reaches, so that scramblings share no bits with paths.
        let mut words = Random::new(seed, cell, 0);
        words.counter[0] = u32::MAX - 2 * N_REPLICATES as u32;
        Stratified { words, scrambles: [None; N_REPLICATES], number: 0, point: [0; 8] }
    }

    /// The eight words of a replicate.
    #[inline]
    fn scramble(&mut self, replicate: usize) -> [u32; 8] {
        match self.scrambles[replicate] {
            Some(scramble) => scramble,
            None => self.drawn(replicate),
        }
    }

    #[cold]
    fn drawn(&mut self, replicate: usize) -> [u32; 8] {
        let mut words = self.words.clone();
        words.counter[0] += 2 * replicate as u32;
        *self.scrambles[replicate].insert([(); 8].map(|()| words.next_u32()))
    }

    /// The 32-bit fractions of point number `sample`, below 8 · 2³².
    #[inline]
    fn point(&mut self, sample: u64) -> [u32; 8] {
        let scramble = self.scramble((sample % N_REPLICATES as u64) as usize);
        let number = (sample / N_REPLICATES as u64) as u32;
        // Points are linear in the bits of their numbers.
        let mut changed = number ^ self.number;
        while changed != 0 {
            let direction = &DIRECTIONS[changed.trailing_zeros() as usize];
            self.point = std::array::from_fn(|j| self.point[j] ^ direction[j]);
            changed &= changed - 1;
        }
        self.number = number;
        std::array::from_fn(|j| scrambled(self.point[j], scramble[j]).reverse_bits())
    }

    /// The start of path `sample` of the cell and seed that `self` was made for.
    #[inline]
    pub fn start(&mut self, seed: u64, cell: u64, sample: u64) -> Start {
        let [u, v, s, t, words @ ..] = self.point(sample);
        let random = Random { block: words, used: 0, ..Random::new(seed, cell, sample) };
        Start { incident: [fraction(u), fraction(v)], origin: [fraction(s), fraction(t)], random }
    }
}

impl Start {
    /// The start of a path whose numbers are all independent.
    pub fn independent(seed: u64, cell: u64, sample: u64) -> Start {
        let mut random = Random::new(seed, cell, sample);
        let [u, v, s, t] = [(); 4].map(|()| random.next_u32());
        Start { incident: [fraction(u), fraction(v)], origin: [fraction(s), fraction(t)], random }
    }
}

/// In [0, 1).
#[inline]
fn fraction(word: u32) -> f64 {
    f64::from(word) * 2.0_f64.powi(-32)
}

/// A hash in which no bit depends on a higher one: a nested uniform scrambling of fractions whose bits are reversed.
#[inline]
fn scrambled(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Direction numbers of the eight coordinates for each bit of a sample's number, as 32-bit fractions with the bits reversed.
static DIRECTIONS: [[u32; 8]; 32] = directions();

const fn directions() -> [[u32; 8]; 32] {
    // Degree, inner coefficients and first numbers of the primitive polynomials of the table new-joe-kuo-6.
    const POLYNOMIALS: [(usize, u32, [u32; 5]); 8] = [
        (0, 0, [0, 0, 0, 0, 0]),
        (1, 0, [1, 0, 0, 0, 0]),
        (2, 1, [1, 3, 0, 0, 0]),
        (3, 1, [1, 3, 1, 0, 0]),
        (3, 2, [1, 1, 1, 0, 0]),
        (4, 1, [1, 1, 3, 3, 0]),
        (4, 4, [1, 3, 5, 13, 0]),
        (5, 2, [1, 1, 5, 5, 17]),
    ];
    let mut table = [[0; 8]; 32];
    let mut j = 0;
    while j < 8 {
        let (degree, inner, first) = POLYNOMIALS[j];
        let mut column = [0u32; 32];
        let mut bit = 0;
        while bit < 32 {
            column[bit] = if degree == 0 {
                1 << (31 - bit)
            } else if bit < degree {
                first[bit] << (31 - bit)
            } else {
                let mut v = column[bit - degree] ^ (column[bit - degree] >> degree);
                let mut k = 1;
                while k < degree {
                    if (inner >> (degree - 1 - k)) & 1 == 1 {
                        v ^= column[bit - k];
                    }
                    k += 1;
                }
                v
            };
            table[bit][j] = column[bit].reverse_bits();
            bit += 1;
        }
        j += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn philox_gives_the_published_answers() {
        // File kat_vectors of Random123, the paper's reference library.
        let cases = [
            ([0; 4], [0; 2], [0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8]),
            ([u32::MAX; 4], [u32::MAX; 2], [0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd]),
            (
                [0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344],
                [0xa4093822, 0x299f31d0],
                [0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1],
            ),
        ];
        for (counter, key, expected) in cases {
            assert_eq!(philox4x32(counter, key), expected);
        }
    }

    #[test]
    fn every_part_of_the_address_changes_the_stream() {
        let first = |seed, cell, sample| Random::new(seed, cell, sample).next_f64();
        let parts =
            [(0, 0, 0), (1, 0, 0), (1 << 32, 0, 0), (0, 1, 0), (0, 1 << 32, 0), (0, 0, 1), (0, 0, 1 << 32)];
        for (i, a) in parts.iter().enumerate() {
            for b in &parts[..i] {
                assert_ne!(first(a.0, a.1, a.2), first(b.0, b.1, b.2), "{a:?} {b:?}");
            }
        }
        let last = NUMBER_LIMIT - 1;
        assert_eq!(Random::new(0, last, last).counter, [0, u32::MAX, u32::MAX, u32::MAX]);
    }

    #[test]
    #[should_panic(expected = "below 2^48")]
    fn numbers_that_would_share_a_stream_are_refused() {
        Random::new(0, NUMBER_LIMIT, 0);
    }

    #[test]
    fn words_continue_across_blocks() {
        let mut random = Random::new(5, 6, 7);
        let words: Vec<u32> = (0..8).map(|_| random.next_u32()).collect();
        assert_eq!(words[..4], philox4x32([0, 7, 0, 6], [5, 0]));
        assert_eq!(words[4..], philox4x32([1, 7, 0, 6], [5, 0]));
    }

    #[test]
    fn numbers_are_uniform_and_inside_their_interval() {
        // χ² with 99 degrees of freedom: 179 is exceeded with probability 1.5e-6.
        let mut random = Random::new(1, 2, 3);
        for draw in
            [|r: &mut Random| r.next_f64(), |r: &mut Random| f64::from(r.next_f32()), Random::next_open]
        {
            let mut counts = [0.0; 100];
            for _ in 0..100_000 {
                let u = draw(&mut random);
                assert!((0.0..1.0).contains(&u));
                counts[(u * 100.0) as usize] += 1.0;
            }
            let chi2: f64 = counts.iter().map(|n| (n - 1000.0_f64).powi(2) / 1000.0).sum();
            assert!(chi2 < 179.0, "χ² = {chi2}");
        }
    }

    #[test]
    fn extreme_words_stay_inside_the_interval() {
        let extreme = |word| Random { key: [0; 2], counter: [0; 4], block: [word; 4], used: 0 };
        assert_eq!(extreme(0).next_f64(), 0.0);
        assert!(extreme(u32::MAX).next_f64() < 1.0 && extreme(u32::MAX).next_f32() < 1.0);
        assert!(extreme(0).next_open() > 0.0 && extreme(u32::MAX).next_open() < 1.0);
    }

    /// The eight numbers of a start.
    fn numbers(start: &Start) -> [f64; 8] {
        let [a, b, c, d] = start.random.block.map(fraction);
        let ([u, v], [s, t]) = (start.incident, start.origin);
        [u, v, s, t, a, b, c, d]
    }

    /// A smooth function of all eight coordinates with mean 1.
    fn smooth(p: [f64; 8]) -> f64 {
        p.iter().enumerate().map(|(j, x)| 1.0 + (x - 0.5) / (1.0 + j as f64)).product()
    }

    fn mean(cell: u64, n: u64) -> f64 {
        let mut points = Stratified::new(9, cell);
        (0..n).map(|k| smooth(numbers(&points.start(9, cell, k)))).sum::<f64>() / n as f64
    }

    #[test]
    fn stratified_starts_are_unbiased_for_any_number_of_them() {
        for n in [1, 3, 10, 100] {
            let runs: Vec<f64> = (0..4000).map(|cell| mean(cell, n)).collect();
            let mean = runs.iter().sum::<f64>() / runs.len() as f64;
            let variance = runs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (runs.len() - 1) as f64;
            let z = (mean - 1.0) / (variance / runs.len() as f64).sqrt();
            assert!(z.abs() < 4.5, "n = {n}: z = {z}");
        }
    }

    #[test]
    fn replicates_are_independent() {
        // The variance of the mean of all is that of the mean of independent ones: correlated ones would differ by up to 8 times.
        let n = 8 * 32;
        let (mut of_means, mut mean_of) = (0.0, 0.0);
        for cell in 0..2000 {
            let mut points = Stratified::new(2, cell);
            let mut of = |r: u64| {
                (0..32).map(|k| smooth(numbers(&points.start(2, cell, 8 * k + r))) - 1.0).sum::<f64>() / 32.0
            };
            let replicates: [f64; 8] = std::array::from_fn(|r| of(r as u64));
            of_means += (replicates.iter().sum::<f64>() / 8.0).powi(2);
            mean_of += replicates.iter().map(|x| x * x).sum::<f64>() / 64.0;
        }
        // Of 2000 squares of normal numbers each, within 4 standard errors (of the first: 1/√1000; of the second: 1/√8000).
        assert!((of_means / mean_of - 1.0).abs() < 0.14, "{n}: {of_means} {mean_of}");
    }

    #[test]
    fn scramblings_of_a_cell_are_no_numbers_of_its_paths() {
        let mut path = Random::new(3, 8, 0);
        let words: Vec<u32> = (0..1000).map(|_| path.next_u32()).collect();
        let mut points = Stratified::new(3, 8);
        let scrambles: Vec<u32> = (0..N_REPLICATES).flat_map(|r| points.scramble(r)).collect();
        assert!(!scrambles.iter().any(|word| words.contains(word)));
    }

    #[test]
    fn directions_are_those_of_sobol() {
        // Points 3, 1000 and 123456 of scipy.stats.qmc.Sobol(8, scramble=False) in its Gray-code order, times 2^20.
        let point = |k: u32| -> [u32; 8] {
            let gray = k ^ (k >> 1);
            std::array::from_fn(|j| {
                let bits = (0..32).filter(|b| gray >> b & 1 == 1);
                bits.fold(0, |x, b| x ^ DIRECTIONS[b as usize][j]).reverse_bits() >> 12
            })
        };
        assert_eq!(point(3), [262144, 786432, 786432, 786432, 262144, 262144, 786432, 262144]);
        assert_eq!(point(1000), [230400, 101376, 543744, 709632, 293888, 951296, 48128, 943104]);
        assert_eq!(point(123_456), [27784, 191624, 322184, 472184, 177400, 213128, 750600, 486600]);
    }

    #[test]
    fn stratified_points_fill_every_elementary_interval() {
        // In each replicate, each coordinate in 2^10 intervals, and the incident square in each grid of 2^10 equal rectangles: one
        // point each.
        let mut points = Stratified::new(7, 7);
        for replicate in 0..N_REPLICATES as u64 {
            let points: Vec<_> = (0..1024)
                .map(|k| numbers(&points.start(7, 7, k * N_REPLICATES as u64 + replicate)))
                .collect();
            let filled = |index: &dyn Fn(&[f64; 8]) -> usize| {
                let mut seen = vec![false; 1024];
                points.iter().for_each(|p| seen[index(p)] = true);
                seen.iter().all(|&s| s)
            };
            for j in 0..8 {
                assert!(filled(&|p| (p[j] * 1024.0) as usize));
            }
            for log2 in 0..=10 {
                let columns = f64::from(1 << log2);
                assert!(filled(
                    &|p| (p[0] * columns) as usize + (p[1] * 1024.0 / columns) as usize * columns as usize
                ));
            }
        }
    }

    #[test]
    fn stratified_points_integrate_better_than_independent_ones() {
        let n = 8 * 256;
        let (mut stratified, mut independent) = (0.0, 0.0);
        for cell in 0..100 {
            stratified += (mean(cell, n) - 1.0).powi(2);
            let starts = (0..n).map(|k| Start::independent(4, cell, k)).map(|mut start| {
                start.random.refill();
                smooth(numbers(&start))
            });
            independent += (starts.sum::<f64>() / n as f64 - 1.0).powi(2);
        }
        assert!(stratified < independent / 20.0, "{stratified} {independent}");
    }
}
