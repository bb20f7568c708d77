//! The quadtree over a map's cells: which quads there are, and where their corners lie.
//!
//! A quad of level l is 2^l cells a side, clamped to the map: one that sticks out is a smaller rectangle, and one of
//! which nothing is left does not exist. Level 0 is a cell between four nodes.

/// The quads over a grid of cells, at least one a side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quads {
    /// Columns and rows of cells.
    pub(crate) cells: (u32, u32),
}

/// A quad's corners in node coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Corners {
    pub(crate) x0: u32,
    pub(crate) y0: u32,
    pub(crate) x1: u32,
    pub(crate) y1: u32,
}

impl Quads {
    /// The quads between `nodes` (columns, rows); `None` where there is no cell.
    pub(crate) fn new(nodes: (u32, u32)) -> Option<Self> {
        (nodes.0 > 1 && nodes.1 > 1).then(|| Self { cells: (nodes.0 - 1, nodes.1 - 1) })
    }

    /// Level of the root, the smallest quad over all cells.
    pub(crate) fn top(&self) -> u32 {
        self.cells.0.max(self.cells.1).next_power_of_two().trailing_zeros()
    }

    /// Columns and rows of quads of a level.
    pub(crate) fn count(&self, level: u32) -> (u32, u32) {
        let side = 1 << level;
        (self.cells.0.div_ceil(side), self.cells.1.div_ceil(side))
    }

    /// Where a quad's corners lie, clamped.
    #[inline]
    pub(crate) fn corners(&self, level: u32, x: u32, y: u32) -> Corners {
        let clamp = |at: u32, cells: u32| (at << level).min(cells);
        Corners {
            x0: clamp(x, self.cells.0),
            y0: clamp(y, self.cells.1),
            x1: clamp(x + 1, self.cells.0),
            y1: clamp(y + 1, self.cells.1),
        }
    }

    /// The middles of a quad of level 1 or more, clamped: where its children meet.
    #[inline]
    pub(crate) fn middle(&self, level: u32, x: u32, y: u32) -> (u32, u32) {
        let middle = |at: u32, cells: u32| ((2 * at + 1) << (level - 1)).min(cells);
        (middle(x, self.cells.0), middle(y, self.cells.1))
    }

    /// Whether a quad sticks out of the map.
    #[inline]
    pub(crate) fn straddles(&self, level: u32, x: u32, y: u32) -> bool {
        (x + 1) << level > self.cells.0 || (y + 1) << level > self.cells.1
    }

    /// Whether a quad has a side on the map's border.
    #[inline]
    pub(crate) fn at_border(&self, level: u32, x: u32, y: u32) -> bool {
        x == 0 || y == 0 || (x + 1) << level >= self.cells.0 || (y + 1) << level >= self.cells.1
    }

    /// The quads of the next level down that a quad is made of.
    #[inline]
    pub(crate) fn children(&self, level: u32, x: u32, y: u32) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (columns, rows) = self.count(level - 1);
        [(0, 0), (1, 0), (0, 1), (1, 1)]
            .map(|(i, j)| (2 * x + i, 2 * y + j))
            .into_iter()
            .filter(move |&(x, y)| x < columns && y < rows)
    }
}

/// One value for each quad of a level.
#[derive(Debug, Clone)]
pub(crate) struct Layer<T> {
    size: (u32, u32),
    values: Vec<T>,
}

impl<T: Copy> Layer<T> {
    /// A layer of `size` (columns, rows) with `value` of every quad, row by row.
    pub(crate) fn new(size: (u32, u32), mut value: impl FnMut(u32, u32) -> T) -> Self {
        let mut values = Vec::with_capacity(size.0 as usize * size.1 as usize);
        for y in 0..size.1 {
            values.extend((0..size.0).map(|x| value(x, y)));
        }
        Self { size, values }
    }

    pub(crate) fn size(&self) -> (u32, u32) {
        self.size
    }

    /// The value of a quad; `None` where there is no such quad.
    #[inline]
    pub(crate) fn get(&self, x: u32, y: u32) -> Option<T> {
        let inside = x < self.size.0 && y < self.size.1;
        inside.then(|| self.values[y as usize * self.size.0 as usize + x as usize])
    }

    /// Changes the value of a quad that exists.
    pub(crate) fn set(&mut self, x: u32, y: u32, value: T) {
        if x < self.size.0 && y < self.size.1 {
            self.values[y as usize * self.size.0 as usize + x as usize] = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quads_by_hand() {
        assert!(Quads::new((1, 9)).is_none() && Quads::new((9, 1)).is_none());
        assert_eq!(Quads::new((2, 2)).unwrap().top(), 0);
        let quads = Quads::new((8, 3)).unwrap(); // 7 × 2 cells
        assert_eq!(
            (quads.top(), quads.count(0), quads.count(1), quads.count(3)),
            (3, (7, 2), (4, 1), (1, 1))
        );
        assert_eq!(quads.corners(2, 1, 0), Corners { x0: 4, y0: 0, x1: 7, y1: 2 });
        assert_eq!(quads.middle(2, 1, 0), (6, 2));
        assert!(quads.straddles(2, 0, 0) && !quads.straddles(1, 2, 0) && quads.straddles(1, 3, 0));
        assert_eq!(quads.children(1, 3, 0).collect::<Vec<_>>(), [(6, 0), (6, 1)]);
        assert_eq!(quads.children(2, 1, 0).collect::<Vec<_>>(), [(2, 0), (3, 0)]);
        assert!(quads.at_border(1, 1, 0));
        assert!(!Quads::new((9, 9)).unwrap().at_border(1, 1, 2));
    }
}
