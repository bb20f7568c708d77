//! Everything that is rendered.

use crate::{Aabb, Camera, Light, Medium, Mesh};

/// Surface colour; surfaces are two-sided Lambert.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in the file, or empty.
    pub name: String,
    /// Diffuse reflectance, linear RGB.
    pub base_color: [f32; 3],
}

impl Default for Material {
    fn default() -> Self {
        Self { name: String::new(), base_color: [0.8; 3] }
    }
}

/// Meshes in world space with what lights and views them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scene {
    /// Geometry.
    pub meshes: Vec<Mesh>,
    /// Materials that the meshes refer to; every index is in range.
    pub materials: Vec<Material>,
    /// Cameras of the file, maybe none.
    pub cameras: Vec<Camera>,
    /// Lights of the file, maybe none.
    pub lights: Vec<Light>,
    /// Medium of the file, if it names one.
    pub medium: Option<Medium>,
    /// What the importer left out, one sentence each.
    pub notes: Vec<String>,
}

impl Scene {
    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles().len()).sum()
    }

    /// The smallest box around all meshes; empty without any.
    pub fn bounds(&self) -> Aabb {
        self.meshes.iter().fold(Aabb::EMPTY, |b, mesh| b.union(&mesh.bounds()))
    }
}
