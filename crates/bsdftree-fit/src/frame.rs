//! Frames: where light that left towards o for one incident direction leaves for another.
//!
//! A lobe that is looked up at moved directions keeps its shape while its place changes, which blending at fixed directions would
//! smear into two. Which frame fits depends on what scatters: none is right for all, so cross-validation chooses
//! ([`crate::choose`]). All directions are on the upper hemisphere; those of transmission are mirrored there first, so the mirror
//! direction m = (−i_x, −i_y, i_z) is also where light goes straight through.

use crate::lambert::Ray;

/// How directions move with the incident one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// They stay: what scatters the same way whatever comes in.
    Fixed,
    /// By the change of the tangential part of i, as gratings and prisms with small angles do.
    Shift,
    /// With the turn that takes the mirror direction of one to that of the other.
    Rotation,
    /// As mirrors of a rough surface: the half vector stays, and f·cos θ_i·cos θ_o is blended instead of f.
    Half,
    /// Each lobe with its own centre, as those of prisms do.
    Lobes,
}

impl Frame {
    /// All of them.
    pub const ALL: [Frame; 5] = [Frame::Fixed, Frame::Shift, Frame::Rotation, Frame::Half, Frame::Lobes];

    /// As tables print it.
    pub fn name(self) -> &'static str {
        match self {
            Frame::Fixed => "fixed",
            Frame::Shift => "shift",
            Frame::Rotation => "rotation",
            Frame::Half => "half-vector",
            Frame::Lobes => "lobes",
        }
    }
}

/// A cosine below which nothing is divided: tan θ is 20 there.
pub(crate) const LEAST_COSINE: f32 = 0.05;

/// One frame between two incident directions.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Motion {
    Stay,
    Shift([f32; 2]),
    Turn([Ray; 3]),
    Reflect { incident: Ray, other: Ray },
}

impl Motion {
    /// From light that comes from `incident` to light that comes from `other`.
    pub fn new(frame: Frame, incident: Ray, other: Ray) -> Motion {
        match frame {
            Frame::Fixed => Motion::Stay,
            Frame::Shift => Motion::Shift([incident[0] - other[0], incident[1] - other[1]]),
            Frame::Rotation => Motion::Turn(turn(mirrored(incident), mirrored(other))),
            Frame::Half => Motion::Reflect { incident, other },
            Frame::Lobes => Motion::Stay,
        }
    }

    /// With the turn that takes one direction to another.
    pub fn between(center: Ray, other: Ray) -> Motion {
        Motion::Turn(turn(center, other))
    }

    /// Where what goes to `o` goes there; perhaps below the horizon.
    #[inline(always)]
    pub fn apply(&self, o: Ray) -> Ray {
        match self {
            Motion::Stay => o,
            Motion::Shift(by) => {
                let (x, y) = (o[0] + by[0], o[1] + by[1]);
                let r2 = x * x + y * y;
                if r2 <= 1.0 {
                    [x, y, (1.0 - r2).sqrt()]
                } else {
                    let r = r2.sqrt();
                    let z = -(1.0 - (2.0 - r).max(0.0).powi(2)).max(0.0).sqrt();
                    let scale = (1.0 - z * z).sqrt() / r;
                    [x * scale, y * scale, z]
                }
            }
            Motion::Turn(rows) => rows.map(|row| dot(row, o)),
            Motion::Reflect { incident, other } => Reflect::new(*incident, o).of(*other),
        }
    }
}

/// A mirror at the half vector of a pair of directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reflect {
    half: Ray,
    /// Twice the half vector over its squared length.
    twice: Ray,
}

impl Reflect {
    #[inline(always)]
    pub fn new(incident: Ray, o: Ray) -> Reflect {
        let half = [o[0] + incident[0], o[1] + incident[1], o[2] + incident[2]];
        let scale = 2.0 / dot(half, half).max(1e-12);
        Reflect { half, twice: half.map(|x| scale * x) }
    }

    /// Where light from another direction leaves for.
    #[inline(always)]
    pub fn of(&self, other: Ray) -> Ray {
        let along = dot(self.half, other);
        let [x, y, z] = self.twice;
        [along * x - other[0], along * y - other[1], along * z - other[2]]
    }
}

#[inline(always)]
fn dot(a: Ray, b: Ray) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn mirrored([x, y, z]: Ray) -> Ray {
    [-x, -y, z]
}

/// The smallest turn that takes one direction to another, as rows of its matrix (Rodrigues).
fn turn(from: Ray, to: Ray) -> [Ray; 3] {
    let c = dot(from, to);
    let v = [
        from[1] * to[2] - from[2] * to[1],
        from[2] * to[0] - from[0] * to[2],
        from[0] * to[1] - from[1] * to[0],
    ];
    let k = 1.0 / (1.0 + c).max(1e-6);
    [
        [c + k * v[0] * v[0], k * v[0] * v[1] - v[2], k * v[0] * v[2] + v[1]],
        [k * v[1] * v[0] + v[2], c + k * v[1] * v[1], k * v[1] * v[2] - v[0]],
        [k * v[2] * v[0] - v[1], k * v[2] * v[1] + v[0], c + k * v[2] * v[2]],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_but_fixed_take_mirror_directions_to_mirror_directions() {
        let (a, b): (Ray, Ray) = ([0.6, 0.0, 0.8], [0.0, 0.28, 0.96]);
        for frame in [Frame::Shift, Frame::Rotation, Frame::Half] {
            let moved = Motion::new(frame, a, b).apply(mirrored(a));
            let expected = mirrored(b);
            assert!((0..3).all(|d| (moved[d] - expected[d]).abs() < 1e-5), "{frame:?} {moved:?}");
        }
    }
}
