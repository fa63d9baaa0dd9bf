//! The tree in memory: one arena of 32-bit slots, a node is its 2^rank children side by side.
//!
//! A BSDF value is never negative, so the sign bit of a slot tells a leaf (clear: the bits of an `f32`) from an
//! inner node (set: the index of the node that holds its children). A rank-4 node is 16 slots, one cache line;
//! a rank-3 node is half a line. Bit i of a child's number is its half along dimension i, as in the file.
//!
//! An arena may be that of a mapped file, which nobody has looked through: its links may lead anywhere. Single look-ups
//! bound the index and the depth, and give some number or other. Whoever walks over a tree begins at [`Arena::root`], which looks
//! through all slots first, once, and is a black leaf if a link is wrong.

use std::sync::OnceLock;

use bytemuck::{Pod, Zeroable};
use thiserror::Error;

use crate::shared::Shared;
use crate::tree::grid::BadValues;
use crate::tree::level_order;

/// Deepest subdivision: 2^15 cells per axis.
pub const MAX_LOG2_RES: u32 = 15;

/// How many dimensions a tree has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rank {
    /// Isotropic: incident polar angle, exitant direction.
    Three,
    /// Anisotropic: incident direction, exitant direction.
    Four,
}

impl Rank {
    /// 3 or 4.
    pub fn dimensions(self) -> usize {
        match self {
            Rank::Three => 3,
            Rank::Four => 4,
        }
    }

    /// 8 or 16.
    pub fn n_children(self) -> usize {
        1 << self.dimensions()
    }
}

/// One slot: a leaf's value or a link to a node.
#[derive(Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Slot(u32);

/// What a slot holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Content {
    /// A leaf of this value \[1/sr\].
    Leaf(f32),
    /// The index of a node.
    Node(u32),
}

impl Slot {
    const NODE: u32 = 1 << 31;

    /// A leaf of 0.
    pub(crate) const BLACK: Slot = Slot(0);

    /// A link to a node.
    pub(crate) fn link(node: u32) -> Slot {
        Slot(node | Slot::NODE)
    }

    /// Whether it is a leaf of a number that a BSDF may have, or a link.
    pub(super) fn is_legal(self) -> bool {
        self.0 & Self::NODE != 0 || f32::from_bits(self.0).is_finite()
    }

    /// A leaf. Negative zero becomes zero.
    ///
    /// # Panics
    /// If the value is negative or NaN: readers and builders refuse those first.
    pub fn leaf(value: f32) -> Slot {
        assert!(value >= 0.0, "a BSDF value is not negative: {value}");
        Slot((value + 0.0).to_bits())
    }

    /// Whether it is a link, and its other bits.
    #[inline]
    pub(super) fn parts(self) -> (bool, u32) {
        (self.0 & Self::NODE != 0, self.0 & !Self::NODE)
    }

    /// What it holds.
    #[inline]
    pub fn content(self) -> Content {
        if self.0 & Self::NODE == 0 {
            Content::Leaf(f32::from_bits(self.0))
        } else {
            Content::Node(self.0 & !Self::NODE)
        }
    }
}

impl std::fmt::Debug for Slot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.content().fmt(f)
    }
}

/// A cache line of slots.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Line([Slot; 16]);

/// A tree that cannot be built.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TreeError {
    /// Subdivided more than [`MAX_LOG2_RES`] times.
    #[error(
        "the tree is subdivided more than {MAX_LOG2_RES} times; coarsen it to 2^{MAX_LOG2_RES} cells per axis"
    )]
    TooDeep,
    /// More than 2^31 − 1 nodes.
    #[error("the tree has more than 2^31 − 1 nodes")]
    TooLarge,
    /// An array whose axes are not all of one power-of-two length.
    #[error("a grid of {len} values is not 2^N values along each of {dimensions} axes")]
    NotAGrid {
        /// Number of values found.
        len: usize,
        /// Number of axes expected.
        dimensions: usize,
    },
    /// Negative, infinite or huge values, or such that are not numbers.
    #[error("{0}")]
    BadValues(Box<BadValues>),
}

/// The arena of a finished tree. A copy shares the slots.
#[derive(Clone)]
pub struct Arena {
    rank: Rank,
    log2_res: u32,
    n_nodes: u32,
    lines: Shared<Line>,
    top: Slot,
    /// Whether links and values are as they must be; not known yet of a file.
    is_sound: OnceLock<bool>,
}

impl Arena {
    /// The arena of a file: nodes level by level ([`level_order`](mod@super::level_order)), the root first, or a single leaf.
    /// Nothing is looked at but how many there are: `None` if they are too few, or `log2_res` is over [`MAX_LOG2_RES`].
    pub(crate) fn unchecked(
        rank: Rank,
        log2_res: u32,
        n_nodes: u32,
        leaf: f32,
        lines: Shared<Line>,
    ) -> Option<Arena> {
        let n_slots = n_nodes as usize * rank.n_children();
        if lines.len() != n_slots.div_ceil(16) || log2_res > MAX_LOG2_RES || (log2_res == 0) != (n_nodes == 0)
        {
            return None;
        }
        let top = if n_nodes == 0 { Slot(leaf.to_bits()) } else { Slot::link(0) };
        let is_leaf = matches!(top.content(), Content::Leaf(_));
        (top.is_legal() && is_leaf == (n_nodes == 0)).then(|| Arena {
            rank,
            log2_res,
            n_nodes,
            lines,
            top,
            is_sound: OnceLock::new(),
        })
    }

    /// How many dimensions it has.
    #[inline]
    pub fn rank(&self) -> Rank {
        self.rank
    }

    /// Depth of the deepest leaf: it resolves 2^log2_res cells per axis.
    #[inline]
    pub fn log2_res(&self) -> u32 {
        self.log2_res
    }

    /// The whole domain, to walk from: no link below it leads to where another one does. A black leaf if the file it comes from is
    /// damaged ([`Arena::fault`]).
    pub fn root(&self) -> Slot {
        match *self.is_sound.get_or_init(|| self.links_fault().is_none()) {
            true => self.top,
            false => Slot(0),
        }
    }

    /// The whole domain, for a look-up that goes down no further than [`Arena::log2_res`].
    #[inline]
    pub(super) fn top(&self) -> Slot {
        self.top
    }

    /// Whether all values are finite, even those that the root does not lead to.
    pub(crate) fn is_finite(&self) -> bool {
        self.slots().iter().fold(true, |all, slot| all & slot.is_legal()) && self.top.is_legal()
    }

    /// What is wrong with a tree of a file, and at which byte: a link, a value or the checksum. Nothing is, with others.
    pub fn fault(&self) -> Option<(u64, String)> {
        let offset = self.lines.stretch()?.offset() as u64;
        let wrong = self.links_fault().map(|(slot, what)| (offset + 4 * slot as u64, what));
        wrong.or_else(|| {
            (!self.lines.is_as_written()).then(|| (offset, "values other than were written".into()))
        })
    }

    /// The slot at which a link, a value or the number of levels is wrong, and what.
    pub(crate) fn links_fault(&self) -> Option<(usize, String)> {
        let slots = &self.slots()[..self.n_nodes() * self.rank.n_children()];
        level_order::fault(slots, self.rank, self.log2_res)
    }

    /// The same tree with its nodes level by level, the root first, so that the k-th link of all is to node k.
    pub(crate) fn in_level_order(&self) -> Arena {
        let root = self.root();
        let is_ordered =
            root == self.top && (root == Slot::link(0) || self.n_nodes == 0) && self.links_fault().is_none();
        if is_ordered {
            return self.clone();
        }
        let slots = level_order::slots(self);
        let n_nodes = (slots.len() / self.rank.n_children()) as u32;
        let top = if n_nodes == 0 { root } else { Slot::link(0) };
        let mut lines = vec![Line([Slot(0); 16]); slots.len().div_ceil(16)];
        bytemuck::cast_slice_mut::<Line, Slot>(&mut lines)[..slots.len()].copy_from_slice(&slots);
        Arena { n_nodes, lines: lines.into(), top, is_sound: true.into(), ..*self }
    }

    /// The children of a node, 2^rank of them.
    #[inline]
    pub fn children(&self, node: u32) -> &[Slot] {
        let n = self.rank.n_children();
        &self.slots()[node as usize * n..][..n]
    }

    /// One child of a node; of the last one if there is no such node.
    #[inline]
    pub fn child(&self, node: u32, child: usize) -> Slot {
        self.slots()[self.slot_of(node, child)]
    }

    /// Which of the slots is that child.
    #[inline]
    pub(super) fn slot_of(&self, node: u32, child: usize) -> usize {
        let node = node.min(self.n_nodes.wrapping_sub(1));
        (node as usize) << self.rank.dimensions() | child
    }

    /// All slots, node after node.
    #[inline]
    pub fn slots(&self) -> &[Slot] {
        bytemuck::cast_slice(&self.lines)
    }

    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.n_nodes as usize
    }

    /// Number of leaves: each node turns one leaf into 2^rank.
    pub fn n_leaves(&self) -> usize {
        1 + self.n_nodes() * (self.rank.n_children() - 1)
    }

    /// Memory of the arena \[byte\].
    pub fn n_bytes(&self) -> usize {
        std::mem::size_of_val(&*self.lines)
    }
}

/// The leaves of a grid of two cells per axis as children: the number of one is that of its value with the bits in opposite order.
fn leaves(values: &[f32]) -> [Slot; 16] {
    const ORDER: [[usize; 16]; 2] = [
        [0, 4, 2, 6, 1, 5, 3, 7, 0, 0, 0, 0, 0, 0, 0, 0],
        [0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15],
    ];
    let are_legal = values.iter().fold(true, |all, &value| all & (value >= 0.0));
    assert!(are_legal, "a BSDF value is not negative: {values:?}");
    let slot = |k: usize| Slot((values[k] + 0.0).to_bits());
    match values.len() {
        8 => ORDER[0].map(slot),
        n => {
            assert_eq!(n, 16, "a node has 8 or 16 children");
            ORDER[1].map(slot)
        }
    }
}

/// Builds an [`Arena`] from the leaves up: a node's children exist before it does.
pub struct TreeBuilder {
    rank: Rank,
    lines: Vec<Line>,
    /// Depth below each node, itself included.
    depths: Vec<u8>,
}

impl TreeBuilder {
    /// Nothing built yet.
    pub fn new(rank: Rank) -> TreeBuilder {
        TreeBuilder { rank, lines: Vec::new(), depths: Vec::new() }
    }

    /// With room for some nodes.
    pub(crate) fn with_capacity(rank: Rank, n_nodes: usize) -> TreeBuilder {
        let lines = Vec::with_capacity((n_nodes * rank.n_children()).div_ceil(16));
        TreeBuilder { rank, lines, depths: Vec::new() }
    }

    /// A node over 2^rank children, in branch order (bit i of the child's number is dimension i).
    ///
    /// # Panics
    /// If the number of children is not 2^rank.
    pub fn node(&mut self, children: &[Slot]) -> Result<Slot, TreeError> {
        let n = self.rank.n_children();
        assert_eq!(children.len(), n, "a node of rank {} has {n} children", self.rank.dimensions());
        let depth = 1 + children.iter().map(|&c| self.depth(c)).max().unwrap_or(0);
        if depth > MAX_LOG2_RES {
            return Err(TreeError::TooDeep);
        }
        let mut line = [Slot(0); 16];
        line[..n].copy_from_slice(children);
        self.line(&line, depth)
    }

    /// A node over the first 2^rank of some children.
    #[inline]
    fn line(&mut self, children: &[Slot; 16], depth: u32) -> Result<Slot, TreeError> {
        let n_nodes = u32::try_from(self.depths.len()).ok();
        let node = n_nodes.filter(|&k| k < Slot::NODE).ok_or(TreeError::TooLarge)?;
        match (self.rank, node % 2) {
            (Rank::Four, _) => self.lines.push(Line(*children)),
            (Rank::Three, 0) => {
                let mut line = [Slot(0); 16];
                line[..8].copy_from_slice(&children[..8]);
                self.lines.push(Line(line));
            }
            (Rank::Three, _) => {
                let Line(last) = self.lines.last_mut().expect("the first half of it is there");
                last[8..].copy_from_slice(&children[..8]);
            }
        }
        self.depths.push(depth as u8);
        Ok(Slot::link(node))
    }

    /// As [`TreeBuilder::node`], but children that are all leaves of one value become that leaf.
    pub fn node_or_leaf(&mut self, children: &[Slot]) -> Result<Slot, TreeError> {
        let uniform =
            matches!(children[0].content(), Content::Leaf(_)) && children.iter().all(|c| *c == children[0]);
        if uniform { Ok(children[0]) } else { self.node(children) }
    }

    /// A uniform grid of 2^log2 cells per axis, row-major with dimension 0 slowest (the file's grid order).
    ///
    /// # Panics
    /// If the number of values is not 2^(rank·log2).
    pub fn grid(&mut self, values: &[f32], log2: u32) -> Result<Slot, TreeError> {
        let d = self.rank.dimensions();
        assert_eq!(values.len(), 1 << (d * log2 as usize), "a grid has 2^(rank·log2) values");
        if log2 == 1 {
            // Nearly all grids of files.
            return self.line(&leaves(values), 1);
        }
        let mut corner = [0usize; 4];
        self.subgrid(values, log2, log2, &mut corner)
    }

    fn subgrid(
        &mut self,
        values: &[f32],
        log2: u32,
        level: u32,
        corner: &mut [usize; 4],
    ) -> Result<Slot, TreeError> {
        let d = self.rank.dimensions();
        if level == 0 {
            let index = corner[..d].iter().fold(0, |index, &c| index << log2 | c);
            return Ok(Slot::leaf(values[index]));
        }
        let mut children = [Slot(0); 16];
        for (k, child) in children[..1 << d].iter_mut().enumerate() {
            let mut at = *corner;
            (0..d).for_each(|i| at[i] += (k >> i & 1) << (level - 1));
            *child = self.subgrid(values, log2, level - 1, &mut at)?;
        }
        self.node(&children[..1 << d])
    }

    /// Number of nodes built.
    pub(crate) fn n_nodes(&self) -> usize {
        self.depths.len()
    }

    /// Forgets all nodes but the first ones.
    pub(crate) fn truncate(&mut self, n_nodes: usize) {
        self.depths.truncate(n_nodes);
        self.lines.truncate((n_nodes * self.rank.n_children()).div_ceil(16));
    }

    /// Depth below a slot: 0 for a leaf.
    pub fn depth(&self, slot: Slot) -> u32 {
        match slot.content() {
            Content::Leaf(_) => 0,
            Content::Node(node) => u32::from(self.depths[node as usize]),
        }
    }

    /// The arena under `root`.
    pub fn finish(mut self, root: Slot) -> Arena {
        // Room that was never written to costs nothing, a copy would.
        if self.lines.capacity() / 8 > self.lines.len() {
            self.lines.shrink_to_fit();
        }
        let n_nodes = self.depths.len() as u32;
        let (log2_res, lines) = (self.depth(root), self.lines.into());
        Arena { rank: self.rank, log2_res, n_nodes, lines, top: root, is_sound: true.into() }
    }
}
