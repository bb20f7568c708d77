//! The linear surface of a cube map between its faces: twelve strips along the edges, eight triangles at the corners.
//!
//! With h = 1/n for n texels a side, the outermost centres of a face lie h short of its edge. A strip joins the outermost
//! centres of two faces: its node (i, 0) is the i-th of the face of lower index along the edge, counted along the
//! positive axis of the world, and (i, 1) the i-th of the other; its cells are cut by the same diagonal as any other,
//! from (i + 1, 0) to (i, 1). The three centres next to a corner of the cube are closed by one triangle.
//!
//! Strips and corners are grids in homogeneous coordinates like the faces. With a, b the coordinates along the axes of
//! the two faces and c along the edge, a strip has W = a + b, V = (b − (1 − h) a)/h and
//! U = (n/2)(2 − h) c + (n − 1)/2 · W. A corner has W = a + b + c and the barycentric coordinates of b's and c's centres
//! as U and V. Depth is the W of the centres, which is 2 − h and 3 − 2h times theirs.

use std::borrow::Cow;

use glam::DVec3;
use scene::{DRay, Interval};

use crate::cells::Triangles;
use crate::cube::{axis_of, face_of, texel_at};
use crate::face::Path;
use crate::linear::Linear;
use crate::pieces::Pieces;
use crate::walk::{Walk, walk};
use crate::{DepthMap, Projection};

/// The surface between the faces of a cube map.
#[derive(Debug)]
pub(crate) struct Seams {
    light: DVec3,
    n: f64,
    strips: Vec<Strip>,
    corners: Vec<Corner>,
}

/// Axes and signs of the faces on either side, and the axis along the edge.
#[derive(Debug)]
struct Strip {
    a: (usize, f64),
    b: (usize, f64),
    c: usize,
    triangles: Triangles<'static>,
}

/// Signs of the three axes, and the triangle.
#[derive(Debug)]
struct Corner {
    signs: [f64; 3],
    triangles: Triangles<'static>,
}

/// Depth of the texel of `face` whose centre lies towards `w` from the light.
fn towards(map: &DepthMap, face: usize, w: DVec3) -> f32 {
    let (x, y) = texel_at(face, w, map.size().0);
    map.depth(face, x, y)
}

fn grid(nodes: Vec<f32>, columns: u32, bias: f64, depth_per_w: f64) -> Triangles<'static> {
    let mut triangles = Triangles::new(Cow::Owned(nodes), (columns, 2), bias, true);
    triangles.depth_per_w = depth_per_w;
    triangles
}

impl Seams {
    pub(crate) fn new(map: &DepthMap, bias: f64) -> Self {
        let n = map.size().0;
        let count = f64::from(n);
        let h = 1.0 / count;
        let mut strips = Vec::with_capacity(12);
        for face_a in 0..4 {
            // the faces of higher index that are not opposite
            for face_b in 2 * (face_a / 2) + 2..6 {
                let (a, b) = (axis_of(face_a), axis_of(face_b));
                let c = 3 - a.0 - b.0;
                let mut nodes = Vec::with_capacity(2 * n as usize);
                for (own, other, face) in [(a, b, face_a), (b, a, face_b)] {
                    for i in 0..n {
                        let mut w = DVec3::ZERO;
                        w[own.0] = own.1;
                        w[other.0] = (1.0 - h) * other.1;
                        w[c] = (2.0 * f64::from(i) + 1.0) * h - 1.0;
                        nodes.push(towards(map, face, w));
                    }
                }
                strips.push(Strip { a, b, c, triangles: grid(nodes, n, bias, 1.0 / (2.0 - h)) });
            }
        }
        let corners = (0..8).map(|bits| {
            let signs = [0, 1, 2].map(|axis| if bits >> axis & 1 == 0 { 1.0 } else { -1.0 });
            let [x, y, z] = [0, 1, 2].map(|axis| {
                let mut w = DVec3::from(signs) * (1.0 - h);
                w[axis] = signs[axis];
                towards(map, face_of(axis, signs[axis] < 0.0), w)
            });
            // the fourth node lies behind the diagonal, where the corner ends
            Corner { signs, triangles: grid(vec![x, y, z, y], 2, bias, 1.0 / (3.0 - 2.0 * h)) }
        });
        let light = map.projection().faces()[0].origin;
        Self { light, n: count, strips, corners: corners.collect() }
    }

    /// Memory; units: bytes.
    pub(crate) fn bytes(&self) -> usize {
        let grids = self.strips.iter().map(|s| &s.triangles).chain(self.corners.iter().map(|c| &c.triangles));
        grids.map(|grid| size_of_val(&*grid.nodes) + grid.pyramid.bytes()).sum()
    }

    /// Adds the lit parts of `span` in the directions between the faces' outermost centres.
    pub(crate) fn walk(&self, ray: &DRay, span: Interval, how: Walk, out: &mut Pieces<'_>) {
        let from = ray.origin - self.light;
        let axis = |axis: usize, sign: f64| Linear::new(sign * from[axis], sign * ray.direction[axis]);
        for strip in &self.strips {
            let (a, b) = (axis(strip.a.0, strip.a.1), axis(strip.b.0, strip.b.1));
            let piece = strip_domain(a, b, axis(strip.c, 1.0), self.n, span);
            if !piece.is_empty() {
                walk(&strip.triangles, &strip_path(a, b, axis(strip.c, 1.0), self.n), piece, how, out);
            }
        }
        for corner in &self.corners {
            let [a, b, c] = [0, 1, 2].map(|i| axis(i, corner.signs[i]));
            let piece = corner_domain(a, b, c, self.n, span);
            if !piece.is_empty() {
                walk(&corner.triangles, &corner_path(a, b, c, self.n), piece, how, out);
            }
        }
    }

    /// Whether a point is lit that `face_domain` leaves to the seams.
    pub(crate) fn is_lit(&self, point: DVec3) -> bool {
        let w = point - self.light;
        let at = |axis: usize, sign: f64| Linear::constant(sign * w[axis]);
        let here = Interval::new(0.0, 1.0);
        let lit = |triangles: &Triangles<'_>, path: Path| {
            let w = path.w.offset;
            triangles.is_lit(path.u.offset / w, path.v.offset / w, path.depth.offset)
        };
        for corner in &self.corners {
            let [a, b, c] = [0, 1, 2].map(|i| at(i, corner.signs[i]));
            if !corner_domain(a, b, c, self.n, here).is_empty() {
                return lit(&corner.triangles, corner_path(a, b, c, self.n));
            }
        }
        for strip in &self.strips {
            let (a, b, c) = (at(strip.a.0, strip.a.1), at(strip.b.0, strip.b.1), at(strip.c, 1.0));
            // a map of one texel has no strip, only corners
            if strip.triangles.size.0 > 1 && !strip_domain(a, b, c, self.n, here).is_empty() {
                return lit(&strip.triangles, strip_path(a, b, c, self.n));
            }
        }
        // the light itself
        true
    }
}

/// The part of `span` in which `face` is within its outermost centres.
pub(crate) fn face_domain(
    projection: &Projection,
    face: usize,
    n: f64,
    ray: &DRay,
    span: Interval,
) -> Interval {
    within(projection, face, 1.0 - 1.0 / n, ray, span)
}

/// The part of `span` in which the other two coordinates are at most `reach` times that along the face's axis.
pub(crate) fn within(
    projection: &Projection,
    face: usize,
    reach: f64,
    ray: &DRay,
    span: Interval,
) -> Interval {
    let (own, sign) = axis_of(face);
    let from = ray.origin - projection.faces()[0].origin;
    let a = Linear::new(sign * from[own], sign * ray.direction[own]) * reach;
    let mut span = Linear::new(sign * from[own], sign * ray.direction[own]).nonnegative(span);
    for axis in (0..3).filter(|&axis| axis != own) {
        let b = Linear::new(from[axis], ray.direction[axis]);
        span = (a + b).nonnegative((a - b).nonnegative(span));
    }
    span
}

fn strip_domain(a: Linear, b: Linear, c: Linear, n: f64, span: Interval) -> Interval {
    let h = 1.0 / n;
    let reach = (a + b) * (1.0 - h);
    let width = c * (2.0 - h);
    let span = (b - a * (1.0 - h)).nonnegative((a - b * (1.0 - h)).nonnegative(span));
    (a + b).nonnegative((reach - width).nonnegative((reach + width).nonnegative(span)))
}

fn strip_path(a: Linear, b: Linear, c: Linear, n: f64) -> Path {
    let h = 1.0 / n;
    let w = a + b;
    Path {
        u: c * (0.5 * n * (2.0 - h)) + w * (0.5 * (n - 1.0)),
        v: (b - a * (1.0 - h)) * n,
        w,
        depth: w * (1.0 / (2.0 - h)),
    }
}

fn corner_domain(a: Linear, b: Linear, c: Linear, n: f64, span: Interval) -> Interval {
    let h = 1.0 / n;
    // beyond the end of the strip along x
    let beyond = |x: Linear, y: Linear, z: Linear| x * (2.0 - h) - (y + z) * (1.0 - h);
    let span = beyond(a, b, c).nonnegative(beyond(b, a, c).nonnegative(beyond(c, a, b).nonnegative(span)));
    (a + b + c).nonnegative(span)
}

fn corner_path(a: Linear, b: Linear, c: Linear, n: f64) -> Path {
    let h = 1.0 / n;
    let w = a + b + c;
    let share = |x: Linear| (x * (3.0 - 2.0 * h) - w * (1.0 - h)) * n;
    Path { u: share(b), v: share(c), w, depth: w * (1.0 / (3.0 - 2.0 * h)) }
}
