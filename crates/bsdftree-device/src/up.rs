//! Turning a device that was not drawn with Y up.

use std::str::FromStr;
use std::sync::Arc;

use glam::DVec3;

use crate::device::Device;
use crate::mesh::Moving;
use crate::shape::Shape;

/// The axis that points up in the drawing.
///
/// X and Y turn about Z, so that the front stays the front. Z turns about X: a device drawn standing, with Z up,
/// has its room towards −Y (its plan's south), and with Z down towards +Y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// +X.
    X,
    /// −X.
    MinusX,
    /// +Y: nothing is turned.
    #[default]
    Y,
    /// −Y.
    MinusY,
    /// +Z; the room is towards −Y.
    Z,
    /// −Z; the room is towards +Y.
    MinusZ,
}

impl FromStr for Up {
    type Err = String;

    fn from_str(text: &str) -> Result<Up, String> {
        match text.to_ascii_lowercase().trim_start_matches('+') {
            "x" => Ok(Up::X),
            "-x" => Ok(Up::MinusX),
            "y" => Ok(Up::Y),
            "-y" => Ok(Up::MinusY),
            "z" => Ok(Up::Z),
            "-z" => Ok(Up::MinusZ),
            _ => Err(format!("up is '{text}'; expected x, -x, y, -y, z or -z")),
        }
    }
}

impl Up {
    /// The vector in the device's own axes for one in the drawing's.
    fn turned(self, v: DVec3) -> DVec3 {
        let DVec3 { x, y, z } = v;
        match self {
            Up::X => DVec3::new(-y, x, z),
            Up::MinusX => DVec3::new(y, -x, z),
            Up::Y => v,
            Up::MinusY => DVec3::new(-x, -y, z),
            Up::Z => DVec3::new(x, z, -y),
            Up::MinusZ => DVec3::new(x, -z, y),
        }
    }
}

impl Device {
    /// The device turned so that the axis that points up in its drawing is +Y.
    pub fn turned_up(&self, up: Up) -> Device {
        let turn = |v: DVec3| up.turned(v);
        let mut device = self.clone();
        let mut meshes = Moving::default();
        for surface in &mut device.surfaces {
            match &mut surface.shape {
                Shape::Polygon(vertices) => vertices.iter_mut().for_each(|v| *v = turn(*v)),
                Shape::Sphere { center, .. } => *center = turn(*center),
                Shape::Cylinder { ends, .. } | Shape::Cone { ends, .. } => *ends = ends.map(turn),
                Shape::Ring { center, normal, .. } => (*center, *normal) = (turn(*center), turn(*normal)),
                Shape::Mesh(mesh) => *mesh = Arc::new(meshes.moved(mesh, turn, turn)),
            }
        }
        device.tile = device.tile.map(|[low, high]| {
            let (a, b) = (turn(low), turn(high));
            [a.min(b), a.max(b)]
        });
        for named in &mut device.materials {
            named.material = named.material.turned(&turn);
        }
        device
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_up_becomes_y_and_hands_stay_right() {
        for (name, up) in [
            ("x", DVec3::X),
            ("-X", DVec3::NEG_X),
            ("+y", DVec3::Y),
            ("-y", DVec3::NEG_Y),
            ("Z", DVec3::Z),
            ("-z", DVec3::NEG_Z),
        ] {
            let turn = |v| name.parse::<Up>().unwrap().turned(v);
            assert_eq!(turn(up), DVec3::Y, "{name}");
            assert_eq!(turn(DVec3::X).cross(turn(DVec3::Y)), turn(DVec3::Z), "{name}");
        }
        assert_eq!("z".parse::<Up>().unwrap().turned(DVec3::NEG_Y), DVec3::Z);
        assert!("up".parse::<Up>().unwrap_err().contains("'up'"));
    }
}
