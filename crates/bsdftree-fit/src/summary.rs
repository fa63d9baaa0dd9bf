//! What was measured, as a table: a row for each part of each scan.
//!
//! In: a [`Measurement`]. Out: [`Row`]s. Values of colour are those of Y. Holes and totals of a sample that is said to be isotropic are
//! those of its points and their mirror images at the plane of incidence.

use bsdftree::direction::Side;
use bsdftree::{Direction, Part};
use rayon::prelude::*;

use crate::coverage::{Coverage, spacing_deg};
use crate::images;
use crate::measurement::{Measurement, Scan, Symmetry};
use crate::prepare;
use crate::write::degrees;

/// Totals are told where no direction is farther than this from a point \[degree\].
pub const LARGEST_HOLE_DEG: f64 = 20.0;
/// Sectors of azimuth that are looked for points in.
const N_SECTORS: usize = 36;

/// Points of a scan on one side.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Which scan, from 0.
    pub scan: usize,
    /// What it belongs to.
    pub part: Part,
    /// Where the light came from: polar angle from +Z and azimuth \[degree\].
    pub incident_deg: [f64; 2],
    /// How many points.
    pub n_points: usize,
    /// Smallest and largest angle from the normal of the side that it was measured on \[degree\].
    pub theta_range_deg: [f64; 2],
    /// Azimuths that there are points at, in steps of 10° \[degree\]; 360 is all.
    pub azimuth_coverage_deg: f64,
    /// Median angle from a point to the nearest other one \[degree\]; NaN of one point.
    pub spacing_deg: f64,
    /// Farthest that a direction of the hemisphere, down to 8° above the horizon, is from any point \[degree\].
    pub hole_deg: f64,
    /// Smallest and largest value \[1/sr\].
    pub value_range: [f64; 2],
    /// Values below 0.
    pub n_negative: usize,
    /// Median of standard error over value, if errors are known.
    pub relative_error: Option<f64>,
    /// How far values are from those mirrored at the plane of the light and the normal: relative L1 difference over the points off the plane
    /// whose images were measured too; `None` of vertical light and of points on one side. The light that such points scatter, not their
    /// number, counts.
    pub asymmetry: Option<f64>,
    /// Estimate of the part of the light that is scattered there, if no hole is larger than [`LARGEST_HOLE_DEG`].
    pub total: Option<f64>,
}

/// The table, in the order of the scans.
pub fn summary(measurement: &Measurement) -> Vec<Row> {
    let scans: Vec<(usize, &Scan)> = measurement.scans.iter().enumerate().collect();
    scans.into_par_iter().flat_map_iter(|(k, scan)| rows(measurement, k, scan)).collect()
}

fn rows(measurement: &Measurement, k: usize, scan: &Scan) -> Vec<Row> {
    let from = Side::of(scan.incident);
    let parts = Part::ALL.into_iter().filter(|part| part.incident_side() == from);
    parts
        .filter_map(|part| {
            let points: Vec<usize> = (0..scan.exitant.len())
                .filter(|&o| Side::of(scan.exitant[o]) == part.exitant_side())
                .collect();
            (!points.is_empty()).then(|| row(measurement, k, scan, part, &points))
        })
        .collect()
}

fn row(measurement: &Measurement, k: usize, scan: &Scan, part: Part, points: &[usize]) -> Row {
    let n = measurement.n_channels;
    // Y of X, Y, Z.
    let channel = if n == 3 { 1 } else { 0 };
    let value = |&o: &usize| scan.values[n * o + channel];
    let directions: Vec<Direction> = points.iter().map(|&o| scan.exitant[o]).collect();
    let thetas = directions.iter().map(|d| d[0].hypot(d[1]).atan2(d[2].abs()).to_degrees());
    let mut known: Vec<(Direction, f64)> = points.iter().map(|o| (scan.exitant[*o], value(o))).collect();
    if measurement.symmetry == Some(Symmetry::Isotropic) {
        known.extend(known.clone().into_iter().map(|(d, v)| (mirrored(d, scan.incident), v)));
    }
    let coverage = Coverage::of(&known);
    Row {
        scan: k,
        part,
        incident_deg: degrees(scan.incident),
        n_points: points.len(),
        theta_range_deg: range(thetas),
        azimuth_coverage_deg: azimuth_coverage_deg(&directions),
        spacing_deg: spacing_deg(&directions),
        hole_deg: coverage.hole_deg,
        value_range: range(points.iter().map(value)),
        n_negative: points.iter().filter(|o| value(o) < 0.0).count(),
        relative_error: relative_error(scan, points, n, channel),
        asymmetry: images::asymmetry(prepare::points_on_side(n, scan, k, part, points)),
        total: (coverage.hole_deg <= LARGEST_HOLE_DEG).then_some(coverage.total),
    }
}

/// Mirrored at the plane of the light and the normal.
fn mirrored([x, y, z]: Direction, incident: Direction) -> Direction {
    let length = incident[0].hypot(incident[1]);
    let [a, b] = if length < 1e-9 { [1.0, 0.0] } else { [incident[0] / length, incident[1] / length] };
    let along = x * a + y * b;
    [2.0 * along * a - x, 2.0 * along * b - y, z]
}

fn range(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    numbers
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], number| [low.min(number), high.max(number)])
}

fn azimuth_coverage_deg(directions: &[Direction]) -> f64 {
    let mut has = [false; N_SECTORS];
    // At the normal there is no azimuth.
    for d in directions.iter().filter(|d| d[0].hypot(d[1]) > 0.02) {
        // What lies on the border of sectors, as round angles do, is put into their middle.
        let sector = (degrees(*d)[1] / 360.0 * N_SECTORS as f64).round() as usize;
        has[sector % N_SECTORS] = true;
    }
    has.iter().filter(|&&has| has).count() as f64 * 360.0 / N_SECTORS as f64
}

fn relative_error(scan: &Scan, points: &[usize], n: usize, channel: usize) -> Option<f64> {
    if scan.errors.is_empty() {
        return None;
    }
    let ratio = |&o: &usize| scan.errors[n * o + channel] / scan.values[n * o + channel].abs();
    let mut ratios: Vec<f64> = points.iter().map(ratio).filter(|ratio| ratio.is_finite()).collect();
    let middle = ratios.len() / 2;
    (!ratios.is_empty()).then(|| *ratios.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdftree::direction::direction_from_polar;

    fn half_sphere() -> Scan {
        let at = |theta: i32, phi: i32| {
            direction_from_polar(f64::from(theta).to_radians(), f64::from(phi).to_radians())
        };
        let exitant: Vec<Direction> =
            (0..90).step_by(5).flat_map(|t| (0..=180).step_by(10).map(move |p| at(t, p))).collect();
        let values = vec![0.1; exitant.len()];
        Scan { incident: at(30, 180), exitant, values, ..Scan::default() }
    }

    #[test]
    fn half_a_sphere_is_whole_if_the_sample_is_isotropic() {
        let mut measurement =
            Measurement { n_channels: 1, scans: vec![half_sphere()], ..Measurement::default() };
        let rows = summary(&measurement);
        assert_eq!((rows.len(), rows[0].part, rows[0].total), (1, Part::ReflectionBack, None));
        assert_eq!((rows[0].azimuth_coverage_deg, rows[0].n_negative), (190.0, 0));
        assert!(rows[0].theta_range_deg[0] < 1e-9 && (rows[0].theta_range_deg[1] - 85.0).abs() < 1e-9);
        measurement.symmetry = Some(Symmetry::Isotropic);
        let total = summary(&measurement)[0].total.unwrap();
        assert!((total - 0.1 * std::f64::consts::PI).abs() < 1e-9);
    }
}
