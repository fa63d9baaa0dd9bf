//! How noisy values are, told from the data alone.
//!
//! Two estimates of the relative standard deviation of a value, both medians by flux, which peaks do not move much.
//! *Neighbours*: what is left of values beside each other when all that is smooth is taken out. Matrices: fourth differences
//! (1, −4, 6, −4, 1)/√70 around a ring of exitant patches, which cubic functions of azimuth leave 0. Trees: of the children of a node that are
//! all leaves, the contrasts of all axes but one, and of all, which leave 0 what is quadratic. Places where values differ over eightfold are
//! edges, not noise, and are left out; `coverage` is the flux of the others. What changes from one cell to the next looks like noise, so
//! this is too large where data is coarse.
//! *Reversal*: how far values are from those of the swapped pairs, over √2. Data that was made reciprocal has none; what lacks reciprocity for
//! other reasons has more. The level is the smaller of the two that can tell.
//! Source: J. Immerkær, Fast Noise Variance Estimation (CVIU 64, 1996) for contrasts; here medians, relative to the mean.

use super::pairs::{difference, draw, weighted_median};
use super::reciprocity::reversed_value;
use super::{Finding, Kind, Severity};
use crate::bsdf::{Band, Component, Part, Scattering};
use crate::klems::Matrix;
use crate::tree::{Content, Slot, Tree};

/// The median of |x| of a normal distribution of standard deviation 1.
const MEDIAN: f64 = 0.674_489_750_196_081_7;
/// Largest ratio of values that may differ by noise.
const EDGE: f64 = 8.0;
/// Flux that the estimate from neighbours must stand on.
const MIN_COVERAGE: f64 = 0.2;
/// Most that reversal alone may call noise.
const MAX_REVERSAL: f64 = 0.25;
/// Reciprocal up to rounding, so made so.
const EXACT: f64 = 1e-4;

/// The noise of a component, relative to its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The component.
    pub part: Part,
    /// Relative standard deviation of a value: the smaller of the estimates that there are.
    pub level: Option<f64>,
    /// From values beside each other; `None` if less than a fifth of the light is where that can be told.
    pub neighbours: Option<f64>,
    /// Share of the light where neighbours can be compared.
    pub coverage: f64,
    /// From swapped pairs; `None` if there are none, or data was made reciprocal.
    pub reversal: Option<f64>,
}

/// Of a component.
pub(super) fn noise(band: &Band, component: &Component, part: Part) -> Noise {
    let function = &component.luminance;
    let (deviations, light) = match function {
        Scattering::Tree(tree) => in_nodes(tree),
        Scattering::Matrix(matrix) => around_rings(matrix),
    };
    let calm = deviations.iter().fold(0.0, |sum, d| sum + d.1);
    let coverage = if light > 0.0 { (calm / light).min(1.0) } else { 0.0 };
    let neighbours = weighted_median(deviations).filter(|_| coverage >= MIN_COVERAGE).map(|m| m / MEDIAN);
    let reversal = by_reversal(band, function, part);
    let level = match (neighbours, reversal) {
        (Some(a), Some(b)) => Some(a.min(b)),
        // Alone, so much is no noise: it lacks reciprocity for other reasons.
        (None, Some(b)) => Some(b).filter(|&b| b < MAX_REVERSAL),
        (a, None) => a,
    };
    Noise { part, level, neighbours, coverage, reversal }
}

fn by_reversal(band: &Band, function: &Scattering, part: Part) -> Option<f64> {
    let reverse = match part {
        Part::TransmissionFront => Part::TransmissionBack,
        Part::TransmissionBack => Part::TransmissionFront,
        reflection => reflection,
    };
    let backward = &band.component(reverse)?.luminance;
    // Cells on the diagonal are their own reverse.
    let apart = draw(function, part).into_iter().filter_map(|pair| {
        let d = difference(pair.value, reversed_value(&pair, backward));
        (d > 0.0).then_some((d, pair.flux))
    });
    // (a − b)/(a + b) has the standard deviation σ/√2.
    weighted_median(apart.collect()).map(|m| m / MEDIAN * std::f64::consts::SQRT_2).filter(|&s| s > EXACT)
}

/// Relative deviations with the flux where they are, and all flux.
type Deviations = (Vec<(f64, f64)>, f64);

/// One contrast of values with a root of squared weights of 1, relative to their mean; `None` at edges and in the dark.
fn relative(values: &[f64], contrast: f64) -> Option<f64> {
    let [least, most] = values.iter().fold([f64::INFINITY, 0.0f64], |[a, b], &v| [a.min(v), b.max(v)]);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (least > 0.0 && most < EDGE * least).then(|| contrast.abs() / mean)
}

fn around_rings(matrix: &Matrix) -> Deviations {
    /// Fewer patches around a ring are too far apart to be smooth.
    const MIN_AROUND: usize = 8;
    const WEIGHTS: [f64; 5] = [1.0, -4.0, 6.0, -4.0, 1.0];
    let (incident, exitant) = (matrix.incident(), matrix.exitant());
    let n = exitant.n_patches();
    let (mut found, mut light) = (Vec::new(), 0.0);
    for (i, row) in matrix.values().chunks_exact(n).enumerate() {
        for ring in 0..exitant.rings().len() {
            let patches = exitant.patches_of(ring);
            let values = &row[patches.clone()];
            let area = incident.projected_solid_angle(i) * exitant.projected_solid_angle(patches.start);
            light += area * values.iter().map(|&v| f64::from(v)).sum::<f64>();
            if values.len() < MIN_AROUND {
                continue;
            }
            for k in 0..values.len() {
                let beside: [f64; 5] =
                    std::array::from_fn(|j| f64::from(values[(k + j + values.len() - 2) % values.len()]));
                let contrast: f64 = beside.iter().zip(WEIGHTS).map(|(v, w)| v * w).sum();
                let deviation = relative(&beside, contrast / 70f64.sqrt());
                found.extend(deviation.map(|d| (d, area * f64::from(values[k]))));
            }
        }
    }
    (found, light)
}

fn in_nodes(tree: &Tree) -> Deviations {
    let (mut found, mut light) = (Vec::new(), 0.0);
    in_node(tree, tree.arena().root(), 1.0, &mut found, &mut light);
    (found, light)
}

fn in_node(tree: &Tree, slot: Slot, volume: f64, found: &mut Vec<(f64, f64)>, light: &mut f64) {
    let node = match slot.content() {
        Content::Leaf(value) => {
            *light += volume * f64::from(value);
            return;
        }
        Content::Node(node) => node,
    };
    let children = tree.arena().children(node);
    let below = volume / children.len() as f64;
    children.iter().for_each(|&child| in_node(tree, child, below, found, light));
    let mut values = [0.0; 16];
    for (value, child) in values.iter_mut().zip(children) {
        let Content::Leaf(leaf) = child.content() else { return };
        *value = f64::from(leaf);
    }
    let values = &values[..children.len()];
    let sum: f64 = values.iter().sum();
    let all = children.len() - 1;
    // Signs by the parity of the axes in a mask: all but one of them, and all.
    let masks = (0..tree.rank().dimensions()).map(|axis| all ^ 1 << axis).chain([all]);
    // Of three axes, all but one are two: mixed second differences, which smooth functions have.
    for mask in masks.filter(|mask| mask.count_ones() >= 3) {
        let sign = |k: usize| if (k & mask).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
        let contrast: f64 = values.iter().enumerate().map(|(k, v)| sign(k) * v).sum();
        let n_masks = if children.len() == 16 { 5.0 } else { 1.0 };
        let deviation = relative(values, contrast / (values.len() as f64).sqrt());
        found.extend(deviation.map(|d| (d, below * sum / n_masks)));
    }
}

pub(super) fn findings(noises: &[Noise], tolerance: f64) -> Vec<Finding> {
    let noisy = noises.iter().filter_map(|noise| Some((noise.part, noise.level.filter(|&l| l > tolerance)?)));
    noisy
        .map(|(part, level)| {
            let message = format!(
                "values of {} have noise of {:.0} % (limit {:.0} %), or detail finer than its cells",
                part.file_name(),
                100.0 * level,
                100.0 * tolerance
            );
            let advice = "generate it with more samples";
            Finding::new(Kind::Noise, Severity::Warning, message, advice).of(part).by(level)
        })
        .collect()
}
