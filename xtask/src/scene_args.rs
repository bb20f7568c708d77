//! The flags that choose what is rendered: scene, camera, medium, lights.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use clap::{Args, ValueEnum};
use glam::Vec3;
use media_math::PhaseFunction;
use scene::import::{ColorSpace, load_gltf, load_light_texture};
use scene::{
    AirlightModel, Camera, DirectionalLight, Light, Medium, PointLight, RgbMedium, Scene, SpotLight,
    TextureFilter,
};

use crate::failure::{Failure, Outcome};

/// Prefix of the name of a generated scene.
const PROCEDURAL: &str = "procedural:";

/// Vertical field of view where none is given; units: degrees.
const DEFAULT_FOV: f32 = 45.0;

/// Camera, medium and lights; each given flag replaces what the file says.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct SceneArgs {
    /// Camera of the file, by name or index.
    #[arg(long, value_name = "NAME|INDEX", allow_hyphen_values = true, conflicts_with_all = ["eye", "target"])]
    pub(crate) camera: Option<String>,
    /// Where the camera is.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "target")]
    pub(crate) eye: Option<Triple>,
    /// What the camera looks at.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "eye")]
    pub(crate) target: Option<Triple>,
    /// What points upwards in the picture.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "eye")]
    pub(crate) up: Option<Triple>,
    /// Vertical field of view in degrees; 45 where the file gives none.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub(crate) fov: Option<f32>,
    /// Scattering coefficient in 1/m.
    #[arg(long, value_name = "R[,G,B]", allow_hyphen_values = true)]
    pub(crate) sigma_s: Option<Colour>,
    /// Absorption coefficient in 1/m.
    #[arg(long, value_name = "R[,G,B]", allow_hyphen_values = true)]
    pub(crate) sigma_a: Option<Colour>,
    /// isotropic, rayleigh, hg:G or rayleigh-mie:G:FRACTION (share of Rayleigh).
    #[arg(long, allow_hyphen_values = true)]
    pub(crate) phase: Option<Phase>,
    /// How airlight of a point or spot light is formed.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) model: Model,
    /// A point light: position and intensity in W/sr; repeatable.
    #[arg(long, value_name = "X,Y,Z:R[,G,B]", allow_hyphen_values = true)]
    pub(crate) point_light: Vec<PointSpec>,
    /// A spot light: position, target, half-angles in degrees, intensity in W/sr; repeatable.
    #[arg(long, value_name = "X,Y,Z:TX,TY,TZ:INNER:OUTER:R[,G,B]", allow_hyphen_values = true)]
    pub(crate) spot_light: Vec<SpotSpec>,
    /// A directional light: the way it travels and its irradiance in W/m2; repeatable.
    #[arg(long, value_name = "DX,DY,DZ:R[,G,B]", allow_hyphen_values = true)]
    pub(crate) directional_light: Vec<DirectionalSpec>,
    /// A picture in front of every spot light.
    #[arg(long, value_name = "PATH")]
    pub(crate) light_texture: Option<PathBuf>,
}

/// Everything that is rendered, with every default filled in.
#[derive(Debug, Clone)]
pub(crate) struct Setup {
    pub(crate) scene: Scene,
    pub(crate) camera: Camera,
    pub(crate) medium: Medium,
    pub(crate) lights: Vec<Light>,
    pub(crate) model: AirlightModel,
    /// What was left out of the file, and which defaults were taken; said once nothing can be refused any more.
    pub(crate) notes: Vec<String>,
}

impl Setup {
    /// The camera, and the others of the scene.
    pub(crate) fn cameras(&self) -> Vec<Camera> {
        let others = self.scene.cameras.iter().filter(|other| **other != self.camera);
        std::iter::once(&self.camera).chain(others).cloned().collect()
    }

    /// Says the notes on stderr.
    pub(crate) fn say_notes(&self) {
        for note in &self.notes {
            tracing::info!("{note}");
        }
    }
}

/// `--model`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Model {
    /// 1/d2 and extinction on the light's way (Sun et al.).
    #[default]
    Sun,
    /// Neither (Hoffman and Preetham).
    HoffmanPreetham,
}

impl From<Model> for AirlightModel {
    fn from(model: Model) -> Self {
        match model {
            Model::Sun => Self::Sun,
            Model::HoffmanPreetham => Self::HoffmanPreetham,
        }
    }
}

/// Reads a scene from a file, or generates `procedural:NAME`.
pub(crate) fn load_scene(name: &str) -> Outcome<Scene> {
    match name.strip_prefix(PROCEDURAL) {
        Some(generated) => scene::procedural::generate(generated).map_err(Failure::input),
        None => load_gltf(Path::new(name)).map_err(Failure::input),
    }
}

impl SceneArgs {
    /// The scene called `name` with these flags applied; every default that is taken is noted.
    pub(crate) fn resolve(&self, name: &str) -> Outcome<Setup> {
        let scene = load_scene(name)?;
        self.apply(name, scene)
    }

    /// `scene` with these flags applied.
    pub(crate) fn apply(&self, name: &str, scene: Scene) -> Outcome<Setup> {
        let mut notes: Vec<String> = scene.notes.iter().map(|note| format!("{name}: {note}")).collect();
        let camera = self.camera(name, &scene, &mut notes)?;
        let lights = self.lights(name, &scene, &mut notes)?;
        let medium = self.medium(name, &scene, &mut notes)?;
        Ok(Setup { camera, lights, medium, model: self.model.into(), notes, scene })
    }

    fn camera(&self, name: &str, scene: &Scene, notes: &mut Vec<String>) -> Outcome<Camera> {
        let fov = self.fov.map(f32::to_radians);
        if let (Some(eye), Some(target)) = (self.eye, self.target) {
            let up = self.up.map_or(Vec3::Y, |up| up.0);
            return Camera::look_at(eye.0, target.0, up, fov.unwrap_or(DEFAULT_FOV.to_radians()))
                .map_err(|e| Failure::input(format!("--eye, --target, --up, --fov: {e}")));
        }
        if let Some(fov) = self.fov
            && !(fov > 0.0 && fov < 180.0)
        {
            return Err(Failure::input(format!("--fov {fov}: must lie between 0 and 180 degrees")));
        }
        let mut camera = match &self.camera {
            Some(wanted) => {
                let by_name = scene.cameras.iter().find(|camera| camera.name.as_deref() == Some(wanted));
                let by_index = || wanted.parse().ok().and_then(|i: usize| scene.cameras.get(i));
                by_name.or_else(by_index).cloned().ok_or_else(|| {
                    let known: Vec<String> = scene
                        .cameras
                        .iter()
                        .enumerate()
                        .map(|(i, camera)| camera.name.clone().unwrap_or_else(|| i.to_string()))
                        .collect();
                    Failure::input(format!("--camera {wanted}: {name} has {}", list(&known, "no camera")))
                })?
            }
            None => match scene.cameras.first() {
                Some(camera) => camera.clone(),
                None => {
                    let camera = Camera::framing(&scene.bounds(), fov.unwrap_or(DEFAULT_FOV.to_radians()));
                    let p = camera.position;
                    notes.push(format!(
                        "{name} has no camera: framing the scene from {},{},{}",
                        p.x, p.y, p.z
                    ));
                    camera
                }
            },
        };
        if let Some(fov) = fov {
            camera.fov_y = fov;
        }
        Ok(camera)
    }

    fn medium(&self, name: &str, scene: &Scene, notes: &mut Vec<String>) -> Outcome<Medium> {
        let mut medium = match (&scene.medium, self.sigma_s, self.sigma_a) {
            (Some(medium), ..) => medium.clone(),
            (None, None, None) => {
                let diagonal = scene.bounds().diagonal();
                let sigma_s = if diagonal > 0.0 { 1.0 / diagonal } else { 0.1 };
                notes.push(format!("{name} has no medium: sigma_s = {sigma_s} per metre, isotropic"));
                Medium::homogeneous([sigma_s; 3], [0.0; 3]).map_err(Failure::input)?
            }
            (None, ..) => Medium::homogeneous([0.0; 3], [0.0; 3]).map_err(Failure::input)?,
        };
        if self.sigma_s.is_some() || self.sigma_a.is_some() {
            let sigma_s = self.sigma_s.map_or(medium.coefficients.sigma_s(), |colour| colour.0);
            let sigma_a = self.sigma_a.map_or(medium.coefficients.sigma_a(), |colour| colour.0);
            medium.coefficients = RgbMedium::new(sigma_s, sigma_a)
                .map_err(|e| Failure::input(format!("--sigma-s, --sigma-a: {e}")))?;
        }
        if let Some(phase) = self.phase {
            medium.phase = phase.0;
        }
        Ok(medium)
    }

    fn lights(&self, name: &str, scene: &Scene, notes: &mut Vec<String>) -> Outcome<Vec<Light>> {
        let mut lights: Vec<Light> = Vec::new();
        lights.extend(self.point_light.iter().map(|spec| Light::Point(spec.0)));
        lights.extend(self.spot_light.iter().map(|spec| Light::Spot(spec.0.clone())));
        lights.extend(self.directional_light.iter().map(|spec| Light::Directional(spec.0)));
        if lights.is_empty() {
            lights.clone_from(&scene.lights);
        }
        if lights.is_empty() {
            let light = default_light(scene)?;
            let (p, i) = (light.position, light.intensity.x);
            notes.push(format!("{name} has no light: a point light of {i} W/sr at {},{},{}", p.x, p.y, p.z));
            lights.push(Light::Point(light));
        }
        if let Some(path) = &self.light_texture {
            let texture =
                load_light_texture(path, TextureFilter::Linear, ColorSpace::Srgb).map_err(Failure::input)?;
            let texture = Arc::new(texture);
            let mut used = false;
            for light in &mut lights {
                if let Light::Spot(spot) = light {
                    spot.texture = Some(Arc::clone(&texture));
                    used = true;
                }
            }
            if !used {
                let path = path.display();
                return Err(Failure::input(format!("--light-texture {path}: there is no spot light")));
            }
        }
        Ok(lights)
    }
}

/// One white point light above and beside the scene, bright enough to see by.
fn default_light(scene: &Scene) -> Outcome<PointLight> {
    let bounds = scene.bounds();
    let (center, size) =
        if bounds.is_empty() { (Vec3::ZERO, 1.0) } else { (bounds.center(), bounds.diagonal()) };
    let size = size.max(1e-6);
    let position = center + size * Vec3::new(0.5, 0.6, 0.3);
    PointLight::new(position, Vec3::splat(10.0 * size * size)).map_err(Failure::input)
}

fn list(known: &[String], none: &str) -> String {
    if known.is_empty() { none.to_owned() } else { known.join(", ") }
}

/// `X,Y,Z`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triple(pub(crate) Vec3);

impl FromStr for Triple {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match numbers(text)?[..] {
            [x, y, z] => Ok(Self(Vec3::new(x, y, z))),
            _ => Err("expected three numbers, X,Y,Z".into()),
        }
    }
}

/// `R[,G,B]`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Colour(pub(crate) [f32; 3]);

impl FromStr for Colour {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match numbers(text)?[..] {
            [grey] => Ok(Self([grey; 3])),
            [r, g, b] => Ok(Self([r, g, b])),
            _ => Err("expected one number or three, R[,G,B]".into()),
        }
    }
}

/// Comma-separated finite numbers.
fn numbers(text: &str) -> Result<Vec<f32>, String> {
    text.split(',').map(number).collect()
}

fn number(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("{:?} is not finite", text.trim())),
        Err(_) => Err(format!("{:?} is not a number", text.trim())),
    }
}

/// The parts of `text` between colons, exactly as many as `N`.
fn parts<const N: usize>(text: &str) -> Result<[&str; N], String> {
    let parts: Vec<&str> = text.split(':').collect();
    let count = parts.len();
    parts.try_into().map_err(|_| format!("expected {N} parts separated by colons, got {count}"))
}

fn vector(text: &str) -> Result<Vec3, String> {
    text.parse::<Triple>().map(|triple| triple.0)
}

fn colour(text: &str) -> Result<Vec3, String> {
    text.parse::<Colour>().map(|colour| colour.0.into())
}

/// `--point-light`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PointSpec(PointLight);

impl FromStr for PointSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [position, intensity] = parts(text)?;
        PointLight::new(vector(position)?, colour(intensity)?).map(Self).map_err(|e| e.to_string())
    }
}

/// `--spot-light`.
#[derive(Debug, Clone)]
pub(crate) struct SpotSpec(SpotLight);

impl FromStr for SpotSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [position, target, inner, outer, intensity] = parts(text)?;
        let (position, target) = (vector(position)?, vector(target)?);
        let (inner, outer) = (number(inner)?.to_radians(), number(outer)?.to_radians());
        SpotLight::new(position, target - position, inner, outer, colour(intensity)?)
            .map(Self)
            .map_err(|e| e.to_string())
    }
}

/// `--directional-light`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DirectionalSpec(DirectionalLight);

impl FromStr for DirectionalSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [direction, irradiance] = parts(text)?;
        DirectionalLight::new(vector(direction)?, colour(irradiance)?).map(Self).map_err(|e| e.to_string())
    }
}

/// `--phase`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Phase(pub(crate) PhaseFunction<f32>);

impl FromStr for Phase {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fields: Vec<&str> = text.split(':').collect();
        match fields[..] {
            ["isotropic"] => Ok(PhaseFunction::ISOTROPIC),
            ["rayleigh"] => PhaseFunction::rayleigh_mie(0.0, 1.0).map_err(|e| e.to_string()),
            ["hg", g] => PhaseFunction::henyey_greenstein(number(g)?).map_err(|e| e.to_string()),
            ["rayleigh-mie", g, fraction] => {
                PhaseFunction::rayleigh_mie(number(g)?, number(fraction)?).map_err(|e| e.to_string())
            }
            _ => Err("expected isotropic, rayleigh, hg:G or rayleigh-mie:G:FRACTION".into()),
        }
        .map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_parse_with_minus_signs() {
        assert_eq!("-1,2.5,-3e2".parse::<Triple>().unwrap().0, Vec3::new(-1.0, 2.5, -300.0));
        assert_eq!("0.5".parse::<Colour>().unwrap().0, [0.5; 3]);
        assert!("1,2".parse::<Colour>().is_err() && "1,2,nan".parse::<Triple>().is_err());
        assert!("1,2,inf".parse::<Triple>().is_err() && "".parse::<Triple>().is_err());
    }

    #[test]
    fn lights_parse() {
        assert!("0,1,2:5".parse::<PointSpec>().is_ok());
        assert!("0,1,2:-5".parse::<PointSpec>().is_err());
        assert!("0,1,2".parse::<PointSpec>().is_err());
        let spot = "0,1,2:0,0,2:10:20:1,2,3".parse::<SpotSpec>().unwrap().0;
        assert_eq!((spot.direction, spot.outer), (Vec3::NEG_Y, 20_f32.to_radians()));
        assert!("0,1,2:0,0,2:20:10:1".parse::<SpotSpec>().is_err());
        assert!("0,1,2:0,1,2:10:20:1".parse::<SpotSpec>().is_err());
        assert!("0,0,0:1".parse::<DirectionalSpec>().is_err());
    }

    #[test]
    fn phases_parse() {
        for good in ["isotropic", "rayleigh", "hg:-0.5", "hg:0", "rayleigh-mie:0.7:0.25"] {
            assert!(good.parse::<Phase>().is_ok(), "{good}");
        }
        for bad in ["hg", "hg:1", "hg:nan", "hg:-1.5", "mie", "rayleigh-mie:0.5", "rayleigh-mie:0.5:2"] {
            assert!(bad.parse::<Phase>().is_err(), "{bad}");
        }
    }
}
