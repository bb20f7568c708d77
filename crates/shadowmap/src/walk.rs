//! The walk of a view ray over a grid of cells, flat and hierarchical.
//!
//! Both cut the ray at the same places, the roots of linear functions, and hand the same pieces to the cells. Which side
//! of a border a piece lies on is read from the sign of that function, never from a rounded coordinate, so that a ray
//! can neither skip a cell nor get stuck on a border.

use scene::Interval;

use crate::face::Path;
use crate::linear::Linear;
use crate::pieces::Pieces;

/// A grid of cells between integer coordinates, each of which decides where a ray through it is lit.
pub(crate) trait Cells {
    /// Columns and rows.
    fn size(&self) -> (u32, u32);

    /// Level of the block that covers all cells.
    fn top(&self) -> u32;

    /// Range of the depths at which light ends in a block of level 1 or more.
    fn range(&self, level: u32, x: u32, y: u32) -> (f64, f64);

    /// Adds the lit parts of `piece`, which lies in cell (`x`, `y`).
    fn cell(&self, x: u32, y: u32, path: &Path, piece: Interval, out: &mut Pieces<'_>);
}

/// How blocks of cells are treated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Walk {
    /// Every cell that the ray crosses.
    Flat,
    /// Blocks that are lit or dark as a whole are taken as a whole.
    Hierarchical,
}

/// Adds the lit parts of `piece`, on which the path lies within the grid; in order along the ray.
pub(crate) fn walk<C: Cells>(cells: &C, path: &Path, piece: Interval, how: Walk, out: &mut Pieces<'_>) {
    let (width, height) = cells.size();
    if piece.is_empty() || width == 0 || height == 0 {
        return;
    }
    match how {
        Walk::Flat => flat(cells, path, piece, out),
        Walk::Hierarchical => Descent { cells, path, out }.block(cells.top(), 0, 0, piece),
    }
}

/// A walk from large blocks to small ones.
struct Descent<'a, 'b, 'c, C> {
    cells: &'a C,
    path: &'a Path,
    out: &'b mut Pieces<'c>,
}

impl<C: Cells> Descent<'_, '_, '_, C> {
    fn block(&mut self, level: u32, x: u32, y: u32, piece: Interval) {
        if piece.is_empty() {
            return;
        }
        if level == 0 {
            self.cells.cell(x, y, self.path, piece, self.out);
            return;
        }
        let (min, max) = self.cells.range(level, x, y);
        let (a, b) = (self.path.depth.at(piece.start), self.path.depth.at(piece.end));
        if a.max(b) <= min {
            self.out.push(piece);
            return;
        }
        if a.min(b) > max {
            return;
        }
        let (width, height) = self.cells.size();
        let (cut_x, left_x, right_x) = self.halve(self.path.u, level, x, width, piece);
        let (cut_y, left_y, right_y) = self.halve(self.path.v, level, y, height, piece);
        // up to three children along the ray
        let (near, far) = (cut_x.min(cut_y), cut_x.max(cut_y));
        self.block(level - 1, left_x, left_y, Interval::new(piece.start, near));
        let (x, y) = if cut_x < cut_y { (right_x, left_y) } else { (left_x, right_y) };
        self.block(level - 1, x, y, Interval::new(near, far));
        self.block(level - 1, right_x, right_y, Interval::new(far, piece.end));
    }

    /// Where the ray crosses the middle of a block, and the children before and after.
    #[inline]
    fn halve(&self, along: Linear, level: u32, index: u32, count: u32, piece: Interval) -> (f64, u32, u32) {
        let middle = (2 * index + 1) << (level - 1);
        if middle >= count {
            return (piece.end, 2 * index, 2 * index);
        }
        let (cut, before, after) = border(along, self.path.w, middle).split(piece);
        (cut, 2 * index + u32::from(before), 2 * index + u32::from(after))
    }
}

/// Positive beyond the border at `index` of the coordinate `along`/`w`.
#[inline]
fn border(along: Linear, w: Linear, index: u32) -> Linear {
    along - w * f64::from(index)
}

/// One coordinate of a flat walk.
struct Axis {
    along: Linear,
    w: Linear,
    /// Whether the coordinate grows (1), shrinks (−1) or stays (0) along the ray.
    direction: f64,
    index: u32,
    count: u32,
}

impl Axis {
    fn new(along: Linear, w: Linear, count: u32, piece: Interval) -> Self {
        // sign of the derivative of along/w
        let growth = along.slope * w.offset - along.offset * w.slope;
        let direction = if growth == 0.0 { 0.0 } else { growth.signum() };
        // the last border that the ray is beyond at the start
        let start = Interval::new(piece.start, piece.start);
        let (mut low, mut high) = (0, count);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            let function = border(along, w, middle);
            let beyond = if function.slope > 0.0 {
                function.root() <= start.start
            } else if function.slope < 0.0 {
                function.root() > start.start
            } else {
                function.offset >= 0.0
            };
            if beyond {
                low = middle;
            } else {
                high = middle;
            }
        }
        Self { along, w, direction, index: low, count }
    }

    /// Where the ray leaves the column.
    #[inline]
    fn exit(&self) -> f64 {
        let next = if self.direction > 0.0 {
            self.index + 1
        } else if self.direction < 0.0 {
            self.index
        } else {
            return f64::INFINITY;
        };
        if next == 0 || next == self.count {
            return f64::INFINITY;
        }
        let function = border(self.along, self.w, next);
        if function.slope * self.direction > 0.0 { function.root() } else { f64::INFINITY }
    }

    fn advance(&mut self) {
        if self.direction > 0.0 {
            self.index += 1;
        } else {
            self.index -= 1;
        }
    }
}

fn flat<C: Cells>(cells: &C, path: &Path, piece: Interval, out: &mut Pieces<'_>) {
    let (width, height) = cells.size();
    let mut columns = Axis::new(path.u, path.w, width, piece);
    let mut rows = Axis::new(path.v, path.w, height, piece);
    let (mut exit_x, mut exit_y) = (columns.exit(), rows.exit());
    let mut from = piece.start;
    loop {
        let to = exit_x.min(exit_y).min(piece.end);
        cells.cell(columns.index, rows.index, path, Interval::new(from, to), out);
        if to >= piece.end {
            return;
        }
        from = from.max(to);
        if exit_x <= exit_y {
            columns.advance();
            exit_x = columns.exit();
        } else {
            rows.advance();
            exit_y = rows.exit();
        }
    }
}
