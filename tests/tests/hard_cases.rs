//! Scenes on which techniques fail first: whatever is asked, a picture is finite and never negative, and where the
//! answer is known without computing it, it is that.
#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

use airlight_tests::picture::{Pixels, rel_rmse};
use airlight_tests::tessellate;
use airlight_tests::view::View;
use glam::{DVec3, Vec3};
use media_math::PhaseFunction;
use scene::{Camera, DirectionalLight, Light, Medium, Mesh, PointLight, SpotLight};

/// Side of the pictures: odd, so that one pixel looks exactly where the camera does.
const SIDE: u32 = 25;

/// Steps of the march.
const SAMPLES: u32 = 32;

fn point(position: Vec3) -> Light {
    Light::Point(PointLight::new(position, Vec3::splat(10.0)).unwrap())
}

fn fog(sigma_s: f32) -> Medium {
    Medium::homogeneous([sigma_s; 3], [0.0; 3]).unwrap()
}

fn camera(eye: Vec3, target: Vec3) -> Camera {
    Camera::look_at(eye, target, Vec3::Y, 0.8).unwrap()
}

/// A box of 1 m at the origin, seen from the front, lit from above.
fn block() -> View {
    View::new(
        vec![unit_box()],
        camera(Vec3::new(0.3, 0.4, 4.0), Vec3::ZERO),
        fog(0.1),
        vec![point(LAMP)],
        SIDE,
    )
}

const LAMP: Vec3 = Vec3::new(0.6, 2.0, -0.4);

fn unit_box() -> Mesh {
    tessellate::cuboid(Vec3::splat(-0.5), Vec3::splat(0.5))
}

fn sound(name: &str, pixels: &Pixels) {
    let values = || pixels.as_flattened().iter();
    let bad = values().filter(|v| !v.is_finite()).count();
    assert_eq!(bad, 0, "{name}: {bad} of {} values are not finite", 3 * pixels.len());
    let least = values().copied().fold(f32::INFINITY, f32::min);
    assert!(least >= 0.0, "{name}: {least:e} is negative");
}

/// Both techniques are finite; returns their pictures, the exact one first.
fn both(name: &str, view: &View) -> [Pixels; 2] {
    let pictures = [view.exact(), view.marched(SAMPLES)];
    for (technique, pixels) in ["exact", "brute force"].iter().zip(&pictures) {
        sound(&format!("{name}, {technique}"), pixels);
    }
    sound(&format!("{name}, unshadowed"), &view.unshadowed());
    sound(&format!("{name}, with surfaces"), &view.with_surfaces());
    pictures
}

/// As [`both`], and neither picture is black.
fn both_lit(name: &str, view: &View) -> [Pixels; 2] {
    let pictures = both(name, view);
    for pixels in &pictures {
        assert!(pixels.as_flattened().iter().any(|v| *v > 0.0), "{name}: black");
    }
    pictures
}

fn is_black(pixels: &Pixels) -> bool {
    pixels.as_flattened().iter().all(|v| *v == 0.0)
}

/// As [`both`], and both pictures are exactly black.
fn both_black(name: &str, view: &View) {
    let [exact, marched] = both(name, view);
    assert!(is_black(&exact), "{name}: the exact picture is not black");
    assert!(is_black(&marched), "{name}: the march is not black");
}

#[test]
fn camera_at_the_light() {
    let mut view = block();
    view.lights = vec![point(view.camera.position)];
    both_lit("camera at a point light", &view);
    let spot = SpotLight::new(view.camera.position, view.camera.forward, 0.2, 0.3, Vec3::ONE).unwrap();
    view.lights = vec![Light::Spot(spot)];
    both_lit("camera at a spot light", &view);
    let back = SpotLight::new(view.camera.position, -view.camera.forward, 0.2, 0.3, Vec3::ONE).unwrap();
    view.lights = vec![Light::Spot(back)];
    both("camera at a spot light that shines backwards", &view);
    for phase in [0.9, -0.9] {
        view.lights = vec![point(view.camera.position)];
        view.medium.phase = PhaseFunction::henyey_greenstein(phase).unwrap();
        both_lit("camera at a point light, anisotropic", &view);
    }
}

#[test]
fn camera_inside_the_mesh() {
    let mut view = block();
    view.camera = camera(Vec3::ZERO, Vec3::NEG_Z);
    both_black("inside a box, light outside", &view);
    view.lights = vec![point(Vec3::new(0.1, 0.2, -0.3))];
    both_lit("inside a box with the light", &view);
    let mut sphere = View::procedural("sphere", SIDE);
    let center = Vec3::new(0.0, 1.0, 0.0);
    sphere.camera = camera(center, center + Vec3::new(1.0, 0.1, 0.2));
    both("inside a sphere", &sphere);
}

#[test]
fn straight_at_the_light_and_straight_away() {
    for g in [0.0, 0.8, -0.8] {
        for sign in [1.0_f32, -1.0] {
            let mut view = block();
            view.bvh = View::procedural("empty", 1).bvh;
            // exact in f32 and f64, so that the middle pixel's ray meets the light to the last bit
            view.camera = camera(Vec3::new(0.0, 0.0, 4.0), Vec3::new(0.0, 0.0, 4.0 - sign));
            view.lights = vec![point(Vec3::new(0.0, 0.0, 1.0))];
            view.medium.phase = PhaseFunction::henyey_greenstein(g).unwrap();
            let name = format!("towards {sign}, g = {g}");
            both_lit(&name, &view);
            view.bvh = block().bvh;
            both_lit(&format!("{name}, a box behind the light"), &view);
            view.lights = vec![point(Vec3::new(0.0, 0.0, -1.0))];
            let name = format!("{name}, a box before the light");
            // looking away, all that is seen lies in the box's shadow
            if sign > 0.0 { _ = both_lit(&name, &view) } else { both_black(&name, &view) }
        }
    }
}

#[test]
fn light_touching_a_wall() {
    let view = View::procedural("wall", SIDE);
    both_lit("light 0.1 mm before a wall", &view);
    // in the plane of the wall and on a vertex: no answer is wrong, but it must be a number
    for position in [Vec3::new(0.0, 0.5, 0.0), Vec3::splat(0.5), Vec3::new(0.5, 0.5, 0.1)] {
        let view = View { lights: vec![point(position)], ..block() };
        both("light in the surface of a box", &view);
    }
}

#[test]
fn light_inside_a_lampshade() {
    both_lit("lampshade", &View::procedural("lampshade", SIDE));
}

#[test]
fn sun_along_the_view() {
    for sign in [1.0, -1.0] {
        for (name, eye) in [("aslant", Vec3::new(0.3, 0.4, 4.0)), ("along an axis", Vec3::new(0.0, 0.0, 4.0))]
        {
            let mut view = block();
            view.camera = camera(eye, Vec3::ZERO);
            let sun = DirectionalLight::new(sign * view.camera.forward, Vec3::ONE).unwrap();
            view.lights = vec![Light::Directional(sun)];
            let name = format!("sun {name}, {sign}");
            let [exact, marched] = both_lit(&name, &view);
            // the middle pixel: its ray and the sun's are the same line, all lit or, behind the box, not at all
            let middle = exact.len() / 2;
            let (a, b) = (marched[middle][0], exact[middle][0]);
            assert!((a - b).abs() <= 0.05 * b, "{name}: {a} {b} in the middle");
        }
    }
}

#[test]
fn degenerate_and_duplicated_triangles() {
    let mut view = block();
    let whole = view.exact();
    let points =
        vec![Vec3::ZERO, Vec3::X, 2.0 * Vec3::X, LAMP, view.camera.position, Vec3::new(0.0, 0.0, 2.0)];
    let slivers = vec![[0, 0, 0], [0, 1, 2], [3, 3, 4], [3, 4, 4], [5, 5, 5], [0, 3, 3]];
    let broken = || Mesh::new(points.clone(), slivers.clone(), 0).unwrap();
    let rebuilt = |meshes| View::new(meshes, block().camera, fog(0.1), vec![point(LAMP)], SIDE);
    view.bvh = rebuilt(vec![unit_box(), broken()]).bvh;
    let [with_broken, _] = both_lit("triangles without area", &view);
    assert!(rel_rmse(&with_broken, &whole) < 1e-6, "triangles without area cast shadows");
    view.bvh = rebuilt(vec![unit_box(), unit_box(), unit_box()]).bvh;
    let [tripled, _] = both_lit("every triangle three times", &view);
    assert!(rel_rmse(&tripled, &whole) < 1e-6, "a duplicated triangle changes the picture");
    view.bvh = rebuilt(vec![broken()]).bvh;
    let [nothing, _] = both_lit("nothing but triangles without area", &view);
    assert!(rel_rmse(&nothing, &view.unshadowed()) < 1e-6, "triangles without area cast shadows alone");
}

#[test]
fn one_triangle_and_none() {
    both_lit("one triangle", &View::procedural("triangle", SIDE));
    let [exact, marched] = both_lit("no triangle", &View::procedural("empty", SIDE));
    assert!(rel_rmse(&marched, &exact) < 1e-5, "with nothing in the way a march has nothing to miss");
}

/// Radiance scales with the square of the unit of length, if intensity and optical depth are kept: L ~ σ I/d.
#[test]
fn tiny_and_huge_scenes() {
    let base = block().exact();
    for scale in [1e-3_f32, 1e5] {
        let meshes = vec![tessellate::cuboid(Vec3::splat(-0.5 * scale), Vec3::splat(0.5 * scale))];
        let camera = camera(scale * Vec3::new(0.3, 0.4, 4.0), Vec3::ZERO);
        let view = View::new(meshes, camera, fog(0.1 / scale), vec![point(scale * LAMP)], SIDE);
        let [exact, marched] = both_lit(&format!("scale {scale}"), &view);
        let back = |pixels: &Pixels| -> Pixels {
            pixels.iter().map(|p| p.map(|v| (f64::from(v) * f64::from(scale).powi(2)) as f32)).collect()
        };
        let error = rel_rmse(&back(&exact), &base);
        assert!(error < 1e-4, "scale {scale}: {error:.1e} from the scene at its own scale");
        let error = rel_rmse(&back(&marched), &block().marched(SAMPLES));
        assert!(error < 1e-3, "scale {scale}: the march is {error:.1e} from itself");
    }
    for scale in [1e-3, 1e5] {
        let mut view = View::procedural("slats", SIDE);
        let mut scene = scene::procedural::generate("slats").unwrap();
        for mesh in &mut scene.meshes {
            let positions = mesh.positions().iter().map(|p| *p * scale).collect();
            *mesh = Mesh::new(positions, mesh.triangles().to_vec(), 0).unwrap();
        }
        view.bvh = scene::Bvh::build(&scene).unwrap();
        view.camera.position *= scale;
        view.medium = fog(0.1 / scale);
        view.lights = vec![point(scale * Vec3::new(-0.3, 1.5, -0.35))];
        both_lit(&format!("slats at {scale}"), &view);
    }
}

#[test]
fn thin_and_thick_media() {
    for name in ["slats", "sphere"] {
        let mut view = View::procedural(name, SIDE);
        // the picture is some 5 m deep
        view.medium = fog(1e-8 / 5.0);
        let [exact, _] = both_lit(&format!("{name}, optical depth 1e-8"), &view);
        let mut thin = View::procedural(name, SIDE);
        thin.medium = fog(1e-6 / 5.0);
        let hundredth: Pixels = thin.exact().iter().map(|p| p.map(|v| 0.01 * v)).collect();
        assert!(rel_rmse(&hundredth, &exact) < 1e-4, "{name}: thin media are not linear in sigma");
        view.medium = fog(1e3 / 5.0);
        both(&format!("{name}, optical depth 1e3"), &view);
        view.medium = Medium::homogeneous([200.0, 1e-9, 0.0], [0.0, 1e-9, 200.0]).unwrap();
        both(&format!("{name}, every channel different"), &view);
        view.lights.push(Light::Directional(DirectionalLight::new(Vec3::NEG_Y, Vec3::ONE).unwrap()));
        both_lit(&format!("{name}, every channel different, with a sun"), &view);
    }
}

#[test]
fn nothing_scatters() {
    for sigma_a in [0.0, 0.3] {
        let mut view = View::procedural("slats", SIDE);
        view.medium = Medium::homogeneous([0.0; 3], [sigma_a; 3]).unwrap();
        view.lights.push(Light::Directional(DirectionalLight::new(Vec3::NEG_Y, Vec3::ONE).unwrap()));
        both_black(&format!("sigma_s = 0, sigma_a = {sigma_a}"), &view);
    }
    // one channel that does not scatter stays black beside two that do
    let mut view = View::procedural("slats", SIDE);
    view.medium = Medium::homogeneous([0.1, 0.0, 0.2], [0.05; 3]).unwrap();
    for pixels in both_lit("a channel without scattering", &view) {
        assert!(pixels.iter().all(|p| p[1] == 0.0), "green must be black");
    }
}

#[test]
fn lights_without_power() {
    let mut view = block();
    view.lights = vec![Light::Point(PointLight::new(LAMP, Vec3::ZERO).unwrap())];
    both_black("a light of no intensity", &view);
}

/// The box around the light lets nothing out.
#[test]
fn all_dark() {
    for (name, lamp) in [("in the middle", Vec3::ZERO), ("in a corner", Vec3::splat(0.49))] {
        let view = View { lights: vec![point(lamp)], ..block() };
        both_black(&format!("a closed box around the light, {name}"), &view);
    }
    // a sphere of 20,480 triangles has seams wherever two of them meet
    let mut view = View::procedural("sphere", 64);
    view.lights = vec![point(Vec3::new(0.0, 1.0, 0.0))];
    let exact = view.exact();
    let lit = exact.iter().filter(|p| p[0] > 0.0).count();
    let unshadowed = view.unshadowed();
    let leaked = airlight_tests::picture::norm(&exact) / airlight_tests::picture::norm(&unshadowed);
    println!(
        "a closed sphere around the light: {lit} of {} pixels lit, {leaked:.1e} of the light",
        exact.len()
    );
    assert!(leaked < 1e-6, "{lit} pixels see light through a closed sphere, {leaked:.1e} of it");
}

#[test]
fn five_hundred_slats() {
    let view = View::procedural("slats-500", SIDE);
    let [exact, _] = both_lit("slats-500", &view);
    let fine = rel_rmse(&view.marched(16_384), &exact);
    assert!(fine < 0.01, "a march of 16,384 steps is {fine:.1e} from the exact picture");
}

#[test]
fn narrow_and_wide_cones() {
    for half_angle in [0.5_f32, 89.5] {
        for inner in [0.0, 0.999 * half_angle, half_angle] {
            let mut view = View::procedural("slats", SIDE);
            let position = Vec3::new(-0.3, 2.5, -1.5);
            let (inner, outer) = (inner.to_radians(), half_angle.to_radians());
            let target = Vec3::new(0.0, 1.0, 1.0);
            let spot = SpotLight::new(position, target - position, inner, outer, Vec3::splat(20.0)).unwrap();
            view.lights = vec![Light::Spot(spot)];
            let name = format!("cone of {half_angle} degrees, inner {inner}");
            let [exact, _] = both(&name, &view);
            assert!(exact.iter().any(|p| p[0] > 0.0), "{name}: black");
        }
    }
}

#[test]
fn none_one_eight_and_nine_lights() {
    let lights: Vec<Light> = (0..9)
        .map(|i| {
            let angle = 0.7 * i as f32;
            let position = Vec3::new(angle.cos(), 1.0 + 0.1 * i as f32, 2.0 * angle.sin());
            match i % 3 {
                0 => point(position),
                1 => Light::Spot(SpotLight::new(position, -position, 0.3, 0.8, Vec3::splat(5.0)).unwrap()),
                _ => Light::Directional(DirectionalLight::new(-position, Vec3::splat(0.5)).unwrap()),
            }
        })
        .collect();
    let with = |lights: &[Light]| View { lights: lights.to_vec(), ..block() };
    both_black("no light", &with(&[]));
    let each: Vec<[Pixels; 2]> = (0..9).map(|i| both_lit("one light", &with(&lights[i..=i]))).collect();
    for count in [1, 8, 9] {
        let together = both_lit(&format!("{count} lights"), &with(&lights[..count]));
        for (technique, picture) in together.iter().enumerate() {
            let mut sum: Vec<DVec3> = vec![DVec3::ZERO; picture.len()];
            for one in &each[..count] {
                sum.iter_mut().zip(&one[technique]).for_each(|(s, p)| *s += DVec3::from(p.map(f64::from)));
            }
            let sum: Pixels = sum.iter().map(|s| s.as_vec3().to_array()).collect();
            let error = rel_rmse(picture, &sum);
            assert!(error < 1e-6, "{count} lights differ from their sum by {error:.1e}");
        }
    }
}
