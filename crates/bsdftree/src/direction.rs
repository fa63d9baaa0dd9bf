//! Directions and the two sides of a surface.
//!
//! A direction is a unit vector `[x, y, z]` pointing **away** from the surface, the incident one too.
//! X is right seen from the front, Y is up, Z is the surface normal; front (+Z) is the room side.

/// A direction: a unit vector pointing away from the surface.
pub type Direction = [f64; 3];

/// A side of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Side {
    /// +Z, the room. WINDOW calls it *back*.
    Front,
    /// −Z, outside. WINDOW calls it *front*.
    Back,
}

impl Side {
    /// The side a direction lies on. The horizon (z = 0) counts as back, as in Radiance.
    pub fn of(direction: Direction) -> Side {
        if direction[2] > 0.0 { Side::Front } else { Side::Back }
    }

    /// The other side.
    pub fn opposite(self) -> Side {
        match self {
            Side::Front => Side::Back,
            Side::Back => Side::Front,
        }
    }

    /// +1 for front, −1 for back.
    pub fn sign(self) -> f64 {
        match self {
            Side::Front => 1.0,
            Side::Back => -1.0,
        }
    }

    /// The direction on this side over a point of the unit disk.
    pub fn direction_from_disk(self, [x, y]: [f64; 2]) -> Direction {
        [x, y, self.sign() * (1.0 - x * x - y * y).max(0.0).sqrt()]
    }
}

/// `direction` from polar angle and azimuth \[rad\]; a polar angle over π/2 gives a direction on the back.
pub fn direction_from_polar(theta: f64, phi: f64) -> Direction {
    let (sin_theta, cos_theta) = theta.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    [sin_theta * cos_phi, sin_theta * sin_phi, cos_theta]
}

/// The vector scaled to unit length, or `None` if it has no direction (zero, NaN or infinite).
pub fn normalized(v: Direction) -> Option<Direction> {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|c| c / length))
}
