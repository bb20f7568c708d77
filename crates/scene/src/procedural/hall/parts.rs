//! What the hall is built of: spans, columns, balusters, windows.

use super::super::builder::MeshBuilder;
use glam::{Vec2, Vec3};

/// A closed body between a lower and an upper line of as many points (left to right), `depth` thick around z = 0.
fn span(lower: &[Vec2], upper: &[Vec2], depth: f32) -> MeshBuilder {
    let z = 0.5 * depth;
    let rings: Vec<Vec<Vec3>> = lower
        .iter()
        .zip(upper)
        .map(|(l, u)| vec![u.extend(z), l.extend(z), l.extend(-z), u.extend(-z)])
        .collect();
    let mut b = MeshBuilder::default();
    b.loft(&rings);
    b
}

/// A point of a half circle from left to right; `t` from 0 to 1.
fn arc(radius: f32, spring: f32, t: f32) -> Vec2 {
    let (sin, cos) = (std::f32::consts::PI * (1.0 - t)).sin_cos();
    Vec2::new(radius * cos, spring + radius * sin)
}

/// The wall above an arcade's columns: `width` wide, from `spring` to `top`, with a half-round arch cut out.
pub(super) fn arch_block(
    width: f32,
    spring: f32,
    top: f32,
    radius: f32,
    depth: f32,
    segments: usize,
) -> MeshBuilder {
    let edge = 0.5 * width;
    let mut lower = vec![Vec2::new(-edge, spring)];
    lower.extend((0..=segments).map(|i| arc(radius, spring, i as f32 / segments as f32)));
    lower.push(Vec2::new(edge, spring));
    let last = (lower.len() - 1) as f32;
    let upper: Vec<Vec2> =
        (0..lower.len()).map(|i| Vec2::new(edge * (2.0 * i as f32 / last - 1.0), top)).collect();
    span(&lower, &upper, depth)
}

/// A half-round arch of constant thickness.
pub(super) fn arch_ring(inner: f32, outer: f32, spring: f32, depth: f32, segments: usize) -> MeshBuilder {
    let line =
        |radius| (0..=segments).map(|i| arc(radius, spring, i as f32 / segments as f32)).collect::<Vec<_>>();
    span(&line(inner), &line(outer), depth)
}

/// A bay of wall around x = 0 from y = `sill` − `below` up to `top` with a round-headed window and its bars.
pub(super) struct Window {
    pub(super) width: f32,
    pub(super) below: f32,
    pub(super) sill: f32,
    pub(super) spring: f32,
    pub(super) top: f32,
    pub(super) radius: f32,
    pub(super) depth: f32,
}

impl Window {
    pub(super) fn wall(&self) -> MeshBuilder {
        let (edge, z) = (0.5 * self.width, 0.5 * self.depth);
        let mut b = arch_block(self.width, self.spring, self.top, self.radius, self.depth, 16);
        b.cuboid(Vec3::new(-edge, self.sill - self.below, -z), Vec3::new(edge, self.sill, z));
        for (x0, x1) in [(-edge, -self.radius), (self.radius, edge)] {
            b.cuboid(Vec3::new(x0, self.sill, -z), Vec3::new(x1, self.spring, z));
        }
        b
    }

    pub(super) fn bars(&self) -> MeshBuilder {
        let mut b = MeshBuilder::default();
        let bar = 0.03;
        let top = self.spring + self.radius;
        for x in [-0.5, 0.0, 0.5].map(|s| s * self.radius) {
            b.cuboid(Vec3::new(x - bar, self.sill, -bar), Vec3::new(x + bar, top - x.abs() * 0.3, bar));
        }
        let rungs = ((self.spring - self.sill) / 0.7).ceil() as usize;
        for i in 1..=rungs {
            let y = self.sill + (self.spring - self.sill) * i as f32 / rungs as f32;
            b.cuboid(Vec3::new(-self.radius, y - bar, -bar), Vec3::new(self.radius, y + bar, bar));
        }
        b
    }
}

/// A fluted column with base and capital from y = 0 to `height`; the shaft's lower radius in m, `levels` rings up the
/// shaft.
pub(super) fn column(height: f32, radius: f32, flutes: usize, levels: usize) -> MeshBuilder {
    let mut b = MeshBuilder::default();
    let block = Vec3::new(2.7, 0.4, 2.7) * radius;
    for y in [0.2 * radius, height - 0.2 * radius] {
        b.block(Vec3::new(0.0, y, 0.0), block);
    }
    let mut turned = |profile: &[(f32, f32)], base: f32, sides: usize, depth: f32| {
        let profile: Vec<Vec2> =
            profile.iter().map(|&(r, y)| Vec2::new(r * radius, base + y * radius)).collect();
        b.lathe(&profile, sides, |i| if i % 2 == 0 { 1.0 } else { 1.0 - depth });
    };
    let torus = [(1.32, 0.4), (1.36, 0.5), (1.3, 0.62), (1.1, 0.68), (1.16, 0.78), (1.04, 0.85)];
    turned(&torus, 0.0, flutes, 0.0);
    let echinus =
        [(0.88, -1.6), (0.96, -1.5), (0.9, -1.4), (0.94, -0.9), (1.12, -0.6), (1.3, -0.45), (1.32, -0.4)];
    turned(&echinus, height, flutes, 0.0);
    // a shaft swells and tapers
    let (low, high) = (0.85 * radius, height - 1.6 * radius);
    let shaft: Vec<(f32, f32)> = (0..levels)
        .map(|k| {
            let t = k as f32 / (levels - 1) as f32;
            (1.0 - 0.14 * t * t, (low + (high - low) * t) / radius)
        })
        .collect();
    turned(&shaft, 0.0, 2 * flutes, 0.09);
    b
}

/// A turned baluster from y = 0 to `height`.
pub(super) fn baluster(height: f32) -> MeshBuilder {
    let profile = [
        (0.075, 0.0),
        (0.075, 0.1),
        (0.04, 0.14),
        (0.06, 0.28),
        (0.07, 0.4),
        (0.035, 0.66),
        (0.05, 0.82),
        (0.07, 0.9),
        (0.07, 1.0),
    ];
    let mut b = MeshBuilder::default();
    b.lathe(&profile.map(|(r, y)| Vec2::new(r, y * height)), 8, |_| 1.0);
    b
}

#[cfg(test)]
mod tests {
    use super::super::super::topology::survey;
    use super::*;

    #[test]
    fn every_part_is_closed_and_faces_outwards() {
        let window =
            Window { width: 4.0, below: 2.0, sill: 2.0, spring: 4.0, top: 6.0, radius: 0.8, depth: 0.4 };
        let parts = [
            arch_block(4.0, 5.0, 7.0, 1.5, 0.7, 24),
            arch_ring(3.0, 3.3, 12.0, 4.0, 24),
            window.bars(),
            column(5.0, 0.4, 20, 6),
            baluster(0.9),
        ];
        for part in parts {
            let s = survey(&part.positions, &part.triangles);
            assert!(s.bad_edges == 0 && s.degenerate == 0 && s.volume > 0.0, "{s:?}");
        }
        // blocks of the window's wall share corners, so it is closed without being a manifold
        let wall = window.wall();
        let volume = survey(&wall.positions, &wall.triangles).volume;
        let by_hand = 0.4 * (4.0 * 6.0 - 1.6 * 2.0 - 0.5 * std::f64::consts::PI * 0.64);
        assert!((volume - by_hand).abs() < 0.01, "{volume} {by_hand}");
    }
}
