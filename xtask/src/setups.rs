//! The fixed set-ups of `scenes.toml`: which scene, seen from where, lit by what, in which medium.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use scene::{AirlightModel, Camera, Light, Medium, PointLight};
use serde::Deserialize;

use crate::failure::{Failure, Outcome};
use crate::scene_args::{Setup, load_scene};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    optical_depths: BTreeMap<String, f32>,
    scene: Vec<Entry>,
}

/// One scene of the file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Entry {
    /// Name in the tables.
    pub(crate) id: String,
    /// Whether `quick` and `smoke` run it where no scenes folder is given.
    #[serde(default)]
    pub(crate) quick: bool,
    /// What Wyman and Ramsey measured.
    pub(crate) wyman: Option<Wyman>,
    file: Option<String>,
    view: Option<f32>,
    camera: Option<CameraEntry>,
    point_light: Option<PointEntry>,
    stand_in: Option<String>,
    stand_in_view: Option<f32>,
}

/// A row of Wyman and Ramsey 2008, Table 1; frames per second at 1024², scattering at 1024² or 256².
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wyman {
    pub(crate) row: String,
    pub(crate) no_shadows: f64,
    pub(crate) brute_full: f64,
    pub(crate) brute_quarter: f64,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraEntry {
    eye: [f32; 3],
    target: [f32; 3],
    fov: f32,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct PointEntry {
    position: [f32; 3],
    intensity: f32,
}

/// The set-ups, and where their meshes are.
#[derive(Debug)]
pub(crate) struct Setups {
    optical_depths: BTreeMap<String, f32>,
    entries: Vec<Entry>,
    folder: Option<PathBuf>,
}

/// A scene that can be run: its entry, and where its geometry comes from.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    pub(crate) entry: Entry,
    /// What `render` would call it.
    name: String,
    is_stand_in: bool,
}

impl Setups {
    /// The built-in file, with meshes from a folder where one is given, by the flag or variable named with it.
    pub(crate) fn load(folder: Option<(&str, &Path)>) -> Outcome<Self> {
        let file: File = toml::from_str(include_str!("../scenes.toml"))
            .map_err(|e| Failure::program(format!("scenes.toml: {e}")))?;
        if let Some((name, folder)) = folder
            && !folder.is_dir()
        {
            return Err(Failure::input(format!("{name} {}: is not a folder", folder.display())));
        }
        Ok(Self {
            optical_depths: file.optical_depths,
            entries: file.scene,
            folder: folder.map(|(_, folder)| folder.to_owned()),
        })
    }

    /// Whether a folder was given that holds at least one of the scenes.
    pub(crate) fn has_folder(&self) -> bool {
        self.sources().iter().any(|source| !source.is_stand_in)
    }

    /// The scenes that can be run: with a folder those it holds, else the generated ones.
    pub(crate) fn sources(&self) -> Vec<Source> {
        let given = |entry: &Entry| {
            let path = self.folder.as_ref()?.join(entry.file.as_ref()?);
            path.is_file().then(|| path.display().to_string())
        };
        let from_folder: Vec<Source> = self
            .entries
            .iter()
            .filter_map(|entry| {
                Some(Source { name: given(entry)?, entry: entry.clone(), is_stand_in: false })
            })
            .collect();
        if !from_folder.is_empty() {
            return from_folder;
        }
        self.entries
            .iter()
            .filter_map(|entry| {
                let name = format!("procedural:{}", entry.stand_in.as_ref()?);
                Some(Source { name, entry: entry.clone(), is_stand_in: true })
            })
            .collect()
    }

    /// Names of the media and the optical depth of the view in each.
    pub(crate) fn media(&self) -> impl Iterator<Item = (&str, f32)> {
        self.optical_depths.iter().map(|(name, depth)| (name.as_str(), *depth))
    }
}

impl Source {
    /// Name in the tables: a generated scene says that it is one.
    pub(crate) fn title(&self) -> String {
        if self.is_stand_in { self.name.clone() } else { self.entry.id.clone() }
    }

    /// The set-up with a view of optical depth `depth`.
    pub(crate) fn setup(&self, depth: f32) -> Outcome<Setup> {
        let scene = load_scene(&self.name)?;
        let wrong = |what: &str| Failure::program(format!("scenes.toml: {} has no {what}", self.entry.id));
        let (view, camera, lights) = if self.is_stand_in {
            let camera = scene.cameras.first().cloned().ok_or_else(|| wrong("camera"))?;
            (self.entry.stand_in_view.ok_or_else(|| wrong("stand_in_view"))?, camera, scene.lights.clone())
        } else {
            let camera = self.entry.camera.as_ref().ok_or_else(|| wrong("camera"))?;
            let light = self.entry.point_light.as_ref().ok_or_else(|| wrong("point_light"))?;
            let eye_target = (Vec3::from(camera.eye), Vec3::from(camera.target));
            let camera = Camera::look_at(eye_target.0, eye_target.1, Vec3::Y, camera.fov.to_radians())
                .map_err(Failure::program)?;
            let light = PointLight::new(light.position.into(), Vec3::splat(light.intensity))
                .map_err(Failure::program)?;
            (self.entry.view.ok_or_else(|| wrong("view"))?, camera, vec![Light::Point(light)])
        };
        let medium = Medium::homogeneous([depth / view; 3], [0.0; 3]).map_err(Failure::program)?;
        Ok(Setup { scene, camera, medium, lights, model: AirlightModel::Sun, notes: Vec::new() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics;
    use crate::technique::{Options, Technique, render};
    use scene::Bvh;

    #[test]
    fn every_entry_is_complete() {
        let setups = Setups::load(None).unwrap();
        assert_eq!(setups.media().count(), 2);
        for entry in &setups.entries {
            assert!(entry.file.is_some() || entry.stand_in.is_some(), "{}", entry.id);
            assert_eq!(
                entry.file.is_some(),
                entry.camera.is_some() && entry.point_light.is_some() && entry.view.is_some()
            );
            assert_eq!(entry.stand_in.is_some(), entry.stand_in_view.is_some(), "{}", entry.id);
        }
        assert!(Setups::load(Some(("--scenes", Path::new("/nowhere/at/all")))).is_err());
    }

    #[test]
    fn shadows_matter_in_every_generated_set_up() {
        let setups = Setups::load(None).unwrap();
        for source in setups.sources() {
            // the large ones are checked by every reproduction, which states the same figure
            if source.name.contains("knot") || source.name.contains("street") {
                continue;
            }
            for (medium, depth) in setups.media() {
                let setup = source.setup(depth).unwrap();
                let bvh = Bvh::build(&setup.scene).unwrap();
                let mut options = Options {
                    size: (32, 32),
                    airlight_only: true,
                    shadows_in_medium: true,
                    max_distance: f64::INFINITY,
                    samples: 1,
                };
                let shadowed = render(&setup, &bvh, Technique::Exact, &options, "exact").unwrap();
                options.shadows_in_medium = false;
                let open = render(&setup, &bvh, Technique::Exact, &options, "unshadowed").unwrap();
                let weight = metrics::compare(&open.image, &shadowed.image, None, None).unwrap().rel_rmse;
                assert!(weight >= 0.2, "{} {medium}: {weight}", source.name);
            }
        }
    }
}
