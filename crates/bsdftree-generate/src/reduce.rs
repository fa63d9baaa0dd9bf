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

use crate::guard::guarded;
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
/// `headroom` is the part of each incident cell's light that did not leave at all.
/// `xyz` turns sums into CIE X, Y, Z where the colour of the result is asked for.
pub fn reduce<S: Spectrum>(
    rank: Rank,
    log2_res: u32,
    rows: &[Row<S>],
    n_samples: u64,
    headroom: &[f64],
    pruned: bool,
    xyz: Option<fn(S) -> [f64; 3]>,
) -> Result<Reduced, TreeError> {
    let omega = std::f64::consts::PI * 0.25f64.powi(log2_res as i32);
    let rows: Vec<_> = rows.par_iter().map(|row| Prefix::new(row, xyz)).collect();
    let reducer = Reducer { rank, log2_res, rows: &rows, n: n_samples as f64, omega, pruned };
    let (region, members) = reducer.root();
    let mut root = reducer.decide(region, &members, 0.0).kept;
    if pruned {
        root = guarded(&reducer, root, headroom);
    }
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
pub(crate) struct Prefix {
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
pub(crate) enum Kept {
    Leaf { value: f64, xyz: [f64; 3] },
    Node(Vec<Kept>),
}

struct Estimate {
    kept: Kept,
    cost: f64,
    /// Σ f² over the finest cells.
    squares: f64,
}

/// What a node of the tree stands for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region {
    pub level: u32,
    /// Incident cells; none in the half of rank 3 that no incident direction has.
    pub first_row: u32,
    pub n_rows: u32,
    first_exit: u64,
    pub n_exit: u64,
}

/// The part of a row that lies in a region: row, first and last+1 of its entries.
pub(crate) type Member = [u32; 3];

pub(crate) struct Reducer<'a> {
    rank: Rank,
    pub log2_res: u32,
    rows: &'a [Prefix],
    pub n: f64,
    pub omega: f64,
    pruned: bool,
}

impl Reducer<'_> {
    /// The whole tree.
    pub fn root(&self) -> (Region, Vec<Member>) {
        let region = Region {
            level: 0,
            first_row: 0,
            n_rows: self.rows.len() as u32,
            first_exit: 0,
            n_exit: 1 << (2 * self.log2_res),
        };
        let rows = self.rows.iter().enumerate().filter(|(_, r)| !r.cells.is_empty());
        (region, rows.map(|(k, r)| [k as u32, 0, r.cells.len() as u32]).collect())
    }

    /// Sums of weights and of their squares per path over a member.
    pub fn sums(&self, [row, from, to]: Member) -> (f64, f64) {
        let prefix = &self.rows[row as usize];
        let range = |sums: &[f64]| (sums[to as usize] - sums[from as usize]) / self.n;
        (range(&prefix.luminance), range(&prefix.squares))
    }

    /// Variance of the mean weight of a member.
    pub fn variance(&self, member: Member) -> f64 {
        let (t, q) = self.sums(member);
        (q - t * t).max(0.0) / self.n
    }

    /// Decides a region: leaf or node. `weight` is the mean weight of the parent's paths.
    fn decide(&self, region: Region, members: &[Member], weight: f64) -> Estimate {
        let size = f64::from(region.n_rows) * region.n_exit as f64;
        if members.is_empty() {
            let one_count = weight / (self.n * self.omega * size);
            let cost = if size > 0.0 { LAMBDA * size * one_count * one_count } else { 0.0 };
            return Estimate { kept: Kept::Leaf { value: 0.0, xyz: [0.0; 3] }, cost, squares: 0.0 };
        }
        let (mut t, mut v, mut xyz) = (0.0, 0.0, [0.0; 3]);
        for &member in members {
            t += self.sums(member).0;
            v += self.variance(member);
            let [row, from, to] = member.map(|k| k as usize);
            let sums = &self.rows[row].xyz;
            if let (Some(b), Some(a)) = (sums.get(to), sums.get(from)) {
                xyz = [0, 1, 2].map(|k| xyz[k] + b[k] - a[k]);
            }
        }
        let scale = 1.0 / (self.omega * size);
        let (value, variance) = (t * scale, v * scale * scale);
        let variance = if value > 0.0 { variance + (variance / value).powi(2) } else { variance };
        let leaf = Kept::Leaf { value, xyz };
        if region.level == self.log2_res {
            return Estimate { kept: leaf, cost: LAMBDA * variance, squares: value * value };
        }
        let split = self.split(region, members);
        let merged = (split.squares - size * value * value).max(0.0) + LAMBDA * size * variance;
        if self.pruned && merged <= split.cost {
            Estimate { kept: leaf, cost: merged, squares: split.squares }
        } else {
            split
        }
    }

    /// A region as a node, whose children are decided.
    fn split(&self, region: Region, members: &[Member]) -> Estimate {
        let (t, q) = members.iter().map(|&m| self.sums(m)).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        let weight = if t > 0.0 { q / t } else { 0.0 };
        let decide = |(region, members): &(Region, Vec<Member>)| self.decide(*region, members, weight);
        let parts = self.parts(region, members);
        let children: Vec<_> = match region.level < 2 {
            true => parts.par_iter().map(decide).collect(),
            false => parts.iter().map(decide).collect(),
        };
        Estimate {
            cost: children.iter().map(|c| c.cost).sum(),
            squares: children.iter().map(|c| c.squares).sum(),
            kept: Kept::Node(children.into_iter().map(|c| c.kept).collect()),
        }
    }

    /// As [`Reducer::split`], the tree alone.
    pub fn split_kept(&self, region: Region, members: &[Member]) -> Kept {
        self.split(region, members).kept
    }

    /// The children of a region in the order of a tree's children, with what lies in each.
    pub fn parts(&self, region: Region, members: &[Member]) -> Vec<(Region, Vec<Member>)> {
        let bits = match self.rank {
            Rank::Three => 1,
            Rank::Four => 2,
        };
        let n_parts = 1u32 << bits;
        let quarter = region.n_exit / 4;
        // At the root of rank 3 all rows lie in the half d0 < ½.
        let unused = self.rank == Rank::Three && region.level == 0;
        let n_rows = if unused { region.n_rows } else { region.n_rows / n_parts };
        let mut parts: Vec<_> = (0..4 * n_parts)
            .map(|k| {
                let (incident, exit) = (k & (n_parts - 1), k >> bits);
                let part = Region {
                    level: region.level + 1,
                    first_row: region.first_row + incident * n_rows,
                    n_rows: if unused && incident == 1 { 0 } else { n_rows },
                    first_exit: region.first_exit + u64::from(exit) * quarter,
                    n_exit: quarter,
                };
                (part, Vec::new())
            })
            .collect();
        for &[row, from, to] in members {
            let incident = (row - region.first_row) / n_rows;
            let cells = &self.rows[row as usize].cells;
            let mut begin = from;
            for exit in 0..4 {
                let border = region.first_exit + u64::from(exit + 1) * quarter;
                let range = &cells[begin as usize..to as usize];
                let end = begin + range.partition_point(|&c| u64::from(c) < border) as u32;
                if end > begin {
                    parts[(incident | exit << bits) as usize].1.push([row, begin, end]);
                }
                begin = end;
            }
        }
        parts
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
