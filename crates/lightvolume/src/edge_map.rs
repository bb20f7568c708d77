//! The paper's criterion: an edge map, and the greatest edge within every quad.                        (BSA10 §4.1)

use crate::nodes::Nodes;
use crate::quads::{Layer, Quads};

/// |Laplacian| of the heights at a node, in metres; beyond the map the outermost nodes count.
fn edge(heights: &[f32], size: (u32, u32), x: u32, y: u32, perspective: bool, floor: f32) -> f32 {
    let at = |x: u32, y: u32| heights[y as usize * size.0 as usize + x as usize];
    let height = at(x, y);
    let sides = at(x.saturating_sub(1), y) + at((x + 1).min(size.0 - 1), y);
    let ends = at(x, y.saturating_sub(1)) + at(x, (y + 1).min(size.1 - 1));
    let laplacian = (sides + ends - 4.0 * height).abs();
    if !perspective {
        return laplacian;
    }
    // dz = −dh/h²
    let height = height.max(floor);
    laplacian / (height * height)
}

/// The greatest edge of the closed quads of each level from 1 on; units: m.
pub(crate) fn levels(nodes: &Nodes<'_>, face: usize, quads: &Quads) -> Vec<Layer<f32>> {
    let (heights, size, floor) = (nodes.heights(face), nodes.size(), 1.0 / nodes.far);
    let mut levels: Vec<Layer<f32>> = Vec::new();
    for level in 1..=quads.top() {
        let layer = match levels.last() {
            None => Layer::new(quads.count(level), |x, y| {
                let c = quads.corners(level, x, y);
                let places = (c.y0..=c.y1).flat_map(|y| (c.x0..=c.x1).map(move |x| (x, y)));
                places.fold(0.0_f32, |most, (x, y)| {
                    most.max(edge(&heights, size, x, y, nodes.perspective, floor))
                })
            }),
            Some(below) => Layer::new(quads.count(level), |x, y| {
                quads.children(level, x, y).filter_map(|(x, y)| below.get(x, y)).fold(0.0, f32::max)
            }),
        };
        levels.push(layer);
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Options;
    use glam::{DVec2, DVec3};
    use shadowmap::{DepthMap, Projection};

    #[test]
    fn a_spike_by_hand() {
        // 5 × 5 nodes of depth 4, one of depth 2
        let mut depths = vec![4.0; 25];
        depths[2 * 5 + 1] = 2.0;
        let flat = Projection::orthographic(DVec3::ZERO, DVec3::Z, DVec3::X, DVec2::ONE).unwrap();
        let map = DepthMap::new(flat, (5, 5), depths.clone()).unwrap();
        let of = |map: &DepthMap| {
            levels(&Nodes::new(map, &Options::default()).unwrap(), 0, &Quads::new((5, 5)).unwrap())
        };
        let found = of(&map);
        assert_eq!((found.len(), found[0].size()), (2, (2, 2)));
        // −4·2 at the spike itself; column 2, which both quads have, is one node away
        assert_eq!(
            (found[0].get(0, 0), found[0].get(1, 0), found[1].get(0, 0)),
            (Some(8.0), Some(2.0), Some(8.0))
        );
        let perspective = Projection::perspective(DVec3::ZERO, DVec3::Z, DVec3::X, DVec2::ONE).unwrap();
        let found = of(&DepthMap::new(perspective, (5, 5), depths).unwrap());
        // 4·(1/2 − 1/4)·2², and (1/2 − 1/4)·4² beside it
        assert_eq!((found[0].get(0, 0), found[0].get(1, 1)), (Some(4.0), Some(4.0)));
    }
}
