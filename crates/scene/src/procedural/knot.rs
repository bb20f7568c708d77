//! A knotted lattice of many handles for the "Yeah Right" model of Wyman & Ramsey's and Billeter et al.'s tables.

use super::builder::MeshBuilder;
use super::isosurface::{largest_piece, surface_nets};
use super::stage::Stage;
use crate::Scene;
use glam::{Mat3, Vec3};

/// Periods of the lattice over the ball's radius.
const PERIODS: f32 = 2.4;
/// Where the lattice is cut: 0 fills half of the ball, more makes thinner strands.
const LEVEL: f32 = 0.62;
/// Turn of the ball's poles against each other; units: rad.
const TWIST: f32 = 1.3;

/// One of the two labyrinths of a gyroid, cut out by a ball that is `across` grid cells wide.
fn lattice(across: f32) -> MeshBuilder {
    // a margin of two cells keeps the surface off the grid's border
    let (scale, n) = (2.0 / across, across.ceil() as usize + 6);
    let coordinate = |i: usize| scale * (i as f32 - 0.5 * (n - 1) as f32);
    let wave = PERIODS * std::f32::consts::TAU;
    // the gyroid is made of products of sines of one coordinate: 2n sines serve n³ samples. The offset puts a
    // hollow of the labyrinth at the centre.
    let waves: Vec<(f32, f32)> =
        (0..n).map(|i| (wave * coordinate(i) - std::f32::consts::FRAC_PI_4).sin_cos()).collect();
    let value = |p: [usize; 3]| {
        let outside = Vec3::from_array(p.map(coordinate)).length() - 1.0;
        if outside > 3.0 * scale {
            return outside;
        }
        let [(sx, cx), (sy, cy), (sz, cz)] = p.map(|i| waves[i]);
        // 1.2 · wave is about the gyroid's slope: both terms are distances in m
        let strand = (LEVEL - (sx * cy + sy * cz + sz * cx)) / (1.2 * wave);
        // a maximum with its edge rounded off, so that the cut ends are smooth at every resolution
        0.5 * (strand + outside + ((strand - outside).powi(2) + 4e-3).sqrt())
    };
    let mut b = largest_piece(&surface_nets(n, value));
    for p in &mut b.positions {
        let at = scale * (*p - Vec3::splat(0.5 * (n - 1) as f32));
        // twisting space moves no strand through another
        *p = 0.5 * (Mat3::from_rotation_y(TWIST * at.y) * at) + Vec3::new(0.0, 0.5, 0.0);
    }
    b
}

/// The lattice with the light in the hollow at its centre.
fn scene(across: f32) -> Scene {
    let mut stage = Stage::default();
    stage
        .part("knot", [0.2, 0.42, 0.5], lattice(across))
        .camera([0.9, 0.95, 2.2], [0.0, 0.48, 0.0], 35.0)
        .point_light([0.0, 0.5, 0.0], [36.0; 3])
        .fog(0.2);
    stage.finish()
}

/// About 188,672 triangles, as "Yeah Right" in Billeter et al.'s Table 1.
pub(super) fn knot_188k() -> Scene {
    scene(96.76)
}

/// About 754,688 triangles, as "Yeah Right" in Wyman & Ramsey's Table 1.
pub(super) fn knot_755k() -> Scene {
    scene(192.45)
}

#[cfg(test)]
mod tests {
    use super::super::topology::survey_scene;
    use super::*;

    fn check(scene: &Scene, triangles: f64) {
        let s = survey_scene(scene);
        assert!(s.is_closed_manifold(), "{s:?}");
        assert!(s.genus() > 50, "{s:?}");
        assert!(s.volume > 0.0);
        assert!((scene.triangle_count() as f64 / triangles - 1.0).abs() < 0.01, "{}", scene.triangle_count());
    }

    #[test]
    fn the_coarse_knot_is_one_closed_surface_of_many_handles() {
        check(&knot_188k(), 188_672.0);
    }

    #[test]
    fn the_fine_knot_is_one_closed_surface_of_many_handles() {
        check(&knot_755k(), 754_688.0);
    }
}
