//! Peaks of the light from one direction.
//!
//! In: a [`Field`]. Out: its [`Spot`]s, brightest cell first. A spot is a connected group of cells, all within a
//! factor `contrast` of its brightest, around which everything is darker than that, and which stands `contrast` times
//! above what lies around.
//!
//! * *Group*: grown from the brightest cell not yet taken, over cells ≥ brightest / contrast.
//! * *Skirt*: the cells that touch it. A peak seldom ends on a border between cells: what spills into skirt cells no
//!   coarser than the brightest one belongs to its flux.
//! * *Ring*: the cells that touch the skirt. Their mean is the level from which flux is counted; cells that are
//!   bright enough to be in the group, other peaks, do not count.
//!
//! **Why size decides.** Light in one direction that leaves in one direction fills the image of one incident cell,
//! whatever the resolution: one cell if the borders fit, up to four if not. A smooth lobe fills ever more cells as
//! they get finer. So a group of at most [`FEW`] cells is as narrow as the data can say, and anything wider must be
//! narrow in itself: at most [`NARROW_DEG`].
//!
//! **Why contrast 10.** The lobe exp(−x²/2σ²) falls to 1/10 at x = 2.15σ. To be taken for a peak of at most four
//! cells of edge w it must have π(2.15σ)² ≤ 4w², σ ≤ 0.53w: narrower than one cell, so that the data itself cannot
//! tell it from a peak. With a contrast of 3 that would be 0.76w, and the spread of a few counts per cell in
//! ray-traced data would do.

use std::f64::consts::PI;

use crate::direction::{Direction, normalized};
use crate::peaks::field::Field;

/// Most cells, of the brightest one's size, that one direction's image meets if it is not stretched.
pub(super) const FEW: f64 = 4.0;
/// Widest peak of more cells than that \[degree\]: the width of a Klems patch, in which the three-phase method has
/// the sun.
pub(super) const NARROW_DEG: f64 = 10.0;
/// Widest peak at all \[degree\]: four cells of 2^3 per axis. Coarser data does not say whether there is a peak.
pub(super) const WIDEST_DEG: f64 = 29.0;

/// More peaks than this of one direction are mostly noise: a prism of 45° has up to ten.
const MANY: usize = 16;
/// How many times stronger than the median of many spots one is that is none of them: four cells of two counts among
/// single ones are eight.
const OVER_NOISE: f64 = 8.0;

/// A peak in a field.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// Fraction of the light.
    pub strength: f64,
    /// Level around it \[1/sr\].
    pub surround: f64,
    /// Its flux-weighted mean direction, as if to the front.
    pub exitant: Direction,
    /// The flux-weighted mean of (−x, −y, |z|) of the incident directions that its cells stand for.
    pub onward: Direction,
    /// Projected solid angle that it fills \[sr\].
    pub area: f64,
    /// Projected solid angle of its brightest cell \[sr\].
    pub cell_area: f64,
    /// Whether it is as narrow as the data can say.
    pub resolution_limited: bool,
}

/// Full angle \[degree\] of the cone of a solid angle \[sr\].
pub(super) fn cone_deg(solid_angle: f64) -> f64 {
    2.0 * (1.0 - solid_angle / (2.0 * PI)).clamp(-1.0, 1.0).acos().to_degrees()
}

fn cone_solid_angle(width_deg: f64) -> f64 {
    2.0 * PI * (1.0 - (0.5 * width_deg).to_radians().cos())
}

/// The peaks of a field that stand `contrast` times above what is around them and hold at least `min_strength` of the
/// light.
pub(super) fn spots(field: &Field<'_>, contrast: f64, min_strength: f64) -> Vec<Spot> {
    let cells = &field.cells;
    let mut order: Vec<u32> = (0..cells.len() as u32).filter(|&k| cells[k as usize].value > 0.0).collect();
    order.sort_by(|&a, &b| cells[b as usize].value.total_cmp(&cells[a as usize].value));
    // Even the widest peak of this value would be too weak.
    let faint = |value: f64| value * cone_solid_angle(WIDEST_DEG) < min_strength;
    let mut search = Search { field, taken: vec![false; cells.len()], marks: vec![0; cells.len()], mark: 0 };
    let mut spots = Vec::new();
    for seed in order {
        if faint(cells[seed as usize].value) {
            break;
        }
        if !search.taken[seed as usize] {
            spots.extend(search.spot(seed, contrast));
        }
    }
    let floor = min_strength.max(noise(&spots));
    spots.retain(|spot| spot.strength >= floor);
    spots
}

/// The strength below which spots are noise: counts scattered thinly over the cells make many spots of like strength.
fn noise(spots: &[Spot]) -> f64 {
    if spots.len() <= MANY {
        return 0.0;
    }
    let mut strengths: Vec<f64> = spots.iter().map(|spot| spot.strength).collect();
    strengths.sort_by(f64::total_cmp);
    OVER_NOISE * strengths[strengths.len() / 2]
}

struct Search<'a> {
    field: &'a Field<'a>,
    /// Whether a cell belongs to a group.
    taken: Vec<bool>,
    /// The search in which a cell was last met.
    marks: Vec<u32>,
    mark: u32,
}

impl Search<'_> {
    fn spot(&mut self, seed: u32, contrast: f64) -> Option<Spot> {
        let cells = &self.field.cells;
        let brightest = cells[seed as usize];
        let floor = brightest.value / contrast;
        let group = self.group(seed, floor);
        let sum = |of: &[u32], f: &dyn Fn(usize) -> f64| of.iter().map(|&k| f(k as usize)).sum::<f64>();
        let area = sum(&group, &|k| cells[k].area);
        let solid_angle = sum(&group, &|k| cells[k].area / cells[k].exitant[2]);
        // Sums of equal areas differ in their last bits.
        let few = area <= FEW * brightest.area * (1.0 + 1e-9);
        if solid_angle > cone_solid_angle(WIDEST_DEG) || !(few || solid_angle <= cone_solid_angle(NARROW_DEG))
        {
            return None;
        }
        self.mark += 1;
        group.iter().for_each(|&k| self.marks[k as usize] = self.mark);
        let skirt = self.around(&group);
        // The foot of something brighter.
        if skirt.iter().any(|&k| cells[k as usize].value >= floor) {
            return None;
        }
        let mut ring = self.around(&skirt);
        ring.retain(|&k| cells[k as usize].value < floor);
        let ring = if ring.is_empty() { &skirt } else { &ring };
        let ring_area = sum(ring, &|k| cells[k].area);
        let surround =
            if ring_area > 0.0 { sum(ring, &|k| cells[k].value * cells[k].area) / ring_area } else { 0.0 };
        if sum(&group, &|k| cells[k].value * cells[k].area) < contrast * surround * area {
            return None;
        }
        let excess = |k: usize| (cells[k].value - surround) * cells[k].area;
        let spilt: Vec<u32> =
            skirt.into_iter().filter(|&k| cells[k as usize].area <= brightest.area * (1.0 + 1e-9)).collect();
        let spill = sum(&spilt, &excess).max(0.0);
        let strength = sum(&group, &excess) + spill;
        let within: Vec<u32> =
            group.into_iter().chain(spilt.into_iter().filter(|&k| excess(k as usize) > 0.0)).collect();
        let flux = sum(&within, &excess);
        let mean = |f: &dyn Fn(usize) -> f64| sum(&within, &|k| excess(k) * f(k)) / flux;
        let square = sum(&within, &|k| excess(k).powi(2) / cells[k].area);
        Some(Spot {
            strength,
            surround,
            exitant: normalized([0, 1, 2].map(|axis| mean(&|k| cells[k].exitant[axis])))?,
            onward: normalized([0, 1, 2].map(|axis| mean(&|k| cells[k].onward[axis])))?,
            // (Σ f Ω)² / Σ f² Ω: the area of an even disk, and 4πσ² of a normal distribution.
            area: flux * flux / square,
            cell_area: brightest.area,
            resolution_limited: few,
        })
    }

    /// The connected cells at least as bright as `floor` and not yet taken.
    fn group(&mut self, seed: u32, floor: f64) -> Vec<u32> {
        let field = self.field;
        let mut group = vec![seed];
        self.taken[seed as usize] = true;
        let mut next = 0;
        while next < group.len() {
            field.for_neighbours(group[next], |k| {
                if !self.taken[k as usize] && field.cells[k as usize].value >= floor {
                    self.taken[k as usize] = true;
                    group.push(k);
                }
            });
            next += 1;
        }
        group
    }

    /// The cells that touch these and were not met in this search.
    fn around(&mut self, of: &[u32]) -> Vec<u32> {
        let mut around = Vec::new();
        for &k in of {
            self.field.for_neighbours(k, |j| {
                if self.marks[j as usize] != self.mark {
                    self.marks[j as usize] = self.mark;
                    around.push(j);
                }
            });
        }
        around
    }
}
