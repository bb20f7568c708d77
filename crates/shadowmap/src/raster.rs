//! The rasteriser on the CPU: what a GPU pass is compared with.
//!
//! A texel's value is the depth of the nearest triangle on light's ray through its centre, found as a ray cast would find
//! it, in `f64`. Edge functions are evaluated in homogeneous coordinates (Olano and Greer, *Triangle Scan Conversion
//! using 2D Homogeneous Coordinates*, 1997), so that a triangle which crosses the plane of the light needs no clipping:
//! it is drawn up to the near plane and no farther. Triangles are two-sided. A centre on a shared edge belongs to both
//! triangles, so that there are no cracks. Orthographic maps also draw what lies before the plane of depth 0, at depth 0.

use glam::{DVec3, Vec3};
use scene::{Light, Mesh, Scene};

use crate::depth_map::count;
use crate::face::Face;
use crate::{DepthMap, MapSurface, Projection, ShadowMapError};

/// Rows that are drawn together.
const BAND: usize = 64;

/// How depth follows from the edge functions e.
#[derive(Debug, Clone, Copy)]
enum DepthOf {
    /// Perspective: volume/Σ e, with the volume that the corners span with the light.
    Volume(f64),
    /// Orthographic: Σ e·depth/Σ e over the corners.
    Corners(DVec3),
}

/// A triangle as a face sees it.
#[derive(Debug, Clone, Copy)]
struct Drawn {
    /// Edge functions over (column, row, 1), all of the same sign inside.
    edges: [DVec3; 3],
    depth: DepthOf,
    /// Depths of the corners: where a triangle is seen all but edge on, nothing else bounds its rounding.
    between: (f64, f64),
    /// Columns and rows that may be covered: first, and one past the last.
    columns: (u32, u32),
    rows: (u32, u32),
}

impl DepthMap {
    /// Draws triangles (corners in m) into a map of `size` (columns, rows); +∞ where light's ray meets none.
    ///
    /// What lies nearer than [`Projection::near`] is not drawn.
    ///
    /// # Errors
    /// [`ShadowMapError`] if a side is 0 or too large, or the faces of a cube are not square.
    pub fn draw(
        projection: Projection,
        size: (u32, u32),
        triangles: &[[Vec3; 3]],
    ) -> Result<Self, ShadowMapError> {
        let mut depths = vec![f32::INFINITY; count(&projection, size)?];
        let texels = size.0 as usize * size.1 as usize;
        let near = f64::from(projection.near());
        for (face, depths) in projection.faces().iter().zip(depths.chunks_exact_mut(texels)) {
            let drawn: Vec<Drawn> =
                triangles.iter().filter_map(|&corners| set_up(face, near, size, corners)).collect();
            let draw = |(band, depths): (usize, &mut [f32])| {
                draw_band(&drawn, near, size.0, (band * BAND) as u32, depths);
            };
            for_each_band(depths, size.0 as usize * BAND, draw);
        }
        Ok(Self::trusted(projection, size, depths))
    }

    /// Draws a scene's meshes as `light` sees them, into a map of `side` × `side` texels (per face for a point light).
    ///
    /// # Errors
    /// As [`Projection::of_light`] and [`DepthMap::draw`].
    pub fn of_light(light: &Light, scene: &Scene, side: u32) -> Result<Self, ShadowMapError> {
        let projection = Projection::of_light(light, &scene.bounds(), (side, side))?;
        Self::draw(projection, (side, side), &all_corners(scene))
    }
}

/// Maps of all lights of a scene, `side` × `side` texels each (per face for a point light); `None` for every light if the
/// scene has no triangle, so that nothing is paid for shadows that are not there.
///
/// # Errors
/// As [`DepthMap::of_light`].
pub fn draw_maps(
    lights: &[Light],
    scene: &Scene,
    side: u32,
) -> Result<Vec<Option<DepthMap>>, ShadowMapError> {
    draw_maps_for(lights, scene, side, MapSurface::Step)
}

/// As [`draw_maps`], with the projections that suit the meaning in which the maps are read: see
/// [`Projection::of_light_for`].
///
/// # Errors
/// As [`DepthMap::of_light`].
pub fn draw_maps_for(
    lights: &[Light],
    scene: &Scene,
    side: u32,
    surface: MapSurface,
) -> Result<Vec<Option<DepthMap>>, ShadowMapError> {
    let (triangles, bounds, size) = (all_corners(scene), scene.bounds(), (side, side));
    let draw = |light: &Light| {
        if triangles.is_empty() {
            return Ok(None);
        }
        let projection = Projection::of_light_for(light, &bounds, size, surface)?;
        DepthMap::draw(projection, size, &triangles).map(Some)
    };
    lights.iter().map(draw).collect()
}

fn all_corners(scene: &Scene) -> Vec<[Vec3; 3]> {
    scene.meshes.iter().flat_map(Mesh::corners).collect()
}

#[cfg(feature = "parallel")]
fn for_each_band(depths: &mut [f32], band: usize, draw: impl Fn((usize, &mut [f32])) + Sync + Send) {
    use rayon::prelude::*;
    depths.par_chunks_mut(band).enumerate().for_each(draw);
}

#[cfg(not(feature = "parallel"))]
fn for_each_band(depths: &mut [f32], band: usize, draw: impl Fn((usize, &mut [f32]))) {
    depths.chunks_mut(band).enumerate().for_each(draw);
}

/// Prepares a triangle; `None` if it has no area as the light sees it or lies off the map.
fn set_up(face: &Face, near: f64, size: (u32, u32), corners: [Vec3; 3]) -> Option<Drawn> {
    let seen = corners.map(|corner| face.project(corner.as_dvec3(), size));
    let v = seen.map(|[u, v, w, _]| DVec3::new(u, v, w));
    let edges = [v[1].cross(v[2]), v[2].cross(v[0]), v[0].cross(v[1])];
    let volume = v[0].dot(edges[0]);
    if volume == 0.0 {
        return None;
    }
    let (min, max) = if face.perspective { bounds_beyond(near, &v)? } else { bounds(&v) };
    // centres between the bounds, with a margin for rounding
    let range = |min: f64, max: f64, count: u32| {
        let first = (min - 0.501).ceil().clamp(0.0, f64::from(count));
        let end = (max - 0.499).floor().clamp(-1.0, f64::from(count) - 1.0) + 1.0;
        (first < end).then_some((first as u32, end as u32))
    };
    let own = DVec3::new(seen[0][3], seen[1][3], seen[2][3]);
    let depth = if face.perspective { DepthOf::Volume(volume) } else { DepthOf::Corners(own) };
    let (columns, rows) = (range(min[0], max[0], size.0)?, range(min[1], max[1], size.1)?);
    Some(Drawn { edges, depth, between: (own.min_element(), own.max_element()), columns, rows })
}

/// Smallest and largest U/W and V/W of corners with W > 0.
fn bounds(corners: &[DVec3]) -> ([f64; 2], [f64; 2]) {
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for corner in corners {
        for (axis, at) in [corner.x / corner.z, corner.y / corner.z].into_iter().enumerate() {
            min[axis] = min[axis].min(at);
            max[axis] = max[axis].max(at);
        }
    }
    (min, max)
}

/// Bounds of the part with W ≥ `near`; `None` if there is none.
fn bounds_beyond(near: f64, corners: &[DVec3; 3]) -> Option<([f64; 2], [f64; 2])> {
    let mut kept = [DVec3::ZERO; 6];
    let mut count = 0;
    let mut keep = |point: DVec3| {
        kept[count] = point;
        count += 1;
    };
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        if a.z >= near {
            keep(a);
        }
        if (a.z >= near) != (b.z >= near) {
            let t = (near - a.z) / (b.z - a.z);
            let mut crossing = a.lerp(b, t);
            crossing.z = near;
            keep(crossing);
        }
    }
    (count > 0).then(|| bounds(&kept[..count]))
}

/// Draws into the rows from `first` on.
fn draw_band(drawn: &[Drawn], near: f64, width: u32, first: u32, depths: &mut [f32]) {
    let last = first + (depths.len() / width as usize) as u32;
    // orthographic maps have no near plane
    let floor = if near > 0.0 { f64::NEG_INFINITY } else { 0.0 };
    for triangle in drawn {
        let (from, to) = (triangle.rows.0.max(first), triangle.rows.1.min(last));
        for y in from..to {
            let row = &mut depths[((y - first) * width) as usize..((y - first + 1) * width) as usize];
            let v = f64::from(y) + 0.5;
            let constant = triangle.edges.map(|e| e.y * v + e.z);
            for x in triangle.columns.0..triangle.columns.1 {
                let u = f64::from(x) + 0.5;
                let e = [0, 1, 2].map(|i| triangle.edges[i].x * u + constant[i]);
                let inside = (e[0] >= 0.0 && e[1] >= 0.0 && e[2] >= 0.0)
                    || (e[0] <= 0.0 && e[1] <= 0.0 && e[2] <= 0.0);
                if !inside {
                    continue;
                }
                let sum = e[0] + e[1] + e[2];
                if sum == 0.0 {
                    continue;
                }
                let depth = match triangle.depth {
                    DepthOf::Volume(volume) => volume / sum,
                    DepthOf::Corners(depths) => depths.dot(DVec3::from(e)) / sum,
                };
                let (least, most) = triangle.between;
                let depth = depth.max(least).min(most).max(floor);
                let texel = &mut row[x as usize];
                if depth >= near && depth < f64::from(*texel) {
                    *texel = depth as f32;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn perspective() -> Projection {
        Projection::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap()
    }

    /// A square in the plane z, from two triangles wound opposite ways.
    fn square(half: f32, z: f32) -> Vec<[Vec3; 3]> {
        let p = |x: f32, y: f32| Vec3::new(x * half, y * half, z);
        vec![[p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0)], [p(-1.0, -1.0), p(-1.0, 1.0), p(1.0, 1.0)]]
    }

    #[test]
    fn a_square_by_hand() {
        // at 2 m a map of 8 texels sees 4 m: the square of 2 m covers the middle four, diagonal included
        let map = DepthMap::draw(perspective(), (8, 8), &square(1.0, -2.0)).unwrap();
        for y in 0..8 {
            for x in 0..8 {
                let inside = (2..6).contains(&x) && (2..6).contains(&y);
                let expected = if inside { 2.0 } else { f32::INFINITY };
                assert_eq!(map.depth(0, x, y), expected, "{x} {y}");
            }
        }
    }

    #[test]
    fn the_nearest_wins_whatever_the_order() {
        let (near, far) = (square(1.0, -2.0), square(9.0, -5.0));
        let a = DepthMap::draw(perspective(), (8, 8), &[near.clone(), far.clone()].concat()).unwrap();
        let b = DepthMap::draw(perspective(), (8, 8), &[far, near].concat()).unwrap();
        assert_eq!(a, b);
        assert_eq!((a.depth(0, 4, 4), a.depth(0, 0, 0)), (2.0, 5.0));
    }

    #[test]
    fn a_floor_under_the_light_is_drawn_up_to_the_horizon() {
        // y = −1, from 50 m behind the light to 50 m before it
        let p = |x: f32, z: f32| Vec3::new(x, -1.0, z);
        let floor = [[p(-50.0, 50.0), p(50.0, 50.0), p(0.0, -100.0)]];
        let map = DepthMap::draw(perspective(), (64, 64), &floor).unwrap();
        for y in 0..64 {
            // light's ray through the row falls by this much per metre of depth
            let slope = (f64::from(y) + 0.5) / 32.0 - 1.0;
            let expected = if slope > 0.0 { 1.0 / slope } else { f64::INFINITY };
            let depth = f64::from(map.depth(0, 31, y));
            if expected < 40.0 || expected.is_infinite() {
                assert!(
                    depth == expected || (depth / expected - 1.0).abs() < 1e-6,
                    "{y}: {depth} {expected}"
                );
            }
        }
    }

    #[test]
    fn the_near_plane_and_what_lies_behind() {
        let near = perspective().with_near(3.0).unwrap();
        let map = DepthMap::draw(near, (4, 4), &square(9.0, -2.0)).unwrap();
        assert!(map.depths().iter().all(|d| d.is_infinite()));
        let map = DepthMap::draw(perspective(), (4, 4), &square(9.0, 2.0)).unwrap();
        assert!(map.depths().iter().all(|d| d.is_infinite()));
        // an orthographic map draws what lies behind its plane, at depth 0
        let flat = Projection::orthographic(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap();
        let map = DepthMap::draw(flat.clone(), (4, 4), &square(9.0, 2.0)).unwrap();
        assert!(map.depths().iter().all(|&d| d == 0.0));
        let map = DepthMap::draw(flat, (4, 4), &square(0.6, -2.0)).unwrap();
        assert_eq!((map.depth(0, 1, 1), map.depth(0, 0, 1)), (2.0, f32::INFINITY));
    }

    #[test]
    fn edge_on_and_degenerate_triangles_are_nothing() {
        let p = Vec3::new;
        let through_the_light = [p(0.0, 0.0, -1.0), p(0.0, 1.0, -2.0), p(0.0, -1.0, -2.0)];
        let line = [p(-1.0, 0.5, -2.0), p(0.0, 0.5, -2.0), p(1.0, 0.5, -2.0)];
        let map = DepthMap::draw(perspective(), (8, 8), &[through_the_light, line]).unwrap();
        assert!(map.depths().iter().all(|d| d.is_infinite()));
        assert!(DepthMap::draw(perspective(), (0, 8), &[line]).is_err());
    }
}
