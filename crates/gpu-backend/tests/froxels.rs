//! Froxels on the GPU: against the exact picture as they shrink, and against the CPU, mask by mask.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests; figures beside the bars")]

mod common;

use common::{Stage, compare, fog, gpu, gpus};
use froxel_grid::{
    Counts, FroxelFog, FroxelView, Froxels, GridMemory, GridReads, Lattice, MaskWidth, Near, Occluders,
    SharedGrid, Temporal, Update,
};
use glam::{Quat, UVec3, Vec3};
use gpu_backend::{
    Fog, Frame, GpuBvh, GpuContext, Lamp, PrepareError, Sampling, SceneDepth, Shadows, Technique, View,
};
use scene::{
    Aabb, AirlightModel, Bvh, Camera, Density, DensityGrid, DirectionalLight, Light, LightId, Material,
    Medium, Mesh, PointLight, Scene, Visibility, WideBvh,
};

/// Shadow rays in the steps in which the GPU takes them.
struct WideVisibility<'a> {
    bvh: &'a WideBvh,
    lights: &'a [Light],
}

impl Visibility for WideVisibility<'_> {
    fn visibility(&self, point: Vec3, light: LightId) -> f32 {
        let (way, far) = match &self.lights[light.0] {
            Light::Point(light) => (light.position - point, 1.0),
            Light::Spot(light) => (light.position - point, 1.0),
            Light::Directional(light) => (-light.direction, 1e30),
        };
        f32::from(u8::from(!self.bvh.blocked(point, way, far)))
    }
}

/// A scene with several viewers and lights.
struct Show {
    stage: Stage,
    bvh: WideBvh,
    lights: Vec<Light>,
    cameras: Vec<Camera>,
    ends: Vec<Vec<f32>>,
    range: f32,
}

/// A camera turned about its up axis, and moved along its right one.
fn turned(camera: &Camera, angle: f32, aside: f32) -> Camera {
    let turn = Quat::from_axis_angle(camera.up, angle);
    Camera {
        position: camera.position + aside * camera.right,
        right: turn * camera.right,
        forward: turn * camera.forward,
        ..camera.clone()
    }
}

fn ends_of(bvh: &Bvh, camera: &Camera, size: (u32, u32)) -> Vec<f32> {
    let pixels = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
    let end = |(x, y)| {
        let hit = bvh.closest_hit(&camera.pixel_ray(x, y, size), f64::INFINITY);
        hit.map_or(f32::INFINITY, |hit| hit.distance as f32)
    };
    pixels.map(end).collect()
}

impl Show {
    fn new(name: &str, size: (u32, u32), views: u32) -> Self {
        let stage = Stage::procedural(name, size, 0.5);
        let (bounds, lights) = (stage.bvh.bounds(), stage.lights());
        let range = bounds.diagonal() + (bounds.center() - stage.camera.position).length();
        let cameras: Vec<Camera> =
            (0..views).map(|i| turned(&stage.camera, 0.2 * i as f32, 0.01 * i as f32 * range)).collect();
        let ends = cameras.iter().map(|camera| ends_of(&stage.bvh, camera, size)).collect();
        let bvh = WideBvh::build(&stage.scene).unwrap();
        Self { stage, bvh, lights, cameras, ends, range }
    }

    fn on_gpu(&self, gpu: &GpuContext, fog: &mut Fog, froxels: Froxels) -> (Vec<Vec<[f32; 3]>>, Counts) {
        self.traced_in(&self.uploaded(gpu), gpu, fog, froxels)
    }

    fn uploaded(&self, gpu: &GpuContext) -> GpuBvh {
        GpuBvh::upload(&gpu.device, &self.bvh).unwrap()
    }

    fn traced_in(
        &self,
        bvh: &GpuBvh,
        gpu: &GpuContext,
        fog: &mut Fog,
        froxels: Froxels,
    ) -> (Vec<Vec<[f32; 3]>>, Counts) {
        let casters = self.stage.bvh.bounds();
        let shadows = (!casters.is_empty()).then_some(Shadows::Rays { bvh, casters });
        let lamps: Vec<Lamp<'_>> =
            self.lights.iter().map(|light| Lamp { light, shadows, volume: None }).collect();
        let views: Vec<View<'_>> = (self.cameras.iter().zip(&self.ends))
            .map(|(camera, ends)| View {
                camera,
                size: self.stage.size,
                depth: SceneDepth::Distances(ends),
                max_distance: f64::from(froxels.range),
            })
            .collect();
        let frame = Frame {
            views: &views,
            medium: &self.stage.medium,
            lamps: &lamps,
            model: AirlightModel::Sun,
            technique: Technique::Froxels(froxels),
            sampling: Sampling::Pixels,
        };
        common::render(gpu, fog, &frame);
        let read = |view| fog.read_airlight(&gpu.device, &gpu.queue, view).unwrap();
        let pictures = (0..views.len()).map(read).collect();
        (pictures, fog.read_froxel_counts(&gpu.device, &gpu.queue).unwrap_or_default())
    }

    fn on_cpu(&self, fog: &mut FroxelFog) -> (Vec<Vec<[f32; 3]>>, Counts) {
        let visibility = WideVisibility { bvh: &self.bvh, lights: &self.lights };
        let bounds = self.stage.bvh.bounds();
        let views: Vec<froxel_grid::View<'_>> = (self.cameras.iter().zip(&self.ends))
            .map(|(camera, ends)| froxel_grid::View { camera, size: self.stage.size, ends })
            .collect();
        let frame = froxel_grid::Frame {
            views: &views,
            medium: &self.stage.medium,
            lights: &self.lights,
            model: AirlightModel::Sun,
            occluders: Some(Occluders { visibility: &visibility, bounds }),
        };
        let rendered = fog.render(&frame).unwrap();
        let arrays = |picture: Vec<Vec3>| picture.into_iter().map(|v| v.to_array()).collect();
        (rendered.airlight.into_iter().map(arrays).collect(), rendered.counts)
    }

    fn exact(&self) -> Vec<[f32; 3]> {
        let range = f64::from(self.range);
        let settings = ground_truth::Settings { max_distance: range, ..Default::default() };
        let Stage { bvh, medium, .. } = &self.stage;
        let reference = ground_truth::Reference::new(&[], bvh, medium, &self.lights, settings).unwrap();
        self.stage.by_ray(|ray, end| reference.airlight(ray, end.min(range)).as_vec3().to_array())
    }
}

/// Masks that differ, of all that both know.
#[derive(Debug, Default)]
struct Masks {
    known: u64,
    different: u64,
}

impl Masks {
    fn add(&mut self, cpu: froxel_grid::Mask, gpu: u32) {
        self.known += u64::from(cpu.known.count_ones());
        self.different += u64::from(((cpu.lit ^ gpu) & cpu.known).count_ones());
    }
}

/// A mask among words: `index` masks from the beginning of a row whose first word is given.
fn mask_at(words: &[u32], first: usize, index: usize, bits: usize) -> u32 {
    let bit = index * bits;
    let word = words[first + bit / 32] >> (bit % 32);
    if bits == 32 { word } else { word & ((1 << bits) - 1) }
}

fn near_masks(show: &Show, gpu: &GpuContext, fog: &Fog, cpu: &FroxelFog, froxels: &Froxels) -> Masks {
    let mut masks = Masks::default();
    let (side, slices) = froxels.near_volume();
    if slices == 0 {
        return masks;
    }
    let words = fog.read_near_masks(&gpu.device, &gpu.queue).unwrap();
    let width = froxels.grid().map_or(MaskWidth::of(show.lights.len()), |grid| grid.lights);
    let bits = width.bits() as usize;
    let mut first = 0;
    for (index, camera) in show.cameras.iter().enumerate() {
        let (columns, rows) = FroxelView::new(camera, show.stage.size, froxels.tile).cells(side);
        let mut known = cpu.near_masks(index).iter();
        let cells = (columns * rows) as usize;
        for slice in 0..slices as usize {
            for cell in 0..cells {
                let word = words[first + slice * bits / 32 * cells + cell];
                masks.add(*known.next().unwrap(), mask_at(&[word], 0, slice % (32 / bits), bits));
            }
        }
        first += cells * (slices as usize * bits).div_ceil(32);
    }
    masks
}

fn grid_masks(gpu: &GpuContext, fog: &Fog, cpu: &FroxelFog, grid: &SharedGrid) -> Masks {
    let mut masks = Masks::default();
    let (words, keys) = fog.read_shadow_grid(&gpu.device, &gpu.queue).unwrap();
    let bits = grid.lights.bits() as usize;
    if matches!(grid.memory, GridMemory::Dense) {
        let Lattice { dims, .. } = cpu.lattices()[0];
        let row = (dims.x as usize * bits).div_ceil(32);
        for (index, (z, y)) in (0..dims.z).flat_map(|z| (0..dims.y).map(move |y| (z, y))).enumerate() {
            for x in 0..dims.x {
                let known = cpu.voxel(0, UVec3::new(x, y, z)).unwrap();
                masks.add(known, mask_at(&words, index * row, x as usize, bits));
            }
        }
        return masks;
    }
    for (place, key) in keys[..keys.len() / 2].iter().enumerate().filter(|(_, key)| **key != 0) {
        let code = key - 1;
        let brick = UVec3::new(code & 1023, code >> 10 & 1023, code >> 20 & 1023);
        for inside in 0..512_u32 {
            let voxel = 8 * brick + UVec3::new(inside & 7, inside >> 3 & 7, inside >> 6);
            if let Some(known) = cpu.voxel((code >> 30) as usize, voxel) {
                masks.add(known, mask_at(&words, place * 16 * bits, inside as usize, bits));
            }
        }
    }
    masks
}

/// Compares `frames` frames on both, the cameras turned a little from one to the next; how many masks were compared.
fn check(gpu: &GpuContext, show: &mut Show, froxels: Froxels, frames: u32, label: &str) {
    let mut on_gpu = fog(gpu);
    let bvh = show.uploaded(gpu);
    let mut on_cpu = FroxelFog::new(froxels).unwrap();
    for frame in 0..frames {
        let (gpu_pictures, gpu_counts) = show.traced_in(&bvh, gpu, &mut on_gpu, froxels);
        let (cpu_pictures, cpu_counts) = show.on_cpu(&mut on_cpu);
        let near = near_masks(show, gpu, &on_gpu, &on_cpu, &froxels);
        let grid = froxels.grid().filter(|_| !on_cpu.lattices().is_empty());
        let grid = grid.map(|grid| grid_masks(gpu, &on_gpu, &on_cpu, grid)).unwrap_or_default();
        let errors: Vec<f64> = gpu_pictures.iter().zip(&cpu_pictures).map(|(a, b)| compare(a, b).0).collect();
        println!(
            "{} {label} {frame}: {errors:?} near {near:?} grid {grid:?}\n  {gpu_counts:?}\n  {cpu_counts:?}",
            show.stage.name
        );
        let most = (near.known + grid.known) as f64 * 1e-5;
        assert!(near.known + grid.known > 1000);
        assert!((near.different + grid.different) as f64 <= most.max(1.0), "{near:?} {grid:?}");
        assert!(errors.iter().all(|error| *error <= 1e-3), "{errors:?}");
        let close = |a: u64, b: u64| a.abs_diff(b) as f64 <= 1e-4 * b as f64 + 2.0;
        assert!(close(gpu_counts.near_rays, cpu_counts.near_rays));
        assert!(close(gpu_counts.grid_rays, cpu_counts.grid_rays));
        assert!(close(gpu_counts.froxels, cpu_counts.froxels) && close(gpu_counts.voxels, cpu_counts.voxels));
        assert!(close(gpu_counts.dropped, cpu_counts.dropped));
        assert_eq!((gpu_counts.bricks, gpu_counts.not_finite), (cpu_counts.bricks, 0));
        for camera in &mut show.cameras {
            *camera = turned(camera, 0.01, 0.001 * show.range);
        }
        let size = show.stage.size;
        show.ends = show.cameras.iter().map(|camera| ends_of(&show.stage.bvh, camera, size)).collect();
    }
}

#[test]
fn smaller_froxels_come_nearer_to_the_exact_picture() {
    let Some(gpu) = gpu() else { return };
    let mut show = Show::new("hall", (128, 128), 1);
    for light in show.lights.clone() {
        show.lights = vec![light];
        let truth = show.exact();
        let mut last = f64::INFINITY;
        for (tile, slices) in [(16, 32), (8, 64), (4, 128), (2, 256)] {
            let froxels = Froxels { tile, slices, ..Froxels::new(show.range) };
            let (pictures, counts) = show.on_gpu(&gpu, &mut fog(&gpu), froxels);
            let (error, p99) = compare(&pictures[0], &truth);
            println!("{tile} {slices}: {error:.2e} {p99:.2e} {counts:?}");
            assert!(error < last);
            last = error;
        }
    }
}

#[test]
fn the_reference_is_that_of_the_cpu() {
    for gpu in gpus() {
        for name in ["hall", "fence"] {
            let mut show = Show::new(name, (100, 60), 2);
            let froxels = Froxels { slices: 50, ..Froxels::new(show.range) };
            check(&gpu, &mut show, froxels, 1, "reference");
        }
    }
}

#[test]
fn the_shared_grid_is_that_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let mut show = Show::new("hall", (100, 60), 3);
    let size = show.range / 60.0;
    let (paper, marked) = (SharedGrid::paper(size), SharedGrid::marked(size));
    let bricks = GridMemory::Bricks { most: 1 << 13 };
    let near = Near::Frustum { side: 2, slices: 16 };
    let fine = Near::FineGrid { ratio: 2, slices: 16 };
    let grids = [
        ("paper", SharedGrid { near, ..paper }),
        ("marked", SharedGrid { near, ..marked }),
        ("alternating", SharedGrid { near, update: Update::Marked { alternate: true }, ..marked }),
        ("trilinear", SharedGrid { near, reads: GridReads::Trilinear, ..marked }),
        ("grid alone", SharedGrid { near: Near::Grid, ..marked }),
        ("bricks", SharedGrid { near, memory: bricks, ..marked }),
        ("fine grid", SharedGrid { near: fine, memory: bricks, ..marked }),
        ("wide masks", SharedGrid { near, lights: MaskWidth::Sixteen, memory: bricks, ..marked }),
        ("widest masks", SharedGrid { near, lights: MaskWidth::ThirtyTwo, ..marked }),
    ];
    for (label, grid) in grids {
        let froxels = Froxels { slices: 50, ..Froxels::new(show.range) }.with_grid(grid);
        check(&gpu, &mut show, froxels, 3, label);
    }
}

#[test]
fn more_lights_than_bits_are_the_strongest() {
    let Some(gpu) = gpu() else { return };
    let mut show = Show::new("hall", (64, 48), 2);
    let bounds = show.stage.bvh.bounds();
    for i in 0..9 {
        let share = Vec3::new(0.1 + 0.09 * i as f32, 0.5, 0.3 + 0.04 * i as f32);
        let position = bounds.min + share * (bounds.max - bounds.min);
        show.lights.push(Light::Point(PointLight::new(position, Vec3::splat(1.0 + i as f32)).unwrap()));
    }
    let froxels = Froxels { slices: 40, ..Froxels::new(show.range) };
    check(&gpu, &mut show, froxels, 1, "twelve lights, reference");
    let size = show.range / 50.0;
    let grid = SharedGrid { near: Near::Frustum { side: 2, slices: 13 }, ..SharedGrid::marked(size) };
    check(&gpu, &mut show, froxels.with_grid(grid), 1, "twelve lights in eight bits");
    let (_, counts) = show.on_gpu(&gpu, &mut fog(&gpu), froxels.with_grid(grid));
    assert!(counts.dropped > 0);
    let grid = SharedGrid { lights: MaskWidth::Sixteen, ..grid };
    let (_, counts) = show.on_gpu(&gpu, &mut fog(&gpu), froxels.with_grid(grid));
    assert_eq!(counts.dropped, 0);
}

#[test]
fn any_medium_is_that_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let mut show = Show::new("hall", (64, 48), 1);
    let bounds = show.stage.bvh.bounds();
    let plain = show.stage.medium.clone();
    let rgb = Medium::homogeneous([0.02, 0.04, 0.06], [0.01, 0.0, 0.03]).unwrap();
    let (center, extent) = (bounds.center(), bounds.max - bounds.min);
    let inner = Aabb { min: center - 0.4 * extent, max: center + 0.3 * extent };
    let values = (0..4 * 3 * 5).map(|i| (i * 7 % 11) as f32 / 5.0).collect();
    let cells = DensityGrid::new([4, 3, 5], inner, values).unwrap();
    let low = bounds.min.y + 0.2 * extent.y;
    let media = [
        ("rgb", Medium { phase: media_math::PhaseFunction::henyey_greenstein(0.6).unwrap(), ..rgb.clone() }),
        ("bounded", Medium { bounds: Some(inner), ..plain.clone() }),
        ("height", Medium { density: Some(Density::height(low, 0.3 * extent.y).unwrap()), ..plain.clone() }),
        ("cells", Medium { density: Some(Density::Grid(cells)), emission: [0.1, 0.2, 0.3], ..rgb }),
    ];
    for (label, medium) in media {
        show.stage.medium = medium;
        let froxels = Froxels { slices: 40, ..Froxels::new(show.range) };
        check(&gpu, &mut show, froxels, 1, label);
    }
}

#[test]
fn a_history_is_that_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let mut show = Show::new("hall", (64, 48), 2);
    let temporal = Some(Temporal { frames: 4, keeps_changed: false });
    let froxels = Froxels { slices: 40, temporal, ..Froxels::new(show.range) };
    check(&gpu, &mut show, froxels, 6, "history");
}

/// A square of 20 m in the middle of a box of 100 m, whose corners two small triangles hold.
fn wide_scene() -> Scene {
    let corner = |p: Vec3| [p, p.lerp(Vec3::splat(50.0), 0.01), p.lerp(Vec3::new(50.0, p.y, 50.0), 0.01)];
    let square = |x: f32, z: f32| Vec3::new(50.0 + 10.0 * x, 60.0, 50.0 + 10.0 * z);
    let mut positions: Vec<Vec3> = [Vec3::ZERO, Vec3::splat(100.0)].map(corner).concat();
    positions.extend([square(-1.0, -1.0), square(1.0, -1.0), square(1.0, 1.0)]);
    positions.extend([square(-1.0, -1.0), square(1.0, 1.0), square(-1.0, 1.0)]);
    let triangles = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Scene {
        meshes: vec![Mesh::new(positions, triangles, 0).unwrap()],
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

#[test]
fn two_hundred_million_voxels_fit() {
    let Some(gpu) = common::core_gpu() else { return };
    let camera = Camera::look_at(Vec3::new(50.0, 45.0, 99.0), Vec3::splat(50.0), Vec3::Y, 0.9).unwrap();
    let stage = Stage::new("wide", wide_scene(), camera.clone(), (64, 48), 0.5);
    let bvh = WideBvh::build(&stage.scene).unwrap();
    let ends = vec![ends_of(&stage.bvh, &camera, stage.size)];
    let sun = DirectionalLight::new(Vec3::new(0.1, -1.0, 0.05), Vec3::ONE).unwrap();
    let lights = vec![Light::Directional(sun)];
    let show = Show { stage, bvh, lights, cameras: vec![camera], ends, range: 100.0 };
    let froxels = Froxels { slices: 64, ..Froxels::new(show.range) };
    let size = 1.0 / 6.0;
    let grid = SharedGrid { near: Near::Grid, ..SharedGrid::marked(size) };
    let lattice = grid.lattice(&show.stage.bvh.bounds()).unwrap();
    assert!(lattice.count() > 216_000_000);
    let mut dense = fog(&gpu);
    let (a, dense_counts) = show.on_gpu(&gpu, &mut dense, froxels.with_grid(grid));
    let sparse = SharedGrid { memory: GridMemory::Bricks { most: 1 << 14 }, ..grid };
    let mut bricks = fog(&gpu);
    let (b, sparse_counts) = show.on_gpu(&gpu, &mut bricks, froxels.with_grid(sparse));
    assert_eq!((a, dense_counts.rays()), (b, sparse_counts.rays()));
    assert_eq!(sparse_counts.missed, 0);
    let (dense, bricks) = (dense.stats().bytes, bricks.stats().bytes);
    println!("{dense} bytes dense, {bricks} in bricks, of which {} are used", sparse_counts.bricks);
    assert!(dense > 216_000_000 && 3 * bricks < dense);
    // no voxel smaller than that fits, and bricks do
    let finer = SharedGrid { voxel_size: 0.14, ..grid };
    let refused = attempt(&show, &gpu, froxels.with_grid(finer));
    assert!(
        matches!(refused, Err(PrepareError::TooLarge { what: "the shared shadow grid", .. })),
        "{refused:?}"
    );
    let finer = SharedGrid { voxel_size: 0.14, ..sparse };
    assert!(attempt(&show, &gpu, froxels.with_grid(finer)).is_ok());
}

fn attempt(show: &Show, gpu: &GpuContext, froxels: Froxels) -> Result<(), PrepareError> {
    let bvh = show.uploaded(gpu);
    let shadows = Some(Shadows::Rays { bvh: &bvh, casters: show.stage.bvh.bounds() });
    let lamps: Vec<_> = show.lights.iter().map(|light| Lamp { light, shadows, volume: None }).collect();
    let view = |camera| View {
        camera,
        size: show.stage.size,
        depth: SceneDepth::Nothing,
        max_distance: f64::INFINITY,
    };
    let views: Vec<View<'_>> = show.cameras.iter().map(view).collect();
    let frame = Frame {
        views: &views,
        medium: &show.stage.medium,
        lamps: &lamps,
        model: AirlightModel::Sun,
        technique: Technique::Froxels(froxels),
        sampling: Sampling::Pixels,
    };
    fog(gpu).prepare(&gpu.device, &gpu.queue, &frame)
}

#[test]
fn what_does_not_fit_is_named() {
    let Some(gpu) = gpu() else { return };
    let mut show = Show::new("slats", (8, 8), 1);
    let froxels = Froxels { slices: 4, ..Froxels::new(show.range) };
    let said = |show: &Show, froxels: Froxels| attempt(show, &gpu, froxels).unwrap_err().to_string();
    assert!(said(&show, Froxels { range: f32::INFINITY, ..froxels }).contains("range"));
    assert!(said(&show, Froxels { tile: 0, ..froxels }).contains("tile"));
    assert!(
        said(&show, froxels.with_grid(SharedGrid { near: Near::Grid, ..SharedGrid::paper(1e-9) }))
            .contains("larger voxels")
    );
    let bricks =
        SharedGrid { memory: GridMemory::Bricks { most: 64 }, near: Near::Grid, ..SharedGrid::marked(1e-4) };
    assert!(said(&show, froxels.with_grid(bricks)).contains("bricks along an axis"));
    show.lights = vec![show.lights[0].clone(); 33];
    assert!(said(&show, froxels).contains("at most 32 lights"));
    show.lights.truncate(1);
    show.cameras = vec![show.cameras[0].clone(); 257];
    assert!(said(&show, froxels).contains("256"));
}

#[test]
fn a_scene_pays_for_what_it_has() {
    let Some(gpu) = gpu() else { return };
    let mut show = Show::new("slats", (32, 32), 2);
    let froxels = Froxels { slices: 16, ..Froxels::new(show.range) };
    let near = Near::Frustum { side: 2, slices: 5 };
    let grid = froxels.with_grid(SharedGrid { near, ..SharedGrid::marked(show.range / 50.0) });
    let passes = |show: &Show, froxels: Froxels| {
        let mut fog = fog(&gpu);
        let (pictures, counts) = show.on_gpu(&gpu, &mut fog, froxels);
        let mut names = fog.stats().passes.clone();
        names.dedup();
        (names.into_iter().map(|name| name.replace("froxels: ", "")).collect::<Vec<_>>(), pictures, counts)
    };
    let has = |names: &[String], name: &str| names.iter().any(|n| n == name);
    let (names, _, counts) = passes(&show, grid);
    assert!(
        ["near shadows", "marks", "grid shadows", "lighting"].iter().all(|name| has(&names, name)),
        "{names:?}"
    );
    assert!(counts.near_rays > 0 && counts.grid_rays > 0);
    let (names, _, counts) = passes(&show, froxels);
    assert!(
        has(&names, "near shadows") && !has(&names, "marks") && !has(&names, "grid shadows"),
        "{names:?}"
    );
    assert_eq!(counts.grid_rays, 0);
    // nothing scatters, or nothing shines: no pass at all
    let medium = std::mem::replace(&mut show.stage.medium, Medium::homogeneous([0.0; 3], [0.1; 3]).unwrap());
    let (names, pictures, _) = passes(&show, grid);
    assert!(names.is_empty() && pictures.iter().flatten().all(|pixel| *pixel == [0.0; 3]), "{names:?}");
    show.stage.medium = medium;
    show.lights.clear();
    let (names, pictures, _) = passes(&show, grid);
    assert!(names.is_empty() && pictures.iter().flatten().all(|pixel| *pixel == [0.0; 3]), "{names:?}");
}
