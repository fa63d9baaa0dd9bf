//! Do the f32 filters ever lose a hit? Every facet is put to the f64 test directly and the result compared to the bit.

#[path = "../../tests/bvh_scenes/mod.rs"]
mod bvh_scenes;

use glam::{DVec3, dvec3};

use super::traverse::LocalRay;
use super::{Bvh, NO_PART, Ray, Simd};
use bvh_scenes::{Random, device, sphere_mesh, triangle};

/// Least (t, part) over all facets, without tree and filters.
fn every_facet(bvh: &Bvh, ray: &Ray) -> Option<(f64, u32)> {
    let local = LocalRay::new(bvh, ray)?;
    let on_plane = if ray.from.is_some() { bvh.on_plane } else { 0.0 };
    let mut best = (f64::INFINITY, NO_PART);
    for leaf in &bvh.leaves {
        for lane in
            (0..super::WIDTH).filter(|&lane| leaf.slack[lane] > 0.0 && Some(leaf.parts[lane]) != ray.from)
        {
            let facet = &bvh.facets[leaf.first as usize + lane];
            let hit = facet.hit(local.origin, ray.direction, f64::INFINITY, on_plane, bvh.slack);
            if let Some(t) = hit.filter(|&t| (t, leaf.parts[lane]) < best) {
                best = (t, leaf.parts[lane]);
            }
        }
    }
    (best.1 != NO_PART).then_some((best.0 * bvh.frame.scale + local.skipped, best.1))
}

/// Rays at everything an edge function can get wrong: corners, edges, planes, near and far, along axes, from surfaces.
fn hard_rays(triangles: &[[DVec3; 3]], n: usize, random: &mut Random) -> Vec<Ray> {
    let mut rays = Vec::new();
    for k in 0..n {
        let [a, b, c] = triangles[random.bits() as usize % triangles.len()];
        let edge = a + (b - a) * random.unit();
        let target = [a, edge, edge + (c - edge) * random.unit()][k % 3];
        let other = triangles[random.bits() as usize % triangles.len()];
        let distance = 10f64.powf(random.between(-6.0, 1.0)) * (a - target).length().max(b.distance(c));
        let in_plane =
            (c - target).normalize_or(DVec3::X) + random.direction() * 10f64.powf(random.between(-9.0, 0.0));
        let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z][k % 3];
        let directions =
            [random.direction(), in_plane.normalize(), axis, (target - other[k % 3]).normalize_or(axis)];
        let direction = directions[random.bits() as usize % 4];
        rays.push(Ray { origin: target - direction * distance, direction, from: None });
        rays.push(Ray {
            origin: target,
            direction,
            from: Some(random.bits() as u32 % triangles.len() as u32),
        });
    }
    rays
}

fn filters_lose_nothing_on(triangles: &[[DVec3; 3]], n_rays: usize, seed: u64) {
    let built = Bvh::build(&device(triangles.iter().map(|&[a, b, c]| triangle(a, b, c)))).unwrap();
    let mut random = Random(seed);
    let rays = hard_rays(triangles, n_rays, &mut random);
    let mut n_hits = 0;
    for simd in [Simd::Portable, Simd::Avx2].into_iter().filter(|s| s.is_available()) {
        let bvh = built.clone().with_simd(simd).unwrap();
        for ray in &rays {
            let found = bvh.closest(ray).map(|hit| (hit.t, hit.part));
            assert_eq!(found, every_facet(&bvh, ray), "{simd:?} {ray:?}");
            n_hits += found.is_some() as usize;
        }
    }
    assert!(n_hits > n_rays / 2, "only {n_hits} hits of {}", 4 * n_rays);
}

#[test]
fn filters_lose_nothing_of_a_mesh() {
    let (corners, faces) = sphere_mesh(20, 30, 0.2);
    let triangles: Vec<_> = faces.iter().map(|f| f.map(|i| corners[i])).collect();
    filters_lose_nothing_on(&triangles, 20_000, 1);
}

#[test]
fn filters_lose_nothing_of_needles_and_specks_among_walls() {
    let mut random = Random(2);
    let cube = [-DVec3::ONE, DVec3::ONE];
    let size = |random: &mut Random| 10f64.powf(random.between(-7.0, 0.3));
    let triangles: Vec<_> = (0..300)
        .map(|_| {
            let a = random.point(cube);
            let (b, c) =
                (a + random.direction() * size(&mut random), a + random.direction() * size(&mut random));
            [a, b, c]
        })
        .collect();
    filters_lose_nothing_on(&triangles, 50_000, 3);
    let far = dvec3(1e4, -3e3, 2e2);
    let moved: Vec<_> = triangles.iter().map(|t| t.map(|p| p * 0.01 + far)).collect();
    filters_lose_nothing_on(&moved, 20_000, 4);
}

#[test]
fn filters_lose_nothing_of_long_slats() {
    let slat = |k: usize| {
        let at = |x: f64, s: f64| dvec3(x, k as f64 * 0.05 + s * 0.03, s * 0.04);
        [[at(0.0, 0.0), at(6.0, 0.0), at(6.0, 1.0)], [at(0.0, 0.0), at(6.0, 1.0), at(0.0, 1.0)]]
    };
    let triangles: Vec<_> = (0..60).flat_map(slat).collect();
    filters_lose_nothing_on(&triangles, 50_000, 5);
}
