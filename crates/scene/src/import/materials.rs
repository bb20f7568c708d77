//! Surfaces: a base colour each, and nothing else.

use super::error::{ImportError, place};
use super::notes::Notes;
use crate::Material;
use gltf::Document;
use gltf::material::AlphaMode;

/// All materials of the document, in its order.
pub(super) fn materials(document: &Document, notes: &mut Notes) -> Result<Vec<Material>, ImportError> {
    document.materials().map(|item| material(&item, notes)).collect()
}

fn material(item: &gltf::Material<'_>, notes: &mut Notes) -> Result<Material, ImportError> {
    let place = place("material", item.index().unwrap_or_default(), item.name());
    let surface = item.pbr_metallic_roughness();
    let [base_color @ .., _] = surface.base_color_factor();
    if let Some(bad) = base_color.iter().find(|channel| !(0.0..=1.0).contains(*channel)) {
        return Err(ImportError::at(place, format!("baseColorFactor must lie between 0 and 1, got {bad}")));
    }
    if surface.base_color_texture().is_some() {
        notes.add("base colour textures are ignored, surfaces have their base colour factor", &place);
    }
    if item.alpha_mode() != AlphaMode::Opaque {
        notes.add("is taken for opaque", &place);
    }
    Ok(Material { name: item.name().unwrap_or_default().into(), base_color })
}
