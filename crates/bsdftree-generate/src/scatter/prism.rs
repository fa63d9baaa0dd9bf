//! `prism1`, `prism2`: each ray is sent where functions say.
//!
//! In: a meeting. Out: one of the directions, taken with the probability of its coefficient, or nothing. A direction may be on
//! either side. Patterns and textures do nothing. Source: Radiance's reference manual and `rtrace`, observed: a coefficient that is
//! not positive sends nothing, and its direction is not worked out; the direction to the light source (DxA, DyA, DzA) is 0, as for
//! rays that no source has sent. Deviation: two coefficients that sum up to more than 1 are scaled down to that.

use std::sync::Arc;

use bsdftree_device::field::RayState;
use bsdftree_device::material::Prism;
use glam::DVec3;

use super::faults::Watch;
use super::shading::{Shade, Shading, ray_state};
use super::{Meeting, Scatter, Spectrum};
use crate::random::Random;

/// A prism ready to scatter.
#[derive(Clone, Debug)]
pub(super) struct PreparedPrism {
    pub prism: Arc<Prism>,
    pub watch: Watch,
}

impl PreparedPrism {
    /// The coefficient of each redirection, at least 0, the second one 0 if there is but one; at most 1 together.
    fn coefficients(&self, ray: &RayState) -> Option<[f64; 2]> {
        let mut coefficients = [0.0; 2];
        for (coefficient, redirection) in coefficients.iter_mut().zip(&self.prism.redirections) {
            let [value] = self.watch.checked(redirection.coefficient.at(ray))?;
            *coefficient = value.max(0.0);
        }
        let total: f64 = coefficients.iter().sum();
        self.watch.see_albedo(total);
        Some(if total > 1.0 { coefficients.map(|c| c / total) } else { coefficients })
    }
}

impl<S: Spectrum> Shading<S> for PreparedPrism {
    fn scatter(&self, meeting: &Meeting, _: &Shade<S>, random: &mut Random) -> Option<Scatter<S>> {
        let ray = ray_state(meeting);
        let [first, second] = self.coefficients(&ray)?;
        let total = first + second;
        if total <= 0.0 {
            return None;
        }
        let chosen = usize::from(random.next_open() * total >= first);
        let direction = self.watch.checked(self.prism.redirections[chosen].direction.vector(&ray))?;
        let direction: DVec3 = direction.try_normalize()?;
        let crossed = (direction.dot(meeting.normal) > 0.0) != meeting.is_front();
        Some(Scatter { direction, weight: S::WHITE * total, transmitted: crossed })
    }
}
