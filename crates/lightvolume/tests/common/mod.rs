//! Maps and rays that the tests share.

#![allow(dead_code, reason = "each test uses a part of it")]

use glam::{DVec2, DVec3};
use lightvolume::{Criterion, Options, Tessellation};
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
    Constant,
    Ramp,
    Checkerboard,
    /// Every texel for itself, a tenth of them infinite.
    Noise,
    /// A smooth surface with spots of noise.
    Spots,
    Infinite,
}

pub(crate) const RELIEFS: [Relief; 6] =
    [Relief::Constant, Relief::Ramp, Relief::Checkerboard, Relief::Noise, Relief::Spots, Relief::Infinite];

pub(crate) fn map(kind: ProjectionKind, size: (u32, u32), relief: Relief, random: &mut Random) -> DepthMap {
    let projection = projection(kind, random);
    let size = if kind == ProjectionKind::Cube { (size.0, size.0) } else { size };
    let mut depths = Vec::new();
    for _ in projection.faces() {
        let spot = (random.unit(), random.unit());
        for y in 0..size.1 {
            for x in 0..size.0 {
                let (u, v) = (f64::from(x) / f64::from(size.0), f64::from(y) / f64::from(size.1));
                let near = (u - spot.0).hypot(v - spot.1) < 0.15;
                depths.push(match relief {
                    Relief::Constant => 2.5,
                    Relief::Ramp => (2.0 + u + 0.5 * v) as f32,
                    Relief::Checkerboard if (x + y) % 2 == 0 => 1.5,
                    Relief::Checkerboard => 3.0,
                    Relief::Noise if random.unit() < 0.1 => f32::INFINITY,
                    Relief::Noise => random.between(1.0, 4.0) as f32,
                    Relief::Spots if near => random.between(1.0, 2.0) as f32,
                    Relief::Spots => (3.0 + 0.4 * (7.0 * u).sin() * (5.0 * v).cos()) as f32,
                    Relief::Infinite => f32::INFINITY,
                });
            }
        }
    }
    DepthMap::new(projection, size, depths).unwrap()
}

pub(crate) fn adaptive(criterion: Criterion, threshold: f32) -> Options {
    Options::new(Tessellation::Adaptive { criterion, threshold })
}

pub(crate) const CRITERIA: [Criterion; 2] = [Criterion::Laplacian, Criterion::Distance];
