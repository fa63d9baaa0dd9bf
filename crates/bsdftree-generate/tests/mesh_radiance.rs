//! What rays meet on smooth meshes, beside Radiance's rtrace, live.

mod bvh_scenes;

use std::fs;

use bsdftree_device::{Device, Unit};
use bsdftree_generate::bvh::{Bvh, Ray};
use bsdftree_testing::radiance::{doubles, printed, programs};
use bvh_scenes::Random;
use glam::{DVec3, dvec3};

const N_RAYS: usize = 4000;

#[test]
fn normals_and_texture_coordinates_of_a_smooth_mesh_are_rtraces() {
    if programs().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // A bumpy ball without poles, and one mirrored, turned and of another size.
    let radius = "(1+.1*sin(9*s)*cos(7*t))";
    let [x, y, z] = ["sin(.3+2.5*s)*cos(6*t)", "cos(.3+2.5*s)", "-sin(.3+2.5*s)*sin(6*t)"];
    let [x, y, z] = [x, y, z].map(|f| format!("{radius}*{f}"));
    let obj = printed("gensurf", folder, &["red", "ball", &x, &y, &z, "20", "30", "-s", "-o"], b"");
    fs::write(folder.join("ball.obj"), obj).unwrap();
    printed("obj2mesh", folder, &["ball.obj", "ball.rtm"], b"");
    let scene = |pattern: &str| {
        format!(
            "void brightfunc pattern 2 {pattern} . 0 0\npattern glow shine 0 0 4 1 1 1 0\n\
             shine mesh one 1 ball.rtm 0 0\nshine mesh two 10 ball.rtm -rx 30 -mz -s .7 -t 2.5 .1 .2 0 0\n"
        )
    };
    let mut random = Random(5);
    let rays: Vec<(DVec3, DVec3)> = (0..N_RAYS)
        .map(|k| {
            let center = if k % 2 == 0 { DVec3::ZERO } else { dvec3(2.5, 0.1, 0.2) };
            let origin = center + random.direction() * 1.2;
            (origin, (center + random.direction() * 0.5 - origin).normalize())
        })
        .collect();
    let input: String = rays
        .iter()
        .map(|(o, d)| format!("{:?} {:?} {:?} {:?} {:?} {:?}\n", o.x, o.y, o.z, d.x, d.y, d.z))
        .collect();
    let mut traced = Vec::new();
    for pattern in ["Lu", "Lv"] {
        fs::write(folder.join("s.rad"), scene(pattern)).unwrap();
        fs::write(folder.join("s.oct"), printed("oconv", folder, &["s.rad"], b"")).unwrap();
        let bytes =
            printed("rtrace", folder, &["-h", "-w", "-fad", "-opNnv", "-ab", "0", "s.oct"], input.as_bytes());
        let numbers = doubles(&bytes);
        assert_eq!(numbers.len(), 12 * N_RAYS);
        traced.push(numbers);
    }
    let device = Device::parse_rad(&scene("Lu"), "s.rad", folder, Unit::Meter).unwrap();
    let bvh = Bvh::build(&device).unwrap();
    let (mut n_hits, mut n_front, mut worst) = (0, 0, [0.0f64; 4]);
    for (k, &(origin, direction)) in rays.iter().enumerate() {
        let theirs = &traced[0][12 * k..12 * k + 12];
        let vector = |from: usize| DVec3::from_slice(&theirs[from..from + 3]);
        let Some(hit) = bvh.closest(&Ray { origin, direction, from: None }) else {
            assert_eq!(vector(3), DVec3::ZERO, "rtrace meets something on {origin} {direction}");
            continue;
        };
        let edge = {
            // Within rounding of an edge the one may meet this triangle, the other the next.
            vector(3).distance(hit.normal) > 1e-4 && vector(0).distance(hit.position) < 1e-4
        };
        if edge {
            continue;
        }
        n_hits += 1;
        let point = bvh.mesh_point(&hit).unwrap();
        let smooth = point.normal.unwrap_or(hit.normal);
        worst[0] = worst[0].max(vector(0).distance(hit.position));
        worst[1] = worst[1].max(vector(3).distance(hit.normal));
        worst[2] = worst[2].max(vector(6).distance(smooth));
        if hit.front {
            // Light leaves the front only.
            n_front += 1;
            let uv = [theirs[9], traced[1][12 * k + 9]];
            worst[3] = worst[3].max((point.uv[0] - uv[0]).abs().max((point.uv[1] - uv[1]).abs()));
        }
    }
    println!("{n_hits} hits, {n_front} on fronts; largest differences {worst:?}");
    assert!(n_hits > N_RAYS * 9 / 10 && n_front > N_RAYS / 2);
    assert!(worst[0] < 1e-6 && worst[1] < 1e-6 && worst[2] < 1e-5 && worst[3] < 1e-5, "{worst:?}");
}
