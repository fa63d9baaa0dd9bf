//! A device as a Radiance scene text, in metres.
//!
//! In: a device. Out: text that Radiance and [`Device::parse_rad`] read. A material is written before the first
//! surface that uses it, and again where another of the same name was in force between. Numbers are exact.

use std::collections::HashMap;
use std::fmt::{self, Write};

use glam::DVec3;

use super::write_material::{write_antimatter, write_material};
use crate::device::{Device, NamedMaterial};
use crate::material::{Antimatter, Material};
use crate::mesh::write_polygons;
use crate::shape::Shape;

impl Device {
    /// The device as a Radiance scene, in metres.
    ///
    /// Reading it back gives the same surfaces; and the same materials where each is used by a surface and they are
    /// in the order of their first use, as the reader and the parametric devices have them. White space in names
    /// becomes `_`. Warnings are written as comments.
    pub fn to_rad(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = self.write_rad(&mut text);
        text
    }

    fn write_rad(&self, to: &mut String) -> fmt::Result {
        writeln!(to, "# Lengths in metres; the room is towards +Z, up is +Y.")?;
        for warning in &self.warnings {
            writeln!(to, "# {}", warning.replace(['\n', '\r'], " "))?;
        }
        let mut in_force = HashMap::new();
        for surface in &self.surfaces {
            let modifier = self.define(to, surface.material, &mut in_force)?;
            write_shape(to, &modifier, &word(&surface.name), &surface.shape)?;
        }
        Ok(())
    }

    /// Writes a material, unless it is in force under its name, which is returned.
    fn define(
        &self,
        to: &mut String,
        index: u32,
        in_force: &mut HashMap<String, u32>,
    ) -> Result<String, fmt::Error> {
        let NamedMaterial { name, material } = &self.materials[index as usize];
        let name = word(name);
        if (name == "void" && *material == Material::Void) || in_force.get(&name) == Some(&index) {
            return Ok(name);
        }
        if let Material::Antimatter(Antimatter { skin, hidden }) = material {
            // The first name shades what is cut.
            let rest = hidden.iter().filter(|&other| Some(*other) != *skin);
            let mut names = Vec::new();
            for &other in skin.iter().chain(rest) {
                names.push(self.define(to, other, in_force)?);
            }
            if skin.is_none() {
                names.insert(0, "void".to_owned());
            }
            write_antimatter(to, &name, &names)?;
        } else {
            write_material(to, &name, material)?;
        }
        in_force.insert(name.clone(), index);
        Ok(name)
    }
}

/// A name as one word that the reader takes for nothing else.
fn word(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_whitespace() || c == '"' || c == '\'' { '_' } else { c }).collect();
    if plain.is_empty() || plain.starts_with(['#', '!']) { format!("_{plain}") } else { plain }
}

fn write_shape(to: &mut String, modifier: &str, name: &str, shape: &Shape) -> fmt::Result {
    let kind = |outward, inward, is_inward| if is_inward { inward } else { outward };
    match shape {
        Shape::Polygon(vertices) => {
            writeln!(to, "\n{modifier} polygon {name}\n0\n0\n{}", 3 * vertices.len())?;
            vertices.iter().try_for_each(|&v| writeln!(to, "  {}", Triple(v)))
        }
        Shape::Sphere { center, radius, inward } => {
            let kind = kind("sphere", "bubble", *inward);
            writeln!(to, "\n{modifier} {kind} {name}\n0\n0\n4 {} {radius:?}", Triple(*center))
        }
        Shape::Cylinder { ends, radius, inward } => {
            let kind = kind("cylinder", "tube", *inward);
            let [a, b] = ends.map(Triple);
            writeln!(to, "\n{modifier} {kind} {name}\n0\n0\n7\n  {a}\n  {b}\n  {radius:?}")
        }
        Shape::Cone { ends, radii, inward } => {
            let kind = kind("cone", "cup", *inward);
            let [a, b] = ends.map(Triple);
            writeln!(to, "\n{modifier} {kind} {name}\n0\n0\n8\n  {a}\n  {b}\n  {:?} {:?}", radii[0], radii[1])
        }
        Shape::Ring { center, normal, radii } => {
            let (c, n) = (Triple(*center), Triple(*normal));
            writeln!(to, "\n{modifier} ring {name}\n0\n0\n8\n  {c}\n  {n}\n  {:?} {:?}", radii[0], radii[1])
        }
        Shape::Mesh(mesh) => write_polygons(to, modifier, name, mesh),
    }
}

/// Three numbers; the debug form of an f64 is the shortest that reads back as the same.
struct Triple(DVec3);

impl fmt::Display for Triple {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} {:?} {:?}", self.0.x, self.0.y, self.0.z)
    }
}
