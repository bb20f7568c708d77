//! Our criterion: how far a quad is from the surface of all nodes, at most.
//!
//! Let F_l be the surface in which every quad of level l is cut into two triangles by its own diagonal; F_0 is that of
//! all nodes. A quad of level l keeps d ≥ |F_l − F_{l−1}| and hands up e = d + (greatest e of its children) ≥ |F_l − F_0|.
//!
//! *Inside the map* the quad's diagonal is made of diagonals of two children, so that both surfaces are linear over
//! the children's triangles: the difference is greatest at one of the five nodes that the children add. d is that.
//!
//! *A quad that sticks out* is a rectangle that its children divide at uneven places, and its diagonal is nobody's. Let B
//! be the bilinear surface through its four corners, m the greatest |h − B| at the five nodes, and
//! t = |h00 − h10 − h01 + h11|. The two triangles of a rectangle lie within t/4 of its B, for B − F = ±t·ab with
//! a + b ≤ 1. The same holds for a child against B between *its* corners, whose t is that of B times its share of the
//! area; and moving its corners from B to their heights moves F_{l−1} by at most m. In all |F_l − F_{l−1}| ≤ m + t/2.
//! d = 2m + t/2 leaves room for rounding, and keeps one formula for the CPU and the GPU.
//!
//! *Stitches* move the middle of an edge to its own height. That adds a tent no higher than |h − F_l| there, which is at
//! most d, whence 2d in the value that is compared. On an edge F_l and B are the same.
//!
//! Heights become metres by dz = −dh/h²: both surfaces are at least as high as the quad's least node, and depths past
//! `far` are taken to lie at `far`.

use crate::nodes::Nodes;
use crate::quads::{Layer, Quads};

/// What a quad hands up.
#[derive(Debug, Clone, Copy)]
struct Quad {
    /// Bound on |F_l − F_0|, a height.
    error: f32,
    /// Least height of its nodes.
    least: f32,
    /// What is compared with the threshold; units: m.
    value: f32,
}

/// The heights of a face.
struct Heights<'a> {
    heights: &'a [f32],
    width: usize,
}

impl Heights<'_> {
    #[inline]
    fn at(&self, x: u32, y: u32) -> f32 {
        self.heights[y as usize * self.width + x as usize]
    }

    /// d of a quad of level 1 or more.
    fn step(&self, quads: &Quads, level: u32, x: u32, y: u32) -> f32 {
        let c = quads.corners(level, x, y);
        let (xm, ym) = quads.middle(level, x, y);
        let [h00, h10] = [c.x0, c.x1].map(|x| self.at(x, c.y0));
        let [h01, h11] = [c.x0, c.x1].map(|x| self.at(x, c.y1));
        if !quads.straddles(level, x, y) {
            // the middles of the four edges, and that of the diagonal
            return [
                (xm, c.y0, 0.5 * (h00 + h10)),
                (c.x0, ym, 0.5 * (h00 + h01)),
                (c.x1, ym, 0.5 * (h10 + h11)),
                (xm, c.y1, 0.5 * (h01 + h11)),
                (xm, ym, 0.5 * (h10 + h01)),
            ]
            .into_iter()
            .fold(0.0, |most, (x, y, coarse)| most.max((self.at(x, y) - coarse).abs()));
        }
        let share = |middle: u32, from: u32, to: u32| (middle - from) as f32 / (to - from) as f32;
        let (fx, fy) = (share(xm, c.x0, c.x1), share(ym, c.y0, c.y1));
        let bilinear = |fx: f32, fy: f32| {
            let (top, bottom) = (h00 + fx * (h10 - h00), h01 + fx * (h11 - h01));
            top + fy * (bottom - top)
        };
        let nodes = [
            (xm, c.y0, fx, 0.0),
            (c.x0, ym, 0.0, fy),
            (c.x1, ym, 1.0, fy),
            (xm, c.y1, fx, 1.0),
            (xm, ym, fx, fy),
        ];
        let apart = nodes
            .into_iter()
            .fold(0.0_f32, |most, (x, y, fx, fy)| most.max((self.at(x, y) - bilinear(fx, fy)).abs()));
        let twist = (h00 - h10 - h01 + h11).abs();
        2.0 * apart + 0.5 * twist
    }
}

/// Bounds on the distance of every quad, in its stitched form, from the surface of all nodes; each level from 1 on;
/// units: m.
pub(crate) fn levels(nodes: &Nodes<'_>, face: usize, quads: &Quads) -> Vec<Layer<f32>> {
    let (values, floor) = (nodes.heights(face), 1.0 / nodes.far);
    let heights = Heights { heights: &values, width: nodes.size().0 as usize };
    let mut below = Layer::new(quads.count(0), |x, y| {
        let corners =
            [heights.at(x, y), heights.at(x + 1, y), heights.at(x, y + 1), heights.at(x + 1, y + 1)];
        Quad { error: 0.0, least: corners.into_iter().fold(f32::INFINITY, f32::min), value: 0.0 }
    });
    let mut levels = Vec::new();
    for level in 1..=quads.top() {
        let layer = Layer::new(quads.count(level), |x, y| {
            let children = quads.children(level, x, y).filter_map(|(x, y)| below.get(x, y));
            let (error, least) = children.fold((0.0_f32, f32::INFINITY), |(error, least), child| {
                (error.max(child.error), least.min(child.least))
            });
            let step = heights.step(quads, level, x, y);
            let bound = error + 2.0 * step;
            let floor = least.max(floor);
            let value = if nodes.perspective { bound / (floor * floor) } else { bound };
            Quad { error: error + step, least, value }
        });
        levels.push(Layer::new(layer.size(), |x, y| layer.get(x, y).map_or(0.0, |quad| quad.value)));
        below = layer;
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Options;
    use glam::{DVec2, DVec3};
    use shadowmap::{DepthMap, Projection};

    fn values(size: (u32, u32), depths: Vec<f32>) -> Vec<Layer<f32>> {
        let flat = Projection::orthographic(DVec3::ZERO, DVec3::Z, DVec3::X, DVec2::ONE).unwrap();
        let map = DepthMap::new(flat, size, depths).unwrap();
        let nodes = Nodes::new(&map, &Options::default()).unwrap();
        levels(&nodes, 0, &Quads::new(size).unwrap())
    }

    #[test]
    fn errors_are_handed_up_and_metres_are_those_of_the_least_node() {
        let mut spike = vec![4.0; 81];
        spike[9 + 1] = 1.0;
        let found = values((9, 9), spike);
        // nothing is added at levels 2 and 3
        assert_eq!([0, 1, 2].map(|level| found[level].get(0, 0)), [Some(6.0), Some(3.0), Some(3.0)]);
        // heights 1/4, and 1/8 in one corner: 1/16 from the middles of two edges, at two levels
        let mut depths = vec![4.0; 25];
        depths[0] = 8.0;
        let projection = Projection::perspective(DVec3::ZERO, DVec3::Z, DVec3::X, DVec2::ONE).unwrap();
        let map = DepthMap::new(projection, (5, 5), depths).unwrap();
        let nodes = Nodes::new(&map, &Options::default()).unwrap();
        let found = levels(&nodes, 0, &Quads::new((5, 5)).unwrap());
        // 2/16 · 8², and (1 + 2)/16 · 8²
        assert_eq!(
            (found[0].get(0, 0), found[0].get(1, 1), found[1].get(0, 0)),
            (Some(8.0), Some(0.0), Some(12.0))
        );
    }

    #[test]
    fn a_plane_costs_nothing_and_a_spike_its_height() {
        let plane: Vec<f32> = (0..45).map(|i| 3.0 + (i % 9) as f32 + 2.0 * (i / 9) as f32).collect();
        for (level, layer) in values((9, 5), plane).iter().enumerate() {
            let (columns, rows) = layer.size();
            let most = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
            let most = most.filter_map(|(x, y)| layer.get(x, y)).fold(0.0, f32::max);
            assert_eq!(most, 0.0, "level {}", level + 1);
        }
        let mut spike = vec![4.0; 25];
        spike[5 + 1] = 1.0;
        let found = values((5, 5), spike);
        // the centre of its quad: 2d at level 1; e = 3 then, and nothing is added at level 2
        assert_eq!(
            (found[0].get(0, 0), found[0].get(1, 0), found[1].get(0, 0)),
            (Some(6.0), Some(0.0), Some(3.0))
        );
    }
}
