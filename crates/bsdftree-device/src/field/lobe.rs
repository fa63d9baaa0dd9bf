//! The directional function of a material: what `plasfunc`, `metfunc`, `transfunc`, `BRTDfunc` and their data forms reflect or
//! transmit towards a direction \[1/sr\].
//!
//! In: a ray at a surface and a direction away from it. Out: a number. Source: Radiance's reference manual ("Materials").
//! Deviation: functions are given a solid angle of 0 for the light, as that of a direction; Radiance gives them that of each source.

use std::sync::Arc;

use glam::DVec3;

use super::data::DataArray;
use super::formula::Call;
use super::space::{RayState, Seen, Space};
use super::{FieldError, FieldProblem};

/// A function of the direction that light is scattered to.
#[derive(Clone, Debug, PartialEq)]
pub struct LobeFunction {
    /// Coordinates and arguments of the functions.
    pub space: Arc<Space>,
    /// What is called: with the direction (x, y, z) and a solid angle; after the value of the data, if there are data.
    pub function: Call,
    /// Data and the functions of the direction that give their coordinates.
    pub data: Option<(Arc<DataArray>, Vec<Call>)>,
}

impl LobeFunction {
    /// The value towards the unit vector `light`, which points away from the surface.
    ///
    /// # Errors
    /// A function that fails, or whose value is not finite.
    pub fn at(&self, ray: &RayState, light: DVec3) -> Result<f64, FieldError> {
        let seen = Seen { ray, space: &self.space };
        self.value(&seen, light).map_err(|reason| self.space.error(reason))
    }

    /// The same in a device that is turned by a rotation.
    pub fn turned(&self, turn: impl Fn(DVec3) -> DVec3) -> LobeFunction {
        LobeFunction { space: Arc::new(self.space.turned(turn)), ..self.clone() }
    }

    fn value(&self, seen: &Seen, light: DVec3) -> Result<f64, FieldProblem> {
        let DVec3 { x, y, z } = self.space.of_direction(light);
        match &self.data {
            None => self.function.call(&[x, y, z, 0.0], seen),
            Some((data, coordinates)) => {
                let mut point = [0.0; DataArray::MOST_DIMENSIONS];
                for (p, call) in point.iter_mut().zip(coordinates) {
                    *p = call.call(&[x, y, z, 0.0], seen)?;
                }
                let found = data.value(&point[..coordinates.len()]);
                self.function.call(&[found, x, y, z, 0.0], seen)
            }
        }
    }
}
