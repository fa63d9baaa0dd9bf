//! Materials that are functions of two directions.
//!
//! Source: Radiance's reference manual ("Materials": plasfunc, metfunc, transfunc, BRTDfunc and the forms with data).

use std::sync::Arc;

use glam::DVec3;

use super::GlossKind;
use crate::field::{Call, FieldError, Formulas, LobeFunction, RayState, Space};

/// `plasfunc`, `metfunc`, `transfunc`, `plasdata`, `metdata`, `transdata`: as plastic, metal and trans, but what is specular
/// goes by a function.
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionGloss {
    /// Which of the three.
    pub kind: GlossKind,
    /// Red, green, blue.
    pub color: DVec3,
    /// Fraction of specularity: what the function is multiplied by where light is reflected.
    pub specular: f64,
    /// `trans`: fraction of the non-specular light that is transmitted, else 0.
    pub transmission: f64,
    /// `trans`: fraction of `transmission` that is not diffused, else 0.
    pub transmitted_specular: f64,
    /// The function, without cosine \[1/sr\].
    pub lobe: LobeFunction,
}

/// `BRTDfunc`: diffuse parts, a mirrored and an unscattered part that depend on the ray, and a function of the direction.
#[derive(Clone, Debug, PartialEq)]
pub struct BrtdFunction {
    /// Diffuse reflectance of the front and of the back.
    pub diffuse_reflection: [DVec3; 2],
    /// Diffuse transmittance.
    pub diffuse_transmission: DVec3,
    /// Coordinates and arguments of all functions.
    pub space: Arc<Space>,
    /// Red, green and blue of what is mirrored, then those of what goes straight on.
    pub specular: Formulas,
    /// Red, green and blue of the directional function \[1/sr\]; `None` where it is 0.
    pub lobe: [Option<Call>; 3],
}

impl BrtdFunction {
    /// Red, green and blue of what is mirrored, then those of what goes straight on.
    ///
    /// # Errors
    /// A function that fails, or whose value is not finite.
    pub fn specular_at(&self, ray: &RayState) -> Result<[f64; 6], FieldError> {
        self.space.values(ray, &self.specular)
    }

    /// Red, green and blue of the directional function towards the unit vector `light`, away from the surface \[1/sr\].
    ///
    /// # Errors
    /// As [`specular_at`](Self::specular_at).
    pub fn lobe_at(&self, ray: &RayState, light: DVec3) -> Result<[f64; 3], FieldError> {
        let mut rgb = [0.0; 3];
        for k in 0..3 {
            let Some(call) = &self.lobe[k] else { continue };
            // Often all three are the same function.
            let same = (0..k).find(|&j| self.lobe[j].as_ref().is_some_and(|other| other.name == call.name));
            rgb[k] = match same {
                Some(j) => rgb[j],
                None => self.space.directional(ray, call, light)?,
            };
        }
        Ok(rgb)
    }

    /// Whether red, green and blue are always the same.
    pub fn is_neutral(&self) -> bool {
        let grey = |c: DVec3| c.x == c.y && c.y == c.z;
        let texts = &self.specular.texts;
        let name = |k: usize| self.lobe[k].as_ref().map(|call| &call.name);
        self.diffuse_reflection.into_iter().chain([self.diffuse_transmission]).all(grey)
            && texts.chunks(3).all(|rgb| rgb.iter().all(|text| *text == rgb[0]))
            && (name(0), name(1)) == (name(1), name(2))
    }
}
