//! What the tessellations promise: the distance criterion bounds the whole surface, Delaunay every node.

#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

mod common;

use common::{KINDS, Random, Relief, adaptive, map};
use lightvolume::{Criterion, LightVolume, Options, Tessellation, Vertex};
use shadowmap::{DepthMap, ProjectionKind};

/// Heights of the map's own surface and of a volume's, in `f64`.
struct Heights<'a> {
    map: &'a DepthMap,
    perspective: bool,
    far: f64,
}

impl Heights<'_> {
    fn of(&self, depth: f32) -> f64 {
        if self.perspective { 1.0 / f64::from(depth) } else { -f64::from(depth).min(self.far) }
    }

    fn node(&self, face: usize, x: u32, y: u32) -> f64 {
        self.of(self.map.depth(face, x, y))
    }

    /// Height of the two triangles of a cell at a place between the nodes.
    fn fine(&self, face: usize, u: f64, v: f64) -> f64 {
        let cell = |at: f64, nodes: u32| (at.max(0.0) as u32).min(nodes - 2);
        let (x, y) = (cell(u, self.map.size().0), cell(v, self.map.size().1));
        let (a, b) = (u - f64::from(x), v - f64::from(y));
        let [right, below] = [self.node(face, x + 1, y), self.node(face, x, y + 1)];
        if a + b <= 1.0 {
            let corner = self.node(face, x, y);
            corner + a * (right - corner) + b * (below - corner)
        } else {
            let corner = self.node(face, x + 1, y + 1);
            corner + (1.0 - a) * (below - corner) + (1.0 - b) * (right - corner)
        }
    }

    /// Planar depth, no farther than `far`; units: m.
    fn depth(&self, height: f64) -> f64 {
        if self.perspective { 1.0 / height.max(1.0 / self.far) } else { -height }
    }
}

/// Farthest that a volume's surface is from the map's, at `samples` places of every triangle and at its corners.
fn farthest(map: &DepthMap, volume: &LightVolume, samples: usize, random: &mut Random) -> f64 {
    let heights = Heights { map, perspective: !volume.is_shadow(), far: f64::from(volume.far()) };
    let mut most: f64 = 0.0;
    for triangle in &volume.triangles()[..volume.surface_count()] {
        let corners = triangle.map(|index| volume.vertices()[index as usize]);
        for _ in 0..samples {
            let (mut s, mut t) = (random.unit(), random.unit());
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            let mix = |of: &dyn Fn(&Vertex) -> f64| {
                (1.0 - s - t) * of(&corners[0]) + s * of(&corners[1]) + t * of(&corners[2])
            };
            let (u, v) = (mix(&|c| f64::from(c.x)), mix(&|c| f64::from(c.y)));
            let coarse = mix(&|c| heights.of(c.depth));
            let fine = heights.fine(usize::from(corners[0].face), u, v);
            most = most.max((heights.depth(coarse) - heights.depth(fine)).abs());
        }
    }
    most
}

#[test]
fn the_distance_criterion_bounds_the_distance() {
    let random = &mut Random::new(21);
    let (mut fewer, mut close) = (0, 0.0_f64);
    for kind in KINDS {
        for size in [(5, 5), (33, 17), (64, 64), (100, 77), (129, 129)] {
            for relief in [Relief::Spots, Relief::Ramp, Relief::Noise] {
                for threshold in [0.003, 0.03, 0.3] {
                    let map = map(kind, size, relief, random);
                    let volume = LightVolume::build(&map, &adaptive(Criterion::Distance, threshold)).unwrap();
                    let found = farthest(&map, &volume, 40, random);
                    // heights are f32
                    let bound = f64::from(threshold) + 1e-5;
                    assert!(found <= bound, "{kind:?} {size:?} {relief:?}: {found} > {threshold}");
                    let cells = 2 * (map.size().0 - 1) as usize * (map.size().1 - 1) as usize;
                    fewer += usize::from(volume.surface_count() < cells * map.projection().faces().len());
                    close = close.max(found / f64::from(threshold));
                }
            }
        }
    }
    // the bound is used: volumes are coarser than the map, and come near it
    assert!(fewer > 50 && close > 0.3, "{fewer} {close}");
}

#[test]
fn delaunay_keeps_every_node_within_its_bound() {
    let random = &mut Random::new(22);
    let mut fewer = 0;
    for kind in [ProjectionKind::Perspective, ProjectionKind::Orthographic] {
        for size in [(2, 2), (5, 3), (33, 17), (64, 64), (90, 77)] {
            for relief in [Relief::Spots, Relief::Ramp, Relief::Noise, Relief::Checkerboard] {
                for bound in [0.0, 0.01, 0.1] {
                    let map = map(kind, size, relief, random);
                    let options = Options::new(Tessellation::Delaunay { bound });
                    let volume = LightVolume::build(&map, &options).unwrap();
                    let found = farthest_node(&map, &volume);
                    assert!(found <= f64::from(bound) + 1e-12, "{kind:?} {size:?} {relief:?}: {found}");
                    fewer += usize::from(
                        volume.surface_count() < 2 * (size.0 as usize - 1) * (size.1 as usize - 1),
                    );
                }
            }
        }
    }
    assert!(fewer > 40, "{fewer}");
}

/// Farthest that a node is from the triangles over it.
fn farthest_node(map: &DepthMap, volume: &LightVolume) -> f64 {
    let far = f64::from(volume.far());
    let heights = Heights { map, perspective: !volume.is_shadow(), far };
    let mut most: f64 = 0.0;
    for triangle in &volume.triangles()[..volume.surface_count()] {
        let [a, b, c] = triangle.map(|index| volume.vertices()[index as usize]);
        let span = |of: &dyn Fn(&Vertex) -> f32| {
            let values = [of(&a), of(&b), of(&c)];
            let low = values.into_iter().fold(f32::INFINITY, f32::min) as u32;
            low..=values.into_iter().fold(0.0, f32::max) as u32
        };
        let cross = |p: (f64, f64), q: (f64, f64)| p.0 * q.1 - p.1 * q.0;
        let from = |to: &Vertex, x: f64, y: f64| (f64::from(to.x) - x, f64::from(to.y) - y);
        for y in span(&|v| v.y) {
            for x in span(&|v| v.x) {
                let (u, v) = (f64::from(x), f64::from(y));
                let [p, q, r] = [&a, &b, &c].map(|corner| from(corner, u, v));
                let [wa, wb, wc] = [cross(q, r), cross(r, p), cross(p, q)];
                if wa.min(wb).min(wc) < 0.0 {
                    continue;
                }
                let mix = wa * heights.of(a.depth) + wb * heights.of(b.depth) + wc * heights.of(c.depth);
                let coarse = mix / (wa + wb + wc);
                let (own, exact) = (heights.depth(coarse), heights.depth(heights.node(0, x, y)));
                most = most.max((own - exact).abs());
            }
        }
    }
    most
}
