//! A street of houses with balconies, awnings, lamp posts and trees, for San Miguel and Bistro of the shared shadow
//! grid's tables (both far larger; the character is what counts here).
//!
//! The street runs along −Z; house fronts stand at x = ±[`FRONT`].

mod facade;
mod furniture;

use super::builder::MeshBuilder;
use super::foliage::{Tree, leaves};
use super::noise::Rng;
use super::stage::Stage;
use crate::Scene;
use facade::Front;
use furniture::{BULB, cable, cobbles, lamp_post};
use glam::{Affine3A, Quat, Vec3};

const TRIANGLES: usize = 280_000;
/// Distance of the house fronts from the middle of the street; units: m.
const FRONT: f32 = 6.0;
/// Half the width of the roadway; units: m.
const ROAD: f32 = 3.4;
/// Width of a house and number of houses on each side; units: m.
const HOUSE: f32 = 11.5;
const HOUSES: usize = 4;
/// Where the street begins and ends; units: m.
const NEAR: f32 = 6.0;
const FAR: f32 = NEAR - HOUSE * HOUSES as f32;

/// Wall colours of the houses in turn.
const WALLS: [[f32; 3]; 3] = [[0.6, 0.44, 0.24], [0.56, 0.3, 0.22], [0.62, 0.56, 0.44]];

/// House fronts on both sides; walls sorted by colour.
fn houses(rng: &mut Rng) -> (Front, [MeshBuilder; 3]) {
    let (mut all, mut walls) = (Front::default(), std::array::from_fn(|_| MeshBuilder::default()));
    for side in [-1.0_f32, 1.0] {
        for i in 0..HOUSES {
            let floors = 3 + rng.index(2);
            let front = Front::build(HOUSE, 5, floors, rng);
            // the front's +z turns to face the street
            let turn = Quat::from_rotation_y(-side * std::f32::consts::FRAC_PI_2);
            let left = if side < 0.0 { NEAR - HOUSE * i as f32 } else { NEAR - HOUSE * (i + 1) as f32 };
            let pose = Affine3A::from_rotation_translation(turn, Vec3::new(side * FRONT, 0.0, left));
            let colour = (i + if side < 0.0 { 0 } else { 2 }) % 3;
            walls[colour].append(&front.wall, pose);
            for (to, from) in [
                (&mut all.stone, &front.stone),
                (&mut all.wood, &front.wood),
                (&mut all.iron, &front.iron),
                (&mut all.glass, &front.glass),
                (&mut all.cloth, &front.cloth),
                (&mut all.plants, &front.plants),
            ] {
                to.append(from, pose);
            }
        }
    }
    (all, walls)
}

/// Street trees: their wood and where their leaves grow.
fn trees(rng: &mut Rng) -> (MeshBuilder, Vec<Vec3>) {
    let (mut wood, mut twigs) = (MeshBuilder::default(), Vec::new());
    for i in 0..8 {
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        let tree = Tree::grow(rng.range(4.6, 5.6), rng);
        let pose = Affine3A::from_translation(Vec3::new(side * 4.2, 0.12, -2.5 - 4.6 * i as f32));
        wood.append(&tree.wood, pose);
        twigs.extend(tree.twigs.iter().map(|&p| pose.transform_point3(p)));
    }
    (wood, twigs)
}

/// Positions of the lamp posts on the pavements, alternately right and left.
fn lamps() -> impl Iterator<Item = Vec3> {
    (0..6).map(|i| {
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        Vec3::new(side * 3.8, 0.12, -0.5 - 6.5 * i as f32)
    })
}

/// 280,000 triangles: as many leaves as everything else leaves over. One lantern burns.
pub(super) fn scene() -> Scene {
    let mut rng = Rng::new(280);
    let (mut houses, walls) = houses(&mut rng);
    let (wood, twigs) = trees(&mut rng);
    let road = cobbles(ROAD, NEAR, FAR, &mut rng);
    let mut pavement = MeshBuilder::default();
    for side in [-1.0, 1.0] {
        let middle = Vec3::new(side * 0.5 * (ROAD + FRONT), 0.06, 0.5 * (NEAR + FAR));
        pavement.block(middle, Vec3::new(FRONT - ROAD, 0.12, NEAR - FAR));
    }
    let (post, mut posts) = (lamp_post(), MeshBuilder::default());
    for at in lamps() {
        posts.append(&post, Affine3A::from_translation(at));
    }
    for k in 0..5 {
        let z = -6.0 - 7.0 * k as f32;
        cable(&mut houses.iron, Vec3::new(-FRONT, 6.6, z), Vec3::new(FRONT, 6.9, z - 1.5), 0.5);
    }

    let mut stage = Stage::default();
    for (wall, colour) in walls.into_iter().zip(WALLS) {
        stage.part("house wall", colour, wall);
    }
    stage
        .part("stone", [0.5, 0.48, 0.44], houses.stone)
        .part("painted wood", [0.16, 0.27, 0.26], houses.wood)
        .part("iron", [0.08, 0.08, 0.09], houses.iron)
        .part("glass", [0.1, 0.13, 0.16], houses.glass)
        .part("awnings", [0.6, 0.12, 0.1], houses.cloth)
        .part("flowers", [0.5, 0.15, 0.25], houses.plants)
        .part("cobbles", [0.27, 0.26, 0.25], road)
        .part("pavement", [0.4, 0.38, 0.35], pavement)
        .part("lamp posts", [0.07, 0.1, 0.09], posts)
        .part("tree wood", [0.24, 0.18, 0.12], wood);
    let mut foliage = MeshBuilder::default();
    let rest = TRIANGLES.saturating_sub(stage.triangle_count());
    leaves(&mut foliage, &twigs, rest / 2, 0.3, (0.1, 0.2), &mut rng);
    let bulb = lamps().nth(2).unwrap_or_default() + Vec3::new(0.0, BULB, 0.0);
    stage
        .part("leaves", [0.17, 0.34, 0.1], foliage)
        .camera([-1.0, 1.75, 3.5], [0.4, 3.0, -14.0], 55.0)
        .point_light(bulb.to_array(), [280.0, 245.0, 190.0])
        .fog(0.025);
    stage.finish()
}

#[cfg(test)]
mod tests {
    #[test]
    fn has_the_stated_size() {
        // single triangles are not filled in: leaves come in twos
        assert!(super::scene().triangle_count().abs_diff(super::TRIANGLES) <= 1);
    }
}
