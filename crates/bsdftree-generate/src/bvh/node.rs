//! The 8-wide tree as it lies in memory.
//!
//! Invariant: boxes are padded by [`PADDING`], triangles carry a slack, both larger than everything the f32 arithmetic of
//! the filters can lose. So a filter may let too much pass, never too little, and results do not depend on it.

/// Children of a node, triangles of a leaf.
pub(super) const WIDTH: usize = 8;

/// Added to each side of a box, local units. Error of a slab distance, as a shift of the plane, with u = 2⁻²⁴: rounding
/// of box, origin, direction, its inverse, difference, product and bound on t: at most 11 u; this is 16 u.
pub(super) const PADDING: f32 = 16.0 * U;

/// Half the spacing of f32 above 1.
pub(super) const U: f32 = 1.0 / (1 << 24) as f32;

/// Eight boxes and what is in them.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// `[2·axis]` lower, `[2·axis + 1]` upper planes. Unused children are inside out.
    pub planes: [[f32; WIDTH]; 6],
    pub children: [Child; WIDTH],
}

/// Up to eight triangles.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Leaf {
    /// `[corner][axis][lane]`, local units.
    pub corners: [[[f32; WIDTH]; 3]; 3],
    /// Bound on the error of an edge function, see [`edge_slack`]; negative in unused lanes.
    pub slack: [f32; WIDTH],
    /// See [`Hit::part`](super::Hit::part).
    pub parts: [u32; WIDTH],
    /// Facet of lane 0; the others follow.
    pub first: u32,
}

/// Bound on the error of an edge function of a triangle with this largest extent along an axis.
///
/// With u = 2⁻²⁴: a corner relative to the origin is off by 4 u, the shear multiplies it by a slope of at most 1 that is
/// off by 3 u, so a sheared coordinate is off by 20 u. If the ray meets the triangle, sheared coordinates are at most
/// L = 2 · extent, and x₁y₂ − y₁x₂ is off by at most 4 · 20 u L, and 16 u L for the rounding of the products: 96 u L.
pub(super) fn edge_slack(extent: f32) -> f32 {
    128.0 * U * 2.0 * extent
}

/// A child of a node: its kind in the upper bits, an index below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct Child(pub u32);

/// What a [`Child`] stands for.
pub(crate) enum Target {
    Node(usize),
    Leaf(usize),
    /// First and number of analytic surfaces.
    Analytic(usize, usize),
}

impl Child {
    const LEAF: u32 = 1 << 31;
    const ANALYTIC: u32 = 1 << 30;
    const COUNT_SHIFT: u32 = 27;
    /// Primitives a tree can hold.
    pub const LIMIT: usize = 1 << Self::COUNT_SHIFT;

    pub fn node(index: usize) -> Child {
        Child(index as u32)
    }

    pub fn leaf(index: usize) -> Child {
        Child(Self::LEAF | index as u32)
    }

    pub fn analytic(first: usize, count: usize) -> Child {
        debug_assert!((1..=WIDTH).contains(&count) && first < Self::LIMIT);
        Child(Self::ANALYTIC | (count as u32 - 1) << Self::COUNT_SHIFT | first as u32)
    }

    #[inline(always)]
    pub fn target(self) -> Target {
        if self.0 & Self::LEAF != 0 {
            Target::Leaf((self.0 & !Self::LEAF) as usize)
        } else if self.0 & Self::ANALYTIC != 0 {
            let count = (self.0 >> Self::COUNT_SHIFT & 7) as usize + 1;
            Target::Analytic((self.0 & (Self::LIMIT as u32 - 1)) as usize, count)
        } else {
            Target::Node(self.0 as usize)
        }
    }
}

impl Default for Node {
    fn default() -> Node {
        let mut planes = [[f32::INFINITY; WIDTH]; 6];
        for axis in 0..3 {
            planes[2 * axis + 1] = [f32::NEG_INFINITY; WIDTH];
        }
        Node { planes, children: [Child(0); WIDTH] }
    }
}

impl Default for Leaf {
    fn default() -> Leaf {
        Leaf { corners: [[[0.0; WIDTH]; 3]; 3], slack: [-1.0; WIDTH], parts: [u32::MAX; WIDTH], first: 0 }
    }
}
