//! `aBSDF`: the peak of light that goes straight through, which its BSDF shows as a blur over a few cells.
//!
//! In: a transmission, and for it the incident direction of a ray. Out: which of its exitant cells are that peak. A path that leaves
//! by one of them goes straight on instead, less what is Lambertian there. So every path of the peak is restored once, and the
//! material's totals are those of its file.
//!
//! Source: Radiance's aBSDF, as its reference manual has it and as `rtrace` does it: around the straight direction 29 directions
//! are probed, 0.6 of the smallest cell's width apart; of the cells they meet, from the brightest on, those belong to the peak that
//! are about as small as the smallest and not fainter than an eighth of the mean of the peak so far; the others are its surround.
//! There is no peak if the brightest cell is a large one, if the surround is less than a fifth of the peak in extent, or if the peak
//! is below 0.05 % of the light.
//!
//! Deviations. Radiance drops scattered samples by their distance from the straight direction, one cell's width, so it counts what
//! lies in the peak's cells but farther away twice, and what lies nearer but in other cells not at all; here a sample belongs to
//! one or the other by its cell. Radiance restores the peak only for paths that were not scattered before; here always. It takes
//! cells of equal value for the same cell. It looks for the peak in the transmission that light would take from behind, if the file
//! has two; here it is the same that is sampled.

use bsdftree::{Cell, Direction, Scattering};

/// Distance of neighbouring probes, in widths of the smallest cell.
const STEP: f64 = 0.6;
/// Rings of probes around the straight direction; the last one has no corners.
const N_RINGS: i32 = 4;
const N_PROBES: usize = 29;
/// How much larger than the smallest cell one of the peak may be.
const LARGEST: f64 = 1.5;
/// How much fainter than the mean of the peak one of its cells may be.
const FAINTEST: f64 = 1.0 / 8.0;
/// Least extent of the surround, in extents of the peak.
const LEAST_SURROUND: f64 = 0.2;
/// Least part of the light that is a peak.
const LEAST_PEAK: f64 = 0.0005;
/// No probe, nor cell that one lies in, is so far from the straight direction, in widths of the smallest cell.
const REACH: f64 = 8.0;

/// What a transmission is searched with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// Width of the smallest cell: the root of its projected solid angle.
    width: f64,
    /// The Lambertian part of the transmission \[1/sr\].
    pub lambertian: f64,
}

/// The cells of a peak.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peak {
    keys: [u64; N_PROBES],
    n: usize,
    /// The fraction of light that goes straight through.
    pub transmittance: f64,
}

impl Search {
    pub fn new(transmission: &Scattering) -> Search {
        Search {
            width: transmission.smallest_cell().sqrt(),
            lambertian: transmission.lambertian() / std::f64::consts::PI,
        }
    }

    /// Whether light from `incident` to `exitant` can be of a peak at all.
    #[inline]
    pub fn reaches(&self, incident: Direction, exitant: Direction) -> bool {
        let [x, y] = [incident[0] + exitant[0], incident[1] + exitant[1]];
        x * x + y * y < (REACH * self.width).powi(2)
    }

    /// The peak of light from `incident`, if there is one.
    pub fn peak(&self, transmission: &Scattering, incident: Direction, reversed: bool) -> Option<Peak> {
        let mut cells = [Cell { key: 0, value: 0.0, projected_solid_angle: 0.0 }; N_PROBES];
        let mut n_cells = 0;
        for [x, y] in probes() {
            let probe = [-incident[0] + x * self.width, -incident[1] + y * self.width, -incident[2]];
            let Some(probe) = bsdftree::direction::normalized(probe) else { continue };
            let cell = transmission.cell(incident, probe, reversed);
            if !cells[..n_cells].iter().any(|other| other.key == cell.key) {
                cells[n_cells] = cell;
                n_cells += 1;
            }
        }
        let cells = &mut cells[..n_cells];
        // Keys decide between equals, so that the order does not depend on the order of probes.
        cells.sort_unstable_by(|a, b| b.value.total_cmp(&a.value).then(a.key.cmp(&b.key)));
        self.gathered(cells)
    }

    /// The peak among cells, the brightest first.
    fn gathered(&self, cells: &[Cell]) -> Option<Peak> {
        let mut peak = Peak { keys: [0; N_PROBES], n: 0, transmittance: 0.0 };
        let (mut values, mut extent, mut surround) = (0.0, 0.0, 0.0);
        for cell in cells {
            let is_small = cell.projected_solid_angle <= LARGEST * self.width * self.width;
            if !is_small || cell.value < FAINTEST * values / (peak.n.max(1) as f64) {
                if peak.n == 0 {
                    return None;
                }
                surround += cell.projected_solid_angle;
                continue;
            }
            peak.keys[peak.n] = cell.key;
            peak.n += 1;
            values += cell.value;
            extent += cell.projected_solid_angle;
            peak.transmittance += (cell.value - self.lambertian).max(0.0) * cell.projected_solid_angle;
        }
        (surround >= LEAST_SURROUND * extent && peak.transmittance >= LEAST_PEAK).then_some(peak)
    }
}

impl Peak {
    /// Whether a cell is part of it.
    pub fn holds(&self, cell: &Cell) -> bool {
        self.keys[..self.n].contains(&cell.key)
    }
}

/// Offsets of the probes, in widths of the smallest cell.
fn probes() -> impl Iterator<Item = [f64; 2]> {
    let around = (1..=N_RINGS).flat_map(|ring| {
        let signs = [-1, 0, 1];
        let pairs = signs.into_iter().flat_map(move |i| signs.map(|j| [i, j]));
        pairs
            .filter(move |&[i, j]| (i, j) != (0, 0) && (ring < N_RINGS || i == 0 || j == 0))
            .map(move |pair| pair.map(|sign| f64::from(sign * ring) * STEP))
    });
    std::iter::once([0.0; 2]).chain(around)
}

#[cfg(test)]
mod tests {
    use bsdftree::{Rank, Tree};

    use super::*;

    /// A rank-4 tree of 2^4 cells an axis with `through` on the diagonal cells and `base` elsewhere.
    fn blurred(through: f32, base: f32) -> Scattering {
        let values: Vec<f32> = (0..1 << 16).map(|k| if k >> 8 == k & 255 { through } else { base }).collect();
        Tree::from_grid(Rank::Four, &values).unwrap().into()
    }

    fn incident() -> Direction {
        // In the middle of a cell of the square.
        let disk = bsdftree::square::disk_from_square([1.0 - 9.5 / 16.0, 1.0 - 10.5 / 16.0]);
        bsdftree::Side::Front.direction_from_disk(disk)
    }

    #[test]
    fn there_are_29_probes() {
        assert_eq!(probes().count(), N_PROBES);
    }

    #[test]
    fn a_peak_of_one_cell_is_its_light_less_what_is_lambertian() {
        let transmission = blurred(40.0, 0.1);
        let search = Search::new(&transmission);
        assert!((search.lambertian - 0.1).abs() < 1e-8);
        let peak = search.peak(&transmission, incident(), false).unwrap();
        let cell = std::f64::consts::PI / 256.0;
        assert!((peak.transmittance - (40.0 - 0.1) * cell).abs() < 1e-7, "{}", peak.transmittance);
        let straight = incident().map(|c| -c);
        assert!(peak.holds(&transmission.cell(incident(), straight, false)));
        assert!(search.reaches(incident(), straight));
    }

    #[test]
    fn what_is_even_or_has_no_surround_is_no_peak() {
        // All cells alike as far as peaks go: none of them is surround.
        let values: Vec<f32> = (0..1 << 16).map(|k| 0.1 + (k % 7) as f32 * 0.01).collect();
        let uneven = Tree::from_grid(Rank::Four, &values).unwrap().into();
        for transmission in [blurred(0.1, 0.1), uneven, Tree::uniform(Rank::Four, 0.2).into()] {
            assert!(Search::new(&transmission).peak(&transmission, incident(), false).is_none());
        }
        // As faint as the law allows.
        let transmission = blurred(0.02, 0.0);
        assert!(Search::new(&transmission).peak(&transmission, incident(), false).is_none());
    }

    #[test]
    fn keys_of_a_peak_are_within_reach() {
        let transmission = blurred(40.0, 0.1);
        let search = Search::new(&transmission);
        let Some(peak) = search.peak(&transmission, incident(), false) else { panic!("no peak") };
        for k in 0..10_000 {
            let [u, v] = [f64::from(k % 100) / 100.0, f64::from(k / 100) / 100.0];
            let exitant =
                bsdftree::Side::Back.direction_from_disk(bsdftree::square::disk_from_square([u, v]));
            if peak.holds(&transmission.cell(incident(), exitant, false)) {
                assert!(search.reaches(incident(), exitant));
            }
        }
    }
}
