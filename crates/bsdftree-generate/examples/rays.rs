//! Closest hits per second of single rays, and the same scenes and rays as files for another tracer:
//! `rays` prints a line "scene kind rays/s hits" for each scene and kind of ray, `rays FOLDER` writes them there instead.
//! See `benches/generate/raw_speed.py`.

#[path = "../tests/bvh_scenes/mod.rs"]
mod bvh_scenes;

use std::fs;
use std::path::Path;
use std::time::Instant;

use bsdftree_device::Device;
use bsdftree_device::shape::Shape;
use bsdftree_generate::bvh::{Bvh, Ray};
use bvh_scenes::{Random, blind, chords, mesh, mixture, sphere_mesh};
use glam::DVec3;

const N_RAYS: usize = 1 << 16;

/// Distance within which a tracer that does not know what a ray has left must not look, in parts of the device's size.
const SELF: f64 = 1e-5;

fn main() -> std::io::Result<()> {
    let scenes = [
        ("blind", blind()),
        ("mesh", mesh(&sphere_mesh(200, 250, 0.1))),
        ("quadrics", mixture(1000, 0.05, false, &mut Random(2))),
    ];
    for (name, device) in &scenes {
        let bvh = Bvh::build(device).expect("the scenes are valid");
        let kinds = rays(&bvh);
        match std::env::args().nth(1) {
            Some(folder) => write(Path::new(&folder), name, device, &bvh, &kinds)?,
            None => kinds.iter().for_each(|(kind, rays)| time(name, kind, &bvh, rays)),
        }
    }
    Ok(())
}

/// Rays that come in through the front of the device's box as paths do, chords of a sphere around it, and rays that leave
/// the surfaces which those meet. In no order.
fn rays(bvh: &Bvh) -> [(&'static str, Vec<Ray>); 3] {
    let mut random = Random(1);
    let [low, high] = bvh.bounds();
    let margin = 1e-6 * (high - low).min_element();
    let incoming: Vec<Ray> = (0..N_RAYS)
        .map(|_| {
            let place = random.point([low.with_z(high.z), high]);
            let direction = (random.direction() * 0.999 - DVec3::Z).normalize();
            Ray { origin: place - direction * margin, direction, from: None }
        })
        .collect();
    let chords = chords([low, high], N_RAYS, &mut random);
    let chords: Vec<Ray> =
        chords.into_iter().map(|(origin, direction)| Ray { origin, direction, from: None }).collect();
    let starts = incoming.iter().zip(&chords).flat_map(|(a, b)| [a, b]);
    let bounces = starts.filter_map(|ray| bvh.closest(ray)).map(|hit| {
        let side = if hit.front { hit.normal } else { -hit.normal };
        let direction = (side + random.direction() * 0.999).normalize();
        Ray { origin: hit.position, direction, from: Some(hit.part) }
    });
    let bounces = bounces.take(N_RAYS).collect();
    [("incoming", incoming), ("chords", chords), ("bounces", bounces)]
}

fn time(scene: &str, kind: &str, bvh: &Bvh, rays: &[Ray]) {
    let mut best = f64::INFINITY;
    let mut hits = 0;
    for _ in 0..20 {
        let begin = Instant::now();
        hits = rays.iter().filter(|ray| bvh.closest(ray).is_some()).count();
        best = best.min(begin.elapsed().as_secs_f64());
    }
    println!("{scene} {kind} {:.0} {hits}", rays.len() as f64 / best);
}

/// SCENE.triangles: 9 f32 each. SCENE.quadrics: an u32 for sphere, cylinder or cone, ring; two points or a point and a
/// direction, two radii. SCENE.KIND.rays: origin, direction, least distance.
fn write(
    folder: &Path,
    scene: &str,
    device: &Device,
    bvh: &Bvh,
    kinds: &[(&str, Vec<Ray>)],
) -> std::io::Result<()> {
    let bytes = |numbers: &[f64]| numbers.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect::<Vec<u8>>();
    let (mut triangles, mut quadrics) = (Vec::new(), Vec::new());
    for shape in device.surfaces.iter().map(|surface| &surface.shape) {
        let (kind, a, b, radii) = match shape {
            Shape::Polygon(_) | Shape::Mesh(_) => {
                let corners = shape.triangulate().into_iter().flatten();
                triangles.extend(corners.flat_map(|p| bytes(&p.to_array())));
                continue;
            }
            Shape::Sphere { center, radius, .. } => (0u32, center, &DVec3::ZERO, [*radius, 0.0]),
            Shape::Cylinder { ends: [a, b], radius, .. } => (1, a, b, [*radius; 2]),
            Shape::Cone { ends: [a, b], radii, .. } => (1, a, b, *radii),
            Shape::Ring { center, normal, radii } => (2, center, normal, *radii),
        };
        quadrics.extend(kind.to_le_bytes());
        quadrics.extend([a, b].iter().flat_map(|p| bytes(&p.to_array())));
        quadrics.extend(bytes(&radii));
    }
    fs::write(folder.join(format!("{scene}.triangles")), triangles)?;
    fs::write(folder.join(format!("{scene}.quadrics")), quadrics)?;
    let [low, high] = bvh.bounds();
    let least = |ray: &Ray| if ray.from.is_some() { SELF * low.distance(high) } else { 0.0 };
    for (kind, rays) in kinds {
        let file = rays.iter().flat_map(|ray| {
            let [origin, direction] = [ray.origin, ray.direction].map(|v| bytes(&v.to_array()));
            [origin, direction, bytes(&[least(ray)])].concat()
        });
        fs::write(folder.join(format!("{scene}.{kind}.rays")), file.collect::<Vec<u8>>())?;
    }
    Ok(())
}
