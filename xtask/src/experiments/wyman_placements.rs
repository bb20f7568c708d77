//! Three placements of as many steps, in one march on the CPU.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use glam::{DVec3, Vec3};
use ground_truth::render_rows;
use hybrid_march::{FaceBounds, ShadowVolume};
use media_math::{Foot, airlight};
use scene::{Aabb, BvhVisibility, DRay, Interval, Light, LightId, Mesh, PointLight, Visibility};

use super::measure::{Arena, in_turns};
use crate::failure::{Failure, Outcome};
use crate::image_file::Image;
use crate::median::median;
use crate::scene_args::Setup;
use crate::technique::{Extruded, Options};
use crate::volumes::extruded_mesh;

/// How far before its end a ray is asked whether it ends in shadow, as a share of its length.
const BEFORE_END: f64 = 1e-6;

/// Where the steps lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Steps {
    /// Equal ones between the frontmost and the backmost face of each ray.
    BetweenFaces,
    /// On planes parallel to the image, the same for all pixels.
    Planes,
    /// Equal ones from the eye to the end of the ray.
    WholeRay,
}

impl Steps {
    const ALL: [Self; 3] = [Self::BetweenFaces, Self::Planes, Self::WholeRay];

    /// Name in the tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::BetweenFaces => "between the faces",
            Self::Planes => "planes parallel to the image",
            Self::WholeRay => "over the whole ray",
        }
    }
}

/// A placement's picture.
pub(super) struct Timed {
    pub(super) steps: Steps,
    pub(super) image: Image,
    /// Sorted; units: ms.
    pub(super) times: Vec<f64>,
    /// Shadow rays.
    pub(super) lookups: u64,
}

impl Timed {
    pub(super) fn ms(&self) -> f64 {
        median(&self.times).unwrap_or(f64::NAN)
    }
}

/// A distance behind all of a scene, seen from its camera; units: m.
pub(super) fn far_enough(setup: &Setup) -> f64 {
    let corners = setup.scene.meshes.iter().flat_map(Mesh::corners).flatten();
    let bounds = Aabb::around(corners);
    f64::from(setup.camera.position.distance(bounds.center()) + 0.75 * bounds.diagonal())
}

/// The march, and what it asks.
struct March<'a> {
    lit: &'a Arena,
    light: &'a PointLight,
    visibility: BvhVisibility<'a>,
    samples: u32,
    /// Least and greatest depth of planes; units: m.
    planes: (f64, f64),
    lookups: AtomicU64,
}

/// Which pixels meet a face, and the pictures of all placements.
///
/// Fails for a light that is no point light.
pub(super) fn measure(lit: &Arena, samples: u32) -> Outcome<(Vec<bool>, Vec<Timed>)> {
    let setup = &lit.setup;
    let [Light::Point(light)] = &setup.lights[..] else {
        return Err(Failure::program("placements of steps in the light of other than one point light"));
    };
    let faces = faces(lit)?;
    let visibility = BvhVisibility::new(&lit.bvh, &setup.lights);
    let mut march = March { lit, light, visibility, samples, planes: (0.0, 0.0), lookups: AtomicU64::new(0) };
    let pixels = (0..lit.base.size.1).flat_map(|y| (0..lit.base.size.0).map(move |x| (x, y)));
    let counts: Vec<bool> = pixels.clone().map(|(x, y)| march.shadowed(&faces, x, y).is_some()).collect();
    let depths = pixels.filter_map(|(x, y)| {
        let depth = march.ray(x, y).direction.dot(setup.camera.forward.as_dvec3());
        let part = march.shadowed(&faces, x, y)?;
        Some((depth * part.start, depth * part.end))
    });
    march.planes = depths.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or((0.0, 0.0));
    let mut timed: Vec<Timed> = Steps::ALL
        .into_iter()
        .map(|steps| {
            let before = march.lookups.load(Ordering::Relaxed);
            let image = march.picture(steps)?;
            let lookups = march.lookups.load(Ordering::Relaxed) - before;
            Ok(Timed { steps, image, times: Vec::new(), lookups })
        })
        .collect::<Outcome<_>>()?;
    let times = in_turns(&mut timed, |result| {
        let started = Instant::now();
        march.picture(result.steps)?;
        Ok(started.elapsed().as_secs_f64() * 1e3)
    })?;
    timed.iter_mut().zip(times).for_each(|(result, times)| result.times = times);
    Ok((counts, timed))
}

fn faces(lit: &Arena) -> Outcome<FaceBounds> {
    let mesh = extruded_mesh(&lit.setup, Extruded::Scene)?;
    let volume = ShadowVolume::new(&mesh, &lit.setup.lights[0]);
    Ok(FaceBounds::draw(&volume, &lit.setup.camera, lit.base.size, 1))
}

impl March<'_> {
    fn ray(&self, x: u32, y: u32) -> DRay {
        self.lit.setup.camera.pixel_ray(x, y, self.lit.base.size)
    }

    /// How far the ray of a pixel is integrated; units: m.
    fn end(&self, x: u32, y: u32) -> f64 {
        let Options { size, max_distance, .. } = self.lit.base;
        self.lit.rays.end((y * size.0 + x) as usize, max_distance)
    }

    fn is_lit(&self, ray: &DRay, x: f64) -> bool {
        self.lookups.fetch_add(1, Ordering::Relaxed);
        self.visibility.visibility(ray.at(x).as_vec3(), LightId(0)) > 0.0
    }

    /// The part of a pixel's ray outside of which it is lit: between its faces, from the eye where that is dark, and to
    /// the ray's end where that is.
    fn shadowed(&self, faces: &FaceBounds, x: u32, y: u32) -> Option<Interval> {
        let (ray, end) = (self.ray(x, y), self.end(x, y));
        let faces = faces.at(x, y).unwrap_or(Interval::new(end, 0.0));
        let front = if self.is_lit(&ray, 0.0) { faces.start.min(end) } else { 0.0 };
        let back = if self.is_lit(&ray, end * (1.0 - BEFORE_END)) { faces.end.min(end) } else { end };
        (back > front).then(|| Interval::new(front, back))
    }

    fn picture(&self, steps: Steps) -> Outcome<Image> {
        let faces = if steps == Steps::BetweenFaces { Some(faces(self.lit)?) } else { None };
        let size = self.lit.base.size;
        let forward = self.lit.setup.camera.forward.as_dvec3();
        let pixels = render_rows(size, &|_| (), |x, y| {
            let (ray, end) = (self.ray(x, y), self.end(x, y));
            let part = match steps {
                Steps::BetweenFaces => faces
                    .as_ref()
                    .and_then(|faces| self.shadowed(faces, x, y))
                    .unwrap_or(Interval::new(end, end)),
                Steps::Planes => {
                    let depth = ray.direction.dot(forward);
                    Interval::new(self.planes.0 / depth, self.planes.1 / depth)
                }
                Steps::WholeRay => Interval::new(0.0, end),
            };
            self.airlight(&ray, part, end).to_array()
        });
        Ok(Image { width: size.0, height: size.1, pixels })
    }

    /// Equal steps over `part`, as far as the ray goes, each asked at its middle; lit before and behind.
    fn airlight(&self, ray: &DRay, part: Interval, end: f64) -> Vec3 {
        let foot = self.foot(ray);
        let setup = &self.lit.setup;
        let of = |from: f64, to: f64| -> Vec3 {
            if to <= from {
                return Vec3::ZERO;
            }
            let (coefficients, phase) = (&setup.medium.coefficients, &setup.medium.phase);
            airlight(coefficients, phase, self.light.intensity.to_array(), &foot, from as f32, to as f32)
                .into()
        };
        let width = part.length() / f64::from(self.samples);
        let mut sum = Vec3::ZERO;
        let (mut is_lit, mut from) = (true, 0.0);
        for i in 0..self.samples {
            let start = part.start + f64::from(i) * width;
            let middle = start + 0.5 * width;
            if width <= 0.0 || middle >= end {
                break;
            }
            if self.is_lit(ray, middle) != is_lit {
                if is_lit {
                    sum += of(from, start);
                }
                (is_lit, from) = (!is_lit, start);
            }
        }
        if !is_lit && part.end < end {
            (is_lit, from) = (true, part.end);
        }
        if is_lit { sum + of(from, end) } else { sum }
    }

    fn foot(&self, ray: &DRay) -> Foot<f32> {
        let to: DVec3 = self.light.position.as_dvec3() - ray.origin;
        let foot = Foot::new(to.to_array(), ray.direction.to_array());
        Foot { x_foot: foot.x_foot as f32, h: foot.h.max(1e-12) as f32 }
    }
}
