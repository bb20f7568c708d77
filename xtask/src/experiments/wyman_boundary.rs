//! How evenly the boundary of a shadow moves in a picture while the light moves evenly.

use glam::Vec3;
use ground_truth::{Reference, Settings};
use hybrid_march::{Adjacency, BruteForce, FaceBounds, Hybrid, Occluders, ShadowVolume};
use scene::{Bvh, BvhVisibility, Light, PointLight};

use crate::failure::{Failure, Outcome};
use crate::scene_args::Setup;
use crate::technique::Extruded;
use crate::volumes::extruded_mesh;

/// Steps of both marches.
const SAMPLES: u32 = 50;

/// The share of the light that is missing where a boundary is seen.
const LEVEL: f64 = 0.02;

/// Pixels that the boundary moves in all.
const MOTION: f64 = 2.0;

/// Positions of the light in the choice of a row.
const TRIAL: u32 = 9;

/// A shadow with a boundary that a row of the picture crosses once.
pub(super) struct View {
    /// Scene of the set-ups.
    pub(super) id: &'static str,
    /// Position of the point light; units: m.
    light: [f32; 3],
    /// Row, in 256ths of the picture.
    row: u32,
}

/// Lights before and above the casters, so that their shadows end within the picture.
pub(super) const VIEWS: [View; 2] = [
    View { id: "sphere", light: [1.0, 2.0, 3.0], row: 216 },
    View { id: "slats", light: [0.3, 4.0, 0.0], row: 216 },
];

/// A boundary followed through all positions of the light.
#[derive(Debug, Clone)]
pub(super) struct Boundary {
    pub(super) technique: String,
    /// Whether it is the hybrid's, of which steadiness is claimed.
    pub(super) is_judged: bool,
    /// Row of the picture, and pixels along its side.
    pub(super) row: u32,
    pub(super) side: u32,
    pub(super) level: f64,
    pub(super) positions: u32,
    /// Positions at which the boundary was found.
    pub(super) found: u32,
    /// Largest distance of a found position from the line through them; units: pixels.
    pub(super) deviation: Option<f64>,
}

impl View {
    /// A set-up with the light moved here.
    pub(super) fn lit(&self, setup: &Setup) -> Outcome<Setup> {
        let power = setup.lights.first().map_or(Vec3::ONE, |light| match light {
            Light::Point(light) => light.intensity,
            _ => Vec3::ONE,
        });
        let light = PointLight::new(self.light.into(), power).map_err(Failure::program)?;
        Ok(Setup { lights: vec![Light::Point(light)], ..setup.clone() })
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum By {
    Exact,
    Hybrid,
    BruteForce,
}

impl By {
    fn name(self) -> String {
        match self {
            Self::Exact => "exact".into(),
            Self::Hybrid => format!("hybrid, {SAMPLES} steps, no bisection"),
            Self::BruteForce => format!("brute force, {SAMPLES} steps"),
        }
    }
}

/// A scene whose light moves.
struct Scene<'a> {
    setup: &'a Setup,
    bvh: Bvh,
    mesh: Adjacency,
    light: PointLight,
    side: u32,
}

/// Follows one boundary in one row of pictures of `side` pixels through `positions` of the light.
///
/// Fails for a light that is no point light, and if no row has a boundary.
pub(super) fn measure(setup: &Setup, view: &View, (side, positions): (u32, u32)) -> Outcome<Vec<Boundary>> {
    let light = PointLight::new(view.light.into(), Vec3::ONE).map_err(Failure::program)?;
    // in 256ths of the picture
    let row = view.row * side / 256;
    let bvh = Bvh::build(&setup.scene).map_err(Failure::program)?;
    let mesh = extruded_mesh(setup, Extruded::Scene)?;
    let scene = Scene { setup, bvh, mesh, light, side };
    let (at, pace) = scene.choose(row)?;
    let follow = |by: By| -> Outcome<Boundary> {
        let places = scene.places(by, row, at, pace, positions)?;
        Ok(Boundary {
            technique: by.name(),
            is_judged: by == By::Hybrid,
            row,
            side,
            level: LEVEL,
            positions,
            found: places.len() as u32,
            deviation: deviation(&places),
        })
    };
    [By::Exact, By::Hybrid, By::BruteForce].into_iter().map(follow).collect()
}

impl Scene<'_> {
    /// The row's most even boundary: where it is at first, and how far the light moves in all; units: pixels and m.
    fn choose(&self, row: u32) -> Outcome<(f64, f64)> {
        let small = 1e-4 * f64::from(self.setup.camera.position.distance(self.light.position));
        let mut best: Option<(f64, (f64, f64))> = None;
        let moved_by_little = self.deficits(By::Exact, row, small)?;
        for at in crossings(&self.deficits(By::Exact, row, 0.0)?) {
            let moved = nearest(&moved_by_little, at);
            let Some(speed) = moved.map(|moved| (moved - at) / small).filter(|speed| *speed != 0.0) else {
                continue;
            };
            let pace = MOTION / speed;
            let places = self.places(By::Exact, row, at, pace, TRIAL)?;
            let Some(off) = deviation(&places).filter(|_| places.len() == TRIAL as usize) else { continue };
            if best.is_none_or(|(least, _)| off < least) {
                best = Some((off, (at, pace)));
            }
        }
        best.map(|(_, chosen)| chosen)
            .ok_or_else(|| Failure::program(format!("no boundary of a shadow in row {row}")))
    }

    /// The boundary's places in the row while the light moves by `pace`; those that were found, with their positions.
    fn places(&self, by: By, row: u32, at: f64, pace: f64, positions: u32) -> Outcome<Vec<(f64, f64)>> {
        let mut places = Vec::new();
        for i in 0..positions {
            let share = f64::from(i) / f64::from(positions - 1);
            let expected = at + share * MOTION;
            if let Some(place) = nearest(&self.deficits(by, row, share * pace)?, expected) {
                places.push((share, place));
            }
        }
        Ok(places)
    }

    /// The share of the light that shadows take, for each pixel of a row, with the light moved to the right.
    fn deficits(&self, by: By, row: u32, moved: f64) -> Outcome<Vec<f64>> {
        let Setup { scene, camera, medium, model, .. } = self.setup;
        let position = self.light.position.as_dvec3() + moved * camera.right.as_dvec3();
        let lights = [Light::Point(PointLight { position: position.as_vec3(), ..self.light })];
        let size = (self.side, self.side);
        let settings = Settings { airlight_only: true, model: *model, ..Settings::default() };
        let reference = Reference::new(&scene.materials, &self.bvh, medium, &lights, settings)
            .map_err(Failure::program)?;
        let visibility = BvhVisibility::new(&self.bvh, &lights);
        let occluders = Some(Occluders { visibility: &visibility, bounds: self.bvh.bounds() });
        let march =
            |occluders| BruteForce { medium, lights: &lights, occluders, samples: SAMPLES, model: *model };
        let hybrid = Hybrid::new(medium, &lights, occluders, SAMPLES, 0, *model).map_err(Failure::program)?;
        let bounds = (by == By::Hybrid)
            .then(|| FaceBounds::draw(&ShadowVolume::new(&self.mesh, &lights[0]), camera, size, 1));
        let share = |x: u32| {
            let ray = camera.pixel_ray(x, row, size);
            let (_, end) = reference.end_of(&ray);
            let open = f64::from(march(None).airlight(&ray, end).airlight.x);
            let shadowed = match by {
                By::Exact => reference.airlight(&ray, end).x,
                By::BruteForce => f64::from(march(occluders).airlight(&ray, end).airlight.x),
                By::Hybrid => {
                    let faces = bounds.as_ref().and_then(|bounds| bounds.at(x, row));
                    f64::from(hybrid.airlight(&ray, end, &[faces]).airlight.x)
                }
            };
            1.0 - shadowed / open
        };
        Ok((0..self.side).map(share).collect())
    }
}

/// Where a row passes the level, from light to shadow; units: pixels.
fn crossings(deficits: &[f64]) -> Vec<f64> {
    let pairs = deficits.windows(2).enumerate().filter(|(_, pair)| pair[0] < LEVEL && pair[1] >= LEVEL);
    pairs.map(|(i, pair)| i as f64 + (LEVEL - pair[0]) / (pair[1] - pair[0])).collect()
}

/// The crossing nearest to where one is expected, no farther than two pixels from there.
fn nearest(deficits: &[f64], expected: f64) -> Option<f64> {
    let all = crossings(deficits).into_iter();
    all.min_by(|a, b| (a - expected).abs().total_cmp(&(b - expected).abs()))
        .filter(|at| (at - expected).abs() <= 2.0)
}

/// The largest distance of points from their line of least squares.
fn deviation(points: &[(f64, f64)]) -> Option<f64> {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |sum, point| (sum.0 + point.0 / n, sum.1 + point.1 / n));
    let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>()
        / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>();
    let off = points.iter().map(|p| (p.1 - y - slope * (p.0 - x)).abs());
    off.reduce(f64::max).filter(|off| off.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossings_are_between_pixels() {
        let row = [0.0, 0.01, 0.03, 0.5, 0.0, 0.04];
        let found = crossings(&row);
        assert!(found.len() == 2 && (found[0] - 1.5).abs() < 1e-9 && (found[1] - 4.5).abs() < 1e-9);
        assert_eq!(nearest(&row, 4.0), Some(found[1]));
        assert_eq!(nearest(&row, 9.0), None);
    }

    #[test]
    fn a_line_deviates_by_nothing() {
        let line = [(0.0, 1.0), (0.5, 2.0), (1.0, 3.0)];
        assert!(deviation(&line).unwrap() < 1e-12);
        let bent = [(0.0, 0.0), (0.5, 0.3), (1.0, 0.0)];
        assert!((deviation(&bent).unwrap() - 0.2).abs() < 1e-12);
        assert_eq!(deviation(&[]), None);
    }
}
