//! What each node of a tree would cost as a leaf.
//!
//! In: a tree whose nodes stand level by level ([`crate::tree::level_order`]), so that children come after their parents and the k-th
//! link is to node k. Out: for each node its mean and the errors of having that mean everywhere in it, as parts of the whole domain by
//! projected solid angle of both directions. At rank 3 that is by the ring of incident directions, the half that is never read being
//! nothing.

use super::{Loss, Norm};
use crate::convert::squared_radii;
use crate::tree::{Arena, Content, Rank, Slot};

/// What nodes would be as leaves.
pub(super) struct Measures {
    /// Mean value \[1/sr\].
    pub means: Vec<f32>,
    /// ∫|f − mean| or ∫(f − mean)² over the node; the whole domain is 1.
    pub errors: Vec<f32>,
    /// Links among the children.
    pub n_links: Vec<u8>,
}

impl Measures {
    /// Of all nodes.
    pub fn new(arena: &Arena, norm: Norm) -> Measures {
        let mut walk = Walk { arena, norm, weights: Weights::new(arena), means: vec![0.0; arena.n_nodes()] };
        let n_links = (0..arena.n_nodes() as u32)
            .map(|node| {
                arena.children(node).iter().filter(|c| matches!(c.content(), Content::Node(_))).count() as u8
            })
            .collect();
        let mut errors = vec![0.0; arena.n_nodes()];
        if let Content::Node(root) = arena.root().content() {
            walk.mean(root, 0, 0);
            walk.errors(root, 0, 0, &mut errors);
        }
        Measures { means: walk.means.into_iter().map(|m| m as f32).collect(), errors, n_links }
    }
}

/// How much of the domain a cell of a level is, by its first coordinate at that level.
struct Weights(Vec<Vec<f64>>);

impl Weights {
    /// For the levels of a tree.
    pub fn new(arena: &Arena) -> Weights {
        let of_level = |level: u32| match arena.rank() {
            Rank::Four => vec![0.5f64.powi(4 * level as i32)],
            Rank::Three => (0..1 << level)
                .map(|layer| {
                    let [inner, outer] = squared_radii(level, layer);
                    (outer - inner) * 0.25f64.powi(level as i32)
                })
                .collect(),
        };
        Weights((0..=arena.log2_res()).map(of_level).collect())
    }

    /// Of a cell.
    #[inline(always)]
    pub fn of(&self, level: u32, layer: u32) -> f64 {
        let level = &self.0[level as usize];
        if level.len() == 1 { level[0] } else { level[layer as usize] }
    }
}

struct Walk<'a> {
    arena: &'a Arena,
    norm: Norm,
    weights: Weights,
    means: Vec<f64>,
}

impl Walk<'_> {
    /// Makes the means of a node and all below; `layer` is its first coordinate.
    fn mean(&mut self, node: u32, level: u32, layer: u32) -> f64 {
        let arena = self.arena;
        let (mut sum, mut plain) = (0.0, 0.0);
        for (k, child) in arena.children(node).iter().enumerate() {
            let below = layer << 1 | (k as u32 & 1);
            let value = match child.content() {
                Content::Leaf(value) => f64::from(value),
                Content::Node(child) => self.mean(child, level + 1, below),
            };
            sum += self.weights.of(level + 1, below) * value;
            plain += value;
        }
        let weight = self.weights.of(level, layer);
        let mean = if weight > 0.0 { sum / weight } else { plain / arena.rank().n_children() as f64 };
        self.means[node as usize] = mean;
        mean
    }

    fn errors(&self, node: u32, level: u32, layer: u32, errors: &mut [f32]) {
        // What a reader gets is the mean as a number of 32 bits.
        let mean = f64::from(self.means[node as usize] as f32);
        errors[node as usize] = self.error(node, level, layer, mean) as f32;
        for (k, child) in self.arena.children(node).iter().enumerate() {
            if let Content::Node(child) = child.content() {
                self.errors(child, level + 1, layer << 1 | (k as u32 & 1), errors);
            }
        }
    }

    /// The error of one value for all of a node.
    fn error(&self, node: u32, level: u32, layer: u32, mean: f64) -> f64 {
        let children = self.arena.children(node).iter().enumerate();
        children
            .map(|(k, child)| {
                let below = layer << 1 | (k as u32 & 1);
                match child.content() {
                    Content::Leaf(value) => {
                        self.weights.of(level + 1, below) * self.norm.of(f64::from(value) - mean)
                    }
                    Content::Node(child) => self.error(child, level + 1, below, mean),
                }
            })
            .sum()
    }
}

/// Sums over two trees, one of which is the other with branches cut off.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// ∫f.
    pub light: f64,
    /// ∫f².
    pub power: f64,
    /// ∫|f − g|.
    l1: f64,
    /// ∫(f − g)².
    squares: f64,
}

impl Sums {
    /// Over a tree and what is left of it.
    pub fn of(whole: &Arena, reduced: &Arena) -> Sums {
        let (mut sums, arenas) = (Sums::default(), [whole, reduced]);
        sums.add(arenas, &Weights::new(whole), arenas.map(Arena::root), 0, 0);
        sums
    }

    /// Adds the part below two slots.
    fn add(&mut self, arenas: [&Arena; 2], weights: &Weights, slots: [Slot; 2], level: u32, layer: u32) {
        match slots.map(Slot::content) {
            [Content::Leaf(f), Content::Leaf(g)] => {
                let [f, g] = [f, g].map(f64::from);
                let weight = weights.of(level, layer);
                self.light += weight * f;
                self.power += weight * f * f;
                self.l1 += weight * (f - g).abs();
                self.squares += weight * (f - g) * (f - g);
            }
            [Content::Node(node), other] => {
                for (k, &child) in arenas[0].children(node).iter().enumerate() {
                    let cut = match other {
                        Content::Leaf(_) => slots[1],
                        Content::Node(node) => arenas[1].child(node, k),
                    };
                    self.add(arenas, weights, [child, cut], level + 1, layer << 1 | (k as u32 & 1));
                }
            }
            [Content::Leaf(_), Content::Node(_)] => {
                panic!("a reduced tree is nowhere finer than the whole one")
            }
        }
    }

    /// The errors, without those of totals.
    pub fn loss(&self) -> Loss {
        let relative = |error: f64, whole: f64| if whole > 0.0 { error / whole } else { 0.0 };
        Loss {
            l1: relative(self.l1, self.light),
            rms: relative(self.squares, self.power).sqrt(),
            ..Loss::default()
        }
    }
}
