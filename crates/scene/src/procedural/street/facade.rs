//! A house front: windows with shutters, balconies, shops with awnings, a cornice.
//!
//! Local frame: x along the front from its left corner, y up, the front at z = 0 and facing +z.

use super::super::builder::MeshBuilder;
use super::super::foliage::leaves;
use super::super::noise::Rng;
use glam::Vec3;

/// Meshes of a front, one a material.
#[derive(Debug, Default)]
pub(super) struct Front {
    pub(super) wall: MeshBuilder,
    pub(super) stone: MeshBuilder,
    pub(super) wood: MeshBuilder,
    pub(super) iron: MeshBuilder,
    pub(super) glass: MeshBuilder,
    pub(super) cloth: MeshBuilder,
    pub(super) plants: MeshBuilder,
}

/// Height of the ground floor and of each floor above; units: m.
const GROUND_FLOOR: f32 = 4.0;
const FLOOR: f32 = 3.2;
/// How far windows lie behind the front; units: m.
const RECESS: f32 = 0.22;

/// An opening in a bay of wall: a rectangle in x and y.
#[derive(Debug, Clone, Copy)]
struct Opening {
    x: [f32; 2],
    y: [f32; 2],
}

impl Front {
    /// A front of `bays` windows over `width` m, `floors` above the shops; balconies and plants by chance.
    pub(super) fn build(width: f32, bays: usize, floors: usize, rng: &mut Rng) -> Self {
        let mut front = Self::default();
        let bay = width / bays as f32;
        for i in 0..bays {
            let x = [bay * i as f32, bay * (i + 1) as f32];
            let middle = 0.5 * (x[0] + x[1]);
            let shop = Opening { x: [x[0] + 0.25, x[1] - 0.25], y: [0.15, 3.0] };
            front.bay(x, [0.0, GROUND_FLOOR], shop);
            front.frame(shop);
            if rng.unit() < 0.75 {
                front.awning(shop, rng.range(0.9, 1.4));
            }
            for k in 0..floors {
                let y = GROUND_FLOOR + FLOOR * k as f32;
                let balcony = rng.unit() < 0.5;
                let sill = if balcony { y + 0.12 } else { y + 0.8 };
                let window = Opening { x: [middle - 0.5, middle + 0.5], y: [sill, y + 2.5] };
                front.bay(x, [y, y + FLOOR], window);
                front.frame(window);
                front.shutters(window, rng.range(0.2, 1.4));
                if balcony {
                    front.balcony(middle, y, rng);
                } else {
                    front.stone.block(Vec3::new(middle, sill - 0.05, 0.06), Vec3::new(1.3, 0.1, 0.16));
                }
            }
        }
        front.top(width, GROUND_FLOOR + FLOOR * floors as f32);
        front
    }

    /// The wall around an opening, the opening's reveals, and a pane at its back.
    fn bay(&mut self, x: [f32; 2], y: [f32; 2], hole: Opening) {
        let (hx, hy) = (hole.x, hole.y);
        let mut rectangle = |x0: f32, x1: f32, y0: f32, y1: f32| {
            self.wall.quad([[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| Vec3::new(x, y, 0.0)));
        };
        rectangle(x[0], x[1], y[0], hy[0]);
        rectangle(x[0], x[1], hy[1], y[1]);
        rectangle(x[0], hx[0], hy[0], hy[1]);
        rectangle(hx[1], x[1], hy[0], hy[1]);
        let rim = [[hx[0], hy[0]], [hx[1], hy[0]], [hx[1], hy[1]], [hx[0], hy[1]]];
        for k in 0..4 {
            let [a, b] = [rim[k], rim[(k + 1) % 4]].map(|[x, y]| Vec3::new(x, y, 0.0));
            let back = Vec3::new(0.0, 0.0, -RECESS);
            self.wall.quad([a, b, b + back, a + back]);
        }
        self.glass.quad(rim.map(|[x, y]| Vec3::new(x, y, -RECESS)));
    }

    fn frame(&mut self, hole: Opening) {
        let (x, y, bar) = (hole.x, hole.y, 0.05);
        let z = [-RECESS, -RECESS + 0.07];
        let middle = 0.5 * (x[0] + x[1]);
        for at in [x[0], middle - 0.5 * bar, x[1] - bar] {
            self.wood.cuboid(Vec3::new(at, y[0], z[0]), Vec3::new(at + bar, y[1], z[1]));
        }
        for t in [0.0, 0.35, 0.7, 1.0] {
            let at = y[0] + (y[1] - y[0] - bar) * t;
            self.wood.cuboid(Vec3::new(x[0], at, z[0]), Vec3::new(x[1], at + bar, z[1]));
        }
    }

    /// Two louvred shutters, opened by `angle` (rad) from the wall.
    fn shutters(&mut self, hole: Opening, angle: f32) {
        let (sin, cos) = angle.sin_cos();
        let width = 0.5 * (hole.x[1] - hole.x[0]);
        let boards = 10;
        for (hinge, side) in [(hole.x[0], -1.0), (hole.x[1], 1.0)] {
            let along = Vec3::new(side * cos, 0.0, sin);
            let out = Vec3::new(-side * sin, 0.0, cos);
            let origin = Vec3::new(hinge, hole.y[0], 0.03);
            // from `from` to `to` along the shutter and `low` to `high` in height, its top pushed out by `lean`
            let mut board = |from: f32, to: f32, low: f32, high: f32, lean: f32| {
                let section = |s: f32| {
                    let bottom = origin + s * along + low * Vec3::Y;
                    let top = origin + s * along + high * Vec3::Y + lean * out;
                    let ring = vec![bottom, bottom + 0.02 * out, top + 0.02 * out, top];
                    if side > 0.0 { ring.into_iter().rev().collect() } else { ring }
                };
                self.wood.loft(&[section(from), section(to)]);
            };
            let height = hole.y[1] - hole.y[0];
            board(0.0, 0.05, 0.0, height, 0.0);
            board(width - 0.05, width, 0.0, height, 0.0);
            for k in 0..boards {
                let low = height * (k as f32 + 0.1) / boards as f32;
                board(0.05, width - 0.05, low, low + 0.8 * height / boards as f32, -0.04);
            }
        }
    }

    fn balcony(&mut self, middle: f32, y: f32, rng: &mut Rng) {
        let (half, out, rail) = (0.85, 0.7, 0.95);
        self.stone.cuboid(Vec3::new(middle - half, y - 0.05, 0.0), Vec3::new(middle + half, y + 0.1, out));
        for x in [-0.6, 0.6] {
            self.stone.block(Vec3::new(middle + x, y - 0.2, 0.2), Vec3::new(0.12, 0.3, 0.4));
        }
        let (floor, top) = (y + 0.1, y + 0.1 + rail);
        let corners = [(-half, 0.0), (-half, out), (half, out), (half, 0.0)]
            .map(|(x, z)| Vec3::new(middle + x, top, z));
        self.iron.tube(&corners, 6, |_| 0.02);
        for pair in corners.windows(2) {
            let bars = ((pair[1] - pair[0]).length() / 0.11) as usize;
            for k in 0..bars {
                let at = pair[0].lerp(pair[1], (k as f32 + 0.5) / bars as f32);
                self.iron.rod(Vec3::new(at.x, floor, at.z), at, 0.009, 5);
            }
        }
        if rng.unit() < 0.6 {
            let box_front = Vec3::new(middle, top - 0.15, out + 0.1);
            self.wood.block(box_front, Vec3::new(1.3, 0.18, 0.18));
            let anchors: Vec<Vec3> =
                (0..12).map(|k| box_front + Vec3::new(0.11 * (k as f32 - 5.5), 0.12, 0.05)).collect();
            leaves(&mut self.plants, &anchors, 110, 0.2, (0.06, 0.13), rng);
        }
    }

    /// A sagging cloth over a shop with a scalloped edge.
    fn awning(&mut self, hole: Opening, reach: f32) {
        let (nu, nv) = (20, 6);
        let width = hole.x[1] - hole.x[0];
        let top = hole.y[1] + 0.35;
        self.cloth.grid(nu, nv + 1, |i, j| {
            let u = i as f32 / nu as f32;
            let x = hole.x[0] + width * u;
            if j <= 1 {
                // the edge hangs down, every other vertex lower
                let drop = if j == 0 { 0.18 + if i % 2 == 0 { 0.0 } else { 0.07 } } else { 0.0 };
                return Vec3::new(x, top - 0.6 - drop, reach);
            }
            let t = 1.0 - (j - 1) as f32 / nv as f32;
            let sag = 0.1 * t * (1.0 - t);
            Vec3::new(x, top - 0.6 * t - sag, reach * t)
        });
        for x in hole.x {
            self.iron.rod(Vec3::new(x, top - 0.9, 0.0), Vec3::new(x, top - 0.62, reach), 0.015, 6);
        }
    }

    fn top(&mut self, width: f32, height: f32) {
        self.stone
            .cuboid(Vec3::new(0.0, GROUND_FLOOR - 0.12, 0.0), Vec3::new(width, GROUND_FLOOR + 0.04, 0.1));
        self.stone.cuboid(Vec3::new(0.0, height, -0.5), Vec3::new(width, height + 0.25, 0.35));
        let teeth = (width / 0.3) as usize;
        for k in 0..teeth {
            let x = width * (k as f32 + 0.5) / teeth as f32;
            self.stone.block(Vec3::new(x, height - 0.07, 0.11), Vec3::new(0.14, 0.14, 0.22));
        }
        // the house behind its front: roof, sides and back
        self.wall.quad(
            [[0.0, -0.5], [width, -0.5], [width, -8.0], [0.0, -8.0]]
                .map(|[x, z]| Vec3::new(x, height + 0.2, z)),
        );
        let side = |x: f32, z0: f32, z1: f32| {
            [[z0, 0.0], [z1, 0.0], [z1, height], [z0, height]].map(|[z, y]| Vec3::new(x, y, z))
        };
        self.wall.quad(side(0.0, -8.0, 0.0));
        self.wall.quad(side(width, 0.0, -8.0));
        self.wall.quad(
            [[width, 0.0], [0.0, 0.0], [0.0, height], [width, height]].map(|[x, y]| Vec3::new(x, y, -8.0)),
        );
        for x in [0.25, 0.7] {
            self.stone.block(Vec3::new(x * width, height + 0.9, -2.0), Vec3::new(0.7, 1.5, 0.5));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::topology::survey;
    use super::*;

    #[test]
    fn solid_parts_are_closed() {
        let mut front = Front::default();
        let hole = Opening { x: [0.5, 1.5], y: [1.0, 2.5] };
        front.shutters(hole, 0.7);
        let shutters = survey(&front.wood.positions, &front.wood.triangles);
        assert_eq!((shutters.bad_edges, shutters.components), (0, 24));
        assert!(shutters.volume > 0.0);
        front.balcony(1.0, 0.0, &mut Rng::new(1));
        let iron = survey(&front.iron.positions, &front.iron.triangles);
        assert!(iron.bad_edges == 0 && iron.volume > 0.0, "{iron:?}");
    }

    #[test]
    fn walls_face_the_street() {
        let mut front = Front::default();
        front.bay([0.0, 2.0], [0.0, 3.0], Opening { x: [0.5, 1.5], y: [1.0, 2.5] });
        let towards = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| front.wall.positions[i as usize]);
            let (normal, middle) = ((b - a).cross(c - a), (a + b + c) / 3.0);
            // reveals face the opening's middle
            normal.z > 0.0 || normal.dot(Vec3::new(1.0, 1.75, middle.z) - middle) > 0.0
        };
        assert!(front.wall.triangles.iter().all(towards));
    }
}
