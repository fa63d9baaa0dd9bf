//! Grooves along X whose facets are a mirror and a diffuser by turns, on an opaque body.
//!
//! Source: the example of the talk "A Variable-resolution BSDF Implementation" (G. Ward, A. McNeil), where retroreflected
//! and scattered light share one profile. Geometry: closed solid; peaks at z = 0, valleys at z = −depth.

use glam::{DVec2, DVec3, dvec2};

use super::builder::{Builder, plastic};
use super::family::{Domain, Family, Parameter, Values};
use crate::device::Device;
use crate::material::Material;

pub(super) const FAMILY: Family = Family {
    name: "sawtooth",
    summary: "grooves along X with mirror and diffuse facets by turns; opaque",
    drawing: r"
     +Y       z = 0
      |         |
      |     ____|  peak
      |    |   /   facet that faces down
      |    |  <    valley at z = -depth
      |    |   \   facet that faces up
      |    |____|  peak, one period below
      |
      +------------- +Z (room)
",
    parameters: &[
        Parameter {
            name: "period",
            unit: "m",
            domain: Domain::length(0.02),
            meaning: "distance of two peaks along Y",
        },
        Parameter { name: "depth", unit: "m", domain: Domain::length(0.01), meaning: "depth of the valleys" },
        Parameter {
            name: "valley",
            unit: "",
            domain: Domain::Number { default: 0.5, least: 0.001, most: 0.999 },
            meaning: "height of the valley above the lower peak as a fraction of the period",
        },
        Parameter {
            name: "mirror_faces",
            unit: "",
            domain: Domain::Word(&["up", "down"]),
            meaning: "which facets are mirrors",
        },
        Parameter {
            name: "mirror",
            unit: "",
            domain: Domain::fraction(0.8),
            meaning: "reflectance of the mirror facets",
        },
        Parameter {
            name: "diffuse",
            unit: "",
            domain: Domain::fraction(0.5),
            meaning: "reflectance of the diffuse facets and of the body",
        },
        Parameter {
            name: "base",
            unit: "m",
            domain: Domain::length(0.002),
            meaning: "thickness of the body behind the valleys",
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

fn build(values: &Values) -> Result<Device, String> {
    let n = values.n_fit("height", "period")?;
    let (period, depth) = (values.number("period"), values.number("depth"));
    let top = 0.5 * n as f64 * period;
    let mut profile = vec![dvec2(top, 0.0)];
    for k in 1..=n {
        let lower_peak = top - k as f64 * period;
        profile.push(dvec2(lower_peak + values.number("valley") * period, -depth));
        profile.push(dvec2(lower_peak, 0.0));
    }
    let back = -depth - values.number("base");
    let bottom = profile.last().map_or(-top, |p: &DVec2| p.x);
    profile.extend([dvec2(bottom, back), dvec2(top, back)]);

    let mut builder = Builder::default();
    let mirror = Material::Mirror { reflectance: DVec3::splat(values.number("mirror")) };
    let diffuse = plastic(values.number("diffuse"), 0.0, 0.0);
    let mirror_up = values.word("mirror_faces") == "up";
    // The first edge faces down; materials enter in the order of their first use.
    let facets = if mirror_up {
        [("diffuse", diffuse), ("mirror", mirror)]
    } else {
        [("mirror", mirror), ("diffuse", diffuse)]
    };
    let facets = facets.map(|(name, material)| builder.material(name, &material));
    let body = facets[usize::from(!mirror_up)];
    let x = 0.5 * values.number("width");
    builder.solid("sawtooth", [-x, x], &profile, body, |k| if k < 2 * n { facets[k % 2] } else { body });
    Ok(builder.finish_extruded([-x, x], top, period, n))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_closed, volume};
    use super::*;

    #[test]
    fn body_is_closed_and_has_the_volume_of_its_profile() {
        let device =
            Device::from_spec("sawtooth:period=0.1,depth=0.04,valley=0.3,base=0.01,width=2").unwrap();
        assert_closed(&device);
        // Half of the depth is air.
        assert!((volume(&device) - 2.0 * 1.0 * (0.02 + 0.01)).abs() < 1e-12);
    }

    #[test]
    fn mirrors_face_the_chosen_way() {
        for (word, sign) in [("up", 1.0), ("down", -1.0)] {
            let device = Device::from_spec(&format!("sawtooth:mirror_faces={word}")).unwrap();
            let mirrors =
                device.surfaces.iter().filter(|s| device.materials[s.material as usize].name == "mirror");
            let mut n = 0;
            for mirror in mirrors {
                let [a, b, c] = mirror.shape.triangulate()[0];
                let normal = (b - a).cross(c - a);
                assert!(normal.y * sign > 0.0 && normal.z > 0.0, "{normal}");
                n += 1;
            }
            assert_eq!(n, 50);
        }
    }
}
