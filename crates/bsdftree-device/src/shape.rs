//! Surface primitives, as Radiance's reference manual defines them. Lengths in metres.

use glam::DVec3;

/// A surface primitive. The front of each is the side its normal points to.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Planar; vertices counter-clockwise seen from the front. Holes are cut by seams, as in Radiance.
    Polygon(Vec<DVec3>),
    /// `sphere` faces out, `bubble` faces in.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius, > 0.
        radius: f64,
        /// Whether the normal points to the centre.
        inward: bool,
    },
    /// `cylinder` faces out, `tube` faces in. Open ends.
    Cylinder {
        /// The two ends of the axis.
        ends: [DVec3; 2],
        /// Radius, > 0.
        radius: f64,
        /// Whether the normal points to the axis.
        inward: bool,
    },
    /// `cone` faces out, `cup` faces in. Open ends, possibly truncated.
    Cone {
        /// The two ends of the axis.
        ends: [DVec3; 2],
        /// Radius at each end, ≥ 0, not equal.
        radii: [f64; 2],
        /// Whether the normal points to the axis.
        inward: bool,
    },
    /// A disk, or a disk with a concentric hole.
    Ring {
        /// Centre.
        center: DVec3,
        /// Unit normal.
        normal: DVec3,
        /// Inner (≥ 0) and outer radius.
        radii: [f64; 2],
    },
}

impl Shape {
    /// Corners of the tight axis-aligned bounding box \[m\].
    pub fn bounds(&self) -> [DVec3; 2] {
        match self {
            Shape::Polygon(v) => {
                v.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |b, &p| [b[0].min(p), b[1].max(p)])
            }
            Shape::Sphere { center, radius, .. } => {
                [center - DVec3::splat(*radius), center + DVec3::splat(*radius)]
            }
            Shape::Cylinder { ends, radius, .. } => disks_bounds(*ends, ends[1] - ends[0], [*radius; 2]),
            Shape::Cone { ends, radii, .. } => disks_bounds(*ends, ends[1] - ends[0], *radii),
            Shape::Ring { center, normal, radii } => disks_bounds([*center; 2], *normal, [radii[1]; 2]),
        }
    }
}

/// Box around two disks that share an axis: a disk reaches r·√(1−a²) along a coordinate with axis cosine a.
fn disks_bounds(centers: [DVec3; 2], axis: DVec3, radii: [f64; 2]) -> [DVec3; 2] {
    let axis = axis.normalize_or_zero();
    let reach = (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt);
    let corner = |k: usize, sign: f64| centers[k] + reach * (sign * radii[k]);
    [corner(0, -1.0).min(corner(1, -1.0)), corner(0, 1.0).max(corner(1, 1.0))]
}
