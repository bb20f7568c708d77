//! Maps and rays that the tests share.

#![allow(dead_code, reason = "each test uses a part of it")]

use glam::{DVec2, DVec3};
use scene::{DRay, Interval};
use shadowmap::{DepthMap, Projection, ProjectionKind};

/// Numbers in [0, 1) that are the same on every run.
#[derive(Debug, Clone)]
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x1234_5678_9ABC_DEF1)
    }

    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (mixed >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn vector(&mut self, reach: f64) -> DVec3 {
        DVec3::new(self.between(-reach, reach), self.between(-reach, reach), self.between(-reach, reach))
    }

    pub(crate) fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector(1.0);
            if v.length() > 0.05 && v.length() < 1.0 {
                return v.normalize();
            }
        }
    }
}

pub(crate) const KINDS: [ProjectionKind; 3] =
    [ProjectionKind::Perspective, ProjectionKind::Orthographic, ProjectionKind::Cube];

/// A light near the origin that sees a few metres around it.
pub(crate) fn projection(kind: ProjectionKind, random: &mut Random) -> Projection {
    let position = random.vector(1.0);
    let (forward, right) = (random.direction(), random.direction());
    let half = DVec2::new(random.between(0.3, 1.5), random.between(0.3, 1.5));
    match kind {
        ProjectionKind::Perspective => Projection::perspective(position, forward, right, half),
        ProjectionKind::Orthographic => {
            Projection::orthographic(position - 3.0 * forward, forward, right, 2.0 * half)
        }
        ProjectionKind::Cube => Projection::cube(position),
    }
    .unwrap()
}

/// What a map looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Relief {
    /// Every texel for itself.
    Noise,
    /// As noise, a tenth of the texels infinite.
    Holes,
    /// Blocks before a smooth background.
    Blocks,
}

pub(crate) fn map(kind: ProjectionKind, size: (u32, u32), relief: Relief, random: &mut Random) -> DepthMap {
    let projection = projection(kind, random);
    let size = if kind == ProjectionKind::Cube { (size.0, size.0) } else { size };
    let faces = projection.faces().len();
    let mut depths = Vec::new();
    for face in 0..faces {
        let phase = random.unit() * 6.0;
        for y in 0..size.1 {
            for x in 0..size.0 {
                let (u, v) = (f64::from(x) / f64::from(size.0), f64::from(y) / f64::from(size.1));
                let depth = match relief {
                    Relief::Noise => random.between(0.5, 4.0),
                    Relief::Holes if random.unit() < 0.1 => f64::INFINITY,
                    Relief::Holes => random.between(0.5, 4.0),
                    Relief::Blocks => {
                        let block = ((u * 3.0).floor() + (v * 3.0).floor() + face as f64) as u32;
                        if block.is_multiple_of(3) {
                            1.0 + 0.3 * u
                        } else {
                            3.0 + (5.0 * u + phase).sin() * (4.0 * v).cos()
                        }
                    }
                };
                depths.push(depth as f32);
            }
        }
    }
    DepthMap::new(projection, size, depths).unwrap()
}

/// A view ray that passes by the light.
pub(crate) fn ray(random: &mut Random) -> DRay {
    let origin = random.vector(4.0);
    let target = random.vector(1.5);
    DRay { origin, direction: (target - origin).normalize_or(DVec3::X) }
}

pub(crate) fn contains(pieces: &[Interval], x: f64) -> bool {
    pieces.iter().any(|i| i.start <= x && x <= i.end)
}

/// Whether `x` is within `margin` of an end of a piece.
pub(crate) fn near_end(pieces: &[Interval], x: f64, margin: f64) -> bool {
    pieces.iter().any(|i| (x - i.start).abs() < margin || (x - i.end).abs() < margin)
}

pub(crate) fn well_formed(pieces: &[Interval], span: Interval) -> bool {
    pieces.windows(2).all(|w| w[0].end < w[1].start)
        && pieces.iter().all(|i| !i.is_empty() && i.start >= span.start && i.end <= span.end)
}

/// Length of what one list covers and the other does not.
pub(crate) fn difference(a: &[Interval], b: &[Interval]) -> f64 {
    let mut cuts: Vec<f64> = a.iter().chain(b).flat_map(|i| [i.start, i.end]).collect();
    cuts.sort_unstable_by(f64::total_cmp);
    cuts.windows(2)
        .filter(|w| w[1] > w[0])
        .map(|w| {
            let middle = if w[1].is_finite() { 0.5 * (w[0] + w[1]) } else { 2.0 * w[0].abs() + 1.0 };
            if contains(a, middle) == contains(b, middle) { 0.0 } else { w[1] - w[0] }
        })
        .sum()
}
