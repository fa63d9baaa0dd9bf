//! Ramps in leaves: what they keep, what they reproduce, and what they gain on functions that are known.

mod common;

use std::f64::consts::PI;

use bsdftree::convert::TreeOptions;
use bsdftree::square::disk_from_square;
use bsdftree::tree::Position;
use bsdftree::{Bsdf, Direction, Part, Rank, Scattering, Side, Tree};
use common::{Random, random_tree};

/// A direction on the front whose disk point lies at a point of the square; incident coordinates are those of its opposite.
fn direction(square: [f64; 2], sign: f64) -> Direction {
    Side::Front.direction_from_disk(disk_from_square(square).map(|x| sign * x))
}

/// The directions of a place in a rank-4 tree.
fn pair([a, b, c, d]: [f64; 4]) -> [Direction; 2] {
    [direction([a, b], -1.0), direction([c, d], 1.0)]
}

#[test]
fn the_mean_of_every_leaf_is_kept_and_nothing_is_negative() {
    let mut random = Random(11);
    let tree = random_tree(Rank::Four, 4, &mut random);
    let smooth = tree.smooth();
    assert!(smooth.is_smooth() && !tree.is_smooth() && smooth.clone().is_smooth());
    for leaf in tree.leaves().step_by(7) {
        let edge = 0.5f64.powi(leaf.level as i32);
        let mut sum = 0.0;
        // Opposite corners, a little inside: of a linear function they have the mean.
        for corner in 0..16 {
            let place = std::array::from_fn(|i| {
                let inside = if corner >> i & 1 == 1 { 0.999 } else { 0.001 };
                (f64::from(leaf.cell[i]) + inside) * edge
            });
            let [incident, exitant] = pair(place);
            let value = smooth.eval(incident, exitant);
            assert!(value >= 0.0, "{value} in {leaf:?}");
            sum += value / 16.0;
        }
        assert!((sum - f64::from(leaf.value)).abs() <= 1e-9 * f64::from(leaf.value), "{sum} {leaf:?}");
    }
}

#[test]
fn leaves_and_values_in_files_stay_as_they_are() {
    let mut random = Random(12);
    let tree = random_tree(Rank::Three, 4, &mut random);
    let smooth = tree.smooth();
    assert!(tree.leaves().eq(smooth.leaves()));
    for _ in 0..200 {
        let (a, b) = (random.direction(), random.direction());
        let position = Position::new(Rank::Three, a, b);
        assert_eq!(smooth.leaf_at(position), tree.leaf_at(position));
        assert_eq!(smooth.projected_solid_angle(a, b), tree.projected_solid_angle(a, b));
    }
}

#[test]
fn a_tree_of_one_leaf_is_smooth_too() {
    for rank in [Rank::Three, Rank::Four] {
        let smooth = Tree::uniform(rank, 0.25).smooth();
        let (i, o) = ([0.6, 0.0, 0.8], [0.0, 0.6, 0.8]);
        assert_eq!(smooth.eval(i, o), 0.25);
        assert!((smooth.hemispherical(i, false) - 0.25 * PI).abs() < 1e-12);
        let mut many = [0.0];
        smooth.eval_many(&[i], &[o], &mut many);
        assert_eq!(many, [0.25]);
        let sampled = smooth.lobe(i, false).sample(0.3, None);
        assert_eq!(sampled.map(|s| s.1), Some(0.25));
    }
}

#[test]
fn no_more_light_comes_out_than_from_the_cells_around() {
    // A mirror's peak, a cell wide or two, that wanders with the incident direction: all light, whatever that is.
    let n = 16usize;
    let values: Vec<f32> = (0..n.pow(4))
        .map(|k| {
            let [a, b, c, d] = [k / 4096, k / 256 % 16, k / 16 % 16, k % 16];
            let peak = |i: usize, o: usize| match (o + 20 - i - i / 3) % 16 {
                0 => 0.7,
                1 => 0.3,
                _ => 0.0,
            };
            (peak(a, c) * peak(b, d) * 256.0 / PI) as f32
        })
        .collect();
    let tree = Tree::from_grid(Rank::Four, &values).unwrap();
    let smooth = tree.smooth();
    let mut random = Random(16);
    let mut moved = 0.0f64;
    for _ in 0..20_000 {
        let incident = random.direction();
        let total = smooth.hemispherical(incident, false);
        assert!((total - 1.0).abs() < 0.0101, "{total}");
        let exitant = smooth.lobe(incident, false).sample(random.unit(), None).unwrap().0;
        let exitant = Side::Front.direction_from_disk(exitant);
        moved = moved.max((smooth.eval(incident, exitant) / tree.eval(incident, exitant) - 1.0).abs());
    }
    assert!(moved > 0.1, "{moved}");
}

#[test]
fn a_linear_function_is_reproduced_inside() {
    let n = 8usize;
    let f = |x: [f64; 4]| 1.0 + 0.3 * x[0] - 0.2 * x[1] + 0.5 * x[2] + 0.1 * x[3];
    let values: Vec<f32> = (0..n.pow(4))
        .map(|k| {
            let c = [k / 512, k / 64 % 8, k / 8 % 8, k % 8];
            f(c.map(|c| (c as f64 + 0.5) / n as f64)) as f32
        })
        .collect();
    let smooth = Tree::from_grid(Rank::Four, &values).unwrap().smooth();
    let mut random = Random(13);
    for _ in 0..1000 {
        let place = std::array::from_fn(|_| (1.0 + 6.0 * random.unit()) / n as f64);
        let [incident, exitant] = pair(place);
        let value = smooth.eval(incident, exitant);
        // Slopes are kept in units of 2^-15.
        assert!((value - f(place)).abs() < 2e-4, "{value} {}", f(place));
    }
}

#[test]
fn a_peak_of_one_cell_stays_what_it_is() {
    let n = 8usize;
    let mut values = vec![0.1f32; n.pow(4)];
    values[((3 * n + 4) * n + 3) * n + 4] = 1000.0;
    let tree = Tree::from_grid(Rank::Four, &values).unwrap();
    let smooth = tree.smooth();
    let mut random = Random(14);
    for _ in 0..300 {
        let place = [3.0, 4.0, 3.0, 4.0].map(|c| (c + random.unit()) / n as f64);
        let [incident, exitant] = pair(place);
        assert_eq!(smooth.eval(incident, exitant), 1000.0);
        // What is flat on one side of a leaf is flat in it.
        let [incident, exitant] = pair(place.map(|x| x + 1.0 / n as f64));
        assert!((smooth.eval(incident, exitant) - 0.1).abs() < 1e-7);
    }
}

/// Diffuse, and a rough metal by its microfacets (B. Walter et al., "Microfacet models for refraction", EGSR 2007: GGX).
fn smooth_and_glossy(i: Direction, o: Direction) -> f64 {
    let roughness2 = 0.3f64.powi(2);
    let h = [0, 1, 2].map(|k| i[k] + o[k]);
    let length = h.iter().map(|h| h * h).sum::<f64>().sqrt();
    let cos = h[2] / length;
    let d = roughness2 / (PI * (cos * cos * (roughness2 - 1.0) + 1.0).powi(2));
    let lambda = |cos: f64| 0.5 * ((1.0 + roughness2 * (1.0 - cos * cos) / (cos * cos)).sqrt() - 1.0);
    let [ci, co] = [i[2], o[2]].map(|cos| cos.abs().max(1e-4));
    0.1 + 0.5 * d / (4.0 * ci * co * (1.0 + lambda(ci) + lambda(co)))
}

#[test]
fn ramps_are_2_5_times_nearer_to_a_smooth_and_glossy_function_than_steps() {
    let options = TreeOptions { rank: Rank::Four, log2_res: 5, tolerance: 0.14 };
    let f = |i: &[Direction], o: &[Direction], values: &mut [f64]| {
        values.iter_mut().enumerate().for_each(|(k, value)| *value = smooth_and_glossy(i[k], o[k]));
        Ok::<(), ()>(())
    };
    let bsdf = Bsdf::from_function(f, &[Part::ReflectionBack], false, &options).unwrap();
    let Scattering::Tree(steps) = &bsdf.bands[0].component(Part::ReflectionBack).unwrap().luminance else {
        panic!("a tree was asked for");
    };
    assert!((150_000..300_000).contains(&steps.arena().n_leaves()), "{}", steps.arena().n_leaves());
    let ramps = steps.smooth();
    let mut random = Random(15);
    let (mut of_steps, mut of_ramps) = (0.0, 0.0);
    for _ in 0..200_000 {
        let (incident, exitant) = (random.direction(), random.direction());
        let exact = smooth_and_glossy(incident, exitant);
        of_steps += (steps.eval(incident, exitant) - exact).abs();
        of_ramps += (ramps.eval(incident, exitant) - exact).abs();
    }
    assert!(of_steps > 2.5 * of_ramps, "{}", of_steps / of_ramps);
}
