//! Where walks begin: on the aperture, and wherever else light of a direction meets the device.
//!
//! What leaves the device may leave past the aperture: through the sides of the device's box, or beside a smaller aperture.
//! Light sent back enters there. So light from everywhere is that through the aperture and that through the rest of the box,
//! counted in units of the flux through the aperture. A device that repeats has no rest.

use bsdftree::Side;
use bsdftree_device::Device;
use glam::DVec3;

use crate::bvh::Ray;
use crate::fold::Fold;
use crate::options::Aperture;
use crate::tile::Tile;

/// Largest number of walks through the aperture per walk through the rest of the box.
const SPARSEST: u64 = 16;

/// The aperture, and the box of what lies around it.
#[derive(Clone, Debug)]
pub(crate) struct Entrance {
    min: DVec3,
    max: DVec3,
    /// The box of the device, or `None` if all light comes through the aperture.
    bounds: Option<[DVec3; 2]>,
    /// With which the device repeats along x and y \[m\].
    periods: [Option<f64>; 2],
    fold: Fold,
}

impl Entrance {
    pub fn new(device: &Device, aperture: &Aperture, tile: Option<&Tile>) -> Entrance {
        let [min, max] = [aperture.min, aperture.max].map(DVec3::from_array);
        let bounds = if tile.is_some() { None } else { device.bounds() };
        let periods = device.periods();
        Entrance { min, max, bounds, periods, fold: Fold::new(periods, aperture) }
    }

    /// See [`Device::periods`].
    pub fn periods(&self) -> [Option<f64>; 2] {
        self.periods
    }

    /// Corners of the aperture's box.
    pub fn corners(&self) -> [DVec3; 2] {
        [self.min, self.max]
    }

    /// Area of the aperture \[m²\].
    pub fn area(&self) -> f64 {
        (self.max.x - self.min.x) * (self.max.y - self.min.y)
    }

    fn z(&self, side: Side) -> f64 {
        if side == Side::Front { self.max.z } else { self.min.z }
    }

    /// A little before the plane of the aperture, so that a ray meets also what lies in it.
    fn margin(&self) -> f64 {
        1e-6 * (self.max.x - self.min.x).min(self.max.y - self.min.y)
    }

    /// The ray through the point of the aperture that a point of the unit square stands for.
    #[inline]
    pub fn through_aperture(&self, side: Side, direction: DVec3, point: [f64; 2]) -> Ray {
        let [s, t] = self.fold.place(point);
        let [x, y] = [self.min.x + s * (self.max.x - self.min.x), self.min.y + t * (self.max.y - self.min.y)];
        let place = DVec3::new(x, y, self.z(side));
        Ray { origin: place - direction * self.margin(), direction, from: None }
    }

    /// Whether light through the aperture has met nothing before.
    pub fn is_outermost(&self, side: Side) -> bool {
        self.bounds.is_none_or(|[low, high]| match side {
            Side::Front => self.max.z >= high.z,
            Side::Back => self.min.z <= low.z,
        })
    }

    /// Flux through each face of the box that the aperture leaves open (x, y, z), in units of the flux through the aperture.
    fn rest(&self, side: Side, direction: DVec3) -> [f64; 3] {
        let Some([low, high]) = self.bounds else { return [0.0; 3] };
        let extent = high - low;
        let slope = direction / direction.z.abs().max(1e-12);
        let covered = self.is_outermost(side)
            && self.min.x <= low.x
            && self.min.y <= low.y
            && self.max.x >= high.x
            && self.max.y >= high.y;
        let faces = [
            extent.y * extent.z * slope.x.abs(),
            extent.x * extent.z * slope.y.abs(),
            if covered { 0.0 } else { extent.x * extent.y },
        ];
        faces.map(|area| area / self.area())
    }

    /// Of how many walks through the aperture one is to be joined by a walk through the rest; `None` if there is no rest.
    pub fn sparsity(&self, side: Side, direction: DVec3) -> Option<u64> {
        let rest: f64 = self.rest(side, direction).iter().sum();
        (rest > 0.0).then(|| ((1.0 / rest) as u64).clamp(1, SPARSEST).next_power_of_two())
    }

    /// A ray through the rest of the box, and its flux in units of the flux through the aperture. `None` if it also comes
    /// through the aperture.
    pub fn through_rest(&self, side: Side, direction: DVec3, [s, t]: [f64; 2]) -> Option<(Ray, f64)> {
        let [low, high] = self.bounds?;
        let rest = self.rest(side, direction);
        let total: f64 = rest.iter().sum();
        let mut place = s * total;
        let mut face = 0;
        while face < 2 && place >= rest[face] {
            place -= rest[face];
            face += 1;
        }
        let s = (place / rest[face]).min(1.0);
        let mut at = low + (high - low) * t;
        at[(face + 1) % 3] = low[(face + 1) % 3] + s * (high - low)[(face + 1) % 3];
        at[face] = if direction[face] > 0.0 { low[face] } else { high[face] };
        if self.is_outermost(side) {
            let back = at - direction * ((at.z - self.z(side)) / direction.z);
            let inside = |k: usize| (self.min[k]..=self.max[k]).contains(&back[k]);
            if inside(0) && inside(1) {
                return None;
            }
        }
        Some((Ray { origin: at - direction * self.margin(), direction, from: None }, total))
    }
}
