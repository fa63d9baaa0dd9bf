//! A device mirrored, turned about its normal, or turned round.
//!
//! In: a BSDF. Out: that of the same device in another position: f′(i, o) = f(M⁻¹i, M⁻¹o). Mirroring, turning round and quarter turns
//! permute the cells of a tree and the patches of a basis, and are exact; rank 3 knows no turn at all. Other turns are
//! resampled by the area that turned cells and patches share with others, cut out exactly: light is kept, peaks get wider by up to
//! a cell. A matrix is exact for multiples of the patches of all its rings.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::grow::Grower;
use super::matrix::{fractions, resampled};
use super::polygon::turned_cell;
use super::rows::from_rows;
use super::{ConvertError, xyz};
use crate::bsdf::{Band, Bsdf, Component, Part, Scattering};
use crate::klems::{Basis, Matrix};
use crate::tree::{Arena, Content, Rank, Slot, Tree, TreeBuilder};

/// Finest resolution at which trees are turned by other than quarters.
const MAX_TURNED_LOG2: u32 = 7;

/// Which coordinate changes its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mirror {
    /// Left and right change places.
    X,
    /// Up and down change places.
    Y,
}

impl Bsdf {
    /// The device mirrored. Exact. Geometry that the file holds is left out.
    pub fn mirrored(&self, mirror: Mirror) -> Bsdf {
        self.moved(|part| part, |function| mirrored(function, mirror))
    }

    /// The device turned round, so that its front faces where its back did: by half a turn about the vertical axis Y. Exact. Geometry
    /// that the file holds is left out.
    pub fn flipped(&self) -> Bsdf {
        let other_side = |part| match part {
            Part::ReflectionFront => Part::ReflectionBack,
            Part::ReflectionBack => Part::ReflectionFront,
            Part::TransmissionFront => Part::TransmissionBack,
            Part::TransmissionBack => Part::TransmissionFront,
        };
        self.moved(other_side, |function| mirrored(function, Mirror::X))
    }

    /// The device turned about its normal by an azimuth \[rad\], counter-clockwise as seen from the room. Geometry that the file holds
    /// is left out. Trees are turned at 2^7 cells per axis at most, unless by quarters.
    ///
    /// # Errors
    /// If the azimuth is not finite.
    pub fn turned(&self, azimuth: f64) -> Result<Bsdf, ConvertError> {
        if !azimuth.is_finite() {
            return Err(ConvertError::Azimuth(azimuth));
        }
        let quarters = azimuth.rem_euclid(TAU) / FRAC_PI_2;
        if (quarters - quarters.round()).abs() < 1e-9 {
            let quarters = quarters.round() as u32 % 4;
            return Ok(self.moved(|part| part, |function| quarter_turned(function, quarters)));
        }
        let mut bsdf = self.mapped(|component| xyz::mapped(component, |f| turned(f, azimuth)))?;
        bsdf.header.geometry = None;
        Ok(bsdf)
    }

    /// A copy with every function replaced, colours too: for permutations only.
    fn moved(&self, part_of: impl Fn(Part) -> Part, f: impl Fn(&Scattering) -> Scattering) -> Bsdf {
        let mut bsdf = Bsdf { header: self.header.clone(), bands: Vec::new() };
        bsdf.header.geometry = None;
        for band in &self.bands {
            let mut made = Band::new(&band.name);
            for (part, component) in band.components() {
                let chroma = component.chroma.as_ref().map(|[a, b]| [f(a), f(b)]);
                made.insert(part_of(part), Component { luminance: f(&component.luminance), chroma });
            }
            bsdf.bands.push(made);
        }
        bsdf
    }
}

/// A tree whose children of every node have changed places: child k of the new one is child `from(k)` of the old.
pub(crate) fn permuted(tree: &Tree, from: &dyn Fn(usize) -> usize) -> Tree {
    fn grow(arena: &Arena, slot: Slot, from: &dyn Fn(usize) -> usize, builder: &mut TreeBuilder) -> Slot {
        let Content::Node(node) = slot.content() else { return slot };
        let n = arena.rank().n_children();
        let mut children = [slot; 16];
        for (k, child) in children[..n].iter_mut().enumerate() {
            *child = grow(arena, arena.child(node, from(k)), from, builder);
        }
        builder.node(&children[..n]).expect("a permutation of a legal tree is as deep and as large")
    }
    let mut builder = TreeBuilder::new(tree.rank());
    let root = grow(tree.arena(), tree.arena().root(), from, &mut builder);
    Tree::new(builder.finish(root))
}

pub(crate) fn mirrored(function: &Scattering, mirror: Mirror) -> Scattering {
    match function {
        Scattering::Tree(tree) => {
            let flipped = match (tree.rank(), mirror) {
                (Rank::Four, Mirror::X) => 0b0101,
                (Rank::Four, Mirror::Y) => 0b1010,
                // Relative azimuths change their sign in both.
                (Rank::Three, _) => 0b100,
            };
            permuted(tree, &|k| k ^ flipped).into()
        }
        Scattering::Matrix(matrix) => {
            // Patches are centred on multiples of their width, so azimuths that change their sign are patches again.
            let upside_down = |basis: &Basis| -> Vec<Vec<(usize, f64)>> {
                let middle = |k: usize| basis.disk_point(k, 0.5, 0.5);
                let opposite =
                    |[x, y]: [f64; 2]| basis.patch([x, -y, 0.0_f64.max(1.0 - x * x - y * y).sqrt()]);
                (0..basis.n_patches()).map(|k| vec![(opposite(middle(k)), 1.0)]).collect()
            };
            let made = remixed(matrix, upside_down);
            match mirror {
                Mirror::Y => made.into(),
                Mirror::X => remixed(&made, |basis| fractions(basis, basis, PI)).into(),
            }
        }
    }
}

/// A matrix over patches that are mixtures of those it has.
fn remixed(matrix: &Matrix, mixtures: impl Fn(&Basis) -> Vec<Vec<(usize, f64)>>) -> Matrix {
    let (incident, exitant) = (matrix.incident(), matrix.exitant());
    let values = resampled(matrix, &mixtures(incident), &mixtures(exitant));
    let values = values.into_iter().map(|v| v as f32).collect();
    Matrix::new(incident.clone(), exitant.clone(), values).expect("mixtures of values that are right")
}

pub(crate) fn quarter_turned(function: &Scattering, quarters: u32) -> Scattering {
    match function {
        Scattering::Tree(tree) if tree.rank() == Rank::Three => function.clone(),
        Scattering::Tree(tree) => {
            // A quarter turn takes (x, y) of the square to (1 − y, x): what is there came from (y, 1 − x).
            let back = |k: usize| (k >> 1 & 0b0101) | (!k & 0b0101) << 1;
            permuted(tree, &|k| (0..quarters).fold(k, |k, _| back(k))).into()
        }
        Scattering::Matrix(matrix) => {
            remixed(matrix, |basis| fractions(basis, basis, f64::from(quarters) * FRAC_PI_2)).into()
        }
    }
}

fn turned(function: &Scattering, azimuth: f64) -> Result<Scattering, ConvertError> {
    let tree = match function {
        Scattering::Matrix(matrix) => {
            return Ok(remixed(matrix, |basis| fractions(basis, basis, azimuth)).into());
        }
        Scattering::Tree(tree) if tree.rank() == Rank::Three => return Ok(function.clone()),
        Scattering::Tree(tree) => tree,
    };
    let level = tree.arena().log2_res().min(MAX_TURNED_LOG2);
    let n = 1usize << level;
    // For each cell, the cells that it covers when it is turned back.
    let covered: Vec<Vec<(usize, f64)>> = (0..n * n)
        .map(|cell| {
            let mut found = Vec::new();
            for polygon in turned_cell(level, [(cell / n) as u32, (cell % n) as u32], -azimuth) {
                polygon.each_cell(level, |[x, y], share| found.push((x as usize * n + y as usize, share)));
            }
            let sum: f64 = found.iter().map(|&(_, share)| share).sum();
            found.iter_mut().for_each(|(_, share)| *share /= sum);
            found
        })
        .collect();
    let mean: f64 = tree.leaves().map(|leaf| f64::from(leaf.value) * 0.0625f64.powi(leaf.level as i32)).sum();
    let mut grower = Grower::new(Rank::Four, 0.0, mean);
    let mut row = vec![0.0; n * n];
    let root = from_rows(level, &mut grower, &mut |[x, y]| {
        row.fill(0.0);
        for &(cell, share) in &covered[x as usize * n + y as usize] {
            add_row(tree, level, [(cell / n) as u32, (cell % n) as u32], share, &mut row);
        }
        covered.iter().map(|parts| parts.iter().map(|&(cell, share)| share * row[cell]).sum()).collect()
    })?;
    Ok(grower.finish(root).into())
}

/// Adds a multiple of the values of all exitant cells for one incident cell of a level, both taken as means.
fn add_row(tree: &Tree, level: u32, incident: [u32; 2], factor: f64, row: &mut [f64]) {
    fn descend(
        arena: &Arena,
        slot: Slot,
        at: u32,
        cell: [u32; 2],
        job: &mut (u32, [u32; 2], f64, &mut [f64]),
    ) {
        let &mut (level, incident, factor, ref mut row) = job;
        match slot.content() {
            Content::Leaf(value) => {
                let add = f64::from(value) * factor;
                if add == 0.0 {
                    return;
                }
                if at >= level {
                    let [x, y] = cell.map(|c| (c >> (at - level)) as usize);
                    // A part of this cell, and of the incident one.
                    row[x << level | y] += add * 0.0625f64.powi((at - level) as i32);
                } else {
                    let edge = 1usize << (level - at);
                    let [x, y] = cell.map(|c| c as usize * edge);
                    for x in x..x + edge {
                        row[x << level | y..][..edge].iter_mut().for_each(|v| *v += add);
                    }
                }
            }
            Content::Node(node) => {
                for (k, &child) in arena.children(node).iter().enumerate() {
                    let bit = |i: usize| (k >> i & 1) as u32;
                    let inside = |i: usize| at >= level || incident[i] >> (level - 1 - at) & 1 == bit(i);
                    if inside(0) && inside(1) {
                        let below = [cell[0] << 1 | bit(2), cell[1] << 1 | bit(3)];
                        descend(arena, child, at + 1, below, job);
                    }
                }
            }
        }
    }
    let arena = tree.arena();
    descend(arena, arena.root(), 0, [0, 0], &mut (level, incident, factor, row));
}
