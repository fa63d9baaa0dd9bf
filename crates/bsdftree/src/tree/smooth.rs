//! A tree that answers with ramps in its leaves ([`super::slopes`]) instead of steps: values, totals and samples that fit together.
//!
//! In: directions as quantised coordinates. For one incident direction the leaves are again walked along the Hilbert curve; what a leaf
//! weighs grows linearly across the incident cell, so that three cumulative sums for each (in the middle of the finest incident cell, and
//! what it gains along both its axes) give the exact one for any direction in it. A guide for the middle of the cell says where to
//! begin, and the search goes on from there, either way, by steps that double. Inside the leaf the
//! two numbers that are left are bent so that their density is the ramp; Hilbert order is kept, since bending is continuous.

use std::sync::{Arc, OnceLock};

use crate::cumulative::BELOW_ONE;
use crate::square::disk_from_square;
use crate::tree::arena::{Arena, Rank};
use crate::tree::batch::ask;
use crate::tree::cache::{self, SliceCache, SliceRef};
use crate::tree::coordinates::{QUANTUM_BITS, turned};
use crate::tree::slice::{Met, Place, area, level_of, walk};
use crate::tree::slopes::{Slope, Slopes, steepness};
use crate::tree::totals::Totals;

/// What a smooth tree has besides its arena.
pub(super) struct Smooth {
    pub slopes: Arc<Slopes>,
    slices: SliceCache<SmoothSlice>,
    totals: OnceLock<Option<Totals<3>>>,
}

impl Smooth {
    pub fn new(slopes: Arc<Slopes>) -> Smooth {
        Smooth { slopes, slices: SliceCache::default(), totals: OnceLock::new() }
    }

    /// The slope of a leaf along the incident axes and along the exitant ones.
    #[inline(always)]
    fn slope(&self, rank: Rank, slot: usize) -> [[f64; 2]; 2] {
        split(rank, self.slopes.of(slot))
    }

    /// The BSDF \[1/sr\] at a place, of whose leaf slot and level are known.
    #[inline(always)]
    pub fn value(&self, value: f32, slot: usize, level: u32, [a, b, c, d]: [u64; 4]) -> f64 {
        let slope = self.slopes.of(slot).map(steepness);
        // Coordinates that the rank does not have are at slope 0.
        let t = [a, b, c, d].map(|c| across(c, level));
        f64::from(value) * (1.0 + (slope[0] * t[0] + slope[1] * t[1]) + (slope[2] * t[2] + slope[3] * t[3]))
    }

    fn totals(&self, arena: &Arena) -> Option<&Totals<3>> {
        let leaf = |slot: usize, value: f64| {
            let [[a, b], _] = self.slope(arena.rank(), slot);
            [value, value * a, value * b]
        };
        self.totals.get_or_init(|| Totals::new(arena, leaf)).as_ref()
    }

    /// Directional-hemispherical total at incident coordinates.
    pub fn total(&self, arena: &Arena, incident: [u64; 2]) -> f64 {
        match self.totals(arena) {
            Some(totals) => at(totals.of(cell(arena, incident)), within(arena, incident)),
            None => self.slice(arena, incident).total(within(arena, incident)),
        }
    }

    /// Asks early for where a slice is.
    pub fn ask(&self, arena: &Arena, incident: [u64; 2]) {
        self.slices.ask(arena, cell(arena, incident));
    }

    /// The slice over the finest incident cell that holds the coordinates.
    pub fn slice(&self, arena: &Arena, incident: [u64; 2]) -> SliceRef<'_, SmoothSlice> {
        let cell = cell(arena, incident);
        self.slices.slice(arena, cell, || SmoothSlice::new(arena, self, cell))
    }

    /// Makes all that samples and totals need; its memory \[byte\].
    pub fn make_tables(&self, arena: &Arena) -> usize {
        let slices = self.slices.fill(arena, |cell| SmoothSlice::new(arena, self, cell));
        slices + self.totals(arena).map_or(0, Totals::n_bytes) + self.slopes.n_bytes()
    }

    /// For light from one direction, given by its coordinates; the azimuth that exitant directions are turned by, if they are.
    pub fn lobe(&self, arena: &Arena, incident: [u64; 2], azimuth: Option<[f64; 2]>) -> SmoothLobe<'_> {
        let slice = self.slice(arena, incident);
        let within = within(arena, incident);
        SmoothLobe { slice, incident, within, total: self.total(arena, incident), azimuth }
    }
}

/// Where incident coordinates lie within the finest cell.
#[inline(always)]
pub(super) fn within(arena: &Arena, incident: [u64; 2]) -> [f64; 2] {
    incident.map(|c| across(c, arena.log2_res()))
}

/// Where a coordinate lies across its cell of a level, from −1 to 1.
#[inline(always)]
fn across(coordinate: u64, level: u32) -> f64 {
    let n = 1u64 << (QUANTUM_BITS - level);
    // 2/n without a division.
    let scale = f64::from_bits((1023 + 1 + u64::from(level) - u64::from(QUANTUM_BITS)) << 52);
    ((coordinate & (n - 1)) as i64 as f64 + 0.5) * scale - 1.0
}

/// The finest incident cell that holds the coordinates.
fn cell(arena: &Arena, incident: [u64; 2]) -> [u32; 2] {
    incident.map(|c| (c >> (QUANTUM_BITS - arena.log2_res())) as u32)
}

/// What grows along two axes, at a place.
#[inline(always)]
fn at([middle, a, b]: [f64; 3], [s, t]: [f64; 2]) -> f64 {
    middle + (s * a + t * b)
}

/// Slopes along the incident axes and along the exitant ones.
#[inline(always)]
fn split(rank: Rank, slope: Slope) -> [[f64; 2]; 2] {
    let [a, b, c, d] = slope.map(steepness);
    match rank {
        Rank::Three => [[a, 0.0], [b, c]],
        Rank::Four => [[a, b], [c, d]],
    }
}

/// A leaf of the slice.
#[derive(Clone, Copy)]
struct Entry {
    /// Along the curve, as that of a constant leaf.
    place: u32,
    /// Mean value \[1/sr\].
    value: f32,
    /// Along the incident axes and along the exitant ones.
    slope: [[f32; 2]; 2],
}

/// The leaves of one incident cell and their cumulative sums.
pub(super) struct SmoothSlice {
    entries: Box<[Entry]>,
    /// Of all entries before, in the middle of the cell, and the growth along its axes; one more than there are entries.
    sums: Box<[[f64; 3]]>,
    /// The last of the sums.
    all: [f64; 3],
    /// `guide[j]`: the entry that holds the j-th of as many equal parts of the total, in the middle of the cell.
    guide: Box<[u32]>,
}

impl cache::Slice for SmoothSlice {
    fn n_bytes(&self) -> usize {
        size_of_val(&*self.entries) + size_of_val(&*self.sums) + size_of_val(&*self.guide)
    }
}

impl SmoothSlice {
    fn new(arena: &Arena, smooth: &Smooth, incident: [u32; 2]) -> SmoothSlice {
        let (mut entries, mut sum) = (Vec::new(), [0.0; 3]);
        let mut sums = vec![sum];
        let half = |cell: u32| u64::from(cell) << (QUANTUM_BITS - arena.log2_res());
        let middle = incident.map(|cell| half(cell) + (half(1) - 1) / 2);
        walk(arena, incident, |Met { slot, value, level, place }| {
            if value > 0.0 {
                let slope = smooth.slope(arena.rank(), slot);
                let finer = 0.5f64.powi((arena.log2_res() - level) as i32);
                let growth = slope[0].map(|slope| slope * finer);
                let t = middle.map(|c| across(c, level));
                let weight = f64::from(value) * area(level);
                sum[0] += weight * (1.0 + (slope[0][0] * t[0] + slope[0][1] * t[1]));
                sum[1] += weight * growth[0];
                sum[2] += weight * growth[1];
                entries.push(Entry { place, value, slope: slope.map(|s| s.map(|s| s as f32)) });
                sums.push(sum);
            }
        });
        SmoothSlice { entries: entries.into(), guide: guide(&sums), sums: sums.into(), all: sum }
    }

    fn total(&self, within: [f64; 2]) -> f64 {
        at(self.all, within).max(0.0)
    }

    pub fn is_black(&self) -> bool {
        self.entries.is_empty()
    }

    /// Where the guide has the entry to begin with for a number; the slice must not be black.
    pub fn guide(&self, u: f64) -> &u32 {
        &self.guide[((u * self.guide.len() as f64) as usize).min(self.guide.len() - 1)]
    }

    /// Asks early for an entry and its sums.
    pub fn ask(&self, entry: u32) {
        ask(self.entries.as_ptr().wrapping_add(entry as usize));
        ask(self.sums.as_ptr().wrapping_add(entry as usize));
    }

    /// The last entry before which there is no more than a target, from one to begin with.
    fn find(&self, begin: usize, target: f64, within: [f64; 2]) -> usize {
        let n = self.entries.len();
        let is_before = |k: usize| at(self.sums[k], within) <= target;
        let (mut low, mut high, mut step) = (begin, begin + 1, 1);
        while low > 0 && !is_before(low) {
            (low, high) = (low.saturating_sub(step), low);
            step *= 2;
        }
        while high < n && is_before(high) {
            (low, high) = (high, (high + step).min(n));
            step *= 2;
        }
        while high - low > 1 {
            let middle = low.midpoint(high);
            if is_before(middle) { low = middle } else { high = middle }
        }
        low
    }

    /// A point of the exitant square and the BSDF there \[1/sr\], for incident coordinates, of which is known too where they lie within
    /// the finest cell, from an entry to begin with. The slice must not be black.
    pub fn sample_from(
        &self,
        begin: u32,
        incident: [u64; 2],
        within: [f64; 2],
        u: f64,
        v: Option<f64>,
    ) -> ([f64; 2], f64) {
        let target = u.clamp(0.0, BELOW_ONE) * self.total(within);
        let before = |k: usize| at(self.sums[k], within);
        let k = self.find(begin as usize, target, within);
        let entry = self.entries[k];
        let weight = before(k + 1) - before(k);
        let rest = if weight > 0.0 { ((target - before(k)) / weight).clamp(0.0, BELOW_ONE) } else { 0.5 };
        let level = level_of(entry.place);
        let [[a, b], exitant] = entry.slope.map(|s| s.map(f64::from));
        let flat = 1.0 + (a * across(incident[0], level) + b * across(incident[1], level));
        let n = (1u64 << level) as f64;
        let point = Place::inside(entry.place, rest, v).point().map(|x| x * n);
        let corner = point.map(f64::floor);
        let t = bent([point[0] - corner[0], point[1] - corner[1]], exitant.map(|slope| slope / flat));
        let value = f64::from(entry.value) * (flat + (exitant[0] * t[0] + exitant[1] * t[1]));
        (std::array::from_fn(|i| (corner[i] + 0.5 + 0.5 * t[i]) / n), value)
    }
}

/// For half as many equal parts of the total as there are entries, the entry that holds the beginning of each.
fn guide(sums: &[[f64; 3]]) -> Box<[u32]> {
    let n = sums.len() / 2;
    let total = sums[sums.len() - 1][0];
    let mut k = 0;
    let part = |j: usize| {
        while k + 2 < sums.len() && sums[k + 1][0] <= total * j as f64 / n as f64 {
            k += 1;
        }
        k as u32
    };
    (0..n).map(part).collect()
}

/// Two numbers in (0, 1) to two in (−1, 1) of density (1 + a·s + b·t)/4, where |a| + |b| ≤ 1.
fn bent([x, y]: [f64; 2], [a, b]: [f64; 2]) -> [f64; 2] {
    let s = ramp(x, a);
    [s, ramp(y, b / (1.0 + a * s))]
}

/// A number in (0, 1) to one in (−1, 1) of density (1 + a·s)/2.
pub(super) fn ramp(x: f64, a: f64) -> f64 {
    let c = 4.0 * x - 2.0 + a;
    (c / (1.0 + (1.0 + a * c).max(0.0).sqrt())).clamp(-1.0, 1.0)
}

/// Where the light from one direction goes.
pub(super) struct SmoothLobe<'a> {
    slice: SliceRef<'a, SmoothSlice>,
    incident: [u64; 2],
    within: [f64; 2],
    total: f64,
    azimuth: Option<[f64; 2]>,
}

impl SmoothLobe<'_> {
    pub fn total(&self) -> f64 {
        self.total
    }

    /// As [`TreeLobe::sample`](super::TreeLobe::sample).
    pub fn sample(&self, u: f64, v: Option<f64>) -> Option<([f64; 2], f64)> {
        if self.slice.is_black() {
            return None;
        }
        let begin = *self.slice.guide(u);
        let (square, value) = self.slice.sample_from(begin, self.incident, self.within, u, v);
        let disk = disk_from_square(square);
        Some((self.azimuth.map_or(disk, |azimuth| turned(disk, azimuth)), value))
    }
}
