//! Values, totals and samples of a tree for many directions at once.
//!
//! In: directions. Out: for each what a single call gives, to the bit. They go in blocks: first the places of all, by
//! arithmetic without branches that the compiler makes vector instructions, then all leaves, level by level, or all cumulative sums,
//! step by step, so that the memory of one is waited for together with that of the others. With AVX2 a level of the tree is one
//! gather for eight pairs; AVX-512 does the arithmetic for as many.

use crate::direction::Direction;
use crate::square::{disk_from_square, square_from_disk, square_from_polar};
use crate::tree::Tree;
use crate::tree::arena::{Arena, Content, Rank, Slot};
use crate::tree::cache::SliceRef;
use crate::tree::coordinates::{
    QUANTUM_BITS, azimuth, quantized, rank3_coordinate, rank3_turned, sin_theta, turned,
};
use crate::tree::slice::{Place, Slice, area};
use crate::tree::smooth::{self, Smooth};

/// Pairs in a block.
const BLOCK: usize = 32;

/// Coordinates of a block as cells of the tree's own resolution, by dimension.
type Cells = [[u32; BLOCK]; 4];

impl Tree {
    /// [`Tree::eval`] for many pairs, several times as fast.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn eval_many(&self, incident: &[Direction], exitant: &[Direction], values: &mut [f64]) {
        match &self.smooth {
            None => self.look_up::<VALUES>(incident, exitant, values),
            Some(smooth) => {
                assert_lengths(incident, exitant, values);
                smooth.eval_many(self.arena(), incident, exitant, values);
            }
        }
    }

    /// [`Tree::projected_solid_angle`] for many pairs, several times as fast.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn projected_solid_angle_many(
        &self,
        incident: &[Direction],
        exitant: &[Direction],
        angles: &mut [f64],
    ) {
        self.look_up::<ANGLES>(incident, exitant, angles);
    }

    /// [`Tree::eval_many`] as processors with fewer instructions do it, of leaves, not smooth: for measurements, and to compare. With
    /// fewer yet if this processor has not even those.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn eval_many_with(
        &self,
        instructions: Instructions,
        incident: &[Direction],
        exitant: &[Direction],
        values: &mut [f64],
    ) {
        self.look_up_with::<VALUES>(instructions.min(Instructions::best()), incident, exitant, values);
    }

    /// What `WANTED` says of the leaves that hold the pairs.
    fn look_up<const WANTED: bool>(&self, incident: &[Direction], exitant: &[Direction], out: &mut [f64]) {
        self.look_up_with::<WANTED>(Instructions::best(), incident, exitant, out);
    }

    /// The same with instructions that the processor has.
    fn look_up_with<const WANTED: bool>(
        &self,
        instructions: Instructions,
        incident: &[Direction],
        exitant: &[Direction],
        out: &mut [f64],
    ) {
        assert_lengths(incident, exitant, out);
        let arena = self.arena();
        #[cfg(target_arch = "x86_64")]
        if i32::try_from(arena.slots().len()).is_ok() {
            // SAFETY: the processor has them, and all indices of slots fit its gathers.
            unsafe {
                match instructions {
                    Instructions::Avx512 => {
                        return x86::look_up_with_avx512::<WANTED>(arena, incident, exitant, out);
                    }
                    Instructions::Avx2 => {
                        return x86::look_up_with_avx2::<WANTED>(arena, incident, exitant, out);
                    }
                    Instructions::Portable => {}
                }
            }
        }
        let _ = instructions;
        portable::<WANTED>(arena, incident, exitant, out);
    }
}

/// Vector instructions, each with all before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Instructions {
    /// Those that all processors of the kind have.
    Portable,
    /// AVX2 of x86-64.
    Avx2,
    /// Its AVX-512 (F, DQ, VL).
    Avx512,
}

impl Instructions {
    /// The best that this processor has.
    #[inline]
    pub fn best() -> Instructions {
        #[cfg(target_arch = "x86_64")]
        {
            let has_avx2 = std::arch::is_x86_feature_detected!("avx2");
            if has_avx2
                && std::arch::is_x86_feature_detected!("avx512f")
                && std::arch::is_x86_feature_detected!("avx512dq")
                && std::arch::is_x86_feature_detected!("avx512vl")
            {
                return Instructions::Avx512;
            }
            if has_avx2 {
                return Instructions::Avx2;
            }
        }
        Instructions::Portable
    }
}

/// Wanted of a leaf: its value.
const VALUES: bool = true;
/// Wanted of a leaf: the projected solid angle of its exitant side.
const ANGLES: bool = false;

fn assert_lengths(incident: &[Direction], exitant: &[Direction], out: &[f64]) {
    assert_eq!(incident.len(), exitant.len(), "as many exitant as incident directions");
    assert_eq!(incident.len(), out.len(), "a number for each pair of directions");
}

impl Smooth {
    /// Level by level too, but with the slots of the leaves and the places in them.
    fn eval_many(&self, arena: &Arena, incident: &[Direction], exitant: &[Direction], out: &mut [f64]) {
        let mut coordinates = [[0; BLOCK]; 4];
        for_blocks(incident, exitant, out, |incident, exitant, out| {
            quantized_places(arena.rank(), incident, exitant, &mut coordinates);
            let (mut slots, mut levels, mut indices) = ([arena.top(); BLOCK], [0; BLOCK], [0; BLOCK]);
            for level in 0..arena.log2_res() {
                for k in 0..BLOCK {
                    if let Content::Node(node) = slots[k].content() {
                        let bit = |i: usize| (coordinates[i][k] >> (QUANTUM_BITS - 1 - level) & 1) as usize;
                        let child = bit(0) | bit(1) << 1 | bit(2) << 2 | bit(3) << 3;
                        indices[k] = arena.slot_of(node, child);
                        slots[k] = arena.slots()[indices[k]];
                        levels[k] += 1;
                    }
                }
            }
            indices.iter().for_each(|&index| self.slopes.ask(index));
            for k in 0..BLOCK {
                out[k] = match slots[k].content() {
                    Content::Leaf(value) => {
                        self.value(value, indices[k], levels[k], coordinates.map(|c| c[k]))
                    }
                    // Only in a damaged file.
                    Content::Node(_) => 0.0,
                };
            }
        });
    }
}

/// The portable way.
fn portable<const WANTED: bool>(
    arena: &Arena,
    incident: &[Direction],
    exitant: &[Direction],
    out: &mut [f64],
) {
    let mut cells = [[0; BLOCK]; 4];
    for_blocks(incident, exitant, out, |incident, exitant, out| {
        places(arena, incident, exitant, &mut cells);
        let (mut slots, mut levels) = ([arena.top(); BLOCK], [0; BLOCK]);
        for level in (0..arena.log2_res()).rev() {
            for (k, slot) in slots.iter_mut().enumerate() {
                if let Content::Node(node) = slot.content() {
                    let bit = |i: usize| ((cells[i][k] >> level & 1) as usize) << i;
                    *slot = arena.child(node, bit(0) | bit(1) | bit(2) | bit(3));
                    levels[k] += 1;
                }
            }
        }
        for k in 0..BLOCK {
            out[k] = if WANTED == VALUES { leaf(slots[k]) } else { area(levels[k]) };
        }
    });
}

#[inline(always)]
fn leaf(slot: Slot) -> f64 {
    match slot.content() {
        Content::Leaf(value) => f64::from(value),
        // Only in a damaged file.
        Content::Node(_) => 0.0,
    }
}

/// Calls `f` with all blocks; the last one is filled up with its first pair.
#[inline(always)]
fn for_blocks(
    incident: &[Direction],
    exitant: &[Direction],
    values: &mut [f64],
    mut f: impl FnMut(&[Direction; BLOCK], &[Direction; BLOCK], &mut [f64; BLOCK]),
) {
    let (incident, incident_rest) = incident.as_chunks();
    let (exitant, exitant_rest) = exitant.as_chunks();
    let (values, values_rest) = values.as_chunks_mut();
    for ((i, o), v) in incident.iter().zip(exitant).zip(values) {
        f(i, o, v);
    }
    if let (Some(&i), Some(&o)) = (incident_rest.first(), exitant_rest.first()) {
        let (mut last_incident, mut last_exitant, mut last) = ([i; BLOCK], [o; BLOCK], [0.0; BLOCK]);
        last_incident[..incident_rest.len()].copy_from_slice(incident_rest);
        last_exitant[..exitant_rest.len()].copy_from_slice(exitant_rest);
        f(&last_incident, &last_exitant, &mut last);
        values_rest.copy_from_slice(&last[..values_rest.len()]);
    }
}

/// Where the pairs of a block lie.
#[inline(always)]
fn places(arena: &Arena, incident: &[Direction; BLOCK], exitant: &[Direction; BLOCK], cells: &mut Cells) {
    let scale = cell_scale(arena.log2_res());
    for (cells, coordinates) in cells.iter_mut().zip(coordinates(arena.rank(), incident, exitant)) {
        for k in 0..BLOCK {
            cells[k] = cell(coordinates[k], scale);
        }
    }
}

/// Their coordinates, as [`Position::new`](super::Position::new) has them.
#[inline(always)]
fn coordinates(rank: Rank, incident: &[Direction; BLOCK], exitant: &[Direction; BLOCK]) -> [[f64; BLOCK]; 4] {
    let (from, to) = (columns(incident), columns(exitant));
    match rank {
        Rank::Four => {
            let ([a, b], [c, d]) = (squares(from, -1.0), squares(to, 1.0));
            [a, b, c, d]
        }
        Rank::Three => {
            // As `exitant_square`, step by step.
            let [mut x, mut y, mut b, mut c] = [[0.0; BLOCK]; 4];
            for k in 0..BLOCK {
                [x[k], y[k]] = rank3_turned([from[0][k], from[1][k], 0.0], [to[0][k], to[1][k]]);
            }
            for k in 0..BLOCK {
                [b[k], c[k]] = square_from_polar(sin_theta([to[0][k], to[1][k], 0.0]), [x[k], y[k]]);
            }
            [rank3_coordinates(from), b, c, [0.0; BLOCK]]
        }
    }
}

#[inline(always)]
fn quantized_block(
    rank: Rank,
    incident: &[Direction; BLOCK],
    exitant: &[Direction; BLOCK],
    quanta: &mut [[u64; BLOCK]; 4],
) {
    for (quanta, coordinates) in quanta.iter_mut().zip(coordinates(rank, incident, exitant)) {
        for k in 0..BLOCK {
            quanta[k] = quantized(coordinates[k]);
        }
    }
}

/// x and y of a block, each by itself. The compiler makes vector instructions of loops over them, all the way; of one that leaves out
/// every third number it does not make the last round.
#[inline(always)]
fn columns(directions: &[Direction; BLOCK]) -> [[f64; BLOCK]; 2] {
    let [mut x, mut y] = [[0.0; BLOCK]; 2];
    for k in 0..BLOCK {
        [x[k], y[k], _] = directions[k];
    }
    [x, y]
}

/// [`rank3_coordinate`] of a block.
#[inline(always)]
fn rank3_coordinates([x, y]: [[f64; BLOCK]; 2]) -> [f64; BLOCK] {
    let mut d0 = [0.0; BLOCK];
    for k in 0..BLOCK {
        d0[k] = rank3_coordinate([x[k], y[k], 0.0]);
    }
    d0
}

/// Points of the square under ± those of the disk.
#[inline(always)]
fn squares([x, y]: [[f64; BLOCK]; 2], sign: f64) -> [[f64; BLOCK]; 2] {
    let [mut a, mut b] = [[0.0; BLOCK]; 2];
    for k in 0..BLOCK {
        [a[k], b[k]] = square_from_disk([sign * x[k], sign * y[k]]);
    }
    [a, b]
}

/// Cells of a tree in a quantum.
fn cell_scale(log2: u32) -> f64 {
    0.5f64.powi(QUANTUM_BITS as i32 - log2 as i32)
}

/// As [`quantized`](super::coordinates::quantized), and then the cell that holds it.
#[inline(always)]
fn cell(x: f64, scale: f64) -> u32 {
    const QUANTA: f64 = (1u64 << QUANTUM_BITS) as f64;
    let quantum = x * QUANTA + 0.5;
    // Comparisons that NaN fails, each one instruction.
    let quantum = if quantum > 0.0 { quantum } else { 0.0 };
    let quantum = if quantum < QUANTA - 1.0 { quantum } else { QUANTA - 1.0 };
    // SAFETY: it lies in [0, 2^15).
    unsafe { (quantum * scale).to_int_unchecked::<i32>() as u32 }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{BLOCK, Cells, VALUES, for_blocks, places};
    use crate::direction::Direction;
    use crate::tree::arena::{Arena, Rank, Slot};
    use crate::tree::slice::area;

    const LANES: usize = 8;
    const VECTORS: usize = BLOCK / LANES;

    /// A function compiled for some features: a closure has those of the function that it stands in.
    macro_rules! look_up {
        ($name:ident, $features:literal) => {
            /// # Safety
            /// The processor must have these features, the number of slots must fit an `i32`.
            #[target_feature(enable = $features)]
            pub(super) unsafe fn $name<const WANTED: bool>(
                arena: &Arena,
                incident: &[Direction],
                exitant: &[Direction],
                out: &mut [f64],
            ) {
                let mut cells = [[0; BLOCK]; 4];
                for_blocks(incident, exitant, out, |incident, exitant, out| {
                    places(arena, incident, exitant, &mut cells);
                    // SAFETY: as this function's.
                    unsafe {
                        match arena.rank() {
                            Rank::Three => leaves::<3, WANTED>(arena, &cells, out),
                            Rank::Four => leaves::<4, WANTED>(arena, &cells, out),
                        }
                    }
                });
            }
        };
    }

    look_up!(look_up_with_avx2, "avx2");
    look_up!(look_up_with_avx512, "avx512f,avx512dq,avx512vl");

    /// # Safety
    /// As [`look_up_with_avx2`].
    #[target_feature(enable = "avx2")]
    unsafe fn leaves<const RANK: usize, const WANTED: bool>(
        arena: &Arena,
        cells: &Cells,
        out: &mut [f64; BLOCK],
    ) {
        let base = arena.slots().as_ptr().cast::<i32>();
        let one = _mm256_set1_epi32(1);
        let last = _mm256_set1_epi32(i32::MIN | arena.n_nodes().saturating_sub(1) as i32);
        let mut slots = [_mm256_set1_epi32(bytemuck::cast::<Slot, i32>(arena.top())); VECTORS];
        let mut levels = [_mm256_setzero_si256(); VECTORS];
        for level in (0..arena.log2_res()).rev() {
            let all =
                _mm256_or_si256(_mm256_or_si256(slots[0], slots[1]), _mm256_or_si256(slots[2], slots[3]));
            if _mm256_movemask_ps(_mm256_castsi256_ps(all)) == 0 {
                break;
            }
            let shift = _mm_cvtsi32_si128(level as i32);
            for (v, slot) in slots.iter_mut().enumerate() {
                // Nobody may have looked at the links of a file.
                let node = _mm256_min_epu32(*slot, last);
                // The index of a node's child; shifting out the bit that tells a node.
                let mut index = _mm256_slli_epi32::<1>(node);
                index = if RANK == 4 { _mm256_slli_epi32::<3>(index) } else { _mm256_slli_epi32::<2>(index) };
                for dimension in 0..RANK {
                    // SAFETY: a vector within the block.
                    let cell = unsafe { _mm256_loadu_si256(cells[dimension].as_ptr().add(LANES * v).cast()) };
                    let bit = _mm256_and_si256(_mm256_srl_epi32(cell, shift), one);
                    index =
                        _mm256_or_si256(index, _mm256_sll_epi32(bit, _mm_cvtsi32_si128(dimension as i32)));
                }
                // All bits of a node's lane: one less is one more level.
                levels[v] = _mm256_sub_epi32(levels[v], _mm256_srai_epi32::<31>(*slot));
                // SAFETY: lanes of nodes only are read, at slots of the arena, which has some if there is a node.
                *slot = unsafe { _mm256_mask_i32gather_epi32::<4>(*slot, base, index, *slot) };
            }
        }
        if WANTED != VALUES {
            for (v, level) in levels.into_iter().enumerate() {
                let mut lanes = [0u32; LANES];
                // SAFETY: as many numbers as the vector has.
                unsafe { _mm256_storeu_si256(lanes.as_mut_ptr().cast(), level) };
                (0..LANES).for_each(|k| out[LANES * v + k] = area(lanes[k]));
            }
            return;
        }
        for (v, slot) in slots.into_iter().enumerate() {
            // No node is left but in a damaged file: 0 for it.
            let leaf = _mm256_castsi256_ps(_mm256_andnot_si256(_mm256_srai_epi32::<31>(slot), slot));
            let (low, high) = (_mm256_castps256_ps128(leaf), _mm256_extractf128_ps::<1>(leaf));
            // SAFETY: vectors within the block.
            unsafe {
                _mm256_storeu_pd(out.as_mut_ptr().add(LANES * v), _mm256_cvtps_pd(low));
                _mm256_storeu_pd(out.as_mut_ptr().add(LANES * v + 4), _mm256_cvtps_pd(high));
            }
        }
    }
}

impl Tree {
    /// [`Tree::hemispherical`] for many incident directions.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn hemispherical_many(&self, incident: &[Direction], reversed: bool, totals: &mut [f64]) {
        assert_eq!(incident.len(), totals.len(), "a total for each incident direction");
        let sums = if self.is_smooth() { None } else { self.totals() };
        match (self.rank(), reversed, sums) {
            (Rank::Four, true, _) => self.reversed().hemispherical_many(incident, false, totals),
            (_, false, Some(sums)) => {
                for_incident(incident, totals, |incident, totals| {
                    let cells = self.incident_cells(incident);
                    for k in 0..BLOCK {
                        [totals[k]] = sums.of([cells[0][k], cells[1][k]]);
                    }
                });
            }
            _ => {
                let each = incident.iter().zip(totals);
                each.for_each(|(&incident, total)| *total = self.hemispherical(incident, reversed));
            }
        }
    }

    /// [`TreeLobe::sample`](super::TreeLobe::sample) of [`Tree::lobe`] for many incident directions: points of the exitant disk and
    /// values \[1/sr\], which are 0 where the lobe is black.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn sample_many(
        &self,
        incident: &[Direction],
        reversed: bool,
        u: &[f64],
        v: Option<&[f64]>,
        sampled: &mut [([f64; 2], f64)],
    ) {
        assert_eq!(incident.len(), u.len(), "a number for each incident direction");
        assert!(v.is_none_or(|v| v.len() == u.len()), "two numbers for each incident direction");
        assert_eq!(incident.len(), sampled.len(), "a sample for each incident direction");
        match (self.rank(), reversed) {
            (Rank::Four, true) => self.reversed().sample_many(incident, false, u, v, sampled),
            (Rank::Three, true) => {
                for (k, sampled) in sampled.iter_mut().enumerate() {
                    let found = self.lobe(incident[k], true).sample(u[k], v.map(|v| v[k]));
                    *sampled = found.unwrap_or_default();
                }
            }
            _ => match &self.smooth {
                None => self.sample_forward(incident, u, v, sampled),
                Some(smooth) => self.sample_smooth(smooth, incident, u, v, sampled),
            },
        }
    }

    fn sample_forward(
        &self,
        incident: &[Direction],
        u: &[f64],
        v: Option<&[f64]>,
        sampled: &mut [([f64; 2], f64)],
    ) {
        for (index, out) in sampled.chunks_mut(BLOCK).enumerate() {
            let range = index * BLOCK..index * BLOCK + out.len();
            let (incident, u) = (&incident[range.clone()], &u[range.clone()]);
            let v = v.map(|v| &v[range]);
            let mut padded = [incident[0]; BLOCK];
            padded[..incident.len()].copy_from_slice(incident);
            let cells = self.incident_cells(&padded);
            let cell = |k: usize| [cells[0][k], cells[1][k]];
            (0..u.len()).for_each(|k| self.slices.ask(&self.arena, cell(k)));
            let slices: [SliceRef<'_, Slice>; BLOCK] =
                std::array::from_fn(|k| self.slice(cell(k.min(u.len() - 1))));
            slices.iter().for_each(|slice| ask(&raw const **slice));
            let lit = |k: &usize| !slices[*k].is_black();
            (0..u.len()).filter(lit).for_each(|k| ask(slices[k].guide(u[k])));
            let mut begin = [0; BLOCK];
            for k in (0..u.len()).filter(lit) {
                begin[k] = *slices[k].guide(u[k]);
                ask(slices[k].place_of(begin[k]));
            }
            let (mut places, mut values) = (Places::default(), [0.0; BLOCK]);
            for k in (0..u.len()).filter(lit) {
                let (place, value) = slices[k].sample_from(begin[k] as usize, u[k], v.map(|v| v[k]));
                (places.hilbert[k], places.across[k], values[k]) = (place.hilbert, place.across, value);
                [places.within[0][k], places.within[1][k]] = place.within;
            }
            let mut points = disk_points(&places);
            if self.rank() == Rank::Three {
                for (point, incident) in points.iter_mut().zip(&padded) {
                    *point = turned(*point, azimuth(*incident));
                }
            }
            out.iter_mut().zip(points.into_iter().zip(values)).for_each(|(out, sampled)| *out = sampled);
        }
    }

    /// In blocks too, so that the memory of one sample is waited for together with that of the others.
    fn sample_smooth(
        &self,
        smooth: &Smooth,
        incident: &[Direction],
        u: &[f64],
        v: Option<&[f64]>,
        sampled: &mut [([f64; 2], f64)],
    ) {
        let arena = self.arena();
        for (index, out) in sampled.chunks_mut(BLOCK).enumerate() {
            let range = index * BLOCK..index * BLOCK + out.len();
            let (incident, u) = (&incident[range.clone()], &u[range.clone()]);
            let v = v.map(|v| &v[range]);
            let n = out.len();
            let places: [[u64; 2]; BLOCK] =
                std::array::from_fn(|k| self.incident_coordinates(incident[k.min(n - 1)]));
            places.iter().for_each(|&place| smooth.ask(arena, place));
            let slices = places.map(|place| smooth.slice(arena, place));
            slices.iter().for_each(|slice| ask(&raw const **slice));
            let lit = |k: &usize| !slices[*k].is_black();
            (0..n).filter(lit).for_each(|k| ask(slices[k].guide(u[k])));
            (0..n).filter(lit).for_each(|k| slices[k].ask(*slices[k].guide(u[k])));
            let mut points = [([0.5; 2], 0.0); BLOCK];
            for k in (0..n).filter(lit) {
                let within = smooth::within(arena, places[k]);
                let begin = *slices[k].guide(u[k]);
                points[k] = slices[k].sample_from(begin, places[k], within, u[k], v.map(|v| v[k]));
            }
            for (k, (square, value)) in points[..n].iter().enumerate() {
                let disk = disk_from_square(*square);
                let is_turned = self.rank() == Rank::Three;
                out[k] = (if is_turned { turned(disk, azimuth(incident[k])) } else { disk }, *value);
            }
        }
    }

    /// The incident cells of a block at the tree's own resolution.
    fn incident_cells(&self, incident: &[Direction; BLOCK]) -> [[u32; BLOCK]; 2] {
        incident_coordinates(self.rank(), incident, self.is_reversed, self.arena().log2_res())
    }
}

/// Asks for memory that is soon needed.
#[inline(always)]
pub(super) fn ask<T>(place: *const T) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch may name any address; SSE is part of x86-64.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(place.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}

/// Makes a function that calls another, which is always inlined, compiled for the widest vectors that the processor has.
macro_rules! wide {
    ($(#[$doc:meta])* $name:ident calls $inner:ident($($argument:ident: $type:ty),*) -> $result:ty) => {
        $(#[$doc])*
        fn $name($($argument: $type),*) -> $result {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx512f,avx512dq,avx512vl")]
                fn with_avx512($($argument: $type),*) -> $result {
                    $inner($($argument),*)
                }
                #[target_feature(enable = "avx2")]
                fn with_avx2($($argument: $type),*) -> $result {
                    $inner($($argument),*)
                }
                match Instructions::best() {
                    // SAFETY: the processor has it.
                    Instructions::Avx512 => return unsafe { with_avx512($($argument),*) },
                    // SAFETY: the processor has it.
                    Instructions::Avx2 => return unsafe { with_avx2($($argument),*) },
                    Instructions::Portable => {}
                }
            }
            $inner($($argument),*)
        }
    };
}

wide! {
    /// Incident coordinates of a block.
    incident_coordinates calls incident_block(rank: Rank, incident: &[Direction; BLOCK], is_reversed: bool, log2: u32) -> [[u32; BLOCK]; 2]
}

wide! {
    /// Quantised coordinates of a block of pairs.
    quantized_places calls quantized_block(
        rank: Rank,
        incident: &[Direction; BLOCK],
        exitant: &[Direction; BLOCK],
        quanta: &mut [[u64; BLOCK]; 4]
    ) -> ()
}

wide! {
    /// Points of the disk over places of the square.
    disk_points calls disk_block(places: &Places) -> [[f64; 2]; BLOCK]
}

/// [`Place`] of a block, field by field.
#[derive(Default)]
struct Places {
    hilbert: [u64; BLOCK],
    across: [u32; BLOCK],
    within: [[u32; BLOCK]; 2],
}

/// The incident cells of a block at a resolution.
#[inline(always)]
fn incident_block(
    rank: Rank,
    incident: &[Direction; BLOCK],
    is_reversed: bool,
    log2: u32,
) -> [[u32; BLOCK]; 2] {
    let [x, y] = columns(incident);
    let coordinates = match rank {
        Rank::Four => squares([x, y], if is_reversed { 1.0 } else { -1.0 }),
        Rank::Three => [rank3_coordinates([x, y]), [0.0; BLOCK]],
    };
    // All bits of a cell turned over count it from the other end.
    let (scale, flip) = (cell_scale(log2), if is_reversed { (1 << log2) - 1 } else { 0 });
    let mut cells = [[0; BLOCK]; 2];
    for axis in 0..2 {
        for k in 0..BLOCK {
            cells[axis][k] = cell(coordinates[axis][k], scale) ^ flip;
        }
    }
    cells
}

#[inline(always)]
fn disk_block(places: &Places) -> [[f64; 2]; BLOCK] {
    let [mut x, mut y, mut a, mut b] = [[0.0; BLOCK]; 4];
    for k in 0..BLOCK {
        let within = [places.within[0][k], places.within[1][k]];
        let place = Place { hilbert: places.hilbert[k], across: places.across[k], within };
        [x[k], y[k]] = place.point();
    }
    for k in 0..BLOCK {
        [a[k], b[k]] = disk_from_square([x[k], y[k]]);
    }
    std::array::from_fn(|k| [a[k], b[k]])
}

/// Calls `f` with all blocks of incident directions; the last one is filled up with its first.
#[inline(always)]
fn for_incident(
    incident: &[Direction],
    out: &mut [f64],
    mut f: impl FnMut(&[Direction; BLOCK], &mut [f64; BLOCK]),
) {
    for_blocks(incident, incident, out, |incident, _, out| f(incident, out));
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::direction::Side;

    /// A tree with leaves of all levels.
    fn tree(rank: Rank) -> Tree {
        let log2 = 4;
        let d = rank.dimensions() as u32;
        let values: Vec<f32> = (0..1usize << (d * log2))
            .map(|k| {
                if (k.wrapping_mul(0x9E37_79B9) >> 9) % 7 == 0 {
                    (k % 1000) as f32
                } else {
                    (k >> (3 * d)) as f32
                }
            })
            .collect();
        Tree::from_grid(rank, &values).unwrap()
    }

    fn direction([x, y]: [f64; 2], front: bool) -> Direction {
        (if front { Side::Front } else { Side::Back }).direction_from_disk([x, y])
    }

    proptest! {
        #[test]
        fn many_values_are_those_of_single_calls_to_the_bit(
            points in prop::collection::vec((prop::array::uniform4(-1.01..1.01f64), any::<bool>(), any::<bool>()), 0..100),
        ) {
            for (rank, is_smooth) in [(Rank::Three, false), (Rank::Four, false), (Rank::Three, true), (Rank::Four, true)] {
                let tree = if is_smooth { tree(rank).smooth() } else { tree(rank) };
                let incident: Vec<_> = points.iter().map(|&([a, b, ..], front, _)| direction([a, b], front)).collect();
                let exitant: Vec<_> = points.iter().map(|&([.., c, d], _, front)| direction([c, d], front)).collect();
                let single: Vec<f64> = incident.iter().zip(&exitant).map(|(&i, &o)| tree.eval(i, o)).collect();
                let mut many = vec![-1.0; points.len()];
                tree.eval_many(&incident, &exitant, &mut many);
                prop_assert_eq!(&many, &single);
                // Of leaves, not of what is between them.
                let all = [Instructions::Portable, Instructions::Avx2, Instructions::Avx512];
                for instructions in all.into_iter().filter(|_| !is_smooth) {
                    many.fill(-1.0);
                    tree.eval_many_with(instructions, &incident, &exitant, &mut many);
                    prop_assert_eq!(&many, &single);
                }
                let single: Vec<f64> =
                    incident.iter().zip(&exitant).map(|(&i, &o)| tree.projected_solid_angle(i, o)).collect();
                tree.projected_solid_angle_many(&incident, &exitant, &mut many);
                prop_assert_eq!(&many, &single);
                portable::<ANGLES>(tree.arena(), &incident, &exitant, &mut many);
                prop_assert_eq!(&many, &single);
                for reversed in [false, true] {
                    tree.hemispherical_many(&incident, reversed, &mut many);
                    let single = incident.iter().map(|&i| tree.hemispherical(i, reversed));
                    prop_assert_eq!(&many, &single.collect::<Vec<_>>());
                    let u: Vec<f64> = points.iter().map(|([a, b, c, d], ..)| (a + b + 3.0 * c - d).rem_euclid(1.0)).collect();
                    for v in [None, Some(&u[..])] {
                        let mut sampled = vec![([0.0; 2], -1.0); u.len()];
                        tree.sample_many(&incident, reversed, &u, v, &mut sampled);
                        for (k, sampled) in sampled.into_iter().enumerate() {
                            let single = tree.lobe(incident[k], reversed).sample(u[k], v.map(|v| v[k]));
                            prop_assert_eq!(sampled.1, single.map_or(0.0, |s| s.1));
                            prop_assert!(single.is_none_or(|single| single == sampled));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn light_from_a_border_between_cells_is_sampled_as_it_is_evaluated() {
        let tree = tree(Rank::Four);
        let axes = [
            [0.0, 0.0, 1.0],
            [0.6, 0.0, 0.8],
            [-0.6, 0.0, 0.8],
            [0.0, 0.6, 0.8],
            [0.0, -0.8, 0.6],
            [1.0, 0.0, 0.0],
        ];
        for reversed in [false, true] {
            for incident in axes {
                let lobe = tree.lobe(incident, reversed);
                for k in 0..500 {
                    let u = (f64::from(k) + 0.5) / 500.0;
                    let ([x, y], value) = lobe.sample(u, None).unwrap();
                    let exitant = Side::Front.direction_from_disk([x, y]);
                    let [from, to] = if reversed { [exitant, incident] } else { [incident, exitant] };
                    assert_eq!(tree.eval(from, to), value, "{incident:?} {reversed}");
                    let mut many = [([0.0; 2], 0.0)];
                    tree.sample_many(&[incident], reversed, &[u], None, &mut many);
                    assert_eq!(many[0], ([x, y], value));
                }
            }
        }
    }

    #[test]
    fn borders_and_odd_numbers_are_as_in_single_calls() {
        let numbers = [0.0, -0.0, 1.0, -1.0, 0.5, 1e-300, f64::NAN, f64::INFINITY, 0.25, -0.75, 2.0, 1e-13];
        let directions: Vec<Direction> = numbers.iter().flat_map(|&x| numbers.map(|y| [x, y, 0.5])).collect();
        let pairs = directions.iter().flat_map(|&i| directions.iter().map(move |&o| (i, o)));
        let (incident, exitant): (Vec<_>, Vec<_>) = pairs.unzip();
        for tree in [tree(Rank::Three), tree(Rank::Four), Tree::uniform(Rank::Four, 3.0)] {
            let mut many = vec![-1.0; incident.len()];
            tree.eval_many(&incident, &exitant, &mut many);
            for ((&i, &o), value) in incident.iter().zip(&exitant).zip(many) {
                assert_eq!(value, tree.eval(i, o), "{i:?} {o:?}");
            }
        }
    }
}
