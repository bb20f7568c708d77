//! The crossings of a light volume are the lit pieces of the map's linear surface.

#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

mod common;

use common::{CRITERIA, KINDS, RELIEFS, Random, Relief, adaptive, map};
use glam::DVec3;
use lightvolume::{LightVolume, Options, RayIndex, Tessellation};
use media_math::Boundary;
use scene::{DRay, Interval};
use shadowmap::{Bias, DepthMap, MapSurface, MapTraversal, ProjectionKind};

/// Lit pieces between sorted boundaries, without those shorter than rounding.
fn pieces(index: &RayIndex<'_>, ray: &DRay, span: Interval) -> Vec<Interval> {
    let mut boundaries = Vec::new();
    index.crossings(ray, span, &mut boundaries);
    assert!(boundaries.iter().all(|b| b.distance >= span.start && b.distance <= span.end));
    boundaries.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let mut lit: f64 = boundaries.iter().map(Boundary::sign).sum();
    assert!(lit == 0.0 || lit == 1.0, "signs sum to {lit}");
    let mut out: Vec<Interval> = Vec::new();
    let mut from = span.start;
    for boundary in boundaries {
        if lit > 0.0 {
            out.push(Interval::new(from, boundary.distance));
        }
        from = boundary.distance;
        lit -= boundary.sign();
    }
    assert_eq!(lit, 0.0);
    out
}

/// Without gaps and pieces that two ways of computing them may disagree about.
fn tidy(pieces: &[Interval]) -> Vec<Interval> {
    let slack = |at: f64| 2e-9 * (1.0 + at.abs());
    let mut out: Vec<Interval> = Vec::new();
    for &piece in pieces {
        match out.last_mut() {
            Some(last) if piece.start <= last.end + slack(piece.start) => last.end = last.end.max(piece.end),
            _ => out.push(piece),
        }
    }
    out.retain(|piece| piece.length() > slack(piece.start));
    out
}

/// Length of what is lit for one and not for the other, within 10⁶ m.
fn difference(a: &[Interval], b: &[Interval]) -> f64 {
    let total = |pieces: &[Interval]| {
        pieces.iter().map(|piece| (piece.end.min(1e6) - piece.start.min(1e6)).max(0.0)).sum::<f64>()
    };
    let common: Vec<_> =
        a.iter().flat_map(|p| b.iter().map(|q| p.intersect(*q))).filter(|piece| !piece.is_empty()).collect();
    total(a) + total(b) - 2.0 * total(&common)
}

/// The reference for a volume: the linear surface, for orthographic maps closed at the far plane.
struct Reference {
    map: DepthMap,
    far: f64,
}

impl Reference {
    fn new(map: &DepthMap, volume: &LightVolume) -> Self {
        let shadow = volume.is_shadow();
        let map = if shadow { map.clone().clamped(volume.far()).unwrap() } else { map.clone() };
        Self { map, far: if shadow { f64::from(volume.far()) } else { f64::INFINITY } }
    }

    fn pieces(&self, ray: &DRay, span: Interval) -> Vec<Interval> {
        let mut out = Vec::new();
        let traversal = MapTraversal::new(&self.map, MapSurface::Linear, Bias::NONE);
        if self.far.is_infinite() {
            traversal.lit(ray, span, &mut out);
            return out;
        }
        // up to the far plane; all is lit beyond
        let face = &self.map.projection().faces()[0];
        let depth = |x: f64| (ray.at(x) - face.origin).dot(face.forward);
        let slope = ray.direction.dot(face.forward);
        let root = (self.far - depth(0.0)) / slope;
        let (near, beyond) = if slope > 0.0 {
            (Interval::new(span.start, span.end.min(root)), Interval::new(span.start.max(root), span.end))
        } else if slope < 0.0 {
            (Interval::new(span.start.max(root), span.end), Interval::new(span.start, span.end.min(root)))
        } else {
            (span, Interval::new(span.end, span.end))
        };
        traversal.lit(ray, near, &mut out);
        out.extend(Some(beyond).filter(|piece| !piece.is_empty()));
        out.sort_by(|a, b| a.start.total_cmp(&b.start));
        out
    }
}

/// A ray that asks for something hard every now and then.
fn ray(map: &DepthMap, random: &mut Random) -> (DRay, Interval) {
    let face = map.projection().faces()[0];
    let origin = match random.between(0.0, 8.0) as u32 {
        // at the light, or on the plane of depth 0
        0 => face.origin,
        // far outside
        1 => random.vector(100.0),
        _ => random.vector(5.0),
    };
    let direction = match random.between(0.0, 8.0) as u32 {
        // parallel to the light's axis, or against it
        0 => face.forward,
        1 => -face.forward,
        // through the light
        2 => (face.origin - origin).try_normalize().unwrap_or(face.right),
        3 => face.right,
        _ => random.direction(),
    };
    let start = if random.unit() < 0.3 { random.between(0.0, 5.0) } else { 0.0 };
    let end = if random.unit() < 0.5 { f64::INFINITY } else { start + random.between(0.1, 20.0) };
    (DRay { origin, direction }, Interval::new(start, end))
}

fn compare(map: &DepthMap, options: &Options, rays: usize, tolerance: f64, random: &mut Random) -> usize {
    let volume = LightVolume::build(map, options).unwrap();
    let index = RayIndex::new(&volume);
    let reference = Reference::new(map, &volume);
    let mut boundaries = 0;
    for _ in 0..rays {
        let (ray, span) = ray(map, random);
        let (found, exact) = (tidy(&pieces(&index, &ray, span)), tidy(&reference.pieces(&ray, span)));
        boundaries += found.len();
        let scale = 1.0 + ray.origin.length();
        let close = |a: f64, b: f64| a == b || (a - b).abs() <= tolerance * (scale + a.abs());
        let same = found.len() == exact.len()
            && found.iter().zip(&exact).all(|(a, b)| close(a.start, b.start) && close(a.end, b.end));
        // a piece that one has and the other has not is as short as rounding
        let apart = if same { 0.0 } else { difference(&found, &exact) };
        assert!(
            apart <= tolerance * scale,
            "{:?} {:?} {options:?}: {ray:?} {span:?}\n{found:?}\n{exact:?}\n{apart:e}",
            map.projection().kind(),
            map.size(),
        );
    }
    boundaries
}

#[test]
fn static_volumes_are_the_linear_surface() {
    let random = &mut Random::new(11);
    let mut boundaries = 0;
    for kind in KINDS {
        for size in [(1, 1), (1, 4), (2, 2), (3, 5), (16, 16), (33, 17), (64, 64)] {
            for relief in RELIEFS {
                let map = map(kind, size, relief, random);
                boundaries += compare(&map, &Options::default(), 150, 1e-9, random);
            }
        }
    }
    assert!(boundaries > 10_000, "{boundaries}");
    for kind in KINDS {
        for relief in [Relief::Noise, Relief::Spots] {
            compare(&map(kind, (200, 150), relief, random), &Options::default(), 400, 1e-9, random);
        }
    }
}

#[test]
fn rays_that_all_but_meet_the_light_do_not_leak() {
    let random = &mut Random::new(13);
    for kind in KINDS {
        let map = map(kind, (40, 40), Relief::Noise, random);
        let volume = LightVolume::build(&map, &Options::default()).unwrap();
        let index = RayIndex::new(&volume);
        let light = map.projection().faces()[0].origin;
        for i in 0..4000 {
            let direction = random.direction();
            let aside = direction.cross(random.direction()) * 10_f64.powi(-(i % 20));
            let origin = light + aside - random.between(-3.0, 3.0) * direction;
            pieces(&index, &DRay { origin, direction }, Interval::new(0.0, f64::INFINITY));
        }
        // parallel to the light's axis, all but for a rounding
        for i in 0..4000 {
            let forward = map.projection().faces()[0].forward;
            let direction = (forward + random.direction() * 10_f64.powi(-(i % 20))).normalize();
            let origin = light + random.vector(2.0);
            pieces(&index, &DRay { origin, direction }, Interval::new(0.0, f64::INFINITY));
        }
    }
}

#[test]
fn threshold_0_is_the_same_surface() {
    let random = &mut Random::new(12);
    for kind in KINDS {
        for size in [(2, 2), (3, 5), (33, 17), (40, 40)] {
            for relief in RELIEFS {
                let map = map(kind, size, relief, random);
                for criterion in CRITERIA {
                    // f32 heights decide what is flat: the surface may move by their rounding. None of these maps has a
                    // saddle, which the Laplacian would miss
                    compare(&map, &adaptive(criterion, 0.0), 100, 2e-6, random);
                }
                if kind != ProjectionKind::Cube && size.0 < 33 {
                    compare(
                        &map,
                        &Options::new(Tessellation::Delaunay { bound: 0.0 }),
                        1,
                        f64::INFINITY,
                        random,
                    );
                }
            }
        }
    }
}

#[test]
fn by_hand() {
    // a spot 4 m above the ground, texel centres at ±½ of a right angle
    use glam::DVec2;
    use shadowmap::Projection;
    let light = DVec3::new(0.0, 4.0, 0.0);
    let projection = Projection::perspective(light, DVec3::NEG_Y, DVec3::X, DVec2::ONE).unwrap();
    let map = DepthMap::uniform(projection, (2, 2), 4.0).unwrap();
    let volume = LightVolume::build(&map, &Options::default()).unwrap();
    let index = RayIndex::new(&volume);
    let along = |y: f64| DRay { origin: DVec3::new(-9.0, y, 0.1), direction: DVec3::X };
    let all = Interval::new(0.0, f64::INFINITY);
    let found = pieces(&index, &along(1.0), all);
    assert!((found[0].start - 7.5).abs() < 1e-12 && (found[0].end - 10.5).abs() < 1e-12, "{found:?}");
    assert!(pieces(&index, &along(5.0), all).is_empty() && pieces(&index, &along(-0.1), all).is_empty());
    // a span that ends in light, and one that lies in it
    let found = pieces(&index, &along(1.0), Interval::new(0.0, 9.0));
    assert_eq!((found.len(), found[0].end), (1, 9.0));
    assert_eq!(pieces(&index, &along(1.0), Interval::new(8.0, 9.0)), [Interval::new(8.0, 9.0)]);
    assert!(pieces(&index, &along(1.0), Interval::new(9.0, 9.0)).is_empty());
}

#[test]
fn rays_through_nodes_and_along_edges_do_not_leak() {
    let random = &mut Random::new(5);
    for kind in KINDS {
        for relief in RELIEFS {
            let map = map(kind, (9, 9), relief, random);
            let volume = LightVolume::build(&map, &Options::default()).unwrap();
            let index = RayIndex::new(&volume);
            let face = &map.projection().faces()[0];
            let nodes: Vec<DVec3> = (0..81)
                .map(|i| face.unproject(f64::from(i % 9) + 0.5, f64::from(i / 9) + 0.5, 2.0, (9, 9)))
                .collect();
            for _ in 0..2000 {
                let pick = |random: &mut Random| nodes[random.between(0.0, 81.0) as usize];
                let (from, to) = (pick(random), pick(random));
                let direction = (to - from).try_normalize().unwrap_or(face.forward);
                let origin = from - direction * f64::from(random.between(0.0, 3.0) as u32);
                // `pieces` asserts that the signs sum to 0 or 1
                for span in [Interval::new(0.0, f64::INFINITY), Interval::new(0.0, 2.0)] {
                    pieces(&index, &DRay { origin, direction }, span);
                }
            }
        }
    }
}

#[test]
fn a_ray_in_the_plane_of_the_surface_changes_nowhere_else() {
    let random = &mut Random::new(14);
    let mut changes = 0;
    for kind in [ProjectionKind::Perspective, ProjectionKind::Orthographic] {
        for _ in 0..400 {
            let n = 2 + random.between(0.0, 20.0) as u32;
            let map = map(kind, (n, n), Relief::Constant, random);
            let volume = LightVolume::build(&map, &Options::default()).unwrap();
            let index = RayIndex::new(&volume);
            let face = &map.projection().faces()[0];
            // in the plane of depth 2.5, from 10 m before the map's middle
            let turn = random.between(0.0, 6.0);
            let direction = turn.cos() * face.right + turn.sin() * face.down;
            let middle = face.unproject(0.5 * f64::from(n), 0.5 * f64::from(n), 2.5, (n, n));
            let reach = (face.half * if face.perspective { 2.5 } else { 1.0 }).length();
            let ray = DRay { origin: middle - 10.0 * direction, direction };
            let mut boundaries = Vec::new();
            index.crossings(&ray, Interval::new(0.0, 1e3), &mut boundaries);
            for boundary in boundaries.iter().filter(|boundary| boundary.distance < 1e3) {
                assert!((boundary.distance - 10.0).abs() < reach + 1e-6, "{kind:?} {n}: {boundary:?}");
                changes += 1;
            }
        }
    }
    assert!(changes > 1000, "{changes}");
}

#[test]
fn rays_through_the_light_are_those_beside_it() {
    let random = &mut Random::new(15);
    for kind in [ProjectionKind::Perspective, ProjectionKind::Cube] {
        for relief in [Relief::Noise, Relief::Spots] {
            let map = map(kind, (24, 24), relief, random);
            let volume = LightVolume::build(&map, &Options::default()).unwrap();
            let (index, reference) = (RayIndex::new(&volume), Reference::new(&map, &volume));
            let light = map.projection().faces()[0].origin;
            for _ in 0..3000 {
                let origin = random.vector(8.0);
                let ray = DRay { origin, direction: (light - origin).normalize() };
                let span = Interval::new(0.0, 1e3);
                let (found, exact) = (pieces(&index, &ray, span), reference.pieces(&ray, span));
                let apart = difference(&found, &exact);
                assert!(apart < 1e-8, "{kind:?} {relief:?} {ray:?}\n{found:?}\n{exact:?}");
            }
        }
    }
}
