//! Meshes for the tracer: met as their triangles are, and what they know of the points where they are met.

mod bvh_scenes;

use bsdftree_device::mesh::{Mesh, Vertices};
use bsdftree_device::{Device, Shape};
use bsdftree_generate::bvh::{Bvh, BvhError, Ray};
use bvh_scenes::{Random, chords, device, mesh, shared_mesh, sphere_mesh, triangle};
use glam::{DVec3, dvec3};
use std::sync::Arc;

#[test]
fn a_mesh_is_met_as_its_triangles_are() {
    let sphere = sphere_mesh(40, 60, 0.1);
    let (apart, shared) = (Bvh::build(&mesh(&sphere)).unwrap(), Bvh::build(&shared_mesh(&sphere)).unwrap());
    let mut random = Random(3);
    let mut n_hits = 0;
    for (origin, direction) in chords(apart.bounds(), 20_000, &mut random) {
        // The first hit, and what a ray that goes straight on meets next. Parts of one device are not those of the other.
        let mut rays = [Ray { origin, direction, from: None }; 2];
        for _ in 0..2 {
            let hits = [apart.closest(&rays[0]), shared.closest(&rays[1])];
            let [Some(a), Some(b)] = hits else {
                assert_eq!(hits, [None, None]);
                break;
            };
            n_hits += 1;
            assert!((a.t - b.t).abs() < 1e-12 && a.normal.distance(b.normal) < 1e-9, "{a:?} {b:?}");
            assert_eq!((b.surface, b.part, b.front), (0, 1 + a.surface, a.front));
            rays = [a, b].map(|hit| Ray { origin: b.position, direction, from: Some(hit.part) });
        }
    }
    assert!(n_hits > 30_000, "only {n_hits} hits");
}

#[test]
fn meshes_interpolate_normals_and_texture_coordinates() {
    let vertices = Vertices {
        positions: vec![DVec3::ZERO, 4.0 * DVec3::X, 2.0 * DVec3::Y],
        normals: [dvec3(0.0, 0.0, 1.0), dvec3(0.6, 0.0, 0.8), dvec3(0.0, -0.8, 0.6)]
            .map(|n| n.as_vec3())
            .into(),
        uvs: [(0.0, 0.0), (1.0, 0.0), (0.0, 3.0)].map(Into::into).into(),
    };
    let flat = triangle(dvec3(0.0, 0.0, -1.0), dvec3(4.0, 0.0, -1.0), dvec3(0.0, 2.0, -1.0));
    let smooth = Shape::Mesh(Arc::new(Mesh { vertices: Arc::new(vertices), triangles: vec![[0, 1, 2]] }));
    let bvh = Bvh::build(&device([flat, smooth])).unwrap();
    let down = |x: f64, y: f64, z: f64| {
        let ray = Ray { origin: dvec3(x, y, z), direction: -DVec3::Z, from: None };
        bvh.closest(&ray).unwrap()
    };
    let hit = down(1.0, 0.5, 1.0);
    assert_eq!((hit.surface, hit.part, hit.normal), (1, 2, DVec3::Z));
    let point = bvh.mesh_point(&hit).unwrap();
    // Shares are 1/2, 1/4, 1/4.
    let expected = dvec3(0.15, -0.2, 0.5 + 0.2 + 0.15).normalize();
    assert!(point.normal.unwrap().distance(expected) < 1e-7, "{point:?}");
    assert!((point.uv[0] - 0.25).abs() < 1e-12 && (point.uv[1] - 0.75).abs() < 1e-12);
    assert_eq!(bvh.mesh_point(&down(1.0, 0.5, -0.5)), None);
}

#[test]
fn meshes_in_one_device_are_told_apart() {
    let sphere = sphere_mesh(8, 12, 0.0);
    let shapes = (0..5).flat_map(|k| {
        let Device { surfaces, .. } = shared_mesh(&sphere);
        let Shape::Mesh(mesh) = &surfaces[0].shape else { unreachable!() };
        let vertices = Arc::new(mesh.vertices.moved(|p| p + DVec3::X * (3.0 * k as f64), |n| n));
        let ball = Shape::Sphere { center: dvec3(3.0 * k as f64, 3.0, 0.0), radius: 1.0, inward: false };
        [ball, Shape::Mesh(Arc::new(Mesh { vertices, triangles: mesh.triangles.clone() }))]
    });
    let bvh = Bvh::build(&device(shapes)).unwrap();
    for k in 0..5 {
        let hit = bvh
            .closest(&Ray { origin: dvec3(3.0 * k as f64 + 0.1, 0.2, 5.0), direction: -DVec3::Z, from: None })
            .unwrap();
        assert_eq!(hit.surface, 2 * k + 1);
        let normal = bvh.mesh_point(&hit).unwrap().normal.unwrap();
        assert!(normal.distance((hit.position - DVec3::X * 3.0 * k as f64).normalize()) < 0.02);
    }
}

#[test]
fn a_mesh_with_wrong_indices_is_refused() {
    let vertices =
        Arc::new(Vertices { positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y], ..Default::default() });
    let wrong = Shape::Mesh(Arc::new(Mesh { vertices, triangles: vec![[0, 1, 3]] }));
    let error = Bvh::build(&device([wrong])).unwrap_err();
    assert!(matches!(error, BvhError::BadShape { .. }), "{error}");
}
