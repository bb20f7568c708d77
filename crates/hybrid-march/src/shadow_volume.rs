//! The side faces of a shadow volume, and where a view ray meets the first and the last of them.
//!
//! A view ray enters and leaves shadow through side faces only: it ends at the first surface that it meets, so it never
//! crosses a lit cap, and the other cap is infinitely far away. Between the frontmost and the backmost face a march looks
//! for shadows; outside it need not (Wyman and Ramsey 2008, section 3.1).

use glam::DVec3;
use scene::{DRay, Interval, Light, LightId, Visibility};

use crate::adjacency::Adjacency;
use crate::silhouette::Silhouette;

/// What rounding may take from an acceptance, relative to the lengths in it: no face is lost where two meet.
const SLACK: f64 = 1e-9;

/// Smallest distance of a light from the ray, as a share of its distance from the ray's origin; as in the exact
/// reference, a ray through the light is moved aside by this much.
const LEAST_OFFSET: f64 = 1e-12;

/// A side face: an edge of the silhouette, extruded away from the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Face {
    /// The edge's ends, from [`ShadowVolume::origin`]; units: m.
    pub(crate) ends: [DVec3; 2],
    /// The length that rounding is relative to; units: m.
    reach: f64,
}

/// The side faces of a mesh's shadow volume for one light.
#[derive(Debug, Clone, PartialEq)]
pub struct ShadowVolume {
    /// Where the faces' ends are measured from: a local light's position, or the middle of the faces.
    pub(crate) origin: DVec3,
    /// The way that directional light travels; `None` for local light.
    pub(crate) direction: Option<DVec3>,
    pub(crate) faces: Vec<Face>,
}

impl ShadowVolume {
    /// The shadow volume of a mesh in the light of `light`; that of a spot is not cut to its cone.
    pub fn new(mesh: &Adjacency, light: &Light) -> Self {
        Self::of(mesh, light, &Silhouette::of(mesh, light))
    }

    /// As [`ShadowVolume::new`] from the silhouette of that mesh and light.
    fn of(mesh: &Adjacency, light: &Light, silhouette: &Silhouette) -> Self {
        let edges = silhouette.edges.iter();
        let ends = edges.map(|edge| edge.vertices.map(|i| mesh.positions()[i as usize].as_dvec3()));
        let local = |position: glam::Vec3| (position.as_dvec3(), None);
        let (origin, direction) = match light {
            Light::Point(light) => local(light.position),
            Light::Spot(light) => local(light.position),
            Light::Directional(light) => {
                let (low, high) = ends
                    .clone()
                    .flatten()
                    .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high): (DVec3, DVec3), end| {
                        (low.min(end), high.max(end))
                    });
                let middle = if low.cmple(high).all() { 0.5 * (low + high) } else { DVec3::ZERO };
                (middle, Some(light.direction.as_dvec3().normalize()))
            }
        };
        let faces = ends.map(|ends| {
            let ends = ends.map(|end| end - origin);
            Face { ends, reach: ends[0].length().max(ends[1].length()) }
        });
        Self { origin, direction, faces: faces.collect() }
    }

    /// Number of side faces.
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// Memory of the faces; units: bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.faces)
    }

    /// Distances along `ray` (in m, within `span`) of the frontmost and the backmost face on it; `None` if it meets none.
    ///
    /// Takes every face in turn. A face that the ray runs within counts with the ends of its edge.
    pub fn faces(&self, ray: &DRay, span: Interval) -> Option<Interval> {
        let plane = RayPlane::new(self, ray);
        let mut hull: Option<Interval> = None;
        let mut keep = |distance: f64| {
            let slack = SLACK * (distance.abs() + plane.rounding);
            // false for NaN too
            if distance >= span.start - slack && distance <= span.end + slack {
                let x = distance.clamp(span.start, span.end.max(span.start));
                let known = hull.unwrap_or(Interval::new(x, x));
                hull = Some(Interval::new(known.start.min(x), known.end.max(x)));
            }
        };
        for face in &self.faces {
            plane.meet(face, &mut keep);
        }
        hull
    }

    /// The part of `ray` within `span` (in m) that may be shadowed: what lies outside is lit. `None` if nothing may.
    ///
    /// The hull of the faces alone would miss two cases. A camera inside a volume meets no face where its ray's shadow
    /// starts: the part starts with `span` where it is dark before the frontmost face. A ray that ends on a surface inside a
    /// volume meets none where its shadow ends: the part ends with `span` where it is dark behind the backmost face. Nothing
    /// changes on either side of the faces, so `visibility` is asked halfway, where rounding is no matter; `light` is the
    /// one whose volume this is. Without faces the span is dark or lit all along.
    pub fn bounds(
        &self,
        ray: &DRay,
        span: Interval,
        light: LightId,
        visibility: &dyn Visibility,
    ) -> Option<Interval> {
        if span.is_empty() {
            return None;
        }
        let plane = RayPlane::new(self, ray);
        let is_dark = |piece: Interval| {
            let halfway = plane.halfway(piece);
            !piece.is_empty() && visibility.visibility(ray.at(halfway).as_vec3(), light) < 1.0
        };
        let Some(faces) = self.faces(ray, span) else {
            return is_dark(span).then_some(span);
        };
        Some(Interval::new(
            if is_dark(Interval::new(span.start, faces.start)) { span.start } else { faces.start },
            if is_dark(Interval::new(faces.end, span.end)) { span.end } else { faces.end },
        ))
    }
}

/// The plane of a view ray and a light: u along the ray, v from the light's side of the ray to the other.
struct RayPlane {
    along: DVec3,
    across: DVec3,
    /// Unit normal.
    normal: DVec3,
    /// What faces' ends are measured from in the plane, relative to the volume's origin; units: m.
    from: DVec3,
    source: Source,
    /// Lengths that take part in a distance along the ray; units: m.
    rounding: f64,
}

/// Where the light is in the plane.
#[derive(Clone, Copy)]
enum Source {
    /// At the origin of u and v; the ray starts at u = `start` and runs along v = `h` > 0; units: m.
    Near { start: f64, h: f64 },
    /// Travels along (`along`, `fall`), a unit vector with `fall` > 0; the ray starts at the origin.
    Far { along: f64, fall: f64 },
}

impl RayPlane {
    fn new(volume: &ShadowVolume, ray: &DRay) -> Self {
        let (along, from_origin) = (ray.direction, ray.origin - volume.origin);
        // what the light passes on its way to the ray
        let way = volume.direction.unwrap_or(from_origin);
        let offset = along.cross(way).cross(along);
        let least = (LEAST_OFFSET * way.length()).max(LEAST_OFFSET);
        let h = offset.length();
        let across = if h < least { along.any_orthonormal_vector() } else { offset / h };
        let h = h.max(least);
        let (from, source) = match volume.direction {
            Some(direction) => (from_origin, Source::Far { along: direction.dot(along), fall: h }),
            None => (DVec3::ZERO, Source::Near { start: from_origin.dot(along), h }),
        };
        let rounding = from_origin.length();
        Self { along, across, normal: along.cross(across), from, source, rounding }
    }

    /// Calls `keep` with the distance along the ray of each point at which it meets the face; distances may lie behind
    /// the ray's origin.
    #[inline]
    fn meet(&self, face: &Face, keep: &mut impl FnMut(f64)) {
        let level = self.from.dot(self.normal);
        let side = face.ends.map(|end| end.dot(self.normal) - level);
        let slack = SLACK * face.reach;
        if (side[0] > slack && side[1] > slack) || (side[0] < -slack && side[1] < -slack) {
            return;
        }
        let [a, b] = face.ends;
        let mut meet_below = |edge: DVec3| {
            if let Some(distance) = self.project(edge - self.from, slack) {
                keep(distance);
            }
        };
        if side[0].abs() <= slack && side[1].abs() <= slack {
            meet_below(a);
            meet_below(b);
        } else {
            // where the edge cuts the plane
            meet_below(a.lerp(b, (side[0] / (side[0] - side[1])).clamp(0.0, 1.0)));
        }
    }

    /// Distance along the ray of the shadow of a point of the plane; `None` if the point is not between light and ray.
    #[inline]
    fn project(&self, point: DVec3, slack: f64) -> Option<f64> {
        let (u, v) = (point.dot(self.along), point.dot(self.across));
        match self.source {
            Source::Near { start, h } => (v > 0.0 && v <= h + slack).then(|| u * (h / v) - start),
            Source::Far { along, fall } => (v <= slack).then(|| u - v * (along / fall)),
        }
    }

    /// A point in the middle of a piece of the ray; of one without end halfway by the angle at a local light, and farther
    /// on by all lengths that take part under a directional one.
    fn halfway(&self, piece: Interval) -> f64 {
        if piece.end.is_finite() {
            return 0.5 * (piece.start + piece.end);
        }
        match self.source {
            Source::Near { start, h } => {
                let angle = 0.5 * (((piece.start + start) / h).atan() + std::f64::consts::FRAC_PI_2);
                (h * angle.tan() - start).max(piece.start)
            }
            Source::Far { .. } => piece.start + piece.start.abs() + self.rounding + 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use scene::{DirectionalLight, PointLight, SpotLight};

    const ALL: Interval = Interval::new(0.0, f64::INFINITY);

    /// The square −1..1 in the plane y = 1.
    fn plate() -> Adjacency {
        let p = |x: f32, z: f32| Vec3::new(x, 1.0, z);
        Adjacency::new([
            [p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0)],
            [p(-1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)],
        ])
        .unwrap()
    }

    fn lamp(at: Vec3) -> Light {
        Light::Point(PointLight::new(at, Vec3::ONE).unwrap())
    }

    fn sun(along: Vec3) -> Light {
        Light::Directional(DirectionalLight::new(along, Vec3::ONE).unwrap())
    }

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> DRay {
        DRay { origin: origin.into(), direction: DVec3::from(direction).normalize() }
    }

    fn assert_near(got: Option<Interval>, start: f64, end: f64) {
        let got = got.unwrap();
        assert!(
            (got.start - start).abs() < 1e-8 && (got.end - end).abs() < 1e-8,
            "{got:?}, not {start} {end}"
        );
    }

    /// Dark below the plate in the light of a lamp at (0, 2, 0).
    struct BelowPlate;

    impl Visibility for BelowPlate {
        fn visibility(&self, p: Vec3, _: LightId) -> f32 {
            let reach = 2.0 - p.y;
            f32::from(p.y > 1.0 || p.x.abs() > reach || p.z.abs() > reach)
        }
    }

    #[test]
    fn a_square_under_a_lamp_by_hand() {
        let volume = ShadowVolume::new(&plate(), &lamp(Vec3::new(0.0, 2.0, 0.0)));
        assert_eq!((volume.face_count(), volume.bytes()), (4, 4 * 56));
        // at y = 0 the shadow is twice as wide as the plate
        let across = ray([-5.0, 0.0, 0.3], [1.0, 0.0, 0.0]);
        assert_near(volume.faces(&across, ALL), 3.0, 7.0);
        assert_near(volume.faces(&across, Interval::new(4.0, 9.0)), 7.0, 7.0);
        assert!(volume.faces(&across, Interval::new(4.0, 6.0)).is_none());
        // above the plate, beside its shadow and away from it there is nothing
        for (origin, direction) in [
            ([-5.0, 1.5, 0.3], [1.0, 0.0, 0.0]),
            ([-5.0, 0.0, 2.1], [1.0, 0.0, 0.0]),
            ([-5.0, 0.0, 0.3], [-1.0, 0.0, 0.0]),
        ] {
            assert!(volume.faces(&ray(origin, direction), ALL).is_none());
        }
        let spot = SpotLight::new(Vec3::new(0.0, 2.0, 0.0), Vec3::X, 0.1, 0.2, Vec3::ONE).unwrap();
        assert_eq!(ShadowVolume::new(&plate(), &Light::Spot(spot)), volume);
    }

    #[test]
    fn a_square_under_the_sun_by_hand() {
        let volume = ShadowVolume::new(&plate(), &sun(Vec3::new(1.0, -1.0, 0.0)));
        let across = ray([-5.0, 0.0, 0.3], [1.0, 0.0, 0.0]);
        assert_near(volume.faces(&across, ALL), 5.0, 7.0);
        assert!(volume.faces(&ray([-5.0, 1.1, 0.3], [1.0, 0.0, 0.0]), ALL).is_none());
        // a ray along the light runs beside the faces or meets them nowhere
        assert!(volume.faces(&ray([0.0, 0.0, 0.3], [1.0, -1.0, 0.0]), ALL).is_none());
    }

    #[test]
    fn a_ray_through_a_vertex_of_the_volume_meets_a_face() {
        for light in
            [lamp(Vec3::new(0.0, 2.0, 0.0)), lamp(Vec3::new(0.1, 2.0, 0.3)), sun(Vec3::new(0.1, -1.0, 0.3))]
        {
            let volume = ShadowVolume::new(&plate(), &light);
            for face in &volume.faces {
                // the shadow of an end, seen from all around
                let way = volume.direction.unwrap_or(face.ends[0]);
                let below = volume.origin + face.ends[0] + 0.7 * way;
                for i in 0..100 {
                    let t = f64::from(i);
                    let direction = DVec3::new(t.sin(), 0.2 * (2.3 * t).cos(), t.cos()).normalize();
                    let found =
                        volume.faces(&DRay { origin: below - 3.0 * direction, direction }, ALL).unwrap();
                    let nearest = (found.start - 3.0).abs().min((found.end - 3.0).abs());
                    assert!(nearest < 1e-6, "{light:?} {i}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn ends_in_shadow_are_what_visibility_says() {
        let volume = ShadowVolume::new(&plate(), &lamp(Vec3::new(0.0, 2.0, 0.0)));
        let bounds =
            |x: f64, span| volume.bounds(&ray([x, 0.0, 0.3], [1.0, 0.0, 0.0]), span, LightId(0), &BelowPlate);
        assert_near(bounds(-5.0, ALL), 3.0, 7.0);
        // from inside, and to an end inside
        assert_near(bounds(-1.0, ALL), 0.0, 3.0);
        assert_near(bounds(-5.0, Interval::new(0.0, 5.0)), 3.0, 5.0);
        assert_near(bounds(-1.0, Interval::new(0.0, 1.0)), 0.0, 1.0);
        assert!(bounds(-5.0, Interval::new(0.0, 2.0)).is_none());
        assert!(bounds(-5.0, Interval::new(4.0, 4.0)).is_none());
        // straight down from inside: dark for ever
        let down = ray([0.1, 0.5, 0.1], [0.0, -1.0, 0.0]);
        assert_eq!(volume.bounds(&down, ALL, LightId(0), &BelowPlate), Some(ALL));
        // and into the volume without leaving it
        let into = ray([-1.4, 0.5, 0.0], [0.5, -1.0, 0.0]);
        let found = volume.bounds(&into, ALL, LightId(0), &BelowPlate).unwrap();
        assert!(found.start < 1.0 && found.end.is_infinite(), "{found:?}");
    }

    #[test]
    fn hard_rays_have_finite_answers() {
        let at = Vec3::new(0.0, 2.0, 0.0);
        for light in [
            lamp(at),
            lamp(Vec3::new(0.0, 1.0, 0.0)),
            lamp(Vec3::new(1.0, 1.0, 1.0)),
            sun(Vec3::NEG_Y),
            sun(Vec3::X),
        ] {
            let volume = ShadowVolume::new(&plate(), &light);
            for origin in
                [[0.0, 2.0, 0.0], [0.0, 5.0, 0.0], [1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [9e5, 0.0, 0.0]]
            {
                for direction in
                    [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, -1.0, 1.0], [-1.0, 0.0, 0.0]]
                {
                    let ray = ray(origin, direction);
                    if let Some(found) = volume.faces(&ray, ALL) {
                        assert!(
                            found.start >= 0.0 && found.end >= found.start,
                            "{light:?} {ray:?}: {found:?}"
                        );
                    }
                    let _ = volume.bounds(&ray, ALL, LightId(0), &BelowPlate);
                }
            }
        }
        assert!(
            ShadowVolume::new(&Adjacency::default(), &sun(Vec3::X))
                .faces(&ray([0.0; 3], [1.0, 0.0, 0.0]), ALL)
                .is_none()
        );
    }
}
