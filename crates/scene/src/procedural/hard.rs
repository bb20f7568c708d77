//! Small scenes on which techniques fail first: nothing, one triangle, a light that touches a surface.

use super::builder::MeshBuilder;
use super::stage::Stage;
use crate::Scene;
use glam::Vec3;

/// No triangle: a light in fog.
pub(super) fn empty() -> Scene {
    let mut stage = Stage::default();
    stage.camera([0.0, 1.0, 4.0], [0.0, 1.0, 0.0], 45.0).point_light([0.4, 1.3, 0.0], [8.0; 3]).fog(0.12);
    stage.finish()
}

/// A single triangle, 1 m high, between the viewer and the light.
pub(super) fn triangle() -> Scene {
    let mut b = MeshBuilder::default();
    let corners = [[-0.6, 0.5, 0.0], [0.6, 0.5, 0.2], [0.1, 1.5, -0.1]];
    let [i, j, k] = corners.map(|p| b.vertex(p.into()));
    b.triangle(i, j, k);
    let mut stage = Stage::default();
    stage
        .part("triangle", [0.7, 0.25, 0.2], b)
        .camera([0.5, 1.2, 3.8], [0.0, 1.0, 0.0], 40.0)
        .point_light([-0.02, 0.9, -0.6], [10.0; 3])
        .fog(0.12);
    stage.finish()
}

/// Distance of the light from the wall; units: m.
const GAP: f32 = 1e-4;

/// A wall whose face, z = 0, the light all but touches; a post, which hides the light from the viewer, and the
/// ground stand in its light too.
pub(super) fn wall() -> Scene {
    let (mut wall, mut post, mut ground) =
        (MeshBuilder::default(), MeshBuilder::default(), MeshBuilder::default());
    wall.cuboid(Vec3::new(-1.5, 0.0, -0.2), Vec3::new(1.5, 2.0, 0.0));
    post.cuboid(Vec3::new(0.45, 0.0, 0.5), Vec3::new(0.65, 1.6, 0.7));
    ground.quad([[-5.0, 5.0], [5.0, 5.0], [5.0, -5.0], [-5.0, -5.0]].map(|[x, z]| Vec3::new(x, 0.0, z)));
    let mut stage = Stage::default();
    stage
        .part("wall", [0.65, 0.6, 0.52], wall)
        .part("post", [0.3, 0.36, 0.5], post)
        .part("ground", [0.35, 0.36, 0.33], ground)
        .camera([2.8, 1.4, 3.6], [0.0, 0.95, 0.2], 45.0)
        .point_light([0.1, 1.1, GAP], [8.0; 3])
        .fog(0.15);
    stage.finish()
}

#[cfg(test)]
mod tests {
    use crate::Light;

    #[test]
    fn are_as_bare_as_they_claim() {
        assert_eq!(super::empty().triangle_count(), 0);
        assert!(super::empty().bounds().is_empty());
        assert_eq!(super::triangle().triangle_count(), 1);
    }

    #[test]
    fn the_light_is_in_front_of_the_wall_by_a_hair() {
        let scene = super::wall();
        let Light::Point(light) = &scene.lights[0] else { panic!("a point light") };
        let face = scene.meshes[0].bounds().max.z;
        assert!(light.position.z > face && light.position.z - face < 1e-3);
    }
}
