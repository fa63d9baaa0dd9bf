//! Points spread evenly over the surfaces that have diffuse lobes.
//!
//! In: a device, the box of one period if it repeats. Out: points of equal shares of area, each with normal and surface. They
//! measure areas of patches by counting, and are where light leaves a patch.
//! Source of the even spread: the additive sequence of the plastic number, M. Roberts, "The unreasonable effectiveness of
//! quasirandom sequences" (2018).

use bsdftree_device::{Device, Shape};
use glam::DVec3;

use crate::bvh::Bvh;

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub position: DVec3,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// See [`Hit::part`](crate::bvh::Hit::part).
    pub part: u32,
}

/// Points, each of which stands for the same area.
pub(crate) struct Points {
    pub points: Vec<Point>,
    /// \[m²\].
    pub area_each: f64,
}

/// What is sampled at once.
enum Element<'a> {
    Triangle { corner: DVec3, edges: [DVec3; 2], normal: DVec3 },
    Round(&'a Shape),
}

/// Most points tried for one that lies inside the box.
const MAX_TRIES: usize = 32;

impl Points {
    /// About `count` points on the surfaces that `wanted` holds for.
    pub fn spread(
        device: &Device,
        bvh: &Bvh,
        period: Option<[DVec3; 2]>,
        count: usize,
        wanted: impl Fn(u32) -> bool,
    ) -> Points {
        let mut elements = Vec::new();
        for (surface, s) in device.surfaces.iter().enumerate().filter(|(_, s)| wanted(s.material)) {
            let surface = surface as u32;
            let mut add = |triangle, part| {
                let pieces = period.map_or_else(|| vec![triangle], |b| clipped(triangle, b));
                elements.extend(pieces.into_iter().map(|t| (Element::triangle(t), part)));
            };
            if let Shape::Polygon(_) = s.shape {
                s.shape.triangulate().into_iter().for_each(|triangle| add(triangle, surface));
            } else if let Shape::Mesh(mesh) = &s.shape {
                mesh.solid().for_each(|(k, triangle)| add(triangle, bvh.part(surface, k)));
            } else if period.is_none_or(|b| meets(s.shape.bounds(), b)) {
                elements.push((Element::Round(&s.shape), surface));
            }
        }
        let mut ends = Vec::with_capacity(elements.len());
        let mut total = 0.0;
        for (element, _) in &elements {
            total += element.area();
            ends.push(total);
        }
        let mut tries = count;
        loop {
            let mut points = Vec::with_capacity(tries);
            let mut index = 0;
            for k in 0..tries {
                let place = (k as f64 + 0.5) / tries as f64 * total;
                while index < ends.len() && ends[index] <= place {
                    index += 1;
                }
                let Some((element, part)) = elements.get(index) else { break };
                let (position, normal) = element.at(spread_over_square(k));
                let inside = match (element, period) {
                    (Element::Round(_), Some(period)) => contains(period, position),
                    _ => true,
                };
                if inside {
                    points.push(Point { position, normal, part: *part });
                }
            }
            if points.len() * 2 >= count || tries >= count * MAX_TRIES || points.is_empty() {
                return Points { area_each: total / tries as f64, points };
            }
            tries = (tries * count / points.len()).min(count * MAX_TRIES);
        }
    }
}

/// Point k of the additive sequence of the plastic number, by fractions of 2⁻³².
fn spread_over_square(k: usize) -> [f64; 2] {
    const STEPS: [u32; 2] = [0xc13f_a9a9, 0x91e1_0da6];
    STEPS.map(|step| f64::from(step.wrapping_mul(k as u32)) * (0.5 / f64::from(1u32 << 31)))
}

impl Element<'_> {
    fn triangle([a, b, c]: [DVec3; 3]) -> Self {
        let edges = [b - a, c - a];
        Element::Triangle { corner: a, edges, normal: edges[0].cross(edges[1]).normalize_or_zero() }
    }

    fn area(&self) -> f64 {
        match self {
            Element::Triangle { edges: [a, b], .. } => 0.5 * a.cross(*b).length(),
            Element::Round(shape) => shape.area(),
        }
    }

    /// The point that a point of the unit square stands for, evenly by area, and the normal there.
    fn at(&self, [u, v]: [f64; 2]) -> (DVec3, DVec3) {
        let shape = match self {
            Element::Triangle { corner, edges: [a, b], normal } => {
                let r = u.sqrt();
                return (*corner + *a * (r * (1.0 - v)) + *b * (r * v), *normal);
            }
            Element::Round(shape) => *shape,
        };
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * v);
        match shape {
            Shape::Sphere { center, radius, inward } => {
                let z = 1.0 - 2.0 * u;
                let r = (1.0 - z * z).max(0.0).sqrt();
                let outward = DVec3::new(r * cos, r * sin, z);
                (center + outward * *radius, if *inward { -outward } else { outward })
            }
            Shape::Cylinder { ends, radius, inward } => taper(*ends, [*radius; 2], *inward, u, [cos, sin]),
            Shape::Cone { ends, radii, inward } => taper(*ends, *radii, *inward, u, [cos, sin]),
            Shape::Ring { center, normal, radii: [inner, outer] } => {
                let r = (inner * inner + (outer * outer - inner * inner) * u).sqrt();
                let normal = normal.normalize();
                let (a, b) = normal.any_orthonormal_pair();
                (center + (a * cos + b * sin) * r, normal)
            }
            Shape::Polygon(_) | Shape::Mesh(_) => unreachable!("these are triangles here"),
        }
    }
}

fn taper(ends: [DVec3; 2], radii: [f64; 2], inward: bool, u: f64, [cos, sin]: [f64; 2]) -> (DVec3, DVec3) {
    let along = ends[1] - ends[0];
    let axis = along.normalize();
    let (a, b) = axis.any_orthonormal_pair();
    let radial = a * cos + b * sin;
    let difference = radii[1] - radii[0];
    let radius = (radii[0] * radii[0] + (radii[1] * radii[1] - radii[0] * radii[0]) * u).sqrt();
    let t = if difference == 0.0 { u } else { (radius - radii[0]) / difference };
    let outward = (radial - axis * (difference / along.length())).normalize();
    (ends[0] + along * t + radial * radius, if inward { -outward } else { outward })
}

fn meets(a: [DVec3; 2], b: [DVec3; 2]) -> bool {
    a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all()
}

fn contains([low, high]: [DVec3; 2], p: DVec3) -> bool {
    low.cmple(p).all() && p.cmple(high).all()
}

/// The part of a triangle in a box, as triangles turned the same way (Sutherland and Hodgman).
fn clipped(triangle: [DVec3; 3], [low, high]: [DVec3; 2]) -> Vec<[DVec3; 3]> {
    let mut outline = triangle.to_vec();
    for axis in 0..3 {
        for (sign, end) in [(1.0, low[axis]), (-1.0, high[axis])] {
            let depth = |p: DVec3| sign * (p[axis] - end);
            let mut kept = Vec::with_capacity(outline.len() + 1);
            for (k, &p) in outline.iter().enumerate() {
                let q = outline[(k + 1) % outline.len()];
                if depth(p) >= 0.0 {
                    kept.push(p);
                }
                if (depth(p) > 0.0 && depth(q) < 0.0) || (depth(p) < 0.0 && depth(q) > 0.0) {
                    kept.push(p + (q - p) * (depth(p) / (depth(p) - depth(q))));
                }
            }
            outline = kept;
        }
    }
    if outline.len() < 3 {
        return Vec::new();
    }
    (1..outline.len() - 1).map(|k| [outline[0], outline[k], outline[k + 1]]).collect()
}
