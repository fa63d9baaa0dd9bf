//! Spheres, cylinders, cones and rings, met analytically in f64.
//!
//! Enters: a shape in the local frame. Leaves: distance along a ray, outward normal at a point.
//! Invariant: a ray that has left the surface meets it again only at the other root, found with the first root set to
//! exactly zero. Source: Haines et al., "Precision Improvements for Ray/Sphere Intersection", *Ray Tracing Gems*, ch. 7
//! (solve next to the shape, not at the origin). Deviation: the same step is used for cylinders and cones, which are one
//! family: radius(h) = r₀ + k·h along the axis.

use glam::DVec3;

/// A curved or round surface in the local frame.
#[derive(Clone, Debug)]
pub(super) enum Analytic {
    Sphere { center: DVec3, radius: f64, inward: bool },
    Taper { base: DVec3, axis: DVec3, length: f64, radius: f64, slope: f64, inward: bool },
    Ring { center: DVec3, normal: DVec3, radii_squared: [f64; 2] },
}

/// The ray of a query and what bounds the answer.
#[derive(Clone, Copy)]
pub(super) struct Query {
    pub origin: DVec3,
    pub direction: DVec3,
    pub t_max: f64,
    /// The ray has just left this very surface.
    pub leaving: bool,
    /// See [`Facet::hit`](super::facet::Facet::hit).
    pub on_plane: f64,
    pub slack: f64,
}

impl Query {
    fn in_range(&self, t: f64) -> bool {
        t >= 0.0 && t <= self.t_max && (t > 0.0 || !self.leaving)
    }
}

impl Analytic {
    /// Distance of the first point of the surface along the ray, if within range.
    pub fn hit(&self, q: &Query) -> Option<f64> {
        match self {
            Analytic::Sphere { center, radius, .. } => sphere(q, *center, *radius),
            Analytic::Taper { .. } => self.taper(q),
            Analytic::Ring { center, normal, radii_squared } => ring(q, *center, *normal, *radii_squared),
        }
    }

    /// Unit normal of the front at a point of the surface.
    pub fn normal(&self, p: DVec3) -> DVec3 {
        match self {
            Analytic::Sphere { inward: true, .. } | Analytic::Taper { inward: true, .. } => -self.outward(p),
            _ => self.outward(p),
        }
    }

    /// Away from centre or axis; a ring's own.
    fn outward(&self, p: DVec3) -> DVec3 {
        match self {
            Analytic::Sphere { center, .. } => (p - center).normalize_or(DVec3::Z),
            Analytic::Taper { base, axis, slope, .. } => {
                let from_base = p - base;
                let radial = (from_base - axis * from_base.dot(*axis)).normalize_or_zero();
                (radial - axis * *slope).normalize_or(*axis)
            }
            Analytic::Ring { normal, .. } => *normal,
        }
    }

    /// `p`, moved along the surface to be at least `inset` from its rims: see [`Facet::inset`](super::facet::Facet::inset).
    pub fn inset(&self, p: DVec3, inset: f64) -> DVec3 {
        match self {
            Analytic::Sphere { .. } => p,
            Analytic::Taper { base, axis, length, slope, .. } => {
                let from_base = p - base;
                let h = from_base.dot(*axis);
                let radial = (from_base - axis * h).normalize_or_zero();
                let inset = inset.min(0.5 * length);
                p + (axis + radial * *slope) * (h.clamp(inset, length - inset) - h)
            }
            Analytic::Ring { center, radii_squared, .. } => {
                let [inner, outer] = radii_squared.map(f64::sqrt);
                let (radial, r) = (p - center).normalize_and_length();
                let middle = 0.5 * (inner + outer);
                let low = if inner > 0.0 { (inner + inset).min(middle) } else { 0.0 };
                p + radial * (r.clamp(low, (outer - inset).max(middle)) - r)
            }
        }
    }

    fn taper(&self, q: &Query) -> Option<f64> {
        let Analytic::Taper { base, axis, length, radius, slope, .. } = self else {
            unreachable!("only tapers")
        };
        let d_axis = q.direction.dot(*axis);
        let d_across = q.direction - axis * d_axis;
        let a_across = d_across.length_squared();
        let from_base = q.origin - base;
        // Solve where the ray is nearest to the axis: there the terms of the quadratic are as small as they get.
        let nearest = -d_across.dot(from_base) / a_across;
        let shift = if q.leaving || !nearest.is_finite() { 0.0 } else { nearest.clamp(-8.0, 8.0) };
        let start = from_base + q.direction * shift;
        let h = start.dot(*axis);
        let across = start - axis * h;
        let r = radius + slope * h;
        let a = a_across - (slope * d_axis).powi(2);
        let half_b = d_across.dot(across) - slope * d_axis * r;
        let c = if q.leaving { 0.0 } else { (across.length() - r) * (across.length() + r) };
        let discriminant = half_b * half_b - a * c;
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let sum = -(half_b + discriminant.sqrt().copysign(half_b));
        let on_stump = |t: f64| {
            let h = h + (t - shift) * d_axis;
            q.in_range(t) && h >= -q.slack && h <= length + q.slack
        };
        let far = shift + sum / a;
        if q.leaving {
            return Some(far).filter(|&t| on_stump(t));
        }
        let near = shift + c / sum;
        match (on_stump(near), on_stump(far)) {
            (true, true) => Some(near.min(far)),
            (true, false) => Some(near),
            (false, true) => Some(far),
            (false, false) => None,
        }
    }
}

fn sphere(q: &Query, center: DVec3, radius: f64) -> Option<f64> {
    let nearest = (center - q.origin).dot(q.direction);
    if q.leaving {
        return Some(2.0 * nearest).filter(|&t| q.in_range(t));
    }
    let miss = q.origin + q.direction * nearest - center;
    let half_chord = (radius * radius - miss.length_squared()).sqrt();
    [nearest - half_chord, nearest + half_chord].into_iter().find(|&t| q.in_range(t))
}

fn ring(q: &Query, center: DVec3, normal: DVec3, radii_squared: [f64; 2]) -> Option<f64> {
    let height = (center - q.origin).dot(normal);
    let t = height / q.direction.dot(normal);
    if q.leaving || height.abs() < q.on_plane || !q.in_range(t) {
        return None;
    }
    let squared = (q.origin + q.direction * t - center).length_squared();
    (squared >= radii_squared[0] && squared <= radii_squared[1]).then_some(t)
}
