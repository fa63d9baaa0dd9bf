//! `prism1` and `prism2`: light is sent in one direction, or two, that functions give.
//!
//! Source: Radiance's reference manual ("Materials"). Patterns and textures do not act on them.

use glam::DVec3;

use crate::field::Field;

/// A surface that sends light elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Prism {
    /// One or two.
    pub redirections: Vec<Redirection>,
}

/// One way that light is sent.
#[derive(Clone, Debug, PartialEq)]
pub struct Redirection {
    /// The fraction of light.
    pub coefficient: Field<1>,
    /// The direction, of any length.
    pub direction: Field<3>,
}

impl Prism {
    /// The same in a device that is turned by a rotation.
    pub fn turned(&self, turn: &dyn Fn(DVec3) -> DVec3) -> Prism {
        let turned = |r: &Redirection| Redirection {
            coefficient: r.coefficient.turned(turn),
            direction: r.direction.turned(turn),
        };
        Prism { redirections: self.redirections.iter().map(turned).collect() }
    }
}
