//! What each node of a tree would be as a leaf, and how far a tree is from what it was.

use super::Loss;
use super::source::Source;
use crate::tree::Arena;

/// What nodes would be as leaves.
pub(super) struct Measures {
    /// Mean value \[1/sr\].
    pub means: Vec<f32>,
    /// ∫|f − mean| or ∫(f − mean)² over the node; the whole domain is 1.
    pub errors: Vec<f32>,
    /// Links among the children.
    n_links: Box<[u8]>,
}

impl Measures {
    /// Nothing measured yet, given how many links the first nodes have; those after them have none.
    pub fn new(n_links: Vec<u8>, n_nodes: usize) -> Measures {
        let [means, errors] = [vec![0.0; n_nodes], vec![0.0; n_nodes]];
        Measures { means, errors, n_links: n_links.into() }
    }

    /// The same with other errors.
    pub fn with_errors(&self, errors: Vec<f32>) -> Measures {
        Measures { means: self.means.clone(), errors, n_links: self.n_links.clone() }
    }

    /// How many nodes there are.
    pub fn n_nodes(&self) -> usize {
        self.errors.len()
    }

    /// Links among the children of a node.
    #[inline]
    pub fn n_links(&self, node: usize) -> usize {
        self.n_links.get(node).map_or(0, |&n| usize::from(n))
    }
}

/// The errors of a tree with branches cut off, without those of totals.
pub(super) fn loss(whole: &impl Source, reduced: &Arena) -> Loss {
    let ([l1, squares], all) = (whole.lost(reduced), whole.whole());
    let relative = |error: f64, whole: f64| if whole > 0.0 { error / whole } else { 0.0 };
    Loss { l1: relative(l1, all.light), rms: relative(squares, all.power).sqrt(), ..Loss::default() }
}
