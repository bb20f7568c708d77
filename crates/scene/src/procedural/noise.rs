//! Repeatable randomness: a small generator and smooth noise, the same on every machine and in every run.

use glam::Vec3;

/// Scrambles 64 bits; neighbouring inputs give unrelated outputs.
fn scramble(mut x: u64) -> u64 {
    x = (x ^ (x >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    x = (x ^ (x >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    x ^ (x >> 32)
}

/// The upper 24 bits as a number in [0, 1): every value is exact in `f32`.
fn unit(bits: u64) -> f32 {
    (bits >> 40) as f32 / (1 << 24) as f32
}

/// A sequence of random numbers that depends on its seed alone.
#[derive(Debug, Clone)]
pub(super) struct Rng(u64);

impl Rng {
    pub(super) fn new(seed: u64) -> Self {
        Self(scramble(seed.wrapping_add(0x9E37_79B9_7F4A_7C15)))
    }

    /// Uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        unit(scramble(self.0))
    }

    /// Uniform in [low, high).
    pub(super) fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Uniform in 0 … n − 1; `n` is at least 1.
    pub(super) fn index(&mut self, n: usize) -> usize {
        ((self.unit() * n as f32) as usize).min(n.saturating_sub(1))
    }

    /// Uniform on the unit sphere.
    pub(super) fn direction(&mut self) -> Vec3 {
        let y = self.range(-1.0, 1.0);
        let (sin, cos) = self.range(0.0, std::f32::consts::TAU).sin_cos();
        let r = (1.0 - y * y).max(0.0).sqrt();
        Vec3::new(r * cos, y, r * sin)
    }
}

/// Smooth noise in [−1, 1] that varies over a distance of about 1.
pub(super) fn noise(p: Vec3, seed: u64) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    // the quintic has zero slope and curvature at the cell's corners, so that no crease shows
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let corner = |dx: i64, dy: i64, dz: i64| {
        let key = (cell.x as i64 + dx) as u64
            ^ scramble((cell.y as i64 + dy) as u64 ^ scramble((cell.z as i64 + dz) as u64 ^ seed));
        2.0 * unit(scramble(key)) - 1.0
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let edge = |dy, dz| mix(corner(0, dy, dz), corner(1, dy, dz), w.x);
    mix(mix(edge(0, 0), edge(1, 0), w.y), mix(edge(0, 1), edge(1, 1), w.y), w.z)
}

/// A sum of `octaves` of [`noise`], each of half the size and half the strength of the one before; about in [−1, 1].
pub(super) fn fractal_noise(p: Vec3, octaves: u32, seed: u64) -> f32 {
    let octave = |k: u32| {
        let scale = (1_u32 << k) as f32;
        noise(p * scale, seed.wrapping_add(u64::from(k))) / scale
    };
    0.5 * (0..octaves).map(octave).sum::<f32>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_numbers_fill_their_range_and_repeat() {
        let draw = |seed| {
            let mut rng = Rng::new(seed);
            (0..10_000).map(|_| rng.unit()).collect::<Vec<_>>()
        };
        let a = draw(1);
        assert!(a.iter().all(|x| (0.0..1.0).contains(x)));
        assert!((a.iter().sum::<f32>() / a.len() as f32 - 0.5).abs() < 0.02);
        assert_eq!(a, draw(1));
        assert_ne!(a, draw(2));
        let mut rng = Rng::new(3);
        assert!((0..1000).all(|_| rng.index(7) < 7));
        assert!((0..1000).all(|_| (rng.direction().length() - 1.0).abs() < 1e-5));
    }

    #[test]
    fn noise_is_bounded_continuous_and_not_flat() {
        let at = |i: usize| noise(Vec3::new(0.013 * i as f32, -7.3, 0.007 * i as f32), 5);
        let values: Vec<f32> = (0..5000).map(at).collect();
        assert!(values.iter().all(|v| v.abs() <= 1.0));
        assert!(values.windows(2).all(|w| (w[0] - w[1]).abs() < 0.1));
        let (low, high) = values.iter().fold((1.0_f32, -1.0_f32), |(l, h), &v| (l.min(v), h.max(v)));
        assert!(high - low > 0.8, "{low} to {high}");
    }
}
