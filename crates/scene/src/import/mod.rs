//! glTF 2.0 into a [`Scene`].
//!
//! What is read: triangles (lists, strips and fans) of all meshes in the default scene with their node transforms and
//! base colour factors, perspective cameras, the lights of `KHR_lights_punctual`, and from the `extras` a medium
//! (on the scene) and light textures (on the nodes of spot lights). What is left out is said in [`Scene::notes`].
//!
//! Files come from anywhere, so nothing in them is believed: every count is held against the bytes that bear it before
//! anything is allocated, every reference is followed with a check, hierarchies are walked without recursion. What does
//! not make sense is an [`ImportError`] that names the object at fault. The format itself, from the container to the
//! numbers in buffers, is the work of the crate `gltf`; the modules here keep it to what it can be relied upon for.

mod accessor;
mod buffers;
mod cameras;
mod container;
mod document;
mod error;
mod lights;
mod materials;
mod medium;
mod mend;
mod mesh;
mod nodes;
mod notes;
mod texture;
mod typed;
mod uri;
mod validate;

pub use error::ImportError;
pub use texture::ColorSpace;

use crate::{LightTexture, Material, Scene, TextureFilter};
use buffers::Buffers;
use error::place;
use gltf::Document;
use nodes::Node;
use notes::Notes;
use std::path::Path;
use texture::Textures;

/// Reads a `.glb` or `.gltf` file, with the files that it refers to.
///
/// # Errors
/// [`ImportError::InFile`] with the file's name if it cannot be read or makes no sense.
///
/// ```no_run
/// let scene = scene::import::load_gltf("room.glb".as_ref())?;
/// println!("{} triangles, {} lights", scene.triangle_count(), scene.lights.len());
/// # Ok::<(), scene::import::ImportError>(())
/// ```
pub fn load_gltf(path: &Path) -> Result<Scene, ImportError> {
    let scene = read_regular(path)
        .map_err(ImportError::Read)
        .and_then(|bytes| load_gltf_bytes(&bytes, path.parent()));
    scene.map_err(|error| in_file(path, error))
}

/// Reads the bytes of a `.glb` or `.gltf` file.
///
/// `base` is the folder in which relative URIs are looked up; without one they are refused.
///
/// # Errors
/// [`ImportError`] if the bytes or what they refer to make no sense.
pub fn load_gltf_bytes(bytes: &[u8], base: Option<&Path>) -> Result<Scene, ImportError> {
    let (text, bin) = container::split(bytes)?;
    let mut notes = Notes::default();
    let document = document::parse(&text, &mut notes)?;
    let buffers = Buffers::load(&document, bin.as_deref(), base)?;
    let scene_item = default_scene(&document, &mut notes);
    let nodes = nodes::collect(&document, scene_item.as_ref())?;

    let mut scene = Scene { materials: materials::materials(&document, &mut notes)?, ..Scene::default() };
    place_meshes(&mut scene, &document, &buffers, &nodes, &mut notes)?;
    let mut textures = Textures::new(&document, &buffers, base);
    for node in &nodes {
        if let Some(camera) = node.item.camera() {
            scene.cameras.extend(cameras::perspective(node, &camera, &mut notes)?);
        }
        scene.lights.extend(lights::light(node, &mut textures, &mut notes)?);
    }
    if let Some(item) = &scene_item {
        scene.medium = medium::medium(&document, &buffers, item)?;
    }
    scene.notes = notes.into_sentences();
    Ok(scene)
}

/// Reads a PNG, JPEG or EXR file as a light texture; EXR is linear whatever `color_space` says.
///
/// # Errors
/// [`ImportError::InFile`] with the file's name if it cannot be read, is of another kind or broken, or holds a value
/// that is negative or not finite.
pub fn load_light_texture(
    path: &Path,
    filter: TextureFilter,
    color_space: ColorSpace,
) -> Result<LightTexture, ImportError> {
    let bytes = read_regular(path).map_err(ImportError::Read);
    bytes.and_then(|bytes| texture::decode(&bytes, filter, color_space)).map_err(|error| in_file(path, error))
}

fn in_file(path: &Path, error: ImportError) -> ImportError {
    ImportError::InFile { path: path.into(), error: Box::new(error) }
}

/// The scene that the document names, or its first; none if it has no scenes.
fn default_scene<'a>(document: &'a Document, notes: &mut Notes) -> Option<gltf::Scene<'a>> {
    let scene = document.default_scene().or_else(|| document.scenes().next())?;
    if document.scenes().len() > 1 {
        notes.add("is the only scene that is read", &place("scene", scene.index(), scene.name()));
    }
    Some(scene)
}

/// One mesh for each primitive of each node that has one.
fn place_meshes(
    scene: &mut Scene,
    document: &Document,
    buffers: &Buffers<'_>,
    nodes: &[Node<'_>],
    notes: &mut Notes,
) -> Result<(), ImportError> {
    // what no node shows is not read, and what many show is looked up once
    let mut known = vec![None; document.meshes().len()];
    let mut instances = Vec::new();
    let mut triangles = 0_u64;
    for node in nodes {
        let Some(item) = node.item.mesh() else { continue };
        let index = item.index();
        if known[index].is_none() {
            known[index] = Some(mesh::primitives(buffers, &item, notes)?);
        }
        if node.item.skin().is_some() {
            notes.add("its skin is ignored, the mesh keeps its rest pose", &node.place());
        }
        let primitives = known[index].iter().flatten();
        triangles = primitives.fold(triangles, |sum, p| sum.saturating_add(p.triangle_count() as u64));
        instances.push((node, index));
    }
    // before any of them takes memory
    if triangles > 1 << 31 {
        return Err(ImportError::TooManyTriangles(triangles));
    }
    for (node, index) in instances {
        for primitive in known[index].iter().flatten().filter(|primitive| primitive.triangle_count() > 0) {
            let material = primitive.material.unwrap_or_else(|| default_material(scene, document));
            scene.meshes.push(primitive.instance(node, material)?);
        }
    }
    Ok(())
}

/// The material of primitives that name none: glTF's default is white. It comes after those of the document.
fn default_material(scene: &mut Scene, document: &Document) -> usize {
    let index = document.materials().len();
    if scene.materials.len() == index {
        scene.materials.push(Material { name: String::new(), base_color: [1.0; 3] });
    }
    index
}

/// A whole file; anything but a regular one could be endless.
fn read_regular(path: &Path) -> std::io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(std::io::Error::other("not a regular file"));
    }
    std::fs::read(path)
}
