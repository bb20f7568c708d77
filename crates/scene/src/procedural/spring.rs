//! The spring of Wyman & Ramsey's Table 1 ("Spring", 32k triangles).

use super::builder::MeshBuilder;
use super::stage::Stage;
use crate::Scene;
use glam::Vec3;

const TURNS: f32 = 8.0;
const HEIGHT: f32 = 2.0;
/// From the axis to the middle of the wire; units: m.
const COIL_RADIUS: f32 = 0.5;
const WIRE_RADIUS: f32 = 0.06;
const RINGS: usize = 499;
const SIDES: usize = 32;

/// 31,936 triangles: a capped tube along a helix of 8 turns, 2 m high, resting on y = 0.
pub(super) fn scene() -> Scene {
    let path: Vec<Vec3> = (0..RINGS)
        .map(|k| {
            let t = k as f32 / (RINGS - 1) as f32;
            let (sin, cos) = (TURNS * std::f32::consts::TAU * t).sin_cos();
            // the wire's ends lie almost flat, so the tube reaches one wire radius beyond its path
            Vec3::new(COIL_RADIUS * cos, WIRE_RADIUS + (HEIGHT - 2.0 * WIRE_RADIUS) * t, COIL_RADIUS * sin)
        })
        .collect();
    let mut spring = MeshBuilder::default();
    spring.tube(&path, SIDES, |_| WIRE_RADIUS);
    let mut stage = Stage::default();
    stage
        .part("spring", [0.45, 0.5, 0.58], spring)
        .camera([1.1, 1.5, 4.2], [0.0, 1.0, 0.0], 40.0)
        .point_light([0.0, 1.0, 0.0], [12.0; 3])
        .fog(0.12);
    stage.finish()
}

#[cfg(test)]
mod tests {
    use super::super::topology::survey_scene;

    #[test]
    fn is_a_closed_tube() {
        let scene = super::scene();
        let s = survey_scene(&scene);
        assert!(s.is_closed_manifold(), "{s:?}");
        assert_eq!((scene.triangle_count(), s.genus()), (31_936, 0));
        assert!(s.volume > 0.0);
        let bounds = scene.bounds();
        assert!(bounds.min.y.abs() < 2e-3 && (bounds.max.y - 2.0).abs() < 2e-3, "{bounds:?}");
    }
}
