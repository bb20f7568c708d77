//! A table lamp: the light is inside an open, perforated shade, so it is all but enclosed.

use super::builder::MeshBuilder;
use super::stage::Stage;
use crate::Scene;
use glam::{Vec2, Vec3};

/// Height above the table and radius of the shade's lower and upper rim; units: m.
const RIMS: [(f32, f32); 2] = [(0.34, 0.23), (0.62, 0.12)];
/// Cells around the shade and up it; each has a round hole.
const CELLS: (usize, usize) = (22, 6);
/// Vertices of a hole and of a cell's outline.
const HOLE: usize = 16;
/// Radius of a hole as a share of its cell.
const HOLE_SIZE: f32 = 0.27;

/// A point of the shade; `u` runs around it and `v` up, both from 0 to 1.
fn shade_point(u: f32, v: f32) -> Vec3 {
    let [(y0, r0), (y1, r1)] = RIMS;
    let (sin, cos) = (std::f32::consts::TAU * u).sin_cos();
    let r = r0 + (r1 - r0) * v;
    Vec3::new(r * cos, y0 + (y1 - y0) * v, -r * sin)
}

/// An open cone without thickness; every cell is a band between its outline and its hole.
fn shade() -> MeshBuilder {
    // the k-th of 16 points around the square with corners (±1, ±1); exact, so that neighbours share their vertices
    let side = |k: usize| (0.5 * ((k % 16).abs_diff(8) as f32 - 4.0)).clamp(-1.0, 1.0);
    let square: [Vec2; HOLE] = std::array::from_fn(|k| Vec2::new(side(k), side(k + 12)));
    let circle: [Vec2; HOLE] = std::array::from_fn(|k| {
        let (sin, cos) = (std::f32::consts::TAU * k as f32 / HOLE as f32).sin_cos();
        2.0 * HOLE_SIZE * Vec2::new(cos, sin)
    });
    let mut b = MeshBuilder::default();
    for i in 0..CELLS.0 {
        for j in 0..CELLS.1 {
            let mut row = |points: &[Vec2; HOLE]| {
                points.map(|p| {
                    let at = Vec2::new(i as f32, j as f32) + 0.5 + 0.5 * p;
                    // the last cell ends where the first begins
                    b.vertex(shade_point(at.x / CELLS.0 as f32 % 1.0, at.y / CELLS.1 as f32))
                })
            };
            let (outline, hole) = (row(&square), row(&circle));
            b.band(&outline, &hole, true);
        }
    }
    b
}

/// A bulb in a perforated lampshade on a table.
pub(super) fn scene() -> Scene {
    let foot = [
        (0.0, 0.0),
        (0.11, 0.0),
        (0.11, 0.015),
        (0.06, 0.03),
        (0.02, 0.06),
        (0.014, 0.1),
        (0.022, 0.2),
        (0.014, 0.3),
        (0.02, 0.38),
        (0.0, 0.385),
    ];
    let mut lamp = MeshBuilder::default();
    lamp.lathe(&foot.map(Vec2::from), 32, |_| 1.0);
    let mut table = MeshBuilder::default();
    table.quad([[-3.0, 3.0], [3.0, 3.0], [3.0, -3.0], [-3.0, -3.0]].map(|[x, z]| Vec3::new(x, 0.0, z)));
    let mut stage = Stage::default();
    stage
        .part("shade", [0.75, 0.62, 0.4], shade())
        .part("foot", [0.35, 0.25, 0.12], lamp)
        .part("table", [0.3, 0.18, 0.11], table)
        .camera([0.35, 0.85, 1.75], [0.0, 0.42, 0.0], 45.0)
        .point_light([0.0, 0.46, 0.0], [1.2, 1.05, 0.8])
        .fog(0.3);
    stage.finish()
}

#[cfg(test)]
mod tests {
    use super::super::topology::survey;
    use super::*;

    #[test]
    fn the_shade_is_one_open_sheet_around_the_light() {
        let shade = shade();
        let s = survey(&shade.positions, &shade.triangles);
        assert_eq!((s.components, s.degenerate), (1, 0));
        // a band around the light has V − E + F = 0, and every hole takes one away
        assert_eq!(s.euler, -((CELLS.0 * CELLS.1) as i64));
        let outwards = shade.triangles.iter().all(|t| {
            let [a, b, c] = t.map(|i| shade.positions[i as usize]);
            (b - a).cross(c - a).dot(Vec3::new(a.x, 0.0, a.z)) > 0.0
        });
        assert!(outwards);
    }
}
