//! Leaves as cards of two triangles, and the branches that carry them.

use super::builder::MeshBuilder;
use super::noise::Rng;
use glam::Vec3;

/// A leaf from `stem` to its tip, folded along its midrib; `length` in m.
pub(super) fn leaf(b: &mut MeshBuilder, stem: Vec3, along: Vec3, facing: Vec3, length: f32) {
    let across = along.cross(facing).normalize_or(along.any_orthonormal_vector());
    let facing = across.cross(along);
    let middle = stem + 0.45 * length * along + 0.08 * length * facing;
    let [right, left] = [1.0, -1.0].map(|side| middle + side * 0.3 * length * across);
    b.quad([stem, right, stem + length * along, left]);
}

/// `count` leaves around the `anchors`, no farther away than `spread`; lengths in m.
pub(super) fn leaves(
    b: &mut MeshBuilder,
    anchors: &[Vec3],
    count: usize,
    spread: f32,
    length: (f32, f32),
    rng: &mut Rng,
) {
    for i in 0..if anchors.is_empty() { 0 } else { count } {
        let stem = anchors[i % anchors.len()] + spread * rng.unit().cbrt() * rng.direction();
        // leaves hang outwards and turn their faces up
        let along = (rng.direction() + Vec3::new(0.0, -0.3, 0.0)).normalize_or(Vec3::X);
        let facing = rng.direction() + Vec3::new(0.0, 0.9, 0.0);
        leaf(b, stem, along, facing, rng.range(length.0, length.1));
    }
}

/// Trunk and branches of a tree at the origin, and the points where its leaves grow.
#[derive(Debug, Default)]
pub(super) struct Tree {
    pub(super) wood: MeshBuilder,
    pub(super) twigs: Vec<Vec3>,
}

/// Branches of one order: how many of them each branch bears, points along one, and sides.
const ORDERS: [(usize, usize, usize); 3] = [(1, 7, 10), (7, 5, 6), (4, 4, 5)];

impl Tree {
    /// A tree about `height` m high.
    pub(super) fn grow(height: f32, rng: &mut Rng) -> Self {
        let mut tree = Self::default();
        tree.branch(Vec3::new(0.0, -0.1, 0.0), Vec3::Y, 0.65 * height, 0.03 * height, 0, rng);
        tree
    }

    fn branch(
        &mut self,
        start: Vec3,
        direction: Vec3,
        length: f32,
        radius: f32,
        order: usize,
        rng: &mut Rng,
    ) {
        let (_, points, sides) = ORDERS[order];
        let mut path = vec![start];
        let mut along = direction;
        for _ in 1..points {
            along = (along + 0.12 * rng.direction() + Vec3::new(0.0, 0.06, 0.0)).normalize_or(direction);
            path.push(path[path.len() - 1] + length / (points - 1) as f32 * along);
        }
        self.wood.tube(&path, sides, |k| radius * (1.0 - 0.75 * k as f32 / (points - 1) as f32));
        let Some(&(children, ..)) = ORDERS.get(order + 1) else {
            self.twigs.extend_from_slice(&path[1..]);
            return;
        };
        let turn = rng.range(0.0, std::f32::consts::TAU);
        for i in 0..children {
            // on the upper part of the branch, evenly around it
            let t = 0.5 + 0.5 * (i as f32 + rng.unit()) / children as f32;
            let at = t * (points - 1) as f32;
            let k = (at as usize).min(points - 2);
            let stem = path[k].lerp(path[k + 1], at - k as f32);
            // golden angle
            let (sin, cos) = (turn + 2.4 * i as f32).sin_cos();
            let across = along.any_orthonormal_vector();
            let out = cos * across + sin * along.cross(across);
            let direction = (out + 0.6 * along + Vec3::new(0.0, 0.25, 0.0)).normalize_or(out);
            self.branch(stem, direction, length * rng.range(0.42, 0.6), 0.45 * radius, order + 1, rng);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::topology::survey;
    use super::*;

    #[test]
    fn leaves_stay_near_their_anchors() {
        let mut b = MeshBuilder::default();
        leaves(&mut b, &[Vec3::ZERO, Vec3::X], 500, 0.2, (0.05, 0.1), &mut Rng::new(1));
        assert_eq!(b.triangles.len(), 1000);
        assert!(b.positions.iter().all(|p| p.length().min((*p - Vec3::X).length()) < 0.31));
        leaves(&mut b, &[], 10, 0.2, (0.05, 0.1), &mut Rng::new(1));
        assert_eq!(b.triangles.len(), 1000);
    }

    #[test]
    fn trees_stand_upright_and_are_closed() {
        let tree = Tree::grow(5.0, &mut Rng::new(4));
        let s = survey(&tree.wood.positions, &tree.wood.triangles);
        assert!(s.is_closed_manifold() && s.volume > 0.0);
        let height = tree.twigs.iter().map(|p| p.y).fold(0.0, f32::max);
        assert!(height > 3.0 && height < 7.0, "{height}");
        assert!(tree.twigs.iter().all(|p| p.y > 0.5));
    }
}
