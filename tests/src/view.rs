//! A scene with everything that a picture of it needs, and its picture by every technique there is.

use ground_truth::{Reference, Settings, render_rows};
use hybrid_march::{BruteForce, Occluders};
use scene::{
    AirlightModel, Bvh, BvhVisibility, Camera, Light, LitIntervals, Material, Medium, Mesh, Scene,
    Visibility, procedural,
};
use shadowmap::{
    Bias, DepthMap, ExactShadowMap, Filter, MapSurface, MapVisibility, SurfaceVisibility, draw_maps_for,
};

use crate::picture::Pixels;

/// A scene that is ready to be rendered.
#[derive(Debug)]
pub struct View {
    /// Colours that the triangles refer to.
    pub materials: Vec<Material>,
    /// Hierarchy over the triangles.
    pub bvh: Bvh,
    /// Where it is seen from.
    pub camera: Camera,
    /// What it is filled with.
    pub medium: Medium,
    /// What lights it.
    pub lights: Vec<Light>,
    /// Width and height in pixels.
    pub size: (u32, u32),
}

impl View {
    /// A view of meshes.
    pub fn new(meshes: Vec<Mesh>, camera: Camera, medium: Medium, lights: Vec<Light>, side: u32) -> Self {
        let scene = Scene { meshes, ..Scene::default() };
        let materials = vec![Material::default()];
        Self { materials, bvh: Bvh::build(&scene).unwrap(), camera, medium, lights, size: (side, side) }
    }

    /// A generated scene as it comes.
    pub fn procedural(name: &str, side: u32) -> Self {
        Self::of(&procedural::generate(name).unwrap(), side)
    }

    /// A scene with its own camera, medium and lights.
    pub fn of(scene: &Scene, side: u32) -> Self {
        Self {
            materials: scene.materials.clone(),
            bvh: Bvh::build(scene).unwrap(),
            camera: scene.cameras[0].clone(),
            medium: scene.medium.clone().unwrap(),
            lights: scene.lights.clone(),
            size: (side, side),
        }
    }

    /// The airlight with analytic shadows.
    pub fn exact(&self) -> Pixels {
        self.reference(Settings { airlight_only: true, ..Settings::default() })
    }

    /// The airlight as if nothing cast a shadow.
    pub fn unshadowed(&self) -> Pixels {
        self.reference(Settings { airlight_only: true, shadows_in_medium: false, ..Settings::default() })
    }

    /// The airlight with analytic shadows, and the lit surfaces behind it.
    pub fn with_surfaces(&self) -> Pixels {
        self.reference(Settings::default())
    }

    /// The airlight with the shadows of maps of `side` × `side` texels, in one of their meanings.
    pub fn exact_shadow_map(&self, side: u32, surface: MapSurface) -> Pixels {
        let maps = self.maps(side, surface);
        let shadows = ExactShadowMap::new(&maps, &self.lights, surface, Bias::NONE).unwrap();
        self.exact_between(&shadows)
    }

    /// The airlight over the pieces that `shadows` leaves.
    pub fn exact_between(&self, shadows: &dyn LitIntervals) -> Pixels {
        let settings = Settings { airlight_only: true, ..Settings::default() };
        let reference =
            Reference::new(&self.materials, &self.bvh, &self.medium, &self.lights, settings).unwrap();
        reference.with_shadows(shadows).render(&self.camera, self.size, &|_| ())
    }

    /// Maps of all lights, as a picture in this meaning needs them.
    pub fn maps(&self, side: u32, surface: MapSurface) -> Vec<Option<DepthMap>> {
        let positions = self.bvh.triangles().iter().flat_map(|triangle| triangle.corners).collect();
        let triangles =
            (0..self.bvh.triangles().len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let meshes = vec![Mesh::new(positions, triangles, 0).unwrap()];
        draw_maps_for(&self.lights, &Scene { meshes, ..Scene::default() }, side, surface).unwrap()
    }

    fn reference(&self, settings: Settings) -> Pixels {
        let reference =
            Reference::new(&self.materials, &self.bvh, &self.medium, &self.lights, settings).unwrap();
        reference.render(&self.camera, self.size, &|_| ())
    }

    /// The airlight by a march of `samples` steps with a shadow ray each.
    pub fn marched(&self, samples: u32) -> Pixels {
        self.marched_with(samples, true)
    }

    /// As [`View::marched`], as if nothing cast a shadow.
    pub fn marched_unshadowed(&self, samples: u32) -> Pixels {
        self.marched_with(samples, false)
    }

    /// The airlight by a march of `samples` steps with a lookup each in maps of `side` × `side` texels.
    pub fn marched_with_maps(&self, samples: u32, side: u32, surface: MapSurface) -> Pixels {
        let maps = self.maps(side, surface);
        match surface {
            MapSurface::Step => {
                self.marched_by(samples, true, &MapVisibility::new(&maps, Filter::Nearest, Bias::NONE))
            }
            MapSurface::Linear => {
                self.marched_by(samples, true, &SurfaceVisibility::new(&maps, surface, Bias::NONE))
            }
        }
    }

    fn marched_with(&self, samples: u32, shadows: bool) -> Pixels {
        self.marched_by(samples, shadows, &BvhVisibility::new(&self.bvh, &self.lights))
    }

    fn marched_by(&self, samples: u32, shadows: bool, visibility: &dyn Visibility) -> Pixels {
        let casts = shadows && !self.bvh.triangles().is_empty();
        let march = BruteForce {
            medium: &self.medium,
            lights: &self.lights,
            occluders: casts.then_some(Occluders { visibility, bounds: self.bvh.bounds() }),
            samples,
            model: AirlightModel::Sun,
        };
        render_rows(self.size, &|_| (), |x, y| {
            let ray = self.camera.pixel_ray(x, y, self.size);
            let end = self.bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
            march.airlight(&ray, end).airlight.to_array()
        })
    }
}
