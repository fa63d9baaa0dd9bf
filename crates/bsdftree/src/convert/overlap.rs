//! What the patches of an angle basis and the cells of the square share.
//!
//! In: a basis and a resolution. Out: for each cell of each level up to it, the patches that it touches with the area they share, as
//! fractions of the square (times π: projected solid angle). Exact, by cutting polygons; the rows of a level add up to its cells.

use super::polygon::sector;
use crate::klems::Basis;

/// Finest level that is cut; cells below share out their ancestor's patches evenly.
pub(super) const MAX_LEVEL: u32 = 10;

/// A patch and an area.
pub(super) type Share = (u32, f64);

/// Patches by cell, on all levels.
pub(super) struct Overlap {
    levels: Vec<Rows>,
    areas: Vec<f64>,
}

struct Rows {
    /// Where the row of each cell begins in `shares`, and the end.
    first: Vec<u32>,
    shares: Vec<Share>,
}

impl Overlap {
    /// Of the cells of 2^log2_res and fewer per axis, cut at [`MAX_LEVEL`] at most.
    pub fn new(basis: &Basis, log2_res: u32) -> Overlap {
        let finest = log2_res.min(MAX_LEVEL);
        let mut found: Vec<(u32, Share)> = Vec::new();
        let cell_area = 0.25f64.powi(finest as i32);
        for ring in 0..basis.rings().len() {
            for patch in basis.patches_of(ring) {
                for polygon in sector(basis.radii(ring), basis.azimuths(patch)) {
                    polygon.each_cell(finest, |[x, y], share| {
                        found.push((y << finest | x, (patch as u32, share * cell_area)));
                    });
                }
            }
        }
        let mut areas = vec![0.0; basis.n_patches()];
        found.iter().for_each(|&(_, (patch, area))| areas[patch as usize] += area);
        let mut levels = vec![Rows::new(finest, found)];
        for level in (0..finest).rev() {
            let fine = levels.last().expect("the finest");
            let rows = fine.coarser(level);
            levels.push(rows);
        }
        levels.reverse();
        Overlap { levels, areas }
    }

    /// The patches that share a cell of edge 2^-level, the areas, and a factor for them.
    pub fn row(&self, level: u32, [x, y]: [u32; 2]) -> (&[Share], f64) {
        let cut = level.min(self.levels.len() as u32 - 1);
        let down = level - cut;
        let cell = ((y >> down) << cut | x >> down) as usize;
        let rows = &self.levels[cut as usize];
        (&rows.shares[rows.first[cell] as usize..rows.first[cell + 1] as usize], 0.25f64.powi(down as i32))
    }

    /// Area of each patch, all together 1.
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }
}

impl Rows {
    /// Sorts shares by cell and patch, and adds up those of one patch.
    fn new(level: u32, mut found: Vec<(u32, Share)>) -> Rows {
        found.sort_by_key(|&(cell, (patch, _))| (cell, patch));
        found.dedup_by(|next, kept| {
            let same = (next.0, next.1.0) == (kept.0, kept.1.0);
            if same {
                kept.1.1 += next.1.1;
            }
            same
        });
        let mut first = vec![0; (1 << (2 * level)) + 1];
        found.iter().for_each(|&(cell, _)| first[cell as usize + 1] += 1);
        (1..first.len()).for_each(|k| first[k] += first[k - 1]);
        Rows { first, shares: found.into_iter().map(|(_, share)| share).collect() }
    }

    /// The next coarser level.
    fn coarser(&self, level: u32) -> Rows {
        let mut found = Vec::with_capacity(self.shares.len());
        for cell in 0..self.first.len() - 1 {
            let (x, y) = (cell & ((2 << level) - 1), cell >> (level + 1));
            let parent = (y >> 1 << level | x >> 1) as u32;
            let row = self.first[cell] as usize..self.first[cell + 1] as usize;
            found.extend(self.shares[row].iter().map(|&share| (parent, share)));
        }
        Rows::new(level, found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn shares_are_the_areas_of_patches_and_of_cells() {
        for basis in [Basis::full(), Basis::half_73(), Basis::quarter(), Basis::full().subdivided(2).unwrap()]
        {
            let overlap = Overlap::new(&basis, 5);
            for (patch, area) in overlap.areas().iter().enumerate() {
                let expected = basis.projected_solid_angle(patch) / PI;
                assert!((area - expected).abs() < 1e-11, "{} {patch}: {area} {expected}", basis.name());
            }
            for level in 0..8 {
                for (x, y) in [(0, 0), (1, 0), (1, 1), (3, 2), (5, 7)] {
                    let n = 1u32 << level;
                    let (shares, factor) = overlap.row(level, [x % n, y % n]);
                    let sum: f64 = shares.iter().map(|&(_, area)| area * factor).sum();
                    assert!((sum * f64::from(n * n) - 1.0).abs() < 1e-9, "level {level}: {sum}");
                }
            }
        }
    }
}
