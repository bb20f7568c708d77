//! The crate's validation, with what it forgets and without what it is too strict about.

use super::error::ImportError;
use gltf::json::camera::Type;
use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Error as Fault, Validate};
use gltf::json::{Path, Root};

/// Refuses a document in which the crate's functions would not find what they look for.
pub(super) fn validate(root: &Root) -> Result<(), ImportError> {
    check_positions(root)?;
    check_cameras(root)?;
    let mut first = None;
    root.validate(root, Path::new, &mut |path, fault| {
        if first.is_none() && !is_harmless(path().as_str(), fault) {
            first = Some(ImportError::at(path(), fault));
        }
    });
    first.map_or(Ok(()), Err)
}

/// The crate's own validation looks up the accessor of positions without a check.
fn check_positions(root: &Root) -> Result<(), ImportError> {
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            if positions.is_some_and(|&index| root.get(index).is_none()) {
                let place = format!("meshes[{m}].primitives[{p}].attributes.POSITION");
                return Err(ImportError::at(place, Fault::IndexOutOfBounds));
            }
        }
    }
    Ok(())
}

/// The crate is content with a perspective camera that has orthographic numbers.
fn check_cameras(root: &Root) -> Result<(), ImportError> {
    for (i, camera) in root.cameras.iter().enumerate() {
        let missing = match camera.type_ {
            Checked::Valid(Type::Perspective) => camera.perspective.is_none().then_some("perspective"),
            Checked::Valid(Type::Orthographic) => camera.orthographic.is_none().then_some("orthographic"),
            Checked::Invalid => None,
        };
        if let Some(field) = missing {
            return Err(ImportError::at(format!("cameras[{i}].{field}"), Fault::Missing));
        }
    }
    Ok(())
}

/// Whether nothing that is read depends on it.
fn is_harmless(path: &str, fault: Fault) -> bool {
    // nothing is followed into these; textures of EXT_texture_webp and its like have no plain source
    ["samplers[", "skins[", "textures["].iter().any(|list| path.starts_with(list))
        // attributes that glTF does not know, and bounds of positions, which many writers leave out
        || ["[\"<invalid semantic name>\"]", "[\"POSITION\"].min", "[\"POSITION\"].max"]
            .iter()
            .any(|field| path.ends_with(field))
        // required extensions have been looked at before
        || fault == Fault::Unsupported
}
