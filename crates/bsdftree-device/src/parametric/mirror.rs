//! A flat mirror at z = 0: the simplest device with a known BSDF, a peak of `reflectance` in the mirror direction.

use glam::DVec3;

use super::builder::Builder;
use super::family::{Domain, Family, Parameter, Values};
use crate::device::Device;
use crate::material::Material;
use crate::shape::Shape;

pub(super) const FAMILY: Family = Family {
    name: "mirror",
    summary: "a flat mirror that faces the room; its back is black",
    drawing: r"
        +Y
         |  +-----------+
         |  |           | height
         |  +-----------+
         |      width
         +------------------ +X      (+Z towards you: the room)
",
    parameters: &[
        Parameter {
            name: "reflectance",
            unit: "",
            domain: Domain::fraction(0.8),
            meaning: "reflectance, the same at all angles",
        },
        Parameter {
            name: "shape",
            unit: "",
            domain: Domain::Word(&["rectangle", "disk"]),
            meaning: "outline; a disk has the width as diameter",
        },
        Parameter { name: "width", unit: "m", domain: Domain::length(1.0), meaning: "extent along X" },
        Parameter {
            name: "height",
            unit: "m",
            domain: Domain::length(1.0),
            meaning: "extent along Y; of the rectangle only",
        },
    ],
    build,
};

fn build(values: &Values) -> Result<Device, String> {
    let mut builder = Builder::default();
    let material = Material::Mirror { reflectance: DVec3::splat(values.number("reflectance")) };
    let material = builder.material("mirror", &material);
    let (x, y) = (0.5 * values.number("width"), 0.5 * values.number("height"));
    let shape = match values.word("shape") {
        "disk" => Shape::Ring { center: DVec3::ZERO, normal: DVec3::Z, radii: [0.0, x] },
        _ => {
            Shape::Polygon([[-x, -y], [x, -y], [x, y], [-x, y]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec())
        }
    };
    builder.shape("mirror".to_owned(), shape, material);
    Ok(match values.word("shape") {
        "disk" => builder.finish(),
        _ => builder.finish_periodic([-x, x], [-y, y]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirror_faces_the_room_with_its_area() {
        let device = Device::from_spec("mirror:width=2,height=3").unwrap();
        assert_eq!(device.surfaces[0].shape.area(), 6.0);
        let [a, b, c] = device.surfaces[0].shape.triangulate()[0];
        assert!((b - a).cross(c - a).z > 0.0);
        let disk = Device::from_spec("mirror:shape=disk,width=2").unwrap();
        assert!((disk.surfaces[0].shape.area() - std::f64::consts::PI).abs() < 1e-15);
    }
}
