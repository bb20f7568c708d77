//! Exact pictures, kept between runs by a hash of what they depend on.
//!
//! They take the larger part of an experiment's time and do not change between its runs. What one depends on is the program
//! that computes it and what the exact techniques read of their stage; each build therefore has a folder of its own beside the
//! program, and the folders of other builds are removed. What cannot be kept or read back is computed: nothing fails for want of
//! it.

use std::fs;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::measure::picture;
use crate::airlight::{self, Stage};
use crate::failure::Outcome;
use crate::image_file::Image;
use crate::output_file;
use crate::technique::Technique;

/// Beside the program, and in it one folder for each build.
const FOLDER: &str = "airlight-references";

/// What a reader must know of their times.
pub(super) const NOTE: &str = "Exact pictures are kept between runs of one build: the times beside them are those of the run that computed them.";

/// Where exact pictures are kept.
#[derive(Debug, Clone, Default)]
pub(crate) struct References {
    /// Without, each is computed.
    folder: Option<PathBuf>,
}

/// An exact picture.
#[derive(Debug, Clone)]
pub(super) struct ExactPicture {
    pub(super) image: Image,
    /// What computing it took, in the run that did; units: ms.
    pub(super) ms: f64,
}

impl References {
    /// Those of this build, beside the program; those of earlier builds go.
    pub(crate) fn of_this_build() -> Self {
        let folder = std::env::current_exe().ok().and_then(|program| build_folder(&program));
        if folder.is_none() {
            tracing::debug!("exact pictures are not kept: there is no folder for them");
        }
        Self { folder }
    }

    /// The airlight of an exact technique, read back if an earlier run left it.
    pub(super) fn picture(&self, stage: &Stage<'_>, technique: Technique) -> Outcome<ExactPicture> {
        let path = self.folder.as_ref().map(|folder| folder.join(key(stage, technique)));
        if let Some(kept) = path.as_ref().and_then(|path| read(path, stage.options.size)) {
            return Ok(kept);
        }
        let airlight = stage.run(technique)?;
        let kept = ExactPicture { image: picture(stage.options.size, &airlight), ms: airlight.ms };
        if let Some(path) = path
            && let Err(error) = output_file::write_bytes(&path, &bytes(&kept))
        {
            tracing::debug!("an exact picture is not kept: {error}");
        }
        Ok(kept)
    }
}

/// The folder of the build that `program` is, and no other beside it.
fn build_folder(program: &Path) -> Option<PathBuf> {
    let all = program.parent()?.join(FOLDER);
    let own = all.join(hex(&Sha256::digest(fs::read(program).ok()?)));
    for other in fs::read_dir(&all).into_iter().flatten().flatten().map(|entry| entry.path()) {
        if other != own {
            // another run may be removing it, too
            _ = fs::remove_dir_all(other);
        }
    }
    fs::create_dir_all(&own).ok()?;
    Some(own)
}

/// A hash of everything that an exact technique's picture depends on but the program.
fn key(stage: &Stage<'_>, technique: Technique) -> String {
    let Stage { setup, bvh, options, rays, maps, further: _, tick: _ } = stage;
    let mut hash = Sha256::new();
    // numbers print as the shortest text that reads back as the same
    let (settings, sampling) = (airlight::settings(setup, options), technique.sampling(options.sampling));
    hash.update(format!("{technique:?} {settings:?} {sampling:?} {:?} {:?} ", options.size, setup.camera));
    hash.update(format!("{:?} {:?} {:?}", setup.medium, setup.lights, setup.scene.materials));
    for triangle in bvh.triangles() {
        for corner in triangle.corners {
            hash.update(bytemuck::bytes_of(&corner.to_array()));
        }
        hash.update(triangle.material.to_le_bytes());
    }
    for index in 0..rays.ends.len() {
        hash.update(rays.end(index, f64::INFINITY).to_le_bytes());
    }
    if technique == Technique::Exact {
        return hex(&hash.finalize());
    }
    hash.update(format!("{:?}", options.map.surface));
    for map in &maps.maps {
        match map {
            None => hash.update("no map"),
            Some(map) => {
                hash.update(format!("{:?} {:?} {:?}", map.projection(), map.size(), map.outside()));
                hash.update(bytemuck::cast_slice(map.depths()));
            }
        }
    }
    hex(&hash.finalize())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Time and pixels as a file holds them, after a hash of them.
fn bytes(kept: &ExactPicture) -> Vec<u8> {
    let mut bytes = kept.ms.to_le_bytes().to_vec();
    bytes.extend(kept.image.pixels.iter().flatten().flat_map(|value| value.to_le_bytes()));
    let hash = Sha256::digest(&bytes);
    bytes.splice(..0, hash);
    bytes
}

/// What a file holds, if it is whole.
fn read(path: &Path, (width, height): (u32, u32)) -> Option<ExactPicture> {
    let bytes = fs::read(path).ok()?;
    let (hash, content) = bytes.split_first_chunk::<32>()?;
    if Sha256::digest(content)[..] != hash[..] {
        return None;
    }
    let (ms, values) = content.split_first_chunk::<8>()?;
    let (pixels, rest) = values.as_chunks::<12>();
    if !rest.is_empty() || pixels.len() as u64 != u64::from(width) * u64::from(height) {
        return None;
    }
    let pixel = |bytes: &[u8; 12]| {
        let [r, g, b] = [0, 4, 8].map(|at| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        [r, g, b].map(f32::from_le_bytes)
    };
    let pixels = pixels.iter().map(pixel).collect();
    Some(ExactPicture { image: Image { width, height, pixels }, ms: f64::from_le_bytes(*ms) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::measure::base;
    use crate::maps::{MapSurface, Maps};
    use crate::scene_args::SceneArgs;
    use crate::technique::Options;
    use crate::view_rays::ViewRays;
    use scene::{AirlightModel, Bvh, Light};

    struct Scene {
        setup: crate::scene_args::Setup,
        bvh: Bvh,
        rays: ViewRays,
        maps: Maps,
        options: Options,
    }

    impl Scene {
        fn new(side: u32) -> Self {
            let setup = SceneArgs::default().resolve("procedural:sphere").unwrap();
            let (bvh, options) = (Bvh::build(&setup.scene).unwrap(), base(side, 32));
            let rays = ViewRays::trace(&setup.camera, &bvh, options.size);
            let maps = Maps::draw(&setup, &options.map).unwrap();
            Self { setup, bvh, rays, maps, options }
        }

        fn stage(&self) -> Stage<'_> {
            let Self { setup, bvh, rays, maps, options } = self;
            Stage { setup, bvh, options, rays, maps, further: &[], tick: &|_| () }
        }

        fn key(&self, technique: Technique) -> String {
            key(&self.stage(), technique)
        }
    }

    #[test]
    fn whatever_changes_a_picture_changes_its_key() {
        let technique = Technique::ExactShadowMap;
        let usual = Scene::new(8).key(technique);
        assert_eq!(usual, Scene::new(8).key(technique), "the same anew");
        assert_ne!(usual, Scene::new(8).key(Technique::Exact));
        // what is exact on the geometry does not look at the map
        let mut other_map = Scene::new(8);
        (other_map.options.map.side, other_map.options.samples) = (64, Some(3));
        assert_eq!(other_map.key(Technique::Exact), Scene::new(8).key(Technique::Exact));
        type Change = fn(&mut Scene);
        let changes: [(&str, Change); 10] = [
            ("size", |scene| *scene = Scene::new(9)),
            ("shadows", |scene| scene.options.shadows_in_medium = false),
            ("camera", |scene| scene.setup.camera.position.x += 1e-3),
            ("medium", |scene| scene.setup.medium.emission[1] += 1e-3),
            ("light", |scene| match &mut scene.setup.lights[0] {
                Light::Point(light) => light.intensity.x += 1e-3,
                Light::Spot(light) => light.intensity.x += 1e-3,
                Light::Directional(light) => light.irradiance.x += 1e-3,
            }),
            ("map", |scene| scene.maps = Maps::none(1)),
            ("model", |scene| scene.setup.model = AirlightModel::HoffmanPreetham),
            ("surface", |scene| scene.options.map.surface = MapSurface::Linear),
            ("a mesh", |scene| {
                let other = SceneArgs::default().resolve("procedural:wall").unwrap();
                scene.bvh = Bvh::build(&other.scene).unwrap();
            }),
            ("where rays end", |scene| scene.rays = scene.rays.up_to(1.0)),
        ];
        for (what, change) in changes {
            let mut scene = Scene::new(8);
            change(&mut scene);
            assert_ne!(usual, scene.key(technique), "{what}");
        }
    }

    #[test]
    fn pictures_are_read_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let references = References { folder: Some(folder.path().to_owned()) };
        let scene = Scene::new(8);
        let first = references.picture(&scene.stage(), Technique::Exact).unwrap();
        let path = folder.path().join(scene.key(Technique::Exact));
        let again = references.picture(&scene.stage(), Technique::Exact).unwrap();
        assert_eq!((first.image.pixels, first.ms), (again.image.pixels.clone(), again.ms));
        // it is the file that is read: another time in it comes back
        let other = bytes(&ExactPicture { ms: 12.5, ..again.clone() });
        fs::write(&path, &other).unwrap();
        assert_eq!(references.picture(&scene.stage(), Technique::Exact).unwrap().ms, 12.5);
        // cut short or with other content, it is computed anew and mended
        let mut changed = other.clone();
        changed[100] ^= 1;
        for spoilt in [&other[..other.len() - 5], &changed] {
            fs::write(&path, spoilt).unwrap();
            let mended = references.picture(&scene.stage(), Technique::Exact).unwrap();
            assert!(mended.ms != 12.5 && mended.image.pixels == again.image.pixels);
            assert_eq!(fs::read(&path).unwrap().len(), other.len());
        }
    }

    #[test]
    fn a_folder_that_cannot_be_is_no_failure() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let references = References { folder: Some(file.path().join("no folder")) };
        assert!(references.picture(&Scene::new(8).stage(), Technique::Exact).is_ok());
        assert!(build_folder(Path::new("/nowhere/at all")).is_none());
    }

    #[test]
    fn another_build_has_another_folder() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("program");
        fs::write(&program, "a build").unwrap();
        let first = build_folder(&program).unwrap();
        fs::write(first.join("picture"), "kept").unwrap();
        assert_eq!(build_folder(&program).unwrap(), first);
        assert!(first.join("picture").exists());
        fs::write(&program, "the next build").unwrap();
        assert_ne!(build_folder(&program).unwrap(), first);
        assert!(!first.exists());
    }
}
