//! Scenes of boxes, as large as they are asked for: few triangles over a wide ground.

use glam::Vec3;
use scene::{
    Aabb, AirlightModel, Camera, DirectionalLight, Light, Material, Medium, Mesh, PointLight, Scene,
};

use crate::failure::{Failure, Outcome};
use crate::scene_args::Setup;

/// From one house to the next; units: m.
const LOT: f32 = 25.0;

/// Width of a house; units: m.
const HOUSE: f32 = 15.0;

/// Lowest and highest house; units: m.
const HEIGHTS: [f32; 2] = [6.0, 18.0];

/// Height of the viewers' eyes; units: m.
const EYES: f32 = 1.7;

/// Optical depth of 100 m of fog.
const DEPTH: f32 = 0.3;

/// A mesh of closed boxes.
pub(super) fn boxes(all: &[Aabb]) -> Outcome<Mesh> {
    let positions: Vec<Vec3> = all.iter().flat_map(hybrid_march::bounding_box).flatten().collect();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh::new(positions, triangles, 0).map_err(Failure::program)
}

/// A town on a square of `extent` metres, under a lamp at its middle crossing and the sun. Every seventh lot is a green.
pub(super) fn town(extent: f32) -> Outcome<Setup> {
    let half = 0.5 * extent;
    let mut all = vec![Aabb { min: Vec3::new(-half, -0.2, -half), max: Vec3::new(half, 0.0, half) }];
    let lots = (half / LOT).floor() as i32;
    for x in -lots..lots {
        for z in -lots..lots {
            let share = chance(x, z);
            if share < 1.0 / 7.0 {
                continue;
            }
            let min =
                LOT * Vec3::new(x as f32, 0.0, z as f32) + 0.5 * (LOT - HOUSE) * Vec3::new(1.0, 0.0, 1.0);
            let height = HEIGHTS[0] + (HEIGHTS[1] - HEIGHTS[0]) * chance(z + 7, x - 3);
            all.push(Aabb { min, max: min + Vec3::new(HOUSE, height, HOUSE) });
        }
    }
    let scene =
        Scene { meshes: vec![boxes(&all)?], materials: vec![Material::default()], ..Scene::default() };
    let eye = Vec3::new(0.0, EYES, 4.0);
    let camera =
        Camera::look_at(eye, eye + Vec3::new(0.2, 0.05, -1.0), Vec3::Y, 1.0).map_err(Failure::program)?;
    let lamp = PointLight::new(Vec3::new(3.0, 5.0, -8.0), Vec3::splat(300.0)).map_err(Failure::program)?;
    let sun =
        DirectionalLight::new(Vec3::new(0.6, -0.5, 0.35), Vec3::splat(10.0)).map_err(Failure::program)?;
    Ok(Setup {
        scene,
        camera,
        medium: Medium::homogeneous([DEPTH / 100.0; 3], [0.0; 3]).map_err(Failure::program)?,
        lights: vec![Light::Point(lamp), Light::Directional(sun)],
        model: AirlightModel::Sun,
        notes: Vec::new(),
    })
}

/// A number in [0, 1) that belongs to a lot.
fn chance(x: i32, z: i32) -> f32 {
    let mixed = (x as u32).wrapping_mul(0x9e37_79b9) ^ (z as u32).wrapping_mul(0x85eb_ca6b);
    let mixed = (mixed ^ (mixed >> 15)).wrapping_mul(0x2c1b_3c6d);
    ((mixed ^ (mixed >> 12)) >> 8) as f32 / (1 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewers::scattered;
    use scene::Bvh;

    #[test]
    fn towns_grow_with_their_ground() {
        let counts: Vec<usize> = [50.0, 200.0, 1000.0]
            .iter()
            .map(|&extent| town(extent).unwrap().scene.triangle_count())
            .collect();
        assert!(counts[0] >= 24 && counts[1] > 10 * counts[0] && counts[2] > 15 * counts[1], "{counts:?}");
        let setup = town(50.0).unwrap();
        let bvh = Bvh::build(&setup.scene).unwrap();
        assert!((bvh.bounds().max.x - 25.0).abs() < 1e-3);
        let cameras = scattered(&setup.cameras(), &bvh, 64);
        assert!(cameras.iter().all(|camera| (camera.position.y - EYES).abs() < 1e-3));
    }
}
