//! Puts meshes, camera, lights and medium together to a scene.

use super::builder::MeshBuilder;
use crate::{Camera, DirectionalLight, Light, Medium, Mesh, PointLight, Scene, SceneError};
use glam::Vec3;

/// A scene under construction.
///
/// Generated parts are valid by construction; the tests see to it. Should one not be, the scene is built without it
/// and says so in its notes, since a generator has no caller who could mend it.
#[derive(Debug, Default)]
pub(super) struct Stage {
    scene: Scene,
}

impl Stage {
    fn accept<T>(&mut self, part: Result<T, SceneError>) -> Option<T> {
        debug_assert!(part.is_ok(), "a generated part is not valid: {:?}", part.as_ref().err());
        part.inspect_err(|error| self.scene.notes.push(format!("left out: {error}"))).ok()
    }

    /// Adds a mesh with a material of its own; `base_color` in linear RGB.
    pub(super) fn part(&mut self, name: &str, base_color: [f32; 3], mesh: MeshBuilder) -> &mut Self {
        let material = self.scene.materials.len();
        if let Some(mesh) = self.accept(Mesh::new(mesh.positions, mesh.triangles, material)) {
            self.scene.materials.push(crate::Material { name: name.into(), base_color });
            self.scene.meshes.push(mesh);
        }
        self
    }

    /// Adds a camera; positions in m, vertical field of view in degrees.
    pub(super) fn camera(&mut self, eye: [f32; 3], target: [f32; 3], fov_y: f32) -> &mut Self {
        if let Some(camera) =
            self.accept(Camera::look_at(eye.into(), target.into(), Vec3::Y, fov_y.to_radians()))
        {
            self.scene.cameras.push(Camera { name: Some("default".into()), ..camera });
        }
        self
    }

    /// Adds a point light; position in m, radiant intensity in W/sr.
    pub(super) fn point_light(&mut self, position: [f32; 3], intensity: [f32; 3]) -> &mut Self {
        if let Some(light) = self.accept(PointLight::new(position.into(), intensity.into())) {
            self.scene.lights.push(Light::Point(light));
        }
        self
    }

    /// Adds a directional light that travels along `direction`; irradiance in W/m².
    pub(super) fn directional_light(&mut self, direction: [f32; 3], irradiance: [f32; 3]) -> &mut Self {
        if let Some(light) = self.accept(DirectionalLight::new(direction.into(), irradiance.into())) {
            self.scene.lights.push(Light::Directional(light));
        }
        self
    }

    /// Fills space with a grey isotropic medium that scatters `sigma_s` and absorbs nothing; units: m⁻¹.
    pub(super) fn fog(&mut self, sigma_s: f32) -> &mut Self {
        self.scene.medium = self.accept(Medium::homogeneous([sigma_s; 3], [0.0; 3]));
        self
    }

    /// Triangles so far.
    pub(super) fn triangle_count(&self) -> usize {
        self.scene.triangle_count()
    }

    pub(super) fn finish(self) -> Scene {
        self.scene
    }
}
