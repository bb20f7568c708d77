//! Tilted slats between the light and the viewer: many thin shadows, one above the other.

use super::builder::MeshBuilder;
use super::stage::Stage;
use crate::Scene;
use glam::{Affine3A, Quat, Vec3};

/// Height of the louvre; units: m.
const HEIGHT: f32 = 2.0;

/// `count` boards over 2 m of height, a little deeper than their spacing.
fn scene(count: usize) -> Scene {
    let spacing = HEIGHT / count as f32;
    let mut board = MeshBuilder::default();
    board.block(Vec3::ZERO, Vec3::new(3.0, 0.08 * spacing, 1.1 * spacing));
    let tilt = Quat::from_rotation_x(0.75);
    let mut boards = MeshBuilder::default();
    for i in 0..count {
        let at = Vec3::new(0.0, 0.3 + spacing * (i as f32 + 0.5), 0.0);
        boards.append(&board, Affine3A::from_rotation_translation(tilt, at));
    }
    let mut floor = MeshBuilder::default();
    floor.quad([[-6.0, 6.0], [6.0, 6.0], [6.0, -6.0], [-6.0, -6.0]].map(|[x, z]| Vec3::new(x, 0.0, z)));
    let mut stage = Stage::default();
    stage
        .part("slats", [0.6, 0.42, 0.25], boards)
        .part("floor", [0.4, 0.4, 0.42], floor)
        .camera([1.6, 1.0, 3.6], [0.0, 1.2, 0.0], 45.0)
        .point_light([-0.3, 1.5, -0.35], [20.0; 3])
        .fog(0.1);
    stage.finish()
}

/// Eight slats.
pub(super) fn slats() -> Scene {
    scene(8)
}

/// Five hundred slats, 4 mm apart.
pub(super) fn slats_500() -> Scene {
    scene(500)
}

#[cfg(test)]
mod tests {
    #[test]
    fn boards_do_not_touch() {
        for (scene, count) in [(super::slats(), 8), (super::slats_500(), 500)] {
            assert_eq!(scene.triangle_count(), 12 * count + 2);
            let heights: Vec<(f32, f32)> = scene.meshes[0]
                .positions()
                .chunks(8)
                .map(|board| board.iter().fold((f32::MAX, f32::MIN), |(l, h), p| (l.min(p.y), h.max(p.y))))
                .collect();
            assert!(heights.windows(2).all(|w| w[0].1 < w[1].0), "{heights:?}");
        }
    }
}
