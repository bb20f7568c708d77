//! What stands in the street: lamp posts, cobbles, cables.

use super::super::builder::MeshBuilder;
use super::super::noise::Rng;
use glam::{Vec2, Vec3};

/// Height of a lantern's bulb above the pavement; units: m.
pub(super) const BULB: f32 = 3.3;

/// A lamp post at the origin whose lantern of four bars and a hat leaves its bulb in the open.
pub(super) fn lamp_post() -> MeshBuilder {
    let profile = [
        (0.2, 0.0),
        (0.2, 0.12),
        (0.12, 0.2),
        (0.14, 0.5),
        (0.08, 0.65),
        (0.065, 0.8),
        (0.05, 2.6),
        (0.09, 2.68),
        (0.05, 2.76),
        (0.13, 2.95),
        (0.16, 3.0),
    ];
    let mut b = MeshBuilder::default();
    b.lathe(&profile.map(Vec2::from), 16, |_| 1.0);
    for k in 0..4 {
        let (sin, cos) = (std::f32::consts::FRAC_PI_2 * (k as f32 + 0.5)).sin_cos();
        b.rod(Vec3::new(0.14 * cos, 2.98, 0.14 * sin), Vec3::new(0.2 * cos, 3.62, 0.2 * sin), 0.014, 6);
    }
    let hat = [(0.24, 3.6), (0.25, 3.64), (0.14, 3.8), (0.05, 3.88), (0.03, 3.98), (0.0, 4.02)];
    b.lathe(&hat.map(Vec2::from), 16, |_| 1.0);
    b
}

/// A pavement of low stones with gaps between them over [−`half`, `half`] × [`near`, `far`] (x, z; z falls).
pub(super) fn cobbles(half: f32, near: f32, far: f32, rng: &mut Rng) -> MeshBuilder {
    let mut b = MeshBuilder::default();
    let (nx, nz) = ((2.0 * half / 0.32) as usize, ((near - far) / 0.32) as usize);
    let size = Vec2::new(2.0 * half / nx as f32, (near - far) / nz as f32);
    for j in 0..nz {
        for i in 0..nx {
            // rows are set off by half a stone
            let shift = if j % 2 == 0 { 0.25 } else { -0.25 };
            let middle =
                Vec3::new(-half + size.x * (i as f32 + 0.5 + shift), 0.0, near - size.y * (j as f32 + 0.5));
            let height = rng.range(0.02, 0.05);
            let ring = |b: &mut MeshBuilder, share: f32, y: f32| {
                [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| {
                    b.vertex(middle + Vec3::new(0.5 * share * size.x * x, y, 0.5 * share * size.y * z))
                })
            };
            let (low, high) = (ring(&mut b, 1.0, 0.0), ring(&mut b, 0.8, height));
            b.band(&low, &high, true);
            b.triangle(high[0], high[1], high[2]);
            b.triangle(high[0], high[2], high[3]);
        }
    }
    b
}

/// A cable that hangs between two points.
pub(super) fn cable(b: &mut MeshBuilder, from: Vec3, to: Vec3, sag: f32) {
    let path: Vec<Vec3> = (0..=16)
        .map(|k| {
            let t = k as f32 / 16.0;
            from.lerp(to, t) - Vec3::new(0.0, 4.0 * sag * t * (1.0 - t), 0.0)
        })
        .collect();
    b.tube(&path, 5, |_| 0.012);
}

#[cfg(test)]
mod tests {
    use super::super::super::topology::survey;
    use super::*;

    #[test]
    fn the_bulb_is_in_the_open() {
        let lamp = lamp_post();
        let s = survey(&lamp.positions, &lamp.triangles);
        assert!(s.is_closed_manifold() && s.volume > 0.0, "{s:?}");
        let bulb = Vec3::new(0.0, BULB, 0.0);
        assert!(lamp.positions.iter().all(|p| (*p - bulb).length() > 0.15));
    }

    #[test]
    fn cobbles_face_up() {
        let b = cobbles(2.0, 1.0, -3.0, &mut Rng::new(1));
        let up = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| b.positions[i as usize]);
            (b - a).cross(c - a).y > 0.0
        };
        assert!(!b.triangles.is_empty() && b.triangles.iter().all(up));
    }
}
