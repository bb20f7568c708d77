//! A small stage to test on: a scene with its hierarchy, a medium, lights and cameras.
#![allow(dead_code, reason = "each test file uses a part of it")]

use froxel_grid::{Frame, FroxelFog, Froxels, Occluders, Rendered, View};
use glam::{DVec3, Vec2, Vec3};
use scene::{AirlightModel, Bvh, BvhVisibility, Camera, Light, Medium, Scene, procedural};

/// A scene that is lit and seen.
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    pub(crate) bvh: Bvh,
    pub(crate) medium: Medium,
    pub(crate) lights: Vec<Light>,
    pub(crate) cameras: Vec<Camera>,
    pub(crate) size: (u32, u32),
    pub(crate) model: AirlightModel,
    /// Where view rays end by view and pixel; units: m.
    pub(crate) ends: Vec<Vec<f32>>,
}

impl Stage {
    pub(crate) fn new(
        scene: Scene,
        medium: Medium,
        lights: Vec<Light>,
        cameras: Vec<Camera>,
        size: (u32, u32),
    ) -> Self {
        let bvh = Bvh::build(&scene).unwrap();
        let mut stage =
            Self { scene, bvh, medium, lights, cameras, size, model: AirlightModel::Sun, ends: Vec::new() };
        stage.look();
        stage
    }

    /// A generated scene with its own camera, light and medium.
    pub(crate) fn generated(name: &str, size: (u32, u32)) -> Self {
        let scene = procedural::generate(name).unwrap();
        let (medium, lights, camera) =
            (scene.medium.clone().unwrap(), scene.lights.clone(), scene.cameras[0].clone());
        Self::new(scene, medium, lights, vec![camera], size)
    }

    /// Finds where view rays end, after cameras have moved.
    pub(crate) fn look(&mut self) {
        let size = self.size;
        let end = |camera: &Camera, i: u32| {
            let ray = camera.pixel_ray(i % size.0, i / size.0, size);
            self.bvh.closest_hit(&ray, f64::INFINITY).map_or(f32::INFINITY, |hit| hit.distance as f32)
        };
        self.ends = self
            .cameras
            .iter()
            .map(|camera| (0..size.0 * size.1).map(|i| end(camera, i)).collect())
            .collect();
    }

    pub(crate) fn render(&self, fog: &mut FroxelFog) -> Rendered {
        self.render_as(fog, true)
    }

    /// With or without shadows.
    pub(crate) fn render_as(&self, fog: &mut FroxelFog, shadowed: bool) -> Rendered {
        let views: Vec<View<'_>> = self
            .cameras
            .iter()
            .zip(&self.ends)
            .map(|(camera, ends)| View { camera, size: self.size, ends })
            .collect();
        let visibility = BvhVisibility::new(&self.bvh, &self.lights);
        let occluders = Occluders { visibility: &visibility, bounds: self.bvh.bounds() };
        let frame = Frame {
            views: &views,
            medium: &self.medium,
            lights: &self.lights,
            model: self.model,
            occluders: shadowed.then_some(occluders),
        };
        fog.render(&frame).unwrap()
    }

    /// One frame by itself.
    pub(crate) fn once(&self, froxels: Froxels) -> Rendered {
        self.render(&mut FroxelFog::new(froxels).unwrap())
    }

    /// The pixels of the first view that are more than `pixels` away from every local light: next to one airlight is
    /// as 1/h, of which a pixel is one sample and a froxel the mean.
    pub(crate) fn away_from_lights(&self, picture: &[Vec3], pixels: f32) -> Vec<Vec3> {
        let layout = froxel_grid::FroxelView::new(&self.cameras[0], self.size, 1);
        let lamps: Vec<Vec2> = self
            .lights
            .iter()
            .filter_map(|light| match light {
                Light::Point(light) => Some(light.position),
                Light::Spot(light) => Some(light.position),
                Light::Directional(_) => None,
            })
            .filter_map(|position| layout.project(position).map(|(pixel, _)| pixel))
            .collect();
        let center = |i: usize| {
            Vec2::new((i as u32 % self.size.0) as f32 + 0.5, (i as u32 / self.size.0) as f32 + 0.5)
        };
        let away = |i: usize| lamps.iter().all(|lamp| lamp.distance(center(i)) > pixels);
        picture.iter().enumerate().filter(|(i, _)| away(*i)).map(|(_, &value)| value).collect()
    }

    /// Airlight of every pixel of the first view by `airlight` of its ray up to `end` metres.
    pub(crate) fn pixels(
        &self,
        range: f64,
        airlight: impl Fn(&scene::DRay, f64) -> DVec3 + Sync,
    ) -> Vec<Vec3> {
        ground_truth::render_rows(self.size, &|_| (), |x, y| {
            let ray = self.cameras[0].pixel_ray(x, y, self.size);
            let end = f64::from(self.ends[0][(y * self.size.0 + x) as usize]).min(range);
            airlight(&ray, end).as_vec3()
        })
    }
}

/// ‖a − b‖ of two pictures.
fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a.as_dvec3() - b.as_dvec3()).length_squared()).sum::<f64>().sqrt()
}

/// ‖a − b‖/‖b‖.
pub(crate) fn rel_rmse(a: &[Vec3], b: &[Vec3]) -> f64 {
    distance(a, b) / distance(b, &vec![Vec3::ZERO; b.len()]).max(1e-300)
}

/// ‖a − b‖/‖u − b‖: the error as a share of what shadows change, `unshadowed` being the picture without any.
pub(crate) fn shadow_err(a: &[Vec3], b: &[Vec3], unshadowed: &[Vec3]) -> f64 {
    distance(a, b) / distance(unshadowed, b)
}

/// Whether every pixel is finite and not negative.
pub(crate) fn is_sound(rendered: &Rendered) -> bool {
    rendered.counts.not_finite == 0
        && rendered.airlight.iter().flatten().all(|v| v.is_finite() && v.min_element() >= 0.0)
}
