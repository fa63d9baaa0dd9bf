//! Where a peak goes as a function of where its light comes from.
//!
//! Facets bend light along their normal: a mirror by 2(i·n)n, refraction by whatever keeps the length of the *optical
//! vector*, the direction of travel times the index of refraction. A flat face of the device keeps x and y of that
//! vector, so inside a panel of index N it is (x, y, ±√(N² − x² − y²)). (Vector form of Snell's law: M. Born, E.
//! Wolf, Principles of Optics, § 1.5.)

use crate::direction::{Direction, Side};

/// Where a peak goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Map {
    /// o = −i: straight through.
    Straight,
    /// o = (−x, −y, z): reflected in the plane of the device.
    Mirror,
    /// o = i: back to where it came from.
    Retro,
    /// o = −i + 2(i·n)n: reflected in facets of this normal, in whichever direction it points.
    Facet {
        /// Unit, z ≥ 0.
        normal: Direction,
    },
    /// o = i − 2(i·a)a: back across right-angled grooves along this axis, onward along them.
    Groove {
        /// Unit, z ≥ 0.
        axis: Direction,
    },
    /// Refracted by a flat face and by facets of this normal on the other side.
    Prism {
        /// Unit, z ≥ 0.
        normal: Direction,
        /// Index of refraction.
        index: f64,
        /// Whether light enters through the flat face.
        flat_first: bool,
    },
    /// Refracted by a flat face, reflected inside by facets of this normal, and out through the flat face again.
    InnerFacet {
        /// Unit, z ≥ 0.
        normal: Direction,
        /// Index of refraction.
        index: f64,
    },
    /// (o.x, o.y) = (−i.x, −i.y) + shift: orders of gratings.
    Shift {
        /// In direction cosines.
        cosines: [f64; 2],
    },
    /// None of these: only the directions themselves are known.
    Table,
}

impl Map {
    /// Its name for programs: `straight`, `mirror`, `retro`, `facet`, `groove`, `prism`, `inner_facet`, `shift` or
    /// `table`.
    pub fn name(&self) -> &'static str {
        match self {
            Map::Straight => "straight",
            Map::Mirror => "mirror",
            Map::Retro => "retro",
            Map::Facet { .. } => "facet",
            Map::Groove { .. } => "groove",
            Map::Prism { .. } => "prism",
            Map::InnerFacet { .. } => "inner_facet",
            Map::Shift { .. } => "shift",
            Map::Table => "table",
        }
    }

    /// Where light from a direction goes, if the map sends it to that side.
    pub fn exitant(&self, incident: Direction, side: Side) -> Option<Direction> {
        let vector = self.vector(incident, side)?;
        if self.leaves_flat() { disk_direction([vector[0], vector[1]], side) } else { Some(vector) }
    }

    /// Direction cosines x and y of where light from a direction goes, if the map sends it to that side. Beyond the unit circle the flat
    /// face that it would leave by reflects it totally, and they say by how much.
    pub fn cosines(&self, incident: Direction, side: Side) -> Option<[f64; 2]> {
        self.vector(incident, side).map(|[x, y, _]| [x, y])
    }

    /// The fraction of unpolarized light that the two faces of a prism let through, with direction cosines of where it leaves
    /// (Fresnel; of other maps 1).
    pub fn transmittance(&self, incident: Direction, [x, y]: [f64; 2]) -> f64 {
        let Map::Prism { normal, index, flat_first } = *self else { return 1.0 };
        let leaving = (1.0 - x * x - y * y).max(0.0).sqrt();
        let (flat, facet) = match flat_first {
            true => (incident[2].abs(), dot([x, y, leaving.copysign(-incident[2])], normal).abs()),
            false => (leaving, dot(incident, normal).abs()),
        };
        transmittance(index, flat) * transmittance(index, facet)
    }

    /// Whether it leaves through the plane of the device, which keeps x and y of the optical vector.
    fn leaves_flat(&self) -> bool {
        matches!(self, Map::Prism { flat_first: false, .. } | Map::InnerFacet { .. } | Map::Shift { .. })
    }

    /// The optical vector of what leaves to a side; before a flat last face.
    fn vector(&self, incident: Direction, side: Side) -> Option<Direction> {
        let [x, y, z] = incident;
        let travel = incident.map(|c| -c);
        let vector = match *self {
            Map::Straight => travel,
            Map::Mirror => [-x, -y, z],
            Map::Retro => incident,
            Map::Facet { normal } => reflected(travel, normal),
            Map::Groove { axis } => reflected(incident, axis),
            Map::Prism { normal, index, flat_first: true } => {
                // Out of the facet: the part along the normal shrinks with the squared length, N² to 1.
                let inside = optical([-x, -y], index, travel[2].signum());
                bent(inside, normal, 1.0 - index * index)?
            }
            Map::Prism { normal, index, flat_first: false } => bent(travel, normal, index * index - 1.0)?,
            Map::InnerFacet { normal, index } => {
                reflected(optical([-x, -y], index, travel[2].signum()), normal)
            }
            Map::Shift { cosines: [a, b] } => [a - x, b - y, side.sign()],
            Map::Table => return None,
        };
        (vector[2] * side.sign() > 0.0).then_some(vector)
    }
}

/// The optical vector inside a panel of light whose x and y its flat face keeps.
pub(super) fn optical([x, y]: [f64; 2], index: f64, sign: f64) -> Direction {
    [x, y, sign * (index * index - x * x - y * y).max(0.0).sqrt()]
}

fn dot(a: Direction, b: Direction) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn along(a: Direction, t: f64, b: Direction) -> Direction {
    std::array::from_fn(|k| a[k] + t * b[k])
}

/// An optical vector reflected in a face of this normal.
pub fn reflected(travel: Direction, normal: Direction) -> Direction {
    along(travel, -2.0 * dot(travel, normal), normal)
}

/// The optical vector with its part along the normal changed so that its squared length grows by `growth`, the difference of squared
/// indices; `None` if it is reflected totally.
pub fn bent(vector: Direction, normal: Direction, growth: f64) -> Option<Direction> {
    let part = dot(vector, normal);
    let square = part * part + growth;
    (square > 0.0).then(|| along(vector, square.sqrt().copysign(part) - part, normal))
}

/// Transmittance of a face to unpolarized light, by the cosine on the outside (Fresnel).
pub fn transmittance(index: f64, outside: f64) -> f64 {
    let c = outside.min(1.0);
    let inside = (1.0 - (1.0 - c * c) / (index * index)).sqrt();
    let s = (c - index * inside) / (c + index * inside);
    let p = (index * c - inside) / (index * c + inside);
    1.0 - 0.5 * (s * s + p * p)
}

fn disk_direction(disk: [f64; 2], side: Side) -> Option<Direction> {
    (disk[0].hypot(disk[1]) < 1.0).then(|| side.direction_from_disk(disk))
}
