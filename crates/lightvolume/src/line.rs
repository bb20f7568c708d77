//! A view ray among triangles, and where it crosses one.
//!
//! Everything happens in the plane that holds the ray and the light. An edge between two vertices *crosses* that plane if
//! they lie on its two sides, and there the ray passes it either on the light's side (the edge is *lit*) or behind it.
//! A triangle that crosses the plane does so with two of its edges; if one is lit and the other is not, the ray goes
//! through the triangle between them.
//!
//! Both questions are asked of the vertex or edge alone, in one order, so that the two triangles of an edge get the very
//! same answer. Over a closed mesh the signs of the crossings then sum to exactly 0, whatever is rounded: each lit edge
//! that crosses the plane counts +1 for one of its triangles and −1 for the other.

use glam::DVec3;
use media_math::Crossing;

use crate::vertex::Point;

/// Share of what a sum may be at most below which it is rounding.
const ROUNDING: f64 = 1e-13;

/// Share of what it may be at most below which a triangle's slope along the ray has too few digits left to say where the
/// two meet.
const GRAZING: f64 = 1e-7;

/// Share of heights by which a ray must clear a box of triangles that it is not asked to cross one by one: well above all
/// rounding in those questions.
const CLEAR: f64 = 1e-7;

/// Length of the normal of the plane of a ray through the light, which any plane through the ray may be.
const TINY: f64 = 1e-200;

/// A view ray, measured from its point nearest to the light in the coordinates of vertices.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    from: Point,
    along: Point,
    /// Distance of `from` along the ray; units: m.
    shift: f64,
    /// What a metre along any ray adds at most: its rounding is a share of that.
    most: Point,
    /// Normal of the plane through the ray and the light.
    normal: DVec3,
    /// The part of lit or not that does not depend on heights: h_o d − h_d o.
    reach: DVec3,
    /// Height of the ray over a place in its plane: a linear function, this times the place. 0 for a ray through the light,
    /// over which nothing can be said.
    height: DVec3,
    /// Whether the light is a point.
    perspective: bool,
}

/// A box around vertices: their places, and their heights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
    pub(crate) lowest: f64,
    pub(crate) highest: f64,
}

impl Block {
    pub(crate) const EMPTY: Self = Self {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
        lowest: f64::INFINITY,
        highest: f64::NEG_INFINITY,
    };

    pub(crate) fn of(point: &Point) -> Self {
        Self { low: point.place, high: point.place, lowest: point.height, highest: point.height }
    }

    pub(crate) fn union(self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            lowest: self.lowest.min(other.lowest),
            highest: self.highest.max(other.highest),
        }
    }

    /// The corners of the box least and farthest along a direction.
    #[inline]
    fn ends(&self, direction: DVec3) -> (DVec3, DVec3) {
        let positive = direction.cmpge(DVec3::ZERO);
        (DVec3::select(positive, self.low, self.high), DVec3::select(positive, self.high, self.low))
    }
}

impl Line {
    /// From the ray's origin, what a metre along it adds, and what a metre along any ray adds at most.
    pub(crate) fn new([origin, along]: [Point; 2], most: Point, perspective: bool) -> Self {
        let square = along.place.length_squared();
        // an orthographic light is at infinity: no point is nearest to it
        let shift = if perspective { -origin.place.dot(along.place) / square } else { 0.0 };
        let from =
            Point { place: origin.place + shift * along.place, height: origin.height + shift * along.height };
        let mut normal = from.place.cross(along.place);
        if normal == DVec3::ZERO {
            // through the light, or parallel to it
            let axis = if square > 0.0 { along.place } else { from.place };
            normal = TINY * axis.any_orthogonal_vector().try_normalize().unwrap_or(DVec3::X);
        }
        let reach = from.height * along.place - along.height * from.place;
        let height = reach.cross(normal) / normal.length_squared();
        let height = if height.is_finite() { height } else { DVec3::ZERO };
        Self { from, along, shift, most, normal, reach, height, perspective }
    }

    /// On which side of the ray's plane a vertex lies. Monotone in each coordinate, rounding included.
    #[inline]
    pub(crate) fn side(&self, place: DVec3) -> f64 {
        self.normal.dot(place)
    }

    /// Whether the ray may cross a triangle in a box: vertices lie on both sides of its plane, and it does not pass all of
    /// them far on the light's side or far behind.
    #[inline]
    pub(crate) fn cuts(&self, block: &Block) -> bool {
        let (least, most) = block.ends(self.normal);
        if self.side(most) < 0.0 || self.side(least) >= 0.0 {
            return false;
        }
        if self.height == DVec3::ZERO {
            return true;
        }
        let (least, most) = block.ends(self.height);
        let size = self.height.abs().dot(block.low.abs().max(block.high.abs()));
        let slack = CLEAR * (size + block.lowest.abs().max(block.highest.abs()));
        let (least, most) = (self.height.dot(least), self.height.dot(most));
        !(least > block.highest + slack || most < block.lowest - slack)
    }

    /// Whether the ray passes on the light's side of an edge that crosses its plane from `a`, where `side` is at least 0,
    /// to `b`.
    #[inline]
    fn is_lit(&self, (a, side_a): (&Point, f64), (b, side_b): (&Point, f64)) -> bool {
        self.reach.dot(a.place.cross(b.place)) + (a.height * side_b - b.height * side_a) >= 0.0
    }

    /// Where the ray crosses a triangle, and how; `None` if it does not. Units: m, infinite where the two meet there.
    #[inline]
    pub(crate) fn crossing(&self, [a, b, c]: [&Point; 3]) -> Option<(f64, Crossing)> {
        let corners = [a, b, c].map(|point| (point, self.side(point.place)));
        let behind = corners.map(|(_, side)| side < 0.0);
        // the corner that is alone on its side
        let alone = match behind {
            [x, y, z] if x == y && y == z => return None,
            [x, y, z] if y == z && x != y => 0,
            [x, _, z] if x == z => 1,
            _ => 2,
        };
        let (apex, next, last) = (corners[alone], corners[(alone + 1) % 3], corners[(alone + 2) % 3]);
        // the edges around it, from the side of the plane that its normal points to
        let edge = |other| if behind[alone] { (other, apex) } else { (apex, other) };
        let ((p, q), (r, s)) = (edge(next), edge(last));
        let lit = [self.is_lit(p, q), self.is_lit(r, s)];
        if lit[0] == lit[1] {
            return None;
        }
        // a lit edge that runs, in the triangle's own order, with the plane's normal behind it
        let crossing = if lit[0] != behind[alone] { Crossing::LeavesLight } else { Crossing::EntersLight };
        let (lit, dark) = if lit[0] { ((p.0, q.0), (r.0, s.0)) } else { ((r.0, s.0), (p.0, q.0)) };
        Some((self.shift + self.meeting([a, b, c], lit, dark, crossing), crossing))
    }

    /// Where the ray meets a triangle, between an edge that it passes lit and one that it does not.
    ///
    /// The root of f(t) = h det(a, b, c) − x·(h_a b × c + h_b c × a + h_c a × b) at x = o + t d, h = h_o + t h_d, written
    /// from a corner so that large coordinates cancel before they are multiplied.
    #[inline]
    fn meeting(
        &self,
        [a, b, c]: [&Point; 3],
        lit: (&Point, &Point),
        dark: (&Point, &Point),
        crossing: Crossing,
    ) -> f64 {
        let (e, f) = (b.place - a.place, c.place - a.place);
        let area = e.cross(f);
        let slope = (c.height - a.height) * e - (b.height - a.height) * f;
        let volume = a.place.dot(area);
        let value = |x: &Point| {
            x.height * volume - (a.height * x.place.dot(area) + x.place.cross(a.place).dot(slope))
        };
        let (along, growth) = (&self.along, value(&self.along));
        let turn = {
            let (x, y) = (self.most.place, a.place.abs());
            DVec3::new(x.y * y.z + x.z * y.y, x.z * y.x + x.x * y.z, x.x * y.y + x.y * y.x)
        };
        let terms = self.most.height * volume.abs()
            + a.height.abs() * self.most.place.dot(area.abs())
            + turn.dot(slope.abs());
        // parallel: they meet at infinity, on the side to which the triangle lies
        let parallel = growth.abs() <= ROUNDING * terms;
        let at = if parallel {
            f64::INFINITY.copysign(along.place.dot(area))
        } else {
            -value(&self.from) / growth
        };
        if growth.abs() > GRAZING * terms {
            return at;
        }
        // all but in the triangle's plane: somewhere between the two edges
        let (lit, dark) = (self.passing(lit), self.passing(dark));
        let (first, last) = if crossing == Crossing::LeavesLight { (lit, dark) } else { (dark, lit) };
        let at = first.map_or(at, |first| at.max(first));
        last.map_or(at, |last| at.min(last))
    }

    /// Where the ray passes before or behind an edge; `None` where it does not, or too slowly to say.
    #[inline]
    fn passing(&self, (a, b): (&Point, &Point)) -> Option<f64> {
        let wall = a.place.cross(b.place);
        let speed = wall.dot(self.along.place);
        let clear = speed.abs() > ROUNDING * wall.abs().dot(self.most.place);
        // the half of a line through a point light that lies behind it is not the edge's
        let passed = !self.perspective || wall.dot(self.reach) > 0.0;
        (clear && passed).then(|| -wall.dot(self.from.place) / speed)
    }
}
