//! The sphere of Wyman & Ramsey's Table 1 ("Sphere", 20k triangles).

use super::builder::MeshBuilder;
use super::stage::Stage;
use crate::Scene;
use glam::Vec3;
use std::collections::HashMap;

/// An icosahedron whose faces are cut in four `levels` times, pushed out to radius 1 around the origin:
/// 20·4^`levels` triangles.
fn geodesic(levels: usize) -> MeshBuilder {
    let golden = 0.5 * (1.0 + 5_f32.sqrt());
    let mut b = MeshBuilder::default();
    // three golden rectangles at right angles; vertex 4·axis + 2·(sign of the long side) + (sign of the short side)
    for axis in 0..3 {
        for signs in 0..4_u32 {
            let sign = |bit: u32| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let mut p = Vec3::ZERO;
            p[axis] = sign(0);
            p[(axis + 1) % 3] = sign(1) * golden;
            b.positions.push(p.normalize());
        }
    }
    // faces are the triples of vertices at the distance of an edge; the sign of the volume orients them
    let close = |i: usize, j: usize| b.positions[i].dot(b.positions[j]) > 0.4;
    let mut faces = Vec::with_capacity(20);
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if close(i, j) && close(j, k) && close(k, i) {
                    let outwards = b.positions[i].cross(b.positions[j]).dot(b.positions[k]) > 0.0;
                    let [i, j, k] = [i as u32, j as u32, k as u32];
                    faces.push(if outwards { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::with_capacity(3 * faces.len() / 2);
        let mut middle = |i: u32, j: u32| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                let p = b.positions[i as usize] + b.positions[j as usize];
                b.vertex(p.normalize())
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[i, j, k]| {
                let [ij, jk, ki] = [middle(i, j), middle(j, k), middle(k, i)];
                [[i, ij, ki], [j, jk, ij], [k, ki, jk], [ij, jk, ki]]
            })
            .collect();
    }
    b.triangles = faces;
    b
}

/// 20,480 triangles, radius 1 m, resting on y = 0.
pub(super) fn scene() -> Scene {
    let mut sphere = geodesic(5);
    for p in &mut sphere.positions {
        p.y += 1.0;
    }
    let mut stage = Stage::default();
    stage
        .part("sphere", [0.62, 0.27, 0.19], sphere)
        .camera([1.2, 1.6, 5.6], [0.2, 1.0, 0.0], 40.0)
        .point_light([-0.45, 1.3, -1.25], [30.0; 3])
        .fog(0.09);
    stage.finish()
}

/// A unit sphere of 81,920 triangles above a floor of 1200 m, seen from the front, under a point light above it.
///
/// The simplest scene with a shaft of shadow: one blocker, one receiver.
pub(super) fn on_plane() -> Scene {
    let mut sphere = geodesic(6);
    for p in &mut sphere.positions {
        p.y += 1.5;
    }
    let mut floor = MeshBuilder::default();
    for (x, z) in [(-600.0, 600.0), (600.0, 600.0), (600.0, -600.0), (-600.0, -600.0)] {
        floor.positions.push(Vec3::new(x, 0.0, z));
    }
    floor.triangles = vec![[0, 1, 2], [0, 2, 3]];
    let mut stage = Stage::default();
    stage
        .part("sphere", [0.62, 0.27, 0.19], sphere)
        .part("floor", [0.6; 3], floor)
        .camera([0.0, 2.0, 8.0], [0.0, 1.6, 0.0], 40.0)
        .point_light([0.6, 5.2, -0.8], [100.0; 3])
        .fog(0.06);
    stage.finish()
}

#[cfg(test)]
mod tests {
    use super::super::topology::survey_scene;

    #[test]
    fn is_a_closed_sphere() {
        let scene = super::scene();
        let s = survey_scene(&scene);
        assert!(s.is_closed_manifold(), "{s:?}");
        assert_eq!((scene.triangle_count(), s.genus()), (20_480, 0));
        assert!((s.volume / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3);
        let bounds = scene.bounds();
        assert!(bounds.min.y.abs() < 1e-6 && (bounds.max.y - 2.0).abs() < 1e-6);
    }
}
