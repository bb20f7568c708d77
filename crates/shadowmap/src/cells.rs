//! What a cell of a map means: a step of constant depth, or two triangles between four texel centres.

use std::borrow::Cow;

use scene::Interval;

use crate::MinMaxPyramid;
use crate::face::Path;
use crate::linear::Linear;
use crate::pieces::Pieces;
use crate::walk::Cells;

/// The part of `piece` where `function` ≤ 0.
#[inline]
fn nonpositive(function: Linear, piece: Interval) -> Interval {
    (function * -1.0).nonnegative(piece)
}

/// Texels as steps: a point is lit if its depth is at most that of the texel it falls in, plus the bias.
#[derive(Debug)]
pub(crate) struct Steps<'a> {
    pub(crate) depths: &'a [f32],
    pub(crate) size: (u32, u32),
    pub(crate) pyramid: MinMaxPyramid,
    pub(crate) bias: f64,
}

impl Cells for Steps<'_> {
    #[inline]
    fn size(&self) -> (u32, u32) {
        self.size
    }

    #[inline]
    fn top(&self) -> u32 {
        self.pyramid.top()
    }

    #[inline]
    fn range(&self, level: u32, x: u32, y: u32) -> (f64, f64) {
        let (min, max) = self.pyramid.range(level, x, y);
        (min + self.bias, max + self.bias)
    }

    #[inline]
    fn cell(&self, x: u32, y: u32, path: &Path, piece: Interval, out: &mut Pieces<'_>) {
        let depth = f64::from(self.depths[y as usize * self.size.0 as usize + x as usize]) + self.bias;
        if depth == f64::INFINITY {
            out.push(piece);
        } else {
            out.push(nonpositive(path.depth - Linear::constant(depth), piece));
        }
    }
}

/// Nodes, the texel centres, joined by straight triangles; the diagonal of cell (x, y) joins the nodes (x + 1, y) and
/// (x, y + 1). Nodes have integer coordinates.
#[derive(Debug)]
pub(crate) struct Triangles<'a> {
    pub(crate) nodes: Cow<'a, [f32]>,
    /// Columns and rows of nodes.
    pub(crate) size: (u32, u32),
    pub(crate) pyramid: MinMaxPyramid,
    pub(crate) bias: f64,
    pub(crate) perspective: bool,
    /// `depth`/W of the path: 1 but on a cube's seams, where W is not the depth.
    pub(crate) depth_per_w: f64,
}

/// Sign of a triangle's height over (u, v) = (U/W, V/W) against a point's.
#[derive(Debug, Clone, Copy)]
struct Heights {
    corner: f64,
    du: f64,
    dv: f64,
}

impl<'a> Triangles<'a> {
    pub(crate) fn new(nodes: Cow<'a, [f32]>, size: (u32, u32), bias: f64, perspective: bool) -> Self {
        let pyramid = MinMaxPyramid::between(&nodes, size);
        Self { nodes, size, pyramid, bias, perspective, depth_per_w: 1.0 }
    }

    /// The four corners of a cell with their bias: (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1).
    #[inline]
    fn corners(&self, x: u32, y: u32) -> [f64; 4] {
        let width = self.size.0 as usize;
        let at = y as usize * width + x as usize;
        [at, at + 1, at + width, at + width + 1].map(|i| f64::from(self.nodes[i]) + self.bias)
    }

    /// Heights of a cell's upper left (`lower` false) or lower right triangle, from the corner opposite the diagonal.
    ///
    /// Heights are linear in (u, v): 1/z in perspective, −z in orthographic, so that more height is nearer the light.
    /// `None` where the surface is infinitely far.
    #[inline]
    fn heights(&self, corners: [f64; 4], lower: bool) -> Option<Heights> {
        let [corner, along_u, along_v] =
            if lower { [corners[3], corners[2], corners[1]] } else { [corners[0], corners[1], corners[2]] };
        if self.perspective {
            let corner = self.depth_per_w / corner;
            let heights = Heights {
                corner,
                du: self.depth_per_w / along_u - corner,
                dv: self.depth_per_w / along_v - corner,
            };
            return Some(heights);
        }
        // the limit of a triangle with a corner that moves away is nowhere but at infinity
        let finite = corner.max(along_u).max(along_v) < f64::INFINITY;
        finite.then_some(Heights { corner: -corner, du: corner - along_u, dv: corner - along_v })
    }

    /// Whether a point at (`u`, `v`) and `depth` lies before the surface.
    pub(crate) fn is_lit(&self, u: f64, v: f64, depth: f64) -> bool {
        let cell = |at: f64, nodes: u32| (at.max(0.0) as u32).min(nodes - 2);
        let (x, y) = (cell(u, self.size.0), cell(v, self.size.1));
        let (u, v) = (u - f64::from(x), v - f64::from(y));
        let lower = u + v > 1.0;
        let Some(heights) = self.heights(self.corners(x, y), lower) else {
            return true;
        };
        let (u, v) = if lower { (1.0 - u, 1.0 - v) } else { (u, v) };
        let height = (heights.corner + u * heights.du + v * heights.dv) / self.depth_per_w;
        // height ≤ that of the point
        if self.perspective { height * depth <= 1.0 } else { height <= -depth }
    }
}

impl Cells for Triangles<'_> {
    #[inline]
    fn size(&self) -> (u32, u32) {
        (self.size.0 - 1, self.size.1 - 1)
    }

    #[inline]
    fn top(&self) -> u32 {
        self.pyramid.top()
    }

    #[inline]
    fn range(&self, level: u32, x: u32, y: u32) -> (f64, f64) {
        let (min, max) = self.pyramid.range(level, x, y);
        (min + self.bias, max + self.bias)
    }

    fn cell(&self, x: u32, y: u32, path: &Path, piece: Interval, out: &mut Pieces<'_>) {
        if piece.is_empty() {
            return;
        }
        let corners = self.corners(x, y);
        let (a, b) = (path.depth.at(piece.start), path.depth.at(piece.end));
        let [c0, c1, c2, c3] = corners;
        if a.max(b) <= c0.min(c1).min(c2.min(c3)) {
            out.push(piece);
            return;
        }
        if a.min(b) > c0.max(c1).max(c2.max(c3)) {
            return;
        }
        let (u, v) = (path.u - path.w * f64::from(x), path.v - path.w * f64::from(y));
        let (cut, before, after) = (u + v - path.w).split(piece);
        for (lower, part) in
            [(before, Interval::new(piece.start, cut)), (after, Interval::new(cut, piece.end))]
        {
            if part.is_empty() {
                continue;
            }
            let Some(heights) = self.heights(corners, lower) else {
                out.push(part);
                continue;
            };
            let (u, v) = if lower { (path.w - u, path.w - v) } else { (u, v) };
            let height = path.w * heights.corner + u * heights.du + v * heights.dv;
            let own = if self.perspective { Linear::constant(1.0) } else { path.depth * -1.0 };
            out.push(nonpositive(height - own, part));
        }
    }
}
