//! A device that repeats for ever: what leaves one period by a side enters the next.
//!
//! The box of one period is cut out of the device; only what lies in it is met. A ray that reaches one of its four sides
//! before a surface, and before it leaves through front or back, goes on from the opposite side. So blinds, films and fabrics
//! scatter as endless ones do, without the light that a finite sample loses at its edges.

use glam::DVec3;

use crate::bvh::Ray;
use crate::options::Aperture;

/// The box of one period.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    min: DVec3,
    max: DVec3,
}

impl Tile {
    /// The period that an aperture stands for.
    pub fn new(aperture: Aperture) -> Tile {
        Tile { min: DVec3::from_array(aperture.min), max: DVec3::from_array(aperture.max) }
    }

    /// Where the ray goes on in the next period, and after which distance \[m\]; `None` if it meets a surface at `hit`, or
    /// leaves through front or back, before it comes to a side.
    #[inline]
    pub fn wrapped(&self, ray: &Ray, hit: f64) -> Option<(Ray, f64)> {
        let distance = |axis: usize| {
            let (o, d) = (ray.origin[axis], ray.direction[axis]);
            if d == 0.0 {
                f64::INFINITY
            } else {
                let end = if d > 0.0 { self.max[axis] } else { self.min[axis] };
                ((end - o) / d).max(0.0)
            }
        };
        let axis = usize::from(distance(1) < distance(0));
        let t = distance(axis);
        if t >= hit || t >= distance(2) {
            return None;
        }
        let mut origin = ray.origin + t * ray.direction;
        origin[axis] = if ray.direction[axis] > 0.0 { self.min[axis] } else { self.max[axis] };
        Some((Ray { origin, direction: ray.direction, from: None }, t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: Tile = Tile { min: DVec3::new(-1.0, -2.0, -0.5), max: DVec3::new(1.0, 2.0, 0.0) };

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: DVec3::from(direction).normalize(), from: Some(3) }
    }

    #[test]
    fn rays_go_on_from_the_opposite_side() {
        let (again, t) = TILE.wrapped(&ray([0.0, 0.0, -0.1], [1.0, 0.0, -0.1]), f64::INFINITY).unwrap();
        assert!((again.origin - DVec3::new(-1.0, 0.0, -0.2)).length() < 1e-12);
        assert!((t - 1.01f64.sqrt()).abs() < 1e-12);
        assert_eq!(again.from, None);
        let (again, _) = TILE.wrapped(&ray([0.9, -1.9, -0.1], [0.01, -1.0, 0.0]), f64::INFINITY).unwrap();
        assert_eq!(again.origin.y, 2.0);
    }

    #[test]
    fn rays_that_meet_something_or_leave_first_do_not() {
        assert!(TILE.wrapped(&ray([0.0, 0.0, -0.1], [1.0, 0.0, 0.0]), 0.5).is_none());
        assert!(TILE.wrapped(&ray([0.0, 0.0, -0.1], [1.0, 0.0, 1.0]), f64::INFINITY).is_none());
        assert!(TILE.wrapped(&ray([0.0, 0.0, -0.1], [0.0, 0.0, -1.0]), f64::INFINITY).is_none());
    }
}
