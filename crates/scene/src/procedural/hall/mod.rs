//! A columned hall with galleries and windows, for Sponza (66k) and Sibenik (75k) of Billeter et al.'s and the shared
//! shadow grid's tables.
//!
//! The nave runs along Z between two arcades at x = ±[`ARCADE`]; aisles lie outside them, galleries above the aisles.

mod parts;

use super::builder::MeshBuilder;
use super::stage::Stage;
use crate::Scene;
use glam::{Affine3A, Quat, Vec3};
use parts::{Window, arch_block, arch_ring, baluster, column};

const BAYS: usize = 8;
/// Distance between two columns; units: m.
const BAY: f32 = 4.0;
/// Distance of an arcade's middle from the nave's; units: m.
const ARCADE: f32 = 3.9;
/// Distance of an outer wall's middle from the nave's; units: m.
const WALL: f32 = 8.2;
/// Thickness of the arcades' walls; units: m.
const THICK: f32 = 0.7;
/// Where the lower arches spring, the gallery's floor, where the upper arches spring, where they end, and where the
/// vault springs; units: m.
const LEVELS: [f32; 5] = [5.0, 7.35, 9.9, 11.2, 12.0];

/// Meshes of the hall, one a material.
#[derive(Default)]
struct Hall {
    floor: MeshBuilder,
    walls: MeshBuilder,
    columns: MeshBuilder,
    trim: MeshBuilder,
    bars: MeshBuilder,
    vault: MeshBuilder,
}

/// Puts a part made around x = z = 0 and facing along Z at (`x`, `y`, `z`), facing along X.
fn crosswise(x: f32, y: f32, z: f32) -> Affine3A {
    Affine3A::from_rotation_translation(
        Quat::from_rotation_y(std::f32::consts::FRAC_PI_2),
        Vec3::new(x, y, z),
    )
}

/// The middle of a bay on the Z axis; half numbers are columns.
fn along(bay: f32) -> f32 {
    BAY * (bay - 0.5 * (BAYS - 1) as f32)
}

impl Hall {
    fn arcade(&mut self, side: f32) {
        let [spring, gallery, upper, roof, vault] = LEVELS;
        let (x, length) = (side * ARCADE, 0.5 * BAY * BAYS as f32);
        let (large, small) = (column(spring, 0.36, 20, 6), column(upper - gallery, 0.15, 8, 4));
        let arch = arch_block(BAY, spring, gallery - 0.3, 1.5, THICK, 20);
        let archivolt = arch_ring(1.5, 1.72, spring, THICK + 0.12, 20);
        let upper_arch = arch_block(0.5 * BAY, upper, roof, 0.78, 0.5, 12);
        let post = baluster(0.85);
        for i in 0..=BAYS {
            self.columns.append(&large, Affine3A::from_translation(Vec3::new(x, 0.0, along(i as f32 - 0.5))));
        }
        for i in 0..=2 * BAYS {
            let z = along(0.5 * i as f32 - 0.5);
            self.columns.append(&small, Affine3A::from_translation(Vec3::new(x, gallery, z)));
        }
        for i in 0..BAYS {
            let z = along(i as f32);
            self.walls.append(&arch, crosswise(x, 0.0, z));
            self.trim.append(&archivolt, crosswise(x, 0.0, z));
            for half in [-0.25, 0.25] {
                self.walls.append(&upper_arch, crosswise(x, 0.0, z + half * BAY));
            }
            for k in 0..6 {
                let z = z + BAY * ((k as f32 + 0.5) / 6.0 - 0.5);
                let inner = x - side * 0.5 * (THICK - 0.2);
                self.trim.append(&post, Affine3A::from_translation(Vec3::new(inner, gallery + 0.05, z)));
            }
        }
        let beam = |b: &mut MeshBuilder, at: f32, width: f32, y: [f32; 2]| {
            b.block(Vec3::new(at, 0.5 * (y[0] + y[1]), 0.0), Vec3::new(width, y[1] - y[0], 2.0 * length));
        };
        beam(&mut self.walls, x, 0.5, [roof, vault]);
        beam(&mut self.walls, side * 0.5 * (ARCADE + WALL), WALL - ARCADE + THICK, [gallery - 0.3, gallery]);
        beam(&mut self.vault, side * 0.5 * (ARCADE + WALL), WALL - ARCADE + THICK, [roof, roof + 0.3]);
        let inner = x - side * 0.5 * (THICK - 0.2);
        beam(&mut self.trim, inner, 0.2, [gallery, gallery + 0.05]);
        beam(&mut self.trim, inner, 0.22, [gallery + 0.9, gallery + 1.0]);
        beam(&mut self.trim, x, THICK + 0.2, [gallery - 0.42, gallery - 0.28]);
        beam(&mut self.trim, x, THICK + 0.1, [vault - 0.2, vault]);
    }

    fn outer_wall(&mut self, side: f32) {
        let [_, gallery, _, roof, _] = LEVELS;
        let low =
            Window { width: BAY, below: 1.8, sill: 1.8, spring: 4.3, top: gallery, radius: 0.85, depth: 0.5 };
        let high = Window { below: 0.8, sill: gallery + 0.8, spring: 9.6, top: roof, ..low };
        for i in 0..BAYS {
            for window in [&low, &high] {
                let pose = crosswise(side * WALL, 0.0, along(i as f32));
                self.walls.append(&window.wall(), pose);
                self.bars.append(&window.bars(), pose);
            }
            // a pilaster between the windows
            self.trim.block(
                Vec3::new(side * (WALL - 0.3), 0.5 * gallery, along(i as f32 - 0.5)),
                Vec3::new(0.25, gallery, 0.6),
            );
        }
    }

    fn ends_and_roof(&mut self) {
        let [.., vault] = LEVELS;
        let length = 0.5 * BAY * BAYS as f32;
        let inner = ARCADE - 0.5 * THICK;
        let ring = arch_ring(inner, inner + 0.3, vault, BAY, 32);
        let rib = arch_ring(inner - 0.22, inner, vault, 0.4, 32);
        for i in 0..BAYS {
            self.vault.append(&ring, Affine3A::from_translation(Vec3::new(0.0, 0.0, along(i as f32))));
        }
        for i in 0..=BAYS {
            self.trim.append(&rib, Affine3A::from_translation(Vec3::new(0.0, 0.0, along(i as f32 - 0.5))));
        }
        // a large window closes the view; the wall behind the viewer has none
        let window =
            Window { width: 4.0, below: 6.0, sill: 6.0, spring: 11.0, top: 16.0, radius: 1.6, depth: 0.5 };
        let (edge, far) = (WALL + 0.25, Affine3A::from_translation(Vec3::new(0.0, 0.0, -length - 0.25)));
        self.walls.append(&window.wall(), far);
        self.bars.append(&window.bars(), far);
        for x in [[-edge, -2.0], [2.0, edge]] {
            self.walls.cuboid(Vec3::new(x[0], 0.0, -length - 0.5), Vec3::new(x[1], 16.0, -length));
        }
        self.walls.cuboid(Vec3::new(-edge, 0.0, length), Vec3::new(edge, 16.0, length + 0.5));
        let (nx, nz) = (16, 32);
        self.floor.grid(nx, nz, |i, j| {
            let (u, v) = (2.0 * i as f32 / nx as f32 - 1.0, 2.0 * j as f32 / nz as f32 - 1.0);
            Vec3::new(edge * u, 0.0, -length * v)
        });
    }
}

/// About 70,000 triangles; the light is on the left gallery, hidden from the viewer, so the colonnade and
/// the balusters cut the fog of the nave into shafts.
pub(super) fn scene() -> Scene {
    let mut hall = Hall::default();
    for side in [-1.0, 1.0] {
        hall.arcade(side);
        hall.outer_wall(side);
    }
    hall.ends_and_roof();
    let mut stage = Stage::default();
    stage
        .part("floor", [0.34, 0.27, 0.22], hall.floor)
        .part("walls", [0.58, 0.52, 0.43], hall.walls)
        .part("columns", [0.66, 0.62, 0.55], hall.columns)
        .part("trim", [0.5, 0.42, 0.32], hall.trim)
        .part("window bars", [0.12, 0.12, 0.13], hall.bars)
        .part("vault", [0.42, 0.45, 0.52], hall.vault)
        .camera([1.0, 1.9, 14.0], [-0.3, 5.5, -6.0], 60.0)
        .point_light([-5.2, 9.2, 0.0], [420.0, 395.0, 350.0])
        .fog(0.03);
    stage.finish()
}

#[cfg(test)]
mod tests {
    #[test]
    fn has_the_size_of_sponza_and_sibenik_and_holds_its_viewer_and_light() {
        let scene = super::scene();
        assert!((66_000..=75_000).contains(&scene.triangle_count()), "{}", scene.triangle_count());
        let bounds = scene.bounds();
        let crate::Light::Point(light) = &scene.lights[0] else { panic!("a point light") };
        assert!(
            bounds.contains(scene.cameras[0].position.as_dvec3())
                && bounds.contains(light.position.as_dvec3())
        );
    }
}
