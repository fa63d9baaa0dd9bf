//! Light that travels the other way: incident and exitant swapped (Helmholtz).
//!
//! Rank 4: swapping directions is f(i, o) → f(1−o, 1−i) in tree coordinates, a permutation of every node's
//! children, so the reversed tree is again a tree.
//!
//! Rank 3: for a fixed incident direction (sine r of its polar angle) the reversed function is constant on patches of
//! the exitant disk bounded by circles (the tree's d0) and radii: under the Shirley–Chiu map the circle of radius r
//! is a square ring of half-side r, and a leaf cuts it in at most four straight pieces, on each of which azimuth is linear.
//! Those patches are exact, and are sampled as such. (Radiance samples nothing here.)

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use crate::cumulative::Cumulative;
use crate::hilbert::unfold;
use crate::tree::arena::{Arena, Content, Rank, Slot, TreeBuilder};
use crate::tree::coordinates::{QUANTUM_BITS, RANK3_SHIFT, quantized};
use crate::tree::slopes::{Slopes, reversed_child, steepness};
use crate::tree::smooth::ramp;

/// The rank-4 tree with incident and exitant directions swapped.
pub(super) fn reversed(arena: &Arena) -> Arena {
    assert_eq!(arena.rank(), Rank::Four, "only a rank-4 tree reverses to a tree");
    let mut builder = TreeBuilder::new(Rank::Four);
    let root = reversed_slot(arena, arena.root(), &mut builder);
    builder.finish(root)
}

fn reversed_slot(arena: &Arena, slot: Slot, builder: &mut TreeBuilder) -> Slot {
    let Content::Node(node) = slot.content() else { return slot };
    let mut children = [slot; 16];
    for (k, &child) in arena.children(node).iter().enumerate() {
        children[reversed_child(k)] = reversed_slot(arena, child, builder);
    }
    builder.node(&children).expect("a permutation of a legal tree is as deep and as large")
}

/// A patch of the exitant disk on which the reversed function is constant, or grows linearly with radius and azimuth.
#[derive(Clone, Copy, Debug)]
struct Patch {
    value: f32,
    /// Radii.
    radii: [f64; 2],
    /// Azimuth of the incident direction relative to the exitant one plus π.
    psi: [f64; 2],
    /// If the tree is smooth.
    growth: Option<Growth>,
}

/// How much above 1, in units of the value, a smooth patch is: what the radius and what the azimuth add.
#[derive(Clone, Copy, Debug)]
struct Growth {
    /// At the inner and the outer radius.
    radial: [f64; 2],
    /// At both ends in azimuth.
    azimuthal: [f64; 2],
}

impl Patch {
    /// Integral over its projected solid angle.
    fn weight(&self) -> f64 {
        let [r0, r1] = self.radii;
        let area = 0.5 * (r1 * r1 - r0 * r0) * (self.psi[1] - self.psi[0]);
        let mean = self.growth.map_or(1.0, |g| 1.0 + g.mean_radial(self.radii) + mean(g.azimuthal));
        f64::from(self.value) * area * mean
    }

    /// Radius and azimuth for two numbers in (0, 1), and the value there.
    fn sample(&self, [across, along]: [f64; 2]) -> ([f64; 2], f64) {
        let (value, r2) = (f64::from(self.value), self.radii.map(|r| r * r));
        match self.growth {
            None => ([lerp(r2, across).sqrt(), lerp(self.psi, along)], value),
            Some(growth) => {
                let base = 1.0 + growth.mean_radial(self.radii) + mean(growth.azimuthal);
                let steepness = 0.5 * (growth.azimuthal[1] - growth.azimuthal[0]) / base;
                let along = 0.5 + 0.5 * ramp(along, steepness);
                let flat = 1.0 + lerp(growth.azimuthal, along);
                let r = ring_radius(self.radii, growth.radial.map(|g| flat + g), across);
                // Behind the last radius that has a place of its own, all is as there.
                let inside = r.min(1.0 - 2.0 * RANK3_SHIFT) - self.radii[0];
                let radial = lerp(growth.radial, inside / (self.radii[1] - self.radii[0]));
                ([r, lerp(self.psi, along)], value * (flat + radial).max(0.0))
            }
        }
    }
}

impl Growth {
    /// Mean of what the radius adds over the area between radii.
    fn mean_radial(&self, [r0, r1]: [f64; 2]) -> f64 {
        // The middle of the area lies outside that of the radii.
        let middle = 2.0 / 3.0 * (r0 * r0 + r0 * r1 + r1 * r1) / (r0 + r1);
        lerp(self.radial, (middle - r0) / (r1 - r0))
    }
}

fn mean([a, b]: [f64; 2]) -> f64 {
    0.5 * (a + b)
}

fn lerp([a, b]: [f64; 2], t: f64) -> f64 {
    a + (b - a) * t
}

/// The radius below which a part of the light of a ring lies, in which a density per area runs linearly between those at its radii.
fn ring_radius([r0, r1]: [f64; 2], [d0, d1]: [f64; 2], part: f64) -> f64 {
    let slope = (d1 - d0) / (r1 - r0);
    let base = d0 - slope * r0;
    let below = |r: f64| r * r * (0.5 * base + slope * r / 3.0);
    let target = lerp([below(r0), below(r1)], part);
    // Newton's method, kept between radii that are known to be too small and too large.
    let (mut low, mut high, mut r) = (r0, r1, lerp([r0 * r0, r1 * r1], part).sqrt());
    for _ in 0..40 {
        let excess = below(r) - target;
        if excess > 0.0 {
            high = r
        } else {
            low = r
        }
        let next = r - excess / (r * (base + slope * r));
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - r).abs() <= 1e-15 {
            return next;
        }
        r = next;
    }
    r
}

/// The reversed rank-3 tree for incident directions of one polar angle.
#[derive(Debug)]
pub(super) struct Rank3Reverse {
    /// Sine of the incident polar angle.
    sin_theta: f64,
    patches: Vec<Patch>,
    cumulative: Cumulative,
}

impl Rank3Reverse {
    /// Collects the patches for a sine of the incident polar angle in \[0, 1\]; of a smooth tree if there are slopes.
    pub fn new(arena: &Arena, slopes: Option<&Slopes>, sin_theta: f64) -> Rank3Reverse {
        let mut collector = Collector { arena, slopes, ring: Ring::new(sin_theta), patches: Vec::new() };
        collector.collect((arena.root(), 0), 0, [0; 3]);
        let patches = collector.patches;
        let cumulative = Cumulative::new(patches.iter().map(Patch::weight));
        Rank3Reverse { sin_theta, patches, cumulative }
    }

    /// The sine it was made for.
    pub fn sin_theta(&self) -> f64 {
        self.sin_theta
    }

    /// Directional-hemispherical total.
    pub fn total(&self) -> f64 {
        self.cumulative.total()
    }

    /// A point of the exitant disk and the value there, as `Slice::sample`; `opposite_phi` is the azimuth opposite to the
    /// incident direction.
    pub fn sample(&self, opposite_phi: f64, u: f64, v: Option<f64>) -> Option<([f64; 2], f64)> {
        let (index, rest) = self.cumulative.find(u)?;
        let ([r, psi], value) = self.patches[index].sample(unfold(rest, v));
        let phi = opposite_phi - psi;
        Some(([r * phi.cos(), r * phi.sin()], value))
    }
}

/// The square ring that is the circle of one radius.
struct Ring {
    radius: f64,
    /// Where its sides lie on an axis of the square: at (1 − r)/2 and (1 + r)/2, in quanta.
    sides: [u64; 2],
}

impl Ring {
    fn new(radius: f64) -> Ring {
        Ring { radius, sides: [quantized(0.5 - 0.5 * radius), quantized(0.5 + 0.5 * radius)] }
    }

    /// Whether it is so small that it lies in one place.
    fn is_point(&self) -> bool {
        self.sides[0] == self.sides[1]
    }

    /// The pieces of the ring in a cell of the square, given by its lower corner and edge in quanta.
    fn pieces(&self, corner: [u64; 2], edge: u64) -> impl Iterator<Item = Piece> {
        let inside =
            |axis: usize, side: usize| (corner[axis]..corner[axis] + edge).contains(&self.sides[side]);
        let r = self.radius;
        let span = |axis: usize| {
            let [lo, hi] = [corner[axis], corner[axis] + edge]
                .map(|q| 2.0 * q as f64 / (1u64 << QUANTUM_BITS) as f64 - 1.0);
            [(lo / r).clamp(-1.0, 1.0), (hi / r).clamp(-1.0, 1.0)]
        };
        let quanta = |t: f64| (0.5 + 0.5 * r * t) * (1u64 << QUANTUM_BITS) as f64;
        let sides = self.sides.map(|side| side as f64);
        let whole = self.is_point().then(|| inside(0, 0) && inside(1, 0));
        let point = Piece { psi: [0.0, TAU], ends: [[sides[0]; 2]; 2] };
        // Side, the axis it is normal to, the azimuth of its middle, and whether azimuth grows along it.
        [(0, 1, 0.0, true), (1, 1, FRAC_PI_2, false), (0, 0, PI, false), (1, 0, 3.0 * FRAC_PI_2, true)]
            .into_iter()
            .filter(move |&(axis, side, ..)| whole.is_none() && inside(axis, side))
            .map(move |(axis, side, middle, grows)| {
                let [a, b] = span(1 - axis);
                let (along, turned) = if grows { ([a, b], [a, b]) } else { ([b, a], [-b, -a]) };
                let end = |t: f64| match axis {
                    0 => [sides[side], quanta(t)],
                    _ => [quanta(t), sides[side]],
                };
                Piece { psi: turned.map(|t| middle + FRAC_PI_4 * t), ends: along.map(end) }
            })
            .filter(|piece| piece.psi[1] > piece.psi[0])
            .chain((whole == Some(true)).then_some(point))
            .collect::<Vec<_>>()
            .into_iter()
    }
}

/// A straight piece of a ring.
#[derive(Clone, Copy)]
struct Piece {
    /// Azimuths of its ends.
    psi: [f64; 2],
    /// Its ends in the square, in quanta.
    ends: [[f64; 2]; 2],
}

struct Collector<'a> {
    arena: &'a Arena,
    slopes: Option<&'a Slopes>,
    ring: Ring,
    patches: Vec<Patch>,
}

impl Collector<'_> {
    /// Adds the patches of all leaves below a slot, given with its index.
    fn collect(&mut self, (slot, index): (Slot, usize), level: u32, corner: [u64; 3]) {
        let edge = 1u64 << (QUANTUM_BITS - level);
        // Radii: d0 = ½ − shift − ½ r; the half d0 ≥ ½ has r < 0 and vanishes; radii over 1 − 2·shift belong to d0 = 0.
        let radius =
            |d0: u64| (1.0 - 2.0 * RANK3_SHIFT - 2.0 * d0 as f64 / (1u64 << QUANTUM_BITS) as f64).max(0.0);
        let radii = [radius(corner[0] + edge), if corner[0] == 0 { 1.0 } else { radius(corner[0]) }];
        let touches = |axis: usize| {
            let range = corner[1 + axis]..corner[1 + axis] + edge;
            range.start <= self.ring.sides[1] && range.end > self.ring.sides[0]
        };
        if radii[1] <= radii[0] || !touches(0) || !touches(1) {
            return;
        }
        match slot.content() {
            Content::Leaf(value) if value > 0.0 => {
                let slope = self.slopes.map(|slopes| slopes.of(index).map(steepness));
                for Piece { psi, ends } in self.ring.pieces([corner[1], corner[2]], edge) {
                    let growth = slope.map(|slope| growth(slope, corner, edge, radii, ends));
                    self.patches.push(Patch { value, radii, psi, growth });
                }
            }
            Content::Leaf(_) => {}
            Content::Node(node) => {
                let arena = self.arena;
                for (k, &child) in arena.children(node).iter().enumerate() {
                    let half = |i: usize| corner[i] + (k as u64 >> i & 1) * (edge / 2);
                    self.collect((child, arena.slot_of(node, k)), level + 1, [half(0), half(1), half(2)]);
                }
            }
        }
    }
}

/// What the slopes of a leaf, given by its lower corner and edge in quanta, add along its part of the ring.
fn growth(
    [a, b, c, _]: [f64; 4],
    corner: [u64; 3],
    edge: u64,
    radii: [f64; 2],
    ends: [[f64; 2]; 2],
) -> Growth {
    let across = |i: usize, q: f64| 2.0 * (q - corner[i] as f64) / edge as f64 - 1.0;
    let d0 = |r: f64| (0.5 - RANK3_SHIFT - 0.5 * r) * (1u64 << QUANTUM_BITS) as f64;
    Growth {
        radial: radii.map(|r| a * across(0, d0(r))),
        azimuthal: ends.map(|[x, y]| b * across(1, x) + c * across(2, y)),
    }
}
