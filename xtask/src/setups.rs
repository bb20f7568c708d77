//! The fixed set-ups of `scenes.toml`: which scene, seen from where, lit by what, in which medium.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use scene::{AirlightModel, Camera, DirectionalLight, Light, Medium, PointLight, Scene, SpotLight};
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
    /// Name in the scenes folder.
    pub(crate) file: Option<String>,
    view: Option<f32>,
    camera: Option<CameraEntry>,
    point_light: Option<PointEntry>,
    spot_light: Option<SpotEntry>,
    directional_light: Option<DirectionalEntry>,
    /// The generated scene that is run without the file.
    pub(crate) stand_in: Option<String>,
    stand_in_view: Option<f32>,
    stand_in_spot_light: Option<SpotEntry>,
    stand_in_directional_light: Option<DirectionalEntry>,
}

/// Which of a scene's set-ups is meant: each has one light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LightKind {
    /// A lamp that shines all around.
    Point,
    /// A cone without a texture.
    Spot,
    /// A sun.
    Directional,
}

impl LightKind {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::Point, Self::Spot, Self::Directional];

    /// The kind of a light.
    pub(crate) fn of(light: &Light) -> Self {
        match light {
            Light::Point(_) => Self::Point,
            Light::Spot(_) => Self::Spot,
            Light::Directional(_) => Self::Directional,
        }
    }

    /// Name in the tables.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Spot => "spot",
            Self::Directional => "directional",
        }
    }
}

/// A row of Wyman and Ramsey 2008, Table 1; frames per second at 1024², scattering at 1024² or 256².
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wyman {
    pub(crate) row: String,
    pub(crate) no_shadows: f64,
    pub(crate) brute_full: f64,
    pub(crate) brute_quarter: f64,
    pub(crate) hybrid_full: f64,
    pub(crate) hybrid_quarter: f64,
    pub(crate) textured_full: f64,
    pub(crate) textured_quarter: f64,
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

/// Half-angles in degrees.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct SpotEntry {
    position: [f32; 3],
    target: [f32; 3],
    inner: f32,
    outer: f32,
    intensity: f32,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct DirectionalEntry {
    direction: [f32; 3],
    irradiance: f32,
}

impl PointEntry {
    fn light(&self) -> Outcome<Light> {
        let light = PointLight::new(self.position.into(), Vec3::splat(self.intensity));
        light.map(Light::Point).map_err(Failure::program)
    }
}

impl SpotEntry {
    fn light(&self) -> Outcome<Light> {
        let (position, target) = (Vec3::from(self.position), Vec3::from(self.target));
        let (inner, outer) = (self.inner.to_radians(), self.outer.to_radians());
        let light = SpotLight::new(position, target - position, inner, outer, Vec3::splat(self.intensity));
        light.map(Light::Spot).map_err(Failure::program)
    }
}

impl DirectionalEntry {
    fn light(&self) -> Outcome<Light> {
        let light = DirectionalLight::new(self.direction.into(), Vec3::splat(self.irradiance));
        light.map(Light::Directional).map_err(Failure::program)
    }
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
        self.given() > 0
    }

    /// How many of the scenes the folder holds.
    pub(crate) fn given(&self) -> usize {
        self.sources().iter().filter(|source| !source.is_stand_in).count()
    }

    /// The scenes that can be run: without any in a folder the generated ones, else those with a file, generated where it is
    /// not there.
    pub(crate) fn sources(&self) -> Vec<Source> {
        let given = |entry: &Entry| {
            let path = self.folder.as_ref()?.join(entry.file.as_ref()?);
            let name = path.is_file().then(|| path.display().to_string())?;
            Some(Source { name, entry: entry.clone(), is_stand_in: false })
        };
        if !self.entries.iter().any(|entry| given(entry).is_some()) {
            return self.stand_ins();
        }
        let with_file = self.entries.iter().filter(|entry| entry.file.is_some());
        with_file.filter_map(|entry| given(entry).or_else(|| stand_in(entry))).collect()
    }

    /// The generated scenes.
    pub(crate) fn stand_ins(&self) -> Vec<Source> {
        self.entries.iter().filter_map(stand_in).collect()
    }

    /// Whether some of the scenes that can be run are generated.
    pub(crate) fn has_stand_ins(&self) -> bool {
        self.sources().iter().any(|source| source.is_stand_in)
    }

    /// What the file says of every scene.
    pub(crate) fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Names of the media and the optical depth of the view in each.
    pub(crate) fn media(&self) -> impl Iterator<Item = (&str, f32)> {
        self.optical_depths.iter().map(|(name, depth)| (name.as_str(), *depth))
    }
}

/// The generated scene in the place of an entry's file.
fn stand_in(entry: &Entry) -> Option<Source> {
    let name = format!("procedural:{}", entry.stand_in.as_ref()?);
    Some(Source { name, entry: entry.clone(), is_stand_in: true })
}

impl Source {
    /// Name in the tables: a generated scene says that it is one.
    pub(crate) fn title(&self) -> String {
        if self.is_stand_in { self.name.clone() } else { self.entry.id.clone() }
    }

    fn wrong(&self, what: &str) -> Failure {
        Failure::program(format!("scenes.toml: {} has no {what}", self.entry.id))
    }

    /// The lights of the set-up that every scene has: those that a stand-in comes with, the point light of a file.
    fn own_lights(&self, scene: &Scene) -> Outcome<Vec<Light>> {
        if self.is_stand_in {
            return Ok(scene.lights.clone());
        }
        let light = self.entry.point_light.as_ref().ok_or_else(|| self.wrong("point_light"))?;
        Ok(vec![light.light()?])
    }

    /// The light of a kind: the scene's own, or the one beside it; `None` where there is neither.
    fn lights_of(&self, scene: &Scene, kind: LightKind) -> Outcome<Option<Vec<Light>>> {
        let own = self.own_lights(scene)?;
        if own.iter().all(|light| LightKind::of(light) == kind) {
            return Ok(Some(own));
        }
        let entry = &self.entry;
        let (spot, sun) = if self.is_stand_in {
            (&entry.stand_in_spot_light, &entry.stand_in_directional_light)
        } else {
            (&entry.spot_light, &entry.directional_light)
        };
        let light = match kind {
            LightKind::Point => None,
            LightKind::Spot => spot.as_ref().map(SpotEntry::light),
            LightKind::Directional => sun.as_ref().map(DirectionalEntry::light),
        };
        Ok(light.transpose()?.map(|light| vec![light]))
    }

    /// The set-up with a view of optical depth `depth`, lit by the scene's own lights.
    pub(crate) fn setup(&self, depth: f32) -> Outcome<Setup> {
        let scene = load_scene(&self.name)?;
        let lights = self.own_lights(&scene)?;
        self.with_lights(scene, lights, depth)
    }

    /// The set-up with a view of optical depth `depth`, lit by a light of `kind`; `None` where there is none in which
    /// shadows matter.
    pub(crate) fn setup_lit(&self, depth: f32, kind: LightKind) -> Outcome<Option<Setup>> {
        let scene = load_scene(&self.name)?;
        let lights = self.lights_of(&scene, kind)?;
        lights.map(|lights| self.with_lights(scene, lights, depth)).transpose()
    }

    fn with_lights(&self, scene: Scene, lights: Vec<Light>, depth: f32) -> Outcome<Setup> {
        let wrong = |what: &str| self.wrong(what);
        let (view, camera) = if self.is_stand_in {
            let camera = scene.cameras.first().cloned().ok_or_else(|| wrong("camera"))?;
            (self.entry.stand_in_view.ok_or_else(|| wrong("stand_in_view"))?, camera)
        } else {
            let camera = self.entry.camera.as_ref().ok_or_else(|| wrong("camera"))?;
            let eye_target = (Vec3::from(camera.eye), Vec3::from(camera.target));
            let camera = Camera::look_at(eye_target.0, eye_target.1, Vec3::Y, camera.fov.to_radians())
                .map_err(Failure::program)?;
            (self.entry.view.ok_or_else(|| wrong("view"))?, camera)
        };
        let medium = Medium::homogeneous([depth / view; 3], [0.0; 3]).map_err(Failure::program)?;
        Ok(Setup { scene, camera, medium, lights, model: AirlightModel::Sun, notes: Vec::new() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::render;
    use crate::metrics;
    use crate::technique::{Options, Technique};
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
            let no_file = entry.spot_light.is_none() && entry.directional_light.is_none();
            assert!(entry.file.is_some() || no_file, "{}", entry.id);
            let no_stand_in =
                entry.stand_in_spot_light.is_none() && entry.stand_in_directional_light.is_none();
            assert!(entry.stand_in.is_some() || no_stand_in, "{}", entry.id);
        }
        assert!(Setups::load(Some(("--scenes", Path::new("/nowhere/at/all")))).is_err());
    }

    #[test]
    fn generated_scenes_stand_in_for_files_that_are_not_there() {
        let folder = tempfile::tempdir().unwrap();
        let load = || Setups::load(Some(("--scenes", folder.path()))).unwrap();
        let names = |setups: &Setups| setups.sources().iter().map(Source::title).collect::<Vec<_>>();
        let all_generated = names(&load());
        assert!(load().given() == 0 && all_generated.contains(&"procedural:fence".to_owned()));
        std::fs::write(folder.path().join("sponza_dabrovic_66k.glb"), "").unwrap();
        let one = load();
        assert!(one.given() == 1 && one.has_folder() && one.has_stand_ins());
        let titles = names(&one);
        assert!(titles.contains(&"sponza".to_owned()) && titles.contains(&"procedural:sphere".to_owned()));
        // what only ever is generated is for where nothing else is
        assert!(!titles.iter().any(|title| title == "procedural:hall" || title == "procedural:fence"));
    }

    #[test]
    fn shadows_matter_in_every_generated_set_up() {
        let setups = Setups::load(None).unwrap();
        for source in setups.sources() {
            // the large ones are checked by every reproduction, which states the same figure
            if source.name.contains("knot") || source.name.contains("street") {
                continue;
            }
            for kind in LightKind::ALL {
                check_weight(&setups, &source, kind);
            }
        }
        let hall = setups.sources().into_iter().find(|source| source.name.ends_with("hall")).unwrap();
        assert!(LightKind::ALL.into_iter().all(|kind| hall.setup_lit(1.0, kind).unwrap().is_some()));
    }

    /// Shadows take away at least a fifth of what is left, in all media.
    fn check_weight(setups: &Setups, source: &Source, kind: LightKind) {
        let mut bvh = None;
        for (medium, depth) in setups.media() {
            let Some(setup) = source.setup_lit(depth, kind).unwrap() else { return };
            assert_eq!(setup.lights.len(), 1);
            assert_eq!(LightKind::of(&setup.lights[0]), kind, "{}", source.name);
            let bvh = bvh.get_or_insert_with(|| Bvh::build(&setup.scene).unwrap());
            let mut options = Options { airlight_only: true, ..Options::new((32, 32)) };
            let shadowed = render(&setup, bvh, Technique::Exact, &options, None, "").unwrap();
            options.shadows_in_medium = false;
            let open = render(&setup, bvh, Technique::Exact, &options, None, "").unwrap();
            let weight = metrics::compare(&open.image, &shadowed.image, None, None).unwrap().rel_rmse;
            println!("{}, {}, {medium}: {weight:.3}", source.name, kind.name());
            assert!(weight >= 0.2, "{}, {}, {medium}: {weight}", source.name, kind.name());
        }
    }

    /// The set-ups of files that are not in the repository, where AIRLIGHT_SCENES names their folder.
    #[test]
    fn shadows_matter_in_the_set_ups_of_files() {
        let Some(folder) = std::env::var_os("AIRLIGHT_SCENES").map(PathBuf::from) else {
            println!("skipped: AIRLIGHT_SCENES is not set");
            return;
        };
        let setups = Setups::load(Some(("AIRLIGHT_SCENES", &folder))).unwrap();
        for source in setups.sources().iter().filter(|source| !source.is_stand_in) {
            for kind in LightKind::ALL {
                check_weight(&setups, source, kind);
            }
        }
    }
}
