//! The reference scenes `data/s*.json`, whose noise-free pictures beside them were computed analytically.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use media_math::PhaseFunction;
use scene::{
    Aabb, Camera, DirectionalLight, Light, LightTexture, Medium, Mesh, PointLight, SpotLight, TextureFilter,
};
use serde::Deserialize;

use crate::cases;
use crate::picture::{self, Pixels};
use crate::tessellate;
use crate::view::View;

/// A reference scene and its picture.
#[derive(Debug)]
pub struct Gold {
    /// The scene, with its solids as triangles.
    pub view: View,
    /// The picture of the solids.
    pub pixels: Pixels,
    /// Pixels (by index) on silhouettes, which the tessellation may move.
    pub fragile: Vec<usize>,
}

#[derive(Deserialize)]
struct File {
    camera: CameraFile,
    medium: MediumFile,
    lights: Vec<LightFile>,
    primitives: Vec<Primitive>,
    stats: Stats,
}

#[derive(Deserialize)]
struct CameraFile {
    origin: Vec3File,
    look_at: Vec3File,
    up: Vec3File,
    vfov_deg: f32,
}

#[derive(Deserialize)]
struct MediumFile {
    sigma_s: [f32; 3],
    sigma_a: [f32; 3],
    phase: cases::Phase,
    bounds: Option<Bounds>,
}

#[derive(Deserialize)]
struct Bounds {
    min: Vec3File,
    max: Vec3File,
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum LightFile {
    Point {
        position: Vec3File,
        intensity: Vec3File,
    },
    Directional {
        direction: Vec3File,
        irradiance: Vec3File,
    },
    Spot {
        position: Vec3File,
        look_at: Vec3File,
        up: Vec3File,
        cutoff_deg: f32,
        beam_deg: f32,
        intensity: Vec3File,
        texture: Option<TextureFile>,
    },
}

#[derive(Deserialize)]
struct TextureFile {
    texels: Vec<Vec<[f32; 3]>>,
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Primitive {
    Sphere { center: Vec3File, radius: f64 },
    Plane { point: Vec3File, normal: Vec3File },
    Box { center: Vec3File, half: Vec3File, axes: [Vec3File; 3] },
    Cylinder { p0: Vec3File, p1: Vec3File, radius: f64 },
}

#[derive(Deserialize)]
struct Stats {
    fragile_pixels: Vec<[usize; 2]>,
}

/// Three numbers; kept in f64 until the scene's f32 is wanted.
#[derive(Deserialize, Clone, Copy)]
struct Vec3File([f64; 3]);

impl Vec3File {
    fn wide(self) -> DVec3 {
        self.0.into()
    }

    fn narrow(self) -> Vec3 {
        self.wide().as_vec3()
    }
}

/// Reads the reference scene called `name`.
pub fn load(name: &str) -> Gold {
    let file: File = cases::read(&format!("{name}.json"));
    let (pixels, size) = picture::read_npy(&crate::data(&format!("{name}.npy")));
    let camera = Camera::look_at(
        file.camera.origin.narrow(),
        file.camera.look_at.narrow(),
        file.camera.up.narrow(),
        file.camera.vfov_deg.to_radians(),
    )
    .unwrap();
    let lights = file.lights.iter().map(light).collect();
    let meshes = file.primitives.iter().map(mesh).collect();
    let mut view = View::new(meshes, camera, medium(&file.medium), lights, 1);
    view.size = size;
    let fragile = file.stats.fragile_pixels.iter().map(|&[row, col]| row * size.0 as usize + col).collect();
    Gold { view, pixels, fragile }
}

fn mesh(primitive: &Primitive) -> Mesh {
    match *primitive {
        Primitive::Sphere { center, radius } => tessellate::sphere(center.wide(), radius),
        Primitive::Plane { point, normal } => tessellate::plane(point.wide(), normal.wide()),
        Primitive::Box { center, half, axes } => {
            tessellate::block(center.wide(), half.wide(), axes.map(Vec3File::wide))
        }
        Primitive::Cylinder { p0, p1, radius } => tessellate::cylinder(p0.wide(), p1.wide(), radius),
    }
}

fn medium(file: &MediumFile) -> Medium {
    let phase = match file.phase {
        cases::Phase::Isotropic => PhaseFunction::ISOTROPIC,
        cases::Phase::Hg { g } => PhaseFunction::henyey_greenstein(g as f32).unwrap(),
    };
    let bounds = file.bounds.as_ref().map(|b| Aabb { min: b.min.narrow(), max: b.max.narrow() });
    Medium { phase, bounds, ..Medium::homogeneous(file.sigma_s, file.sigma_a).unwrap() }
}

fn light(file: &LightFile) -> Light {
    match file {
        LightFile::Point { position, intensity } => {
            Light::Point(PointLight::new(position.narrow(), intensity.narrow()).unwrap())
        }
        LightFile::Directional { direction, irradiance } => {
            Light::Directional(DirectionalLight::new(direction.narrow(), irradiance.narrow()).unwrap())
        }
        LightFile::Spot { position, look_at, up, cutoff_deg, beam_deg, intensity, texture } => {
            let axis = (look_at.wide() - position.wide()).normalize();
            let mut spot = SpotLight::new(
                position.narrow(),
                axis.as_vec3(),
                beam_deg.to_radians(),
                cutoff_deg.to_radians(),
                intensity.narrow(),
            )
            .unwrap();
            spot.right = axis.cross(up.wide()).normalize().as_vec3();
            spot.texture = texture.as_ref().map(|texture| {
                let (rows, columns) = (texture.texels.len() as u32, texture.texels[0].len() as u32);
                let texels = texture.texels.concat();
                Arc::new(LightTexture::new(columns, rows, texels, TextureFilter::Nearest).unwrap())
            });
            Light::Spot(spot)
        }
    }
}
