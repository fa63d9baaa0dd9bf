//! What is reduced: a tree, or a grid as the full tree over its cells.
//!
//! Nodes have numbers from 0, the root, on: level by level, so that children come after their parents and the k-th link of all is to
//! node k. Errors are parts of the whole domain by projected solid angle of both directions. At rank 3 that is by the ring of incident
//! directions, the half that is never read being nothing.

use std::ops::Range;

use super::Norm;
use super::measure::Measures;
use crate::convert::squared_radii;
use crate::tree::{Arena, Content, Rank, Slot, Totals, leaf_area};

/// A node and where it is: its level, and its first coordinate at that level.
#[derive(Clone, Copy)]
struct Place {
    node: u32,
    level: u32,
    layer: u32,
}

impl Place {
    /// The first coordinate of child k.
    fn layer_below(self, k: usize) -> u32 {
        self.layer << 1 | (k as u32 & 1)
    }
}

/// Sums over all of a function.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Whole {
    /// ∫f.
    pub light: f64,
    /// ∫f².
    pub power: f64,
    /// Largest f.
    pub largest: f64,
}

/// A function that is a tree.
pub(super) trait Source {
    fn rank(&self) -> Rank;
    /// Finest level.
    fn log2_res(&self) -> u32;
    fn root(&self) -> Slot;
    /// The children of a node, the first 2^rank of these.
    fn children(&self, node: u32) -> [Slot; 16];
    /// The nodes among them.
    fn nodes_below(&self, node: u32) -> Range<u32>;
    fn whole(&self) -> Whole;
    /// What all nodes would be as leaves; differences are multiplied by a scale.
    fn measures(&self, norm: Norm, scale: f64) -> Measures;
    /// ∫|f − g| and ∫(f − g)², g being this with branches cut off.
    fn lost(&self, reduced: &Arena) -> [f64; 2];
    /// Directional-hemispherical totals of all finest incident cells, the first dimension fastest.
    fn totals(&self) -> Vec<f64>;
    /// What a node of a level gives to those of the incident cells that it stands for, in place of what is in `totals`.
    fn totals_below(&self, node: u32, level: u32, totals: &mut Vec<f64>);
}

/// How much of the domain a cell of a level is, by its first coordinate at that level.
pub(super) struct Weights(Vec<Vec<f64>>);

impl Weights {
    /// For the levels of a tree.
    pub fn new(rank: Rank, log2_res: u32) -> Weights {
        let of_level = |level: u32| match rank {
            Rank::Four => vec![0.5f64.powi(4 * level as i32)],
            Rank::Three => (0..1 << level)
                .map(|layer| {
                    let [inner, outer] = squared_radii(level, layer);
                    (outer - inner) * 0.25f64.powi(level as i32)
                })
                .collect(),
        };
        Weights((0..=log2_res).map(of_level).collect())
    }

    /// Of a cell.
    #[inline(always)]
    pub fn of(&self, level: u32, layer: u32) -> f64 {
        let level = &self.0[level as usize];
        if level.len() == 1 { level[0] } else { level[layer as usize] }
    }
}

/// A tree as it is in memory.
pub(super) struct Nodes<'a> {
    arena: &'a Arena,
    weights: Weights,
}

impl Nodes<'_> {
    /// Of an arena in level order, if more than deviations and totals are wanted.
    pub fn new(arena: &Arena) -> Nodes<'_> {
        Nodes { arena, weights: Weights::new(arena.rank(), arena.log2_res()) }
    }

    fn add(&self, slot: Slot, level: u32, layer: u32, whole: &mut Whole) {
        match slot.content() {
            Content::Leaf(value) => {
                let (value, weight) = (f64::from(value), self.weights.of(level, layer));
                whole.light += weight * value;
                whole.power += weight * value * value;
                whole.largest = whole.largest.max(value);
            }
            Content::Node(node) => {
                for (k, &child) in self.arena.children(node).iter().enumerate() {
                    self.add(child, level + 1, layer << 1 | (k as u32 & 1), whole);
                }
            }
        }
    }

    /// Makes the means of a node and all below.
    fn mean(&self, place: Place, means: &mut [f64]) -> f64 {
        let (mut sum, mut plain) = (0.0, 0.0);
        for (k, child) in self.arena.children(place.node).iter().enumerate() {
            let (level, layer) = (place.level + 1, place.layer_below(k));
            let value = match child.content() {
                Content::Leaf(value) => f64::from(value),
                Content::Node(node) => self.mean(Place { node, level, layer }, means),
            };
            sum += self.weights.of(level, layer) * value;
            plain += value;
        }
        let weight = self.weights.of(place.level, place.layer);
        let mean = if weight > 0.0 { sum / weight } else { plain / self.arena.rank().n_children() as f64 };
        means[place.node as usize] = mean;
        mean
    }

    /// Makes the errors of a node and all below.
    fn errors(&self, place: Place, norm: Norm, scale: f64, measures: &mut Measures) {
        // What a reader gets is the mean as a number of 32 bits.
        let mean = f64::from(measures.means[place.node as usize]);
        let error = self.error(place, &|value| norm.of((value - mean) * scale));
        measures.errors[place.node as usize] = error as f32;
        for (k, child) in self.arena.children(place.node).iter().enumerate() {
            if let Content::Node(node) = child.content() {
                let below = Place { node, level: place.level + 1, layer: place.layer_below(k) };
                self.errors(below, norm, scale, measures);
            }
        }
    }

    /// The sum of a function of all leaves of a node.
    fn error(&self, place: Place, of: &impl Fn(f64) -> f64) -> f64 {
        let mut sum = 0.0;
        for (k, child) in self.arena.children(place.node).iter().enumerate() {
            let (level, layer) = (place.level + 1, place.layer_below(k));
            sum += match child.content() {
                Content::Leaf(value) => self.weights.of(level, layer) * of(f64::from(value)),
                Content::Node(node) => self.error(Place { node, level, layer }, of),
            };
        }
        sum
    }
}

impl Nodes<'_> {
    /// Adds what was lost below two slots, that of this tree at a level and a first coordinate.
    fn add_lost(&self, reduced: &Arena, slots: [Slot; 2], level: u32, layer: u32, sums: &mut [f64; 2]) {
        let errors = match slots.map(Slot::content) {
            [Content::Leaf(f), Content::Leaf(g)] => {
                let weight = self.weights.of(level, layer);
                NORMS.map(|norm| weight * norm.of(f64::from(f) - f64::from(g)))
            }
            [Content::Node(node), Content::Leaf(g)] => {
                let place = Place { node, level, layer };
                NORMS.map(|norm| self.error(place, &|f| norm.of(f - f64::from(g))))
            }
            [Content::Node(node), Content::Node(cut)] => {
                let pairs = self.arena.children(node).iter().zip(reduced.children(cut));
                for (k, (&child, &cut)) in pairs.enumerate() {
                    self.add_lost(reduced, [child, cut], level + 1, layer << 1 | (k as u32 & 1), sums);
                }
                return;
            }
            [Content::Leaf(_), Content::Node(_)] => {
                panic!("a reduced tree is nowhere finer than the whole one")
            }
        };
        sums.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error);
    }
}

impl Nodes<'_> {
    /// Adds what a node of 2^log2 finest cells per axis gives to totals; the first of its own, and how many there are in a row.
    fn add_totals(&self, node: u32, log2: u32, first: usize, side: usize, totals: &mut [f64]) {
        let half = 1usize << (log2 - 1);
        let rank = self.arena.rank();
        for (k, child) in self.arena.children(node).iter().enumerate() {
            let (x, y) = (k & 1, if rank == Rank::Four { k >> 1 & 1 } else { 0 });
            let first = first + half * (y * side + x);
            match child.content() {
                Content::Leaf(value) => {
                    let light = f64::from(value) * leaf_area(self.arena.log2_res() - log2 + 1);
                    for row in 0..if rank == Rank::Four { half } else { 1 } {
                        totals[first + row * side..][..half].iter_mut().for_each(|total| *total += light);
                    }
                }
                Content::Node(child) => self.add_totals(child, log2 - 1, first, side, totals),
            }
        }
    }
}

/// In the order in which both are told.
const NORMS: [Norm; 2] = [Norm::L1, Norm::Rms];

impl Source for Nodes<'_> {
    fn rank(&self) -> Rank {
        self.arena.rank()
    }

    fn log2_res(&self) -> u32 {
        self.arena.log2_res()
    }

    fn root(&self) -> Slot {
        self.arena.root()
    }

    fn children(&self, node: u32) -> [Slot; 16] {
        let mut children = [Slot::leaf(0.0); 16];
        let found = self.arena.children(node);
        children[..found.len()].copy_from_slice(found);
        children
    }

    fn nodes_below(&self, node: u32) -> Range<u32> {
        let mut links = self.arena.children(node).iter().filter_map(|child| match child.content() {
            Content::Node(node) => Some(node),
            Content::Leaf(_) => None,
        });
        let first = links.next();
        first.map_or(0..0, |first| first..first + 1 + links.count() as u32)
    }

    fn whole(&self) -> Whole {
        let mut whole = Whole::default();
        self.add(self.arena.root(), 0, 0, &mut whole);
        whole
    }

    fn measures(&self, norm: Norm, scale: f64) -> Measures {
        let n_nodes = self.arena.n_nodes();
        let is_link = |slot: &&Slot| matches!(slot.content(), Content::Node(_));
        let n_links = |node| self.arena.children(node).iter().filter(is_link).count() as u8;
        let mut measures = Measures::new((0..n_nodes as u32).map(n_links).collect(), n_nodes);
        if let Content::Node(node) = self.arena.root().content() {
            let root = Place { node, level: 0, layer: 0 };
            let mut means = vec![0.0; n_nodes];
            self.mean(root, &mut means);
            measures.means = means.into_iter().map(|mean| mean as f32).collect();
            self.errors(root, norm, scale, &mut measures);
        }
        measures
    }

    fn lost(&self, reduced: &Arena) -> [f64; 2] {
        let mut sums = [0.0; 2];
        self.add_lost(reduced, [self.arena.root(), reduced.root()], 0, 0, &mut sums);
        sums
    }

    fn totals(&self) -> Vec<f64> {
        let n = 1u32 << self.arena.log2_res();
        let ny = if self.arena.rank() == Rank::Four { n } else { 1 };
        let totals = Totals::new(self.arena, |_, v| [v]).expect("a tree that is reduced was looked at");
        (0..ny).flat_map(|y| (0..n).map(move |x| [x, y])).map(|cell| totals.of(cell)[0]).collect()
    }

    fn totals_below(&self, node: u32, level: u32, totals: &mut Vec<f64>) {
        let log2 = self.arena.log2_res() - level;
        let side = 1 << log2;
        totals.clear();
        totals.resize(if self.arena.rank() == Rank::Four { side * side } else { side }, 0.0);
        self.add_totals(node, log2, 0, side, totals);
    }
}
