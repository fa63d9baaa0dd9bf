//! How well scattered points cover a hemisphere, and what light they stand for.
//!
//! In: points with values on one side of the surface. Out: the largest hole, the spacing, the total. The hemisphere is cut into cells of
//! equal projected solid angle; a cell has the mean of its points, an empty one that of the nearest cell that has some, found by
//! going from neighbour to neighbour (nearest but for some percent of the distance). A total is Σ f·Ω over the cells.

use std::collections::VecDeque;
use std::f64::consts::PI;

use bsdftree::Direction;
use bsdftree::square::{disk_from_square, square_from_disk};

/// Cells per axis of the square.
const N: usize = 96;
/// Points whose nearest neighbours are looked for.
const N_SAMPLED: usize = 300;

/// Points on one side.
pub(crate) struct Coverage {
    /// Farthest that a direction of the hemisphere, down to 8° above the horizon, is from any point \[degree\].
    pub hole_deg: f64,
    /// Σ of values × projected solid angle.
    pub total: f64,
}

/// The square's cell that a direction lies in.
fn cell_of(direction: Direction) -> usize {
    let [x, y] = square_from_disk([direction[0], direction[1]]);
    let index = |t: f64| ((t * N as f64) as usize).min(N - 1);
    index(x) * N + index(y)
}

/// The middle of a cell; z is positive.
fn middle_of(cell: usize) -> Direction {
    let along = |k: usize| (k as f64 + 0.5) / N as f64;
    let [x, y] = disk_from_square([along(cell / N), along(cell % N)]);
    [x, y, (1.0 - x * x - y * y).max(0.0).sqrt()]
}

pub(crate) fn dot(a: Direction, b: Direction) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The angle between unit vectors \[degree\].
pub(crate) fn angle_deg(a: Direction, b: Direction) -> f64 {
    dot(a, b).clamp(-1.0, 1.0).acos().to_degrees()
}

impl Coverage {
    /// Of at least one point.
    pub(crate) fn of(points: &[(Direction, f64)]) -> Coverage {
        let up = |d: Direction| [d[0], d[1], d[2].abs()];
        let mut sums = vec![(0.0, 0usize); N * N];
        let mut nearest: Vec<Option<Direction>> = vec![None; N * N];
        for &(direction, value) in points {
            let direction = up(direction);
            let cell = cell_of(direction);
            let middle = middle_of(cell);
            sums[cell].0 += value;
            sums[cell].1 += 1;
            if nearest[cell].is_none_or(|other| dot(direction, middle) > dot(other, middle)) {
                nearest[cell] = Some(direction);
            }
        }
        let mut sources: Vec<Option<usize>> = (0..N * N).map(|cell| nearest[cell].map(|_| cell)).collect();
        spread(&mut sources, &nearest);
        let (mut hole, mut total): (f64, f64) = (0.0, 0.0);
        for (cell, source) in sources.iter().enumerate() {
            let source = source.expect("there is a point, and all cells are neighbours of neighbours");
            let (sum, n) = sums[source];
            total += sum / n as f64;
            hole = hole.max(angle_deg(nearest[source].expect("a source has one"), middle_of(cell)));
        }
        Coverage { hole_deg: hole, total: total * PI / (N * N) as f64 }
    }
}

/// Gives every cell the source that is nearest among those of its neighbours, until nothing changes.
fn spread(sources: &mut [Option<usize>], nearest: &[Option<Direction>]) {
    let mut queue: VecDeque<usize> = (0..N * N).filter(|&cell| sources[cell].is_some()).collect();
    while let Some(cell) = queue.pop_front() {
        let source = sources[cell].expect("only cells that have one are queued");
        let point = nearest[source].expect("a source has one");
        for neighbour in neighbours(cell) {
            if nearest[neighbour].is_some() {
                continue;
            }
            let middle = middle_of(neighbour);
            let is_nearer = match sources[neighbour] {
                None => true,
                Some(other) => {
                    dot(point, middle) > dot(nearest[other].expect("a source has one"), middle) + 1e-12
                }
            };
            if is_nearer {
                sources[neighbour] = Some(source);
                queue.push_back(neighbour);
            }
        }
    }
}

fn neighbours(cell: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (cell / N, cell % N);
    let steps = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)];
    steps.into_iter().filter_map(move |(a, b)| {
        let (x, y) = (x.checked_add_signed(a)?, y.checked_add_signed(b)?);
        (x < N && y < N).then_some(x * N + y)
    })
}

/// The median angle from a point to the nearest other one \[degree\], of some of them; NaN of fewer than two.
pub(crate) fn spacing_deg(points: &[Direction]) -> f64 {
    if points.len() < 2 {
        return f64::NAN;
    }
    let step = points.len().div_ceil(N_SAMPLED);
    let mut angles: Vec<f64> = (0..points.len())
        .step_by(step)
        .map(|k| {
            let others = points.iter().enumerate().filter(|&(other, _)| other != k);
            // Of near points the chord is exact, and the cosine is not.
            let squared = |p: &Direction| (0..3).map(|c| (p[c] - points[k][c]).powi(2)).sum::<f64>();
            let nearest = others.map(|(_, p)| squared(p)).fold(f64::INFINITY, f64::min);
            (2.0 * (nearest.sqrt() / 2.0).min(1.0).asin()).to_degrees()
        })
        .collect();
    let middle = angles.len() / 2;
    *angles.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdftree::direction::direction_from_polar;

    fn grid(thetas_deg: std::ops::Range<i32>, step: usize) -> Vec<Direction> {
        let thetas = thetas_deg.step_by(step);
        let at = |theta: i32| (0..360).step_by(step).map(move |phi| [f64::from(theta), f64::from(phi)]);
        thetas.flat_map(at).map(|[t, p]| direction_from_polar(t.to_radians(), p.to_radians())).collect()
    }

    #[test]
    fn totals_are_those_of_closed_forms() {
        let points = |f: fn(Direction) -> f64| -> Vec<(Direction, f64)> {
            grid(0..90, 3).into_iter().map(|d| (d, f(d))).collect()
        };
        assert!((Coverage::of(&points(|_| 1.0 / PI)).total - 1.0).abs() < 1e-9);
        // ∫ cos θ · cos θ dω = 2π/3.
        assert!((Coverage::of(&points(|d| d[2])).total - 2.0 * PI / 3.0).abs() < 0.01);
    }

    #[test]
    fn holes_are_as_large_as_they_are() {
        let whole = grid(0..90, 5).into_iter().map(|d| (d, 1.0)).collect::<Vec<_>>();
        assert!(Coverage::of(&whole).hole_deg < 6.0);
        let half: Vec<_> = whole.iter().copied().filter(|(d, _)| d[1] > -1e-9).collect();
        assert!((Coverage::of(&half).hole_deg - 82.0).abs() < 3.0);
        let cap: Vec<_> = grid(0..31, 5).into_iter().map(|d| (d, 1.0)).collect();
        assert!((Coverage::of(&cap).hole_deg - 52.0).abs() < 3.0);
        assert!((spacing_deg(&grid(40..45, 5)) - 3.21).abs() < 0.1);
    }
}
