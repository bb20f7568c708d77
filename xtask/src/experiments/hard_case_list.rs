//! The scenes on which techniques fail first.

use glam::Vec3;
use media_math::PhaseFunction;
use scene::{
    AirlightModel, Camera, DirectionalLight, Light, Material, Medium, Mesh, PointLight, Scene, SpotLight,
};

use crate::failure::{Failure, Outcome};
use crate::scene_args::{Setup, load_scene};

/// How much of a list a case belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Weight {
    /// Also where there is little time.
    Always,
    /// In every list but the shortest.
    Usual,
    /// Where there is much time.
    Large,
}

/// A case: its name, and how it is set up.
pub(super) struct Case {
    pub(super) name: String,
    pub(super) weight: Weight,
    pub(super) build: Box<dyn Fn() -> Outcome<Setup>>,
}

/// Where the lamp of the plain set-up is; units: m.
const LAMP: Vec3 = Vec3::new(0.6, 2.0, -0.4);

/// Where its camera is; units: m.
const EYE: Vec3 = Vec3::new(0.3, 0.4, 4.0);

fn point(position: Vec3) -> Outcome<Light> {
    PointLight::new(position, Vec3::splat(10.0)).map(Light::Point).map_err(Failure::program)
}

/// A spot with half-angles in degrees.
fn spot(position: Vec3, direction: Vec3, [inner, outer]: [f32; 2]) -> Outcome<Light> {
    let (inner, outer) = (inner.to_radians(), outer.to_radians());
    let light = SpotLight::new(position, direction, inner, outer, Vec3::splat(20.0));
    light.map(Light::Spot).map_err(Failure::program)
}

fn sun(direction: Vec3) -> Outcome<Light> {
    DirectionalLight::new(direction, Vec3::ONE).map(Light::Directional).map_err(Failure::program)
}

fn fog(sigma_s: f32) -> Outcome<Medium> {
    Medium::homogeneous([sigma_s; 3], [0.0; 3]).map_err(Failure::program)
}

fn look(eye: Vec3, target: Vec3) -> Outcome<Camera> {
    Camera::look_at(eye, target, Vec3::Y, 0.8).map_err(Failure::program)
}

/// The twelve triangles of a box around the origin, two after two by side.
fn cuboid(half: f32) -> Outcome<Mesh> {
    let corner = |i: u32| half * Vec3::new(sign(i), sign(i >> 1), sign(i >> 2));
    let triangles = hybrid_march::bounding_box(&scene::Aabb::around((0..8).map(corner)));
    soup(&triangles)
}

fn sign(bit: u32) -> f32 {
    if bit & 1 == 1 { 1.0 } else { -1.0 }
}

fn soup(triangles: &[[Vec3; 3]]) -> Outcome<Mesh> {
    let positions = triangles.iter().flatten().copied().collect();
    let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh::new(positions, indices, 0).map_err(Failure::program)
}

/// Triangles, seen from the front and lit from above in thin fog.
fn block_of(triangles: &[[Vec3; 3]]) -> Outcome<Setup> {
    let scene =
        Scene { meshes: vec![soup(triangles)?], materials: vec![Material::default()], ..Scene::default() };
    Ok(Setup {
        scene,
        camera: look(EYE, Vec3::ZERO)?,
        medium: fog(0.1)?,
        lights: vec![point(LAMP)?],
        model: AirlightModel::Sun,
        notes: Vec::new(),
    })
}

fn box_triangles() -> Outcome<Vec<[Vec3; 3]>> {
    Ok(cuboid(0.5)?.corners().collect())
}

/// A box of 1 m at the origin.
fn block() -> Outcome<Setup> {
    block_of(&box_triangles()?)
}

fn generated(name: &str) -> Outcome<Setup> {
    let scene = load_scene(&format!("procedural:{name}"))?;
    let lacks = || Failure::program(format!("{name} lacks a camera or a medium"));
    Ok(Setup {
        camera: scene.cameras.first().cloned().ok_or_else(lacks)?,
        medium: scene.medium.clone().ok_or_else(lacks)?,
        lights: scene.lights.clone(),
        scene,
        model: AirlightModel::Sun,
        notes: Vec::new(),
    })
}

/// The same scene in another unit of length: intensities and optical depths are kept.
fn scaled(mut setup: Setup, scale: f32) -> Outcome<Setup> {
    for mesh in &mut setup.scene.meshes {
        let positions = mesh.positions().iter().map(|p| *p * scale).collect();
        *mesh = Mesh::new(positions, mesh.triangles().to_vec(), mesh.material).map_err(Failure::program)?;
    }
    setup.camera.position *= scale;
    for light in &mut setup.lights {
        match light {
            Light::Point(light) => light.position *= scale,
            Light::Spot(light) => light.position *= scale,
            Light::Directional(_) => {}
        }
    }
    let sigma = setup.medium.coefficients.sigma_s().map(|s| s / scale);
    setup.medium = Medium::homogeneous(sigma, [0.0; 3]).map_err(Failure::program)?;
    Ok(setup)
}

/// Straight at or away from a light on the axis, exact in f32.
fn on_axis(target: f32, light: f32, g: f32) -> Outcome<Setup> {
    let mut setup = block()?;
    setup.camera = look(Vec3::new(0.0, 0.0, 4.0), Vec3::new(0.0, 0.0, target))?;
    setup.lights = vec![point(Vec3::new(0.0, 0.0, light))?];
    if g != 0.0 {
        setup.medium.phase = PhaseFunction::henyey_greenstein(g).map_err(Failure::program)?;
    }
    Ok(setup)
}

/// The box with other lights.
fn lit_by(lights: Vec<Light>) -> Outcome<Setup> {
    Ok(Setup { lights, ..block()? })
}

/// The box with another camera.
fn seen(eye: Vec3, target: Vec3) -> Outcome<Setup> {
    Ok(Setup { camera: look(eye, target)?, ..block()? })
}

/// Slats in another medium; the picture is some 5 m deep.
fn slats_in(medium: Medium) -> Outcome<Setup> {
    Ok(Setup { medium, ..generated("slats")? })
}

fn cone(half_angle: f32) -> Outcome<Setup> {
    let position = Vec3::new(-0.3, 2.5, -1.5);
    let light = spot(position, Vec3::new(0.3, -1.5, 2.5), [0.0, half_angle])?;
    Ok(Setup { lights: vec![light], ..generated("slats")? })
}

/// A camera relative to the volume of a spot of 40° about its axis, which shines down past the box.
///
/// `place` is in units of the volume: right and down across it, from −1 at one wall to 1 at the other, and the depth in m.
fn in_volume(place: Vec3, target: Vec3) -> Outcome<Setup> {
    let lamp = spot(Vec3::new(0.3, 2.0, 0.0), Vec3::NEG_Y, [20.0, 40.0])?;
    let Light::Spot(light) = &lamp else { return Err(Failure::program("a spot that is none")) };
    let wide = light.outer.tan();
    let at =
        |p: Vec3| light.position + p.z * (light.direction + wide * (p.x * light.right - p.y * light.top()));
    Ok(Setup {
        camera: Camera::look_at(at(place), at(target), Vec3::Z, 0.8).map_err(Failure::program)?,
        lights: vec![lamp],
        ..block()?
    })
}

/// A camera so near to the top of the box, which bounds the light of the lamp above it, that the near plane of any renderer
/// lies in it.
fn above_top(height: f32, target: Vec3) -> Outcome<Setup> {
    seen(Vec3::new(0.1, 0.5 + height, 0.2), target)
}

/// Lights of all kinds around the box.
fn many(count: u32) -> Outcome<Setup> {
    let light = |i: u32| {
        let (angle, height) = (0.7 * i as f32, 1.0 + 0.1 * i as f32);
        let position = Vec3::new(angle.cos(), height, 2.0 * angle.sin());
        match i % 3 {
            0 => point(position),
            1 => spot(position, -position, [17.0, 46.0]),
            _ => sun(-position),
        }
    };
    lit_by((0..count).map(light).collect::<Outcome<_>>()?)
}

/// Three sheets on one edge, and a second box that shares an edge with the first.
fn non_manifold() -> Outcome<Setup> {
    let mut triangles = box_triangles()?;
    let other: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|p| p + Vec3::new(1.0, 1.0, 0.0))).collect();
    triangles.extend(other);
    let (a, b) = (Vec3::new(-0.5, 0.5, 0.5), Vec3::new(0.5, 0.5, 0.5));
    for tip in [Vec3::new(0.0, 1.2, 0.9), Vec3::new(0.0, 1.0, 1.4), Vec3::new(0.0, 0.4, 1.6)] {
        triangles.push([a, b, tip]);
    }
    block_of(&triangles)
}

fn slivers() -> Vec<[Vec3; 3]> {
    let [o, x, xx] = [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X];
    vec![[o, o, o], [o, x, xx], [LAMP, LAMP, EYE], [LAMP, EYE, EYE], [o, LAMP, LAMP]]
}

/// A million triangles: hills under a lamp.
fn million() -> Outcome<Setup> {
    const SIDE: u32 = 708;
    let at = |i: u32, j: u32| {
        let [x, z] = [i, j].map(|k| 4.0 * (k as f32 / SIDE as f32 - 0.5));
        Vec3::new(x, 0.35 * ((5.0 * x).sin() * (4.0 * z).cos()) + 0.02 * (90.0 * x).sin() - 0.3, z)
    };
    let triangles: Vec<[Vec3; 3]> = (0..SIDE * SIDE)
        .flat_map(|cell| {
            let (i, j) = (cell % SIDE, cell / SIDE);
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
            [[a, c, b], [b, c, d]]
        })
        .collect();
    let mut setup = block_of(&triangles)?;
    setup.lights = vec![point(Vec3::new(0.3, 0.35, -1.2))?];
    Ok(setup)
}

/// All cases.
pub(super) fn cases() -> Vec<Case> {
    use Weight::{Always, Large, Usual};
    let mut cases = Vec::new();
    let mut add = |weight, name: &str, build: Box<dyn Fn() -> Outcome<Setup>>| {
        cases.push(Case { name: name.into(), weight, build });
    };
    let forward = || Ok::<_, Failure>(block()?.camera.forward);
    add(Always, "camera at a point light", Box::new(|| lit_by(vec![point(EYE)?])));
    add(
        Usual,
        "camera at a spot light",
        Box::new(move || lit_by(vec![spot(EYE, forward()?, [11.0, 17.0])?])),
    );
    add(
        Usual,
        "camera at a spot light that shines backwards",
        Box::new(move || lit_by(vec![spot(EYE, -forward()?, [11.0, 17.0])?])),
    );
    add(
        Always,
        "camera inside a shadow volume",
        Box::new(|| seen(Vec3::new(-0.48, -1.6, 0.32), Vec3::new(1.0, 0.0, 2.0))),
    );
    add(
        Always,
        "camera on an edge of a shadow volume",
        Box::new(|| seen(Vec3::new(-1.05, -0.25, 0.95), Vec3::new(0.2, -0.6, -0.5))),
    );
    add(Usual, "camera inside a box, light outside", Box::new(|| seen(Vec3::ZERO, Vec3::NEG_Z)));
    add(
        Usual,
        "camera and light inside a box",
        Box::new(|| {
            let lights = vec![point(Vec3::new(0.1, 0.2, -0.3))?];
            Ok(Setup { lights, ..seen(Vec3::ZERO, Vec3::NEG_Z)? })
        }),
    );
    add(
        Usual,
        "camera outside of a spot's cone",
        Box::new(|| lit_by(vec![spot(LAMP, Vec3::new(-1.0, -1.0, -0.3), [20.0, 30.0])?])),
    );
    add(Always, "straight at the light, a box behind it", Box::new(|| on_axis(3.0, 1.0, 0.0)));
    add(Usual, "straight at the light, g = 0.9", Box::new(|| on_axis(3.0, 1.0, 0.9)));
    add(Usual, "straight at the light, a box before it", Box::new(|| on_axis(3.0, -1.0, 0.0)));
    add(Usual, "straight away from the light, a box between", Box::new(|| on_axis(5.0, -1.0, 0.0)));
    add(Usual, "straight away from the light", Box::new(|| on_axis(5.0, 1.0, 0.0)));
    add(Always, "light 0.1 mm before a wall", Box::new(|| generated("wall")));
    add(Usual, "light in the surface of a box", Box::new(|| lit_by(vec![point(Vec3::new(0.0, 0.5, 0.0))?])));
    add(Usual, "light on a corner of a box", Box::new(|| lit_by(vec![point(Vec3::splat(0.5))?])));
    add(Always, "light inside a lampshade", Box::new(|| generated("lampshade")));
    add(Always, "sun along the view", Box::new(move || lit_by(vec![sun(forward()?)?])));
    add(Usual, "sun against the view", Box::new(move || lit_by(vec![sun(-forward()?)?])));
    add(Usual, "sun grazing the top of a box", Box::new(|| lit_by(vec![sun(Vec3::new(1.0, -1e-6, 0.0))?])));
    add(
        Usual,
        "lamp in the plane of the top of a box",
        Box::new(|| lit_by(vec![point(Vec3::new(-1.5, 0.5, 0.3))?])),
    );
    add(Usual, "an open mesh: a box without its front", Box::new(|| block_of(&box_triangles()?[..10])));
    add(Always, "a mesh that is no manifold", Box::new(non_manifold));
    add(
        Usual,
        "every triangle three times",
        Box::new(|| block_of(&[box_triangles()?, box_triangles()?, box_triangles()?].concat())),
    );
    add(Usual, "triangles without area", Box::new(|| block_of(&[box_triangles()?, slivers()].concat())));
    add(Usual, "nothing but triangles without area", Box::new(|| block_of(&slivers())));
    add(Always, "one triangle", Box::new(|| generated("triangle")));
    add(Always, "no triangle", Box::new(|| generated("empty")));
    add(Large, "a million triangles", Box::new(million));
    add(Always, "a box of 1 mm", Box::new(|| scaled(block()?, 1e-3)));
    add(Usual, "a box of 100 km", Box::new(|| scaled(block()?, 1e5)));
    add(Usual, "slats of 1e-3 of their size", Box::new(|| scaled(generated("slats")?, 1e-3)));
    add(Usual, "slats of 1e5 times their size", Box::new(|| scaled(generated("slats")?, 1e5)));
    add(Always, "optical depth 1e-8", Box::new(|| slats_in(fog(1e-8 / 5.0)?)));
    add(Usual, "optical depth 1e3", Box::new(|| slats_in(fog(1e3 / 5.0)?)));
    add(
        Usual,
        "every channel different",
        Box::new(|| {
            let medium = Medium::homogeneous([200.0, 1e-9, 0.1], [0.0, 1e-9, 0.3]);
            slats_in(medium.map_err(Failure::program)?)
        }),
    );
    add(
        Always,
        "nothing scatters",
        Box::new(|| slats_in(Medium::homogeneous([0.0; 3], [0.3; 3]).map_err(Failure::program)?)),
    );
    add(Usual, "all lit: the box is behind the camera", Box::new(|| seen(EYE, Vec3::new(0.3, 3.0, 9.0))));
    add(Usual, "all dark: a closed box around the light", Box::new(|| lit_by(vec![point(Vec3::ZERO)?])));
    let middle = Vec3::new(0.1, 0.1, 2.0);
    add(
        Usual,
        "camera inside a spot's volume",
        Box::new(move || in_volume(Vec3::new(0.5, 0.4, 0.7), middle)),
    );
    add(
        Usual,
        "camera outside of a spot's volume",
        Box::new(move || in_volume(Vec3::new(2.5, 0.4, 1.0), middle)),
    );
    add(
        Always,
        "camera on a wall of a spot's volume",
        Box::new(move || in_volume(Vec3::new(1.0, 0.3, 1.0), middle)),
    );
    add(
        Usual,
        "camera on a wall of a spot's volume, along it",
        Box::new(|| in_volume(Vec3::new(1.0, 0.3, 1.0), Vec3::new(1.0, -0.2, 1.6))),
    );
    add(
        Usual,
        "camera on an edge between two walls",
        Box::new(move || in_volume(Vec3::new(1.0, 1.0, 1.0), middle)),
    );
    add(
        Usual,
        "camera on an edge between two walls, along it to the light",
        Box::new(|| in_volume(Vec3::new(1.0, 1.0, 1.0), Vec3::new(1.0, 1.0, 0.5))),
    );
    add(
        Always,
        "camera in the cap: on the lit top of the box",
        Box::new(|| above_top(0.0, Vec3::new(0.4, 0.8, -2.0))),
    );
    add(Usual, "camera in the cap, along it", Box::new(|| above_top(0.0, Vec3::new(-0.3, 0.495, -0.4))));
    add(Usual, "camera in the cap, into the light", Box::new(|| above_top(0.0, LAMP)));
    add(Usual, "camera 10 µm above the cap", Box::new(|| above_top(1e-5, Vec3::new(-0.3, 0.45, -0.4))));
    add(Usual, "camera 10 µm below the cap", Box::new(|| above_top(-1e-5, Vec3::new(-0.3, 0.6, -0.4))));
    add(
        Usual,
        "camera in the cap of a sun's volume",
        Box::new(|| {
            Ok(Setup {
                lights: vec![sun(Vec3::new(0.2, -1.0, 0.1))?],
                ..above_top(0.0, Vec3::new(0.4, 0.3, -2.0))?
            })
        }),
    );
    add(
        Usual,
        "camera beside a sun's volume",
        Box::new(|| {
            Ok(Setup {
                lights: vec![sun(Vec3::new(0.2, -1.0, 0.1))?],
                ..seen(Vec3::new(6.0, 1.0, 3.0), Vec3::ZERO)?
            })
        }),
    );
    add(
        Usual,
        "camera far below a sun's volume",
        Box::new(|| {
            Ok(Setup {
                lights: vec![sun(Vec3::new(0.0, -1.0, 0.1))?],
                ..seen(Vec3::new(0.0, -300.0, 29.0), Vec3::ZERO)?
            })
        }),
    );
    let micron = |light: Vec3| move || seen(LAMP + light, LAMP - 1e3 * light + Vec3::new(0.0, -1.0, 0.0));
    add(Usual, "camera 1 µm from a point light", Box::new(micron(Vec3::new(1e-6, 0.0, 0.0))));
    add(Usual, "camera 1 mm from a point light", Box::new(micron(Vec3::new(1e-3, 1e-3, 0.0))));
    add(Usual, "five hundred slats", Box::new(|| generated("slats-500")));
    add(Usual, "a cone of 1 degree", Box::new(|| cone(0.5)));
    add(Usual, "a cone of 179 degrees", Box::new(|| cone(89.5)));
    for count in [0, 1, 8, 9] {
        let name = if count == 1 { "one light".into() } else { format!("{count} lights") };
        add(if count == 9 { Always } else { Usual }, &name, Box::new(move || many(count)));
    }
    cases
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_can_be_set_up() {
        for case in cases().iter().filter(|case| case.weight < Weight::Large) {
            let setup = (case.build)().unwrap();
            assert!(setup.scene.meshes.iter().all(|mesh| mesh.material < setup.scene.materials.len()));
        }
        let names: std::collections::BTreeSet<String> = cases().into_iter().map(|case| case.name).collect();
        assert_eq!(names.len(), cases().len());
    }
}
