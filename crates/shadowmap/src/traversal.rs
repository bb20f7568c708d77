//! The exact lit pieces of a view ray against one map, by traversal: nothing is sampled.

use std::borrow::Cow;

use glam::DVec3;
use scene::{DRay, Interval};

use crate::cells::{Steps, Triangles};
use crate::cube::face_towards;
use crate::face::Path;
use crate::pieces::Pieces;
use crate::seams::{Seams, face_domain, within};
use crate::walk::{Cells, Walk, walk};
use crate::{Bias, DepthMap, MinMaxPyramid, Outside, ProjectionKind};

/// What a map says about the space between its texel centres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MapSurface {
    /// Texels are steps: a point is lit if its depth is at most that of the texel it falls in. What a nearest lookup
    /// sees, so that a march with such lookups converges to it.
    #[default]
    Step,
    /// Texel centres, moved to their depth, are joined by straight triangles in the world: a quad per four centres,
    /// cut from (x + 1, y) to (x, y + 1). What a light volume encloses.
    ///
    /// The outermost centres of neighbouring cube faces are joined as well and the corners closed by a triangle; the
    /// other projections enclose nothing outside their outermost centres, where [`DepthMap::outside`] holds.
    /// In perspective, a centre at infinite depth is the limit of one that moves away. In an orthographic map that limit
    /// takes every triangle at that centre away with it: there, all is lit.
    Linear,
}

/// Traversal of one map.
#[derive(Debug)]
pub struct MapTraversal<'a> {
    map: &'a DepthMap,
    surface: Surface<'a>,
}

#[derive(Debug)]
enum Surface<'a> {
    Step(Vec<Steps<'a>>),
    Linear { faces: Vec<Triangles<'a>>, seams: Option<Seams> },
}

impl<'a> MapTraversal<'a> {
    /// Builds the pyramids of a map. Only the constant part of `bias` counts, see [`Bias`]: it moves every texel away
    /// from the light by as much depth.
    pub fn new(map: &'a DepthMap, surface: MapSurface, bias: Bias) -> Self {
        let bias = bias.in_medium();
        let faces = 0..map.projection().faces().len();
        let size = map.size();
        let surface = match surface {
            MapSurface::Step => Surface::Step(
                faces
                    .map(|face| {
                        let pyramid = MinMaxPyramid::of_texels(map, face);
                        Steps { depths: map.face(face), size, pyramid, bias }
                    })
                    .collect(),
            ),
            MapSurface::Linear => {
                let kind = map.projection().kind();
                let perspective = kind != ProjectionKind::Orthographic;
                Surface::Linear {
                    faces: faces
                        .map(|face| Triangles::new(Cow::Borrowed(map.face(face)), size, bias, perspective))
                        .collect(),
                    seams: (kind == ProjectionKind::Cube).then(|| Seams::new(map, bias)),
                }
            }
        };
        Self { map, surface }
    }

    /// The map.
    pub fn map(&self) -> &'a DepthMap {
        self.map
    }

    /// Memory of the pyramids and seams, beside the map's own; units: bytes.
    pub fn bytes(&self) -> usize {
        match &self.surface {
            Surface::Step(faces) => faces.iter().map(|face| face.pyramid.bytes()).sum(),
            Surface::Linear { faces, seams } => {
                faces.iter().map(|face| face.pyramid.bytes()).sum::<usize>()
                    + seams.as_ref().map_or(0, Seams::bytes)
            }
        }
    }

    /// Writes the lit pieces of `ray` within `span` to `out` (cleared first): sorted, disjoint, none empty.
    ///
    /// Blocks of the map that are lit or dark as a whole are taken as a whole.
    pub fn lit(&self, ray: &DRay, span: Interval, out: &mut Vec<Interval>) {
        self.run(ray, span, Walk::Hierarchical, out);
    }

    /// As [`MapTraversal::lit`], texel by texel: the same pieces but for rounding, found without the pyramid.
    pub fn lit_flat(&self, ray: &DRay, span: Interval, out: &mut Vec<Interval>) {
        self.run(ray, span, Walk::Flat, out);
    }

    fn run(&self, ray: &DRay, span: Interval, how: Walk, out: &mut Vec<Interval>) {
        let mut pieces = Pieces::new(out);
        if !span.is_empty() {
            match &self.surface {
                Surface::Step(faces) => self.faces(faces, 0.0, ray, span, how, &mut pieces),
                Surface::Linear { faces, seams } => {
                    self.faces(faces, 0.5, ray, span, how, &mut pieces);
                    if let Some(seams) = seams {
                        seams.walk(ray, span, how, &mut pieces);
                    }
                }
            }
        }
        pieces.finish();
    }

    /// Walks every face; its cells begin `inset` texels in from the edge.
    fn faces<C: Cells>(
        &self,
        cells: &[C],
        inset: f64,
        ray: &DRay,
        span: Interval,
        how: Walk,
        out: &mut Pieces<'_>,
    ) {
        let (projection, size) = (self.map.projection(), self.map.size());
        let path = |face: usize| {
            let Path { u, v, w, depth } = projection.faces()[face].path(ray, size);
            Path { u: u - w * inset, v: v - w * inset, w, depth }
        };
        if projection.kind() == ProjectionKind::Cube {
            for (face, cells) in cells.iter().enumerate() {
                let piece = if inset == 0.0 {
                    within(projection, face, 1.0, ray, span)
                } else {
                    face_domain(projection, face, f64::from(size.0), ray, span)
                };
                if !piece.is_empty() {
                    walk(cells, &path(face), piece, how, out);
                }
            }
            return;
        }
        for cells in cells {
            let path = path(0);
            let (columns, rows) = cells.size();
            let piece = if columns == 0 || rows == 0 {
                Interval::new(span.start, span.start)
            } else {
                grid_domain(&path, columns, rows, span)
            };
            let outside = self.map.outside() == Outside::Lit;
            if piece.is_empty() {
                if outside {
                    out.push(span);
                }
                return;
            }
            if outside {
                out.push(Interval::new(span.start, piece.start));
            }
            walk(cells, &path, piece, how, out);
            if outside {
                out.push(Interval::new(piece.end, span.end));
            }
        }
    }

    /// Whether the light reaches a point: the question that [`MapTraversal::lit`] answers for whole rays, found by
    /// looking up the point's cell.
    pub fn is_lit(&self, point: DVec3) -> bool {
        let (projection, size) = (self.map.projection(), self.map.size());
        let outside = self.map.outside() == Outside::Lit;
        match &self.surface {
            Surface::Step(faces) => match self.map.locate(point) {
                Some(at) => {
                    let texel = |x: f64, count: u32| (x as usize).min(count as usize - 1);
                    let index = texel(at.v, size.1) * size.0 as usize + texel(at.u, size.0);
                    let cells = &faces[at.face];
                    at.depth <= f64::from(cells.depths[index]) + cells.bias
                }
                // a cube has no outside but the light itself
                None => outside,
            },
            Surface::Linear { faces, seams } => {
                let face = match seams {
                    Some(_) => face_towards(point - projection.faces()[0].origin),
                    None => 0,
                };
                let [u, v, w, depth] = projection.faces()[face].project(point, size);
                let (u, v) = (u / w - 0.5, v / w - 0.5);
                let within = |x: f64, count: u32| x >= 0.0 && x <= f64::from(count - 1);
                let enough = size.0 > 1 && size.1 > 1;
                if w > 0.0 && enough && within(u, size.0) && within(v, size.1) {
                    return faces[face].is_lit(u, v, depth);
                }
                seams.as_ref().map_or(outside, |seams| seams.is_lit(point))
            }
        }
    }
}

/// The part of `span` in which the path lies within a grid.
fn grid_domain(path: &Path, columns: u32, rows: u32, span: Interval) -> Interval {
    let mut span = span;
    for (along, count) in [(path.u, columns), (path.v, rows)] {
        span = (path.w * f64::from(count) - along).nonnegative(along.nonnegative(span));
    }
    // follows from the others but for a ray through the light
    path.w.nonnegative(span)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Projection;
    use glam::DVec2;

    const ALL: Interval = Interval::new(0.0, f64::INFINITY);

    /// A map at the origin that looks down −Z with a right angle between its sides.
    fn perspective(size: (u32, u32), depths: Vec<f32>) -> DepthMap {
        let projection = Projection::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap();
        DepthMap::new(projection, size, depths).unwrap()
    }

    fn lit(map: &DepthMap, surface: MapSurface, ray: (DVec3, DVec3)) -> Vec<(f64, f64)> {
        let traversal = MapTraversal::new(map, surface, Bias::NONE);
        let ray = DRay { origin: ray.0, direction: ray.1 };
        let (mut out, mut flat) = (Vec::new(), Vec::new());
        traversal.lit(&ray, ALL, &mut out);
        traversal.lit_flat(&ray, ALL, &mut flat);
        assert_eq!(out, flat);
        out.iter().map(|i| (i.start, i.end)).collect()
    }

    #[test]
    fn steps_by_hand() {
        // left column 2 m deep, right column 6 m
        let map = perspective((2, 1), vec![2.0, 6.0]);
        let across = |z: f64| (DVec3::new(-9.0, 0.0, z), DVec3::X);
        assert_eq!(lit(&map, MapSurface::Step, across(-1.0)), [(8.0, 10.0)]);
        assert_eq!(lit(&map, MapSurface::Step, across(-4.0)), [(9.0, 13.0)]);
        assert_eq!(lit(&map, MapSurface::Step, across(-7.0)), []);
        // along the axis in the right column
        assert_eq!(lit(&map, MapSurface::Step, (DVec3::new(0.5, 0.0, 9.0), DVec3::NEG_Z)), [(9.5, 15.0)]);
        // behind the light
        assert_eq!(lit(&map, MapSurface::Step, across(3.0)), []);
        let map = map.with_outside(Outside::Lit);
        assert_eq!(lit(&map, MapSurface::Step, across(3.0)), [(0.0, f64::INFINITY)]);
        assert_eq!(lit(&map, MapSurface::Step, across(-7.0)), [(0.0, 2.0), (16.0, f64::INFINITY)]);
    }

    #[test]
    fn triangles_by_hand() {
        // centres at ±½ of depth 1: at 2 m on the left, 4 m on the right; joined from (−1, ·, −2) to (2, ·, −4)
        let map = perspective((2, 2), vec![2.0, 4.0, 2.0, 4.0]);
        let along = |x: f64| (DVec3::new(x, 0.0, 1.0), DVec3::NEG_Z);
        let found = lit(&map, MapSurface::Linear, along(0.5));
        // inside the hull from depth 2·½ on, until the surface at depth 2 + 2·(1.5/3)
        assert_eq!(found.len(), 1);
        assert!((found[0].0 - 2.0).abs() < 1e-12 && (found[0].1 - 4.0).abs() < 1e-12, "{found:?}");
        // outside the outermost centres nothing is enclosed
        assert_eq!(lit(&map, MapSurface::Linear, (DVec3::new(-9.0, 1.6, -3.0), DVec3::X)), []);
        assert_eq!(lit(&perspective((1, 1), vec![4.0]), MapSurface::Linear, along(0.0)), []);
    }

    #[test]
    fn the_diagonal_runs_from_upper_right_to_lower_left() {
        // orthographic, centres at ±1: one corner pulled towards the light
        let projection =
            Projection::orthographic(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::splat(2.0)).unwrap();
        let depth_in_the_middle = |depths: Vec<f32>| {
            let map = DepthMap::new(projection.clone(), (2, 2), depths).unwrap().with_outside(Outside::Dark);
            let found = lit(&map, MapSurface::Linear, (DVec3::ZERO, DVec3::NEG_Z));
            assert_eq!(found.len(), 1);
            found[0].1
        };
        assert_eq!(depth_in_the_middle(vec![0.0, 4.0, 4.0, 4.0]), 4.0);
        assert_eq!(depth_in_the_middle(vec![4.0, 0.0, 4.0, 4.0]), 2.0);
        assert_eq!(depth_in_the_middle(vec![4.0, 4.0, 0.0, 4.0]), 2.0);
        assert_eq!(depth_in_the_middle(vec![4.0, 4.0, 4.0, 0.0]), 4.0);
    }

    #[test]
    fn a_cube_of_equal_depth_is_a_cube_or_a_cube_with_blunt_edges() {
        let map = DepthMap::uniform(Projection::cube(DVec3::ONE).unwrap(), (4, 4), 2.0).unwrap();
        let ray = |y: f64, z: f64| (DVec3::new(-9.0, y, z), DVec3::X);
        let close = |found: Vec<(f64, f64)>, start: f64, end: f64| {
            assert_eq!(found.len(), 1, "{found:?}");
            assert!((found[0].0 - start).abs() < 1e-12 && (found[0].1 - end).abs() < 1e-12, "{found:?}");
        };
        // x from −1 to 3 through the middle and near an edge
        close(lit(&map, MapSurface::Step, ray(1.3, 0.6)), 8.0, 12.0);
        close(lit(&map, MapSurface::Step, ray(2.9, 0.6)), 8.0, 12.0);
        close(lit(&map, MapSurface::Linear, ray(1.3, 0.6)), 8.0, 12.0);
        // the strip joins (2, 1.5) and (1.5, 2): at y − 1 = 1.9 it ends at 1.6
        close(lit(&map, MapSurface::Linear, ray(2.9, 0.6)), 10.0 - 1.6, 10.0 + 1.6);
        // the corner joins (2, 1.5, 1.5) and its like: the plane x + y + z = 5
        close(lit(&map, MapSurface::Linear, ray(1.0 + 1.7, 1.0 + 1.65)), 10.0 - 1.65, 10.0 + 1.65);
        // one texel a face: an octahedron
        let map = DepthMap::uniform(Projection::cube(DVec3::ONE).unwrap(), (1, 1), 2.0).unwrap();
        close(lit(&map, MapSurface::Linear, ray(1.5, 0.7)), 10.0 - 1.2, 10.0 + 1.2);
    }

    #[test]
    fn an_empty_map_is_all_lit() {
        let far = f32::INFINITY;
        let ray = (DVec3::new(-9.0, 0.3, -0.2), DVec3::new(1.0, 0.2, -0.3).normalize());
        for n in [1, 3, 8] {
            let map = DepthMap::uniform(Projection::cube(DVec3::ZERO).unwrap(), (n, n), far).unwrap();
            for surface in [MapSurface::Step, MapSurface::Linear] {
                assert_eq!(lit(&map, surface, ray), [(0.0, f64::INFINITY)]);
            }
            let flat = Projection::orthographic(DVec3::ZERO, DVec3::NEG_Y, DVec3::X, DVec2::ONE).unwrap();
            let map = DepthMap::uniform(flat, (n, n), far).unwrap();
            for surface in [MapSurface::Step, MapSurface::Linear] {
                assert_eq!(lit(&map, surface, ray), [(0.0, f64::INFINITY)]);
            }
        }
    }

    #[test]
    fn bias_moves_the_texels_away() {
        let map = perspective((1, 1), vec![2.0]);
        let traversal = MapTraversal::new(&map, MapSurface::Step, Bias::constant(0.5).unwrap());
        let mut out = Vec::new();
        let ray = DRay { origin: DVec3::ZERO, direction: DVec3::NEG_Z };
        traversal.lit(&ray, ALL, &mut out);
        assert_eq!(out, [Interval::new(0.0, 2.5)]);
        assert!(
            traversal.is_lit(DVec3::new(0.0, 0.0, -2.4)) && !traversal.is_lit(DVec3::new(0.0, 0.0, -2.6))
        );
    }
}
