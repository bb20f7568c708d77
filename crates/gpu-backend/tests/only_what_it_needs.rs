//! A scene pays for what it has: one test for each thing that a frame can do without, on what a frame reports.
#![expect(clippy::unwrap_used, reason = "test code")]

mod common;

use std::sync::Arc;

use common::{Stage, compare, fog, gpu, render, upload};
use froxel_grid::{Counts, FroxelView, Froxels, Near, SharedGrid, Slices, Update};
use glam::Vec3;
use gpu_backend::{
    AirlightForm, CompositeTarget, Faces, Fog, FogDescriptor, Frame, FrameStats, GpuBvh, GpuContext, Hybrid,
    Lamp, LightPicture, Lookup, Pipelines, Sampling, SceneDepth, ShadowCasters, ShadowMap, ShadowVolume,
    Shadows, Technique, Tessellation, View, wgpu,
};
use hybrid_march::Adjacency;
use scene::{
    AirlightModel, Camera, DirectionalLight, Light, LightTexture, Material, Medium, Mesh, Scene, SpotLight,
    TextureFilter, WideBvh,
};
use shadowmap::MapSurface;

const MARCH: Technique = Technique::BruteForce { samples: 20, lookup: Lookup::Nearest };

const EXACT: Technique = Technique::ExactShadowMap { surface: MapSurface::Step };

/// A frame of `stage` with these lamps; view rays end at `ends`.
fn frame<'a>(
    stage: &'a Stage,
    views: &'a [View<'a>],
    lamps: &'a [Lamp<'a>],
    technique: Technique,
) -> Frame<'a> {
    Frame {
        views,
        medium: &stage.medium,
        lamps,
        model: AirlightModel::Sun,
        technique,
        sampling: Sampling::Pixels,
    }
}

fn view<'a>(stage: &'a Stage, ends: &'a [f32], max_distance: f64) -> View<'a> {
    View { camera: &stage.camera, size: stage.size, depth: SceneDepth::Distances(ends), max_distance }
}

/// What a frame with one lamp reports.
fn stats(gpu: &GpuContext, fog: &mut Fog, stage: &Stage, lamp: Lamp<'_>, technique: Technique) -> FrameStats {
    let ends = stage.ends_f32();
    let (views, lamps) = ([view(stage, &ends, f64::INFINITY)], [lamp]);
    fog.prepare(&gpu.device, &gpu.queue, &frame(stage, &views, &lamps, technique)).unwrap();
    fog.stats().clone()
}

/// The same of froxels, with what they counted; `ends` of each of so many views of the same camera.
fn froxel_stats(
    gpu: &GpuContext,
    fog: &mut Fog,
    stage: &Stage,
    bvh: Option<&GpuBvh>,
    ends: &[Vec<f32>],
    froxels: Froxels,
) -> (FrameStats, Counts) {
    let lights = stage.lights();
    let casters = stage.bvh.bounds();
    let shadows = bvh.map(|bvh| Shadows::Rays { bvh, casters });
    let lamps: Vec<_> = lights.iter().map(|light| Lamp { light, shadows, volume: None }).collect();
    let views: Vec<_> = ends.iter().map(|ends| view(stage, ends, froxels.range.into())).collect();
    render(gpu, fog, &frame(stage, &views, &lamps, Technique::Froxels(froxels)));
    (fog.stats().clone(), fog.read_froxel_counts(&gpu.device, &gpu.queue).unwrap())
}

fn has(stats: &FrameStats, pass: &str) -> bool {
    stats.passes.iter().any(|name| name == pass)
}

fn hall() -> (Stage, f32) {
    let stage = Stage::procedural("hall", (48, 32), 1.0);
    let bounds = stage.bvh.bounds();
    let range = bounds.diagonal() + (bounds.center() - stage.camera.position).length();
    (stage, range)
}

fn hierarchy(gpu: &GpuContext, stage: &Stage) -> GpuBvh {
    GpuBvh::upload(&gpu.device, &WideBvh::build(&stage.scene).unwrap()).unwrap()
}

#[test]
fn without_an_occluder_airlight_is_one_closed_form_without_map_or_march() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::procedural("sphere", (16, 12), 1.0);
    let volume = Technique::LightVolume { tessellation: Tessellation::Grid, kept: None };
    // ray ends and one airlight texture
    let least = 16 * 12 * (4 + 16);
    for technique in [EXACT, MARCH, Technique::Hybrid(Hybrid::default()), volume] {
        for light in stage.lights() {
            let mut fog = fog(&gpu);
            let open =
                stats(&gpu, &mut fog, &stage, Lamp { light: &light, shadows: None, volume: None }, technique);
            assert_eq!((open.passes.len(), open.closed_forms), (1, 1), "{technique:?}: {open:?}");
            assert_eq!((open.maps, open.samples, open.rays, open.triangles), (0, 0, 0, 0), "{technique:?}");
            let built = (open.pyramids_built, open.tessellations_built, open.silhouettes_found);
            assert_eq!((built, open.bytes), ((0, 0, 0), least), "{technique:?}");
        }
    }
    // and froxels are lit without a shadow ray
    let (stage, range) = hall();
    let froxels = Froxels { slices: 16, ..Froxels::new(range) };
    let grid = froxels.with_grid(SharedGrid::marked(range / 40.0));
    for froxels in [froxels, grid] {
        let ends = [stage.ends_f32()];
        let (open, counts) = froxel_stats(&gpu, &mut fog(&gpu), &stage, None, &ends, froxels);
        assert_eq!((counts.rays(), open.triangles), (0, 0));
        assert!(
            !open.passes.iter().any(|pass| pass.contains("shadows") || pass.contains("marks")),
            "{open:?}"
        );
    }
}

#[test]
fn achromatic_extinction_is_one_channel_until_the_end() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::procedural("sphere", (16, 12), 1.0);
    let light = stage.lights().remove(0);
    let target = CompositeTarget::picture(wgpu::TextureFormat::Rgba16Float);
    let mut fog =
        Fog::new(&gpu.device, &FogDescriptor { target: Some(target), ..Default::default() }).unwrap();
    let mut fragments = |sigma_s: [f32; 3], sigma_a: [f32; 3]| {
        stage.medium = Medium::homogeneous(sigma_s, sigma_a).unwrap();
        let lamp = Lamp { light: &light, shadows: None, volume: None };
        stats(&gpu, &mut fog, &stage, lamp, EXACT).fragments
    };
    // one transmittance in alpha, beside the airlight; three need a draw of their own
    assert_eq!(fragments([0.1; 3], [0.02; 3]), 16 * 12);
    assert_eq!(fragments([0.1; 3], [0.02, 0.02, 0.03]), 2 * 16 * 12);
    // what scatters with colour may be attenuated without
    assert_eq!(fragments([0.125, 0.25, 0.125], [0.25, 0.125, 0.25]), 16 * 12);
}

#[test]
fn a_second_fog_compiles_nothing_anew() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::procedural("sphere", (16, 12), 1.0);
    let light = stage.lights().remove(0);
    let map = upload(&gpu, &stage.map(&light, 32, MapSurface::Linear).unwrap());
    let casters = ShadowCasters::upload(&gpu.device, &Adjacency::of_scene(&stage.scene).unwrap()).unwrap();
    let volume = ShadowVolume::new(&gpu.device, Arc::new(casters)).unwrap();
    let shadows = Some(Shadows::Map { map: &map, casters: stage.bvh.bounds() });
    let lamp = Lamp { light: &light, shadows, volume: Some(&volume) };
    let light_volume = Technique::LightVolume { tessellation: Tessellation::default(), kept: None };
    let hybrid = Technique::Hybrid(Hybrid::default());
    let target = Some(CompositeTarget::picture(wgpu::TextureFormat::Rgba16Float));
    let drawn = |pipelines: &Pipelines, techniques: &[Technique]| -> Vec<Vec<[f32; 3]>> {
        let descriptor = FogDescriptor { target, pipelines: Some(pipelines), ..Default::default() };
        let mut fog = Fog::new(&gpu.device, &descriptor).unwrap();
        let ends = stage.ends_f32();
        let (views, lamps) = ([view(&stage, &ends, f64::INFINITY)], [lamp]);
        let picture =
            |technique: &Technique| render(&gpu, &mut fog, &frame(&stage, &views, &lamps, *technique));
        techniques.iter().map(picture).collect()
    };
    let shared = Pipelines::new(&gpu.device);
    let few = drawn(&shared, &[EXACT, MARCH]);
    let some = shared.count();
    let all = drawn(&shared, &[EXACT, MARCH, hybrid, light_volume]);
    let most = shared.count();
    assert!(0 < some && some < most && few[..] == all[..2], "{some} {most}");
    let again = drawn(&shared, &[light_volume, hybrid, MARCH, EXACT]);
    assert_eq!(shared.count(), most);
    // and what is shared draws what one's own does
    let own = [light_volume, hybrid, MARCH, EXACT].map(|technique| {
        let own = Pipelines::new(&gpu.device);
        drawn(&own, &[technique]).remove(0)
    });
    assert!(again[..] == own[..] && again.iter().rev().eq(&all));
}

#[test]
fn without_a_textured_light_there_is_no_texture() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::procedural("sphere", (16, 12), 1.0);
    let plain = stage.lights().remove(1);
    let Light::Spot(spot) = &plain else { panic!("the second light is a spot") };
    let picture = LightTexture::new(8, 4, vec![[0.5; 3]; 32], TextureFilter::Linear).unwrap();
    let textured = Light::Spot(SpotLight { texture: Some(Arc::new(picture)), ..spot.clone() });
    let map = upload(&gpu, &stage.map(&plain, 32, MapSurface::Step).unwrap());
    let casters = ShadowCasters::upload(&gpu.device, &Adjacency::of_scene(&stage.scene).unwrap()).unwrap();
    let volume = ShadowVolume::new(&gpu.device, Arc::new(casters)).unwrap();
    let shadows = Some(Shadows::Map { map: &map, casters: stage.bvh.bounds() });
    let hybrid =
        |picture| Technique::Hybrid(Hybrid { picture, form: AirlightForm::Interval, ..Hybrid::default() });
    let mips = hybrid(LightPicture::Mips { blur: 0.0 });
    for technique in [EXACT, MARCH, hybrid(LightPicture::Point), mips] {
        let mut fog = fog(&gpu);
        let mut bytes = |light| {
            let stats =
                stats(&gpu, &mut fog, &stage, Lamp { light, shadows, volume: Some(&volume) }, technique);
            // a light's pyramid, and its silhouette, are made once: only the picture differs between the frames
            stats.bytes
        };
        bytes(&plain);
        let (without, with, again) = (bytes(&plain), bytes(&textured), bytes(&plain));
        assert_eq!(again, without, "{technique:?}");
        // 16 bytes a texel, or for mips a third more of 8 or 16
        assert!(with >= without + 8 * 32, "{technique:?}: {without} and {with}");
        let exactly = if technique == mips { with } else { without + 16 * 32 };
        assert_eq!(with, exactly, "{technique:?}");
    }
    // of froxels, whose pictures are in one buffer
    let (stage, range) = hall();
    let froxels = Froxels { slices: 8, ..Froxels::new(range) };
    let ends = [stage.ends_f32()];
    let mut fog = fog(&gpu);
    let mut bytes = |light: &Light| {
        let views = [view(&stage, &ends[0], range.into())];
        let lamps = [Lamp { light, shadows: None, volume: None }];
        fog.prepare(&gpu.device, &gpu.queue, &frame(&stage, &views, &lamps, Technique::Froxels(froxels)))
            .unwrap();
        fog.stats().bytes
    };
    assert_eq!([bytes(&plain), bytes(&textured) - 16 * 32, bytes(&plain)], [bytes(&plain); 3]);
}

#[test]
fn one_viewer_has_no_shared_grid() {
    let Some(gpu) = gpu() else { return };
    let (stage, range) = hall();
    let bvh = hierarchy(&gpu, &stage);
    let reference = Froxels { slices: 32, ..Froxels::new(range) };
    let near = Near::Frustum { side: 2, slices: 10 };
    let shared = reference.with_grid(SharedGrid { near, ..SharedGrid::marked(range / 60.0) });
    let (one, two) = (vec![stage.ends_f32()], vec![stage.ends_f32(); 2]);
    let mut fog = fog(&gpu);
    let (alone, counts) = froxel_stats(&gpu, &mut fog, &stage, Some(&bvh), &one, reference);
    assert!(counts.near_rays > 0 && (counts.grid_rays, counts.voxels) == (0, 0), "{counts:?}");
    assert!(!has(&alone, "froxels: marks") && !has(&alone, "froxels: grid shadows"), "{:?}", alone.passes);
    let (grid, counts) = froxel_stats(&gpu, &mut fog, &stage, Some(&bvh), &two, shared);
    assert!(counts.grid_rays > 0 && has(&grid, "froxels: marks") && has(&grid, "froxels: grid shadows"));
    // it goes with the second viewer, and so does its memory
    let (after, counts) = froxel_stats(&gpu, &mut fog, &stage, Some(&bvh), &one, reference);
    assert_eq!((after.bytes, counts.grid_rays), (alone.bytes, 0));
    assert_eq!(after.passes, alone.passes);
    assert!(grid.bytes > alone.bytes);
    // nor is there one where a viewer's own shadows reach to the last slice
    let near = Near::Frustum { side: 1, slices: 32 };
    let own = reference.with_grid(SharedGrid { near, ..SharedGrid::marked(range / 60.0) });
    let (own, counts) = froxel_stats(&gpu, &mut fog, &stage, Some(&bvh), &one, own);
    assert_eq!((own.bytes, own.passes, counts.grid_rays), (alone.bytes, alone.passes, 0));
}

/// A rectangle at height 3 m.
fn roof(x: [f32; 2], z: [f32; 2]) -> [[Vec3; 3]; 2] {
    let corner = |x, z| Vec3::new(x, 3.0, z);
    let [a, b, c, d] = [corner(x[0], z[0]), corner(x[1], z[0]), corner(x[1], z[1]), corner(x[0], z[1])];
    [[a, b, c], [a, c, d]]
}

/// Two roofs under the sun: a narrow one across all view rays, and one on the left behind it. A march in the shadow
/// volume of the second alone sees nothing of the first, because it takes no step there; one of the whole ray does.
#[test]
fn a_pixel_outside_every_shadow_volume_is_not_marched() {
    let Some(gpu) = gpu() else { return };
    let (across, left) = (roof([-4.0, 4.0], [1.0, 1.2]), roof([-4.0, -0.4], [-2.0, -1.0]));
    let corners: Vec<[Vec3; 3]> = [across, left].concat();
    let triangles = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Mesh::new(corners.concat(), triangles, 0).unwrap();
    let scene = Scene { meshes: vec![mesh], materials: vec![Material::default()], ..Scene::default() };
    let camera = Camera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::new(0.0, 0.5, 0.0), Vec3::Y, 0.5).unwrap();
    let mut stage = Stage::new("roofs", scene, camera, (24, 12), 1.0);
    stage.ends.fill(10.0);
    let ends = stage.ends_f32();
    let sun = Light::Directional(DirectionalLight::new(Vec3::NEG_Y, Vec3::ONE).unwrap());
    let map: ShadowMap = upload(&gpu, &stage.map(&sun, 256, MapSurface::Step).unwrap());
    let casters = ShadowCasters::upload(&gpu.device, &Adjacency::new(left).unwrap()).unwrap();
    let volume = ShadowVolume::new(&gpu.device, Arc::new(casters)).unwrap();
    let mut fog = fog(&gpu);
    let mut picture = |shadowed: bool, technique| {
        let shadows = shadowed.then_some(Shadows::Map { map: &map, casters: stage.bvh.bounds() });
        let views = [view(&stage, &ends, f64::INFINITY)];
        let lamps = [Lamp { light: &sun, shadows, volume: Some(&volume) }];
        render(&gpu, &mut fog, &frame(&stage, &views, &lamps, technique))
    };
    let open = picture(false, EXACT);
    let marched = picture(true, Technique::BruteForce { samples: 400, lookup: Lookup::Nearest });
    let hybrid = Hybrid { samples: 400, faces: Faces::Pixels, ..Hybrid::default() };
    let between = picture(true, Technique::Hybrid(hybrid));
    let column = |picture: &[[f32; 3]], x: usize| -> Vec<[f32; 3]> {
        picture.iter().skip(x).step_by(24).copied().collect()
    };
    // far right of the volume
    for x in 16..24 {
        let (open, between) = (column(&open, x), column(&between, x));
        let (error, _) = compare(&between, &open);
        assert!(error < 1e-5, "column {x} differs from no shadow by {error}");
        let (error, _) = compare(&column(&marched, x), &open);
        assert!(error > 0.01, "column {x} is to see the roof across it where it is marched: {error}");
    }
    // and in it
    let (error, _) = compare(&column(&between, 2), &column(&open, 2));
    assert!(error > 0.03, "the roof on the left is not seen: {error}");
}

#[test]
fn a_froxel_behind_the_depth_buffer_is_not_lit() {
    let Some(gpu) = gpu() else { return };
    let (stage, range) = hall();
    let bvh = hierarchy(&gpu, &stage);
    let froxels = Froxels { slices: 24, ..Froxels::new(range) };
    let slices = Slices::new(&froxels);
    let (columns, rows) = FroxelView::new(&stage.camera, stage.size, froxels.tile).tiles();
    let tiles = u64::from(columns) * u64::from(rows);
    let mut fog = fog(&gpu);
    let mut rays = Vec::new();
    for slice in [0, 5, 11, 23] {
        // in the middle of the slice
        let end = slices.distance(slice, 0.5);
        let ends = [vec![end; stage.ends.len()]];
        let (_, counts) = froxel_stats(&gpu, &mut fog, &stage, Some(&bvh), &ends, froxels);
        assert_eq!(counts.froxels, tiles * (u64::from(slice) + 1), "{counts:?}");
        assert!(counts.near_rays <= counts.froxels * stage.lights().len() as u64);
        rays.push(counts.near_rays);
    }
    assert!(rays.windows(2).all(|pair| pair[0] < pair[1]), "{rays:?}");
}

#[test]
fn a_voxel_that_nothing_reads_is_not_traced() {
    let Some(gpu) = gpu() else { return };
    let (stage, range) = hall();
    let bvh = hierarchy(&gpu, &stage);
    let near = Near::Frustum { side: 2, slices: 8 };
    let froxels = Froxels { slices: 24, ..Froxels::new(range) };
    let marked = SharedGrid { near, ..SharedGrid::marked(range / 60.0) };
    let in_sight = SharedGrid { update: Update::InFrustums { alternate: false }, ..marked };
    let slices = Slices::new(&froxels);
    let counts = |slice: u32, grid| {
        let ends = [vec![slices.distance(slice, 0.5); stage.ends.len()]];
        froxel_stats(&gpu, &mut fog(&gpu), &stage, Some(&bvh), &ends, froxels.with_grid(grid)).1
    };
    // all froxels have shadows of their own: no voxel is read
    let none = counts(7, marked);
    assert_eq!((none.voxels, none.grid_rays), (0, 0), "{none:?}");
    assert!(none.near_rays > 0);
    // the paper's update traces what is in sight all the same
    assert!(counts(7, in_sight).grid_rays > 0);
    // as many voxels as there are pairs of a froxel behind that and a light, at most
    let (some, all) = (counts(8, marked), counts(23, marked));
    let pairs = |froxels: u64| (froxels - none.froxels) * stage.lights().len() as u64;
    assert!(some.voxels > 0 && some.voxels <= pairs(some.froxels), "{some:?}");
    assert!(some.voxels < all.voxels && all.voxels <= pairs(all.froxels), "{all:?}");
    assert!(all.grid_rays < counts(23, in_sight).grid_rays);
}
