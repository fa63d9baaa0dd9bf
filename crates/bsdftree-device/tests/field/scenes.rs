//! Radiance scenes of one surface, given to `rtrace` and to us.

use std::f64::consts::TAU;
use std::path::Path;

use bsdftree_device::field::RayState;
use bsdftree_device::{Device, Material, ReadOptions, Unit};
use bsdftree_testing::radiance::{doubles, printed, programs};
use glam::DVec3;

/// Files in a directory of their own.
pub struct Scene {
    pub folder: tempfile::TempDir,
}

/// A surface in the plane z = 0, seen from its front.
#[derive(Clone, Copy, Debug)]
pub enum Plane {
    /// Its normal is +z.
    Up,
    /// Its normal is −z.
    Down,
}

impl Plane {
    pub fn normal(self) -> DVec3 {
        match self {
            Plane::Up => DVec3::Z,
            Plane::Down => DVec3::NEG_Z,
        }
    }

    /// The primitive, large enough for all rays.
    pub fn polygon(self) -> &'static str {
        match self {
            Plane::Up => "m polygon p 0 0 12 -99 -99 0 99 -99 0 99 99 0 -99 99 0\n",
            Plane::Down => "m polygon p 0 0 12 -99 99 0 99 99 0 99 -99 0 -99 -99 0\n",
        }
    }
}

impl Scene {
    pub fn new(files: &[(&str, &str)]) -> Scene {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        Scene { folder }
    }

    /// Triples that rtrace gives for rays through a scene text.
    pub fn rtrace(&self, text: &str, arguments: &[&str], rays: &[RayState]) -> Vec<DVec3> {
        std::fs::write(self.folder.path().join("scene.rad"), text).unwrap();
        let octree = printed("oconv", self.path(), &["scene.rad"], b"");
        std::fs::write(self.folder.path().join("scene.oct"), octree).unwrap();
        let input: String = rays
            .iter()
            .map(|ray| {
                let o = ray.position - ray.direction * ray.distance;
                let d = ray.direction;
                format!("{:?} {:?} {:?} {:?} {:?} {:?}\n", o.x, o.y, o.z, d.x, d.y, d.z)
            })
            .collect();
        let all = [&["-h", "-fad"], arguments, &["scene.oct"]].concat();
        let bytes = printed("rtrace", self.path(), &all, input.as_bytes());
        doubles(&bytes).chunks_exact(3).map(DVec3::from_slice).collect()
    }

    /// Our reading of a scene text; its first material.
    pub fn material(&self, text: &str, unit: Unit) -> Material {
        let library = programs().map(|programs| programs.with_file_name("lib"));
        let options =
            ReadOptions { unit, search: Some(library.into_iter().collect()), ..ReadOptions::default() };
        let device = Device::parse_rad(text, "scene.rad", self.folder.path(), options);
        device.unwrap_or_else(|e| panic!("{e}\n{text}")).materials[0].material.clone()
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Rays to the plane from its front, spread evenly enough: lengths in the scene's unit.
pub fn rays(plane: Plane, n: u32) -> Vec<RayState> {
    let fraction = |k: u32, step: f64| (0.5 + f64::from(k) * step).fract();
    (0..n)
        .map(|k| {
            // Additive recurrences of the powers of 1/g, where g⁶ = g + 1 (M. Roberts' sequence in five dimensions).
            let [u, v, s, t, w] = [0.8812714616, 0.7766393890, 0.6844301295, 0.6031687406, 0.5315553977]
                .map(|a| fraction(k, a));
            let (height, phi) = (0.15 + 0.85 * u, TAU * v);
            let radius = (1.0 - height * height).sqrt();
            let normal = plane.normal();
            let direction = DVec3::new(radius * phi.cos(), radius * phi.sin(), 0.0) - normal * height;
            let position = DVec3::new(4.0 * s - 2.0, 4.0 * t - 2.0, 0.0);
            let distance = 0.5 + 3.0 * w;
            RayState {
                direction,
                normal,
                position,
                distance,
                traveled: distance,
                uv: [0.0; 2],
                perturbed_normal: normal,
                perturbed_cosine: height,
                color: DVec3::ONE,
            }
        })
        .collect()
}
