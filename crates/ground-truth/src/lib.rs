//! The exact reference: single-scattered light with analytic shadows, in `f64`.
//!
//! For a view ray and a light, the triangles that cut the plane region between the ray and the light are found
//! through the hierarchy. Each one's shadow on the ray is an interval, found analytically; their union is removed, and
//! airlight is integrated over the rest: in closed form where there is one, else by quadrature between the points
//! where the integrand or its slope jumps (cone, texels, faces of a bounded medium). No marching, no shadow map, no
//! noise. Every fast technique of the workspace answers to it.
//!
//! The same integrals over the lit pieces that something else found, a shadow map's traversal for instance, come from
//! [`Reference::with_shadows`].
//!
//! ```
//! use glam::{DVec3, Vec3};
//! use ground_truth::{Reference, Settings};
//! use scene::{Bvh, DRay, Light, Material, Medium, Mesh, PointLight, Scene};
//!
//! // a square of 2 m at y = 2, below a lamp at y = 4
//! let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| Vec3::new(x, 2.0, z));
//! let square = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]], 0)?;
//! let scene = Scene { meshes: vec![square], materials: vec![Material::default()], ..Scene::default() };
//! let bvh = Bvh::build(&scene)?;
//! let lights = [Light::Point(PointLight::new(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(10.0))?)];
//! let medium = Medium::homogeneous([0.1; 3], [0.0; 3])?;
//! let reference = Reference::new(&scene.materials, &bvh, &medium, &lights, Settings::default())?;
//!
//! // a view ray along X at y = 0, in shadow from x = −2 to x = 2: light from −9 to −2 and from 2 to 11
//! let ray = DRay { origin: DVec3::new(-9.0, 0.0, 0.0), direction: DVec3::X };
//! let airlight = reference.airlight(&ray, 20.0);
//! assert!((airlight.x - 0.0068097875).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod airlight;
mod face_cuts;
mod lit_intervals;
mod quadrature;
mod ray_plane;
mod shadow_interval;
mod shadows;
mod spot_cuts;
mod surface;

use glam::DVec3;
use media_math::PhaseFunction;
use rayon::prelude::*;
use scene::{AirlightModel, Bvh, Camera, DRay, Hit, Light, LightId, LitIntervals, Material, Medium, Refusal};

use airlight::{Coefficients, Scratch};
pub use lit_intervals::ExactShadows;
use shadows::Shadows;

/// What is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Leave surfaces black.
    pub airlight_only: bool,
    /// Whether triangles cast shadows in the medium; on surfaces they always do.
    pub shadows_in_medium: bool,
    /// How far a ray that hits nothing is integrated; units: m; may be infinite.
    pub max_distance: f64,
    /// How the airlight of point and spot lights is formed.
    pub model: AirlightModel,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            airlight_only: false,
            shadows_in_medium: true,
            max_distance: f64::INFINITY,
            model: AirlightModel::Sun,
        }
    }
}

/// The exact reference for one scene, medium and set of lights.
#[derive(Debug)]
pub struct Reference<'a> {
    materials: &'a [Material],
    bvh: &'a Bvh,
    medium: &'a Medium,
    lights: &'a [Light],
    settings: Settings,
    shadows: Shadows<'a>,
    coefficients: Coefficients,
    phase: PhaseFunction<f64>,
}

impl<'a> Reference<'a> {
    /// Prepares the reference.
    ///
    /// # Errors
    /// [`Refusal`] if the medium has a density or emits: those have no analytic integral here, and the converged
    /// march is the reference for them.
    pub fn new(
        materials: &'a [Material],
        bvh: &'a Bvh,
        medium: &'a Medium,
        lights: &'a [Light],
        settings: Settings,
    ) -> Result<Self, Refusal> {
        Self::check(medium)?;
        Ok(Self::surfaces(materials, bvh, medium, lights, settings))
    }

    /// Whether the medium has an analytic integral.
    ///
    /// # Errors
    /// [`Refusal`] as [`Reference::new`].
    pub fn check(medium: &Medium) -> Result<(), Refusal> {
        if medium.is_homogeneous() {
            return Ok(());
        }
        Err(Refusal {
            technique: "exact",
            feature: if medium.density.is_some() { "a heterogeneous density" } else { "an emitting medium" },
            instead: "brute-force with many samples",
        })
    }

    /// As [`Reference::new`] for any medium, of which only surfaces are asked ([`Reference::surface_radiance`]): they
    /// see the medium's coefficients at density 1.
    pub fn surfaces(
        materials: &'a [Material],
        bvh: &'a Bvh,
        medium: &'a Medium,
        lights: &'a [Light],
        settings: Settings,
    ) -> Self {
        let (coefficients, phase) = airlight::widen(medium);
        let shadows = Shadows::Exact(ExactShadows::new(bvh, lights));
        Self { materials, bvh, medium, lights, settings, shadows, coefficients, phase }
    }

    /// Integrates over the pieces of view rays that `shadows` says are lit, for each light by its index, instead of the
    /// exact ones.
    ///
    /// Only the medium's shadows change: what surfaces receive is still found by exact shadow rays. Pieces must lie in
    /// the span that was asked for; everything else (cones, textures, bounds, phase functions) stays the integral's
    /// own matter.
    #[must_use]
    pub fn with_shadows(mut self, shadows: &'a dyn LitIntervals) -> Self {
        self.shadows = Shadows::Given(shadows);
        self
    }

    /// The surface that a view ray meets, if any, and how far the ray is integrated.
    pub fn end_of(&self, ray: &DRay) -> (Option<Hit>, f64) {
        let hit = self.bvh.closest_hit(ray, f64::INFINITY);
        let end = hit.map_or(self.settings.max_distance, |hit| hit.distance);
        (hit, end)
    }

    /// Airlight of all lights along `ray` up to `end` metres; units: W/(m²·sr).
    pub fn airlight(&self, ray: &DRay, end: f64) -> DVec3 {
        let mut scratch = Scratch::default();
        (0..self.lights.len())
            .fold(DVec3::ZERO, |sum, light| sum + self.light_airlight(ray, end, LightId(light), &mut scratch))
    }

    /// Radiance that arrives along `ray`: airlight, and the surface behind it unless surfaces are black.
    pub fn radiance(&self, ray: &DRay) -> DVec3 {
        let (hit, end) = self.end_of(ray);
        let airlight = self.airlight(ray, end);
        match hit {
            Some(hit) if !self.settings.airlight_only => airlight + self.surface_radiance(ray, &hit),
            _ => airlight,
        }
    }

    /// Renders an image of `size` (width, height) row by row, row 0 at the top, in parallel over rows.
    ///
    /// `progress` is told of every finished row.
    pub fn render(
        &self,
        camera: &Camera,
        size: (u32, u32),
        progress: &(dyn Fn(u64) + Sync),
    ) -> Vec<[f32; 3]> {
        render_rows(size, progress, |x, y| self.radiance(&camera.pixel_ray(x, y, size)).as_vec3().to_array())
    }
}

/// Calls `pixel` for every pixel of an image of `size`, in parallel over rows; row-major.
///
/// `progress` is told of every finished row.
pub fn render_rows<T: Clone + Send>(
    size: (u32, u32),
    progress: &(dyn Fn(u64) + Sync),
    pixel: impl Fn(u32, u32) -> T + Sync,
) -> Vec<T> {
    let rows: Vec<Vec<T>> = (0..size.1)
        .into_par_iter()
        .map(|y| {
            let row = (0..size.0).map(|x| pixel(x, y)).collect();
            progress(1);
            row
        })
        .collect();
    rows.concat()
}
