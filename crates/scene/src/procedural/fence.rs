//! A fence of pickets, lattice and chain link with the light low behind it: thousands of shadows, many thinner than
//! a texel or a step.

use super::builder::MeshBuilder;
use super::stage::Stage;
use crate::Scene;
use glam::{Affine3A, Quat, Vec3};

/// Width and height of each of the three panels; units: m.
const PANEL: (f32, f32) = (2.0, 1.8);
/// Height of the panels' lower edge above the ground; units: m.
const FOOT: f32 = 0.06;
/// Width of an opening of the chain link from corner to corner; units: m.
const LINK: f32 = 0.05;
/// Radius of the chain link's wire; units: m.
const WIRE: f32 = 0.002;

/// Upright boards with pointed tops, 3 cm apart, around x = 0.
fn pickets() -> MeshBuilder {
    let mut b = MeshBuilder::default();
    let (count, width) = (20, 0.07);
    for i in 0..count {
        let x = PANEL.0 * ((i as f32 + 0.5) / count as f32 - 0.5);
        let top = FOOT + PANEL.1;
        let outline = [(-1.0, FOOT), (1.0, FOOT), (1.0, top - 0.08), (0.0, top), (-1.0, top - 0.08)];
        let face = |z: f32| outline.map(|(side, y)| Vec3::new(x + 0.5 * width * side, y, z)).to_vec();
        b.loft(&[face(-0.008), face(0.008)]);
    }
    b
}

/// Diagonal laths, one layer behind the other, around x = 0.
fn lattice() -> MeshBuilder {
    let mut b = MeshBuilder::default();
    let (half, pitch) = (0.5 * PANEL.0, 0.1);
    let reach = PANEL.0 + PANEL.1;
    for lean in [-1.0, 1.0] {
        for i in 1..(reach / pitch) as usize {
            // along x + lean·(y − FOOT) = c, cut off at the panel's edges
            let c = pitch * i as f32;
            let (low, high) = ((c - PANEL.0).max(0.0), c.min(PANEL.1));
            let end = |y: f32| Vec3::new(lean * (half - c + y), FOOT + y, 0.0);
            let (from, to) = (end(low), end(high));
            let mut lath = MeshBuilder::default();
            lath.block(Vec3::ZERO, Vec3::new((to - from).length(), 0.025, 0.007));
            let turn = Quat::from_rotation_z((to.y - from.y).atan2(to.x - from.x));
            let middle = 0.5 * (from + to) + Vec3::new(0.0, 0.0, 0.004 * lean);
            b.append(&lath, Affine3A::from_rotation_translation(turn, middle));
        }
    }
    b
}

/// Upright wires in zigzag around x = 0; each hooks into its neighbours at its corners, in front of one and behind
/// the other.
fn chain_link() -> MeshBuilder {
    let mut b = MeshBuilder::default();
    let rows = (PANEL.1 / (0.5 * LINK)).round() as usize;
    let wires = (PANEL.0 / LINK).round() as usize;
    for i in 0..wires {
        let middle = LINK * (i as f32 + 0.5) - 0.5 * PANEL.0;
        let path: Vec<Vec3> = (0..=rows)
            .map(|k| {
                // corners of neighbours meet: this one's right corner is in front, the next one's left behind
                let side = if k % 2 == i % 2 { 1.0 } else { -1.0 };
                Vec3::new(middle + side * 0.5 * LINK, FOOT + 0.5 * LINK * k as f32, 1.3 * WIRE * side)
            })
            .collect();
        b.tube(&path, 5, |_| WIRE);
    }
    b
}

fn frame() -> MeshBuilder {
    let mut b = MeshBuilder::default();
    let top = FOOT + PANEL.1;
    for k in 0..4 {
        let x = PANEL.0 * (k as f32 - 1.5);
        b.rod(Vec3::new(x, 0.0, -0.03), Vec3::new(x, top + 0.05, -0.03), 0.03, 16);
    }
    for y in [FOOT + 0.1, top - 0.15] {
        let end = 1.5 * PANEL.0;
        b.rod(Vec3::new(-end, y, -0.03), Vec3::new(end, y, -0.03), 0.018, 12);
    }
    b
}

/// Three panels, 6 m long; the light stands behind the middle one, half a metre above the ground.
pub(super) fn scene() -> Scene {
    let mut ground = MeshBuilder::default();
    ground.quad([[-8.0, 8.0], [8.0, 8.0], [8.0, -8.0], [-8.0, -8.0]].map(|[x, z]| Vec3::new(x, 0.0, z)));
    let mut boards = MeshBuilder::default();
    boards.append(&pickets(), Affine3A::from_translation(Vec3::new(-PANEL.0, 0.0, 0.0)));
    boards.append(&lattice(), Affine3A::IDENTITY);
    let mut wire = MeshBuilder::default();
    wire.append(&chain_link(), Affine3A::from_translation(Vec3::new(PANEL.0, 0.0, 0.0)));
    let mut stage = Stage::default();
    stage
        .part("boards", [0.55, 0.5, 0.42], boards)
        .part("chain link", [0.5, 0.53, 0.55], wire)
        .part("frame", [0.25, 0.35, 0.3], frame())
        .part("ground", [0.36, 0.33, 0.27], ground)
        .camera([1.5, 1.5, 4.0], [-0.1, 0.75, 0.0], 50.0)
        .point_light([-0.3, 0.5, -0.4], [12.0; 3])
        .fog(0.1);
    stage.finish()
}

#[cfg(test)]
mod tests {
    use super::super::topology::survey;
    use super::*;

    #[test]
    fn panels_are_thin_closed_and_of_one_size() {
        for panel in [pickets(), lattice(), chain_link()] {
            let s = survey(&panel.positions, &panel.triangles);
            assert!(s.is_closed_manifold() && s.volume > 0.0, "{s:?}");
            let inside = |p: &Vec3| p.z.abs() < 0.01 && p.x.abs() < 1.03 && p.y > 0.03 && p.y < 1.9;
            assert!(panel.positions.iter().all(inside));
        }
        assert_eq!(survey(&chain_link().positions, &chain_link().triangles).components, 40);
    }
}
