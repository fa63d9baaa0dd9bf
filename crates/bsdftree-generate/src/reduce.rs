//! From counted paths to a tree: a branch is kept only where its children differ by more than noise explains.
//!
//! Every node B has an estimate f, the mean of all paths that fall into it, and its variance V. A cell of a kept leaf is wrong by
//! noise, V; a node made a leaf is wrong by the spread of its cells, Q = Σf_c² − |B|f². Noise costs λ times its variance
//! (splitting must pay for the noise it lets in), so the cheapest tree is found bottom-up:
//!
//! C(B) = min( Q + λ|B|V , Σ C(children) ),    λ|B|V for a finest cell.
//!
//! With t and q the sums of weights and of their squares per incident cell and path, exitant cells of area Ω and |B| pairs of cells:
//! f = Σ_i t/(Ω|B|), V = Σ_i max(0, q−t²)/n /(Ω|B|)². Few counts make V too small, or 0 where nothing was counted;
//! one count is added: V + (V/f)², and in an empty node the mean weight of its parent's paths.
//! Leaves are plain means of their paths, so flux over a leaf is kept exactly and estimates are unbiased given the tree.

use bsdftree::color::uv_from_xyz;
use bsdftree::tree::{Rank, Slot, Tree, TreeBuilder, TreeError};
use rayon::prelude::*;

use crate::scatter::Spectrum;
use crate::tally::Row;

/// What a unit of noise costs beside a unit of spread. Measured: flat between 2 and 3, and 1.5 keeps noise as detail.
const LAMBDA: f64 = 2.0;

/// Differences of u′ or v′ that are not kept: about one MacAdam step.
const CHROMA_TOLERANCE: f64 = 0.001;

/// Estimated trees of one component.
pub struct Reduced {
    /// Y, or the one value there is.
    pub luminance: Tree,
    /// u′ and v′.
    pub chroma: Option<[Tree; 2]>,
}

/// Reduces rows of paths, one per incident cell, to trees. `pruned: false` keeps every cell that the paths resolve.
/// `xyz` turns sums into CIE X, Y, Z where the colour of the result is asked for.
pub fn reduce<S: Spectrum>(
    rank: Rank,
    log2_res: u32,
    rows: &[Row<S>],
    n_samples: u64,
    pruned: bool,
    xyz: Option<fn(S) -> [f64; 3]>,
) -> Result<Reduced, TreeError> {
    let omega = std::f64::consts::PI * 0.25f64.powi(log2_res as i32);
    let rows: Vec<_> = rows.par_iter().map(|row| Prefix::new(row, xyz)).collect();
    let reducer = Reducer { rank, log2_res, rows: &rows, n: n_samples as f64, omega, pruned };
    let n_exitant = 1u64 << (2 * log2_res);
    let members: Vec<_> = rows
        .iter()
        .enumerate()
        .filter(|(_, r)| !r.cells.is_empty())
        .map(|(k, r)| [k as u32, 0, r.cells.len() as u32])
        .collect();
    let root = reducer.node(0, rows.len() as f64, 0, n_exitant, &members, 0.0).kept;
    let tree = |f: &dyn Fn(&mut TreeBuilder) -> Result<Slot, TreeError>| {
        let mut builder = TreeBuilder::new(rank);
        let root = f(&mut builder)?;
        Ok::<_, TreeError>(Tree::new(builder.finish(root)))
    };
    let luminance = tree(&|b| luminance_slot(&root, rank, b))?;
    let chroma = match xyz {
        None => None,
        Some(_) => {
            let chroma = Chroma::of(&root);
            Some([tree(&|b| chroma.slot(0, rank, b))?, tree(&|b| chroma.slot(1, rank, b))?])
        }
    };
    Ok(Reduced { luminance, chroma })
}

/// A row as running sums, so that any range of its cells is summed by a subtraction.
struct Prefix {
    cells: Vec<u32>,
    luminance: Vec<f64>,
    squares: Vec<f64>,
    /// X, Y, Z; empty without colour.
    xyz: Vec<[f64; 3]>,
}

impl Prefix {
    fn new<S: Spectrum>(row: &Row<S>, xyz: Option<fn(S) -> [f64; 3]>) -> Prefix {
        let mut prefix = Prefix {
            cells: row.iter().map(|e| e.cell).collect(),
            luminance: vec![0.0],
            squares: vec![0.0],
            xyz: Vec::new(),
        };
        let (mut t, mut q, mut color) = (0.0, 0.0, [0.0; 3]);
        if xyz.is_some() {
            prefix.xyz.push(color);
        }
        for exit in row {
            t += exit.sum.luminance();
            q += exit.squares;
            prefix.luminance.push(t);
            prefix.squares.push(q);
            if let Some(xyz) = xyz {
                let add = xyz(exit.sum);
                color = [0, 1, 2].map(|k| color[k] + add[k]);
                prefix.xyz.push(color);
            }
        }
        prefix
    }
}

/// The tree while it is decided.
enum Kept {
    Leaf { value: f64, xyz: [f64; 3] },
    Node(Vec<Kept>),
}

struct Estimate {
    kept: Kept,
    cost: f64,
    /// Σ f² over the finest cells.
    squares: f64,
}

struct Reducer<'a> {
    rank: Rank,
    log2_res: u32,
    rows: &'a [Prefix],
    n: f64,
    omega: f64,
    pruned: bool,
}

/// The part of a row that lies in a node: row, first and last+1 of its entries.
type Member = [u32; 3];

impl Reducer<'_> {
    /// Decides a node over `n_incident` incident cells and the exitant cells from `first_exit`, `n_exit` of them.
    /// `weight` is the mean weight of the parent's paths.
    fn node(
        &self,
        level: u32,
        n_incident: f64,
        first_exit: u64,
        n_exit: u64,
        members: &[Member],
        weight: f64,
    ) -> Estimate {
        let size = n_incident * n_exit as f64;
        if members.is_empty() {
            let one_count = weight / (self.n * self.omega * size);
            let cost = if size > 0.0 { LAMBDA * size * one_count * one_count } else { 0.0 };
            return Estimate { kept: Kept::Leaf { value: 0.0, xyz: [0.0; 3] }, cost, squares: 0.0 };
        }
        let (mut t, mut q, mut v, mut xyz) = (0.0, 0.0, 0.0, [0.0; 3]);
        for &[row, from, to] in members {
            let prefix = &self.rows[row as usize];
            let range = |sums: &[f64]| (sums[to as usize] - sums[from as usize]) / self.n;
            let (ti, qi) = (range(&prefix.luminance), range(&prefix.squares));
            t += ti;
            q += qi;
            v += (qi - ti * ti).max(0.0) / self.n;
            if let (Some(b), Some(a)) = (prefix.xyz.get(to as usize), prefix.xyz.get(from as usize)) {
                xyz = [0, 1, 2].map(|k| xyz[k] + b[k] - a[k]);
            }
        }
        let scale = 1.0 / (self.omega * size);
        let (value, variance) = (t * scale, v * scale * scale);
        let variance = if value > 0.0 { variance + (variance / value).powi(2) } else { variance };
        let leaf = Kept::Leaf { value, xyz };
        if level == self.log2_res {
            return Estimate { kept: leaf, cost: LAMBDA * variance, squares: value * value };
        }
        let children =
            self.children(level, n_incident, first_exit, n_exit, members, if t > 0.0 { q / t } else { 0.0 });
        let squares = children.iter().map(|c| c.squares).sum::<f64>();
        let split = children.iter().map(|c| c.cost).sum::<f64>();
        let merged = (squares - size * value * value).max(0.0) + LAMBDA * size * variance;
        if self.pruned && merged <= split {
            Estimate { kept: leaf, cost: merged, squares }
        } else {
            Estimate {
                kept: Kept::Node(children.into_iter().map(|c| c.kept).collect()),
                cost: split,
                squares,
            }
        }
    }

    fn children(
        &self,
        level: u32,
        n_incident: f64,
        first_exit: u64,
        n_exit: u64,
        members: &[Member],
        weight: f64,
    ) -> Vec<Estimate> {
        let (incident_bits, below) = match self.rank {
            Rank::Three => (1, self.log2_res - level - 1),
            Rank::Four => (2, 2 * (self.log2_res - level - 1)),
        };
        let n_parts = 1usize << incident_bits;
        let mut parts: Vec<Vec<Member>> = vec![Vec::new(); 4 * n_parts];
        for &[row, from, to] in members {
            let incident = (row >> below) as usize & (n_parts - 1);
            let cells = &self.rows[row as usize].cells;
            let mut begin = from;
            for exit in 0..4 {
                let border = first_exit + (exit + 1) * (n_exit / 4);
                let end = begin
                    + cells[begin as usize..to as usize].partition_point(|&c| u64::from(c) < border) as u32;
                if end > begin {
                    parts[incident | (exit as usize) << incident_bits].push([row, begin, end]);
                }
                begin = end;
            }
        }
        // The half of rank 3 that no incident direction has.
        let unused = |k: usize| self.rank == Rank::Three && level == 0 && k & 1 == 1;
        let n_used = if self.rank == Rank::Three && level == 0 { 1.0 } else { n_parts as f64 };
        let decide = |(k, members): (usize, &Vec<Member>)| {
            let n_incident = if unused(k) { 0.0 } else { n_incident / n_used };
            let first_exit = first_exit + (k >> incident_bits) as u64 * (n_exit / 4);
            self.node(level + 1, n_incident, first_exit, n_exit / 4, members, weight)
        };
        if level < 2 {
            parts.par_iter().enumerate().map(decide).collect()
        } else {
            parts.iter().enumerate().map(decide).collect()
        }
    }
}

fn luminance_slot(kept: &Kept, rank: Rank, builder: &mut TreeBuilder) -> Result<Slot, TreeError> {
    match kept {
        Kept::Leaf { value, .. } => Ok(Slot::leaf(*value as f32)),
        Kept::Node(children) => {
            let mut slots = [Slot::leaf(0.0); 16];
            for (slot, child) in slots.iter_mut().zip(children) {
                *slot = luminance_slot(child, rank, builder)?;
            }
            builder.node_or_leaf(&slots[..rank.n_children()])
        }
    }
}

/// u′ and v′ over the luminance tree, with nodes of one colour made leaves.
enum Chroma {
    Leaf { uv: [f64; 2], xyz: [f64; 3] },
    Node(Vec<Chroma>),
}

impl Chroma {
    fn of(kept: &Kept) -> Chroma {
        match kept {
            Kept::Leaf { xyz, .. } => Chroma::Leaf { uv: uv_from_xyz(*xyz), xyz: *xyz },
            Kept::Node(children) => {
                let children: Vec<_> = children.iter().map(Chroma::of).collect();
                Chroma::merged(&children).unwrap_or(Chroma::Node(children))
            }
        }
    }

    /// One leaf for children that are leaves of nearly the colour of their sum; black ones have any colour.
    fn merged(children: &[Chroma]) -> Option<Chroma> {
        let mut sum = [0.0; 3];
        for child in children {
            let Chroma::Leaf { xyz, .. } = child else { return None };
            sum = [0, 1, 2].map(|k| sum[k] + xyz[k]);
        }
        let mean = uv_from_xyz(sum);
        let near = |child: &Chroma| match child {
            Chroma::Leaf { uv, xyz } => {
                xyz[1] <= 0.0 || (0..2).all(|k| (uv[k] - mean[k]).abs() <= CHROMA_TOLERANCE)
            }
            Chroma::Node(_) => false,
        };
        children.iter().all(near).then_some(Chroma::Leaf { uv: mean, xyz: sum })
    }

    fn slot(&self, k: usize, rank: Rank, builder: &mut TreeBuilder) -> Result<Slot, TreeError> {
        match self {
            Chroma::Leaf { uv, .. } => Ok(Slot::leaf(uv[k] as f32)),
            Chroma::Node(children) => {
                let mut slots = [Slot::leaf(0.0); 16];
                for (slot, child) in slots.iter_mut().zip(children) {
                    *slot = child.slot(k, rank, builder)?;
                }
                builder.node_or_leaf(&slots[..rank.n_children()])
            }
        }
    }
}
