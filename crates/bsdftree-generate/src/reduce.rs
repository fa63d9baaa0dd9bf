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

use std::ops::Range;

use bsdftree::color::uv_from_xyz;
use bsdftree::tree::{Rank, Slot, Tree, TreeBuilder, TreeError};
use rayon::prelude::*;

use crate::pyramid::Pyramid;
use crate::scatter::Flux;
use crate::tally::{Exit, Row};

/// What a unit of noise costs beside a unit of spread. Measured: flat between 2 and 3, and 1.5 keeps noise as detail.
pub(crate) const LAMBDA: f64 = 2.0;

/// Differences of u′ or v′ that are not kept: about one MacAdam step.
const CHROMA_TOLERANCE: f64 = 0.001;

/// The trees of one component.
pub(crate) struct Trees {
    /// Y, or the one value there is.
    pub luminance: Tree,
    /// u′ and v′.
    pub chroma: Option<[Tree; 2]>,
}

/// The tree while it is decided.
pub(crate) enum Kept {
    Leaf {
        value: f64,
        xyz: [f32; 3],
        /// What it would be as a node, if that was remembered.
        split: Option<Box<[Kept]>>,
    },
    Node(Vec<Kept>),
}

impl Kept {
    /// The trees of a component; with `color`, leaves hold X, Y, Z.
    pub fn trees(&self, rank: Rank, color: bool) -> Result<Trees, TreeError> {
        let tree = |f: &dyn Fn(&mut TreeBuilder) -> Result<Slot, TreeError>| {
            let mut builder = TreeBuilder::new(rank);
            let root = f(&mut builder)?;
            Ok::<_, TreeError>(Tree::new(builder.finish(root)))
        };
        let luminance = tree(&|b| luminance_slot(self, rank, b))?;
        let chroma = match color {
            false => None,
            true => {
                let chroma = Chroma::of(self);
                Some([tree(&|b| chroma.slot(0, rank, b))?, tree(&|b| chroma.slot(1, rank, b))?])
            }
        };
        Ok(Trees { luminance, chroma })
    }
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
    pub first_exit: u64,
    pub n_exit: u64,
}

impl Region {
    /// Pairs of finest cells.
    pub fn size(&self) -> f64 {
        f64::from(self.n_rows) * self.n_exit as f64
    }

    /// Incident cells.
    pub fn rows(&self) -> Range<usize> {
        self.first_row as usize..(self.first_row + self.n_rows) as usize
    }

    /// Whether another one is a part of it.
    pub fn contains(&self, part: &Region) -> bool {
        let (rows, part_rows) = (self.rows(), part.rows());
        rows.start <= part_rows.start
            && part_rows.end <= rows.end
            && self.first_exit <= part.first_exit
            && part.first_exit + part.n_exit <= self.first_exit + self.n_exit
            && self.n_rows > 0
    }
}

/// The part of a row that lies in a region: row, first and last+1 of its entries.
pub(crate) type Member = [u32; 3];

/// The children of a region in the order of a tree's children, with what lies in each.
pub(crate) struct Parts {
    regions: Vec<Region>,
    members: Vec<Member>,
    /// Where the members of each child end.
    ends: Vec<usize>,
}

impl Parts {
    pub fn iter(&self) -> impl Iterator<Item = (Region, &[Member])> {
        (0..self.regions.len()).map(|k| self.get(k))
    }

    /// Child k.
    pub fn get(&self, k: usize) -> (Region, &[Member]) {
        let begin = k.checked_sub(1).map_or(0, |before| self.ends[before]);
        (self.regions[k], &self.members[begin..self.ends[k]])
    }
}

/// Counted paths of one component, to be made a tree.
pub(crate) struct Reducer<'a, S> {
    pub rank: Rank,
    pub log2_res: u32,
    /// One row per incident cell.
    pub rows: &'a [Row<S>],
    /// Paths per incident cell.
    pub n: f64,
    /// Projected solid angle of a finest exitant cell \[sr\].
    pub omega: f64,
    /// Whether each pair of cells is the mean of itself and of the pair travelled the other way, in the same rows.
    pub symmetric: bool,
    /// Whether cells that differ by noise only become one.
    pub pruned: bool,
    /// From sums to CIE X, Y, Z, where colour is asked for.
    pub xyz: Option<fn(S) -> [f64; 3]>,
    /// What a leaf costs for being there: detail that is worth less is not kept \[1/sr²\].
    pub price: f64,
    /// A part of the BSDF that is not in the rows.
    pub model: Option<&'a Pyramid>,
    /// Whether the tree is of what the rows have more than the model, instead of their sum.
    pub residual: bool,
    /// Whether leaves know what they would be as nodes. What is remembered takes more memory than what was counted.
    pub remembers: bool,
}

/// What is known of a region.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    /// Estimated BSDF \[1/sr\].
    pub value: f64,
    /// Its variance, few counts taken into account.
    pub variance: f64,
}

impl<S: Flux> Reducer<'_, S> {
    /// The cheapest tree.
    pub fn cheapest(&self) -> Kept {
        let (region, members) = self.root();
        self.decide(region, &members, 0.0).kept
    }

    /// The whole tree.
    pub fn root(&self) -> (Region, Vec<Member>) {
        let region = Region {
            level: 0,
            first_row: 0,
            n_rows: self.rows.len() as u32,
            first_exit: 0,
            n_exit: 1 << (2 * self.log2_res),
        };
        let rows = self.rows.iter().enumerate().filter(|(_, r)| !r.is_empty());
        (region, rows.map(|(k, r)| [k as u32, 0, r.len() as u32]).collect())
    }

    /// What was counted in a member.
    pub fn exits(&self, [row, from, to]: Member) -> &[Exit<S>] {
        &self.rows[row as usize][from as usize..to as usize]
    }

    /// Sums of weights and of their squares per path over a member.
    pub fn sums(&self, member: Member) -> (f64, f64) {
        let exits = self.exits(member);
        let (t, q) =
            exits.iter().fold((0.0, 0.0), |(t, q), e| (t + e.sum.luminance(), q + f64::from(e.squares)));
        (t / self.n, q / self.n)
    }

    /// Mean weight of the paths of members.
    pub fn weight(&self, members: &[Member]) -> f64 {
        let (t, q) = members.iter().map(|&m| self.sums(m)).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        if t > 0.0 { q / t } else { 0.0 }
    }

    /// Whether the model may differ within a region.
    fn has_detail(&self, region: &Region) -> bool {
        !self.residual && self.model.is_some_and(|model| region.level < model.log2())
    }

    /// Whether nothing is known of parts of a region.
    pub fn is_whole(&self, region: &Region, members: &[Member]) -> bool {
        region.level == self.log2_res || (members.is_empty() && !self.has_detail(region))
    }

    /// Where a region, or the model's block that holds it, lies in the model: level, incident and exitant block.
    pub fn block(&self, model: &Pyramid, region: &Region) -> (u32, u32, u64) {
        let level = region.level.min(model.log2());
        let bits = 2 * (self.log2_res - level);
        (level, region.first_row >> bits, region.first_exit >> bits)
    }

    /// What the model says of a region, with its variance.
    pub fn modelled(&self, region: &Region) -> Moments {
        let Some(model) = self.model else { return Moments { value: 0.0, variance: 0.0 } };
        let (level, i, o) = self.block(model, region);
        Moments { value: model.mean(level, i, o), variance: model.variance(level, i, o) }
    }

    /// Mean of the squares of the model's cells in a region.
    fn modelled_square(&self, region: &Region) -> f64 {
        let Some(model) = self.model else { return 0.0 };
        let (level, i, o) = self.block(model, region);
        model.mean_square(level, i, o)
    }

    /// Light that the model sends from one incident cell into the exitant cells of a region.
    pub fn modelled_sum(&self, row: u32, region: &Region) -> f64 {
        let Some(model) = self.model else { return 0.0 };
        let (level, _, o) = self.block(model, region);
        let row = row >> (2 * (self.log2_res - model.log2()));
        model.row(level, row, o) * self.omega * region.n_exit as f64
    }

    /// Estimate of a region and its variance; `weight` is the mean weight of the parent's paths.
    pub fn moments(&self, region: &Region, members: &[Member], weight: f64) -> Moments {
        let (counted, modelled) = (self.counted(region, members, weight), self.modelled(region));
        let sign = if self.residual { -1.0 } else { 1.0 };
        Moments {
            value: counted.value + sign * modelled.value,
            variance: counted.variance + modelled.variance,
        }
    }

    /// As [`Reducer::moments`], of the rows alone.
    fn counted(&self, region: &Region, members: &[Member], weight: f64) -> Moments {
        let scale = 1.0 / (self.omega * region.size());
        if members.is_empty() {
            return Moments { value: 0.0, variance: (weight * scale / self.n).powi(2) };
        }
        let (mut t, mut v) = (0.0, 0.0);
        for &member in members {
            let (sum, squares) = self.sums(member);
            t += sum;
            v += (squares - sum * sum).max(0.0) / self.n;
        }
        if self.symmetric && self.is_reversed(region) {
            // Every pair and its reverse are here, so they are no independent estimates.
            v *= 2.0;
        }
        let (value, variance) = (t * scale, v * scale * scale);
        Moments {
            value,
            variance: if value > 0.0 { variance + (variance / value).powi(2) } else { variance },
        }
    }

    /// Whether the region travelled the other way is itself.
    fn is_reversed(&self, region: &Region) -> bool {
        let last_row = self.rows.len() as u64 - 1 - u64::from(region.first_row);
        region.first_exit + region.n_exit - 1 == last_row
    }

    fn leaf(&self, value: f64, region: &Region, members: &[Member]) -> Kept {
        let mut total = [0.0; 3];
        if let Some(xyz) = self.xyz {
            if let Some(model) = self.model {
                let (level, i, o) = self.block(model, region);
                let mut channels = model.channels(level, i, o);
                let flux = S::from_channels(|_| channels.next().unwrap_or(0.0));
                total = xyz(flux).map(|c| c * self.n * self.omega * region.size());
            }
            for exit in members.iter().flat_map(|&m| self.exits(m)) {
                let add = xyz(exit.sum);
                total = [0, 1, 2].map(|k| total[k] + add[k]);
            }
        }
        Kept::Leaf { value, xyz: total.map(|c| c as f32), split: None }
    }

    /// Decides a region: leaf or node.
    fn decide(&self, region: Region, members: &[Member], weight: f64) -> Estimate {
        let size = region.size();
        if size == 0.0 {
            return Estimate { kept: self.leaf(0.0, &region, members), cost: 0.0, squares: 0.0 };
        }
        let Moments { value, variance } = self.moments(&region, members, weight);
        if self.is_whole(&region, members) {
            return Estimate {
                kept: self.leaf(value, &region, members),
                cost: LAMBDA * size * variance + self.price,
                squares: size * value * value,
            };
        }
        if members.is_empty() && self.pruned && self.price > 0.0 && !self.residual {
            // Splitting costs the price of the children at least: most of a smooth model is never looked at more closely.
            let squares = size * self.modelled_square(&region);
            let merged = (squares - size * value * value).max(0.0) + LAMBDA * size * variance + self.price;
            if merged <= self.rank.n_children() as f64 * self.price {
                return Estimate { kept: self.leaf(value, &region, members), cost: merged, squares };
            }
        }
        let split = self.split(region, members);
        let merged = (split.squares - size * value * value).max(0.0) + LAMBDA * size * variance + self.price;
        if self.pruned && merged <= split.cost {
            let mut kept = self.leaf(value, &region, members);
            if let (Kept::Leaf { split: remembered, .. }, Kept::Node(children), true) =
                (&mut kept, split.kept, self.remembers)
            {
                *remembered = Some(children.into_boxed_slice());
            }
            Estimate { kept, cost: merged, squares: split.squares }
        } else {
            split
        }
    }

    /// A region as a node, whose children are decided.
    fn split(&self, region: Region, members: &[Member]) -> Estimate {
        let weight = self.weight(members);
        let children: Vec<_> = if members.is_empty() {
            self.regions(region).map(|part| self.decide(part, &[], weight)).collect()
        } else {
            let parts = self.parts(region, members);
            match region.level < 2 {
                true => {
                    let children = (0..self.rank.n_children()).into_par_iter().map(|k| parts.get(k));
                    children.map(|(region, members)| self.decide(region, members, weight)).collect()
                }
                false => parts.iter().map(|(region, members)| self.decide(region, members, weight)).collect(),
            }
        };
        Estimate {
            cost: children.iter().map(|c| c.cost).sum(),
            squares: children.iter().map(|c| c.squares).sum(),
            kept: Kept::Node(children.into_iter().map(|c| c.kept).collect()),
        }
    }

    /// A leaf as a node, the cheapest that it can be.
    pub fn split_leaf(&self, leaf: &mut Kept, region: Region) {
        let remembered = match leaf {
            Kept::Leaf { split, .. } => split.take(),
            Kept::Node(_) => None,
        };
        *leaf = match remembered {
            Some(children) => Kept::Node(children.into_vec()),
            None => self.split(region, &self.members(&region)).kept,
        };
    }

    /// Rows of a child of a region.
    fn rows_of_part(&self, region: &Region) -> u32 {
        match self.rank {
            // At the root of rank 3 all rows lie in the half d0 < ½.
            Rank::Three if region.level == 0 => region.n_rows,
            Rank::Three => region.n_rows / 2,
            Rank::Four => region.n_rows / 4,
        }
    }

    /// Bits of a child's number that tell its rows.
    fn incident_bits(&self) -> u32 {
        match self.rank {
            Rank::Three => 1,
            Rank::Four => 2,
        }
    }

    /// The children of a region in the order of a tree's children.
    pub fn regions(&self, region: Region) -> impl Iterator<Item = Region> {
        let (bits, n_rows, quarter) = (self.incident_bits(), self.rows_of_part(&region), region.n_exit / 4);
        let half = self.rank == Rank::Three && region.level == 0;
        (0..4u32 << bits).map(move |k| {
            let (incident, exit) = (k & ((1 << bits) - 1), k >> bits);
            Region {
                level: region.level + 1,
                first_row: region.first_row + incident * n_rows,
                n_rows: if half && incident == 1 { 0 } else { n_rows },
                first_exit: region.first_exit + u64::from(exit) * quarter,
                n_exit: quarter,
            }
        })
    }

    /// As [`Reducer::regions`], with what lies in each. `members` are in the order of their rows.
    pub fn parts(&self, region: Region, members: &[Member]) -> Parts {
        let (bits, n_rows, quarter) = (self.incident_bits(), self.rows_of_part(&region), region.n_exit / 4);
        let mut parts = Parts {
            regions: self.regions(region).collect(),
            members: Vec::with_capacity(2 * members.len()),
            ends: Vec::with_capacity(self.rank.n_children()),
        };
        // Where each member goes on, quarter by quarter.
        let mut begins: Vec<u32> = members.iter().map(|[_, from, _]| *from).collect();
        for exit in 0..4 {
            let border = region.first_exit + (exit + 1) * quarter;
            let mut rest = members.iter().zip(&mut begins).peekable();
            for incident in 1..=1 << bits {
                let row_end = region.first_row + incident * n_rows;
                while let Some((&[row, _, to], begin)) = rest.next_if(|(member, _)| member[0] < row_end) {
                    let exits = self.exits([row, *begin, to]);
                    let end = *begin + exits.partition_point(|e| u64::from(e.cell) < border) as u32;
                    if end > *begin {
                        parts.members.push([row, *begin, end]);
                    }
                    *begin = end;
                }
                parts.ends.push(parts.members.len());
            }
        }
        parts
    }

    /// Adds, so many times, the light that a tree gives each incident cell.
    pub fn give(&self, kept: &Kept, region: Region, times: f64, sums: &mut [f64]) {
        match kept {
            Kept::Leaf { value, .. } => {
                let light = times * value * self.omega * region.n_exit as f64;
                sums[region.rows()].iter_mut().for_each(|sum| *sum += light);
            }
            Kept::Node(children) => {
                let children = children.iter().zip(self.regions(region));
                children.for_each(|(child, part)| self.give(child, part, times, sums));
            }
        }
    }

    /// What lies in a region.
    pub fn members(&self, region: &Region) -> Vec<Member> {
        let within = |row: u32| {
            let exits = &self.rows[row as usize];
            let before = |cell: u64| exits.partition_point(|e| u64::from(e.cell) < cell) as u32;
            [row, before(region.first_exit), before(region.first_exit + region.n_exit)]
        };
        let rows = region.first_row..region.first_row + region.n_rows;
        rows.map(within).filter(|[_, from, to]| from < to).collect()
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
            Kept::Leaf { xyz, .. } => {
                let xyz = xyz.map(f64::from);
                Chroma::Leaf { uv: uv_from_xyz(xyz), xyz }
            }
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
