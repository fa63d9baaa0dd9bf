//! Triangles of a polygon in space.
//!
//! In: vertices of one outline, holes cut by seams or listed after it. Out: triangles of the same vertices, none of them turned against
//! the polygon. The outline is projected along the axis that its normal is closest to, which drops a coordinate and
//! rounds nothing; ears are cut by the crate `earcut` (M. Held, "FIST", Algorithmica 30, 2001).

use earcut::Earcut;
use glam::DVec3;

/// Vector of the polygon's area along its normal (Newell's sum), relative to the first vertex.
pub(crate) fn area_vector(vertices: &[DVec3]) -> DVec3 {
    let Some(&origin) = vertices.first() else { return DVec3::ZERO };
    0.5 * vertices.windows(2).map(|w| (w[0] - origin).cross(w[1] - origin)).sum::<DVec3>()
}

/// Whether the area is nothing but rounding.
pub(crate) fn is_degenerate(vertices: &[DVec3]) -> bool {
    // A slat 10 m long and 0.1 µm thick still has an area of 2.5e-9 of its perimeter squared.
    const LEAST_AREA: f64 = 1e-14;
    let perimeter: f64 =
        (0..vertices.len()).map(|k| vertices[k].distance(vertices[(k + 1) % vertices.len()])).sum();
    let enough = area_vector(vertices).length() > LEAST_AREA * perimeter * perimeter;
    // NaN is not enough.
    !enough
}

/// See the module's head.
pub(crate) fn triangles(vertices: &[DVec3]) -> Vec<[DVec3; 3]> {
    triangles_around_holes(vertices, &[])
}

/// As [`triangles`]; from each of these vertices on, the next hole is listed, whichever way it turns.
pub(crate) fn triangles_around_holes(vertices: &[DVec3], holes: &[u32]) -> Vec<[DVec3; 3]> {
    let corners = corners_around_holes(vertices, holes);
    corners.into_iter().map(|t| t.map(|k| vertices[k as usize])).collect()
}

/// As [`triangles`], their vertices by index.
pub(crate) fn corners_of_triangles(vertices: &[DVec3]) -> Vec<[u32; 3]> {
    match vertices.len() {
        3 if !is_degenerate(vertices) => vec![[0, 1, 2]],
        _ => corners_around_holes(vertices, &[]),
    }
}

fn corners_around_holes(vertices: &[DVec3], holes: &[u32]) -> Vec<[u32; 3]> {
    let outline = &vertices[..holes.first().map_or(vertices.len(), |&k| k as usize)];
    if is_degenerate(outline) {
        return Vec::new();
    }
    let area = area_vector(outline);
    let axis = area.abs().max_position();
    // A cyclic choice keeps the turning sense where the normal's component is positive.
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut corners: Vec<u32> = Vec::new();
    Earcut::new().earcut(vertices.iter().map(|p| [p[u], p[v]]), holes, &mut corners);
    let turning = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|k| vertices[k as usize]);
        (b - a).cross(c - a)
    };
    let triangles = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
    let turned = triangles.map(|t| if turning(&t).dot(area) < 0.0 { [t[0], t[2], t[1]] } else { t });
    turned.filter(|t| turning(t) != DVec3::ZERO).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;

    fn total(triangles: &[[DVec3; 3]]) -> f64 {
        triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum()
    }

    /// Lifts plane points into a tilted plane.
    fn lifted(points: &[(f64, f64)]) -> Vec<DVec3> {
        points.iter().map(|&(x, y)| DVec3::new(x, y, 0.3 * x - 1.7 * y + 5.0)).collect()
    }

    fn assert_covers(vertices: &[DVec3]) {
        let area = area_vector(vertices);
        let triangles = triangles(vertices);
        assert!(
            (total(&triangles) / area.length() - 1.0).abs() < 1e-9,
            "{} of {}",
            total(&triangles),
            area.length()
        );
        for [a, b, c] in triangles {
            assert!((b - a).cross(c - a).dot(area) > 0.0);
        }
    }

    #[test]
    fn concave_outlines_are_covered_once() {
        assert_covers(&lifted(&[(0., 0.), (4., 0.), (4., 4.), (2., 1.), (0., 4.)]));
        let comb: Vec<_> = (0..40).map(|k| (k as f64, if k % 2 == 0 { 0.0 } else { 9.0 })).collect();
        let mut outline = comb.clone();
        outline.extend(comb.iter().rev().map(|&(x, y)| (x, y + 2.0)));
        assert_covers(&lifted(&outline));
    }

    #[test]
    fn listed_holes_stay_open_whichever_way_they_turn() {
        let outer = lifted(&[(0., 0.), (9., 0.), (9., 4.), (0., 4.)]);
        let mut first = lifted(&[(1., 1.), (3., 1.), (3., 3.), (1., 3.)]);
        let second = lifted(&[(5., 1.), (5., 3.), (7., 2.)]);
        for _ in 0..2 {
            let vertices = [&outer[..], &first, &second].concat();
            let open = area_vector(&first).length() + area_vector(&second).length();
            let triangles = triangles_around_holes(&vertices, &[4, 8]);
            assert!((total(&triangles) / (area_vector(&outer).length() - open) - 1.0).abs() < 1e-12);
            first.reverse();
        }
    }

    #[test]
    fn either_turning_sense_is_kept() {
        let mut vertices = lifted(&[(0., 0.), (4., 0.), (4., 4.), (2., 1.), (0., 4.)]);
        vertices.reverse();
        assert_covers(&vertices);
    }

    #[test]
    fn holes_cut_by_seams_stay_open() {
        let outer = [(0., 0.), (4., 0.), (4., 4.), (0., 4.), (0., 0.)];
        let hole = [(1., 1.), (1., 2.), (2., 2.), (2., 1.), (1., 1.)];
        let vertices = lifted(&[&outer[..], &hole].concat());
        assert_covers(&vertices);
        let inside = |p: DVec3, [a, b, c]: [DVec3; 3]| {
            [(a, b), (b, c), (c, a)]
                .iter()
                .all(|&(s, e)| (e - s).truncate().perp_dot((p - s).truncate()) > 0.0)
        };
        let center = lifted(&[(1.5, 1.5)])[0];
        assert!(!triangles(&vertices).into_iter().any(|t| inside(center, t)));
    }

    #[test]
    fn two_holes_cut_by_seams_stay_open() {
        let mut points = vec![(0., 0.), (9., 0.), (9., 4.), (0., 4.), (0., 0.)];
        for x in [1.0, 5.0] {
            let hole = (0..=12).map(|k| {
                let a = -TAU * k as f64 / 12.0;
                (x + 1.5 - a.cos(), 2.0 + a.sin())
            });
            points.extend(hole);
            points.push((0., 0.));
        }
        points.pop();
        assert_covers(&lifted(&points));
    }

    #[test]
    fn repeated_and_collinear_vertices_change_nothing() {
        assert_covers(&lifted(&[
            (0., 0.),
            (1., 0.),
            (1., 0.),
            (2., 0.),
            (4., 0.),
            (4., 4.),
            (0., 4.),
            (0., 2.),
        ]));
    }

    #[test]
    fn slightly_bent_polygons_are_covered() {
        let mut vertices = lifted(&[(0., 0.), (4., 0.), (4., 4.), (0., 4.)]);
        vertices[2].z += 1e-7;
        assert_covers(&vertices);
    }

    #[test]
    fn nothing_comes_of_no_area() {
        assert!(triangles(&lifted(&[(0., 0.), (1., 0.), (2., 0.), (3., 0.)])).is_empty());
        assert!(triangles(&[]).is_empty());
    }

    proptest! {
        #[test]
        fn star_shaped_polygons_are_covered_once(radii in prop::collection::vec(0.1..10.0f64, 5..60), turn in 0.0..TAU) {
            let n = radii.len() as f64;
            let points: Vec<_> = radii.iter().enumerate().map(|(k, r)| {
                let a = turn + TAU * k as f64 / n;
                (r * a.cos(), r * a.sin())
            }).collect();
            assert_covers(&lifted(&points));
        }

        #[test]
        fn tangled_outlines_give_triangles_of_their_own_sense(
            points in prop::collection::vec(prop::array::uniform3(-3..3i32), 0..40), scale in prop::sample::select(vec![1e-200, 1.0, 1e200])
        ) {
            let vertices: Vec<DVec3> = points.iter().map(|p| DVec3::from(p.map(f64::from)) * scale).collect();
            let area = area_vector(&vertices);
            for [a, b, c] in triangles(&vertices) {
                prop_assert!((b - a).cross(c - a).dot(area) >= 0.0);
            }
        }
    }
}
