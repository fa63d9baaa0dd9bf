//! Venetian blinds: slats along X, flat or curved, of one surface or solid, with an optional pane outside.
//!
//! The angle is that of Radiance's `genblinds` with its +X edge turned to the room: 0 is horizontal, and a positive
//! angle raises the edge on the room side. The foremost points of the slats are at z = 0. Slats that would cut
//! each other or interlock are refused. Deviation from `genblinds`: curvature is given by the rise of the middle above the chord
//! (positive: arched upwards, its `+r`), so `depth` is the chord and the number of facets is a parameter.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3, dvec2};

use super::builder::{Builder, plastic};
use super::family::{Domain, Family, Parameter, Values};
use crate::device::Device;
use crate::material::{Material, transmissivity_from_transmittance};

pub(super) const FAMILY: Family = Family {
    name: "blinds",
    summary: "venetian blinds, flat or curved, with an optional pane outside",
    drawing: r"
     +Y   outside              room
      |    | pane     _____
      |    |      __--          positive angle: the edge
      |    |    --      ^       on the room side is raised
      |    | gap        | spacing
      |    |<-->      __v__
      |    |      __--
      |    |    --
      |    |    |<-depth->|     (along the slat)
      +------------------------ +Z
",
    parameters: &[
        Parameter {
            name: "depth",
            unit: "m",
            domain: Domain::length(0.05),
            meaning: "width of a slat, from edge to edge",
        },
        Parameter {
            name: "spacing",
            unit: "m",
            domain: Domain::length(0.04),
            meaning: "distance of two slats along Y",
        },
        Parameter {
            name: "angle",
            unit: "deg",
            domain: Domain::Number { default: 0.0, least: -90.0, most: 90.0 },
            meaning: "tilt; positive raises the edge on the room side",
        },
        Parameter {
            name: "rise",
            unit: "m",
            domain: Domain::Number { default: 0.0, least: -50.0, most: 50.0 },
            meaning: "height of the curved slat's middle above its edges; 0 is flat, at most depth/2",
        },
        Parameter {
            name: "facets",
            unit: "",
            domain: Domain::Number { default: 8.0, least: 1.0, most: 360.0 },
            meaning: "flat pieces that a curved slat is made of",
        },
        Parameter {
            name: "thickness",
            unit: "m",
            domain: Domain::length_or_zero(0.0),
            meaning: "thickness of a slat; 0 is a single surface",
        },
        Parameter {
            name: "reflectance",
            unit: "",
            domain: Domain::fraction(0.7),
            meaning: "reflectance of the slats' colour (Radiance plastic)",
        },
        Parameter {
            name: "specular",
            unit: "",
            domain: Domain::fraction(0.0),
            meaning: "specular fraction of the slats",
        },
        Parameter {
            name: "roughness",
            unit: "",
            domain: Domain::fraction(0.0),
            meaning: "RMS slope of the specular part",
        },
        Parameter {
            name: "glazing",
            unit: "",
            domain: Domain::Number { default: 0.0, least: 0.0, most: 0.918 },
            meaning: "transmittance of a pane outside at normal incidence; 0 is no pane",
        },
        Parameter {
            name: "gap",
            unit: "m",
            domain: Domain::length(0.01),
            meaning: "distance from the slats to the pane",
        },
        Parameter { name: "width", unit: "m", domain: Domain::length(1.0), meaning: "extent along X" },
        Parameter {
            name: "height",
            unit: "m",
            domain: Domain::length(1.0),
            meaning: "extent along Y, cut to whole spacings",
        },
    ],
    build,
};

fn build(values: &Values) -> Result<Device, String> {
    let n = values.n_fit("height", "spacing")?;
    let spacing = values.number("spacing");
    let slat = Slat::of(values)?;
    slat.check_apart(spacing)?;
    let mut builder = Builder::default();
    let material =
        plastic(values.number("reflectance"), values.number("specular"), values.number("roughness"));
    let material = builder.material("slat", &material);
    let x = 0.5 * values.number("width");
    let top = 0.5 * n as f64 * spacing;
    for k in 0..n {
        let middle = dvec2((k as f64 + 0.5) * spacing - top, 0.0);
        let outline: Vec<DVec2> = slat.outline.iter().map(|&p| p + middle).collect();
        let name = format!("slat.{k}");
        if slat.solid {
            builder.solid(&name, [-x, x], &outline, material, |_| material);
        } else {
            for (piece, ends) in outline.windows(2).enumerate() {
                builder.strip(format!("{name}.{piece}"), [-x, x], ends[0], ends[1], material);
            }
        }
    }
    if values.number("glazing") > 0.0 {
        let index = 1.52;
        let transmissivity = DVec3::splat(transmissivity_from_transmittance(values.number("glazing"), index));
        let pane = builder.material("pane", &Material::Glass { transmissivity, index });
        let z = slat.outline.iter().map(|p| p.y).fold(0.0, f64::min) - values.number("gap");
        builder.strip("pane".to_owned(), [-x, x], dvec2(top, z), dvec2(-top, z), pane);
    }
    Ok(builder.finish_extruded([-x, x], top, spacing, n))
}

/// Section of a slat in (y, z), its foremost point at z = 0.
struct Slat {
    /// From the outer edge to the room; of a solid slat further around, counter-clockwise seen from +X.
    outline: Vec<DVec2>,
    solid: bool,
}

impl Slat {
    fn of(values: &Values) -> Result<Self, String> {
        let (depth, rise, thickness) =
            (values.number("depth"), values.number("rise"), values.number("thickness"));
        if rise.abs() > 0.5 * depth {
            return Err("rise must be at most half of depth, where the slat is half a circle".to_owned());
        }
        if thickness > 0.5 * depth {
            return Err("thickness must be at most half of depth".to_owned());
        }
        let angle = values.number("angle");
        let (sin, cos) =
            if angle.abs() == 90.0 { (angle.signum(), 0.0) } else { angle.to_radians().sin_cos() };
        let section = Section { along: dvec2(sin, cos), up: dvec2(cos, -sin), depth, rise };
        let n_facets = if rise == 0.0 { 1 } else { values.number("facets") as usize };
        let solid = thickness > 0.0;
        let mut outline = section.arc(0.5 * thickness, n_facets);
        if solid {
            outline.extend(section.arc(-0.5 * thickness, n_facets).into_iter().rev());
        }
        let front = outline.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
        outline.iter_mut().for_each(|p| p.y -= front);
        Ok(Slat { outline, solid })
    }

    /// An error if copies `spacing` above each other would touch: where the section is as high as that.
    fn check_apart(&self, spacing: f64) -> Result<(), String> {
        let n = self.outline.len();
        let n_edges = if self.solid { n } else { n - 1 };
        // The height is piecewise linear in z, so it is greatest at a corner.
        let height_at = |z: f64| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for k in 0..n_edges {
                let (a, b) = (self.outline[k], self.outline[(k + 1) % n]);
                if (a.y - z) * (b.y - z) > 0.0 {
                    continue;
                }
                let crossing = a.x + (b.x - a.x) * ((z - a.y) / (b.y - a.y));
                let ends = if a.y == b.y { [a.x, b.x] } else { [crossing; 2] };
                (low, high) = (low.min(ends[0]).min(ends[1]), high.max(ends[0]).max(ends[1]));
            }
            high - low
        };
        let height = self.outline.iter().map(|p| height_at(p.y)).fold(0.0, f64::max);
        if height < spacing {
            return Ok(());
        }
        Err(format!(
            "slats {height:.4} m high would touch at a spacing of {spacing} m: tilt them less or space them"
        ))
    }
}

/// The middle surface of a slat.
struct Section {
    /// Unit vector from the outer edge to the room edge.
    along: DVec2,
    /// Unit vector to the slat's upper side.
    up: DVec2,
    depth: f64,
    rise: f64,
}

impl Section {
    /// Points at a distance above the middle surface, from the outer edge to the room edge.
    fn arc(&self, above: f64, n_facets: usize) -> Vec<DVec2> {
        let half = 0.5 * self.depth;
        if self.rise == 0.0 {
            return [-half, half].map(|t| self.along * t + self.up * above).to_vec();
        }
        let (sign, rise) = (self.rise.signum(), self.rise.abs());
        let radius = (half * half + rise * rise) / (2.0 * rise);
        let half_angle = (2.0 * (rise / half).atan()).min(FRAC_PI_2);
        let center = self.up * (sign * (rise - radius));
        let distance = radius + sign * above;
        let point = |k: usize| {
            let (sin, cos) = (half_angle * (2.0 * k as f64 / n_facets as f64 - 1.0)).sin_cos();
            center + distance * (self.along * sin + self.up * (sign * cos))
        };
        (0..=n_facets).map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_closed, volume};
    use super::*;
    use crate::shape::Shape;

    fn polygon(device: &Device, k: usize) -> &[DVec3] {
        match &device.surfaces[k].shape {
            Shape::Polygon(vertices) => vertices,
            _ => panic!("blinds are polygons"),
        }
    }

    #[test]
    fn positive_angle_raises_the_room_edge() {
        let device = Device::from_spec("blinds:angle=30").unwrap();
        assert_eq!(device.surfaces.len(), 25);
        let slat = polygon(&device, 0);
        let room = slat.iter().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        let outside = slat.iter().min_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        assert!((room.y - outside.y - 0.025).abs() < 1e-15, "{slat:?}");
        assert!((room.z - outside.z - 0.05 * 0.75f64.sqrt()).abs() < 1e-15);
        assert_eq!(room.z, 0.0);
        let [a, b, c] = device.surfaces[0].shape.triangulate()[0];
        assert!((b - a).cross(c - a).y > 0.0, "the front is the upper side");
    }

    #[test]
    fn slats_fill_the_height_evenly() {
        let device = Device::from_spec("blinds:spacing=0.03,height=0.1").unwrap();
        let ys: Vec<f64> = (0..3).map(|k| polygon(&device, k)[0].y).collect();
        for (y, expected) in ys.iter().zip([-0.03, 0.0, 0.03]) {
            assert!((y - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn curved_slats_rise_in_the_middle_and_keep_their_chord() {
        for rise in [0.004, -0.004, 0.025] {
            let device = Device::from_spec(&format!("blinds:rise={rise},spacing=0.1,height=0.1")).unwrap();
            assert_eq!(device.surfaces.len(), 8);
            let (first, middle) = (polygon(&device, 0)[0], polygon(&device, 4)[0]);
            assert!((middle.y - first.y - rise).abs() < 1e-15, "{first} {middle}");
            let last = polygon(&device, 7)[1];
            assert!((last.z - first.z - 0.05).abs() < 1e-15 && (last.y - first.y).abs() < 1e-15);
        }
    }

    #[test]
    fn solid_slats_are_closed_and_have_their_volume() {
        let flat = Device::from_spec("blinds:thickness=0.002,angle=-40,height=0.04").unwrap();
        assert_closed(&flat);
        assert!((volume(&flat) - 0.05 * 0.002).abs() < 1e-15);
        let spec = "blinds:thickness=0.002,rise=-0.01,facets=100,height=0.04,angle=20";
        let curved = Device::from_spec(spec).unwrap();
        assert_closed(&curved);
        // Length of the arc: radius 0.036 25 m, half angle 2·atan(0.4); 100 chords shorten it by 4e-5.
        let length = 0.03625 * 4.0 * 0.4f64.atan();
        assert!((volume(&curved) / (length * 0.002) - 1.0).abs() < 2e-4);
    }

    #[test]
    fn slats_that_would_touch_are_refused() {
        for (spec, fits) in [
            ("angle=90", false),
            ("angle=90,spacing=0.051", true),
            ("angle=-90,spacing=0.049", false),
            ("angle=89", true),
            ("thickness=0.02,angle=61", false),
            ("thickness=0.02,angle=59", true),
            ("rise=0.025,thickness=0.02,spacing=0.03", false),
            ("rise=0.025,thickness=0.02,spacing=0.032", true),
            ("rise=0.03", false),
            ("thickness=0.03", false),
            ("spacing=0.04,height=0.03", false),
        ] {
            assert_eq!(Device::from_spec(&format!("blinds:{spec}")).is_ok(), fits, "{spec}");
        }
    }

    #[test]
    fn pane_stands_outside_the_slats_with_its_transmittance() {
        let device = Device::from_spec("blinds:glazing=0.88,gap=0.02,width=2").unwrap();
        let pane = device.surfaces.last().unwrap();
        assert!((pane.shape.area() - 2.0).abs() < 1e-12);
        let [low, high] = pane.shape.bounds();
        assert!((low.z + 0.07).abs() < 1e-15 && low.z == high.z);
        let [a, b, c] = pane.shape.triangulate()[0];
        assert!((b - a).cross(c - a).z > 0.0);
        let Material::Glass { transmissivity, .. } = device.materials[1].material else {
            panic!("a pane is glass")
        };
        assert!((transmissivity.x - 0.96).abs() < 5e-3);
    }
}
