//! Cases on which sums overflow, divide by nothing or run empty.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

mod support;

use froxel_grid::{
    Froxels, GridMemory, GridReads, MAX_LIGHTS, MaskWidth, Near, SharedGrid, Slices, Temporal, Update,
};
use glam::Vec3;
use scene::{
    Aabb, AirlightModel, Density, DirectionalLight, Light, Medium, PointLight, SpotLight, procedural,
};
use support::{Stage, is_sound};

const SIZE: (u32, u32) = (33, 17);

/// The reference and the grid in several guises.
fn guises(range: f32, voxel_size: f32) -> Vec<Froxels> {
    let froxels = Froxels { tile: 8, slices: 24, ..Froxels::new(range) };
    let near = Near::Frustum { side: 2, slices: 8 };
    let paper = SharedGrid { near, ..SharedGrid::paper(voxel_size) };
    let marked = SharedGrid { near, ..SharedGrid::marked(voxel_size) };
    let trilinear =
        SharedGrid { reads: GridReads::Trilinear, update: Update::Marked { alternate: true }, ..marked };
    let fine = SharedGrid {
        near: Near::FineGrid { ratio: 2, slices: 8 },
        memory: GridMemory::Bricks { most: 64 },
        lights: MaskWidth::ThirtyTwo,
        ..marked
    };
    let temporal = Froxels { temporal: Some(Temporal::default()), ..froxels.with_grid(marked) };
    let mut all = vec![froxels, temporal];
    all.extend([paper, marked, trilinear, fine].map(|grid| froxels.with_grid(grid)));
    all
}

fn survives(name: &str, stage: &Stage, range: f32, voxel_size: f32) {
    for froxels in guises(range, voxel_size) {
        let mut fog = froxel_grid::FroxelFog::new(froxels).unwrap();
        for _ in 0..2 {
            let rendered = stage.render(&mut fog);
            assert!(is_sound(&rendered), "{name}, {froxels:?}: {:?}", rendered.counts);
        }
    }
}

#[test]
fn generated_scenes() {
    for name in ["empty", "triangle", "wall", "lampshade", "slats-500", "canopy"] {
        survives(name, &Stage::generated(name, SIZE), 10.0, 0.2);
    }
}

fn lamp(position: Vec3) -> Light {
    Light::Point(PointLight::new(position, Vec3::new(3.0, 2.0, 1.0)).unwrap())
}

#[test]
fn lights_where_froxels_and_voxels_are() {
    let mut stage = Stage::generated("triangle", SIZE);
    let eye = stage.cameras[0].position;
    let layout = froxel_grid::FroxelView::new(&stage.cameras[0], SIZE, 8);
    let slices = Slices::new(&Froxels { slices: 24, ..Froxels::new(10.0) });
    let froxel = eye + slices.distance(9, 0.5) * layout.direction(2, 1, 1);
    let lattice = SharedGrid::paper(0.2).lattice(&stage.bvh.bounds()).unwrap();
    let voxel = lattice.center(lattice.dims / 2);
    for (name, position) in [("eye", eye), ("froxel", froxel), ("voxel", voxel)] {
        stage.lights = vec![lamp(position)];
        survives(name, &stage, 10.0, 0.2);
        for degrees in [0.5_f32, 45.0, 89.5] {
            let outer = degrees.to_radians();
            let spot = SpotLight::new(position, Vec3::NEG_Y, 0.0, outer, Vec3::ONE).unwrap();
            stage.lights = vec![Light::Spot(spot)];
            survives(name, &stage, 10.0, 0.2);
        }
    }
    // along the view, from the front and from behind
    for sign in [1.0, -1.0] {
        let sun = DirectionalLight::new(sign * stage.cameras[0].forward, Vec3::ONE).unwrap();
        stage.lights = vec![Light::Directional(sun)];
        survives("sun along the view", &stage, 10.0, 0.2);
    }
}

#[test]
fn thin_and_thick_media() {
    let mut stage = Stage::generated("triangle", SIZE);
    stage.lights.push(Light::Directional(DirectionalLight::new(Vec3::NEG_Y, Vec3::ONE).unwrap()));
    for depth in [0.0, 1e-8, 1.0, 1e3, 1e6] {
        let sigma = depth / 10.0;
        for [s, a] in [[sigma, 0.0], [0.0, sigma], [sigma, sigma]] {
            for model in [AirlightModel::Sun, AirlightModel::HoffmanPreetham] {
                stage.model = model;
                // one channel without any medium
                stage.medium = Medium::homogeneous([s, s, 0.0], [a, a, 0.0]).unwrap();
                survives("medium", &stage, 10.0, 0.2);
            }
        }
    }
    let thick = Medium::homogeneous([100.0, 1.0, 0.0], [1.0; 3]).unwrap();
    let height = Density::height(-50.0, 0.05).unwrap();
    stage.medium = Medium { density: Some(height), emission: [1e3; 3], ..thick.clone() };
    survives("height", &stage, 10.0, 0.2);
    let bounds = Some(Aabb { min: Vec3::splat(50.0), max: Vec3::splat(51.0) });
    stage.medium = Medium { bounds, ..thick };
    let rendered = stage.once(Froxels::new(10.0));
    assert!(rendered.airlight[0].iter().all(|v| *v == Vec3::ZERO));
    assert_eq!(rendered.counts.rays(), 0, "no ray where there is no medium");
}

#[test]
fn any_number_of_lights_up_to_the_most() {
    let mut stage = Stage::generated("triangle", SIZE);
    for count in [0, 1, 8, 9, 32] {
        let position = |i: usize| Vec3::new(i as f32 * 0.1 - 1.0, 2.0 + (i % 3) as f32, -1.0);
        stage.lights = (0..count).map(|i| lamp(position(i))).collect();
        survives("lights", &stage, 10.0, 0.2);
        let counts = stage.once(Froxels::new(10.0)).counts;
        assert!(counts.dropped == 0 && (counts.rays() > 0) == (count > 0));
    }
    stage.lights = vec![lamp(Vec3::ONE); MAX_LIGHTS + 1];
    let view = froxel_grid::View { camera: &stage.cameras[0], size: SIZE, ends: &stage.ends[0] };
    let frame = froxel_grid::Frame {
        views: &[view],
        medium: &stage.medium,
        lights: &stage.lights,
        model: AirlightModel::Sun,
        occluders: None,
    };
    let mut fog = froxel_grid::FroxelFog::new(Froxels::new(10.0)).unwrap();
    let error = fog.render(&frame).unwrap_err();
    assert_eq!(error, froxel_grid::FroxelError::TooManyLights { got: 33, most: 32 });
}

#[test]
fn scenes_of_any_size() {
    for scale in [1e-3_f32, 1e5] {
        let mut scene = procedural::generate("triangle").unwrap();
        let mesh = &scene.meshes[0];
        let positions = mesh.positions().iter().map(|p| scale * *p).collect();
        scene.meshes[0] = scene::Mesh::new(positions, mesh.triangles().to_vec(), 0).unwrap();
        let mut camera = scene.cameras[0].clone();
        camera.position *= scale;
        let lights = vec![lamp(scale * Vec3::new(-0.02, 0.9, -0.6))];
        let medium = Medium::homogeneous([0.1 / scale; 3], [0.0; 3]).unwrap();
        let stage = Stage::new(scene, medium, lights, vec![camera], SIZE);
        survives("scale", &stage, 10.0 * scale, 0.2 * scale);
    }
}

#[test]
fn no_view_and_views_of_one_pixel() {
    let mut stage = Stage::generated("triangle", (1, 1));
    survives("one pixel", &stage, 10.0, 0.2);
    stage.cameras.clear();
    stage.look();
    survives("no view", &stage, 10.0, 0.2);
    // surfaces right at the eye
    let mut stage = Stage::generated("triangle", SIZE);
    stage.ends[0].fill(0.0);
    let rendered = stage.once(Froxels::new(10.0));
    assert!(rendered.counts.froxels == 0 && rendered.airlight[0].iter().all(|v| *v == Vec3::ZERO));
}
