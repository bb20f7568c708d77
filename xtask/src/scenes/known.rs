//! What is known of the meshes: `known.toml`.

use glam::Vec3;
use scene::Aabb;
use serde::Deserialize;

use crate::failure::{Failure, Outcome};

/// The list.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Known {
    #[serde(rename = "scene")]
    pub(super) scenes: Vec<KnownScene>,
    pub(super) absent: Vec<Absent>,
}

/// A mesh that set-ups were chosen with.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KnownScene {
    /// Name in the scenes folder.
    pub(super) file: String,
    /// In hexadecimal digits.
    pub(super) sha256: String,
    pub(super) triangles: usize,
    min: [f32; 3],
    max: [f32; 3],
    pub(super) kind: String,
    pub(super) row: String,
    pub(super) licence: String,
    pub(super) original: Option<String>,
    pub(super) papers_own: Option<String>,
    pub(super) made_from: String,
    pub(super) note: Option<String>,
}

/// What a paper used and no file stands for.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Absent {
    pub(super) row: String,
    pub(super) original: String,
    pub(super) note: String,
}

impl Known {
    /// The built-in list.
    pub(super) fn load() -> Outcome<Self> {
        toml::from_str(include_str!("known.toml")).map_err(|e| Failure::program(format!("known.toml: {e}")))
    }
}

impl KnownScene {
    /// The box around the mesh, to four decimals; units: as in the file.
    pub(super) fn bounds(&self) -> Aabb {
        Aabb { min: Vec3::from(self.min), max: Vec3::from(self.max) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setups::Setups;

    #[test]
    fn every_mesh_of_a_set_up_is_known_once() {
        let known = Known::load().unwrap();
        let setups = Setups::load(None).unwrap();
        let files: Vec<&String> = setups.entries().iter().filter_map(|entry| entry.file.as_ref()).collect();
        assert_eq!(files.len(), known.scenes.len());
        for scene in &known.scenes {
            assert!(scene.sha256.len() == 64 && scene.sha256.bytes().all(|b| b.is_ascii_hexdigit()));
            assert!(scene.triangles > 0 && scene.bounds().diagonal() > 0.0, "{}", scene.file);
            let generated = scene.kind == "generated";
            assert_eq!(scene.original.is_none(), generated, "{}: where is it published?", scene.file);
            assert_eq!(files.iter().filter(|file| **file == &scene.file).count(), 1, "{}", scene.file);
        }
    }
}
