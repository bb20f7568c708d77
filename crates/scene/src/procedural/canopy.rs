//! A roof of leaves under the sun: thousands of small openings, a directional light.

use super::builder::MeshBuilder;
use super::foliage::leaf;
use super::noise::{Rng, noise};
use super::stage::Stage;
use crate::Scene;
use glam::Vec3;

const LEAVES: usize = 7000;
/// Half the side of the square that the leaves cover; units: m.
const HALF: f32 = 9.0;

/// Leaves mostly level, between 2.6 m and 4 m above the floor, denser in clumps.
fn roof() -> MeshBuilder {
    let mut rng = Rng::new(7);
    let mut b = MeshBuilder::default();
    while b.triangles.len() < 2 * LEAVES {
        let at = Vec3::new(rng.range(-HALF, HALF), rng.range(2.6, 4.0), rng.range(-HALF, HALF));
        if noise(at * Vec3::new(0.8, 0.0, 0.8), 7) + 0.45 < rng.unit() * 0.9 {
            continue;
        }
        let along = rng.direction() * Vec3::new(1.0, 0.35, 1.0);
        let facing = Vec3::Y + 0.5 * rng.direction();
        leaf(&mut b, at, along.normalize_or(Vec3::X), facing, rng.range(0.25, 0.5));
    }
    b
}

/// Slender trunks that reach into the roof.
fn trunks() -> MeshBuilder {
    let mut rng = Rng::new(8);
    let mut b = MeshBuilder::default();
    for i in 0..5 {
        for j in 0..5 {
            let [x, z] = [i, j].map(|k| 3.4 * (k as f32 - 2.0) + rng.range(-0.9, 0.9));
            let lean = 0.15 * rng.direction();
            let path: Vec<Vec3> = (0..6)
                .map(|k| Vec3::new(x, 0.7 * k as f32, z) + k as f32 * lean * Vec3::new(1.0, 0.0, 1.0))
                .collect();
            b.tube(&path, 10, |k| 0.09 - 0.01 * k as f32);
        }
    }
    b
}

/// 7,000 leaf cards over a floor; the sun stands high, a little to the side.
pub(super) fn scene() -> Scene {
    let mut floor = MeshBuilder::default();
    let at = |i: usize| 40.0 * (i as f32 / 20.0 - 0.5);
    floor.grid(20, 20, |i, j| Vec3::new(at(i), 0.0, -at(j)));
    let mut stage = Stage::default();
    stage
        .part("leaves", [0.16, 0.36, 0.09], roof())
        .part("trunks", [0.27, 0.2, 0.14], trunks())
        .part("floor", [0.3, 0.27, 0.2], floor)
        .camera([1.2, 1.9, 8.0], [-0.3, 1.5, 0.0], 50.0)
        .directional_light([0.45, -1.0, 0.15], [4.0, 3.8, 3.4])
        .fog(0.09);
    stage.finish()
}

#[cfg(test)]
mod tests {
    #[test]
    fn has_its_leaves_above_the_viewer() {
        let scene = super::scene();
        assert_eq!(scene.meshes[0].triangles().len(), 2 * super::LEAVES);
        assert!(scene.meshes[0].bounds().min.y > scene.cameras[0].position.y);
    }
}
