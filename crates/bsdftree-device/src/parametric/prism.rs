//! A prismatic panel: a clear sheet with ridges along X on one side, as one closed dielectric solid.
//!
//! Light refracts at every face, also at the edges of the panel. Geometry: the room side is at z = 0; ridge height
//! h = period / (cot angle_up + cot angle_down); the apex angle is 180° − angle_up − angle_down.

use glam::{DVec2, DVec3, dvec2};

use super::builder::Builder;
use super::family::{Domain, Family, Parameter, Values};
use crate::device::Device;
use crate::material::{Material, Medium};

pub(super) const FAMILY: Family = Family {
    name: "prism",
    summary: "a clear panel with prismatic ridges along X",
    drawing: r"
     +Y   outside | base |
      |           |______|__
      |           |      \  |  facet that faces up, tilted by angle_up
      |           |       \ |    out of the panel's plane
      |           |        >   ridge
      |           |       / |  facet that faces down, tilted by angle_down
      |           |______/__|  one period below
      |
      +-------------------------- +Z (room)
",
    parameters: &[
        Parameter {
            name: "period",
            unit: "m",
            domain: Domain::length(0.01),
            meaning: "distance of two ridges along Y",
        },
        Parameter {
            name: "angle_up",
            unit: "deg",
            domain: ANGLE,
            meaning: "tilt of the facets that face up",
        },
        Parameter {
            name: "angle_down",
            unit: "deg",
            domain: ANGLE,
            meaning: "tilt of the facets that face down",
        },
        Parameter {
            name: "base",
            unit: "m",
            domain: Domain::length(0.003),
            meaning: "thickness of the sheet without its ridges",
        },
        Parameter {
            name: "ridges",
            unit: "",
            domain: Domain::Word(&["room", "outside"]),
            meaning: "the side that the ridges are on",
        },
        Parameter {
            name: "index",
            unit: "",
            domain: Domain::Number { default: 1.49, least: 1.0, most: 4.0 },
            meaning: "index of refraction; acrylic 1.49, polycarbonate 1.58",
        },
        Parameter {
            name: "transmittance",
            unit: "1/m",
            domain: Domain::fraction(0.5),
            meaning: "transmittance of 1 m of the material",
        },
        Parameter { name: "width", unit: "m", domain: Domain::length(1.0), meaning: "extent along X" },
        Parameter {
            name: "height",
            unit: "m",
            domain: Domain::length(1.0),
            meaning: "extent along Y, cut to whole periods",
        },
    ],
    build,
};

const ANGLE: Domain = Domain::Number { default: 45.0, least: 1.0, most: 90.0 };

fn build(values: &Values) -> Result<Device, String> {
    let n = values.n_fit("height", "period")?;
    let (period, base) = (values.number("period"), values.number("base"));
    let cot = |name: &str| (90.0 - values.number(name)).to_radians().tan();
    let (cot_up, cot_down) = (cot("angle_up"), cot("angle_down"));
    if cot_up + cot_down <= 0.0 {
        return Err("angle_up and angle_down cannot both be 90 deg".to_owned());
    }
    let ridge = period / (cot_up + cot_down);
    let top = 0.5 * n as f64 * period;
    let mut profile = vec![dvec2(top, -ridge)];
    for k in 1..=n {
        let lower = top - k as f64 * period;
        profile.push(dvec2(lower + ridge * cot_down, 0.0));
        profile.push(dvec2(lower, -ridge));
    }
    let back = -ridge - base;
    let bottom = profile.last().map_or(-top, |p: &DVec2| p.x);
    profile.extend([dvec2(bottom, back), dvec2(top, back)]);
    if values.word("ridges") == "outside" {
        // Turned inside out along z, which also turns the sense of rotation.
        profile = profile.iter().rev().map(|p| dvec2(p.x, back - p.y)).collect();
    }
    let inside =
        Medium { transmittance: DVec3::splat(values.number("transmittance")), index: values.number("index") };
    let mut builder = Builder::default();
    let clear = builder.material("clear", &Material::Dielectric { inside, outside: Medium::VACUUM });
    let x = 0.5 * values.number("width");
    builder.solid("prism", [-x, x], &profile, clear, |_| clear);
    Ok(builder.finish_extruded([-x, x], top, period, n))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_closed, volume};
    use super::*;

    #[test]
    fn panel_is_closed_and_has_the_volume_of_its_profile() {
        for ridges in ["room", "outside"] {
            let spec = format!("prism:ridges={ridges},period=0.1,angle_up=30,angle_down=60,base=0.02");
            let device = Device::from_spec(&spec).unwrap();
            assert_closed(&device);
            // A right angle at the ridge: its height is the period × sin 30° × cos 30°.
            let ridge = 0.1 * 0.5 * 0.75f64.sqrt();
            assert!((volume(&device) - (0.5 * ridge + 0.02)).abs() < 1e-12);
            let [low, high] = device.bounds().unwrap();
            assert!((low.z + ridge + 0.02).abs() < 1e-15 && high.z.abs() < 1e-15);
        }
    }

    #[test]
    fn facets_have_their_tilts() {
        let device = Device::from_spec("prism:period=0.1,angle_up=30,angle_down=70").unwrap();
        for (k, tilt, sign) in [(0, 30.0f64, 1.0), (1, 70.0, -1.0)] {
            let [a, b, c] = device.surfaces[k].shape.triangulate()[0];
            let normal = (b - a).cross(c - a).normalize();
            assert!((normal.z - tilt.to_radians().cos()).abs() < 1e-12 && normal.y * sign > 0.0, "{normal}");
        }
    }

    #[test]
    fn two_upright_facets_make_no_ridge() {
        assert!(Device::from_spec("prism:angle_up=90,angle_down=90").is_err());
        assert_closed(&Device::from_spec("prism:angle_up=90").unwrap());
    }
}
