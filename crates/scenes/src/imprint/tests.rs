//! Rays, surfaces and bodies inside the scene.

use crate::shapes::mesh::{Mesh, RayGrid, ViewPlane};
use crate::shapes::objects;
use crate::shapes::solid::Solid;
use crate::shapes::touch::tangent;
use crate::shapes::vector::{Vector, add, cross, dot, length, scale, sub};
use rand::RngExt;
use std::collections::BTreeMap;

/// Returns the height at which a ray meets a triangle (Möller and Trumbore), one triangle at a time.
fn cast(mesh: &Mesh, from: Vector, along: Vector) -> Option<f64> {
    let meets = mesh.triangles.iter().filter_map(|t| {
        let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
        let (ab, ac) = (sub(b, a), sub(c, a));
        let p = cross(along, ac);
        let det = dot(ab, p);
        let start = sub(from, a);
        let u = dot(start, p) / det;
        let q = cross(start, ab);
        let v = dot(along, q) / det;
        (det.abs() > 1e-14 && u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9).then(|| dot(ac, q) / det)
    });
    meets.max_by(f64::total_cmp)
}

fn dog() -> Mesh {
    let (vertices, triangles) = objects::CLASSES[5].1[0]().surface();
    Mesh::new("dog", vertices, triangles, 200.0).unwrap()
}

#[test]
fn heights_are_those_of_ray_casting() {
    let mesh = dog();
    let mut rng = taxel_base::seed::rng(3, "test");
    let mut met = 0;
    for _ in 0..12 {
        let (point, normal) = mesh.point(rng.random());
        let frame = tangent(point, normal, rng.random_range(0.0..6.0));
        let grid = RayGrid { side: 5, pitch: rng.random_range(1.0..12.0) };
        let heights = mesh.heights(&frame, grid, f64::NEG_INFINITY);
        for (ray, height) in heights.into_iter().enumerate() {
            let (row, column) = ((ray / 5) as f64, (ray % 5) as f64);
            let right = scale(frame.right, (column - 2.0) * grid.pitch);
            let from = add(point, add(right, scale(frame.up, (2.0 - row) * grid.pitch)));
            let want = cast(&mesh, from, frame.normal);
            match (height, want) {
                (Some((height, _)), Some(want)) => assert!((height - want).abs() < 1e-6, "{height} {want}"),
                (height, want) => assert_eq!(height.is_none(), want.is_none(), "ray {ray}"),
            }
            met += usize::from(want.is_some());
        }
    }
    assert!(met > 100, "{met} rays met the mesh");
}

#[test]
fn a_floor_leaves_out_only_what_lies_below() {
    let mesh = dog();
    let mut rng = taxel_base::seed::rng(4, "test");
    let (point, normal) = mesh.point(rng.random());
    let frame = tangent(point, normal, 1.0);
    let grid = RayGrid { side: 40, pitch: 3.0 };
    let all = mesh.heights(&frame, grid, f64::NEG_INFINITY);
    let most = mesh.heights(&frame, grid, -6.0);
    assert!(all.iter().flatten().any(|(height, _)| *height < -12.0));
    for (all, most) in all.iter().zip(&most) {
        let above = |seen: &Option<(f64, u32)>| seen.filter(|(height, _)| *height >= -6.0);
        assert_eq!(above(all), above(most));
    }
}

#[test]
fn tangent_planes_are_square_to_the_normal() {
    let tops = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.6, 0.0, 0.8], [1e-8, 0.0, 1.0]];
    for normal in tops {
        for spin in [0.0, 1.0, 4.0] {
            let ViewPlane { right, up, normal, .. } = tangent([1.0, 2.0, 3.0], normal, spin);
            for (a, b) in [(right, up), (right, normal), (up, normal)] {
                assert!(dot(a, b).abs() < 1e-7, "{right:?} {up:?} {normal:?}");
            }
            assert!((length(right) - 1.0).abs() < 1e-7 && (length(up) - 1.0).abs() < 1e-7);
            assert!(dot(cross(right, up), normal) > 0.99, "not mirrored");
        }
    }
    assert!(tangent([0.0; 3], [1.0, 0.0, 0.0], 0.0).up[2] > 0.99, "without spin, up is up");
}

#[test]
fn points_are_uniform_over_the_surface() {
    // Two unit-wide strips, one three times as long: three quarters of the area.
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let far = corners.map(|[x, y, z]| [x, 3.0 * y, z + 1.0]);
    let vertices = [corners, far].concat();
    let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let diagonal = 11f64.sqrt();
    let mesh = Mesh::new("strips", vertices, triangles, diagonal).unwrap();
    let mut rng = taxel_base::seed::rng(5, "test");
    let points: Vec<(Vector, Vector)> = (0..8000).map(|_| mesh.point(rng.random())).collect();
    let share = |of: &dyn Fn(Vector) -> bool| points.iter().filter(|(p, _)| of(*p)).count() as f64 / 8000.0;
    assert!((share(&|p| p[2] > 0.0) - 0.75).abs() < 0.02);
    assert!((share(&|p| p[0] > 0.25) - 0.25).abs() < 0.02);
    assert!((share(&|p| p[1] > 0.75) - 0.1875).abs() < 0.02);
    assert!(points.iter().all(|(p, n)| n[2].abs() == 1.0 && (p[2].abs() - 0.5).abs() < 1e-9));
}

/// Checks whether every directed edge has its opposite as often: no hole, and all triangles wind alike.
fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let mut balance: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *balance.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
        }
    }
    balance.values().all(|&sum| sum == 0)
}

fn volume(vertices: &[Vector], triangles: &[[u32; 3]]) -> f64 {
    let six = triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| vertices[v as usize]);
        dot(a, cross(b, c))
    });
    six.sum::<f64>() / 6.0
}

#[test]
fn a_ball_and_a_box_have_their_volume_and_point_outward() {
    let (vertices, triangles) = Solid::new(0.1).ball([0.3, -0.2, 0.1], 1.0).surface();
    assert!(is_closed(&triangles));
    let ball = volume(&vertices, &triangles);
    assert!((ball / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.005, "{ball}");
    let away = vertices.iter().map(|&v| (length(sub(v, [0.3, -0.2, 0.1])) - 1.0).abs());
    assert!(away.fold(0.0, f64::max) < 0.002, "vertices lie on the ball");

    let (vertices, triangles) = Solid::new(0.1).tilted([0.0; 3], [1.0, 0.5, 0.25], 0.02, 30.0).surface();
    let volume = volume(&vertices, &triangles);
    assert!(is_closed(&triangles) && (volume - 1.0).abs() < 0.01, "{volume}");
    let front = vertices.iter().max_by(|a, b| a[0].total_cmp(&b[0])).unwrap();
    assert!(front[2] > 0.2, "the front is raised: {front:?}");
}

#[test]
fn what_is_hollowed_out_is_gone() {
    let whole = Solid::new(0.01).ball([0.0; 3], 1.0);
    let (vertices, triangles) = whole.clone().hollow([0.0, 0.0, 1.0], 0.5).surface();
    assert!(is_closed(&triangles));
    let top = vertices.iter().filter(|v| v[0].hypot(v[1]) < 0.05).map(|v| v[2]).fold(-2.0, f64::max);
    assert!((top - 0.5).abs() < 0.01, "{top}");
}

#[test]
fn all_thirty_objects_are_closed_bodies_of_their_own() {
    let mut seen = Vec::new();
    for (class, variants) in objects::CLASSES {
        for variant in variants {
            let (vertices, triangles) = variant().surface();
            assert!(is_closed(&triangles), "{class}");
            let volume = volume(&vertices, &triangles);
            assert!(volume > 0.0, "{class}: inside out");
            let size = (vertices.len(), triangles.len());
            assert!((2_000..150_000).contains(&size.1), "{class}: {size:?}");
            assert!(!seen.contains(&size), "{class}: two objects are the same");
            seen.push(size);
        }
    }
    assert_eq!(seen.len(), 30);
}

#[test]
fn a_ray_through_an_edge_or_a_corner_meets_the_surface() {
    // A sheet of 6 × 6 squares, each of two triangles; rays go through all corners and diagonals.
    let at = |i: u32| i * 7;
    let vertices = (0..49).map(|i| [f64::from(i % 7), f64::from(i / 7), 0.0]).collect();
    let squares = (0..6).flat_map(|r| (0..6).map(move |c| at(r) + c));
    let triangles = squares.flat_map(|a| [[a, a + 1, a + 8], [a, a + 8, a + 7]]).collect();
    let mesh = Mesh::new("sheet", vertices, triangles, 72f64.sqrt()).unwrap();
    let frame = tangent([0.0; 3], [0.0, 0.0, 1.0], 0.0);
    for side in [13, 25, 31] {
        let heights = mesh.heights(&frame, RayGrid { side, pitch: 6.0 / (side - 1) as f64 }, -1.0);
        assert!(heights.iter().all(Option::is_some), "{side}: {heights:?}");
    }
}
