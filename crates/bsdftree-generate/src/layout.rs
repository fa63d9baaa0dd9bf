//! How incident and exitant directions are divided: the cells of a tree at its finest, or the patches of a Klems basis.
//!
//! Both sides of a pair are points of the unit disk: −incident.xy, which is where the ray travels, and exitant.xy.
//! Cells of a square count in Morton order, first coordinate in the low bit, which is the order of a tree's children.

use std::f64::consts::PI;
use std::sync::Arc;

use bsdftree::square::{disk_from_square, square_from_disk};
use bsdftree::{Basis, Rank, Side};

/// The division of a BSDF's domain in which paths are counted.
#[derive(Clone, Debug)]
pub enum Layout {
    /// 2^log2_res cells along each axis of a tree.
    Tree {
        /// Isotropic or not.
        rank: Rank,
        /// At most [`MAX_LOG2_RES`].
        log2_res: u32,
    },
    /// Patches of one basis for both directions.
    Klems(Arc<Basis>),
}

/// Exitant cells are numbered in 32 bits.
pub const MAX_LOG2_RES: u32 = 12;

impl Layout {
    /// Number of incident cells.
    pub fn n_incident(&self) -> usize {
        match self {
            Layout::Tree { rank: Rank::Three, log2_res } => 1 << (log2_res - 1),
            Layout::Tree { rank: Rank::Four, log2_res } => 1 << (2 * log2_res),
            Layout::Klems(basis) => basis.n_patches(),
        }
    }

    /// Number of exitant cells.
    pub fn n_exitant(&self) -> usize {
        match self {
            Layout::Tree { log2_res, .. } => 1 << (2 * log2_res),
            Layout::Klems(basis) => basis.n_patches(),
        }
    }

    /// −incident.xy for a point of an incident cell, uniform in projected solid angle for uniform (u, v) in \[0, 1)².
    /// Rank 3 takes every azimuth: its BSDF is the mean over azimuth if the device is not isotropic.
    #[inline]
    pub fn incident_disk(&self, cell: usize, u: f64, v: f64) -> [f64; 2] {
        match self {
            Layout::Tree { rank: Rank::Four, log2_res } => {
                let [x, y] = cell_from_morton(cell as u32).map(f64::from);
                let scale = 1.0 / f64::from(1u32 << log2_res);
                disk_from_square([(x + u) * scale, (y + v) * scale])
            }
            Layout::Tree { rank: Rank::Three, log2_res } => {
                let sine = |cell: usize| 1.0 - 2.0 * cell as f64 * 0.5f64.powi(*log2_res as i32);
                let (outer, inner) = (sine(cell), sine(cell + 1));
                let r = (inner * inner + (outer * outer - inner * inner) * u).sqrt();
                let (sin, cos) = (2.0 * PI * v).sin_cos();
                [r * cos, r * sin]
            }
            Layout::Klems(basis) => basis.disk_point(cell, u, v),
        }
    }

    /// The exitant cell of exitant.xy for light that came by `incident` (as −incident.xy).
    #[inline]
    pub fn exitant_cell(&self, incident: [f64; 2], [x, y]: [f64; 2]) -> u32 {
        match self {
            Layout::Tree { rank, log2_res } => {
                let square = match rank {
                    Rank::Four => square_from_disk([x, y]),
                    Rank::Three => {
                        let r = incident[0].hypot(incident[1]);
                        let [c, s] = if r > 0.0 { [incident[0] / r, incident[1] / r] } else { [1.0, 0.0] };
                        let across = c * y - s * x;
                        // Mirrored and straight light lies in the plane of incidence, on a border of cells: half of it
                        // goes to each side, by a bit of the direction that is as good as random.
                        let across = match across.abs() < 1e-12 {
                            true if (incident[0].to_bits() ^ incident[1].to_bits()) & 1 == 0 => 1e-12,
                            true => -1e-12,
                            false => across,
                        };
                        square_from_disk([c * x + s * y, across])
                    }
                };
                let n = 1u32 << log2_res;
                let [p, q] = square.map(|c| ((c * f64::from(n)) as u32).min(n - 1));
                morton_from_cell([p, q])
            }
            Layout::Klems(basis) => basis.patch(Side::Front.direction_from_disk([x, y])) as u32,
        }
    }

    /// The incident cell from which light comes that travels against an exitant cell's, or the other way round. Not for rank 3.
    pub fn reversed(&self, cell: usize) -> usize {
        match self {
            Layout::Tree { log2_res, .. } => (1 << (2 * log2_res)) - 1 - cell,
            // The middle of a patch, turned by 180° about the normal.
            Layout::Klems(basis) if basis.rings()[0].n_phi == 1 && cell == 0 => 0,
            Layout::Klems(basis) => {
                let [x, y] = basis.disk_point(cell, 0.5, 0.5);
                basis.patch(Side::Front.direction_from_disk([-x, -y]))
            }
        }
    }

    /// Projected solid angle of an exitant cell \[sr\].
    pub fn exitant_area(&self, cell: usize) -> f64 {
        match self {
            Layout::Tree { log2_res, .. } => PI * 0.25f64.powi(*log2_res as i32),
            Layout::Klems(basis) => basis.projected_solid_angle(cell),
        }
    }
}

/// Bits of a number spread to the even places.
fn spread(x: u32) -> u32 {
    let x = (x | x << 8) & 0x00FF_00FF;
    let x = (x | x << 4) & 0x0F0F_0F0F;
    let x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}

fn gathered(x: u32) -> u32 {
    let x = x & 0x5555_5555;
    let x = (x | x >> 1) & 0x3333_3333;
    let x = (x | x >> 2) & 0x0F0F_0F0F;
    let x = (x | x >> 4) & 0x00FF_00FF;
    (x | x >> 8) & 0xFFFF
}

/// The Morton number of a cell of the square, first coordinate in the low bit.
#[inline]
pub fn morton_from_cell([x, y]: [u32; 2]) -> u32 {
    spread(x) | spread(y) << 1
}

/// The cell of a Morton number.
#[inline]
pub fn cell_from_morton(morton: u32) -> [u32; 2] {
    [gathered(morton), gathered(morton >> 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn morton_numbers_are_inverse_and_first_coordinate_is_low() {
        assert_eq!(morton_from_cell([1, 0]), 1);
        assert_eq!(morton_from_cell([0, 1]), 2);
        for cell in [[0, 0], [5, 9], [4095, 4095], [1234, 3210]] {
            assert_eq!(cell_from_morton(morton_from_cell(cell)), cell);
        }
    }

    #[test]
    fn light_that_goes_straight_on_leaves_by_the_cell_it_came_by() {
        let layouts = [
            Layout::Tree { rank: Rank::Four, log2_res: 4 },
            Layout::Klems(Arc::new(Basis::full())),
            Layout::Klems(Arc::new(Basis::half())),
        ];
        for layout in layouts {
            for cell in 0..layout.n_incident() {
                let disk = layout.incident_disk(cell, 0.3, 0.8);
                assert_eq!(layout.exitant_cell(disk, disk) as usize, cell);
            }
        }
    }

    #[test]
    fn rank_3_peaks_lie_where_the_format_says() {
        let layout = Layout::Tree { rank: Rank::Three, log2_res: 5 };
        for cell in 0..layout.n_incident() {
            for v in [0.1, 0.45, 0.9] {
                let disk = layout.incident_disk(cell, 0.5, v);
                let [p, q] = cell_from_morton(layout.exitant_cell(disk, disk));
                // (1 − d0, ½): the border between the two middle cells of q.
                assert_eq!(p, 31 - cell as u32);
                assert!(q == 15 || q == 16);
            }
        }
    }

    #[test]
    fn light_in_the_plane_of_incidence_is_shared_by_the_cells_beside_it() {
        let layout = Layout::Tree { rank: Rank::Three, log2_res: 5 };
        let upper = (0..1000).filter(|&k| {
            let disk = layout.incident_disk(k % 16, 0.5, k as f64 / 1000.0);
            cell_from_morton(layout.exitant_cell(disk, disk))[1] == 16
        });
        let upper = upper.count();
        // Five standard deviations of a fair coin.
        assert!(upper.abs_diff(500) < 80, "{upper} of 1000");
    }

    #[test]
    fn areas_of_exitant_cells_make_a_hemisphere() {
        for layout in
            [Layout::Tree { rank: Rank::Three, log2_res: 3 }, Layout::Klems(Arc::new(Basis::quarter()))]
        {
            let sum: f64 = (0..layout.n_exitant()).map(|k| layout.exitant_area(k)).sum();
            assert!((sum - PI).abs() < 1e-12);
        }
    }
}
