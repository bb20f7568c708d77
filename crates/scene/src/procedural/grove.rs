//! A clearing between trees on hilly ground, for the Utah Fairy Forest of Wyman & Ramsey's Table 1 ("Fairy", 155k).

use super::builder::MeshBuilder;
use super::foliage::{Tree, leaf, leaves};
use super::noise::{Rng, fractal_noise};
use super::stage::Stage;
use crate::Scene;
use glam::{Affine3A, Quat, Vec3};

const TRIANGLES: usize = 155_000;
/// Half the side of the ground; units: m.
const HALF: f32 = 11.0;
/// Quadrangles along a side of the ground.
const CELLS: usize = 110;
const TREES: usize = 16;
const BLADES: usize = 14_000;

/// Height of the ground; units: m. The clearing in the middle is nearly flat.
fn ground_height(x: f32, z: f32) -> f32 {
    let p = Vec3::new(x, 0.0, z);
    let rise = (p.length() / HALF).min(1.2).powi(2);
    1.6 * rise * (0.6 + fractal_noise(0.22 * p, 3, 31)) + 0.12 * fractal_noise(1.1 * p, 2, 32)
}

fn on_ground(x: f32, z: f32) -> Vec3 {
    Vec3::new(x, ground_height(x, z), z)
}

/// Positions of the trees: a ring around the clearing, open towards the viewer at +z.
fn places(rng: &mut Rng) -> Vec<Vec3> {
    (0..TREES)
        .map(|i| {
            let turn = 0.6 + 5.1 * (i as f32 + rng.range(-0.2, 0.2)) / (TREES - 1) as f32;
            let distance = if i % 2 == 0 { rng.range(2.6, 3.8) } else { rng.range(5.5, 8.5) };
            on_ground(distance * turn.sin(), distance * turn.cos())
        })
        .collect()
}

/// 155,000 triangles: as many leaves as the ground, the wood and the grass leave over.
pub(super) fn scene() -> Scene {
    let mut rng = Rng::new(155);
    let (mut ground, mut wood, mut twigs) = (MeshBuilder::default(), MeshBuilder::default(), Vec::new());
    let at = |i: usize| HALF * (2.0 * i as f32 / CELLS as f32 - 1.0);
    ground.grid(CELLS, CELLS, |i, j| on_ground(at(i), -at(j)));
    for place in places(&mut rng) {
        let tree = Tree::grow(rng.range(3.6, 5.2), &mut rng);
        let turn = Quat::from_rotation_y(rng.range(0.0, std::f32::consts::TAU));
        let pose = Affine3A::from_rotation_translation(turn, place);
        wood.append(&tree.wood, pose);
        twigs.extend(tree.twigs.iter().map(|&p| pose.transform_point3(p)));
    }
    let mut grass = MeshBuilder::default();
    for _ in 0..BLADES {
        let root = on_ground(rng.range(-HALF, HALF), rng.range(-HALF, HALF));
        let along = (Vec3::Y + 0.5 * rng.direction()).normalize_or(Vec3::Y);
        leaf(&mut grass, root, along, rng.direction(), rng.range(0.1, 0.3));
    }
    let mut foliage = MeshBuilder::default();
    let rest =
        TRIANGLES.saturating_sub(ground.triangles.len() + wood.triangles.len() + grass.triangles.len());
    leaves(&mut foliage, &twigs, rest / 2, 0.28, (0.12, 0.24), &mut rng);

    let mut stage = Stage::default();
    stage
        .part("ground", [0.28, 0.22, 0.13], ground)
        .part("wood", [0.24, 0.17, 0.11], wood)
        .part("grass", [0.25, 0.42, 0.1], grass)
        .part("leaves", [0.15, 0.34, 0.1], foliage)
        .camera([0.9, 1.7, 9.5], [0.0, 1.9, 0.0], 45.0)
        .point_light([2.3, 2.6, 1.0], [60.0, 56.0, 48.0])
        .fog(0.045);
    stage.finish()
}

#[cfg(test)]
mod tests {
    #[test]
    fn has_the_size_of_the_fairy_forest() {
        assert_eq!(super::scene().triangle_count(), super::TRIANGLES);
    }
}
