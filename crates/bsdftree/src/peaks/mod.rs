//! Specular peaks: light that leaves in one direction for each direction it comes from.
//!
//! In: a [`Band`]. Out: [`PeakFamily`]s: straight through, mirrored, or deviated by facets, prisms and gratings, each
//! with its strength, its width and the map of its directions. Nothing in the data changes.
//!
//! **Why.** A cell is constant, so a peak in it is spread over the cell: the flux is right, but the sun seen through
//! a cell of 5° is 100 times too large and too dim. Whoever knows the peak can send a ray along it instead.
//! Radiance's aBSDF does so when it renders, for light that goes straight through.
//!
//! Deviation: aBSDF looks around the straight direction, one query at a time; here all exitant directions are looked
//! at, and the peaks of all incident directions are judged together, which tells a faint peak from noise.
//!
//! What is a peak and why is said in `detect`, how peaks become families in `family`, how maps are found in `fit`.

mod field;
mod detect;
mod map;
mod fit;
mod family;
#[cfg(test)]
mod tests;

pub use map::{Map, bent, reflected, transmittance};

use crate::bsdf::{Band, Part, Scattering};
use crate::direction::{Direction, Side};
use crate::tree::Rank;
use detect::{Spot, cone_deg, spots};
use family::{Member, families};
use field::Incident;
use fit::{Pair, best_map, rms, through};

/// What counts as a peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakOptions {
    /// How many times brighter than what lies around it, at least; over 1.
    pub contrast: f64,
    /// Least fraction of the light; five times that, on average, where no map describes the peaks.
    pub min_strength: f64,
}

impl Default for PeakOptions {
    fn default() -> PeakOptions {
        PeakOptions { contrast: 10.0, min_strength: 0.002 }
    }
}

/// The map that most of the given peaks follow, `least` or more: incident and exitant directions that are known to about `edge`, a distance
/// in the disk (twice that in radians near the horizon is still little).
pub fn map_of(peaks: &[(Direction, Direction)], edge: f64, least: usize) -> Option<Map> {
    let pair = |&(incident, exitant): &(Direction, Direction)| Pair { incident, exitant, edge, weight: 1.0 };
    let pairs: Vec<Pair> = peaks.iter().map(pair).collect();
    best_map(&pairs, &[Map::Straight, Map::Mirror, Map::Retro], true, least)
}

/// Maps of all kinds, of several indices of refraction, that send light from one direction to another.
pub fn maps_through(incident: Direction, exitant: Direction) -> Vec<Map> {
    through(Pair { incident, exitant, edge: 1.0, weight: 1.0 }).collect()
}

/// A peak of the light from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Where the light comes from: the middle of an incident cell. In isotropic data, from azimuth 180°.
    pub incident: Direction,
    /// Where it goes: the flux-weighted middle.
    pub exitant: Direction,
    /// Fraction of the incident light in it, above the level around it.
    pub strength: f64,
    /// That level \[1/sr\].
    pub surround: f64,
    /// Projected solid angle that it fills \[sr\]: (Σ f Ω)² / Σ f² Ω.
    pub projected_solid_angle: f64,
    /// Whether it fills at most four cells, so that it may be narrower than the data says.
    pub resolution_limited: bool,
}

impl Peak {
    /// Full angle \[degree\] of the cone of its solid angle, which is the projected one over |cos θ_exitant|.
    pub fn width_deg(&self) -> f64 {
        cone_deg(self.projected_solid_angle / self.exitant[2].abs())
    }
}

/// Peaks of many incident directions that one map describes.
#[derive(Clone, Debug)]
pub struct PeakFamily {
    /// The component they are in.
    pub part: Part,
    /// Where they go.
    pub map: Map,
    /// Root mean square angle \[degree\] between where they go and where the map says; NaN for a table.
    pub residual_deg: f64,
    /// The peaks, in the order of the incident cells.
    pub peaks: Vec<Peak>,
    /// Incident directions that were looked at, evenly spread in projected solid angle for trees.
    pub n_directions: usize,
}

impl PeakFamily {
    /// Mean strength of the peaks.
    pub fn mean_strength(&self) -> f64 {
        self.peaks.iter().map(|p| p.strength).sum::<f64>() / self.peaks.len() as f64
    }
}

/// The specular peaks of all components of a band, component by component, the strongest family of each first.
///
/// Looks at up to 32 × 32 incident directions of a rank-4 tree (16 × 16 of one finer than 2^7), 128 of a rank-3 tree,
/// and all patches of a matrix. An absent transmission has the peaks of the other one, reversed.
///
/// ```
/// use bsdftree::{Component, Part, Band, Rank, Tree};
/// use bsdftree::peaks::{Map, PeakOptions, peaks};
///
/// // A mirror of 80 % at 2^4 cells per axis: all its light is in the cell on the diagonal.
/// let value = 0.8 / (std::f64::consts::PI / 256.0);
/// let grid: Vec<f32> = (0..1 << 16).map(|k| if k >> 8 == k & 255 { value as f32 } else { 0.0 }).collect();
/// let mut band = Band::new("Visible");
/// band.insert(Part::ReflectionBack, Component::grey(Tree::from_grid(Rank::Four, &grid)?.into()));
///
/// let families = peaks(&band, PeakOptions::default());
/// assert_eq!(families.len(), 1);
/// assert_eq!(families[0].map, Map::Mirror);
/// assert!((families[0].mean_strength() - 0.8).abs() < 1e-6);
/// // 16 × 16 cells: at the normal one is π/256 sr, a cone of 7.2°.
/// let narrowest = families[0].peaks.iter().map(|p| p.width_deg()).fold(180.0, f64::min);
/// assert!((narrowest - 7.2).abs() < 0.1);
/// # Ok::<(), bsdftree::tree::TreeError>(())
/// ```
pub fn peaks(band: &Band, options: PeakOptions) -> Vec<PeakFamily> {
    band.components().flat_map(|(part, component)| peaks_of(&component.luminance, part, options)).collect()
}

fn peaks_of(scattering: &Scattering, part: Part, options: PeakOptions) -> Vec<PeakFamily> {
    let (incident, isotropic) = match scattering {
        Scattering::Matrix(matrix) => (Incident::of_matrix(matrix), false),
        Scattering::Tree(tree) if tree.rank() == Rank::Three => (Incident::of_tree(tree, 8), true),
        Scattering::Tree(tree) => {
            (Incident::of_tree(tree, if tree.arena().log2_res() > 7 { 4 } else { 5 }), false)
        }
    };
    let (mut members, mut found) = (Vec::new(), Vec::new());
    for direction in 0..incident.onward.len() {
        for spot in spots(&incident.field(direction), options.contrast, options.min_strength) {
            members.push(Member { direction, pair: pair(&spot, part) });
            found.push(peak(&spot, incident.onward[direction], part));
        }
    }
    let fixed: &[Map] = if part.is_reflection() { &[Map::Mirror, Map::Retro] } else { &[Map::Straight] };
    let mut all: Vec<PeakFamily> =
        families(&members, &incident.neighbours, fixed, !isotropic, options.min_strength)
            .into_iter()
            .map(|family| {
                let pairs: Vec<Pair> = family.members.iter().map(|&k| members[k].pair).collect();
                PeakFamily {
                    part,
                    map: family.map,
                    residual_deg: rms(pairs.iter().map(|p| p.angle_deg(&family.map))),
                    peaks: family.members.iter().map(|&k| found[k]).collect(),
                    n_directions: incident.onward.len(),
                }
            })
            .collect();
    let flux = |family: &PeakFamily| family.peaks.iter().map(|p| p.strength).sum::<f64>();
    all.sort_by(|a, b| flux(b).total_cmp(&flux(a)));
    all
}

/// The direction on a side from one that is turned as if to the front.
fn on_side([x, y, z]: Direction, side: Side) -> Direction {
    [x, y, side.sign() * z]
}

/// Where light comes from that goes on in a direction.
fn back([x, y, z]: Direction, part: Part) -> Direction {
    on_side([-x, -y, z], part.incident_side())
}

fn pair(spot: &Spot, part: Part) -> Pair {
    Pair {
        incident: back(spot.onward, part),
        exitant: on_side(spot.exitant, part.exitant_side()),
        edge: spot.cell_area.sqrt(),
        weight: spot.strength,
    }
}

fn peak(spot: &Spot, onward: Direction, part: Part) -> Peak {
    Peak {
        incident: back(onward, part),
        exitant: on_side(spot.exitant, part.exitant_side()),
        strength: spot.strength,
        surround: spot.surround,
        projected_solid_angle: spot.area,
        resolution_limited: spot.resolution_limited,
    }
}
