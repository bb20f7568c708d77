//! The linear surface of a cube map: closed over edges and corners, and the same one everywhere.

#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

mod common;

use std::collections::HashMap;

use common::{Random, Relief, map, ray};
use glam::DVec3;
use scene::{DRay, Interval};
use shadowmap::{Bias, DepthMap, MapSurface, MapTraversal, Projection, ProjectionKind};

/// Face, column and row.
type Texel = (usize, u32, u32);

/// The texel that sees `w` from the light.
fn texel_towards(map: &DepthMap, w: DVec3) -> Texel {
    let at = map.locate(map.projection().faces()[0].origin + w).unwrap();
    (at.face, at.u as u32, at.v as u32)
}

/// The triangles of the surface, put together from what the documentation says, by directions alone.
fn surface(map: &DepthMap) -> Vec<[Texel; 3]> {
    let n = map.size().0;
    let step = 1.0 / f64::from(n);
    let along = |i: u32| (2.0 * f64::from(i) + 1.0) * step - 1.0;
    let mut triangles = Vec::new();
    let mut quad = |a, b, c, d| {
        triangles.push([a, b, c]);
        triangles.push([b, c, d]);
    };
    for face in 0..6 {
        for (y, x) in (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| (y, x))) {
            quad((face, x, y), (face, x + 1, y), (face, x, y + 1), (face, x + 1, y + 1));
        }
    }
    // the edge between +X (lower index) and −Z, say: their outermost centres, in the order of +Y
    for first in 0..3 {
        for second in first + 1..3 {
            let edge = 3 - first - second;
            for signs in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let node = |i: u32, near_first: bool| {
                    let (mut w, inner) = (DVec3::ZERO, 1.0 - step);
                    w[first] = signs.0 * if near_first { 1.0 } else { inner };
                    w[second] = signs.1 * if near_first { inner } else { 1.0 };
                    w[edge] = along(i);
                    texel_towards(map, w)
                };
                for i in 0..n - 1 {
                    quad(node(i, true), node(i + 1, true), node(i, false), node(i + 1, false));
                }
            }
        }
    }
    for corner in 0..8 {
        let signs = DVec3::from([0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { 1.0 } else { -1.0 }));
        triangles.push([0, 1, 2].map(|axis| {
            let mut w = signs * (1.0 - step);
            w[axis] = signs[axis];
            texel_towards(map, w)
        }));
    }
    triangles
}

#[test]
fn the_surface_is_closed() {
    for n in [1, 2, 3, 8] {
        let map = map(ProjectionKind::Cube, (n, n), Relief::Noise, &mut Random::new(3));
        let triangles = surface(&map);
        assert_eq!(triangles.len(), (12 * (n - 1) * (n - 1) + 24 * (n - 1) + 8) as usize);
        let mut edges: HashMap<(Texel, Texel), usize> = HashMap::new();
        for t in &triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                *edges.entry((a.min(b), a.max(b))).or_default() += 1;
            }
        }
        assert!(edges.values().all(|&uses| uses == 2));
        // a sphere: vertices − edges + faces = 2
        assert_eq!(6 * i64::from(n * n) - edges.len() as i64 + triangles.len() as i64, 2);
    }
}

/// Whether the way from `light` to `point` crosses a triangle.
fn crosses(light: DVec3, point: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let direction = point - light;
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let det = e1.dot(p);
    let s = light - a;
    let u = s.dot(p) / det;
    let q = s.cross(e1);
    let v = direction.dot(q) / det;
    let t = e2.dot(q) / det;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..1.0).contains(&t)
}

#[test]
fn traversal_and_lookups_see_the_triangles_in_the_world() {
    let mut random = Random::new(4);
    for (n, relief) in [(1, Relief::Noise), (2, Relief::Noise), (5, Relief::Noise), (6, Relief::Blocks)] {
        let map = map(ProjectionKind::Cube, (n, n), relief, &mut random);
        let light = map.projection().faces()[0].origin;
        let triangles: Vec<_> =
            surface(&map).into_iter().map(|t| t.map(|(face, x, y)| map.vertex(face, x, y))).collect();
        let traversal = MapTraversal::new(&map, MapSurface::Linear, Bias::NONE);
        let mut lit = Vec::new();
        let mut outcomes = [0, 0];
        for _ in 0..300 {
            let ray = ray(&mut random);
            traversal.lit(&ray, Interval::new(0.0, 9.0), &mut lit);
            for _ in 0..30 {
                let x = random.between(0.0, 9.0);
                let point = ray.at(x);
                let shadowed = triangles.iter().any(|&t| crosses(light, point, t));
                assert_eq!(traversal.is_lit(point), !shadowed, "{point}");
                assert_eq!(common::contains(&lit, x), !shadowed, "{ray:?} {x}");
                outcomes[usize::from(shadowed)] += 1;
            }
        }
        assert!(outcomes.iter().all(|&count| count > 500), "{outcomes:?}");
    }
}

/// All texels at the same distance: a ball of light, without gaps where faces meet.
#[test]
fn a_ball_has_no_gaps_at_the_seams() {
    let (n, radius) = (16, 3.0);
    let projection = Projection::cube(DVec3::new(0.3, -0.2, 0.1)).unwrap();
    let distances = vec![radius as f32; (6 * n * n) as usize];
    let map = DepthMap::from_host(projection, (n, n), distances, shadowmap::DepthEncoding::Distance).unwrap();
    let light = map.projection().faces()[0].origin;
    let traversal = MapTraversal::new(&map, MapSurface::Linear, Bias::NONE);
    let mut random = Random::new(5);
    let mut lit = Vec::new();
    let mut check = |origin: DVec3, direction: DVec3| {
        let ray = DRay { origin, direction };
        traversal.lit(&ray, Interval::new(0.0, f64::INFINITY), &mut lit);
        let along = (light - origin).dot(direction);
        let aside = (light - origin - along * direction).length();
        let chord = 2.0 * (radius * radius - aside * aside).max(0.0).sqrt();
        if aside < 0.9 * radius {
            assert_eq!(lit.len(), 1, "{ray:?}: {lit:?}");
            // the flat triangles lie within the ball, at most a texel's sagitta deep
            let deficit = chord - lit[0].length();
            assert!(deficit > -1e-6 && deficit < 0.1, "{deficit}");
        }
    };
    for _ in 0..3000 {
        let origin = light + 6.0 * random.direction();
        let target = light + random.vector(1.5);
        check(origin, (target - origin).normalize());
    }
    // through edges and corners of the cube, and in the planes between faces
    for sign in [1.0, -1.0] {
        for diagonal in [DVec3::new(1.0, sign, 0.0), DVec3::new(0.0, 1.0, sign), DVec3::new(1.0, 1.0, sign)] {
            let diagonal = diagonal.normalize();
            check(light - 7.0 * diagonal, diagonal);
            check(light - 7.0 * diagonal + 0.5 * diagonal.any_orthonormal_vector(), diagonal);
            check(light + DVec3::new(1.0, 1.0, -7.0), DVec3::Z);
            check(light + DVec3::new(1.0, sign, -7.0), DVec3::Z);
        }
    }
}

#[test]
fn steps_have_no_gaps_at_the_seams() {
    let projection = Projection::cube(DVec3::ZERO).unwrap();
    let map = DepthMap::uniform(projection, (7, 7), 2.0).unwrap();
    let traversal = MapTraversal::new(&map, MapSurface::Step, Bias::NONE);
    let mut random = Random::new(6);
    let mut lit = Vec::new();
    let cube = scene::Aabb { min: glam::Vec3::splat(-2.0), max: glam::Vec3::splat(2.0) };
    for _ in 0..3000 {
        let ray = ray(&mut random);
        traversal.lit(&ray, Interval::new(0.0, f64::INFINITY), &mut lit);
        let inside = cube.clip(&ray);
        let lengths = (lit.iter().map(Interval::length).sum::<f64>(), inside.length().max(0.0));
        assert!(lit.len() <= 1 && (lengths.0 - lengths.1).abs() < 1e-9, "{lit:?} {inside:?}");
    }
}
