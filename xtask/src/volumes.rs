//! What the hybrid extrudes shadow volumes from.

use glam::Vec3;
use hybrid_march::{Adjacency, bounding_box, cluster, near_viewer};
use scene::{Aabb, Mesh};

use crate::failure::{Failure, Outcome};
use crate::scene_args::Setup;
use crate::technique::Extruded;

/// The mesh of a set-up's shadow volumes, with its edges.
///
/// Fails if the scene has more edges than can be indexed.
pub(crate) fn extruded_mesh(setup: &Setup, extruded: Extruded) -> Outcome<Adjacency> {
    let scene = &setup.scene;
    let all = || -> Vec<[Vec3; 3]> { scene.meshes.iter().flat_map(Mesh::corners).collect() };
    let mesh = match extruded {
        Extruded::Scene => Adjacency::of_scene(scene),
        Extruded::BoundingBox => Adjacency::new(bounding_box(&Aabb::around(all().into_iter().flatten()))),
        Extruded::Coarse(cells) => Adjacency::new(cluster(&all(), cells)),
        Extruded::NearViewer(radius) | Extruded::RestAsTexture(radius) => {
            Adjacency::new(near_viewer(&all(), setup.camera.position, radius))
        }
    };
    mesh.map_err(|error| Failure::input(format!("shadow volumes: {error}")))
}
