//! The tracer against brute force, on watertightness, on leaving surfaces, and on bad input.

mod bvh_scenes;

use bsdftree_device::material::Material;
use bsdftree_device::shape::Shape;
use bsdftree_device::{Device, NamedMaterial};
use bsdftree_generate::bvh::{Bvh, BvhError, Hit, Ray, Simd};
use bvh_scenes::{Random, blind, chords, device, mesh, mixture, shared_mesh, sphere_mesh, triangle};
use glam::{DVec3, dvec3};

fn ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray { origin, direction, from: None }
}

/// Textbook intersections, one shape after the other, in f64: distance of the first hit.
fn brute_force(device: &Device, ray: &Ray) -> Option<(f64, usize)> {
    let hits = device.surfaces.iter().enumerate().filter_map(|(i, s)| Some((distances(&s.shape, ray)?, i)));
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

fn distances(shape: &Shape, ray: &Ray) -> Option<f64> {
    let (o, d) = (ray.origin, ray.direction);
    let first = |ts: Vec<f64>| ts.into_iter().filter(|t| *t > 0.0).min_by(f64::total_cmp);
    let quadratic = |a: f64, b: f64, c: f64| {
        let root = (b * b - 4.0 * a * c).sqrt();
        vec![(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)]
    };
    match shape {
        Shape::Polygon(_) | Shape::Mesh(_) => {
            first(shape.triangulate().iter().filter_map(|t| moller_trumbore(t, o, d)).collect())
        }
        Shape::Sphere { center, radius, .. } => {
            let m = o - center;
            first(quadratic(1.0, 2.0 * m.dot(d), m.dot(m) - radius * radius))
        }
        Shape::Cylinder { ends, radius, .. } => stump(ends, [*radius; 2], o, d, quadratic),
        Shape::Cone { ends, radii, .. } => stump(ends, *radii, o, d, quadratic),
        Shape::Ring { center, normal, radii } => {
            let t = (center - o).dot(*normal) / d.dot(*normal);
            let r = (o + d * t).distance(*center);
            (t > 0.0 && r >= radii[0] && r <= radii[1]).then_some(t)
        }
    }
}

fn moller_trumbore([a, b, c]: &[DVec3; 3], o: DVec3, d: DVec3) -> Option<f64> {
    let (e1, e2) = (b - a, c - a);
    let p = d.cross(e2);
    let det = e1.dot(p);
    let s = o - a;
    let (u, q) = (s.dot(p) / det, s.cross(e1));
    let v = d.dot(q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some(e2.dot(q) / det)
}

/// The quadric through two circles: |x − axis|² = radius(h)², by its values at three points of the ray.
fn stump(
    ends: &[DVec3; 2],
    radii: [f64; 2],
    o: DVec3,
    d: DVec3,
    quadratic: impl Fn(f64, f64, f64) -> Vec<f64>,
) -> Option<f64> {
    let length = ends[0].distance(ends[1]);
    let axis = (ends[1] - ends[0]) / length;
    let height = |t: f64| (o + d * t - ends[0]).dot(axis);
    let f = |t: f64| {
        let (p, h) = (o + d * t - ends[0], height(t));
        p.dot(p) - h * h - (radii[0] + (radii[1] - radii[0]) * h / length).powi(2)
    };
    let (f0, f1, f2) = (f(0.0), f(1.0), f(-1.0));
    let ts = quadratic((f1 + f2) / 2.0 - f0, (f1 - f2) / 2.0, f0);
    let inside = |t: &f64| *t > 0.0 && height(*t) >= 0.0 && height(*t) <= length;
    ts.into_iter().filter(inside).min_by(f64::total_cmp)
}

fn random_rays(bvh: &Bvh, n: usize, random: &mut Random) -> Vec<Ray> {
    let bounds = bvh.bounds();
    let mut rays: Vec<Ray> = chords(bounds, n / 2, random).into_iter().map(|(o, d)| ray(o, d)).collect();
    rays.extend((n / 2..n).map(|_| ray(random.point(bounds), random.direction())));
    rays
}

#[test]
fn closest_hit_is_that_of_brute_force() {
    let mut random = Random(11);
    let scenes = [
        mixture(120, 0.2, true, &mut random),
        mixture(300, 0.05, true, &mut random),
        mixture(7, 1.0, true, &mut random),
        mixture(1, 1.0, false, &mut random),
    ];
    let mut n_hits = 0;
    for device in &scenes {
        let bvh = Bvh::build(device).unwrap();
        for r in random_rays(&bvh, 30_000, &mut random) {
            let (found, expected) = (bvh.closest(&r), brute_force(device, &r));
            match (found, expected) {
                (None, None) => {}
                (Some(hit), Some((t, surface))) => {
                    n_hits += 1;
                    // Two surfaces may lie within rounding of each other, and a graze is ill-conditioned.
                    let same = hit.surface as usize == surface && (hit.t - t).abs() < 1e-9;
                    assert!(same || (hit.t - t).abs() < 1e-12, "{r:?}: {hit:?}, expected {t} on {surface}");
                    assert!(hit.position.distance(r.origin + r.direction * hit.t) < 1e-11);
                }
                _ => panic!("{r:?}: {found:?}, expected {expected:?}"),
            }
        }
    }
    assert!(n_hits > 30_000, "only {n_hits} rays hit anything");
}

#[test]
fn kernels_agree_to_the_bit() {
    if !Simd::Avx2.is_available() {
        println!("SKIPPED: this processor has no AVX2");
        return;
    }
    let mut random = Random(12);
    for device in [mixture(500, 0.1, true, &mut random), blind(), mesh(&sphere_mesh(40, 60, 0.1))] {
        let avx2 = Bvh::build(&device).unwrap().with_simd(Simd::Avx2).unwrap();
        let portable = avx2.clone().with_simd(Simd::Portable).unwrap();
        for r in random_rays(&avx2, 50_000, &mut random) {
            assert_eq!(avx2.closest(&r), portable.closest(&r), "{r:?}");
        }
    }
}

/// Rays from inside a closed mesh that meet nothing.
fn n_leaks(bvh: &Bvh, rays: impl Iterator<Item = Ray>) -> usize {
    rays.filter(|r| bvh.closest(r).is_none()).count()
}

#[test]
fn closed_mesh_does_not_leak() {
    let shape = sphere_mesh(30, 40, 0.1);
    let (corners, faces) = &shape;
    let mut random = Random(13);
    for simd in [Simd::Avx2, Simd::Portable].into_iter().filter(|s| s.is_available()) {
        let bvh = Bvh::build(&mesh(&shape)).unwrap().with_simd(simd).unwrap();
        let inner = [DVec3::splat(-0.4), DVec3::splat(0.4)];
        let n = 1_000_000;
        let anywhere = (0..n).map(|_| ray(random.point(inner), random.direction()));
        assert_eq!(n_leaks(&bvh, anywhere), 0, "{simd:?}, random rays");
        let aimed = (0..n).map(|k| {
            let face = faces[random.bits() as usize % faces.len()];
            let (a, b) = (corners[face[0]], corners[face[1]]);
            let target = if k % 2 == 0 { a } else { a + (b - a) * random.unit() };
            let origin = random.point(inner);
            ray(origin, (target - origin).normalize())
        });
        assert_eq!(n_leaks(&bvh, aimed), 0, "{simd:?}, rays aimed at vertices and edges");
    }
}

#[test]
fn axis_parallel_rays_meet_edges_and_vertices_of_a_grid() {
    let n = 8;
    let at = |i: usize, j: usize| dvec3(i as f64 / 4.0 - 1.0, j as f64 / 4.0 - 1.0, 0.0);
    let square = |k: usize| {
        let (i, j) = (k % n, k / n);
        Shape::Polygon(vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])
    };
    let bvh = Bvh::build(&device((0..n * n).map(square))).unwrap();
    for i in 0..=4 * n {
        for j in 0..=4 * n {
            let target = dvec3(i as f64 / 16.0 - 1.0, j as f64 / 16.0 - 1.0, 0.0);
            for z in [1.0, -1.0] {
                let hit = bvh
                    .closest(&ray(target + DVec3::Z * z, -DVec3::Z * z))
                    .unwrap_or_else(|| panic!("{target} {z}"));
                assert_eq!((hit.t, hit.front, hit.normal), (1.0, z > 0.0, DVec3::Z));
            }
        }
    }
}

/// Leave a surface in a random direction of the hemisphere on one side; every `grazing`-th almost along the surface.
fn leave(hit: &Hit, to_front: bool, grazing: f64, random: &mut Random) -> Ray {
    let side = if to_front { hit.normal } else { -hit.normal };
    let d = random.direction();
    let along = (d - side * side.dot(d)).normalize();
    let up = if random.unit() < 0.5 { grazing } else { random.between(0.01, 1.0) };
    Ray { origin: hit.position, direction: (along + side * up).normalize(), from: Some(hit.part) }
}

fn slab(width: f64, thickness: f64, n: usize) -> Device {
    let mut shapes = Vec::new();
    let at = |i: usize, j: usize, z: f64| {
        dvec3(width * (i as f64 / n as f64 - 0.5), width * (j as f64 / n as f64 - 0.5), z)
    };
    for k in 0..n * n {
        let (i, j) = (k % n, k / n);
        shapes.push(Shape::Polygon(vec![
            at(i, j, thickness),
            at(i + 1, j, thickness),
            at(i + 1, j + 1, thickness),
            at(i, j + 1, thickness),
        ]));
        shapes.push(Shape::Polygon(vec![
            at(i, j, 0.0),
            at(i, j + 1, 0.0),
            at(i + 1, j + 1, 0.0),
            at(i + 1, j, 0.0),
        ]));
    }
    for k in 0..n {
        for (a, b) in [((k, 0), (k + 1, 0)), ((n, k), (n, k + 1)), ((k + 1, n), (k, n)), ((0, k + 1), (0, k))]
        {
            let bottom = [at(a.0, a.1, 0.0), at(b.0, b.1, 0.0)];
            let top = [at(b.0, b.1, thickness), at(a.0, a.1, thickness)];
            shapes.push(Shape::Polygon([bottom, top].concat()));
        }
    }
    device(shapes)
}

/// Random walks inside a closed device whose normals face out: every ray must meet another surface's back.
fn walk_inside(device: &Device, start: DVec3, n_paths: usize, n_bounces: usize, grazing: f64, curved: bool) {
    let bvh = Bvh::build(device).unwrap();
    let mut random = Random(14);
    for _ in 0..n_paths {
        let mut r = ray(start, random.direction());
        for bounce in 0..n_bounces {
            let hit = bvh.closest(&r).unwrap_or_else(|| panic!("leaked at bounce {bounce}: {r:?}"));
            assert!(!hit.front, "front met from inside at bounce {bounce}: {r:?}, {hit:?}");
            assert!(curved || Some(hit.part) != r.from, "met itself: {r:?}, {hit:?}");
            r = leave(&hit, false, grazing, &mut random);
        }
    }
}

#[test]
fn paths_stay_inside_a_thin_slab() {
    for grazing in [1e-2, 1e-5] {
        walk_inside(&slab(6.0, 1e-3, 4), dvec3(0.1, 0.2, 5e-4), 300, 300, grazing, false);
    }
}

#[test]
fn paths_stay_inside_a_rotated_slab_far_from_the_origin() {
    let turn = glam::DQuat::from_rotation_z(0.3) * glam::DQuat::from_rotation_x(0.7);
    let mut device = slab(6.0, 1e-3, 4);
    let place = |p: DVec3| turn * p + dvec3(120.0, -35.0, 70.0);
    for surface in &mut device.surfaces {
        let Shape::Polygon(corners) = &mut surface.shape else { unreachable!() };
        corners.iter_mut().for_each(|p| *p = place(*p));
    }
    walk_inside(&device, place(dvec3(0.1, 0.2, 5e-4)), 300, 300, 1e-3, false);
}

#[test]
fn paths_stay_inside_spheres_tubes_and_cones() {
    let sphere = device([Shape::Sphere { center: dvec3(3.0, 1.0, -2.0), radius: 0.25, inward: false }]);
    walk_inside(&sphere, dvec3(3.1, 1.1, -2.0), 300, 300, 1e-6, true);
    let disk =
        |z: f64, r: f64| Shape::Ring { center: DVec3::Z * z, normal: DVec3::Z * (z - 1.0), radii: [0.0, r] };
    let mut can = device([
        Shape::Cylinder { ends: [DVec3::ZERO, DVec3::Z * 2.0], radius: 0.5, inward: false },
        disk(0.0, 0.5),
        disk(2.0, 0.5),
    ]);
    walk_inside(&can, dvec3(0.1, 0.1, 1.0), 300, 300, 1e-4, true);
    can.surfaces[0].shape =
        Shape::Cone { ends: [DVec3::ZERO, DVec3::Z * 2.0], radii: [0.5, 0.1], inward: false };
    can.surfaces[2].shape = disk(2.0, 0.1);
    walk_inside(&can, dvec3(0.1, 0.1, 1.0), 300, 300, 1e-4, true);
}

#[test]
fn paths_stay_inside_a_bumpy_mesh() {
    let bumpy = sphere_mesh(60, 80, 0.1);
    walk_inside(&mesh(&bumpy), DVec3::ZERO, 300, 300, 1e-4, false);
    walk_inside(&shared_mesh(&bumpy), DVec3::ZERO, 300, 300, 1e-4, false);
}

#[test]
fn leaving_a_convex_surface_meets_nothing() {
    let scenes = [
        (slab(6.0, 1e-3, 4), dvec3(0.3, 0.4, 1.0)),
        (mesh(&sphere_mesh(60, 80, 0.0)), dvec3(3.0, 2.0, 1.0)),
        (device([Shape::Sphere { center: DVec3::X, radius: 1e-3, inward: false }]), dvec3(40.0, 2.0, 1.0)),
        (
            device([Shape::Cylinder { ends: [DVec3::X, DVec3::Y], radius: 0.1, inward: false }]),
            dvec3(2.0, 2.0, 1.0),
        ),
        (
            device([Shape::Cone { ends: [DVec3::X, DVec3::Y], radii: [0.2, 0.0], inward: false }]),
            dvec3(2.0, 2.0, 1.0),
        ),
    ];
    let mut random = Random(15);
    for (device, eye) in &scenes {
        let bvh = Bvh::build(device).unwrap();
        let mut n = 0;
        while n < 20_000 {
            let direction = (random.point(bvh.bounds()) - eye).normalize();
            let Some(hit) = bvh.closest(&ray(*eye, direction)).filter(|hit| hit.front) else { continue };
            n += 1;
            let r = leave(&hit, true, 1e-5, &mut random);
            assert_eq!(bvh.closest(&r), None, "{r:?}");
        }
    }
}

#[test]
fn walks_from_edges_and_corners_of_a_room_do_not_leak() {
    let room = slab(1.0, 1.0, 2);
    let bvh = Bvh::build(&room).unwrap();
    let mut random = Random(16);
    let start = dvec3(0.05, 0.1, 0.45);
    for k in 0..50_000 {
        let edge = |free: bool, x: f64| if free { x } else { x.round() };
        let p = dvec3(random.unit(), random.unit(), random.unit());
        let target =
            dvec3(edge(k % 4 == 0, p.x), edge(k % 4 == 1, p.y), edge(k % 4 == 2, p.z)) - dvec3(0.5, 0.5, 0.0);
        let mut r = ray(start, (target - start).normalize());
        for _ in 0..4 {
            let hit = bvh.closest(&r).unwrap_or_else(|| panic!("leaked: {r:?}"));
            assert!(!hit.front, "{r:?} {hit:?}");
            r = leave(&hit, false, 0.1, &mut random);
        }
    }
}

#[test]
fn chords_of_a_sphere_keep_their_length() {
    let (center, radius) = (dvec3(1.0, 2.0, 3.0), 0.7);
    let bvh = Bvh::build(&device([Shape::Sphere { center, radius, inward: true }])).unwrap();
    let first = bvh.closest(&ray(center + dvec3(0.1, 0.0, 0.0), DVec3::Y)).unwrap();
    let mut r = Ray { origin: first.position, direction: DVec3::Y, from: Some(first.part) };
    for _ in 0..10_000 {
        // Reflect: the path stays in a plane, all chords are equal.
        let n = (r.origin - center).normalize();
        r.direction = (r.direction - 2.0 * n * n.dot(r.direction)).normalize();
        let hit = bvh.closest(&r).unwrap();
        assert!(hit.front, "the bubble's normal points in");
        assert!((hit.t - 2.0 * (radius * radius - 0.01f64).sqrt()).abs() < 1e-9, "{hit:?}");
        r.origin = hit.position;
    }
}

#[test]
fn hits_far_away_are_exact() {
    let mut random = Random(17);
    let scene = mixture(60, 0.3, false, &mut random);
    let bvh = Bvh::build(&scene).unwrap();
    let mut n_hits = 0;
    for _ in 0..20_000 {
        let target = random.point(bvh.bounds());
        let d = random.direction();
        let near = ray(target - d * 4.0, d);
        let far = ray(target - d * 4000.0, d);
        if let (Some(a), Some(b)) = (bvh.closest(&near), bvh.closest(&far)) {
            n_hits += 1;
            assert!(a.surface != b.surface || (a.t + 3996.0 - b.t).abs() < 1e-6, "{a:?} {b:?}");
        }
    }
    assert!(n_hits > 5_000);
}

#[test]
fn triangles_are_hit_at_any_scale() {
    for scale in [1e-9, 1e-3, 1e6] {
        let bvh = Bvh::build(&device([triangle(DVec3::ZERO, DVec3::X * scale, DVec3::Y * scale)])).unwrap();
        let origin = dvec3(0.2, 0.3, 7.0) * scale;
        let hit = bvh.closest(&ray(origin, -DVec3::Z)).unwrap();
        assert!(
            (hit.t / scale - 7.0).abs() < 1e-12 && hit.front && hit.normal.distance(DVec3::Z) < 1e-15,
            "{scale}: {hit:?}"
        );
    }
}

#[test]
fn rays_on_a_surface_hit_it_unless_they_left_it() {
    let bvh = Bvh::build(&device([triangle(DVec3::ZERO, DVec3::X, DVec3::Y)])).unwrap();
    let mut r = ray(dvec3(0.2, 0.2, 0.0), DVec3::Z);
    assert_eq!(bvh.closest(&r).map(|h| (h.t, h.front)), Some((0.0, false)));
    r.from = Some(0);
    assert_eq!(bvh.closest(&r), None);
}

#[test]
fn void_surfaces_are_not_there() {
    let near = triangle(DVec3::ZERO, DVec3::X, DVec3::Y);
    let far = triangle(-DVec3::Z, DVec3::X - DVec3::Z, DVec3::Y - DVec3::Z);
    let mut device = device([near, far]);
    device.materials.push(NamedMaterial { name: "void".into(), material: Material::Void });
    device.surfaces[0].material = 1;
    let hit = Bvh::build(&device).unwrap().closest(&ray(dvec3(0.2, 0.2, 1.0), -DVec3::Z)).unwrap();
    assert_eq!((hit.surface, hit.material, hit.t), (1, 0, 2.0));
    device.surfaces[1].material = 1;
    assert_eq!(Bvh::build(&device).unwrap_err(), BvhError::NothingToHit { n_surfaces: 2 });
}

#[test]
fn degenerate_triangles_neither_stop_the_build_nor_hide_others() {
    let p = dvec3(1.0, 2.0, 3.0);
    let good = triangle(DVec3::ZERO, DVec3::X, DVec3::Y);
    let mut shapes = vec![good.clone(); 10_000];
    shapes.extend((0..10_000).map(|k| triangle(p, p * k as f64, p * 2.0)));
    shapes.extend((0..1000).map(|_| triangle(p, p, p)));
    shapes.push(Shape::Polygon(vec![]));
    shapes.push(Shape::Polygon(vec![p]));
    shapes.push(Shape::Polygon(vec![p, DVec3::ZERO]));
    let bvh = Bvh::build(&device(shapes)).unwrap();
    let hit = bvh.closest(&ray(dvec3(0.2, 0.2, 1.0), -DVec3::Z)).unwrap();
    assert_eq!((hit.surface, hit.t), (0, 1.0), "the first of coincident surfaces");
    assert_eq!(Bvh::build(&device([])).unwrap_err(), BvhError::NothingToHit { n_surfaces: 0 });
    let flat = Bvh::build(&device([triangle(p, p, p)])).unwrap_err();
    assert_eq!(flat, BvhError::NothingToHit { n_surfaces: 1 });
}

#[test]
fn exponentially_nested_triangles_build_and_trace() {
    let shapes = (0..1000).map(|k| {
        let s = 0.5f64.powi(k % 900);
        triangle(DVec3::ZERO, DVec3::X * s, DVec3::Y * s) // all share a corner
    });
    let bvh = Bvh::build(&device(shapes)).unwrap();
    assert_eq!(bvh.closest(&ray(dvec3(0.4, 0.4, 1.0), -DVec3::Z)).unwrap().surface, 0);
}

#[test]
fn rays_that_are_not_finite_meet_nothing() {
    let bvh = Bvh::build(&blind()).unwrap();
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        for axis in 0..3 {
            let (mut o, mut d) = (bvh.bounds()[0] + 0.01, DVec3::Z);
            o[axis] = bad;
            assert_eq!(bvh.closest(&ray(o, DVec3::new(0.6, 0.0, 0.8))), None);
            if bad != 1e300 {
                d[axis] = bad;
                assert_eq!(bvh.closest(&ray(bvh.bounds()[0] + 0.01, d)), None);
            }
        }
    }
    assert_eq!(bvh.closest(&ray(bvh.bounds()[0] + 0.01, DVec3::ZERO)), None);
}

#[test]
fn errors_name_the_surface_and_what_is_wrong() {
    let good = triangle(DVec3::ZERO, DVec3::X, DVec3::Y);
    let bad: [(Shape, &str); 8] = [
        (triangle(DVec3::X, DVec3::splat(f64::NAN), DVec3::Y), "a vertex is [NaN"),
        (triangle(DVec3::X, DVec3::splat(f64::INFINITY), DVec3::Y), "a vertex is [inf"),
        (Shape::Sphere { center: DVec3::X, radius: 0.0, inward: false }, "the radius is 0"),
        (Shape::Sphere { center: DVec3::X, radius: f64::INFINITY, inward: false }, "the radius is inf"),
        (
            Shape::Cylinder { ends: [DVec3::X; 2], radius: 1.0, inward: true },
            "the distance between its ends is 0",
        ),
        (Shape::Cone { ends: [DVec3::X, DVec3::Y], radii: [1.0, -1.0], inward: true }, "a radius is -1"),
        (
            Shape::Ring { center: DVec3::X, normal: DVec3::ZERO, radii: [0.0, 1.0] },
            "the length of the normal is 0",
        ),
        (triangle(DVec3::X * -1e308, DVec3::X * 1.7e308, DVec3::Y), "a vertex is [-1e308, "),
    ];
    for (shape, message) in bad {
        let text = Bvh::build(&device([good.clone(), shape])).map(|_| "built").unwrap_err().to_string();
        assert!(text.contains(message), "{text}");
        assert!(text.contains("\"s1\" (number 1)"), "{text}");
    }
    let mut lost = device([good]);
    lost.surfaces[0].material = 5;
    let text = Bvh::build(&lost).unwrap_err().to_string();
    assert!(text.contains("\"s0\" (number 0) has material 5, but the device has 1"), "{text}");
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let device = mesh(&sphere_mesh(100, 120, 0.1));
    let build = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        format!("{:?}", pool.install(|| Bvh::build(&device).unwrap()))
    };
    assert!(build(1) == build(4));
}
