//! The coordinates that functions see, and what of a ray they can ask for.
//!
//! In: a ray at a surface, in the device's coordinates and metres. Out: the channels of
//! [`cal::rayinit`](crate::cal::rayinit), in the function's coordinates and unit. Source: the variables of Radiance's
//! reference manual ("Function files"). Deviation: `S` and lengths know of the unit that the scene is in, since devices are
//! in metres; so functions see what they do in Radiance.

use std::fmt;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::{Call, FieldError, FieldProblem, Formulas};
use crate::cal::Inputs;
use crate::cal::rayinit as cal;
use crate::error::Place;

/// A ray at a surface as functions may ask for it, in the device's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayState {
    /// Unit vector along travel.
    pub direction: DVec3,
    /// Unit normal of the surface itself: on its front, or on the side of the ray, as the caller's material has it.
    pub normal: DVec3,
    /// Where \[m\].
    pub position: DVec3,
    /// Length of the ray \[m\].
    pub distance: f64,
    /// Length of the path so far \[m\].
    pub traveled: f64,
    /// Texture coordinates of a mesh.
    pub uv: [f64; 2],
    /// Unit normal after textures; for materials.
    pub perturbed_normal: DVec3,
    /// Cosine of the way back to that.
    pub perturbed_cosine: f64,
    /// Product of the patterns, times the material's colour where it has one; for materials.
    pub color: DVec3,
}

/// A file that a device needs. Equal, and the same to look at, if its content is.
#[derive(Clone)]
pub struct File {
    /// As it was found; `.` for no file.
    pub path: Arc<str>,
    /// [`digest`](super::digest) of what is in it.
    pub digest: u64,
}

/// The statement of a scene that a field stands in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The type, e.g. `brightfunc`.
    pub kind: Arc<str>,
    /// The identifier.
    pub name: Arc<str>,
    /// File and line.
    pub at: Place,
}

/// Coordinates and arguments of functions. Where they were written does not matter to equality, nor to how they look.
#[derive(Clone)]
pub struct Space {
    /// What the functions belong to.
    pub origin: Origin,
    /// Where they are defined.
    pub file: File,
    /// The real arguments A1, A2, ….
    pub arguments: Arc<[f64]>,
    /// From the device's coordinates to the function's.
    pub function_from_device: DAffine3,
    /// Units of the function in a metre, above 0.
    pub scale: f64,
    /// The scene's unit \[m\].
    pub unit: f64,
}

impl PartialEq for File {
    fn eq(&self, other: &File) -> bool {
        self.digest == other.digest
    }
}

impl fmt::Debug for File {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "File({:016x})", self.digest)
    }
}

impl PartialEq for Space {
    fn eq(&self, other: &Space) -> bool {
        (&self.file, &self.arguments, &self.function_from_device)
            == (&other.file, &other.arguments, &other.function_from_device)
            && (self.scale, self.unit) == (other.scale, other.unit)
    }
}

impl fmt::Debug for Space {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers: Vec<f64> = self.function_from_device.to_cols_array().to_vec();
        f.debug_struct("Space")
            .field("file", &self.file)
            .field("arguments", &self.arguments)
            .field("function_from_device", &numbers)
            .field("scale", &self.scale)
            .field("unit", &self.unit)
            .finish()
    }
}

impl Space {
    /// `device_from_function` multiplies lengths by `factor`.
    pub(crate) fn new(
        origin: Origin,
        file: File,
        arguments: Arc<[f64]>,
        device_from_function: DAffine3,
        factor: f64,
        unit: f64,
    ) -> Space {
        let function_from_device = device_from_function.inverse();
        Space { origin, file, arguments, function_from_device, scale: 1.0 / factor, unit }
    }

    /// A direction of the function's coordinates in the device's, its length kept.
    pub fn direction(&self, v: DVec3) -> DVec3 {
        // The inverse of a rotation, mirrored or not, times a scale.
        self.function_from_device.matrix3.transpose() * v / self.scale
    }

    /// A direction of the device's coordinates in the function's, its length kept.
    pub fn of_direction(&self, v: DVec3) -> DVec3 {
        self.function_from_device.matrix3 * v / self.scale
    }

    /// The same in a device that is turned by a rotation.
    pub fn turned(&self, turn: impl Fn(DVec3) -> DVec3) -> Space {
        // The inverse of a turn is its transpose.
        let back = DMat3::from_cols(turn(DVec3::X), turn(DVec3::Y), turn(DVec3::Z)).transpose();
        Space { function_from_device: self.function_from_device * DAffine3::from_mat3(back), ..self.clone() }
    }

    /// Values of `N` formulas for a ray at a surface.
    pub(crate) fn values<const N: usize>(
        &self,
        ray: &RayState,
        formulas: &Formulas,
    ) -> Result<[f64; N], FieldError> {
        let mut values = [0.0; N];
        match formulas.evaluate(&Seen { ray, space: self }, &mut values) {
            Ok(()) => Ok(values),
            Err(reason) => Err(self.error(reason)),
        }
    }

    /// The value of a function of a direction of the device's coordinates, and of a solid angle, which is 0.
    pub(crate) fn directional(&self, ray: &RayState, call: &Call, light: DVec3) -> Result<f64, FieldError> {
        let DVec3 { x, y, z } = self.of_direction(light);
        call.call(&[x, y, z, 0.0], &Seen { ray, space: self }).map_err(|reason| self.error(reason))
    }

    pub(super) fn error(&self, reason: FieldProblem) -> FieldError {
        FieldError { origin: self.origin.clone(), reason }
    }
}

/// A ray seen from a function.
pub(super) struct Seen<'a> {
    pub ray: &'a RayState,
    pub space: &'a Space,
}

impl Seen<'_> {
    /// Where, in the function's coordinates.
    pub fn position(&self) -> DVec3 {
        self.space.function_from_device.transform_point3(self.ray.position)
    }

    /// What is wrong where a formula has no finite value.
    pub fn no_value(&self, formula: &Arc<str>) -> FieldProblem {
        let file = self.space.file.path.clone();
        FieldProblem::NoValue { formula: formula.clone(), file, position: self.ray.position }
    }
}

impl Inputs for Seen<'_> {
    fn channel(&self, n: u32) -> f64 {
        let (ray, space) = (self.ray, self.space);
        let direction = |first: u32, v: DVec3| space.of_direction(v)[(n - first) as usize];
        match n {
            cal::DIRECTION..cal::NORMAL => direction(cal::DIRECTION, ray.direction),
            cal::NORMAL..cal::POSITION => direction(cal::NORMAL, ray.normal),
            cal::POSITION..cal::TOTAL_DISTANCE => self.position()[(n - cal::POSITION) as usize],
            cal::TOTAL_DISTANCE => ray.traveled * space.scale,
            cal::COSINE => (-ray.direction.dot(ray.normal)).clamp(-1.0, 1.0),
            cal::SCALE => space.scale * space.unit,
            cal::ORIGIN..cal::AXIS_I => space.function_from_device.translation[(n - cal::ORIGIN) as usize],
            cal::AXIS_I..cal::AXIS_J => direction(cal::AXIS_I, DVec3::X),
            cal::AXIS_J..cal::AXIS_K => direction(cal::AXIS_J, DVec3::Y),
            cal::AXIS_K..cal::RAY_DISTANCE => direction(cal::AXIS_K, DVec3::Z),
            cal::RAY_DISTANCE => ray.distance * space.scale,
            cal::MESH_UV..cal::PERTURBED_NORMAL => ray.uv[(n - cal::MESH_UV) as usize],
            cal::PERTURBED_NORMAL..cal::PERTURBED_COSINE => {
                direction(cal::PERTURBED_NORMAL, ray.perturbed_normal)
            }
            cal::PERTURBED_COSINE => ray.perturbed_cosine.clamp(-1.0, 1.0),
            cal::PERTURBED_COLOR..cal::SOURCE_DIRECTION => ray.color[(n - cal::PERTURBED_COLOR) as usize],
            _ => 0.0,
        }
    }

    fn argument(&self, n: u32) -> f64 {
        match n {
            0 => self.space.arguments.len() as f64,
            n => self.space.arguments.get(n as usize - 1).copied().unwrap_or(0.0),
        }
    }
}
