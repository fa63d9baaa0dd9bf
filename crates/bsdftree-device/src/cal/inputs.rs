//! What a formula takes from outside: the channels of a ray and the real arguments of a primitive.

/// Where the values come from that a formula does not compute.
pub trait Inputs {
    /// Channel `$n`; the numbers are those of [`super::rayinit`]. Channels that there are not are 0.
    fn channel(&self, n: u32) -> f64;

    /// Real argument `A1`, `A2`, …; `argument(0)` is how many there are, and others are not asked for.
    fn argument(&self, n: u32) -> f64;
}

/// Nothing at all, for constants.
impl Inputs for () {
    fn channel(&self, _: u32) -> f64 {
        0.0
    }

    fn argument(&self, _: u32) -> f64 {
        0.0
    }
}

/// Real arguments without a ray.
impl Inputs for [f64] {
    fn channel(&self, _: u32) -> f64 {
        0.0
    }

    fn argument(&self, n: u32) -> f64 {
        if n == 0 { self.len() as f64 } else { self[n as usize - 1] }
    }
}

/// What a formula can depend on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uses {
    /// Bit n for channel n; the last one for all beyond.
    channels: u64,
    arguments: bool,
}

impl Uses {
    /// Nothing: the value is a constant.
    pub fn is_empty(self) -> bool {
        self == Uses::default()
    }

    /// Real arguments `A1`, …, or their number.
    pub fn arguments(self) -> bool {
        self.arguments
    }

    /// Channel `n`.
    pub fn channel(self, n: u32) -> bool {
        self.channels & bit(n) != 0
    }

    /// Any channel: with none, the value is the same for all rays that meet the same primitive.
    pub fn any_channel(self) -> bool {
        self.channels != 0
    }

    /// The direction of the ray, as such, by its cosine, or relative to the normal.
    pub fn direction(self) -> bool {
        use super::rayinit::{COSINE, DIRECTION, PERTURBED_COSINE};
        (DIRECTION..DIRECTION + 3).chain([COSINE, PERTURBED_COSINE]).any(|n| self.channel(n))
    }

    /// The place where the ray meets the surface, or its coordinates on a mesh.
    pub fn position(self) -> bool {
        use super::rayinit::{MESH_UV, POSITION};
        (POSITION..POSITION + 3).chain(MESH_UV..MESH_UV + 2).any(|n| self.channel(n))
    }

    pub(super) fn add(&mut self, other: Uses) {
        self.channels |= other.channels;
        self.arguments |= other.arguments;
    }

    pub(super) fn of_channel(n: u32) -> Self {
        Uses { channels: bit(n), arguments: false }
    }

    pub(super) fn of_arguments() -> Self {
        Uses { channels: 0, arguments: true }
    }
}

fn bit(channel: u32) -> u64 {
    1 << channel.min(63)
}
