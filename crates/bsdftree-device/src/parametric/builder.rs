//! Surfaces of parametric devices: polygons, and profiles extruded along X.
//!
//! In: points and materials. Out: a device whose materials are in the order of their first use. Profiles lie in the
//! (y, z) plane and are counter-clockwise seen from +X, so that what is to the left of an edge is inside.

use glam::{DVec2, DVec3};

use crate::device::{Device, NamedMaterial, Surface};
use crate::material::{Gloss, GlossKind, Material};
use crate::shape::Shape;

/// A device that grows.
#[derive(Default)]
pub(super) struct Builder {
    device: Device,
}

impl Builder {
    /// Index of a material, which enters the device if it is new.
    pub(super) fn material(&mut self, name: &str, material: &Material) -> u32 {
        let materials = &mut self.device.materials;
        let known = materials.iter().position(|m| m.name == name);
        known.unwrap_or_else(|| {
            materials.push(NamedMaterial { name: name.to_owned(), material: material.clone() });
            materials.len() - 1
        }) as u32
    }

    pub(super) fn shape(&mut self, name: String, shape: Shape, material: u32) {
        self.device.surfaces.push(Surface { name, shape, material });
    }

    pub(super) fn polygon(&mut self, name: String, vertices: Vec<DVec3>, material: u32) {
        self.shape(name, Shape::Polygon(vertices), material);
    }

    /// The rectangle over the edge from `p` to `q`; its front is to the right of the edge, outside of a profile.
    pub(super) fn strip(&mut self, name: String, x: [f64; 2], p: DVec2, q: DVec2, material: u32) {
        let vertices = vec![at(x[0], p), at(x[0], q), at(x[1], q), at(x[1], p)];
        self.polygon(name, vertices, material);
    }

    /// A closed solid over a profile; `material(k)` is of the edge from point k to the next.
    pub(super) fn solid(
        &mut self,
        name: &str,
        x: [f64; 2],
        profile: &[DVec2],
        cap: u32,
        material: impl Fn(usize) -> u32,
    ) {
        for (k, &p) in profile.iter().enumerate() {
            self.strip(format!("{name}.{k}"), x, p, profile[(k + 1) % profile.len()], material(k));
        }
        self.polygon(format!("{name}.left"), profile.iter().rev().map(|&p| at(x[0], p)).collect(), cap);
        self.polygon(format!("{name}.right"), profile.iter().map(|&p| at(x[1], p)).collect(), cap);
    }

    pub(super) fn finish(self) -> Device {
        self.device
    }

    /// As [`Builder::finish`]; one period of the device lies between these x and y.
    pub(super) fn finish_periodic(mut self, x: [f64; 2], y: [f64; 2]) -> Device {
        let bounds = self.device.bounds();
        self.device.tile =
            bounds.map(|[low, high]| [DVec3::new(x[0], y[0], low.z), DVec3::new(x[1], y[1], high.z)]);
        self.device
    }

    /// As [`Builder::finish`], for a device that is the same for all x and repeats `n` times along y, from `top` downwards.
    pub(super) fn finish_extruded(self, x: [f64; 2], top: f64, period: f64, n: usize) -> Device {
        // Neighbours on both sides must be there.
        if n < 3 {
            return self.finish();
        }
        let high = top - (n / 2) as f64 * period;
        self.finish_periodic(x.map(|x| x / 3.0), [high - period, high])
    }
}

fn at(x: f64, p: DVec2) -> DVec3 {
    DVec3::new(x, p.x, p.y)
}

/// A grey `plastic`.
pub(super) fn plastic(reflectance: f64, specular: f64, roughness: f64) -> Material {
    Material::Gloss(Gloss {
        kind: GlossKind::Plastic,
        color: DVec3::splat(reflectance),
        specular,
        roughness: [roughness; 2],
        orientation: None,
        transmission: 0.0,
        transmitted_specular: 0.0,
    })
}
