//! With which period a device repeats, found from its surfaces.
//!
//! In: a device. Out: its period along x and along y, if it has one. Surfaces that differ only by their place along an axis repeat there if
//! they follow each other at equal distances; the period is the one by which most area repeats. It is told to whoever spreads samples
//! over a device, for whom a wrong one would be a pity and no error.

use std::collections::HashMap;

use glam::DVec3;

use crate::device::{Device, Surface};
use crate::shape::Shape;
use crate::triangulate::area_vector;

/// Fewest times that something has to be there to repeat.
const LEAST_TIMES: usize = 3;

/// Distances that differ by less are equal, as a part of them.
const TOLERANCE: f64 = 1e-3;

/// Lengths are told apart by this part of the device's extent.
const GRAIN: f64 = 1e-5;

/// All of a surface but its place along an axis: material, kind, and in grains its box, its area's root and which way it faces.
type Likeness = (u32, u8, [i64; 10]);

impl Device {
    /// The period along x and along y \[m\] of a device that repeats at least three times.
    pub fn periods(&self) -> [Option<f64>; 2] {
        let Some([low, high]) = self.bounds() else { return [None; 2] };
        let grain = GRAIN * (high - low).max_element();
        if grain.is_nan() || grain <= 0.0 {
            return [None; 2];
        }
        [0, 1].map(|axis| match self.tile {
            Some([from, to]) => {
                let known = to[axis] - from[axis];
                (known > 0.0 && high[axis] - low[axis] > 2.0 * known).then_some(known)
            }
            None => self.period_along(axis, grain),
        })
    }

    fn period_along(&self, axis: usize, grain: f64) -> Option<f64> {
        let mut alike: HashMap<Likeness, Vec<f64>> = HashMap::new();
        for surface in self.surfaces.iter().filter(|s| !matches!(s.shape, Shape::Mesh(_))) {
            let place = surface.shape.bounds()[0][axis];
            alike.entry(likeness(surface, axis, grain)).or_default().push(place);
        }
        let mut found: Vec<(f64, f64)> = alike
            .into_iter()
            .filter(|(_, places)| places.len() >= LEAST_TIMES)
            .filter_map(|((_, _, lengths), mut places)| {
                let period = common_distance(&mut places)?;
                Some((period, lengths[6] as f64 * places.len() as f64))
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let same = |a: &(f64, f64), b: &(f64, f64)| b.0 - a.0 <= TOLERANCE * a.0;
        let by_area = found.chunk_by(same).map(|group| (group[0].0, group.iter().map(|g| g.1).sum::<f64>()));
        by_area.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(period, _)| period)
    }
}

fn likeness(surface: &Surface, axis: usize, grain: f64) -> Likeness {
    let [mut low, mut high] = surface.shape.bounds();
    high[axis] -= low[axis];
    low[axis] = 0.0;
    let (kind, facing) = match &surface.shape {
        Shape::Polygon(vertices) => (0, area_vector(vertices)),
        Shape::Sphere { .. } => (1, DVec3::ZERO),
        Shape::Cylinder { ends, .. } => (2, ends[1] - ends[0]),
        Shape::Cone { ends, .. } => (3, ends[1] - ends[0]),
        Shape::Ring { normal, .. } => (4, *normal),
        Shape::Mesh(_) => (5, DVec3::ZERO),
    };
    let size = surface.shape.area().sqrt();
    let facing = facing.normalize_or_zero() * size;
    let lengths = [low.x, low.y, low.z, high.x, high.y, high.z, size, facing.x, facing.y, facing.z];
    (surface.material, kind, lengths.map(|x| (x / grain).round() as i64))
}

/// The distance at which places follow each other, nearly all of them.
fn common_distance(places: &mut [f64]) -> Option<f64> {
    places.sort_unstable_by(f64::total_cmp);
    let mut distances: Vec<f64> = places.windows(2).map(|w| w[1] - w[0]).collect();
    distances.sort_unstable_by(f64::total_cmp);
    let middle = distances[distances.len() / 2];
    let equal = distances.iter().filter(|&&d| (d - middle).abs() <= TOLERANCE * middle).count();
    (middle > 0.0 && 10 * equal >= 9 * distances.len()).then_some(middle)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Device {
        Device::parse_rad(text, "test.rad", ".".as_ref(), crate::Unit::Meter).unwrap()
    }

    fn periods(spec: &str) -> [Option<f64>; 2] {
        let mut device = Device::from_spec(spec).unwrap();
        let known = device.periods();
        device.tile = None;
        let found = device.periods();
        for (known, found) in known.into_iter().zip(found) {
            if let (Some(known), Some(found)) = (known, found) {
                assert!((known - found).abs() < 1e-3 * known, "{spec}: {known} {found}");
            }
        }
        found
    }

    #[test]
    fn what_repeats_is_found_without_being_told() {
        for spec in ["blinds:angle=30", "blinds:angle=30,glazing=0.8,rise=0.005", "sawtooth", "prism"] {
            let [x, y] = periods(spec);
            assert!(x.is_none() && y.is_some(), "{spec}: {x:?} {y:?}");
        }
        assert_eq!(periods("mirror:reflectance=0.5"), [None; 2]);
    }

    #[test]
    fn a_lattice_has_a_period_along_either_axis() {
        let mut text = String::from("void plastic m 0 0 5 .5 .5 .5 0 0\n");
        for (i, j) in (0..5).flat_map(|i| (0..7).map(move |j| (i, j))) {
            text += &format!("m sphere s 0 0 4 {} {} -1 .2\n", 0.7 * f64::from(i), 0.9 * f64::from(j));
        }
        let device = read(&text);
        let [x, y] = device.periods().map(Option::unwrap);
        assert!((x - 0.7).abs() < 1e-9 && (y - 0.9).abs() < 1e-9, "{x} {y}");
    }

    #[test]
    fn what_lies_anywhere_has_none() {
        let mut text = String::from("void plastic m 0 0 5 .5 .5 .5 0 0\n");
        for k in 0..20 {
            text += &format!("m sphere s 0 0 4 {} 0 -1 .1\n", (f64::from(k) * 0.618).fract() * 10.0);
        }
        assert_eq!(read(&text).periods(), [None; 2]);
        assert_eq!(Device::default().periods(), [None; 2]);
    }
}
