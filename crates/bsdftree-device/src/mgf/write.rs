//! A device as MGF text.
//!
//! In: a device and a unit of length. Out: text that Radiance's mgf2rad and [`Device::parse_mgf`] read in that unit, and a list of
//! what it does not say. A material is written before the first surface that uses it, and made the current one again where
//! others were used between. A point has one name wherever it stands. Numbers are exact where the unit is a metre. Source: rad2mgf of
//! Radiance 6.1, observed; materials are in `write_material`.

use std::collections::{HashMap, HashSet};
use std::fmt::{self, Write};

use glam::DVec3;

use super::write_material::write_material;
use crate::device::{Device, Surface};
use crate::mesh::Mesh;
use crate::shape::Shape;
use crate::unit::Unit;

/// A device in MGF.
#[derive(Clone, Debug, PartialEq)]
pub struct Mgf {
    /// The text.
    pub text: String,
    /// What it does not say of the device, one sentence each; nothing if it says all.
    pub losses: Vec<String>,
}

impl Device {
    /// The device in MGF, its lengths in `unit`.
    ///
    /// Reading it back in that unit gives the same surfaces and, up to rounding, the same materials, except for what is listed as lost.
    /// Names that MGF could not read are changed a little. Warnings are written as comments.
    ///
    /// ```
    /// use bsdftree_device::{Device, Unit};
    /// let blinds = Device::from_spec("blinds:depth=0.05,spacing=0.04,glazing=0.88")?;
    /// let mgf = blinds.to_mgf(Unit::Meter);
    /// assert!(mgf.losses.is_empty());
    /// let again = Device::parse_mgf(&mgf.text, "blinds.mgf", ".".as_ref(), Unit::Meter)?;
    /// assert_eq!(again.bounds(), blinds.bounds());
    /// # Ok::<(), bsdftree_device::DeviceError>(())
    /// ```
    pub fn to_mgf(&self, unit: Unit) -> Mgf {
        let mut writer = Writer { unit: unit.meters(), ..Writer::default() };
        // Writing to a String cannot fail.
        let _ = writer.device(self);
        Mgf { text: writer.text, losses: writer.losses }
    }
}

#[derive(Default)]
struct Writer {
    text: String,
    losses: Vec<String>,
    /// \[m\].
    unit: f64,
    /// Numbers of the points that have names, by their bits.
    points: HashMap<[u64; 3], usize>,
}

impl Writer {
    fn device(&mut self, device: &Device) -> fmt::Result {
        for warning in &device.warnings {
            // A backslash at the end would take the next line for part of the comment.
            writeln!(self.text, "# {}.", warning.replace(['\n', '\r'], " "))?;
        }
        let names = material_names(device);
        let (mut written, mut current) = (HashSet::new(), None);
        let mut object: Option<String> = None;
        for surface in &device.surfaces {
            let index = surface.material as usize;
            if written.insert(index) {
                writeln!(self.text, "m {} =", names[index])?;
                let lost = write_material(&mut self.text, &device.materials[index].material, self.unit)?;
                self.losses
                    .extend(lost.into_iter().map(|lost| format!("material \"{}\": {lost}", names[index])));
            } else if current != Some(index) {
                writeln!(self.text, "m {}", names[index])?;
            }
            current = Some(index);
            let name = object_name(&surface.name);
            if object.as_ref() != Some(&name) {
                let end = if object.is_some() { "o\n" } else { "" };
                writeln!(self.text, "{end}o {name}")?;
                object = Some(name);
            }
            self.surface(surface)?;
        }
        if object.is_some() {
            writeln!(self.text, "o")?;
        }
        Ok(())
    }

    fn surface(&mut self, surface: &Surface) -> fmt::Result {
        match &surface.shape {
            Shape::Polygon(vertices) => {
                let names = vertices.iter().map(|&p| self.point(p)).collect::<Result<Vec<_>, _>>()?;
                self.face(&names)
            }
            Shape::Sphere { center, radius, inward } => {
                let (name, radius) = (self.point(*center)?, self.signed(*radius, *inward));
                writeln!(self.text, "sph {name} {radius:?}")
            }
            Shape::Cylinder { ends, radius, inward } => {
                let ([a, b], radius) = (self.ends(*ends)?, self.signed(*radius, *inward));
                writeln!(self.text, "cyl {a} {radius:?} {b}")
            }
            Shape::Cone { ends, radii, inward } => {
                let ([a, b], radii) = (self.ends(*ends)?, radii.map(|r| self.signed(r, *inward)));
                writeln!(self.text, "cone {a} {:?} {b} {:?}", radii[0], radii[1])
            }
            Shape::Ring { center, normal, radii } => {
                let radii = radii.map(|r| self.signed(r, false));
                self.vertex("ring", *center, *normal)?;
                writeln!(self.text, "ring ring {:?} {:?}", radii[0], radii[1])
            }
            Shape::Mesh(mesh) => self.mesh(&surface.name, mesh),
        }
    }

    fn mesh(&mut self, name: &str, mesh: &Mesh) -> fmt::Result {
        if !mesh.vertices.uvs.is_empty() {
            self.losses.push(format!("surface \"{name}\": texture coordinates"));
        }
        for (k, corners) in mesh.solid() {
            let normals = mesh.triangles[k].map(|v| mesh.vertices.normals.get(v as usize).copied());
            let is_smooth = normals.iter().all(|n| n.is_some_and(|n| n != glam::Vec3::ZERO));
            let mut names = [const { String::new() }; 3];
            for (corner, name) in names.iter_mut().enumerate() {
                *name = match normals[corner].filter(|_| is_smooth) {
                    None => self.point(corners[corner])?,
                    Some(normal) => {
                        let name = format!("n{corner}");
                        self.vertex(&name, corners[corner], normal.as_dvec3())?;
                        name
                    }
                };
            }
            self.face(&names)?;
        }
        Ok(())
    }

    /// `f` over as many lines as it takes.
    fn face(&mut self, names: &[String]) -> fmt::Result {
        const LONGEST: usize = 72;
        let mut column = self.text.len();
        write!(self.text, "f")?;
        for name in names {
            if self.text.len() - column > LONGEST {
                write!(self.text, " \\\n ")?;
                column = self.text.len();
            }
            write!(self.text, " {name}")?;
        }
        writeln!(self.text)
    }

    fn ends(&mut self, [a, b]: [DVec3; 2]) -> Result<[String; 2], fmt::Error> {
        Ok([self.point(a)?, self.point(b)?])
    }

    /// The name of a point, which is written if it is new.
    fn point(&mut self, point: DVec3) -> Result<String, fmt::Error> {
        let next = self.points.len();
        // 0 and −0 are one place.
        let bits = (point + DVec3::ZERO).to_array().map(f64::to_bits);
        let number = *self.points.entry(bits).or_insert(next);
        let name = format!("v{number}");
        if number == next {
            let DVec3 { x, y, z } = point / self.unit;
            writeln!(self.text, "v {name} =\n\tp {x:?} {y:?} {z:?}")?;
        }
        Ok(name)
    }

    fn vertex(&mut self, name: &str, point: DVec3, normal: DVec3) -> fmt::Result {
        let DVec3 { x, y, z } = point / self.unit;
        writeln!(self.text, "v {name} =\n\tp {x:?} {y:?} {z:?}")?;
        let DVec3 { x, y, z } = normal;
        writeln!(self.text, "\tn {x:?} {y:?} {z:?}")
    }

    fn signed(&self, radius: f64, inward: bool) -> f64 {
        let radius = radius / self.unit;
        if inward { -radius } else { radius }
    }
}

/// A name for each material, none twice.
fn material_names(device: &Device) -> Vec<String> {
    let mut taken = HashSet::new();
    let unique = |name: &str| {
        let name = word(name);
        let mut candidate = name.clone();
        let mut n = 1;
        while !taken.insert(candidate.clone()) {
            n += 1;
            candidate = format!("{name}.{n}");
        }
        candidate
    };
    device.materials.iter().map(|m| m.name.as_str()).map(unique).collect()
}

/// The object of a surface: its name without what follows the last dot, as rad2mgf has it.
fn object_name(name: &str) -> String {
    word(name.rsplit_once('.').map_or(name, |(object, _)| object))
}

/// A name as mgf2rad takes it: a letter, then visible ASCII.
fn word(name: &str) -> String {
    let visible: String =
        name.chars().map(|c| if c.is_ascii_graphic() && c != '\\' { c } else { '_' }).collect();
    if visible.starts_with(|c: char| c.is_ascii_alphabetic()) { visible } else { format!("O{visible}") }
}
