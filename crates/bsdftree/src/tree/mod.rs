//! Tensor trees: a BSDF over the square-mapped hemispheres, subdivided where it changes.
//!
//! What enters is an [`Arena`] (from a file, a grid, or generation); what leaves are values, samples and totals
//! for pairs of directions. Reversed queries ask for light travelling the other way.

pub mod arena;
pub(crate) mod level_order;
mod coordinates;
mod slice;
mod totals;
mod cache;
mod reverse;
mod lobe;
mod batch;
mod slopes;
mod ramp_totals;
mod smooth;
mod walk;
pub mod grid;

use std::hint::select_unpredictable;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

pub use arena::{Arena, Content, MAX_LOG2_RES, Rank, Slot, TreeBuilder, TreeError};
pub use batch::Instructions;
pub use coordinates::Position;
pub use lobe::TreeLobe;
pub(crate) use slice::area as leaf_area;
pub(crate) use totals::Totals;
pub use walk::Leaf;
pub(crate) use walk::child_cell;

use crate::direction::Direction;
use cache::{SliceCache, SliceRef};
use coordinates::{QUANTUM_BITS, exitant_square, incident_coordinates, quantized};
use reverse::Rank3Reverse;
use slice::Slice;
use slopes::Slopes;
use smooth::Smooth;

/// A BSDF component as a tensor tree of rank 3 or 4. Values are \[1/sr\], without a cosine.
pub struct Tree {
    arena: Arena,
    slices: SliceCache<Slice>,
    totals: OnceLock<Option<Totals<1>>>,
    /// If it answers with ramps.
    smooth: Option<Smooth>,
    /// Rank 4: the tree for light travelling the other way.
    reversed: OnceLock<Box<Tree>>,
    /// Whether it is that of another, whose exitant cells its incident ones are. It matters at their borders only.
    is_reversed: bool,
    /// Rank 3: the reversed slice last used.
    rank3_reverse: Mutex<Option<Arc<Rank3Reverse>>>,
}

impl Tree {
    /// A tree over a finished arena.
    pub fn new(arena: Arena) -> Tree {
        Tree {
            arena,
            slices: SliceCache::default(),
            totals: OnceLock::new(),
            smooth: None,
            reversed: OnceLock::new(),
            is_reversed: false,
            rank3_reverse: Mutex::new(None),
        }
    }

    /// One value everywhere.
    pub fn uniform(rank: Rank, value: f32) -> Tree {
        Tree::new(TreeBuilder::new(rank).finish(Slot::leaf(value)))
    }

    /// The tree with nodes whose children are all one value replaced by that value.
    pub fn merged(&self) -> Tree {
        fn merge(arena: &Arena, slot: Slot, builder: &mut TreeBuilder) -> Slot {
            let Content::Node(node) = slot.content() else { return slot };
            let n = arena.rank().n_children();
            let mut children = [slot; 16];
            for (merged, &child) in children.iter_mut().zip(arena.children(node)) {
                *merged = merge(arena, child, builder);
            }
            builder.node_or_leaf(&children[..n]).expect("merging makes a legal tree smaller")
        }
        let mut builder = TreeBuilder::new(self.rank());
        let root = merge(&self.arena, self.arena.root(), &mut builder);
        Tree::new(builder.finish(root))
    }

    /// The same tree, whose values, samples, densities and totals go up and down inside its leaves as their neighbours suggest, instead
    /// of being constant there. The mean of every leaf is kept. Leaves, areas and what is written to a file stay what they are.
    ///
    /// The total of a direction stays within those of the cells around its own, and 1 % of them.
    pub fn smooth(&self) -> Tree {
        self.smooth_beside(&|_| 0.0)
    }

    /// [`Tree::smooth`] of one of two functions that share the light of each direction: the sum of both totals is kept likewise. `beside` is
    /// the total of the other one.
    pub fn smooth_beside(&self, beside: &dyn Fn(Direction) -> f64) -> Tree {
        self.with_slopes(Arc::new(Slopes::new(&self.arena, beside)))
    }

    fn with_slopes(&self, slopes: Arc<Slopes>) -> Tree {
        let is_reversed = self.is_reversed;
        Tree { smooth: Some(Smooth::new(slopes)), is_reversed, ..Tree::new(self.arena.clone()) }
    }

    /// Whether it answers with ramps in its leaves ([`Tree::smooth`]).
    pub fn is_smooth(&self) -> bool {
        self.smooth.is_some()
    }

    /// The slots themselves.
    pub fn arena(&self) -> &Arena {
        &self.arena
    }

    /// 3 or 4 dimensions.
    pub fn rank(&self) -> Rank {
        self.arena.rank()
    }

    /// The value of the leaf at a place \[1/sr\].
    #[inline]
    pub fn value(&self, position: Position) -> f32 {
        self.leaf_at(position).0
    }

    /// The value \[1/sr\] and the level of the leaf at a place.
    #[inline]
    pub fn leaf_at(&self, position: Position) -> (f32, u32) {
        let (value, _, level) = self.leaf_and_slot_at(position);
        (value, level)
    }

    /// The value \[1/sr\], the slot and the level of the leaf at a place; slot 0 if the leaf is the whole tree.
    #[inline]
    fn leaf_and_slot_at(&self, Position(p): Position) -> (f32, usize, u32) {
        // The upper 16 bits of each coordinate. Of one level's bits a multiplication makes the number of a child, bit i being that of
        // dimension i: the products that are not wanted stay below bit 48, or fall out.
        const KEPT: u32 = QUANTUM_BITS - 16;
        const TOP_BITS: u64 = 0x0001_0001_0001_0001;
        const GATHERED: u64 = 1 << 48 | 1 << 33 | 1 << 18 | 1 << 3;
        let cells = p[0] >> KEPT | p[1] >> KEPT << 16 | p[2] >> KEPT << 32 | p[3] >> KEPT << 48;
        let (mut slot, mut index, mut level) = (self.arena.top(), 0, 0);
        for below in 0..self.arena.log2_res() {
            let bits = cells >> (15 - below) & TOP_BITS;
            // Of a leaf, the child of some node, which is not taken: a jump to the end would be foreseen half of the time.
            let (is_node, node) = slot.parts();
            let child = self.arena.slot_of(node, (bits.wrapping_mul(GATHERED) >> 48) as usize);
            slot = select_unpredictable(is_node, self.arena.slots()[child], slot);
            index = select_unpredictable(is_node, child, index);
            level += u32::from(is_node);
        }
        match slot.content() {
            Content::Leaf(value) => (value, index, level),
            // Only in a damaged file.
            Content::Node(_) => (0.0, 0, level),
        }
    }

    /// The BSDF \[1/sr\] for light from `incident` to `exitant`; which sides they lie on does not matter here.
    pub fn eval(&self, incident: Direction, exitant: Direction) -> f64 {
        let position = Position::new(self.rank(), incident, exitant);
        match &self.smooth {
            None => f64::from(self.value(position)),
            Some(smooth) => {
                let (value, slot, level) = self.leaf_and_slot_at(position);
                smooth.value(value, slot, level, position.0)
            }
        }
    }

    /// Projected solid angle \[sr\] of the exitant side of the leaf that holds a pair of directions.
    pub fn projected_solid_angle(&self, incident: Direction, exitant: Direction) -> f64 {
        slice::area(self.leaf_at(Position::new(self.rank(), incident, exitant)).1)
    }

    /// Smallest and largest projected solid angle \[sr\] of the leaves that an incident direction meets.
    pub fn projected_solid_angle_range(&self, incident: Direction, reversed: bool) -> [f64; 2] {
        let tree = match self.rank() {
            Rank::Four if reversed => self.reversed(),
            // The incident cell of the same polar angle: isotropic resolution is alike both ways.
            _ => self,
        };
        tree.slice(tree.incident_cell(incident)).projected_solid_angle()
    }

    /// Rank 4: a tree of its own for light travelling the other way, incident and exitant swapped.
    pub(crate) fn reversed_copy(&self) -> Tree {
        Tree::new(reverse::reversed(&self.arena))
    }

    /// Rank 4: the tree for light travelling the other way.
    fn reversed(&self) -> &Tree {
        self.reversed.get_or_init(|| {
            let arena = reverse::reversed(&self.arena);
            let slopes = self.smooth.as_ref().map(|s| Arc::new(s.slopes.reversed(&self.arena, &arena)));
            let is_reversed = !self.is_reversed;
            Box::new(Tree { is_reversed, smooth: slopes.map(Smooth::new), ..Tree::new(arena) })
        })
    }

    /// Directional-hemispherical total.
    pub fn hemispherical(&self, incident: Direction, reversed: bool) -> f64 {
        match (self.rank(), reversed) {
            (Rank::Four, true) => self.reversed().hemispherical(incident, false),
            (Rank::Three, true) => self.lobe(incident, true).total(),
            _ => match &self.smooth {
                None => self.total(self.incident_cell(incident)),
                Some(smooth) => smooth.total(&self.arena, self.incident_coordinates(incident)),
            },
        }
    }

    /// The incident cell of a direction at the tree's own resolution.
    fn incident_cell(&self, incident: Direction) -> [u32; 2] {
        let shift = QUANTUM_BITS - self.arena.log2_res();
        self.incident_coordinates(incident).map(|c| (c >> shift) as u32)
    }

    /// Incident coordinates of a direction.
    fn incident_coordinates(&self, incident: Direction) -> [u64; 2] {
        match self.is_reversed {
            false => incident_coordinates(self.rank(), incident),
            true => {
                exitant_square(Rank::Four, incident, incident).map(|c| (1 << QUANTUM_BITS) - 1 - quantized(c))
            }
        }
    }

    /// Makes all that samples and totals need, which is made when it is first needed otherwise; its memory \[byte\]. Those of the
    /// reversed tree are not among it.
    pub fn make_tables(&self) -> usize {
        match &self.smooth {
            None => {
                let slices = self.slices.fill(&self.arena, |cell| Slice::new(&self.arena, cell));
                slices + self.totals().map_or(0, Totals::n_bytes)
            }
            Some(smooth) => smooth.make_tables(&self.arena),
        }
    }

    /// The totals of all incident cells, unless there are too many.
    fn totals(&self) -> Option<&Totals<1>> {
        self.totals.get_or_init(|| Totals::new(&self.arena, |_, value| [value])).as_ref()
    }

    fn total(&self, cell: [u32; 2]) -> f64 {
        match self.totals() {
            Some(totals) => totals.of(cell)[0],
            None => self.slice(cell).total(),
        }
    }

    /// The slice over an incident cell.
    #[inline]
    fn slice(&self, cell: [u32; 2]) -> SliceRef<'_, Slice> {
        self.slices.slice(&self.arena, cell, || Slice::new(&self.arena, cell))
    }

    fn rank3_reverse(&self, sin_theta: f64) -> Arc<Rank3Reverse> {
        let mut last = self.rank3_reverse.lock().unwrap_or_else(PoisonError::into_inner);
        match last.as_ref() {
            Some(slice) if slice.sin_theta() == sin_theta => Arc::clone(slice),
            _ => Arc::clone(last.insert(Arc::new(Rank3Reverse::new(
                &self.arena,
                self.smooth.as_ref().map(|s| &*s.slopes),
                sin_theta,
            )))),
        }
    }
}

impl Clone for Tree {
    fn clone(&self) -> Tree {
        match &self.smooth {
            None => Tree { is_reversed: self.is_reversed, ..Tree::new(self.arena.clone()) },
            Some(smooth) => self.with_slopes(Arc::clone(&smooth.slopes)),
        }
    }
}

impl std::fmt::Debug for Tree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tree")
            .field("rank", &self.rank())
            .field("log2_res", &self.arena.log2_res())
            .field("n_leaves", &self.arena.n_leaves())
            .finish()
    }
}
