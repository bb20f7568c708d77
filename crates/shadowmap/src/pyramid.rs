//! Min-max mips: the range of depths under ever larger blocks of a map.

use crate::DepthMap;

/// Smallest and largest depth of every block of 2ˡ × 2ˡ cells, for every level l from 1 to the one that covers all.
///
/// Level l has ⌈n/2ˡ⌉ blocks along a side of n cells. Level 0, the cells themselves, is not stored: it is the map.
#[derive(Debug, Clone, PartialEq)]
pub struct MinMaxPyramid {
    size: (u32, u32),
    levels: Vec<Level>,
}

#[derive(Debug, Clone, PartialEq)]
struct Level {
    width: usize,
    ranges: Vec<[f32; 2]>,
}

impl MinMaxPyramid {
    /// Over the texels of one face.
    ///
    /// # Panics
    /// If the map has no such face.
    pub fn of_texels(map: &DepthMap, face: usize) -> Self {
        let (depths, width) = (map.face(face), map.size().0 as usize);
        Self::build(map.size(), |x, y| {
            let depth = depths[y * width + x];
            [depth, depth]
        })
    }

    /// Over the cells between texel centres of one face: a map of n texels a side has n − 1, and a cell's range is
    /// that of its four corners. It bounds the surface of [`MapSurface::Linear`](crate::MapSurface::Linear).
    ///
    /// # Panics
    /// If the map has no such face.
    pub fn of_cells(map: &DepthMap, face: usize) -> Self {
        Self::between(map.face(face), map.size())
    }

    /// Over the cells between nodes.
    pub(crate) fn between(nodes: &[f32], size: (u32, u32)) -> Self {
        let width = size.0 as usize;
        Self::build((size.0 - 1, size.1 - 1), |x, y| {
            let at = y * width + x;
            let corners = [nodes[at], nodes[at + 1], nodes[at + width], nodes[at + width + 1]];
            [corners.into_iter().fold(f32::INFINITY, f32::min), corners.into_iter().fold(0.0, f32::max)]
        })
    }

    fn build(size: (u32, u32), cell: impl Fn(usize, usize) -> [f32; 2]) -> Self {
        let mut levels: Vec<Level> = Vec::new();
        let (mut width, mut height) = (size.0 as usize, size.1 as usize);
        while width.max(height) > 1 {
            let below = levels.last();
            let read = |x: usize, y: usize| match below {
                Some(level) => level.ranges[y * level.width + x],
                None => cell(x, y),
            };
            let (w, h) = (width.div_ceil(2), height.div_ceil(2));
            let mut ranges = Vec::with_capacity(w * h);
            for y in 0..h {
                for x in 0..w {
                    let mut range = read(2 * x, 2 * y);
                    let mut grow = |x: usize, y: usize| {
                        let [min, max] = read(x, y);
                        range = [range[0].min(min), range[1].max(max)];
                    };
                    let (right, lower) = (2 * x + 1 < width, 2 * y + 1 < height);
                    if right {
                        grow(2 * x + 1, 2 * y);
                    }
                    if lower {
                        grow(2 * x, 2 * y + 1);
                    }
                    if right && lower {
                        grow(2 * x + 1, 2 * y + 1);
                    }
                    ranges.push(range);
                }
            }
            levels.push(Level { width: w, ranges });
            (width, height) = (w, h);
        }
        Self { size, levels }
    }

    /// Cells of level 0 (columns, rows).
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// The level whose one block covers everything; 0 for a single cell.
    pub fn top(&self) -> u32 {
        self.levels.len() as u32
    }

    /// Blocks of `level` (columns, rows); level 0 gives the cells.
    pub fn level_size(&self, level: u32) -> (u32, u32) {
        (self.size.0.div_ceil(1 << level), self.size.1.div_ceil(1 << level))
    }

    /// Ranges (smallest, largest depth) of a level from 1 on, row-major; units: m.
    ///
    /// # Panics
    /// If there is no such level.
    pub fn level(&self, level: u32) -> &[[f32; 2]] {
        &self.levels[level as usize - 1].ranges
    }

    /// Range of a block of a level from 1 on; units: m.
    #[inline]
    pub(crate) fn range(&self, level: u32, x: u32, y: u32) -> (f64, f64) {
        let level = &self.levels[level as usize - 1];
        let [min, max] = level.ranges[y as usize * level.width + x as usize];
        (f64::from(min), f64::from(max))
    }

    /// Memory; units: bytes.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(&*level.ranges)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Projection;
    use glam::{DVec2, DVec3};
    use proptest::prelude::*;

    fn map(size: (u32, u32), depths: Vec<f32>) -> DepthMap {
        let projection = Projection::orthographic(DVec3::ZERO, DVec3::Z, DVec3::X, DVec2::ONE).unwrap();
        DepthMap::new(projection, size, depths).unwrap()
    }

    #[test]
    fn pyramid_by_hand() {
        let map = map((3, 2), vec![1.0, 5.0, 2.0, 4.0, 3.0, f32::INFINITY]);
        let texels = MinMaxPyramid::of_texels(&map, 0);
        assert_eq!((texels.top(), texels.level_size(1), texels.level_size(2)), (2, (2, 1), (1, 1)));
        assert_eq!(texels.level(1), [[1.0, 5.0], [2.0, f32::INFINITY]]);
        assert_eq!(texels.level(2), [[1.0, f32::INFINITY]]);
        let cells = MinMaxPyramid::of_cells(&map, 0);
        assert_eq!((cells.size(), cells.top()), ((2, 1), 1));
        assert_eq!(cells.level(1), [[1.0, f32::INFINITY]]);
    }

    #[test]
    fn single_texels_and_rows() {
        assert_eq!(MinMaxPyramid::of_texels(&map((1, 1), vec![1.0]), 0).top(), 0);
        let row = map((5, 1), vec![3.0, 1.0, 4.0, 1.0, 5.0]);
        assert_eq!(MinMaxPyramid::of_texels(&row, 0).level(3), [[1.0, 5.0]]);
        let none = MinMaxPyramid::of_cells(&row, 0);
        assert_eq!(none.size(), (4, 0));
        assert!(none.level(2).is_empty());
    }

    proptest! {
        #[test]
        fn every_block_has_the_range_of_its_texels(
            width in 1_u32..20, height in 1_u32..20, seed in prop::collection::vec(0.0_f32..9.0, 400),
        ) {
            let depths = seed[..(width * height) as usize].to_vec();
            let map = map((width, height), depths);
            let pyramid = MinMaxPyramid::of_texels(&map, 0);
            for level in 1..=pyramid.top() {
                let (w, h) = pyramid.level_size(level);
                prop_assert_eq!(pyramid.level(level).len(), (w * h) as usize);
                for by in 0..h {
                    for bx in 0..w {
                        let (mut min, mut max) = (f64::INFINITY, 0.0_f64);
                        for y in by << level..((by + 1) << level).min(height) {
                            for x in bx << level..((bx + 1) << level).min(width) {
                                let depth = f64::from(map.depth(0, x, y));
                                (min, max) = (min.min(depth), max.max(depth));
                            }
                        }
                        prop_assert_eq!(pyramid.range(level, bx, by), (min, max));
                    }
                }
            }
        }
    }
}
