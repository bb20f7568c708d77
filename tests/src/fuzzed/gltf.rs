//! Any bytes as a glTF file.

/// The importer gives a scene or a one-line error, and never panics, hangs or takes memory out of proportion to the
/// file.
pub fn gltf(bytes: &[u8]) {
    match scene::import::load_gltf_bytes(bytes, None) {
        // what a scene promises: finite bounds, and indices in range, or this panics
        Ok(scene) => {
            let bounds = scene.bounds();
            assert!(bounds.is_empty() || (bounds.min.is_finite() && bounds.max.is_finite()));
            assert!(scene.meshes.iter().all(|mesh| mesh.material < scene.materials.len()));
            assert_eq!(
                scene.meshes.iter().map(|mesh| mesh.corners().count()).sum::<usize>(),
                scene.triangle_count()
            );
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "more than one line: {error}"),
    }
}
