//! Displaced blobs for the smooth animals and statues of Wyman & Ramsey's Table 1: elephant, bunny, Buddha.

use super::builder::MeshBuilder;
use super::noise::{Rng, fractal_noise};
use super::stage::Stage;
use crate::{Aabb, Scene};
use glam::Vec3;
use std::collections::HashMap;

/// What tells one blob from another.
struct Blob {
    name: &'static str,
    base_color: [f32; 3],
    /// Quadrangles along the edges of the box that the surface is cut like: 4·(ab + bc + ca) triangles.
    cells: [usize; 3],
    /// How far the lobes reach, as a share of the core's radius.
    reach: f32,
    /// How narrow the lobes are.
    sharpness: f32,
    lobes: usize,
    /// Strength and size of the small dents.
    dents: (f32, f32),
    /// Height over width.
    stretch: f32,
    seed: u64,
}

/// The surface of a box of `cells` quadrangles, blown up to the unit sphere; vertices shared.
fn round_box(cells: [usize; 3]) -> MeshBuilder {
    let mut b = MeshBuilder::default();
    let mut ids = HashMap::new();
    let mut vertex = |b: &mut MeshBuilder, at: [usize; 3]| {
        *ids.entry(at).or_insert_with(|| {
            // equal angles instead of equal lengths: cells of about one size all over the sphere
            let axis =
                |a: usize| (std::f32::consts::FRAC_PI_4 * (2.0 * at[a] as f32 / cells[a] as f32 - 1.0)).tan();
            b.vertex(Vec3::new(axis(0), axis(1), axis(2)).normalize())
        })
    };
    for w in 0..3 {
        let (u, v) = ((w + 1) % 3, (w + 2) % 3);
        for side in [0, cells[w]] {
            for i in 0..cells[u] {
                for j in 0..cells[v] {
                    let [p, q, r, s] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                        let mut at = [0; 3];
                        (at[u], at[v], at[w]) = (i + di, j + dj, side);
                        vertex(&mut b, at)
                    });
                    // u × v points along +w
                    if side == 0 {
                        b.triangles.extend([[p, r, q], [p, s, r]]);
                    } else {
                        b.triangles.extend([[p, q, r], [p, r, s]]);
                    }
                }
            }
        }
    }
    b
}

impl Blob {
    fn build(&self) -> MeshBuilder {
        let mut b = round_box(self.cells);
        let lobes = self.lobe_directions();
        for p in &mut b.positions {
            let lobe =
                lobes.iter().map(|&(axis, height)| height * (self.sharpness * (p.dot(axis) - 1.0)).exp());
            let (strength, size) = self.dents;
            let dents = strength * fractal_noise(*p / size, 4, self.seed);
            // radial, so that the surface cannot pass through itself
            *p *= 1.0 + self.reach * lobe.sum::<f32>() + dents;
            p.y *= self.stretch;
            // a bow to the side, more the higher up: not every point can be seen from the middle any more
            p.x += 0.12 * p.y * p.y;
        }
        // 1 m high, resting on y = 0, centred
        let bounds = Aabb::around(b.positions.iter().copied());
        let (scale, middle) = (1.0 / (bounds.max.y - bounds.min.y), bounds.center());
        for p in &mut b.positions {
            *p = scale * (*p - Vec3::new(middle.x, bounds.min.y, middle.z));
        }
        b
    }

    /// Directions and heights of the lobes, apart from each other so that valleys stay between them.
    fn lobe_directions(&self) -> Vec<(Vec3, f32)> {
        let mut rng = Rng::new(self.seed);
        let mut lobes: Vec<(Vec3, f32)> = Vec::new();
        for _ in 0..self.lobes {
            let farthest = (0..40).map(|_| rng.direction()).min_by(|a, b| {
                let nearness = |d: &Vec3| lobes.iter().map(|(l, _)| l.dot(*d)).fold(-1.0, f32::max);
                nearness(a).total_cmp(&nearness(b))
            });
            lobes.extend(farthest.map(|d| (d, rng.range(0.6, 1.0))));
        }
        lobes
    }

    fn scene(&self) -> Scene {
        let mut stage = Stage::default();
        stage
            .part(self.name, self.base_color, self.build())
            .camera([0.5, 0.8, 2.7], [0.05, 0.48, 0.0], 35.0)
            .point_light([-0.12, 0.62, -0.5], [7.0; 3])
            .fog(0.2);
        stage.finish()
    }
}

/// 24,000 triangles, for the elephant: six heavy lobes.
pub(super) fn blob_24k() -> Scene {
    Blob {
        name: "blob",
        base_color: [0.42, 0.42, 0.46],
        cells: [40, 55, 40],
        reach: 1.5,
        sharpness: 9.0,
        lobes: 7,
        dents: (0.1, 0.6),
        stretch: 1.0,
        seed: 24,
    }
    .scene()
}

/// 69,452 triangles, for the bunny (69,451, open at the bottom): many short lobes, a furrowed skin.
pub(super) fn blob_70k() -> Scene {
    Blob {
        name: "blob",
        base_color: [0.66, 0.56, 0.44],
        cells: [83, 89, 58],
        reach: 0.9,
        sharpness: 16.0,
        lobes: 12,
        dents: (0.16, 0.4),
        stretch: 1.0,
        seed: 70,
    }
    .scene()
}

/// 250,000 triangles, for the Buddha: tall, finely dented.
pub(super) fn blob_250k() -> Scene {
    Blob {
        name: "blob",
        base_color: [0.6, 0.46, 0.16],
        cells: [145, 180, 112],
        reach: 0.75,
        sharpness: 13.0,
        lobes: 14,
        dents: (0.2, 0.35),
        stretch: 1.7,
        seed: 250,
    }
    .scene()
}

#[cfg(test)]
mod tests {
    use super::super::topology::survey_scene;
    use super::*;

    /// How far the surface rises above the plane of one of its own triangles, at most; 0 for a convex shape. Units: m.
    fn deepest_dent(scene: &Scene) -> f32 {
        let mesh = &scene.meshes[0];
        mesh.corners()
            .step_by(97)
            .map(|[a, b, c]| {
                let normal = (b - a).cross(c - a).normalize_or_zero();
                mesh.positions().iter().step_by(53).map(|&p| normal.dot(p - a)).fold(0.0, f32::max)
            })
            .fold(0.0, f32::max)
    }

    #[test]
    fn are_closed_concave_and_of_the_stated_size() {
        for (scene, triangles) in [(blob_24k(), 24_000), (blob_70k(), 69_452), (blob_250k(), 250_000)] {
            let s = survey_scene(&scene);
            assert!(s.is_closed_manifold(), "{s:?}");
            assert_eq!((scene.triangle_count(), s.genus()), (triangles, 0));
            assert!(s.volume > 0.0);
            assert!(deepest_dent(&scene) > 0.2, "{triangles}: {}", deepest_dent(&scene));
            let bounds = scene.bounds();
            assert!(bounds.min.y == 0.0 && (bounds.max.y - 1.0).abs() < 1e-6);
        }
    }
}
