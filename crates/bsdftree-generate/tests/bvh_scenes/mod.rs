//! Devices and random numbers for the tests and benchmarks of the tracer.
#![allow(dead_code)]

use std::sync::Arc;

use bsdftree_device::material::Material;
use bsdftree_device::mesh::{Mesh, Vertices};
use bsdftree_device::shape::Shape;
use bsdftree_device::{Device, NamedMaterial, Surface};
use glam::{DVec3, dvec3, vec2};

/// SplitMix64, for tests only.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E3779B97F4A7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58476D1CE4E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D049BB133111EB);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    /// Uniform on the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let (z, phi) = (self.between(-1.0, 1.0), self.between(0.0, std::f64::consts::TAU));
        let r = (1.0 - z * z).sqrt();
        dvec3(r * phi.cos(), r * phi.sin(), z).normalize()
    }

    /// In a box.
    pub fn point(&mut self, [a, b]: [DVec3; 2]) -> DVec3 {
        dvec3(self.between(a.x, b.x), self.between(a.y, b.y), self.between(a.z, b.z))
    }
}

/// All black.
pub fn device(shapes: impl IntoIterator<Item = Shape>) -> Device {
    let surface = |(i, shape)| Surface { name: format!("s{i}"), shape, material: 0 };
    Device {
        surfaces: shapes.into_iter().enumerate().map(surface).collect(),
        materials: vec![NamedMaterial { name: "black".into(), material: Material::Black }],
        ..Device::default()
    }
}

pub fn triangle(a: DVec3, b: DVec3, c: DVec3) -> Shape {
    Shape::Polygon(vec![a, b, c])
}

/// 45 curved slats of 8 quadrangles, 720 triangles, 1.5 m wide and 1.4 m high.
pub fn blind() -> Device {
    let (n_slats, n_strips, pitch, width, chord) = (45, 8, 0.031, 1.5, 0.038);
    let mut shapes = Vec::new();
    for slat in 0..n_slats {
        let corner = |k: usize, x: f64| {
            let s = k as f64 / n_strips as f64 - 0.5;
            let (along, sag) = (s * chord, 0.006 * (1.0 - 4.0 * s * s));
            let (sin, cos) = 0.7f64.sin_cos();
            let y = slat as f64 * pitch + along * sin + sag * cos;
            dvec3(x, y, along * cos - sag * sin)
        };
        for k in 0..n_strips {
            let quad = vec![corner(k, 0.0), corner(k, width), corner(k + 1, width), corner(k + 1, 0.0)];
            shapes.push(Shape::Polygon(quad));
        }
    }
    device(shapes)
}

/// Corners and faces of a sphere of 2·n_phi·(n_theta − 1) triangles, its radius displaced by `bumps`.
pub fn sphere_mesh(n_theta: usize, n_phi: usize, bumps: f64) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let corner = |i: usize, j: usize| {
        let (theta, phi) = (
            std::f64::consts::PI * i as f64 / n_theta as f64,
            std::f64::consts::TAU * j as f64 / n_phi as f64,
        );
        let r = 1.0 + bumps * (theta * 9.0).sin() * (phi * 7.0).cos() * theta.sin();
        r * dvec3(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    let mut corners = vec![corner(0, 0), corner(n_theta, 0)];
    for i in 1..n_theta {
        corners.extend((0..n_phi).map(|j| corner(i, j)));
    }
    let at = |i: usize, j: usize| match i {
        0 => 0,
        _ if i == n_theta => 1,
        _ => 2 + (i - 1) * n_phi + j % n_phi,
    };
    let mut faces = Vec::new();
    for i in 0..n_theta {
        for j in 0..n_phi {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if i > 0 {
                faces.push([a, c, d]);
            }
            if i + 1 < n_theta {
                faces.push([a, b, c]);
            }
        }
    }
    (corners, faces)
}

pub fn mesh((corners, faces): &(Vec<DVec3>, Vec<[usize; 3]>)) -> Device {
    device(faces.iter().map(|f| triangle(corners[f[0]], corners[f[1]], corners[f[2]])))
}

/// The same as one surface, with normals away from the centre and longitude and height as texture coordinates.
pub fn shared_mesh((corners, faces): &(Vec<DVec3>, Vec<[usize; 3]>)) -> Device {
    let vertices = Vertices {
        positions: corners.clone(),
        normals: corners.iter().map(|p| p.normalize().as_vec3()).collect(),
        uvs: corners.iter().map(|p| vec2(p.y.atan2(p.x) as f32, p.z as f32)).collect(),
    };
    let triangles = faces.iter().map(|f| f.map(|k| k as u32)).collect();
    device([Shape::Mesh(Arc::new(Mesh { vertices: Arc::new(vertices), triangles }))])
}

/// `n` random spheres, cylinders, cones, rings and, if asked for, polygons in the unit cube.
pub fn mixture(n: usize, size: f64, with_polygons: bool, random: &mut Random) -> Device {
    let cube = [DVec3::ZERO, DVec3::ONE];
    let shapes: Vec<Shape> = (0..n)
        .map(|i| {
            let p = random.point(cube);
            let (q, a, b) = (p + random.direction() * size, size * random.unit(), size * random.unit());
            let inward = random.unit() < 0.5;
            match i % if with_polygons { 6 } else { 4 } {
                0 => Shape::Sphere { center: p, radius: a + 1e-3 * size, inward },
                1 => Shape::Cylinder { ends: [p, q], radius: b + 1e-3 * size, inward },
                2 => Shape::Cone { ends: [p, q], radii: [a, b], inward },
                3 => Shape::Ring { center: p, normal: random.direction(), radii: [0.5 * a, a + 1e-3 * size] },
                4 => triangle(p, q, random.point(cube)),
                _ => {
                    let (u, v) = (q - p, (q - p).cross(random.direction()));
                    Shape::Polygon(vec![p, p + u, p + u + v, p + 0.7 * u + 0.4 * v, p + v])
                }
            }
        })
        .collect();
    device(shapes)
}

/// Incoherent rays: chords between random points on a sphere around the device.
pub fn chords(bounds: [DVec3; 2], n: usize, random: &mut Random) -> Vec<(DVec3, DVec3)> {
    let center = (bounds[0] + bounds[1]) * 0.5;
    (0..n)
        .map(|_| {
            let origin = center + random.direction() * bounds[0].distance(bounds[1]) * 0.5;
            (origin, (random.point(bounds) - origin).normalize())
        })
        .collect()
}
