//! The frontmost and the backmost side face of a shadow volume by pixel, as a rasteriser finds them.
//!
//! Drawing all faces once and keeping the least and the greatest depth is the second step of the hybrid (Wyman and Ramsey
//! 2008, section 3.1). By pixel the depth at its centre is kept; by tile of several pixels, for scattering at a lower
//! resolution (section 3.3), a range that holds every depth in the tile, so that no shadow of any of its pixels is missed.
//!
//! 1/z of a plane is linear over the image, z being the depth along the camera's axis, and 0 infinitely far away: so ranges
//! are kept as 1/z, and faces that reach to infinity are polygons of four homogeneous corners like others.

use glam::{DMat3, DVec2, DVec3, DVec4};
use scene::{Camera, Interval};

use crate::face_polygon::{SeenPolygon, polygon_of, thickened};
use crate::shadow_volume::ShadowVolume;

/// A face that is nearer to the eye than this share of its ends' distance is met by every ray at once.
const CLOSE: f64 = 1e-9;

/// What rounding may take from a position in the image; units: tiles.
const SLACK: f64 = 1e-9;

/// What of a view's rays may be shadowed by one light, by tile.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceBounds {
    view: View,
    /// Greatest and least 1/z of the faces in each tile, row by row; the greatest is negative where there is none.
    inverse: Vec<DVec2>,
}

impl FaceBounds {
    /// Draws all faces of `volume` as `camera` sees them in an image of `size` pixels, by tile of `scale` × `scale` pixels.
    ///
    /// With a scale of 1 the distances are those at the pixels' centres; with a greater one they hold for the whole tile.
    /// A scale of 0 counts as 1.
    pub fn draw(volume: &ShadowVolume, camera: &Camera, size: (u32, u32), scale: u32) -> Self {
        Self::draw_with_margin(volume, camera, size, scale, 0.0)
    }

    /// As [`FaceBounds::draw`], for shadows that stick out of the volume by up to `margin`, as those of a map's texels do.
    ///
    /// `margin` is the size of a texel: per metre of distance from a local light, and in m for a directional one. Each face
    /// becomes a slab that reaches so far to both of its sides, and over the ends of its edge; all sides of the slab are
    /// drawn, since a ray may run along within it.
    pub fn draw_with_margin(
        volume: &ShadowVolume,
        camera: &Camera,
        size: (u32, u32),
        scale: u32,
        margin: f64,
    ) -> Self {
        let view = View::new(camera, size, scale.max(1));
        let tiles = view.tiles.0 as usize * view.tiles.1 as usize;
        let mut bounds = Self { view, inverse: vec![DVec2::new(-1.0, f64::INFINITY); tiles] };
        let mut outline = Vec::with_capacity(8);
        for face in &volume.faces {
            bounds.add_face(volume, face.ends, margin, &mut outline);
        }
        bounds
    }

    /// Distances along the ray through the centre of a pixel between which its faces lie; units: m. `None` where there is
    /// no face, and outside the image.
    pub fn at(&self, x: u32, y: u32) -> Option<Interval> {
        let view = &self.view;
        if x >= view.size.0 || y >= view.size.1 {
            return None;
        }
        let tile = (y / view.scale) as usize * view.tiles.0 as usize + (x / view.scale) as usize;
        let inverse = self.inverse[tile];
        let length = view.length_per_depth(x, y);
        (inverse.x >= 0.0).then(|| Interval::new(length / inverse.x, length / inverse.y))
    }

    /// Memory of the bounds; units: bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.inverse)
    }

    /// Draws the face of the edge between `ends`, which are relative to the volume's origin; `outline` is room to work in.
    fn add_face(&mut self, volume: &ShadowVolume, ends: [DVec3; 2], margin: f64, outline: &mut Vec<DVec4>) {
        let from_eye = volume.origin - self.view.eye;
        let seen = |corner: DVec4| {
            // what is infinitely far away is so from the eye too
            (self.view.into * (corner.truncate() + corner.w * from_eye)).extend(corner.w)
        };
        let Some(face) = polygon_of(volume, ends) else { return };
        let face = SeenPolygon::new(face.map(seen));
        let close = CLOSE * face.reach;
        let reach = |end: DVec3| if volume.direction.is_some() { margin } else { margin * end.length() };
        // a face without thickness holds the eye where the least slab does
        let thickness = ends.map(|end| reach(end).max(close));
        if margin > 0.0 || face.offset.abs() <= close {
            let sides = thickened(volume, ends, thickness).map(|side| SeenPolygon::new(side.map(seen)));
            if SeenPolygon::enclose_eye(&sides) {
                // every ray meets the face where it starts
                self.inverse.iter_mut().for_each(|kept| kept.x = f64::INFINITY);
            }
            if margin > 0.0 {
                sides.iter().for_each(|side| self.add(side, outline));
                return;
            }
        }
        self.add(&face, outline);
    }

    /// Draws one polygon.
    fn add(&mut self, polygon: &SeenPolygon, outline: &mut Vec<DVec4>) {
        let view = &self.view;
        polygon.clip(view.corner, outline);
        // greatest and least 1/z of what is in view, and its rows
        let (mut own, mut rows) =
            (DVec2::new(0.0, f64::INFINITY), DVec2::new(f64::INFINITY, f64::NEG_INFINITY));
        for p in &mut *outline {
            let (tile, inverse) = ((DVec2::new(p.x, p.y) / p.z - view.corner) / view.step, p.w / p.z);
            *p = tile.extend(0.0).extend(0.0);
            own = DVec2::new(own.x.max(inverse), own.y.min(inverse));
            rows = DVec2::new(rows.x.min(tile.y), rows.y.max(tile.y));
        }
        let half = if view.scale > 1 { 0.5 } else { 0.0 };
        let plane = view.inverse_depth(polygon);
        for row in covered(rows.x, rows.y, half, view.tiles.1) {
            let middle = f64::from(row) + 0.5;
            let Some(columns) = crossing(outline, middle - half - SLACK, middle + half + SLACK) else {
                continue;
            };
            let first = row as usize * view.tiles.0 as usize;
            for column in covered(columns.x, columns.y, half, view.tiles.0) {
                let range = plane.map_or(own, |plane| {
                    let at = plane.dot(DVec3::new(f64::from(column) + 0.5, middle, 1.0));
                    let reach = half * (plane.x.abs() + plane.y.abs());
                    DVec2::new(at + reach, at - reach).max(DVec2::splat(own.y)).min(DVec2::splat(own.x))
                });
                let kept = &mut self.inverse[first + column as usize];
                *kept = DVec2::new(kept.x.max(range.x), kept.y.min(range.y));
            }
        }
    }
}

/// A camera with its image divided into tiles.
#[derive(Debug, Clone, PartialEq)]
struct View {
    /// Columns: right, up and forward, as the camera has them.
    axes: DMat3,
    /// From world axes to multiples of the camera's.
    into: DMat3,
    eye: DVec3,
    size: (u32, u32),
    scale: u32,
    tiles: (u32, u32),
    /// Tangent (to the right and upwards, over forward) at the upper left corner of the image.
    corner: DVec2,
    /// Change of the tangent by tile to the right and downwards.
    step: DVec2,
}

impl View {
    fn new(camera: &Camera, size: (u32, u32), scale: u32) -> Self {
        let axes = DMat3::from_cols(camera.right.as_dvec3(), camera.up.as_dvec3(), camera.forward.as_dvec3());
        let half = (0.5 * f64::from(camera.fov_y)).tan();
        let pixels = DVec2::new(f64::from(size.0), f64::from(size.1)).max(DVec2::ONE);
        let corner = DVec2::new(-half * pixels.x / pixels.y, half);
        Self {
            axes,
            // the axes are rounded to f32: not quite at right angles, so that a transpose is not the inverse
            into: axes.inverse(),
            eye: camera.position.as_dvec3(),
            size,
            scale,
            tiles: (size.0.div_ceil(scale), size.1.div_ceil(scale)),
            corner,
            step: -2.0 * f64::from(scale) * corner / pixels,
        }
    }

    /// Distance along the ray through a pixel's centre for each metre of depth.
    fn length_per_depth(&self, x: u32, y: u32) -> f64 {
        let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let tangent = self.corner + self.step * (pixel / f64::from(self.scale));
        (self.axes * tangent.extend(1.0)).length()
    }

    /// 1/z of a polygon's plane as x·column + y·row + z in tiles; `None` if the plane holds the eye, or is infinitely far
    /// away.
    fn inverse_depth(&self, polygon: &SeenPolygon) -> Option<DVec3> {
        let n = polygon.normal;
        let (aside, at_corner) = (DVec2::new(n.x, n.y) * self.step, n.dot(self.corner.extend(1.0)));
        (polygon.offset.abs() > CLOSE * polygon.reach).then(|| aside.extend(at_corner) / polygon.offset)
    }
}

/// The tiles, of `count`, whose middles are at most `half` from the range from `low` to `high`.
fn covered(low: f64, high: f64, half: f64, count: u32) -> std::ops::Range<u32> {
    // saturating: what is outside the image is clamped to it
    let first = (low - 0.5 - half - SLACK).ceil().max(0.0) as u32;
    let last = (high - 0.5 + half + SLACK).floor();
    first..if last < 0.0 { 0 } else { (last as u32).saturating_add(1).min(count) }
}

/// Least and greatest x of the part of a convex polygon between y = `top` and y = `bottom`; `None` if there is none.
fn crossing(outline: &[DVec4], top: f64, bottom: f64) -> Option<DVec2> {
    let mut p = *outline.last()?;
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for &q in outline {
        if p.y.max(q.y) >= top && p.y.min(q.y) <= bottom {
            let rise = q.y - p.y;
            let cut = |y: f64| ((y - p.y) / rise).clamp(0.0, 1.0);
            for t in if rise == 0.0 { [0.0, 1.0] } else { [cut(top), cut(bottom)] } {
                let x = p.x + (q.x - p.x) * t;
                (left, right) = (left.min(x), right.max(x));
            }
        }
        p = q;
    }
    (left <= right).then_some(DVec2::new(left, right))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adjacency::Adjacency;
    use glam::Vec3;
    use scene::{DirectionalLight, Light, PointLight};

    const SIZE: (u32, u32) = (37, 26);
    const ALL: Interval = Interval::new(0.0, f64::INFINITY);

    fn lamp(at: Vec3) -> Light {
        Light::Point(PointLight::new(at, Vec3::ONE).unwrap())
    }

    fn lights() -> [Light; 4] {
        let sun = |along| Light::Directional(DirectionalLight::new(along, Vec3::ONE).unwrap());
        [
            lamp(Vec3::new(0.3, 2.0, -0.2)),
            lamp(Vec3::new(0.9, 1.001, 3.0)),
            sun(Vec3::new(0.3, -1.0, 0.4)),
            sun(Vec3::new(0.1, 0.02, -1.0)),
        ]
    }

    /// A tilted triangle and a little tetrahedron beside it.
    fn volume(light: &Light) -> ShadowVolume {
        let p = |x, y, z| Vec3::new(x, y, z);
        let t = [p(1.5, 0.7, 0.0), p(1.9, 0.8, 0.3), p(1.6, 1.1, 0.1), p(1.4, 0.9, 0.5)];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let triangle = [p(-1.0, 1.0, -1.0), p(1.0, 0.8, -0.6), p(0.1, 0.9, 1.0)];
        let mesh = Adjacency::new(faces.map(|f| f.map(|i| t[i])).into_iter().chain([triangle])).unwrap();
        ShadowVolume::new(&mesh, light)
    }

    fn cameras() -> Vec<Camera> {
        let look = |eye, at| Camera::look_at(eye, at, Vec3::new(0.1, 1.0, 0.05), 1.2).unwrap();
        vec![
            look(Vec3::new(0.0, 1.0, 5.0), Vec3::ZERO),
            look(Vec3::new(-4.0, 3.0, -2.0), Vec3::new(0.5, 0.0, 0.0)),
            // inside the shadow, under the triangle, and above everything
            look(Vec3::new(0.1, 0.7, -0.2), Vec3::new(3.0, 0.2, 1.0)),
            look(Vec3::new(0.2, 0.5, 0.1), Vec3::new(0.1, 3.0, -0.2)),
            look(Vec3::new(0.3, 6.0, -0.2), Vec3::new(0.31, 0.0, -0.2)),
            // at the first light, and along the last
            look(Vec3::new(0.3, 2.0, -0.2), Vec3::new(0.0, 0.0, -0.2)),
            look(Vec3::new(-0.5, 1.0, 9.0), Vec3::new(0.5, 1.2, -1.0)),
        ]
    }

    #[test]
    fn a_pixel_has_what_its_ray_meets() {
        let (mut met, mut differ) = (0, 0);
        for (light, camera) in
            lights().iter().flat_map(|light| cameras().into_iter().map(move |c| (light, c)))
        {
            let volume = volume(light);
            let drawn = FaceBounds::draw(&volume, &camera, SIZE, 1);
            for (x, y) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))) {
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-8 * b;
                match (drawn.at(x, y), volume.faces(&camera.pixel_ray(x, y, SIZE), ALL)) {
                    (None, None) => {}
                    (Some(got), Some(exact)) if near(got.start, exact.start) && near(got.end, exact.end) => {
                        met += 1;
                    }
                    // the edge of a face that is itself seen edge-on
                    _ => differ += 1,
                }
            }
        }
        assert!(
            met > 5000 && differ <= met / 5000,
            "{met} pixels met a face, {differ} another than their ray"
        );
    }

    #[test]
    fn a_tile_holds_what_any_of_its_rays_meets() {
        let (mut met, mut tiles) = (0, 0);
        for (light, camera) in
            lights().iter().flat_map(|light| cameras().into_iter().map(move |c| (light, c)))
        {
            let volume = volume(light);
            for scale in [2, 8] {
                let drawn = FaceBounds::draw(&volume, &camera, SIZE, scale);
                for (x, y) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))) {
                    tiles += usize::from(drawn.at(x, y).is_some());
                    let Some(exact) = volume.faces(&camera.pixel_ray(x, y, SIZE), ALL) else { continue };
                    let got = drawn.at(x, y).unwrap();
                    let slack = 1e-8 * exact.start;
                    assert!(
                        got.start <= exact.start + slack && got.end >= exact.end - slack,
                        "{got:?} {exact:?}"
                    );
                    met += 1;
                }
            }
        }
        assert!(met > 10_000 && tiles < 2 * met, "{met} pixels met a face, {tiles} lie in tiles that may");
    }

    #[test]
    fn one_face_by_hand() {
        // a triangle's edge at x = 1 under the sun: its face is the plane x = 1 below it
        let p = Vec3::new;
        let triangle = [p(1.0, 9.0, -50.0), p(1.0, 9.0, 50.0), p(99.0, 9.0, 0.0)];
        let down = Light::Directional(DirectionalLight::new(Vec3::NEG_Y, Vec3::ONE).unwrap());
        let volume = ShadowVolume::new(&Adjacency::new([triangle]).unwrap(), &down);
        let camera = Camera::look_at(Vec3::ZERO, Vec3::X, Vec3::Y, 0.5).unwrap();
        let by_pixel = FaceBounds::draw(&volume, &camera, (5, 5), 1);
        let found = by_pixel.at(2, 2).unwrap();
        // the way in through the near face, and out through one of the slanted ones at z = 0
        assert!((found.start - 1.0).abs() < 1e-6 && (found.end - 99.0).abs() < 1e-3, "{found:?}");
        assert_eq!((by_pixel.at(5, 0), by_pixel.at(0, 5), by_pixel.bytes()), (None, None, 25 * 16));
        let by_tile = FaceBounds::draw(&volume, &camera, (5, 5), 4);
        assert_eq!(by_tile.bytes(), 4 * 16);
        assert!(by_tile.at(2, 2).unwrap().start <= found.start + 1e-9);
    }

    #[test]
    fn an_eye_in_a_face_is_met_at_once() {
        let volume = volume(&lights()[0]);
        let [a, b] = volume.faces[0].ends;
        let on = volume.origin + 1.7 * a.lerp(b, 0.4);
        for eye in [on, volume.origin + 1.7 * a] {
            let eye = eye.as_vec3();
            let camera = Camera::look_at(eye, eye + Vec3::new(1.0, 0.3, 0.2), Vec3::Y, 1.0).unwrap();
            // the eye is rounded to f32: move the face there instead
            let aside =
                camera.position.as_dvec3() - if eye == on.as_vec3() { on } else { volume.origin + 1.7 * a };
            let moved = ShadowVolume { origin: volume.origin + aside, ..volume.clone() };
            for scale in [1, 8] {
                let drawn = FaceBounds::draw(&moved, &camera, SIZE, scale);
                assert!((0..SIZE.0).all(|x| drawn.at(x, 3).unwrap().start == 0.0));
            }
        }
    }

    #[test]
    fn a_margin_holds_what_faces_moved_by_less_are_met_at() {
        let margin = 0.02;
        let (mut met, mut beyond) = (0, 0);
        for (i, (light, camera)) in
            lights().iter().flat_map(|light| cameras().into_iter().map(move |c| (light, c))).enumerate()
        {
            let volume = volume(light);
            let exact = FaceBounds::draw(&volume, &camera, SIZE, 4);
            let wide = FaceBounds::draw_with_margin(&volume, &camera, SIZE, 4, margin);
            let mut moved = volume.clone();
            for (k, face) in moved.faces.iter_mut().enumerate() {
                let [a, b] = face.ends;
                let normal = volume.direction.unwrap_or(a).cross(b - a).normalize();
                let reach =
                    |end: DVec3| if volume.direction.is_some() { margin } else { margin * end.length() };
                let share = |j: usize| (7.3 * (i + 3 * k + j) as f64).sin();
                let along = (b - a).normalize();
                face.ends = [
                    a + reach(a) * (share(0) * normal - share(1).abs() * along),
                    b + reach(b) * (share(2) * normal + share(3).abs() * along),
                ];
            }
            for (x, y) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))) {
                let Some(faces) = moved.faces(&camera.pixel_ray(x, y, SIZE), ALL) else { continue };
                let holds = |bounds: Option<Interval>| {
                    bounds.is_some_and(|b| {
                        b.start <= faces.start * (1.0 + 1e-8) && b.end >= faces.end * (1.0 - 1e-8)
                    })
                };
                assert!(holds(wide.at(x, y)), "{light:?} {camera:?} {x} {y}: {:?} {faces:?}", wide.at(x, y));
                beyond += usize::from(!holds(exact.at(x, y)));
                met += 1;
            }
        }
        assert!(met > 5000 && beyond > 100, "{met} pixels, of which {beyond} need the margin");
    }

    #[test]
    fn a_scale_of_zero_is_one() {
        let (volume, camera) = (volume(&lights()[0]), &cameras()[0]);
        let drawn = |scale| FaceBounds::draw(&volume, camera, SIZE, scale);
        assert_eq!(drawn(0), drawn(1));
    }

    #[test]
    fn no_face_and_no_image() {
        let none = ShadowVolume::new(&Adjacency::default(), &lights()[0]);
        assert!(FaceBounds::draw(&none, &cameras()[0], SIZE, 8).at(0, 0).is_none());
        let empty = FaceBounds::draw(&volume(&lights()[0]), &cameras()[0], (0, 5), 8);
        assert!(empty.at(0, 0).is_none());
    }
}
