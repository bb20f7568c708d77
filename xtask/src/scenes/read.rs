//! Models in the formats that they are published in.

use std::path::Path;

use glam::Vec3;
use scene::import::load_gltf;
use scene::{Material, Mesh, Scene};

use super::{obj, off, ply, stl, three_ds};
use crate::failure::{Failure, Outcome};
use crate::output_file::read_input;

/// A format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Obj,
    Ply,
    Stl,
    Off,
    ThreeDs,
    Gltf,
}

/// Endings of what is read, for messages.
pub(super) const ENDINGS: &str = ".obj, .ply, .stl, .off, .3ds, .gltf or .glb";

impl Format {
    /// The format of a file, by the ending of its name.
    pub(super) fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_lowercase().as_str() {
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "off" => Some(Self::Off),
            "3ds" => Some(Self::ThreeDs),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }

    /// Reads a file of this format: triangles by material, nothing else.
    pub(super) fn read(self, path: &Path) -> Outcome<Scene> {
        let scene = match self {
            Self::Gltf => return load_gltf(path).map_err(Failure::input),
            Self::Obj => obj::read(&read_input(path)?, path.parent()),
            Self::Ply => ply::read(&read_input(path)?),
            Self::Stl => stl::read(&read_input(path)?),
            Self::Off => off::read(&read_input(path)?),
            Self::ThreeDs => three_ds::read(&read_input(path)?),
        };
        scene.map_err(|what| Failure::input(format!("{}: {what}", path.display())))
    }
}

/// A scene of one mesh, of white surfaces.
pub(super) fn plain(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Scene, String> {
    let mesh = Mesh::new(positions, triangles, 0).map_err(|e| e.to_string())?;
    let white = Material { name: String::new(), base_color: [1.0; 3] };
    Ok(Scene { meshes: vec![mesh], materials: vec![white], ..Scene::default() })
}
