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
        let mirrored = !k & 15;
        children[mirrored >> 2 | (mirrored & 3) << 2] = reversed_slot(arena, child, builder);
    }
    builder.node(&children).expect("a permutation of a legal tree is as deep and as large")
}

/// A patch of the exitant disk on which the reversed function is constant.
#[derive(Clone, Copy, Debug)]
struct Patch {
    value: f32,
    /// Squared radii.
    r2: [f64; 2],
    /// Azimuth of the incident direction relative to the exitant one plus π.
    psi: [f64; 2],
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
    /// Collects the patches for a sine of the incident polar angle in \[0, 1\].
    pub fn new(arena: &Arena, sin_theta: f64) -> Rank3Reverse {
        let mut patches = Vec::new();
        let ring = Ring::new(sin_theta);
        collect(arena, arena.root(), 0, [0; 3], &ring, &mut patches);
        let weight = |p: &Patch| f64::from(p.value) * 0.5 * (p.r2[1] - p.r2[0]) * (p.psi[1] - p.psi[0]);
        let cumulative = Cumulative::new(patches.iter().map(weight));
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
        let patch = &self.patches[index];
        let [across, along] = unfold(rest, v);
        let lerp = |[a, b]: [f64; 2], t: f64| a + (b - a) * t;
        let r = lerp(patch.r2, across).sqrt();
        let phi = opposite_phi - lerp(patch.psi, along);
        Some(([r * phi.cos(), r * phi.sin()], f64::from(patch.value)))
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

    /// The azimuths at which the ring lies in a cell of the square, given by its lower corner and edge in quanta.
    fn azimuths(&self, corner: [u64; 2], edge: u64) -> impl Iterator<Item = [f64; 2]> {
        let inside =
            |axis: usize, side: usize| (corner[axis]..corner[axis] + edge).contains(&self.sides[side]);
        let r = self.radius;
        let span = |axis: usize| {
            let [lo, hi] = [corner[axis], corner[axis] + edge]
                .map(|q| 2.0 * q as f64 / (1u64 << QUANTUM_BITS) as f64 - 1.0);
            [(lo / r).clamp(-1.0, 1.0), (hi / r).clamp(-1.0, 1.0)]
        };
        let whole = self.is_point().then(|| inside(0, 0) && inside(1, 0));
        // Side, the axis it is normal to, the azimuth of its middle, and whether azimuth grows along it.
        [(0, 1, 0.0, true), (1, 1, FRAC_PI_2, false), (0, 0, PI, false), (1, 0, 3.0 * FRAC_PI_2, true)]
            .into_iter()
            .filter(move |&(axis, side, ..)| whole.is_none() && inside(axis, side))
            .map(move |(axis, _, middle, grows)| {
                let [a, b] = span(1 - axis);
                if grows {
                    [middle + FRAC_PI_4 * a, middle + FRAC_PI_4 * b]
                } else {
                    [middle - FRAC_PI_4 * b, middle - FRAC_PI_4 * a]
                }
            })
            .filter(|[a, b]| b > a)
            .chain((whole == Some(true)).then_some([0.0, TAU]))
            .collect::<Vec<_>>()
            .into_iter()
    }
}

fn collect(arena: &Arena, slot: Slot, level: u32, corner: [u64; 3], ring: &Ring, patches: &mut Vec<Patch>) {
    let edge = 1u64 << (QUANTUM_BITS - level);
    // Radii: d0 = ½ − shift − ½ r; the half d0 ≥ ½ has r < 0 and vanishes; radii over 1 − 2·shift belong to d0 = 0.
    let radius =
        |d0: u64| (1.0 - 2.0 * RANK3_SHIFT - 2.0 * d0 as f64 / (1u64 << QUANTUM_BITS) as f64).max(0.0);
    let outer = if corner[0] == 0 { 1.0 } else { radius(corner[0]) };
    let inner = radius(corner[0] + edge);
    let touches = |axis: usize| {
        let range = corner[1 + axis]..corner[1 + axis] + edge;
        range.start <= ring.sides[1] && range.end > ring.sides[0]
    };
    if outer <= inner || !touches(0) || !touches(1) {
        return;
    }
    match slot.content() {
        Content::Leaf(value) => {
            if value > 0.0 {
                let r2 = [inner * inner, outer * outer];
                patches.extend(ring.azimuths([corner[1], corner[2]], edge).map(|psi| Patch {
                    value,
                    r2,
                    psi,
                }));
            }
        }
        Content::Node(node) => {
            for (k, &child) in arena.children(node).iter().enumerate() {
                let half = |i: usize| corner[i] + (k as u64 >> i & 1) * (edge / 2);
                collect(arena, child, level + 1, [half(0), half(1), half(2)], ring, patches);
            }
        }
    }
}
